"""The discrete energy of a field in a smoothed dielectric, and its gradient.

    W = ½ Σ_faces ε_f E_f² V_f + ½ Σ_corners Ē·K Ē V_c,   E = E₀ − ∇ψ,   K = |q|² 1 − q qᵀ

ψ lies at cell centres, E_f on the faces, Ē at the cell corners: the mean over the four faces of
each direction that meet there. With ε_f = ε_h (harmonic) and q = √(ε_a − ε_h) n this is the tensor
ε_h nnᵀ + ε_a (1 − nnᵀ). Each term is a square, so the operator Aψ = −V∇·(ε∇ψ), the exact second
derivative of W, is positive definite for any contrast. Without q it is the seven-point stencil.
"""

from dataclasses import dataclass

import numpy as np
from numba import get_thread_id, njit, prange

from smoothprofile.grid import Grid
from smoothprofile.threads import available_threads

CHUNK = 8
"""Planes that one task works through, so that corner fluxes are computed once but for its first."""


@dataclass(frozen=True, eq=False)
class Geometry:
    """Per axis, padded: cell widths w, distances d of centres, rates 1/d, and shares.

    share is d with half of it at walls, and zero at the face that a periodic axis counts twice.
    flux is scratch, one part for each thread: two planes of corner fluxes.
    """

    widths: tuple[np.ndarray, np.ndarray, np.ndarray]
    distances: tuple[np.ndarray, np.ndarray, np.ndarray]
    share: tuple[np.ndarray, np.ndarray, np.ndarray]
    rates: tuple[np.ndarray, np.ndarray, np.ndarray]
    flux: np.ndarray

    @classmethod
    def of(cls, grid: Grid) -> "Geometry":
        share = []
        for axis in grid.axes:
            part = axis.padded_distances.copy()
            if axis.periodic:
                part[-1] = 0.0
            else:
                part[1], part[-1] = 0.5 * part[1], 0.5 * part[-1]
            share.append(part)
        return cls(
            tuple(a.padded_widths.copy() for a in grid.axes),
            tuple(a.padded_distances.copy() for a in grid.axes),
            tuple(share),
            tuple(1.0 / a.padded_distances for a in grid.axes),
            np.zeros((available_threads(), 2, 3, grid.shape[1] + 2, grid.shape[2] + 3)),
        )


def apply(potential, field, sign, medium, geometry: Geometry, out) -> float:
    """out = Gᵀ V ε (E₀ + sign·Gψ), G the discrete gradient; returns ψ·out.

    With E₀ = 0 and sign 1, out = Aψ; with sign −1, out = −∂W/∂ψ, the residual. The ghosts of ψ
    must be filled. `medium` has faces (3 fields), layers (3 fields) and runs.
    """
    planes = np.zeros(out.shape[0])
    _apply(
        potential,
        np.asarray(field, dtype=np.float64),
        medium.faces,
        medium.layers,
        *medium.runs,
        geometry.widths,
        geometry.distances,
        tuple(float(sign) * rate for rate in geometry.rates),
        geometry.flux,
        out,
        planes,
    )
    return float(planes.sum())


