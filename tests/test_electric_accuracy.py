"""The default medium against independent values: lattices, pairs, spheroids, cylinders, contact."""

import math

import numpy as np
import pytest

from dielectrics import LATTICES, PAIRS, UPRIGHT, lattice_radius
from flows import slope
from smoothprofile.electric.forces import body_loads
from smoothprofile.electric.medium import dielectric_medium
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.electric.stress import field_at, maxwell_loads, sphere_surface
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import bodies_at
from smoothprofile.rotations import from_axis_angle
from smoothprofile.shapes import cylinder, ellipsoid, sphere

ALONG_X = (1.0, 0.0, 0.0)
OFF_CENTRE = [0.503, 0.511, 0.507]


class Solved:
    """Bodies painted as by default and solved; cells and lengths of a periodic box."""

    def __init__(
        self, cells, lengths, shapes, ratios, places, turns=None, tolerance=1e-7, **options
    ):
        axes = zip("xyz", lengths, cells, strict=True)
        self.grid = Grid(tuple(uniform_axis(name, 0.0, a, n, True) for name, a, n in axes))
        self.medium = dielectric_medium(self.grid, shapes, ratios, **options)
        self.solver = PotentialSolver(self.grid)
        self.state = bodies_at(places, turns or [UPRIGHT] * len(places))
        self.medium.paint(self.state, self.solver.scratch)
        self.report = self.solver.solve(self.medium, ALONG_X, tolerance)
        assert self.report.status == "converged"

    @property
    def response(self):
        return 2 * self.solver.energy(self.medium, ALONG_X) / self.grid.volume

    @property
    def loads(self):
        solver = self.solver
        return body_loads(
            self.medium, self.state, solver.potential, ALONG_X, solver.geometry
        ).balanced((True,) * 3)

    def field(self, place):
        return field_at(self.grid, self.solver.field(ALONG_X), np.array([place]))[0]

    def pull(self, body, radius):
        """Maxwell's stress on a sphere around a body, along x."""
        faces, place = self.solver.field(ALONG_X), self.state.position[body]
        return maxwell_loads(self.grid, faces, 1.0, place, sphere_surface(radius))[0][0]


def lattice(cells, fraction, ratio, **options):
    radius = lattice_radius(fraction)
    return Solved((cells,) * 3, (1.0,) * 3, [sphere(radius)], [ratio], [OFF_CENTRE], **options)


def pair(cells, ratio, gap, length=8.0, **options):
    middle, shift = 0.5 * length, 0.31 * length / cells
    places = [[middle + side * (1 + 0.5 * gap) + shift, middle, middle] for side in (-1, 1)]
    shapes = [sphere(1.0)] * 2
    return Solved((cells,) * 3, (length,) * 3, shapes, [ratio] * 2, places, **options)


def attraction(solved):
    """Force on the second of a pair, the mean over both."""
    force = solved.loads.force
    return 0.5 * (force[1, 0] - force[0, 0])


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "fraction"), LATTICES)
# Measured .001 to .07 % and .0003 to .014 %; asked .4 and .1 %.
@pytest.mark.parametrize(("cells", "allowed"), [(64, 1e-3), (128, 3e-4)])
def test_fine_lattices(ratio, fraction, cells, allowed):
    found = lattice(cells, fraction, ratio).response
    assert found == pytest.approx(LATTICES[ratio, fraction], rel=allowed)


@pytest.mark.slow
def test_fine_lattice_of_high_contrast():
    # Measured .18 %, without the retraction .65 %.
    assert lattice(64, 0.3, 100).response == pytest.approx(2.2745674, rel=3e-3)


@pytest.mark.parametrize(
    ("cells", "error"), [(32, 0.03), pytest.param(64, 0.008, marks=pytest.mark.slow)]
)
def test_field_at_the_centre_of_a_sphere(cells, error):
    """Second order: −2.5, −.65 and −.17 % at 32, 64 and 128 cells."""
    case = lattice(cells, 0.2, 10)
    assert case.field(OFF_CENTRE)[0] == pytest.approx(0.2954021, rel=error)


