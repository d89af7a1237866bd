"""What stands for the inverse of A in the conjugate gradients for the potential.

fourier   M⁻¹ = (−V∇²)⁻¹, the direct solve
scaled    M⁻¹ = G + diag(A)⁻¹ + C,   G = S⁻¹(−V∇²)⁻¹S⁻¹,   S² = diag(A)/diag(−V∇²)
smoothed  1 − M⁻¹A = p(PA)(1 − GA)p(PA) − CA,   p(λ) = Π(1 − ω_m λ)

S makes the direct solve right in the fluid and in the bodies, where ε is constant, whatever it is.
In the layers between ε varies within a cell or two and, as a tensor, is up to (R+1)²/4R times
larger along them than across: what converges slowly lives there. P is diag(A)⁻¹ on their cells and
zero elsewhere, and p a Chebyshev polynomial, the same before and after, so that M is symmetric; it
is positive definite as |p| < 1. C corrects the constant potentials of highly polarisable bodies.
"""

from typing import Literal

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary, fill_ghosts
from smoothprofile.electric.conductors import Conductors
from smoothprofile.electric.operator import Geometry
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.stencil import LayerStencil
from smoothprofile.grid import Grid
from smoothprofile.solvers.separable import SeparableSolver

Preconditioner = Literal["auto", "fourier", "scaled", "smoothed"]
PRECONDITIONERS = ("auto", "fourier", "scaled", "smoothed")
LOW_CONTRAST, HIGH_CONTRAST = 30.0, 300.0
"""Below the first "auto" takes "fourier", whose iterations √(contrast) bounds for any arrangement;
of a random suspension at R = 10 it takes 22 where "scaled" takes 52. From the second on it takes
"smoothed", a third to half of the iterations of "scaled"; between, few are saved."""
ADDED = 1.0
"""Weight of the diagonal beside the scaled direct solve."""
STEPS, SPREAD = 4, 25.0
"""Degree of p, and largest over smallest eigenvalue between which it is least."""
CONDUCTING = 30.0
"""Permittivity over the fluid's from which on a body's constant potential is corrected."""
STEEP = 5.0
"""Largest over smallest ε about a cell from which on it belongs to a layer."""


class Preconditioning:
    """M⁻¹ on one grid, for the medium prepared last."""

    def __init__(
        self, grid: Grid, boundary: FieldBoundary, geometry: Geometry, chosen: Preconditioner
    ):
        self.grid, self.boundary, self.geometry, self._chosen = grid, boundary, geometry, chosen
        self._direct = SeparableSolver(grid, boundary)
        self._scale = self._extra = self._prepared = None
        self._layer: LayerStencil | None = None
        self._conductors: Conductors | None = None
        self._weights = _chebyshev_weights(_largest_eigenvalue(grid))
        self.kind = "fourier"

    def prepare(self, medium: Permittivity) -> None:
        """Choose a kind for "auto", and bring its scale 1/S and its layers up to date."""
        self.kind = self._chosen
        if self.kind == "auto":
            high = "smoothed" if medium.contrast >= HIGH_CONTRAST else "scaled"
            self.kind = "fourier" if medium.contrast < LOW_CONTRAST else high
        if self.kind == "fourier":
            self._scale = np.ones((1, 1, 1))
            return
        if self._scale is None or self._scale.size == 1:
            self._scale, self._prepared = self.grid.zeros(), None
        if self._prepared == (id(medium), medium.version, self.kind):
            return
        g = self.geometry
        parts = (g.widths, g.distances, g.rates)
        _fill_scale(medium.faces, medium.layers, *medium.runs, *parts, self._scale)
        if self.kind == "smoothed":
            self._extra = self.grid.zeros() if self._extra is None else self._extra
            self._layer = LayerStencil.of(medium, g, STEEP)
        self._conductors = Conductors.of(medium, self.boundary, g, CONDUCTING)
        self._prepared = (id(medium), medium.version, self.kind)

    def __call__(self, residual: np.ndarray, image: np.ndarray) -> None:
        """image ← M⁻¹ residual."""
        if self.kind == "smoothed":
            self._smoothed(residual, image)
        else:
            self._scaled(residual, image, ADDED if self.kind == "scaled" else 0.0)
        if self.kind != "fourier" and self._conductors is not None:
            self._conductors.correct(residual, image)

    def _scaled(self, residual, image, weight) -> None:
        widths, rates = self.geometry.widths, self.geometry.rates
        _before(residual, self._scale, widths, image)
        self._direct.solve(image, 0.0)
        _after(residual, weight, self._scale, widths, rates, image)

    def _smoothed(self, residual, image) -> None:
        extra, layer = self._extra, self._layer
        image[:] = 0.0
        self._relax(residual, image, False)
        # z is zero beyond the layers, and Az beyond the cells around them.
        extra[:] = residual
        fill_ghosts(image, self.boundary)
        layer.residual(residual, image, layer.around, extra)
        _before(extra, self._scale, self.geometry.widths, extra)
        self._direct.solve(extra, 0.0)
        _add_scaled(extra, self._scale, image)
        self._relax(residual, image, True)

    def _relax(self, residual, image, started: bool) -> None:
        """z ← z + ω_m P(r − Az) for each m; z is zero unless started."""
        widths, rates, cells = self.geometry.widths, self.geometry.rates, self._layer.inside
        for weight in self._weights:
            rest = residual
            if started:
                rest = self._extra
                fill_ghosts(image, self.boundary)
                self._layer.residual(residual, image, cells, rest)
            _jacobi(rest, weight, self._scale, *cells[:3], widths, rates, image)
            started = True


