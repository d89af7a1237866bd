"""Conjugate gradients on flat vectors, within the space that linear constraints leave.

    A x = b + Zλ,   Zᵀx = c:    with P = 1 − Z(ZᵀZ)⁻¹Zᵀ,   z = P M⁻¹ r,   r ← P(r − αAp)

A and M are symmetric and positive definite. A start that obeys Zᵀx = c keeps obeying it.
Gould, Hribar & Nocedal, SIAM J. Sci. Comput. 23 (2001).
"""

import math
from collections.abc import Callable

import numpy as np
from numba import njit, prange

from smoothprofile.solvers.krylov import LIMIT, Progress, SolveReport

CHUNK = 8192
"""Numbers that are summed in one go, whatever the number of threads."""
VANISHING = 1e-100
"""A reference whose residuals have no squares above the smallest number: all is at rest."""


def constrained_conjugate_gradients(
    operator: Callable[[np.ndarray, np.ndarray], None],
    precondition: Callable[[np.ndarray, np.ndarray], None],
    project: Callable[[np.ndarray], None],
    solution: np.ndarray,
    residual: np.ndarray,
    *,
    reference: float,
    tolerance: float,
    limit: int,
) -> SolveReport:
    """From a start whose projected residual P(b − Ax) the caller has put into `residual`.

    operator(p, q) stores q = Ap, precondition(r, z) stores z = M⁻¹r, project(r) does r ← Pr.
    Stops at ‖r‖ ≤ tolerance·reference, and does not begin where reference ≤ `VANISHING`.
    """
    size = norm(residual)
    if reference <= VANISHING:
        return SolveReport(0, size, "converged")
    if size <= tolerance * reference:
        return SolveReport(0, size / reference, "converged")
    direction, image = np.zeros_like(solution), np.empty_like(solution)
    progress, product, status = Progress(size, tolerance * reference), 0.0, ""
    iterations = 0
    while iterations < limit:
        precondition(residual, image)
        project(image)
        before, product = product, dot(residual, image)
        _turn(direction, image, product / before if iterations else 0.0)
        operator(direction, image)
        curvature = dot(direction, image)
        iterations += 1
        # Not above zero: A or M is not positive definite, or a number is not finite.
        if not (curvature > 0.0 and product > 0.0):
            status = "diverged"
            break
        _advance(solution, residual, direction, image, product / curvature)
        project(residual)
        size = norm(residual)
        status = progress.verdict(size)
        if status:
            break
    return SolveReport(iterations, size / reference, status or LIMIT)


def norm(vector: np.ndarray) -> float:
    """‖r‖ = √(r·r)."""
    return math.sqrt(dot(vector, vector))


def dot(first: np.ndarray, second: np.ndarray) -> float:
    """a·b, the same bits for any number of threads."""
    sums = np.zeros(-(-first.size // CHUNK))
    _dot(first, second, sums)
    return float(sums.sum())


@njit(parallel=True, cache=True)
def _dot(a, b, sums):
    for c in prange(sums.size):
        total = 0.0
        for k in range(c * CHUNK, min(a.size, (c + 1) * CHUNK)):
            total += a[k] * b[k]
        sums[c] = total


@njit(parallel=True, cache=True)
def _turn(p, z, beta):
    for k in prange(p.size):
        p[k] = z[k] + beta * p[k]


@njit(parallel=True, cache=True)
def _advance(x, r, p, q, alpha):
    for k in prange(x.size):
        x[k] += alpha * p[k]
        r[k] -= alpha * q[k]
