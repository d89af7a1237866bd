"""The discrete dissipation of a flow of smoothed viscosity, and its gradient.

    Φ/2 = Σ_cells μ_h (e_xx² + e_yy² + e_zz²) + 2 Σ_edges μ_h (e_xy² + e_yz² + e_zx²)
        + Σ_cells (μ_a − μ_h) (|ē|² − 2|P ē n|²),    P = 1 − nnᵀ

per unit volume of a cell; e = E + sym ∇u lies where the staggered grid has its differences, ē in a
cell takes shears from the mean over its four edges. |ē|² − 2|Pēn|² is what is left of |ē|² without
the shear across the layer. Each term is a square: −∇·σ, the derivative of Φ/2, is symmetric and
positive semi-definite for any contrast. Without the third it is the usual staggered stencil.
"""

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import fill_ghosts
from smoothprofile.grid import Grid
from smoothprofile.viscous.direct import Vector
from smoothprofile.viscous.tensor_viscosity import SmoothedViscosity

PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1))
"""The six components of strain and stress, in the order in which they are kept."""


class Stress:
    """σ without pressure of velocities on one grid, with its scratch of twelve fields."""

    def __init__(self, grid: Grid):
        self.grid = grid
        self.rates = tuple(float(1.0 / axis.widths[0]) for axis in grid.axes)
        self._stress = tuple(grid.zeros() for _ in range(6))
        self._layer: tuple[np.ndarray, ...] = ()

    def divergence(
        self, velocity: Vector, medium: SmoothedViscosity, strain: np.ndarray | None, out: Vector
    ) -> None:
        """out = −∇·σ of E + sym ∇u; the ghosts of u must be filled. strain: E (3,3), 0 if None."""
        self.evaluate(velocity, medium, strain)
        _divergence(self._stress, self.rates, out)

    def evaluate(
        self, velocity: Vector, medium: SmoothedViscosity, strain: np.ndarray | None
    ) -> None:
        """Bring σ up to date with a velocity."""
        given = np.zeros((3, 3)) if strain is None else np.asarray(strain, dtype=np.float64)
        applied = np.array([0.5 * (given[a, b] + given[b, a]) for a, b in PAIRS])
        if medium.excess.size:
            self._layer = self._layer or tuple(self.grid.zeros() for _ in range(6))
            for field in self._layer:
                field[:] = 0.0
            layers = (medium.place, medium.excess, medium.normal)
            _layer_stress(*velocity, applied, self.rates, *layers, self._layer)
            for field in self._layer:
                fill_ghosts(field, medium.boundary)
        fields = (medium.cells, medium.edges, self._layer if medium.excess.size else self._stress)
        _stress(*velocity, applied, self.rates, *fields, medium.excess.size > 0, self._stress)

    def mean(self) -> np.ndarray:
        """⟨σ⟩ (3,3), without pressure, of the velocity evaluated last."""
        total = np.zeros((3, 3))
        for (a, b), field in zip(PAIRS, self._stress, strict=True):
            total[a, b] = total[b, a] = field[1:-1, 1:-1, 1:-1].mean()
        return total


@njit(parallel=True, cache=True)
def _layer_stress(u, v, w, applied, rates, place, excess, normal, out):
    """2(μ_a − μ_h)(ē − (ēn nᵀ + n (ēn)ᵀ) + 2(n·ēn) nnᵀ) in the cells of layers."""
    rx, ry, rz = rates
    qx, qy, qz = 0.125 * rx, 0.125 * ry, 0.125 * rz
    for m in prange(excess.size):
        i, j, k = place[m]
        xx = applied[0] + rx * (u[i + 1, j, k] - u[i, j, k])
        yy = applied[1] + ry * (v[i, j + 1, k] - v[i, j, k])
        zz = applied[2] + rz * (w[i, j, k + 1] - w[i, j, k])
        yz = applied[3]
        yz += qz * (v[i, j, k + 1] - v[i, j, k - 1] + v[i, j + 1, k + 1] - v[i, j + 1, k - 1])
        yz += qy * (w[i, j + 1, k] - w[i, j - 1, k] + w[i, j + 1, k + 1] - w[i, j - 1, k + 1])
        zx = applied[4]
        zx += qz * (u[i, j, k + 1] - u[i, j, k - 1] + u[i + 1, j, k + 1] - u[i + 1, j, k - 1])
        zx += qx * (w[i + 1, j, k] - w[i - 1, j, k] + w[i + 1, j, k + 1] - w[i - 1, j, k + 1])
        xy = applied[5]
        xy += qy * (u[i, j + 1, k] - u[i, j - 1, k] + u[i + 1, j + 1, k] - u[i + 1, j - 1, k])
        xy += qx * (v[i + 1, j, k] - v[i - 1, j, k] + v[i + 1, j + 1, k] - v[i - 1, j + 1, k])
        x, y, z = normal[m]
        tx, ty, tz = xx * x + xy * y + zx * z, xy * x + yy * y + yz * z, zx * x + yz * y + zz * z
        along = 2.0 * (tx * x + ty * y + tz * z)
        c = 2.0 * excess[m]
        out[0][i, j, k] = c * (xx - 2.0 * tx * x + along * x * x)
        out[1][i, j, k] = c * (yy - 2.0 * ty * y + along * y * y)
        out[2][i, j, k] = c * (zz - 2.0 * tz * z + along * z * z)
        out[3][i, j, k] = c * (yz - ty * z - tz * y + along * y * z)
        out[4][i, j, k] = c * (zx - tz * x - tx * z + along * z * x)
        out[5][i, j, k] = c * (xy - tx * y - ty * x + along * x * y)


