"""The potential of dielectric bodies in a field, by conjugate gradients.

    ∇·(ε∇ψ) = ∇·(εE₀),   E = E₀ − ∇ψ

E₀ is the mean field of a periodic box, or that of two electrodes, −(V_high − V_low)/L along their
axis, whose disturbance ψ vanishes on them. The other sides are periodic or let no flux through.
"""

import math

import numpy as np

from smoothprofile.boundaries import FieldBoundary, fill_ghosts
from smoothprofile.electric.operator import Geometry, apply, totals
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.preconditioner import (
    PRECONDITIONERS,
    Preconditioner,
    Preconditioning,
)
from smoothprofile.errors import CaseError
from smoothprofile.grid import AXIS_NAMES, Grid
from smoothprofile.solvers.krylov import SolveReport, conjugate_gradients, norm

ROUND_OFF = 1e-12
"""In the sum of a cell's six fluxes, of the largest: 7e-14 was met, left by differences of d."""
FEW = 30
"""Iterations in which round-off cannot part the recurrence's residual from the true one."""
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
                f"preconditioner is {preconditioner!r}; it must be one of "
                f"{', '.join(PRECONDITIONERS)}."
            )
        if grid.dtype != np.float64:
            raise CaseError("the electric field needs a grid of float64 numbers.")
        self.grid, self.electrodes = grid, electrodes
        self.boundary = potential_boundary(grid, electrodes)
        self.geometry = Geometry.of(grid)
        self.potential = grid.zeros()
        self._inverse = Preconditioning(grid, self.boundary, self.geometry, preconditioner)
        self._residual, self._direction, self._image = (grid.zeros() for _ in range(3))

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
        """ψ for E₀ = field, to ‖r‖ ≤ tolerance·‖r of ψ = 0‖.

        The residual reported is the true one; that of the recurrence where it is as good.

        CaseError for a field that is not finite, or along an axis whose walls let no flux through.
        """
        self._check(field)
        self._inverse.prepare(medium)
        self._direction[:] = 0.0
        reference = self._true_residual(medium, field, self._direction)
        if reference <= self._round_off(medium, field) or medium.contrast == 1.0:
            self.potential[:] = 0.0
            return SolveReport(0, 0.0, "converged")
        if not self._true_residual(medium, field, self.potential) <= reference:
            # A start that is worse than none, as where an alternating field passes through zero.
            self.potential[:] = 0.0
            self._true_residual(medium, field, self.potential)

        def operator(direction, image):
            fill_ghosts(direction[0], self.boundary)
            return apply(direction[0], (0.0, 0.0, 0.0), 1.0, medium, self.geometry, image[0])

        report = conjugate_gradients(
            operator,
            lambda residual, image: self._inverse(residual[0], image[0]),
            (self.potential,),
            (self._residual,),
            (self._direction,),
            (self._image,),
            reference=reference,
            tolerance=tolerance,
            limit=limit,
        )
        residual, status = report.residual, report.status
        fill_ghosts(self.potential, self.boundary)
        drift = ROUND_OFF * medium.contrast
        if status != "converged" or report.iterations > FEW or drift > 0.01 * tolerance:
            residual = self._true_residual(medium, field, self.potential) / reference
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
            if not math.isfinite(field[d]):
                raise CaseError(
                    f"the mean field along {axis.name} is {field[d]}; it must be finite."
                )
            if field[d] != 0.0 and not axis.periodic and d != self.electrodes:
                raise CaseError(
                    f"the mean field has a component along {axis.name}, where walls without "
                    "electrodes let no flux through."
                )

    def _round_off(self, medium: Permittivity, field) -> float:
        """‖r‖ of ψ = 0 that round-off leaves where no flux changes along the field."""
        widest = [float(axis.widths.max()) for axis in self.grid.axes]
        flux = max(abs(e) * math.prod(widest) / w for e, w in zip(field, widest, strict=True))
        highest = max([medium.fluid, *medium.permittivity])
        return ROUND_OFF * highest * flux * math.sqrt(self.grid.cell_count)

    def _true_residual(self, medium, field, potential) -> float:
        fill_ghosts(potential, self.boundary)
        apply(potential, field, -1.0, medium, self.geometry, self._residual)
        return norm((self._residual,))
