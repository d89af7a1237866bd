"""The direct Stokes solve: both equations to round-off, on uniform and stretched boxes."""

import itertools
import math

import numpy as np
import pytest

from smoothprofile.boundaries import fill_ghosts
from smoothprofile.flow.viscosity import Viscosity
from smoothprofile.grid import Grid
from smoothprofile.staggered import volume_mean
from smoothprofile.viscous.direct import DirectStokes
from stokes_scenes import box, wavy

LENGTHS, CELLS, VISCOSITY = (3.0, 2.0, 1.5), (12, 10, 8), 2.0
# Numbers of order one over cells of .2: ∇² of them is of order 100, times round-off.
ROUND_OFF = 1e-12
SIDES = [(True, True, True), (True, False, True), (True, False, False), (False, False, False)]


def solved(grid, mean, resistance, seed=0):
    """The solver, a random force, and the flow, pressure and gradient that it drives."""
    direct = DirectStokes(grid, VISCOSITY)
    rng = np.random.default_rng(seed)
    force = tuple(rng.standard_normal(grid.padded_shape) for _ in range(3))
    velocity, pressure = tuple(grid.zeros() for _ in range(3)), grid.zeros()
    gradient = direct.solve(force, velocity, pressure, mean, resistance)
    return direct, force, velocity, pressure, gradient


def momentum_defect(direct, force, velocity, pressure, gradient, resistance):
    """The largest |σu + ∇p + G − μ∇²u − f|."""
    worst = 0.0
    for c, u in enumerate(velocity):
        laplacian = np.zeros_like(u)
        Viscosity(direct.grid, direct.boundaries[c]).add_explicit(u, VISCOSITY, laplacian)
        slope = np.zeros_like(u)
        p = np.moveaxis(pressure, c, 0)
        distances = direct.grid.axes[c].padded_distances[1:, None, None]
        np.moveaxis(slope, c, 0)[1:] = (p[1:] - p[:-1]) / distances
        defect = resistance * u + slope + gradient[c] - laplacian - force[c]
        worst = max(worst, np.abs(defect[direct.boundaries[c].unknowns(direct.grid)]).max())
    return worst


@pytest.mark.parametrize("periodic", SIDES)
@pytest.mark.parametrize("depth", [0.0, 0.4])
@pytest.mark.parametrize(
    ("mean", "resistance"), [((0.3, 0.2, 0.1), 0.0), ((0.3, 0.2, 0.1), 1.5), (None, 1.5)]
)
def test_both_equations_hold_to_round_off(periodic, depth, mean, resistance):
    plain = box(LENGTHS, CELLS, periodic)
    grid = Grid(tuple(wavy(axis, depth) for axis in plain.axes))
    direct, force, velocity, pressure, gradient = solved(grid, mean, resistance)
    assert direct.largest_divergence(velocity, grid.zeros()) < ROUND_OFF
    arguments = direct, force, velocity, pressure, gradient, resistance
    assert momentum_defect(*arguments) < ROUND_OFF
    # Of the other sign, the pressure gradient would not balance the force.
    assert momentum_defect(direct, force, velocity, -pressure, gradient, resistance) > 0.1
    for c in range(3):
        if mean is not None and periodic[c]:
            assert volume_mean(direct.grid, velocity[c], c) == pytest.approx(mean[c], abs=ROUND_OFF)


def test_the_mean_force_is_what_the_pressure_gradient_balances():
    grid = box(LENGTHS, CELLS)
    direct, force, _, _, gradient = solved(grid, (0.0, 0.0, 0.0), 0.0)
    for c in range(3):
        assert gradient[c] == pytest.approx(volume_mean(direct.grid, force[c], c), abs=ROUND_OFF)


def test_a_wave_across_itself_follows_its_discrete_wave_number():
    grid = box(LENGTHS, CELLS)
    direct = DirectStokes(grid, VISCOSITY)
    k, h = 2.0 * math.pi / LENGTHS[1], LENGTHS[1] / CELLS[1]
    wave = np.sin(k * grid.axes[1].padded_centres)[None, :, None]
    force = tuple(grid.zeros() for _ in range(3))
    force[0][...] = wave
    velocity, pressure = tuple(grid.zeros() for _ in range(3)), grid.zeros()
    direct.solve(force, velocity, pressure)
    expected = wave / (VISCOSITY * (2.0 / h * math.sin(k * h / 2.0)) ** 2)
    assert np.abs(velocity[0] - expected).max() < ROUND_OFF
    assert np.abs(pressure).max() < ROUND_OFF


def test_force_and_velocity_may_be_the_same_fields():
    grid = box(LENGTHS, CELLS, (True, False, True))
    _, _, velocity, _, gradient = solved(grid, (0.0, 0.0, 0.0), 0.0)
    direct = DirectStokes(grid, VISCOSITY)
    rng = np.random.default_rng(0)
    both = tuple(rng.standard_normal(grid.padded_shape) for _ in range(3))
    assert np.array_equal(direct.solve(both, both, grid.zeros()), gradient)
    assert all(np.array_equal(a, b) for a, b in zip(both, velocity, strict=True))


def test_the_solve_is_symmetric():
    """f·𝒮h = h·𝒮f, which conjugate gradients stand on."""
    grid = box(LENGTHS, CELLS, (True, False, True))
    first, second = (solved(grid, (0.0, 0.0, 0.0), 0.0, seed) for seed in (1, 2))
    products = []
    for a, b in itertools.permutations((first, second)):
        parts = zip(a[1], b[2], a[0].boundaries, strict=True)
        products.append(sum((f * u)[x.unknowns(grid)].sum() for f, u, x in parts))
    assert products[0] == pytest.approx(products[1], rel=1e-11)


def test_ghosts_are_filled():
    grid = box(LENGTHS, CELLS, (True, False, True))
    direct, _, velocity, pressure, _ = solved(grid, (0.0, 0.0, 0.0), 0.0)
    for field, boundary in zip(velocity, direct.boundaries, strict=True):
        filled = field.copy()
        fill_ghosts(filled, boundary)
        assert np.array_equal(filled, field)
    filled = pressure.copy()
    fill_ghosts(filled, direct.pressure_boundary)
    assert np.array_equal(filled, pressure)
