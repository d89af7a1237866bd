"""Viscous term: its implicit solve, its explicit part, and the stress it leaves on the walls.

(1 − c∇²) u = r,   c = θνΔt/γ,   u given on no-slip walls
"""

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.grid import Grid
from smoothprofile.solvers.separable import SeparableSolver


class Viscosity:
    """Implicit and explicit ∇² of one velocity component."""

    def __init__(self, grid: Grid, boundary: FieldBoundary):
        self.grid, self.boundary = grid, boundary
        self._solver = SeparableSolver(grid, boundary)
        self._unknowns = boundary.unknowns(grid)
        self._rows = tuple(
            _second_difference_rows(grid, d, boundary.staggered == d) for d in range(3)
        )

    def solve(self, field: np.ndarray, coefficient: float, wall_values: tuple) -> None:
        """field ← (1 − c∇²)⁻¹ field in place; wall_values[axis][side] on "value" sides."""
        if coefficient == 0.0:
            return
        self._add_wall_values(field, coefficient, wall_values)
        self._solver.solve(field, 1.0 / coefficient, 1.0 / coefficient)

    def add_explicit(self, field: np.ndarray, coefficient: float, out: np.ndarray) -> None:
        """out += c∇²f of a field with filled ghosts."""
        _add_laplacian(field, coefficient, out, *self._rows)

    def _add_wall_values(self, field: np.ndarray, coefficient: float, wall_values: tuple) -> None:
        # The ghost beyond a wall is 2U − f, and the solver has taken care of the −f.
        for d, (low, high) in enumerate(self.boundary.conditions):
            if d == self.boundary.staggered:
                continue
            across = [s for e, s in enumerate(self._unknowns) if e != d]
            f = np.moveaxis(field, d, 0)
            below, _, above = self._rows[d]
            n = self.grid.shape[d]
            if low == "value":
                f[(1, *across)] += field.dtype.type(2 * coefficient * below[1] * wall_values[d][0])
            if high == "value":
                f[(n, *across)] += field.dtype.type(2 * coefficient * above[n] * wall_values[d][1])


def _second_difference_rows(grid: Grid, axis: int, staggered: bool) -> np.ndarray:
    """(3, n+2): weights of f_{i−1}, f_i, f_{i+1} in the second difference at each padded index."""
    widths, distances = grid.axes[axis].padded_widths, grid.axes[axis].padded_distances
    rows = np.zeros((3, widths.size))
    if staggered:
        rows[0, 1:-1] = 1 / (distances[1:-1] * widths[:-2])
        rows[2, 1:-1] = 1 / (distances[1:-1] * widths[1:-1])
    else:
        rows[0, 1:-1] = 1 / (widths[1:-1] * distances[1:-1])
        rows[2, 1:-1] = 1 / (widths[1:-1] * distances[2:])
    rows[1] = -(rows[0] + rows[2])
    return rows.astype(grid.dtype)


@njit(parallel=True, cache=True)
def _add_laplacian(f, c, out, ax, ay, az):
    for i in prange(1, f.shape[0] - 1):
        for j in range(1, f.shape[1] - 1):
            for k in range(1, f.shape[2] - 1):
                out[i, j, k] += c * (
                    ax[0, i] * f[i - 1, j, k]
                    + ax[2, i] * f[i + 1, j, k]
                    + ay[0, j] * f[i, j - 1, k]
                    + ay[2, j] * f[i, j + 1, k]
                    + az[0, k] * f[i, j, k - 1]
                    + az[2, k] * f[i, j, k + 1]
                    + (ax[1, i] + ay[1, j] + az[1, k]) * f[i, j, k]
                )
