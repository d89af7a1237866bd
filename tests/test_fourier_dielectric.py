"""The thesis' own dielectric solver: derivatives, both methods, closed forms, divergence."""

import math

import numpy as np
import pytest
from scipy.special import i0

from smoothprofile.electric.fourier import FourierSolver, indicator_at_centres
from smoothprofile.electric.spectral import FourierBox
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid, stretched_axis, uniform_axis
from smoothprofile.profiles import PROFILES
from smoothprofile.studies.lattice_curves import FIELD, fourier_solver
from smoothprofile.threads import set_thread_count
from smoothprofile.transforms import to_modes, to_values

X = (1.0, 0.0, 0.0)


def box_grid(cells=(8, 6, 10), lengths=(1.0, 1.5, 2.0)):
    return Grid(
        tuple(uniform_axis(n, 0.0, lengths[d], cells[d], True) for d, n in enumerate("xyz"))
    )


def coordinates(grid):
    return np.meshgrid(*(a.padded_centres[1:-1] for a in grid.axes), indexing="ij")


def layered(cells=64, ratio=10.0, axis=0):
    """ε = exp(c cos 2πx) along one axis, whose means are Bessel functions: c = ½ ln R."""
    shape = [4, 4, 4]
    shape[axis] = cells
    grid = box_grid(tuple(shape), (1.0, 1.0, 1.0))
    c = 0.5 * math.log(ratio)
    return FourierSolver(grid, np.exp(c * np.cos(2 * np.pi * coordinates(grid)[axis]))), c


@pytest.mark.parametrize("cells", [(8, 6, 10), (7, 9, 5), (6, 5, 9)])
def test_derivatives_and_sums(cells):
    grid = box_grid(cells)
    box, (x, y, z) = FourierBox(grid), coordinates(grid)
    k = [2 * np.pi / length for length in grid.lengths]
    f = np.sin(k[0] * x) * np.cos(2 * k[1] * y + 0.3) * np.sin(2 * k[2] * z + 1.0)
    modes, work, found = box.new_modes(), box.new_modes(), box.new_values()
    to_modes(f, modes)
    slopes = (
        k[0] * np.cos(k[0] * x) * np.cos(2 * k[1] * y + 0.3) * np.sin(2 * k[2] * z + 1.0),
        -2 * k[1] * np.sin(k[0] * x) * np.sin(2 * k[1] * y + 0.3) * np.sin(2 * k[2] * z + 1.0),
        2 * k[2] * np.sin(k[0] * x) * np.cos(2 * k[1] * y + 0.3) * np.cos(2 * k[2] * z + 1.0),
    )
    for d in range(3):
        box.derivative(modes, d, work, found)
        # A product of resolved waves is exact to round-off.
        assert np.abs(found - slopes[d]).max() < 1e-13 * 20
    assert box.norm(modes) == pytest.approx(np.sqrt((f**2).sum()), rel=1e-13)
    box.over_square(modes, -1.0, work)
    to_values(work, found)
    square = k[0] ** 2 + 4 * k[1] ** 2 + 4 * k[2] ** 2
    assert np.abs(found + f / square).max() < 1e-15
    other = box.new_modes()
    assert box.distance(modes, other) == pytest.approx(box.norm(modes), rel=1e-14)


def test_the_highest_wave_of_an_even_axis_has_no_slope():
    box = FourierBox(box_grid((8, 6, 10)))
    modes, work, found = box.new_modes(), box.new_modes(), box.new_values()
    for d in range(3):
        sign = (-1.0) ** np.arange(box.shape[d])
        to_modes(np.broadcast_to(np.moveaxis(sign[:, None, None], 0, d), box.shape).copy(), modes)
        box.derivative(modes, d, work, found)
        # Round-off of the transforms.
        assert np.abs(found).max() < 1e-14


