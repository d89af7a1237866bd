"""The operator of the potential written out for the cells of the layers, as 27 numbers a cell.

    (Aψ)_c = Σ a_{cc'} ψ_c',   a_{cc'} = −ε_f A_f/d_f + Σ_corners V s_c·K s_c',   s = ±¼(1/d)

over the 26 neighbours c' and c itself, for which the faces' part is +Σ ε_f A_f/d_f. Where it is
acted with many times, numbers at hand cost less than the corners' sums of `operator`. They are of
single precision, enough for what is only a preconditioner.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from smoothprofile.electric.operator import Geometry
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.runs import around, runs_of


@dataclass(frozen=True, eq=False)
class LayerStencil:
    """Coefficients (m,27) of A for the cells of layers and those around them.

    inside, around: runs of the layers' cells, and with all their neighbours; after their start, low
    and high, the row of `coefficients` that a cell of padded index 0 in each run would have.
    """

    coefficients: np.ndarray
    inside: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
    around: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]

    @classmethod
    def of(cls, medium: Permittivity, geometry: Geometry, steep: float) -> "LayerStencil":
        """Layers are where ε about a cell varies by more than the factor `steep`."""
        marks = np.zeros(medium.grid.padded_shape, dtype=np.uint8)
        _mark(medium.faces, medium.layers, steep, marks)
        cells, wider = runs_of(marks), runs_of(around(marks, medium.grid.periodic))
        sizes = wider[2] - wider[1] + 1
        row = np.cumsum(sizes) - sizes - wider[1]
        table = np.zeros((int(sizes.sum()), 27), dtype=np.float32)
        parts = (geometry.widths, geometry.distances, geometry.rates)
        _fill(medium.faces, medium.layers, *wider, row, *parts, table)
        inner = np.zeros_like(cells[1])
        _find(*cells, *wider, row, inner)
        return cls(table, (*cells, inner), (*wider, row))

    def residual(self, right, potential, cells, out) -> None:
        """out = right − Aψ on runs of cells; the ghosts of ψ must be filled."""
        _residual(self.coefficients, *cells, right, potential, out)


@njit(parallel=True, cache=True)
def _residual(table, start, low, high, row, right, psi, out):
    for i in prange(1, out.shape[0] - 1):
        for j in range(1, out.shape[1] - 1):
            if start[i, j] == start[i, j + 1]:
                continue
            u, v = right[i, j], out[i, j]
            for m in range(start[i, j], start[i, j + 1]):
                b, e = low[m], high[m] + 1
                # Slices, indexed from zero: the compiler knows that no index is negative.
                a, r, t = table[row[m] + b : row[m] + e], u[b:e], v[b:e]
                b, e = b - 1, e + 1
                p0, p1, p2 = psi[i - 1, j - 1, b:e], psi[i - 1, j, b:e], psi[i - 1, j + 1, b:e]
                p3, p4, p5 = psi[i, j - 1, b:e], psi[i, j, b:e], psi[i, j + 1, b:e]
                p6, p7, p8 = psi[i + 1, j - 1, b:e], psi[i + 1, j, b:e], psi[i + 1, j + 1, b:e]
                for k in range(r.size):
                    s0 = a[k, 0] * p0[k] + a[k, 1] * p0[k + 1] + a[k, 2] * p0[k + 2]
                    s1 = a[k, 3] * p1[k] + a[k, 4] * p1[k + 1] + a[k, 5] * p1[k + 2]
                    s2 = a[k, 6] * p2[k] + a[k, 7] * p2[k + 1] + a[k, 8] * p2[k + 2]
                    s3 = a[k, 9] * p3[k] + a[k, 10] * p3[k + 1] + a[k, 11] * p3[k + 2]
                    s4 = a[k, 12] * p4[k] + a[k, 13] * p4[k + 1] + a[k, 14] * p4[k + 2]
                    s5 = a[k, 15] * p5[k] + a[k, 16] * p5[k + 1] + a[k, 17] * p5[k + 2]
                    s6 = a[k, 18] * p6[k] + a[k, 19] * p6[k + 1] + a[k, 20] * p6[k + 2]
                    s7 = a[k, 21] * p7[k] + a[k, 22] * p7[k + 1] + a[k, 23] * p7[k + 2]
                    s8 = a[k, 24] * p8[k] + a[k, 25] * p8[k + 1] + a[k, 26] * p8[k + 2]
                    t[k] = r[k] - (s0 + s1 + s2 + s3 + s4 + s5 + s6 + s7 + s8)


@njit(cache=True)
def _find(start, low, high, wider_start, wider_low, wider_high, row, found):
    """The row of each run, which lies within one of the wider runs."""
    for i in range(1, start.shape[0] - 1):
        for j in range(1, start.shape[1] - 2):
            n = wider_start[i, j]
            for m in range(start[i, j], start[i, j + 1]):
                while wider_high[n] < high[m]:
                    n += 1
                found[m] = row[n]


@njit(parallel=True, cache=True, error_model="numpy")
def _fill(faces, layers, start, low, high, row, w, d, rates, table):
    for i in prange(1, start.shape[0] - 1):
        a = np.empty(27)
        for j in range(1, start.shape[1] - 2):
            for m in range(start[i, j], start[i, j + 1]):
                for k in range(low[m], high[m] + 1):
                    a[:] = 0.0
                    _add_faces(i, j, k, faces, w, rates, a)
                    _add_corners(i, j, k, layers, d, a)
                    table[row[m] + k] = a


@njit(inline="always")
def _add_faces(i, j, k, faces, w, rates, a):
    ex, ey, ez = faces
    x, y, z = w[1][j] * w[2][k], w[0][i] * w[2][k], w[0][i] * w[1][j]
    for side in range(2):
        ahead = 2 * side - 1
        for spot, value in (
            (13 + 9 * ahead, x * ex[i + side, j, k] * rates[0][i + side]),
            (13 + 3 * ahead, y * ey[i, j + side, k] * rates[1][j + side]),
            (13 + ahead, z * ez[i, j, k + side] * rates[2][k + side]),
        ):
            a[spot] -= value
            a[13] += value


@njit(inline="always")
def _add_corners(i, j, k, layers, d, a):
    """Corner side (1 above the cell, 0 below) of each axis; cells on its two sides likewise."""
    qx, qy, qz = layers
    for u in range(2):
        for v in range(2):
            for o in range(2):
                at = (i + u, j + v, k + o)
                x, y, z = qx[at], qy[at], qz[at]
                size = x * x + y * y + z * z
                if size == 0.0:
                    continue
                dx, dy, dz = d[0][i + u], d[1][j + v], d[2][k + o]
                # A cell below the corner has s < 0.
                sx, sy, sz = (0.25 - 0.5 * u) / dx, (0.25 - 0.5 * v) / dy, (0.25 - 0.5 * o) / dz
                along, volume = x * sx + y * sy + z * sz, 0.25 * dx * dy * dz
                fx = volume * (size * sx - along * x) / dx
                fy = volume * (size * sy - along * y) / dy
                fz = volume * (size * sz - along * z) / dz
                for p in range(2):
                    for q in range(2):
                        for r in range(2):
                            spot = 9 * (u + p) + 3 * (v + q) + o + r
                            a[spot] += (2 * p - 1) * fx + (2 * q - 1) * fy + (2 * r - 1) * fz


@njit(parallel=True, cache=True)
def _mark(faces, layers, steep, marks):
    """Cells about which ε, of the faces and with the mean |q|² of the corners, is not constant."""
    ex, ey, ez = faces
    qx, qy, qz = layers
    for i in prange(1, marks.shape[0] - 1):
        for j in range(1, marks.shape[1] - 1):
            for k in range(1, marks.shape[2] - 1):
                x0, x1, y0, y1 = ex[i, j, k], ex[i + 1, j, k], ey[i, j, k], ey[i, j + 1, k]
                z0, z1, excess = ez[i, j, k], ez[i, j, k + 1], 0.0
                for a in range(i, i + 2):
                    for b in range(j, j + 2):
                        for c in range(k, k + 2):
                            u, v, q = qx[a, b, c], qy[a, b, c], qz[a, b, c]
                            excess += 0.125 * (u * u + v * v + q * q)
                highest = max(max(max(x0, x1), max(y0, y1)), max(z0, z1)) + excess
                lowest = min(min(min(x0, x1), min(y0, y1)), min(z0, z1))
                marks[i, j, k] = highest > steep * lowest