@njit(parallel=True, cache=True)
def _stress(u, v, w, applied, rates, cells, edges, layer, layered, out):
    """σ in cells 0 … n and on edges 1 … n+1 of each axis; a layer's shears are spread to edges."""
    rx, ry, rz = rates
    for i in prange(u.shape[0] - 1):
        for j in range(u.shape[1] - 1):
            for k in range(u.shape[2] - 1):
                twice = 2.0 * cells[i, j, k]
                out[0][i, j, k] = twice * (applied[0] + rx * (u[i + 1, j, k] - u[i, j, k]))
                out[1][i, j, k] = twice * (applied[1] + ry * (v[i, j + 1, k] - v[i, j, k]))
                out[2][i, j, k] = twice * (applied[2] + rz * (w[i, j, k + 1] - w[i, j, k]))
                if layered:
                    for c in range(3):
                        out[c][i, j, k] += layer[c][i, j, k]
    for i in prange(1, u.shape[0]):
        for j in range(1, u.shape[1]):
            for k in range(1, u.shape[2]):
                a, b, c = i - 1, j - 1, k - 1
                yz = rz * (v[i, j, k] - v[i, j, c]) + ry * (w[i, j, k] - w[i, b, k])
                zx = rx * (w[i, j, k] - w[a, j, k]) + rz * (u[i, j, k] - u[i, j, c])
                xy = ry * (u[i, j, k] - u[i, b, k]) + rx * (v[i, j, k] - v[a, j, k])
                yz = edges[0][i, j, k] * (2.0 * applied[3] + yz)
                zx = edges[1][i, j, k] * (2.0 * applied[4] + zx)
                xy = edges[2][i, j, k] * (2.0 * applied[5] + xy)
                if layered:
                    p, q, s = layer[3], layer[4], layer[5]
                    yz += 0.25 * (p[i, j, k] + p[i, j, c] + p[i, b, k] + p[i, b, c])
                    zx += 0.25 * (q[i, j, k] + q[i, j, c] + q[a, j, k] + q[a, j, c])
                    xy += 0.25 * (s[i, j, k] + s[a, j, k] + s[i, b, k] + s[a, b, k])
                out[3][i, j, k], out[4][i, j, k], out[5][i, j, k] = yz, zx, xy


@njit(parallel=True, cache=True)
def _divergence(stress, rates, out):
    """−∇·σ on the faces."""
    xx, yy, zz, yz, zx, xy = stress
    u, v, w = out
    rx, ry, rz = rates
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            for k in range(1, u.shape[2] - 1):
                u[i, j, k] = -(
                    rx * (xx[i, j, k] - xx[i - 1, j, k])
                    + ry * (xy[i, j + 1, k] - xy[i, j, k])
                    + rz * (zx[i, j, k + 1] - zx[i, j, k])
                )
                v[i, j, k] = -(
                    rx * (xy[i + 1, j, k] - xy[i, j, k])
                    + ry * (yy[i, j, k] - yy[i, j - 1, k])
                    + rz * (yz[i, j, k + 1] - yz[i, j, k])
                )
                w[i, j, k] = -(
                    rx * (zx[i + 1, j, k] - zx[i, j, k])
                    + ry * (yz[i, j + 1, k] - yz[i, j, k])
                    + rz * (zz[i, j, k] - zz[i, j, k - 1])
                )
