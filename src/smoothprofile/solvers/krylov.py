"""Preconditioned conjugate gradients on padded fields.

    α = r·z/p·Ap,  x ← x + αp,  r ← r − αAp,  z = M⁻¹r,  β = (r·z)ₙ₊₁/(r·z)ₙ,  p ← z + βp

A is symmetric, M symmetric and positive definite. A vector is a tuple of padded fields, so that one
solver serves a potential and a velocity alike; only interiors enter the sums. Nothing is allocated
in the loop but one number a plane. Hestenes & Stiefel, J. Res. NBS 49 (1952).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit, prange

Status = Literal["converged", "stagnated", "diverged", "iteration limit"]
Vector = tuple[np.ndarray, ...]

PATIENCE = 200
"""Iterations without a new smallest residual after which a solve counts as stagnated."""
HOPELESS = 1e8
"""Growth of the residual over its smallest value that counts as divergence."""
LIMIT: Status = "iteration limit"


@dataclass(frozen=True)
class SolveReport:
    """How a solve ended: iterations, ‖r‖/‖reference‖ and why it stopped."""

    iterations: int
    residual: float
    status: Status

    @property
    def converged(self) -> bool:
        return self.status == "converged"


class Progress:
    """What the sizes of the residuals say, one iteration after the other."""

    def __init__(self, size: float, goal: float):
        self._best, self._since, self._goal = size, 0, goal

    def verdict(self, size: float) -> str:
        """ "converged", "diverged" or "stagnated"; empty while it may go on."""
        if size <= self._goal:
            return "converged"
        if not size <= HOPELESS * self._best:
            return "diverged"
        self._best, self._since = (size, 0) if size < self._best else (self._best, self._since + 1)
        return "stagnated" if self._since >= PATIENCE else ""


def conjugate_gradients(
    operator: Callable[[Vector, Vector], float],
    precondition: Callable[[Vector, Vector], None],
    solution: Vector,
    residual: Vector,
    direction: Vector,
    image: Vector,
    *,
    reference: float,
    tolerance: float,
    limit: int,
) -> SolveReport:
    """A x = b, from a start whose residual b − Ax the caller has put into `residual`.

    `operator(p, q)` stores q = Ap and returns p·Ap; it may fill the ghosts of p.
    `precondition(r, z)` stores z = M⁻¹r and leaves r.  `direction` and `image` are scratch.
    Stops at ‖r‖ ≤ tolerance·reference; `residual` follows the recurrence, whose drift from
    b − Ax is round-off.
    """
    size = norm(residual)
    if reference == 0.0 or size <= tolerance * reference:
        return SolveReport(0, size / reference if reference else size, "converged")
    progress, product, status = Progress(size, tolerance * reference), 0.0, ""
    iterations = 0
    while iterations < limit:
        precondition(residual, image)
        before, product = product, dot(residual, image)
        _turn(direction, image, product / before if iterations else 0.0)
        curvature = operator(direction, image)
        iterations += 1
        # Not above zero: A or M is not positive definite, or a number is not finite.
        if not (curvature > 0.0 and product > 0.0):
            status = "diverged"
            break
        size = math.sqrt(_advance(solution, residual, direction, image, product / curvature))
        status = progress.verdict(size)
        if status:
            break
    return SolveReport(iterations, size / reference, status or LIMIT)


def norm(vector: Vector) -> float:
    """‖r‖ = √(r·r) over the interior."""
    return math.sqrt(dot(vector, vector))


def dot(first: Vector, second: Vector) -> float:
    """a·b over the interior, the same bits for any number of threads."""
    total = 0.0
    for a, b in zip(first, second, strict=True):
        planes = np.zeros(a.shape[0])
        _dot(a, b, planes)
        total += float(planes.sum())
    return total


def _turn(direction: Vector, image: Vector, beta: float) -> None:
    for p, z in zip(direction, image, strict=True):
        _combine(p, z, beta)


def _advance(
    solution: Vector, residual: Vector, direction: Vector, image: Vector, alpha: float
) -> float:
    total = 0.0
    for x, r, p, q in zip(solution, residual, direction, image, strict=True):
        planes = np.zeros(x.shape[0])
        _step(x, r, p, q, alpha, planes)
        total += float(planes.sum())
    return total


# A row of running sums, one for each column, lets the compiler vectorise a sum without changing
# its order. Planes are summed outside: in a parallel kernel that sum would be split by threads.


@njit(parallel=True, cache=True)
def _dot(a, b, planes):
    for i in prange(1, a.shape[0] - 1):
        sums = np.zeros(a.shape[2])
        for j in range(1, a.shape[1] - 1):
            u, v = a[i, j], b[i, j]
            for k in range(1, a.shape[2] - 1):
                sums[k] += u[k] * v[k]
        planes[i] = sums.sum()


@njit(parallel=True, cache=True)
def _combine(p, z, beta):
    for i in prange(1, p.shape[0] - 1):
        for j in range(1, p.shape[1] - 1):
            u, v = p[i, j], z[i, j]
            if beta == 0.0:
                for k in range(1, p.shape[2] - 1):
                    u[k] = v[k]
            else:
                for k in range(1, p.shape[2] - 1):
                    u[k] = v[k] + beta * u[k]


@njit(parallel=True, cache=True)
def _step(x, r, p, q, alpha, planes):
    for i in prange(1, x.shape[0] - 1):
        sums = np.zeros(x.shape[2])
        for j in range(1, x.shape[1] - 1):
            u, v, s, t = x[i, j], r[i, j], p[i, j], q[i, j]
            for k in range(1, x.shape[2] - 1):
                u[k] += alpha * s[k]
                new = v[k] - alpha * t[k]
                v[k] = new
                sums[k] += new * new
        planes[i] = sums.sum()