def _largest_eigenvalue(grid: Grid) -> float:
    """Bound on the eigenvalues of diag(A)⁻¹A, 8/(1 + (h_min/h_max)²).

    The worst mode alternates along the narrowest cells and is even along the others: 4q²/h² from
    the corners, whose diagonal is ½q²(1/h² + 1/h'²), h' the other width across n. The faces' own
    bound is 2.
    """
    widths = [axis.widths for axis in grid.axes if axis.cells > 1 or not axis.periodic]
    narrow, wide = min(w.min() for w in widths), max(w.max() for w in widths)
    return 8.0 / (1.0 + float(narrow / wide) ** 2)


def _chebyshev_weights(largest: float) -> list[float]:
    """ω_m = 1/(θ + δ cos(π(2m−1)/2n)): p is least on θ ± δ, from largest/SPREAD to largest."""
    middle, half = 0.5 * largest * (1 + 1 / SPREAD), 0.5 * largest * (1 - 1 / SPREAD)
    angles = np.pi * (2 * np.arange(1, STEPS + 1) - 1) / (2 * STEPS)
    return [float(1.0 / (middle + half * np.cos(angle))) for angle in angles]


@njit(inline="always")
def _plain_diagonal(w, rates, i, j, k):
    """Diagonal of −V∇², as if no wall were near."""
    x = (rates[0][i] + rates[0][i + 1]) * w[1][j] * w[2][k]
    y = (rates[1][j] + rates[1][j + 1]) * w[0][i] * w[2][k]
    return x + y + (rates[2][k] + rates[2][k + 1]) * w[0][i] * w[1][j]


@njit(parallel=True, cache=True, error_model="numpy")
def _before(r, scale, w, out):
    """out = S⁻¹r/V."""
    for i in prange(1, r.shape[0] - 1):
        for j in range(1, r.shape[1] - 1):
            u, row = r[i, j], out[i, j]
            s = scale[i, j] if scale.size > 1 else scale[0, 0]
            area, wz, one = w[0][i] * w[1][j], w[2], s.size == 1
            for k in range(1, row.size - 1):
                row[k] = u[k] * (1.0 if one else s[k]) / (area * wz[k])


@njit(parallel=True, cache=True, error_model="numpy")
def _after(r, weight, scale, w, rates, z):
    for i in prange(1, r.shape[0] - 1):
        for j in range(1, r.shape[1] - 1):
            if scale.size == 1:
                continue
            u, s, row = r[i, j], scale[i, j], z[i, j]
            for k in range(1, row.size - 1):
                row[k] = s[k] * (row[k] + weight * s[k] * u[k] / _plain_diagonal(w, rates, i, j, k))


@njit(parallel=True, cache=True, error_model="numpy")
def _jacobi(r, weight, scale, start, low, high, w, rates, z):
    """z ← z + weight·diag(A)⁻¹r on runs of cells."""
    for i in prange(1, r.shape[0] - 1):
        for j in range(1, r.shape[1] - 1):
            u, s, row = r[i, j], scale[i, j], z[i, j]
            for m in range(start[i, j], start[i, j + 1]):
                for k in range(low[m], high[m] + 1):
                    row[k] += weight * s[k] * s[k] * u[k] / _plain_diagonal(w, rates, i, j, k)


@njit(parallel=True, cache=True, error_model="numpy")
def _add_scaled(t, scale, z):
    for i in prange(1, t.shape[0] - 1):
        for j in range(1, t.shape[1] - 1):
            u, s, row = t[i, j], scale[i, j], z[i, j]
            for k in range(1, row.size - 1):
                row[k] += s[k] * u[k]


@njit(parallel=True, cache=True, error_model="numpy")
def _fill_scale(faces, layers, start, low, high, w, d, rates, out):
    """out = 1/√(diag(A)/diag(−V∇²)); the diagonal of A as if no wall were near."""
    ex, ey, ez = faces
    qx, qy, qz = layers
    for i in prange(1, out.shape[0] - 1):
        for j in range(1, out.shape[1] - 1):
            row = out[i, j]
            for k in range(1, row.size - 1):
                x = (ex[i, j, k] / d[0][i] + ex[i + 1, j, k] / d[0][i + 1]) * w[1][j] * w[2][k]
                y = (ey[i, j, k] / d[1][j] + ey[i, j + 1, k] / d[1][j + 1]) * w[0][i] * w[2][k]
                z = (ez[i, j, k] / d[2][k] + ez[i, j, k + 1] / d[2][k + 1]) * w[0][i] * w[1][j]
                row[k] = x + y + z
            for a in range(2):
                for b in range(2):
                    ci, cj = i + a, j + b
                    sx, sy = (0.25 - 0.5 * a) / d[0][ci], (0.25 - 0.5 * b) / d[1][cj]
                    area = d[0][ci] * d[1][cj]
                    for m in range(start[ci, cj], start[ci, cj + 1]):
                        for ck in range(low[m], high[m] + 1):
                            u, v, q = qx[ci, cj, ck], qy[ci, cj, ck], qz[ci, cj, ck]
                            sz, volume = 0.25 / d[2][ck], area * d[2][ck]
                            length = (u * u + v * v + q * q) * (sx * sx + sy * sy + sz * sz)
                            # Cell ck has this corner below it, cell ck − 1 above.
                            if ck <= row.size - 2:
                                row[ck] += volume * (length - (u * sx + v * sy + q * sz) ** 2)
                            if ck >= 2:
                                row[ck - 1] += volume * (length - (u * sx + v * sy - q * sz) ** 2)
            for k in range(1, row.size - 1):
                row[k] = np.sqrt(_plain_diagonal(w, rates, i, j, k) / row[k])
