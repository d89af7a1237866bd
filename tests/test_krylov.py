"""Conjugate gradients: exactness, statuses by name, several fields at once."""

import numpy as np
import pytest

from smoothprofile.solvers.krylov import conjugate_gradients, dot, norm
from smoothprofile.threads import set_thread_count

SHAPE = (4, 5, 3)


def padded(values):
    return np.pad(np.asarray(values, dtype=np.float64).reshape(SHAPE), 1, constant_values=7.0)


def inner(field):
    return field[1:-1, 1:-1, 1:-1].ravel()


def problem(matrices, rng):
    """One block a field: vectors for the solver, its operator and the right-hand sides."""
    sides = [rng.normal(size=m.shape[0]) for m in matrices]

    def operator(direction, image):
        for m, p, q in zip(matrices, direction, image, strict=True):
            q[1:-1, 1:-1, 1:-1] = (m @ inner(p)).reshape(SHAPE)
        return dot(direction, image)

    vectors = [tuple(padded(np.zeros(60)) for _ in matrices) for _ in range(4)]
    for r, b in zip(vectors[1], sides, strict=True):
        r[1:-1, 1:-1, 1:-1] = b.reshape(SHAPE)
    return vectors, operator, sides


def same(residual, image):
    for r, z in zip(residual, image, strict=True):
        z[:] = r


def positive(rng, low, high):
    turn, _ = np.linalg.qr(rng.normal(size=(60, 60)))
    return turn @ np.diag(np.geomspace(low, high, 60)) @ turn.T


def solve(matrices, rng, precondition=same, tolerance=1e-10, limit=400):
    (x, r, p, q), operator, sides = problem(matrices, rng)
    report = conjugate_gradients(
        operator, precondition, x, r, p, q, reference=norm(r), tolerance=tolerance, limit=limit
    )
    return x, report, sides


@pytest.mark.parametrize("blocks", [1, 3])
def test_solves_symmetric_positive_systems(blocks):
    rng = np.random.default_rng(1)
    matrices = [positive(rng, 1.0, 50.0 + b) for b in range(blocks)]
    x, report, sides = solve(matrices, rng)
    assert report.status == "converged" and report.converged
    for m, solution, b in zip(matrices, x, sides, strict=True):
        # Relative residual 1e-10 over a condition number of about 50.
        assert np.linalg.norm(inner(solution) - np.linalg.solve(m, b)) < 1e-8 * np.linalg.norm(b)


def test_exact_preconditioner_needs_one_iteration():
    rng = np.random.default_rng(2)
    m = positive(rng, 1.0, 1e4)
    inverse = np.linalg.inv(m)

    def precondition(residual, image):
        image[0][1:-1, 1:-1, 1:-1] = (inverse @ inner(residual[0])).reshape(SHAPE)

    assert solve([m], rng, precondition)[1].iterations == 1


def test_iterations_follow_the_square_root_of_the_condition_number():
    # Classical bound ½√κ ln(2/tolerance·√κ); a wrong β or α exceeds it at once.
    rng = np.random.default_rng(3)
    iterations = solve([positive(rng, 1.0, 16.0)], rng, tolerance=1e-8)[1].iterations
    assert 10 < iterations <= 0.5 * 4 * np.log(2 * 4 / 1e-8)


def test_iteration_limit_is_named():
    rng = np.random.default_rng(4)
    _, report, _ = solve([positive(rng, 1.0, 1e4)], rng, limit=3)
    assert (report.iterations, report.status) == (3, "iteration limit")
    assert report.residual > 1e-10


@pytest.mark.parametrize("bad", [-1.0, np.nan])
def test_indefinite_or_broken_operator_diverges(bad):
    rng = np.random.default_rng(5)
    _, report, _ = solve([bad * np.eye(60)], rng)
    assert report.status == "diverged"


def test_unreachable_tolerance_stagnates():
    # Below the round-off of a condition number of 1e13 nothing is left to gain.
    rng = np.random.default_rng(6)
    _, report, _ = solve([positive(rng, 1e-13, 1.0)], rng, tolerance=1e-30, limit=5000)
    assert report.status == "stagnated"
    assert report.iterations < 5000


def test_a_start_that_is_good_enough_is_left_alone():
    rng = np.random.default_rng(7)
    (x, r, p, q), operator, _ = problem([np.eye(60)], rng)
    report = conjugate_gradients(
        operator, same, x, r, p, q, reference=1e9 * norm(r), tolerance=1e-6, limit=9
    )
    assert (report.iterations, report.status) == (0, "converged")
    assert not inner(x[0]).any()


def test_sums_have_the_same_bits_for_any_number_of_threads():
    field = np.random.default_rng(8).normal(size=(19, 14, 17))
    sums = set()
    for threads in (1, 2, 4):
        set_thread_count(threads)
        sums.add(dot((field,), (field,)))
    assert len(sums) == 1
