"""What a step does to the kinetic energy of the fluid, on the staggered grid.

    E = ½ρΣ|u|²δV,   D = μΣ(δū/δx)²δV,   W = μΣ_walls U·(∂ū/∂n)δA,   Σū·b δV,   Σū·∇²b δV

ū is the mean of the velocities before and after the step. Sums run over the cells around each
velocity point, and over the differences between neighbours; a wall is half a cell away from its
nearest layer. W − D is μ∫ū·∇²ū dV as the viscous term has it, exactly.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from smoothprofile.flow.state import Velocity
from smoothprofile.grid import Axis, Grid


@dataclass(frozen=True)
class KineticSums:
    """Of one step, by unit density and viscosity.

    gain         ½Σ(|uⁿ⁺¹|² − |uⁿ|²)δV
    dissipation  Σ(δū/δx)²δV
    walls        Σ_walls U·(∂ū/∂n)δA
    given        Σū·b δV of a force density b; 0 without
    bent         Σū·∇²b δV, b = 0 at walls
    """

    gain: float
    dissipation: float
    walls: float
    given: float
    bent: float


def kinetic_sums(grid: Grid, old: Velocity, new: Velocity, force: Velocity | None) -> KineticSums:
    """Of velocities before and after a step, and a force density or none; all ghosts filled."""
    total = np.zeros(5)
    for c in range(3):
        rows = tuple(_rows(axis, d == c) for d, axis in enumerate(grid.axes))
        given = force[c] if force is not None else new[c]
        planes = np.zeros((grid.shape[0] + 1, 5))
        _sums(old[c], new[c], given, force is not None, *rows, planes)
        total += planes.sum(axis=0)
    return KineticSums(*total.tolist())


def _rows(axis: Axis, staggered: bool) -> np.ndarray:
    """(4, n+2): size of a cell, 1/distance to the point before, size of that difference, wall.

    The last is −1 and 1 at the differences that reach across the low and the high wall, else 0.
    """
    n, walled = axis.cells, not axis.periodic
    rows = np.zeros((4, n + 2))
    if staggered:
        rows[0, 1:-1] = axis.padded_distances[1:-1]
        rows[1, 2:] = 1.0 / axis.widths
        rows[2, 2:] = axis.widths
        return rows
    rows[0, 1:-1] = axis.widths
    rows[1, 1:] = 1.0 / axis.padded_distances[1:]
    rows[2, 1 : n + 1] = axis.padded_distances[1 : n + 1]
    if walled:
        rows[2, 1], rows[2, n + 1] = 0.5 * axis.widths[0], 0.5 * axis.widths[-1]
        rows[3, 1], rows[3, n + 1] = -1.0, 1.0
    return rows


@njit(parallel=True, cache=True)
def _sums(old, new, force, forced, x, y, z, planes):
    for i in prange(1, old.shape[0]):
        gain, loss, walls, given, bent = 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(1, old.shape[1]):
            for k in range(1, old.shape[2]):
                a, b, f = old[i, j, k], new[i, j, k], force[i, j, k]
                here, volume = 0.5 * (a + b), x[0, i] * y[0, j] * z[0, k]
                gain += 0.5 * volume * (b - a) * (b + a)
                for d in range(3):
                    if d == 0:
                        l, m, n, w, p, area = i - 1, j, k, x, i, y[0, j] * z[0, k]
                    elif d == 1:
                        l, m, n, w, p, area = i, j - 1, k, y, j, x[0, i] * z[0, k]
                    else:
                        l, m, n, w, p, area = i, j, k - 1, z, k, x[0, i] * y[0, j]
                    below = 0.5 * (old[l, m, n] + new[l, m, n])
                    slope, wall = w[1, p] * (here - below), 0.5 * w[3, p] * area * (here + below)
                    loss += w[2, p] * area * slope * slope
                    walls += wall * slope
                    if forced:
                        other = w[1, p] * (f - force[l, m, n])
                        bent += wall * other - w[2, p] * area * slope * other
                if forced:
                    given += volume * here * f
        planes[i - 1, 0], planes[i - 1, 1], planes[i - 1, 2] = gain, loss, walls
        planes[i - 1, 3], planes[i - 1, 4] = given, bent