def test_lattice_is_of_second_order_in_the_thickness():
    """ξ ∝ Δx; as painted, the tensor's error falls as ξ² and the arithmetic mean's as ξ."""
    cells, exact = (16, 24, 32, 48), LATTICES[10, 0.2]
    orders = {
        (smoothing, retract): slope(
            1.0 / np.array(cells),
            [
                lattice(n, 0.2, 10, smoothing=smoothing, retract=retract).response / exact - 1
                for n in cells
            ],
        )
        for smoothing, retract in (("tensor", True), ("tensor", False), ("arithmetic", False))
    }
    assert orders["tensor", True] >= 1.8 and orders["tensor", False] >= 1.8
    assert 0.8 < orders["arithmetic", False] < 1.4


@pytest.mark.slow
def test_pair_force_is_of_second_order_in_the_thickness():
    cells, orders = (64, 96, 128), {}
    for smoothing, retract in (("tensor", True), ("tensor", False), ("arithmetic", False)):
        forces = [attraction(pair(n, 10, 1.0, smoothing=smoothing, retract=retract)) for n in cells]
        errors = np.array(forces) / PAIRS[10, 1.0] - 1
        orders[smoothing, retract] = slope(1.0 / np.array(cells), errors)
    assert orders["tensor", True] >= 1.8 and orders["tensor", False] >= 1.8
    assert 0.8 < orders["arithmetic", False] < 1.5


def test_pair_along_the_field_coarse():
    # 1.6 % at a = 8Δx, .36 % at 16.
    assert attraction(pair(64, 10, 1.0)) == pytest.approx(PAIRS[10, 1.0], rel=0.025)


