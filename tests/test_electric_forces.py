"""Forces, torques and dipoles: the derivative of the energy, Maxwell's stress, known bodies."""

import math

import numpy as np
import pytest

from dielectrics import PAIRS, Box, cube
from smoothprofile.electric.stress import Surface, maxwell_loads, sphere_surface
from smoothprofile.rotations import from_axis_angle, multiply
from smoothprofile.shapes import capsule, ellipsoid, sphere

SHAPES = [ellipsoid([1.1, 0.7, 0.6]), capsule(0.5, 0.6), sphere(0.5)]
PLACES = np.array([[1.03, 2.0, 2.1], [3.05, 2.31, 1.93], [2.2, 3.4, 3.3]])
TURNS = np.array(
    [from_axis_angle([1, 2, 3], 0.7), from_axis_angle([0, 1, 1], 0.3), [1.0, 0.0, 0.0, 0.0]]
)


def box_surface(half_sides, points: int = 24) -> Surface:
    """Gauss points on the six sides |x_i| = half_sides[i]."""
    half = np.asarray(half_sides, dtype=np.float64)
    node, weight = np.polynomial.legendre.leggauss(points)
    u, v = np.meshgrid(node, node, indexing="ij")
    areas = np.outer(weight, weight).ravel()
    places, normals, sizes = [], [], []
    for d in range(3):
        a, b = (d + 1) % 3, (d + 2) % 3
        for side in (-1.0, 1.0):
            x, n = np.zeros((areas.size, 3)), np.zeros((areas.size, 3))
            x[:, d], x[:, a], x[:, b] = side * half[d], half[a] * u.ravel(), half[b] * v.ravel()
            n[:, d] = side
            places.append(x)
            normals.append(n)
            sizes.append(areas * half[a] * half[b])
    return Surface(np.concatenate(places), np.concatenate(normals), np.concatenate(sizes))


def three_bodies(smoothing, places=PLACES, turns=TURNS, **options):
    # Layers of 4 cells of a profile that ends: no jump where the paint stops.
    case = cube(20, 4.0, SHAPES, [10.0, 0.2, 5.0], profile="sine", ratio=4.0,
                smoothing=smoothing, tolerance=1e-11, **options)  # fmt: skip
    return case.at(places, (0.3, -0.5, 1.0), turns)


@pytest.mark.parametrize("smoothing", ["tensor", "arithmetic", "harmonic"])
@pytest.mark.parametrize("body", [0, 1])
def test_force_and_torque_are_the_derivatives_of_the_energy(smoothing, body):
    """Neighbours' layers and images overlap here, so that the order of bodies matters too."""
    case, step = three_bodies(smoothing), 1e-5
    loads = case.loads
    for a in range(3):
        moved, turned = [], []
        for side in (step, -step):
            places, turns = PLACES.copy(), TURNS.copy()
            places[body, a] += side
            moved.append(case.at(places, case.field, TURNS).energy)
            turns[body] = multiply(from_axis_angle(np.eye(3)[a], side), TURNS[body])
            turned.append(case.at(PLACES, case.field, turns).energy)
        # Round-off of W ≈ 40 over the step. A longer step meets corners where opposite slopes of
        # overlapping layers cancel and n swings round, and there W bends sharply.
        tolerance = {"rel": 1e-5, "abs": 2e-6}
        force, torque = loads.force[body, a], loads.torque[body, a]
        assert (moved[0] - moved[1]) / (2 * step) == pytest.approx(force, **tolerance)
        assert (turned[0] - turned[1]) / (2 * step) == pytest.approx(torque, **tolerance)


def test_force_between_electrodes_is_the_derivative_of_minus_the_free_energy():
    """Ω = −W at fixed potentials: dielectrics climb to where W is larger."""
    case = Box((24, 16, 16), (3.0, 2.0, 2.0), [sphere(0.5), sphere(0.4)], [8.0, 3.0], electrodes=0,
               walled=(0,), profile="sine", ratio=4.0, tolerance=1e-11)  # fmt: skip
    places, step = np.array([[0.9, 1.0, 1.03], [2.02, 1.2, 0.9]]), 1e-4
    loads = case.at(places, (2.0, 0.0, 0.0)).loads
    energies = [case.at(places + side * np.array([[1, 0, 0], [0, 0, 0]]), case.field).energy
                for side in (step, -step)]  # fmt: skip
    difference = (energies[0] - energies[1]) / (2 * step)
    assert difference == pytest.approx(loads.force[0, 0], rel=2e-4)


def test_dipoles_add_up_to_the_mean_displacement():
    case = three_bodies("tensor")
    mean = case.solver.mean_displacement(case.medium, case.field)
    total = (mean - np.array(case.field)) * case.grid.volume
    # Every point's excess is shared out completely.
    assert case.loads.dipole.sum(axis=0) == pytest.approx(total, rel=1e-10)


def test_no_torque_on_spheres_and_no_net_force():
    loads = three_bodies("tensor").loads
    largest = np.abs(loads.force).max()
    # Steps of the differences of d: 1e-9.
    assert np.abs(loads.torque[2]).max() < 1e-6 * largest
    balanced = loads.balanced((True, True, True))
    assert np.abs(balanced.force.sum(axis=0)).max() < 1e-12 * largest
    walled = loads.balanced((False, True, True))
    assert walled.force[:, 0] == pytest.approx(loads.force[:, 0], rel=1e-14)


