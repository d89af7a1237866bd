"""Conservative second-order advection on the staggered grid.

    N(u) = ∇·(u u)

Momentum fluxes through the faces of each velocity's own cell; the advecting velocity is the mean
of the mass fluxes through the two half faces, the advected one the plain mean of its two
neighbours, so that momentum telescopes and, without viscosity, kinetic energy is kept by the
spatial operator (Verstappen & Veldman, J. Comput. Phys. 187, 2003).
"""

import numpy as np
from numba import njit, prange

from smoothprofile.grid import Grid


def advection_spacings(grid: Grid) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(3, n+2) per axis: 1/width, 1/distance of centres, and the share of cell i−1 at face i."""
    spacings = []
    for axis in grid.axes:
        widths, distances = axis.padded_widths, axis.padded_distances
        share = np.full_like(widths, 0.5)
        share[1:] = widths[:-1] / (widths[:-1] + widths[1:])
        spacings.append(np.stack([1 / widths, 1 / distances, share]).astype(grid.dtype))
    return tuple(spacings)


def advect(velocity: tuple, out: tuple, spacings: tuple) -> None:
    """Write N(u) of a velocity with filled ghosts to three padded fields."""
    _advect(*velocity, *out, *spacings)


# One row of one component at a time, so that the caller can use N while it is in the cache; from
# one-dimensional rows, which is what the compiler vectorises.


@njit(inline="always")
def advect_x(u, v, w, i, j, sx, sy, sz, out):
    """out[k] = N_x on the interior faces of row (i, j)."""
    gx, a, ry, rz = sx[1, i], sx[2, i], sy[0, j], sz[0]
    b = 1 - a
    u0, ue, uw, un, us = u[i, j], u[i + 1, j], u[i - 1, j], u[i, j + 1], u[i, j - 1]
    v0, vn, vw, vnw = v[i, j], v[i, j + 1], v[i - 1, j], v[i - 1, j + 1]
    w0, ww = w[i, j], w[i - 1, j]
    for k in range(1, u.shape[2] - 1):
        east, west = u0[k] + ue[k], u0[k] + uw[k]
        north, south = a * vnw[k] + b * vn[k], a * vw[k] + b * v0[k]
        top, bottom = a * ww[k + 1] + b * w0[k + 1], a * ww[k] + b * w0[k]
        out[k] = (
            0.25 * gx * (east * east - west * west)
            + 0.5 * ry * (north * (u0[k] + un[k]) - south * (u0[k] + us[k]))
            + 0.5 * rz[k] * (top * (u0[k] + u0[k + 1]) - bottom * (u0[k] + u0[k - 1]))
        )


@njit(inline="always")
def advect_y(u, v, w, i, j, sx, sy, sz, out):
    """out[k] = N_y on the interior faces of row (i, j)."""
    rx, gy, a, rz = sx[0, i], sy[1, j], sy[2, j], sz[0]
    b = 1 - a
    v0, ve, vw, vn, vs = v[i, j], v[i + 1, j], v[i - 1, j], v[i, j + 1], v[i, j - 1]
    u0, us, ue, use = u[i, j], u[i, j - 1], u[i + 1, j], u[i + 1, j - 1]
    w0, ws = w[i, j], w[i, j - 1]
    for k in range(1, u.shape[2] - 1):
        north, south = v0[k] + vn[k], v0[k] + vs[k]
        east, west = a * use[k] + b * ue[k], a * us[k] + b * u0[k]
        top, bottom = a * ws[k + 1] + b * w0[k + 1], a * ws[k] + b * w0[k]
        out[k] = (
            0.25 * gy * (north * north - south * south)
            + 0.5 * rx * (east * (v0[k] + ve[k]) - west * (v0[k] + vw[k]))
            + 0.5 * rz[k] * (top * (v0[k] + v0[k + 1]) - bottom * (v0[k] + v0[k - 1]))
        )


@njit(inline="always")
def advect_z(u, v, w, i, j, sx, sy, sz, out):
    """out[k] = N_z on the interior faces of row (i, j)."""
    rx, ry, gz, a = sx[0, i], sy[0, j], sz[1], sz[2]
    w0, we, ww, wn, ws = w[i, j], w[i + 1, j], w[i - 1, j], w[i, j + 1], w[i, j - 1]
    u0, ue, v0, vn = u[i, j], u[i + 1, j], v[i, j], v[i, j + 1]
    for k in range(1, u.shape[2] - 1):
        top, bottom = w0[k] + w0[k + 1], w0[k] + w0[k - 1]
        east, west = a[k] * ue[k - 1] + (1 - a[k]) * ue[k], a[k] * u0[k - 1] + (1 - a[k]) * u0[k]
        north, south = a[k] * vn[k - 1] + (1 - a[k]) * vn[k], a[k] * v0[k - 1] + (1 - a[k]) * v0[k]
        out[k] = (
            0.25 * gz[k] * (top * top - bottom * bottom)
            + 0.5 * rx * (east * (w0[k] + we[k]) - west * (w0[k] + ww[k]))
            + 0.5 * ry * (north * (w0[k] + wn[k]) - south * (w0[k] + ws[k]))
        )


@njit(parallel=True, cache=True, error_model="numpy", fastmath={"contract"})
def _advect(u, v, w, nu, nv, nw, sx, sy, sz):
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            advect_x(u, v, w, i, j, sx, sy, sz, nu[i, j])
            advect_y(u, v, w, i, j, sx, sy, sz, nv[i, j])
            advect_z(u, v, w, i, j, sx, sy, sz, nw[i, j])