@pytest.mark.parametrize("method", ["fixed-point", "conjugate-gradients"])
def test_layers_in_series_and_in_parallel(method):
    """ε_eff of exp(c cos 2πx): 1/I₀(c) across the layers and I₀(c) along them."""
    for axis, exact in ((0, lambda c: 1 / i0(c)), (1, i0)):
        solver, c = layered(axis=axis)
        report = solver.solve(X, method, tolerance=1e-13, limit=200)
        assert report.converged
        # A smooth ε: round-off, and what the tolerance leaves.
        assert solver.mean_displacement(X) == pytest.approx([exact(c), 0.0, 0.0], abs=1e-12)


def test_the_field_between_layers_has_the_right_sign():
    solver, c = layered()
    solver.solve(X, tolerance=1e-13)
    x = (np.arange(64) + 0.5) / 64
    # D is uniform: E = D/ε, strong where ε is small; here −∇ψ = E − E∞.
    exact = np.exp(-c * np.cos(2 * np.pi * x)) / i0(c) - 1.0
    assert np.abs(solver.disturbance(0)[:, 0, 0] - exact).max() < 1e-12
    slope = np.gradient(solver.potential()[:, 0, 0], x)
    # A central difference of the potential, wrong by (2πc/64)²/6 of the largest.
    assert np.abs(slope[1:-1] + exact[1:-1]).max() < 0.02 * np.abs(exact).max()


# ln ε and ε are not cut off alike: the points leave out e^{−π²ξ/2Δx} of the layer's waves.
@pytest.mark.parametrize(("cells", "allowed"), [(32, 4e-4), (64, 1.4e-7)])
def test_both_methods_agree_on_a_sphere(cells, allowed):
    solver = fourier_solver(cells, 4.0, 0.2, 5.0)
    assert solver.solve(X, "fixed-point", 1e-10).converged
    first = solver.potential()
    report = solver.solve(X, "conjugate-gradients", 1e-11)
    assert report.converged and report.iterations > 0
    assert np.abs(solver.potential() - first).max() < allowed


def test_solutions_are_linear_in_the_field_and_turn_with_it():
    solver = fourier_solver(32, 4.0, 0.2, 5.0)
    assert solver.solve(X, tolerance=1e-12).converged
    along_x = solver.potential()
    assert solver.solve((0.0, 0.0, -2.0), tolerance=1e-12).converged
    turned = np.swapaxes(solver.potential(), 0, 2)
    assert np.abs(turned + 2 * along_x).max() < 1e-9


def test_the_thesis_error_is_not_normalised():
    """√Σ(ψⁿ⁺¹−ψⁿ)² grows as N^{3/2}."""
    coarse, fine = (fourier_solver(n, 4.0, 0.2, 2.0) for n in (32, 64))
    for solver in (coarse, fine):
        report = solver.solve(X, "fixed-point", limit=5)
        assert report.status == "iteration limit" and report.iterations == 5
    errors = [s.solve(X, "fixed-point", limit=5).errors for s in (coarse, fine)]
    # ξ = 1.6Δx on the coarser: the fields are the same to 1e-6, relative to the first.
    assert np.array(errors[1]) / 2**1.5 == pytest.approx(errors[0], abs=1e-5 * errors[0][0])


@pytest.mark.parametrize("ratio", [60.0, 100.0, 1000.0, 0.01, 0.001])
def test_divergence_is_named_and_leaves_no_numbers(ratio):
    solver = fourier_solver(32, 4.0, 0.1, ratio)
    report = solver.solve(FIELD, "fixed-point", tolerance=1e-6)
    assert report.status == "diverged" and not report.converged
    assert np.isnan(solver.potential()).all() and np.isnan(solver.mean_displacement(FIELD)).all()
    again = solver.solve(FIELD, "conjugate-gradients", tolerance=1e-8)
    assert again.converged and np.isfinite(solver.potential()).all()