def test_no_force_on_a_row_of_equal_gaps():
    """Centres half a period apart: each pulls from both sides alike."""
    case = pair(32, 10, 2.0, length=8.0)
    # Against the force of a gap of 1; the shift against the grid leaves what `balanced` removes.
    assert abs(attraction(case)) < 1e-6 * abs(PAIRS[10, 1.0])


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "gap"), PAIRS)
def test_pair_along_the_field(ratio, gap):
    case = pair(128, ratio, gap)
    force, exact = attraction(case), PAIRS[ratio, gap]
    # Measured .12 to .86 %; asked 2 %. As painted 1.3 to 2.7 %.
    assert force == pytest.approx(exact, rel=0.012)
    pull = 0.5 * (case.pull(1, 1 + 0.4 * gap) - case.pull(0, 1 + 0.4 * gap))
    assert pull == pytest.approx(force, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(("cells", "allowed"), [(64, 0.015), (128, 0.005)])
def test_force_is_the_slope_of_the_energy(cells, allowed):
    """F = +dW/dx at a fixed mean field; by virtual work, by Maxwell's stress, by differences of W.

    A difference over a whole cell averages the ripple of the grid: .9 and .26 % apart, as Δx².
    """
    step, gap = 8.0 / cells, 1.0
    energies = [
        case.solver.energy(case.medium, ALONG_X)
        for case in (pair(cells, 10, gap + s * step, tolerance=1e-8) for s in (1.0, -1.0))
    ]
    # Each of the two moves by half a cell, so that the gap's slope is the force on the second.
    rise = (energies[0] - energies[1]) / (2 * step)
    case = pair(cells, 10, gap)
    assert rise == pytest.approx(attraction(case), rel=allowed)
    pull = 0.5 * (case.pull(1, 1.4) - case.pull(0, 1.4))
    assert pull == pytest.approx(attraction(case), rel=0.01)


def test_no_net_force_and_no_torque_on_spheres():
    case = pair(32, 10, 0.5)
    loads = case.loads
    largest = np.abs(loads.force).max()
    assert np.abs(loads.force.sum(axis=0)).max() < 1e-6 * largest
    assert np.abs(loads.torque).max() < 1e-6 * largest


def spheroid(cells):
    """Error of the field at the centre of a 2:1:1 spheroid, ε = 10, at 45°, and of its torque."""
    turn = from_axis_angle([0, 0, 1], math.pi / 4)
    shape, places = ellipsoid([2.0, 1.0, 1.0]), [[6.0] * 3]
    case = Solved((cells,) * 3, (12.0,) * 3, [shape], [10.0], places, [turn])
    factor, excess = np.array([0.1735640, 0.4132180]), 9.0
    along, across = np.array([1, 1, 0]) / math.sqrt(2), np.array([-1, 1, 0]) / math.sqrt(2)
    parts = 1 / (1 + factor * excess)
    inside = along * along[0] * parts[0] + across * across[0] * parts[1]
    miss = np.linalg.norm(case.field(places[0]) - inside) / np.linalg.norm(inside)
    return miss, case.loads.torque[0, 2] / -6.725427 - 1


def test_tilted_spheroid_coarse():
    miss, torque = spheroid(72)
    # 6 cells to the short radius: 3.4 and −.1 %; at 4 cells 7.7 and 14 %.
    assert miss < 0.05 and abs(torque) < 0.03


@pytest.mark.slow
def test_tilted_spheroid():
    miss, torque = spheroid(144)
    # Asked 3 % at 12 cells to the short radius; measured .7 and .7 %, of which images 12 away
    # give .3 and .9.
    assert miss < 0.015 and abs(torque) < 0.015


@pytest.mark.parametrize(("fraction", "exact"), [(0.1, 1.1782218), (0.3, 1.6520360)])
def test_square_array_of_cylinders_by_default(fraction, exact):
    radius = math.sqrt(fraction / math.pi)
    case = Solved(
        (48, 48, 3), (1.0, 1.0, 1 / 16), [cylinder(radius, 0.5)], [10.0], [[0.503, 0.511, 0.0]]
    )
    # .007 % at 64 cells, without the retraction .08 %.
    assert case.response == pytest.approx(exact, rel=5e-4)


@pytest.mark.slow
def test_coated_sphere_by_default():
    """Core 10 in a shell of 3 acts as 5.597938; the shell is 3.2 cells thick."""
    dipoles = [
        Solved((64,) * 3, (4.0,) * 3, shapes, ratios, [[2.0] * 3] * len(shapes)).loads.dipole
        for shapes, ratios in (
            ([sphere(1.0), sphere(0.8)], [3.0, 10.0]),
            ([sphere(1.0)], [5.597938]),
        )
    ]
    # Measured −.32 %, −.26 % with the core retracted as in its shell.
    assert dipoles[0].sum(axis=0)[0] == pytest.approx(dipoles[1][0, 0], rel=0.01)


@pytest.mark.parametrize("ratio", [10.0, 1000.0])
@pytest.mark.parametrize("gap", [0.02, 0.0])
def test_touching_spheres_have_finite_forces(ratio, gap):
    case = pair(40, ratio, gap, length=5.0, tolerance=1e-8)
    loads = case.loads
    assert np.all(np.isfinite(loads.force)) and np.all(np.isfinite(loads.torque))
    # They attract along the field.
    assert attraction(case) < 0.0


@pytest.mark.parametrize("ratio", [10.0, 0.001])
def test_spheres_that_reach_their_images(ratio):
    """c = .52 and more: the surface meets that of the next period, and beyond .5236 overlaps it."""
    responses = [lattice(24, fraction, ratio).response for fraction in (0.45, 0.52, 0.56)]
    # ε_eff moves on towards the body's.
    assert np.all(np.diff(responses) * (ratio - 1) > 0)
    assert min(ratio, 1.0) < min(responses) and max(responses) < max(ratio, 1.0)
