"""The potential of dielectric bodies in a field, by conjugate gradients.

    ∇·(ε∇ψ) = ∇·(εE₀),   E = E₀ − ∇ψ

E₀ is the mean field of a periodic box, or that of two electrodes, −(V_high − V_low)/L along their
axis, whose disturbance ψ vanishes on them. The other sides are periodic or let no flux through.
"""

from typing import Literal

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary, fill_ghosts
from smoothprofile.electric.operator import Geometry, apply, totals
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.errors import CaseError
from smoothprofile.grid import AXIS_NAMES, Grid
from smoothprofile.solvers.krylov import SolveReport, conjugate_gradients, norm
from smoothprofile.solvers.separable import SeparableSolver

Preconditioner = Literal["auto", "fourier", "scaled", "smoothed"]
PRECONDITIONERS = ("auto", "fourier", "scaled", "smoothed")
HIGH_CONTRAST = 30.0
"""From here on "auto" takes "smoothed", whose fewer iterations pay for their greater cost."""
ADDED, DAMPED = 1.0, 0.45
"""Weights of the diagonal: beside the direct solve, and as a smoother before and after it.

The corners' part of A reaches up to four times its diagonal, so that the smoother, and with it the
preconditioner, is positive definite for weights up to a half; near there it was found the best.
"""
DRIFT = 10.0
"""Times the tolerance that the true residual may be left at by round-off in its recurrence."""


def potential_boundary(grid: Grid, electrodes: int | None = None) -> FieldBoundary:
    """Of ψ: zero on the walls of axis number `electrodes`, no flux through other walls."""
    if electrodes is not None and grid.axes[electrodes].periodic:
        raise CaseError(
            f"the electrodes stand on the {AXIS_NAMES[electrodes]} axis, which is periodic; "
            "electrodes need an axis with walls."
        )
    return FieldBoundary(
        tuple(
            ("periodic",) * 2 if axis.periodic else ("value" if d == electrodes else "flux",) * 2
            for d, axis in enumerate(grid.axes)
        )
    )


def electrode_field(grid: Grid, axis: int, low: float, high: float) -> tuple[float, float, float]:
    """E₀ = −(V_high − V_low)/L along `axis`, between electrodes at those potentials."""
    field = [0.0, 0.0, 0.0]
    field[axis] = -(high - low) / grid.axes[axis].length
    return tuple(field)