@njit(parallel=True, cache=True, error_model="numpy")
def _apply(psi, e0, faces, layers, start, low, high, w, d, rates, buffers, out, planes):
    nx, ny, nz = psi.shape[0] - 2, psi.shape[1] - 2, psi.shape[2] - 2
    for g in prange((nx + CHUNK - 1) // CHUNK):
        flux = buffers[get_thread_id()]
        sums = np.zeros(nz + 2)
        first = 1 + g * CHUNK
        last = min(first + CHUNK, nx + 1)
        _corner_plane(first, psi, e0, layers, start, low, high, d, rates, flux[first % 2])
        for i in range(first, last):
            following = flux[(i + 1) % 2]
            _corner_plane(i + 1, psi, e0, layers, start, low, high, d, rates, following)
            sums[:] = 0.0
            for j in range(1, ny + 1):
                row = out[i, j]
                _face_row(i, j, psi, e0, faces, w, rates, row)
                for a in range(2):
                    for b in range(2):
                        _corner_row(
                            i + a, j + b, 1 - 2 * a, 1 - 2 * b, start, low, high,
                            flux[(i + a) % 2], row,
                        )  # fmt: skip
                here = psi[i, j]
                for k in range(1, nz + 1):
                    sums[k] += here[k] * row[k]
            planes[i] = sums.sum()


@njit(inline="always")
def _face_row(i, j, psi, e0, faces, w, rates, row):
    ex, ey, ez = faces
    here, west, east = psi[i, j], psi[i - 1, j], psi[i + 1, j]
    south, north = psi[i, j - 1], psi[i, j + 1]
    x0, x1, y0, y1, z0 = ex[i, j], ex[i + 1, j], ey[i, j], ey[i, j + 1], ez[i, j]
    wx, wy, wz, rz = w[0][i], w[1][j], w[2], rates[2]
    rx0, rx1, ry0, ry1 = rates[0][i], rates[0][i + 1], rates[1][j], rates[1][j + 1]
    fx, fy, fz = e0[0], e0[1], e0[2]
    area = wx * wy
    for k in range(1, row.size - 1):
        c = here[k]
        along_x = x0[k] * (fx + rx0 * (c - west[k])) - x1[k] * (fx + rx1 * (east[k] - c))
        along_y = y0[k] * (fy + ry0 * (c - south[k])) - y1[k] * (fy + ry1 * (north[k] - c))
        along_z = z0[k] * (fz + rz[k] * (c - here[k - 1]))
        along_z -= z0[k + 1] * (fz + rz[k + 1] * (here[k + 1] - c))
        row[k] = wz[k] * (wy * along_x + wx * along_y) + area * along_z


@njit(inline="always")
def _corner_plane(i, psi, e0, layers, start, low, high, d, rates, flux):
    """¼ of the corner fluxes Y = KĒ times the areas they cross, on the runs of one plane."""
    qx, qy, qz = layers
    ny = psi.shape[1] - 2
    fx, fy, fz = flux[0], flux[1], flux[2]
    dz, rz = d[2], rates[2]
    for j in range(1, ny + 2):
        begin, end = start[i, j], start[i, j + 1]
        if begin == end:
            continue
        p0, p1, p2, p3 = psi[i - 1, j - 1], psi[i - 1, j], psi[i, j - 1], psi[i, j]
        ux, uy, uz = qx[i, j], qy[i, j], qz[i, j]
        yx, yy, yz = fx[j], fy[j], fz[j]
        dx, dy = d[0][i], d[1][j]
        rx, ry = 0.25 * rates[0][i], 0.25 * rates[1][j]
        for m in range(begin, end):
            a, b = low[m], high[m] + 1
            yx[a - 1], yy[a - 1], yz[a - 1] = 0.0, 0.0, 0.0
            yx[b], yy[b], yz[b] = 0.0, 0.0, 0.0
            # Slices, indexed from zero: the compiler vectorises loops over those.
            h0, h1, h2, h3 = p0[a:b], p1[a:b], p2[a:b], p3[a:b]
            l0, l1, l2, l3 = p0[a - 1 : b], p1[a - 1 : b], p2[a - 1 : b], p3[a - 1 : b]
            vx, vy, vz, tx, ty, tz = ux[a:b], uy[a:b], uz[a:b], yx[a:b], yy[a:b], yz[a:b]
            step, rate = dz[a:b], rz[a:b]
            for k in range(b - a):
                s0, s1, s2, s3 = h0[k] + l0[k], h1[k] + l1[k], h2[k] + l2[k], h3[k] + l3[k]
                rise = h0[k] - l0[k] + h1[k] - l1[k] + h2[k] - l2[k] + h3[k] - l3[k]
                gx = e0[0] + rx * (s2 + s3 - s0 - s1)
                gy = e0[1] + ry * (s1 + s3 - s0 - s2)
                gz = e0[2] + 0.25 * rate[k] * rise
                u, v, q = vx[k], vy[k], vz[k]
                size, along = u * u + v * v + q * q, u * gx + v * gy + q * gz
                tx[k] = 0.25 * dy * step[k] * (size * gx - along * u)
                ty[k] = 0.25 * dx * step[k] * (size * gy - along * v)
                tz[k] = 0.25 * dx * dy * (size * gz - along * q)


@njit(inline="always")
def _corner_row(i, j, sx, sy, start, low, high, flux, row):
    """What the corners of one row give to a row of cells beside it."""
    fx, fy, fz = flux[0, j], flux[1, j], flux[2, j]
    for m in range(start[i, j], start[i, j + 1]):
        a, b = max(1, low[m] - 1), min(row.size - 2, high[m]) + 1
        part, x, y, z = row[a:b], fx[a : b + 1], fy[a : b + 1], fz[a : b + 1]
        for k in range(b - a):
            part[k] += sx * (x[k] + x[k + 1]) + sy * (y[k] + y[k + 1]) + z[k] - z[k + 1]


def totals(potential, field, medium, geometry: Geometry) -> tuple[float, np.ndarray]:
    """W and ∫D dV (3,) of E = E₀ − ∇ψ; the ghosts of ψ must be filled."""
    planes = np.zeros((potential.shape[0], 4))
    e0 = np.asarray(field, dtype=np.float64)
    parts = (geometry.widths, geometry.distances, geometry.share)
    _totals(potential, e0, medium.faces, medium.layers, *parts, planes)
    sums = planes.sum(axis=0)
    return float(sums[0]), sums[1:]


@njit(inline="always")
def corner_field(psi, e0, d, i, j, k):
    """Ē = E₀ − ∇ψ at a corner, from the eight cells around it."""
    a, b = psi[i - 1, j - 1, k - 1], psi[i - 1, j - 1, k]
    c, e = psi[i - 1, j, k - 1], psi[i - 1, j, k]
    f, g = psi[i, j - 1, k - 1], psi[i, j - 1, k]
    h, m = psi[i, j, k - 1], psi[i, j, k]
    x = e0[0] - 0.25 * (f + g + h + m - a - b - c - e) / d[0][i]
    y = e0[1] - 0.25 * (c + e + h + m - a - b - f - g) / d[1][j]
    z = e0[2] - 0.25 * (b + e + g + m - a - c - f - h) / d[2][k]
    return x, y, z


@njit(parallel=True, cache=True)
def _totals(psi, e0, faces, layers, w, d, share, planes):
    ex, ey, ez = faces
    qx, qy, qz = layers
    for i in prange(1, psi.shape[0]):
        energy, mx, my, mz = 0.0, 0.0, 0.0, 0.0
        inner_i = i < psi.shape[0] - 1
        for j in range(1, psi.shape[1]):
            inner_j = j < psi.shape[1] - 1
            for k in range(1, psi.shape[2]):
                inner_k = k < psi.shape[2] - 1
                if inner_j and inner_k:
                    field = e0[0] - (psi[i, j, k] - psi[i - 1, j, k]) / d[0][i]
                    part = ex[i, j, k] * field * share[0][i] * w[1][j] * w[2][k]
                    energy, mx = energy + part * field, mx + part
                if inner_i and inner_k:
                    field = e0[1] - (psi[i, j, k] - psi[i, j - 1, k]) / d[1][j]
                    part = ey[i, j, k] * field * w[0][i] * share[1][j] * w[2][k]
                    energy, my = energy + part * field, my + part
                if inner_i and inner_j:
                    field = e0[2] - (psi[i, j, k] - psi[i, j, k - 1]) / d[2][k]
                    part = ez[i, j, k] * field * w[0][i] * w[1][j] * share[2][k]
                    energy, mz = energy + part * field, mz + part
                u, v, q = qx[i, j, k], qy[i, j, k], qz[i, j, k]
                size = u * u + v * v + q * q
                if size > 0.0:
                    x, y, z = corner_field(psi, e0, d, i, j, k)
                    along = u * x + v * y + q * z
                    volume = share[0][i] * share[1][j] * share[2][k]
                    x1, y1 = volume * (size * x - along * u), volume * (size * y - along * v)
                    z1 = volume * (size * z - along * q)
                    energy += x * x1 + y * y1 + z * z1
                    mx, my, mz = mx + x1, my + y1, mz + z1
        planes[i, 0], planes[i, 1], planes[i, 2], planes[i, 3] = 0.5 * energy, mx, my, mz
