"""Sums and differences on the staggered grid that every solver of a flow takes.

(∇·u)_ijk = (u_{i+1} − u_i)/Δx + (v_{j+1} − v_j)/Δy + (w_{k+1} − w_k)/Δz,   ⟨u⟩ = ∫u dV/V
"""

import numpy as np
from numba import njit, prange

from smoothprofile.grid import Grid


def spacings(grid: Grid) -> tuple[np.ndarray, ...]:
    """Along each axis (2, n+2): one over the widths of cells, and over the ways between centres."""
    return tuple(
        np.stack([1 / a.padded_widths, 1 / a.padded_distances]).astype(grid.dtype)
        for a in grid.axes
    )


def volume_mean(grid: Grid, field: np.ndarray, component: int) -> float:
    """Mean over the box, by the volumes of the cells around each velocity point."""
    sizes = [
        axis.padded_distances if d == component else axis.padded_widths
        for d, axis in enumerate(grid.axes)
    ]
    return float(_weighted_planes(field, *sizes).sum()) / grid.volume


@njit(parallel=True, cache=True)
def divergence(u, v, w, factor, out, sx, sy, sz):
    """factor ∇·u into the interior of out; sx, sy, sz are the `spacings`."""
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
def _weighted_planes(f, dx, dy, dz):
    sums = np.zeros(f.shape[0])
    for i in prange(1, f.shape[0] - 1):
        for j in range(1, f.shape[1] - 1):
            row = 0.0
            for k in range(1, f.shape[2] - 1):
                row += f[i, j, k] * dz[k]
            sums[i] += row * dx[i] * dy[j]
    return sums
