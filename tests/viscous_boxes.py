"""Periodic boxes of bodies of smoothed viscosity for the tests."""

import math

import numpy as np

from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import bodies_at
from smoothprofile.viscous.smoothed_viscosity import SmoothedStokes
from smoothprofile.viscous.smoothed_viscosity_medium import viscous_medium


class Drops:
    """Bodies of one viscosity ratio in a periodic box, painted."""

    def __init__(self, cells, lengths, shapes, positions, ratio, thickness, **options):
        names = "xyz"
        self.grid = Grid(
            tuple(uniform_axis(names[d], 0.0, lengths[d], cells[d], True) for d in range(3))
        )
        quaternions = options.pop("quaternions", [(1.0, 0.0, 0.0, 0.0)] * len(positions))
        self.state = bodies_at(positions, quaternions)
        self.medium = viscous_medium(
            self.grid, shapes, [ratio] * len(shapes), 1.0, thickness=thickness, **options
        )
        self.medium.paint(self.state)
        self.solver = SmoothedStokes(self.grid)


def lattice(shape, fraction, cells, ratio, thickness, **options):
    """One body of radius 1 in the cube that it fills to that fraction, between grid points."""
    side = (4 * math.pi / (3 * fraction)) ** (1 / 3)
    centre = [0.5 * side + 0.25 * side / cells] * 3
    return Drops((cells,) * 3, (side,) * 3, [shape], [centre], ratio, thickness, **options)


def shear(pair):
    """E of unit rate, "xy" for E_xy = ½, "xx" for E_xx = −E_yy = 1, and so on."""
    a, b = ("xyz".index(letter) for letter in pair)
    strain = np.zeros((3, 3))
    if a == b:
        strain[a, a], strain[(a + 1) % 3, (a + 1) % 3] = 1.0, -1.0
    else:
        strain[a, b] = strain[b, a] = 0.5
    return strain