@pytest.mark.parametrize("permittivity", [2, 10])
def test_pair_in_a_periodic_cube_coarse(permittivity):
    case = cube(64, 8.0, [sphere(1.0)] * 2, [permittivity] * 2, profile="sine", ratio=2.0,
                tolerance=1e-6)  # fmt: skip
    loads = case.at([[2.5, 4.0, 4.0], [5.5, 4.0, 4.0]]).loads
    # Second order: 1.2 % or less at Δx = a/16, four times that here.
    assert -loads.force[0, 0] == pytest.approx(PAIRS[permittivity, 1.0], rel=0.05)
    assert loads.force[0, 0] == pytest.approx(-loads.force[1, 0], rel=1e-5)
    assert np.abs(loads.force[:, 1:]).max() < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(("permittivity", "gap"), PAIRS)
@pytest.mark.parametrize("shift", [0.0, 0.31])
def test_pair_in_a_periodic_cube(permittivity, gap, shift):
    case = cube(128, 8.0, [sphere(1.0)] * 2, [permittivity] * 2, profile="sine", ratio=2.0,
                tolerance=1e-6)  # fmt: skip
    places = np.array([[3.0 - gap / 2, 4, 4], [5.0 + gap / 2, 4, 4]]) + shift / 16
    loads = case.at(places).loads.balanced((True,) * 3)
    exact = PAIRS[permittivity, gap]
    force = 0.5 * (loads.force[1, 0] - loads.force[0, 0])
    assert force == pytest.approx(exact, rel=0.02)
    # Maxwell's stress, on a sphere around each and on a box, against the derivative of the energy.
    for surface in (sphere_surface(1.22), box_surface([1.22] * 3)):
        pull, _ = maxwell_loads(case.grid, case.faces, 1.0, places[1], surface)
        assert pull[0] == pytest.approx(force, rel=0.01)


@pytest.mark.slow
def test_pair_force_is_of_second_order():
    orders = {}
    for smoothing in ("tensor", "arithmetic"):
        errors = []
        for cells in (32, 64, 128):
            case = cube(cells, 8.0, [sphere(1.0)] * 2, [10.0] * 2, smoothing=smoothing,
                        tolerance=1e-6)  # fmt: skip
            force = case.at([[2.5, 4.0, 4.0], [5.5, 4.0, 4.0]]).loads.force[1, 0]
            errors.append(abs(force / PAIRS[10, 1.0] - 1))
        orders[smoothing] = np.polyfit(np.log([1, 0.5, 0.25]), np.log(errors), 1)[0]
    assert orders["tensor"] >= 1.8
    assert 0.8 < orders["arithmetic"] < 1.5


def tilted_ellipsoid(cells, length, **options):
    shape, turn = ellipsoid([2.0, 1.0, 1.0]), from_axis_angle([0, 0, 1], math.pi / 4)
    case = cube(cells, length, [shape], [10.0], tolerance=1e-6, **options)
    case.at([[length / 2] * 3], quaternions=[turn])
    middle = slice(cells // 2, cells // 2 + 2)
    return np.array([f[middle, middle, middle].mean() for f in case.faces]), case.loads


def exact_ellipsoid():
    """Field inside and torque about z of the 2:1:1 ellipsoid, ε = 10, at 45° to the field."""
    n_a, n_b, excess = 0.1735640, 0.4132180, 9.0
    along, across = np.array([1, 1, 0]) / math.sqrt(2), np.array([-1, 1, 0]) / math.sqrt(2)
    inside = along * along[0] / (1 + n_a * excess) + across * across[0] / (1 + n_b * excess)
    return inside, -6.725427


def test_tilted_ellipsoid_coarse():
    inside, loads = tilted_ellipsoid(64, 12.0, profile="sine", ratio=2.0)
    exact, torque = exact_ellipsoid()
    # 5.3 cells to the short radius, images 12 away.
    assert np.linalg.norm(inside - exact) < 0.05 * np.linalg.norm(exact)
    assert loads.torque[0, 2] == pytest.approx(torque, rel=0.05)
    assert np.abs(loads.force).max() < 1e-3 * abs(torque)


@pytest.mark.slow
def test_tilted_ellipsoid():
    inside, loads = tilted_ellipsoid(144, 12.0)
    exact, torque = exact_ellipsoid()
    # Asked of 12 cells to the short radius.
    assert np.linalg.norm(inside - exact) < 0.03 * np.linalg.norm(exact)
    assert loads.torque[0, 2] == pytest.approx(torque, rel=0.03)


def test_surfaces_are_closed_and_have_their_areas():
    for surface, area in ((sphere_surface(1.3), 4 * math.pi * 1.69), (box_surface([1, 2, 3]), 88)):
        assert surface.areas.sum() == pytest.approx(area, rel=1e-12)
        assert np.abs(surface.normals.T @ surface.areas).max() < 1e-12
        volume = np.einsum("ma,ma,m->", surface.points, surface.normals, surface.areas) / 3
        assert volume == pytest.approx({88: 48}.get(area, 4 / 3 * math.pi * 1.3**3), rel=1e-12)