@pytest.mark.parametrize("ratio", [50.0, 0.01])
def test_five_shrinking_steps_are_not_convergence(ratio):
    solver = fourier_solver(32, 4.0, 0.05, ratio)
    report = solver.solve(FIELD, "fixed-point", tolerance=1e-6, limit=5)
    assert report.errors[4] < 0.2 * report.errors[0]
    assert report.status == "iteration limit" and not report.converged


def test_a_slow_oscillation_that_grows_is_divergence():
    """At R = 50 the errors of this grid grow by one per cent a step, and may never be tenfold."""
    solver = fourier_solver(32, 4.0, 0.05, 50.0)
    assert solver.solve(FIELD, "fixed-point", tolerance=1e-6).status == "diverged"


def test_no_progress_at_round_off_is_stagnation():
    solver = fourier_solver(16, 4.0, 0.4, 2.0)
    report = solver.solve(FIELD, "fixed-point", tolerance=1e-30)
    assert report.status == "stagnated"
    assert min(report.errors) < 1e-13 * report.errors[0]


@pytest.mark.parametrize(("ratio", "known"), [(2.0, 14), (10.0, 37)])
def test_iterations_of_conjugate_gradients(ratio, known):
    report = fourier_solver(64, 4.0, 0.05, ratio).solve(FIELD, tolerance=1e-11)
    assert report.converged and report.iterations == known


def test_conjugate_gradients_start_from_the_last_potential():
    solver = fourier_solver(32, 4.0, 0.2, 10.0)
    cold = solver.solve(FIELD, tolerance=1e-8)
    assert solver.solve(FIELD, tolerance=1e-8).iterations == 0
    assert solver.solve((1.01, 0.0, 0.0), tolerance=1e-8).iterations < cold.iterations


def test_any_number_of_threads_solves_the_same_problem():
    found = []
    for threads in (1, 3):
        set_thread_count(threads)
        solver = fourier_solver(18, 4.0, 0.4, 7.0)
        solver.solve(FIELD, tolerance=1e-10)
        found.append(solver.potential())
    # The transforms may take left-over lines singly: round-off.
    assert np.abs(found[0] - found[1]).max() < 1e-13


@pytest.mark.parametrize("method", ["fixed-point", "conjugate-gradients"])
def test_nothing_to_solve_in_a_uniform_medium(method):
    solver = FourierSolver(box_grid(), np.full((8, 6, 10), 3.0))
    report = solver.solve(X, method)
    assert report.converged and report.iterations <= 1
    assert solver.mean_displacement(X) == pytest.approx([3.0, 0.0, 0.0], abs=1e-14)


@pytest.mark.parametrize("name", PROFILES)
def test_the_indicator_is_evaluated_at_the_points(name):
    grid, profile = box_grid(), PROFILES[name]

    def distance(x, y, z):
        return np.sqrt((x - 0.4) ** 2 + (y - 0.7) ** 2 + (z - 1.0) ** 2) - 0.35

    found = indicator_at_centres(grid, distance, profile, 0.3)
    assert np.array_equal(found, profile.value(distance(*coordinates(grid)) / 0.3))
    assert found.min() < 0.1 < 0.7 < found.max()


def test_bad_input_is_refused_in_one_sentence():
    with pytest.raises(CaseError, match="it must be positive"):
        FourierSolver(box_grid(), np.zeros((8, 6, 10)))
    with pytest.raises(CaseError, match=r"electric\.method is 'magic'"):
        FourierSolver(box_grid(), np.ones((8, 6, 10))).solve(X, "magic")
    walled = Grid(tuple(uniform_axis(n, 0.0, 1.0, 4, n != "y") for n in "xyz"))
    with pytest.raises(CaseError, match="y axis is not periodic with equal cells"):
        FourierBox(walled)
    uneven = stretched_axis("z", 0.0, 1.0, 8, True, 0.5, 3.0)
    axes = tuple(uniform_axis(n, 0.0, 1.0, 8, True) for n in "xy")
    with pytest.raises(CaseError, match="z axis is not periodic with equal cells"):
        FourierBox(Grid((*axes, uneven)))
