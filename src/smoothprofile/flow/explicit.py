"""The explicit side of the predictor, in one pass over memory.

r = (Δt/γ) [ Σα_q uⁿ⁻q/Δt − Σβ_q N(uⁿ⁻q) − ∇pⁿ + g ]
"""

import numpy as np
from numba import njit, prange

from smoothprofile.flow.advection import advect_x, advect_y, advect_z, advection_spacings
from smoothprofile.grid import Grid


class ExplicitTerms:
    """r of the newest time level; older levels are added with `accumulate`."""

    def __init__(self, grid: Grid):
        self.spacings = advection_spacings(grid)
        self._nowhere = np.zeros((0, 0, 0), grid.dtype)

    def newest(
        self,
        velocity: tuple,
        pressure: np.ndarray,
        out: tuple,
        advection: tuple | None,
        past: float,
        advection_weight: float,
        pressure_weight: float,
        drive: tuple[float, float, float],
    ) -> None:
        """out ← past·uⁿ − advection_weight·N(uⁿ) − pressure_weight·∇pⁿ + drive.

        N(uⁿ) is stored in `advection` when given. Fields have filled ghosts.
        """
        keep = advection is not None
        store = advection if keep else (self._nowhere,) * 3
        _explicit(
            *velocity, pressure, *out, *store, keep, *self.spacings,
            past, advection_weight, pressure_weight, *drive,
        )  # fmt: skip


def accumulate(out: np.ndarray, weight: float, field: np.ndarray) -> None:
    """out += weight·field on the interior."""
    if weight:
        _accumulate(out, weight, field)


# fastmath={"contract"} lets a product and a sum be one rounding; it reorders nothing.


@njit(parallel=True, cache=True, error_model="numpy", fastmath={"contract"})
def _explicit(
    u, v, w, p, ru, rv, rw, nu, nv, nw, keep, sx, sy, sz, past, advection, pressure, gx, gy, gz
):
    m = u.shape[2]
    for i in prange(1, u.shape[0] - 1):
        n = np.zeros((3, m), u.dtype)
        for j in range(1, u.shape[1] - 1):
            if advection != 0.0 or keep:
                advect_x(u, v, w, i, j, sx, sy, sz, n[0])
                advect_y(u, v, w, i, j, sx, sy, sz, n[1])
                advect_z(u, v, w, i, j, sx, sy, sz, n[2])
            if keep:
                nu[i, j], nv[i, j], nw[i, j] = n[0], n[1], n[2]
            p0 = p[i, j]
            _row(ru[i, j], u[i, j], n[0], past, advection, gx, pressure * sx[1, i], p0, p[i - 1, j])
            _row(rv[i, j], v[i, j], n[1], past, advection, gy, pressure * sy[1, j], p0, p[i, j - 1])
            out, old, n0, inverse_distance = rw[i, j], w[i, j], n[2], sz[1]
            for k in range(1, m - 1):
                slope = pressure * inverse_distance[k] * (p0[k] - p0[k - 1])
                out[k] = past * old[k] - advection * n0[k] - slope + gz


@njit(inline="always")
def _row(out, old, n, past, advection, drive, factor, here, below):
    for k in range(1, out.size - 1):
        out[k] = past * old[k] - advection * n[k] - factor * (here[k] - below[k]) + drive


@njit(parallel=True, cache=True)
def _accumulate(out, weight, f):
    for i in prange(1, f.shape[0] - 1):
        for j in range(1, f.shape[1] - 1):
            row, f0 = out[i, j], f[i, j]
            for k in range(1, f.shape[2] - 1):
                row[k] += weight * f0[k]
