"""Projection onto divergence-free velocities.

∇²δp = (γ/Δt) ∇·u,   u ← u − (Δt/γ) ∇δp
"""

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.flow.monitor import Extremes
from smoothprofile.grid import Grid
from smoothprofile.solvers.separable import SeparableSolver
from smoothprofile.staggered import divergence, spacings


class Projection:
    """Direct projection on one grid, with a scratch field for δp."""

    def __init__(self, grid: Grid):
        self._boundary = pressure_boundary(grid)
        self._solver = SeparableSolver(grid, self._boundary)
        self._spacings = spacings(grid)
        self.increment = grid.zeros()

    def solve(self, velocity: tuple, rate: float) -> np.ndarray:
        """δp for rate = γ/Δt and a velocity with filled ghosts; its own ghosts are filled too."""
        divergence(*velocity, -rate, self.increment, *self._spacings)
        self._solver.solve(self.increment, 0.0)
        fill_ghosts(self.increment, self._boundary)
        return self.increment

    def correct(
        self, velocity: tuple, rate: float, old: tuple, pressure: np.ndarray | None = None
    ) -> Extremes:
        """u ← u − ∇δp/rate, p ← p + δp with the δp solved last, on the interior.

        Returns the largest values of the new velocity, and of its change from the old one.
        """
        keep = pressure is not None
        target = pressure if keep else self.increment
        planes = np.zeros((velocity[0].shape[0] - 2, 6))
        _correct(*velocity, self.increment, target, keep, 1.0 / rate, *old, *self._spacings, planes)
        if keep:
            fill_ghosts(pressure, self._boundary)
        return Extremes.of(planes)

    def make_divergence_free(self, velocity: tuple) -> None:
        """Project a velocity with filled ghosts; no pressure is involved."""
        self.solve(velocity, 1.0)
        self.correct(velocity, 1.0, velocity)

    def largest_divergence(self, velocity: tuple) -> float:
        """max |∇·u| of a velocity with filled ghosts; overwrites the scratch field."""
        divergence(*velocity, 1.0, self.increment, *self._spacings)
        return float(np.abs(self.increment[1:-1, 1:-1, 1:-1]).max())


@njit(parallel=True, cache=True)
def _correct(u, v, w, dp, p, keep, factor, u_old, v_old, w_old, sx, sy, sz, planes):
    gz = sz[1]
    for i in prange(1, u.shape[0] - 1):
        # One running maximum a column, so that the inner loops vectorise.
        best = np.zeros((6, u.shape[2]), u.dtype)
        for j in range(1, u.shape[1] - 1):
            here, west, south = dp[i, j], dp[i - 1, j], dp[i, j - 1]
            _correct_row(u[i, j], u_old[i, j], here, west, factor * sx[1, i], best[0], best[3])
            _correct_row(v[i, j], v_old[i, j], here, south, factor * sy[1, j], best[1], best[4])
            row, old, speed, change = w[i, j], w_old[i, j], best[2], best[5]
            for k in range(1, u.shape[2] - 1):
                before = old[k]
                new = row[k] - factor * gz[k] * (here[k] - here[k - 1])
                row[k] = new
                a, b = abs(new), abs(new - before)
                speed[k] = a if a > speed[k] else speed[k]
                change[k] = b if b > change[k] else change[k]
            if keep:
                total = p[i, j]
                for k in range(1, u.shape[2] - 1):
                    total[k] += here[k]
        for m in range(6):
            planes[i - 1, m] = best[m].max()
        # A comparison with NaN is false, so it hides from a maximum; one sample a plane finds it,
        # for the direct solves spread it everywhere.
        for m, f in enumerate((u, v, w)):
            sample = f[i, u.shape[1] // 2, u.shape[2] // 2]
            if not np.isfinite(sample):
                planes[i - 1, m] = sample


@njit(inline="always")
def _correct_row(row, old, here, below, factor, speed, change):
    for k in range(1, row.size - 1):
        before = old[k]
        new = row[k] - factor * (here[k] - below[k])
        row[k] = new
        a, b = abs(new), abs(new - before)
        speed[k] = a if a > speed[k] else speed[k]
        change[k] = b if b > change[k] else change[k]