class PotentialSolver:
    """Solves for ψ on one grid; `potential` is kept as the start of the next solve."""

    def __init__(
        self, grid: Grid, electrodes: int | None = None, preconditioner: Preconditioner = "auto"
    ):
        if preconditioner not in PRECONDITIONERS:
            raise CaseError(
                f"electric.preconditioner is {preconditioner!r}; it must be one of "
                f"{', '.join(PRECONDITIONERS)}."
            )
        if grid.dtype != np.float64:
            raise CaseError("the electric field needs a grid of float64 numbers.")
        self.grid, self.electrodes, self._chosen = grid, electrodes, preconditioner
        self.boundary = potential_boundary(grid, electrodes)
        self.geometry = Geometry.of(grid)
        self.potential = grid.zeros()
        self._direct = SeparableSolver(grid, self.boundary)
        self._residual, self._direction, self._image = (grid.zeros() for _ in range(3))
        self._scale = self._extra = None
        self._prepared = None

    @property
    def scratch(self) -> tuple[np.ndarray, np.ndarray]:
        """Two padded fields that are free between solves."""
        return self._residual, self._direction

    def solve(
        self,
        medium: Permittivity,
        field: tuple[float, float, float],
        tolerance: float = 1e-6,
        limit: int = 1000,
    ) -> SolveReport:
        """ψ for E₀ = field, to ‖r‖ ≤ tolerance·‖r of ψ = 0‖; the residual reported is the true one.

        CaseError for a field along an axis whose walls let no flux through.
        """
        self._check(field)
        kind = self._prepare(medium)
        self._direction[:] = 0.0
        reference = self._true_residual(medium, field, self._direction)
        if reference == 0.0:
            self.potential[:] = 0.0
            return SolveReport(0, 0.0, "converged")
        self._true_residual(medium, field, self.potential)
        nothing = (0.0, 0.0, 0.0)

        def operator(direction, image):
            fill_ghosts(direction[0], self.boundary)
            return apply(direction[0], nothing, 1.0, medium, self.geometry, image[0])

        def precondition(residual, image):
            if kind == "smoothed":
                self._smoothed(operator, residual[0], image[0])
            else:
                self._scaled(residual[0], image[0], ADDED if kind == "scaled" else 0.0)

        report = conjugate_gradients(
            operator,
            precondition,
            (self.potential,),
            (self._residual,),
            (self._direction,),
            (self._image,),
            reference=reference,
            tolerance=tolerance,
            limit=limit,
        )
        residual = self._true_residual(medium, field, self.potential) / reference
        status = report.status
        if status == "converged" and residual > DRIFT * tolerance:
            status = "stagnated"
        return SolveReport(report.iterations, residual, status)

    def energy(self, medium: Permittivity, field) -> float:
        """W = ½∫E·εE dV of the field solved last."""
        return totals(self.potential, field, medium, self.geometry)[0]

    def mean_displacement(self, medium: Permittivity, field) -> np.ndarray:
        """⟨D⟩ = ∫εE dV/V, (3,), of the field solved last."""
        return totals(self.potential, field, medium, self.geometry)[1] / self.grid.volume

    def field(self, field) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """E = E₀ − ∇ψ on the faces, as padded fields whose outermost layer is not set."""
        psi = self.potential
        result = tuple(np.zeros_like(psi) for _ in range(3))
        for d in range(3):
            ahead, behind = [slice(None)] * 3, [slice(None)] * 3
            ahead[d], behind[d] = slice(1, None), slice(None, -1)
            shape = [1, 1, 1]
            shape[d] = -1
            step = self.geometry.distances[d][1:].reshape(shape)
            result[d][tuple(ahead)] = field[d] - (psi[tuple(ahead)] - psi[tuple(behind)]) / step
        return result

    def _check(self, field) -> None:
        for d, axis in enumerate(self.grid.axes):
            if field[d] != 0.0 and not axis.periodic and d != self.electrodes:
                raise CaseError(
                    f"the mean field has a component along {axis.name}, where walls without "
                    "electrodes let no flux through."
                )

    def _true_residual(self, medium, field, potential) -> float:
        fill_ghosts(potential, self.boundary)
        apply(potential, field, -1.0, medium, self.geometry, self._residual)
        return norm((self._residual,))

    def _prepare(self, medium: Permittivity) -> str:
        """The preconditioner's name, its scale 1/√(diagonal of A over that of −V∇²) ready."""
        kind = self._chosen
        if kind == "auto":
            kind = "smoothed" if medium.contrast >= HIGH_CONTRAST else "scaled"
        if kind == "fourier":
            self._scale = np.ones((1, 1, 1))
            return kind
        if self._scale is None or self._scale.size == 1:
            self._scale, self._prepared = self.grid.zeros(), None
        if kind == "smoothed" and self._extra is None:
            self._extra = self.grid.zeros()
        if self._prepared != (id(medium), medium.version):
            g = self.geometry
            parts = (g.widths, g.distances, g.rates)
            _fill_scale(medium.faces, medium.layers, *medium.runs, *parts, self._scale)
            self._prepared = (id(medium), medium.version)
        return kind

    def _scaled(self, residual, image, weight) -> None:
        """z = S⁻¹(−V∇²)⁻¹S⁻¹r + weight·diag(A)⁻¹r, S² = diag(A)/diag(−V∇²)."""
        widths, rates = self.geometry.widths, self.geometry.rates
        _before(residual, residual, 0.0, self._scale, widths, image)
        self._direct.solve(image, 0.0)
        _after(residual, weight, self._scale, widths, rates, image)

    def _smoothed(self, operator, residual, image) -> None:
        """One damped Jacobi step, the scaled direct solve of what is left, one Jacobi step."""
        widths, rates = self.geometry.widths, self.geometry.rates
        extra = self._extra
        image[:] = 0.0
        _jacobi(residual, image, False, DAMPED, self._scale, widths, rates, image)
        operator((image,), (extra,))
        _before(residual, extra, 1.0, self._scale, widths, extra)
        self._direct.solve(extra, 0.0)
        _add_scaled(extra, self._scale, image)
        operator((image,), (extra,))
        _jacobi(residual, extra, True, DAMPED, self._scale, widths, rates, image)


@njit(inline="always")
def _at(scale, i, j, k):
    return scale[i, j, k] if scale.size > 1 else 1.0


@njit(inline="always")
def _plain_diagonal(w, rates, i, j, k):
    """Diagonal of −V∇², as if no wall were near."""
    x = (rates[0][i] + rates[0][i + 1]) * w[1][j] * w[2][k]
    y = (rates[1][j] + rates[1][j + 1]) * w[0][i] * w[2][k]
    return x + y + (rates[2][k] + rates[2][k + 1]) * w[0][i] * w[1][j]


@njit(parallel=True, cache=True, error_model="numpy")
def _before(r, image, share, scale, w, out):
    """out = S⁻¹(r − share·image)/V."""
    for i in prange(1, r.shape[0] - 1):
        for j in range(1, r.shape[1] - 1):
            u, v, row = r[i, j], image[i, j], out[i, j]
            s = scale[i, j] if scale.size > 1 else scale[0, 0]
            area, wz, one = w[0][i] * w[1][j], w[2], s.size == 1
            for k in range(1, row.size - 1):
                row[k] = (u[k] - share * v[k]) * (1.0 if one else s[k]) / (area * wz[k])


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
def _jacobi(r, image, started, weight, scale, w, rates, z):
    """z ← z + weight·diag(A)⁻¹(r − image), from z = 0 unless started."""
    for i in prange(1, r.shape[0] - 1):
        for j in range(1, r.shape[1] - 1):
            u, v, s, row = r[i, j], image[i, j], scale[i, j], z[i, j]
            for k in range(1, row.size - 1):
                factor = weight * s[k] * s[k] / _plain_diagonal(w, rates, i, j, k)
                row[k] = row[k] + factor * (u[k] - v[k]) if started else factor * u[k]


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
