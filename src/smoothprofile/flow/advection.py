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


class Advection:
    """N(u) on one grid."""

    def __init__(self, grid: Grid):
        # widths w, distances d between centres, and the share that cell i−1 has at face i.
        spacings = []
        for axis in grid.axes:
            widths, distances = axis.padded_widths, axis.padded_distances
            share = np.full_like(widths, 0.5)
            share[1:] = widths[:-1] / (widths[:-1] + widths[1:])
            spacings.append(np.stack([1 / widths, 1 / distances, share]).astype(grid.dtype))
        self._spacings = tuple(spacings)

    def __call__(self, velocity: tuple, out: tuple) -> None:
        """Write N(u) of a velocity with filled ghosts to three padded fields."""
        _advect(*velocity, *out, *self._spacings)


@njit(parallel=True, cache=True, error_model="numpy")
def _advect(u, v, w, nu, nv, nw, sx, sy, sz):
    # One inner loop a component and one-dimensional rows: that is what the compiler vectorises.
    rz, gz, az = sz[0], sz[1], sz[2]
    for i in prange(1, u.shape[0] - 1):
        rx, gx, ax = sx[0, i], sx[1, i], sx[2, i]
        bx = 1 - ax
        for j in range(1, u.shape[1] - 1):
            ry, gy, ay = sy[0, j], sy[1, j], sy[2, j]
            by = 1 - ay
            u0, ue, uw, un, us = u[i, j], u[i + 1, j], u[i - 1, j], u[i, j + 1], u[i, j - 1]
            v0, ve, vw, vn, vs = v[i, j], v[i + 1, j], v[i - 1, j], v[i, j + 1], v[i, j - 1]
            w0, we, ww, wn, ws = w[i, j], w[i + 1, j], w[i - 1, j], w[i, j + 1], w[i, j - 1]
            vnw, use = v[i - 1, j + 1], u[i + 1, j - 1]
            out = nu[i, j]
            for k in range(1, u.shape[2] - 1):
                east, west = u0[k] + ue[k], u0[k] + uw[k]
                north = ax * vnw[k] + bx * vn[k]
                south = ax * vw[k] + bx * v0[k]
                top = ax * ww[k + 1] + bx * w0[k + 1]
                bottom = ax * ww[k] + bx * w0[k]
                out[k] = (
                    0.25 * gx * (east * east - west * west)
                    + 0.5 * ry * (north * (u0[k] + un[k]) - south * (u0[k] + us[k]))
                    + 0.5 * rz[k] * (top * (u0[k] + u0[k + 1]) - bottom * (u0[k] + u0[k - 1]))
                )
            out = nv[i, j]
            for k in range(1, u.shape[2] - 1):
                north, south = v0[k] + vn[k], v0[k] + vs[k]
                east = ay * use[k] + by * ue[k]
                west = ay * us[k] + by * u0[k]
                top = ay * ws[k + 1] + by * w0[k + 1]
                bottom = ay * ws[k] + by * w0[k]
                out[k] = (
                    0.25 * gy * (north * north - south * south)
                    + 0.5 * rx * (east * (v0[k] + ve[k]) - west * (v0[k] + vw[k]))
                    + 0.5 * rz[k] * (top * (v0[k] + v0[k + 1]) - bottom * (v0[k] + v0[k - 1]))
                )
            out = nw[i, j]
            for k in range(1, u.shape[2] - 1):
                top, bottom = w0[k] + w0[k + 1], w0[k] + w0[k - 1]
                east = az[k] * ue[k - 1] + (1 - az[k]) * ue[k]
                west = az[k] * u0[k - 1] + (1 - az[k]) * u0[k]
                north = az[k] * vn[k - 1] + (1 - az[k]) * vn[k]
                south = az[k] * v0[k - 1] + (1 - az[k]) * v0[k]
                out[k] = (
                    0.25 * gz[k] * (top * top - bottom * bottom)
                    + 0.5 * rx * (east * (w0[k] + we[k]) - west * (w0[k] + ww[k]))
                    + 0.5 * ry * (north * (w0[k] + wn[k]) - south * (w0[k] + ws[k]))
                )
