"""Projection onto divergence-free velocities.

∇²δp = (γ/Δt) ∇·u,   u ← u − (Δt/γ) ∇δp
"""

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.grid import Grid
from smoothprofile.solvers.separable import SeparableSolver


class Projection:
    """Direct projection on one grid, with a scratch field for δp."""

    def __init__(self, grid: Grid):
        self._boundary = pressure_boundary(grid)
        self._solver = SeparableSolver(grid, self._boundary)
        self._spacings = tuple(
            np.stack([1 / a.padded_widths, 1 / a.padded_distances]).astype(grid.dtype)
            for a in grid.axes
        )
        self.increment = grid.zeros()

    def solve(self, velocity: tuple, rate: float) -> np.ndarray:
        """δp for rate = γ/Δt and a velocity with filled ghosts; its own ghosts are filled too."""
        _divergence(*velocity, -rate, self.increment, *self._spacings)
        self._solver.solve(self.increment, 0.0)
        fill_ghosts(self.increment, self._boundary)
        return self.increment

    def correct(self, velocity: tuple, rate: float) -> None:
        """u ← u − ∇δp/rate with the δp solved last, on interior faces; ghosts are left alone."""
        _subtract_gradient(*velocity, self.increment, 1.0 / rate, *self._spacings)

    def largest_divergence(self, velocity: tuple) -> float:
        """max |∇·u| of a velocity with filled ghosts; overwrites the scratch field."""
        _divergence(*velocity, 1.0, self.increment, *self._spacings)
        return float(np.abs(self.increment[1:-1, 1:-1, 1:-1]).max())


@njit(parallel=True, cache=True)
def _divergence(u, v, w, factor, out, sx, sy, sz):
    rz = sz[0]
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            row, u0, ue, v0, vn, w0 = out[i, j], u[i, j], u[i + 1, j], v[i, j], v[i, j + 1], w[i, j]
            rx, ry = sx[0, i], sy[0, j]
            for k in range(1, u.shape[2] - 1):
                row[k] = factor * (
                    rx * (ue[k] - u0[k]) + ry * (vn[k] - v0[k]) + rz[k] * (w0[k + 1] - w0[k])
                )


@njit(parallel=True, cache=True)
def _subtract_gradient(u, v, w, p, factor, sx, sy, sz):
    gz = sz[1]
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            u0, v0, w0 = u[i, j], v[i, j], w[i, j]
            p0, west, south = p[i, j], p[i - 1, j], p[i, j - 1]
            gx, gy = factor * sx[1, i], factor * sy[1, j]
            for k in range(1, u.shape[2] - 1):
                u0[k] -= gx * (p0[k] - west[k])
                v0[k] -= gy * (p0[k] - south[k])
                w0[k] -= factor * gz[k] * (p0[k] - p0[k - 1])
