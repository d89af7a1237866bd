"""Boxes of dielectric bodies for the tests of electric fields."""

import math

import numpy as np

from smoothprofile.electric.forces import body_loads
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import Forms, bodies_at
from smoothprofile.profiles import profile_named

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
LATTICES = {(2, 0.2): 1.1579717, (2, 0.4): 1.3351368, (10, 0.2): 1.5317239, (10, 0.4): 2.3644314}
"""ε_eff/ε of simple cubic lattices of spheres, by R and volume fraction."""
PAIRS = {(2, 0.5): -0.131808, (2, 1.0): -0.054098, (10, 0.5): -1.567287, (10, 1.0): -0.563357}
"""Force on the farther of two spheres of radius 1 along the field, by R and gap; side 8."""


class Box:
    """Bodies in a box of given cells and lengths; `at` places, paints and solves."""

    def __init__(
        self, cells, lengths, shapes, permittivity, *, profile="tanh", ratio=0.75,
        smoothing="tensor", electrodes=None, walled=(), preconditioner="auto", fluid=1.0,
        tolerance=1e-8,
    ):  # fmt: skip
        self.grid = Grid(
            tuple(
                uniform_axis(name, 0.0, lengths[d], cells[d], d not in walled)
                for d, name in enumerate("xyz")
            )
        )
        forms = Forms.of(shapes, [np.zeros((len(s.parts), 2)) for s in shapes])
        thickness = ratio * lengths[0] / cells[0]
        self.medium = Permittivity(
            self.grid, forms, permittivity, fluid, profile_named(profile), thickness, smoothing
        )
        self.solver = PotentialSolver(self.grid, electrodes, preconditioner)
        self.tolerance = tolerance

    def at(self, positions, field=(1.0, 0.0, 0.0), quaternions=None):
        turned = [UPRIGHT] * len(positions) if quaternions is None else quaternions
        self.field, self.state = field, bodies_at(positions, turned)
        self.medium.paint(self.state, self.solver.scratch)
        self.report = self.solver.solve(self.medium, field, self.tolerance)
        return self

    @property
    def energy(self):
        return self.solver.energy(self.medium, self.field)

    @property
    def loads(self):
        return body_loads(
            self.medium, self.state, self.solver.potential, self.field, self.solver.geometry
        )

    @property
    def faces(self):
        return self.solver.field(self.field)


def cube(cells, length, shapes, permittivity, **options):
    return Box((cells,) * 3, (length,) * 3, shapes, permittivity, **options)


def lattice_radius(fraction):
    """Of a sphere that fills that fraction of a unit cube."""
    return (3 * fraction / (4 * math.pi)) ** (1 / 3)
