"""Steady creeping flow of a fluid whose smoothed viscosity makes its bodies stiff.

    ∇·σ − ∇p + f = ⟨f⟩,   σ = 2μe,   e = E + sym ∇u,   ∇·u = 0,   ⟨u⟩ = 0

in a periodic box: option 2 of the thesis (3.6–3.7) in three dimensions. A body of μ_s/μ_f = R is a
drop whose surface carries no stress of its own, and rigid as R → ∞. By conjugate gradients on
divergence-free fields; with 𝒫 the projection onto them,

    Au = −𝒫∇·σ(u),   M⁻¹ = 𝒫 μ^{−1/2} (−∇²)⁻¹ μ^{−1/2} 𝒫

M is A where μ is uniform, whatever it is, so that only layers cost iterations: of a sphere with
R = 10, 10³, 10⁴ and harmonic smoothing, ξ = .14a, 8, 24, 31 to 1e-4, with (−μ_f∇²)⁻¹ alone 18,
193, 587; of the tensor's, whose layers are up to (R+1)²/4R stiffer along than across, 9, 76, 284.
An iteration takes five separable solves: three for M, and one in each of two projections. Bodies
beside each other take more: two at a gap of a, ξ = .125a, R = 10³, 90 to 1e-3; correcting the rigid
motions of each as well would save a tenth of them.
"""

import numpy as np

from smoothprofile.boundaries import fill_ghosts
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.solvers.krylov import SolveReport, conjugate_gradients, dot, norm
from smoothprofile.viscous.direct import Vector
from smoothprofile.viscous.smoothed_viscosity_projection import Projection
from smoothprofile.viscous.tensor_viscosity import SmoothedViscosity
from smoothprofile.viscous.tensor_viscosity_stress import Stress

ROUND_OFF = 1e-13
"""Of forces and of stresses over a cell: a residual of u = 0 below it is none."""
DRIFT = 10.0
"""Times the tolerance that the true residual may be left at by round-off in its recurrence."""
STIFF = 0.25
"""Exponent of μ_a/μ_h in the scale of a layer's cells: of 0, 1/4, 1/2 and 1 this takes fewest
iterations, from R = 100 to 10⁴."""


class SmoothedStokes:
    """Solves for u on one grid; `velocity` is kept as the start of the next solve.

    pressure: of zero mean, without the mean gradient; mean_gradient (3,): ⟨f⟩, which balances f.
    """

    def __init__(self, grid: Grid):
        if grid.dtype != np.float64:
            raise CaseError("smoothed viscosity needs a grid of float64 numbers.")
        self.grid = grid
        self.velocity, self._residual, self._direction, self._image = (
            tuple(grid.zeros() for _ in range(3)) for _ in range(4)
        )
        self.stress, self._project = Stress(grid), Projection(grid)
        self._scale: tuple[np.ndarray, ...] = ()
        self.mean_gradient = np.zeros(3)

    @property
    def pressure(self) -> np.ndarray:
        return self._project.pressure

    def solve(
        self,
        medium: SmoothedViscosity,
        force: Vector | None = None,
        strain: np.ndarray | None = None,
        tolerance: float = 1e-4,
        limit: int = 5000,
    ) -> SolveReport:
        """u for a force density f on the faces (padded) and a mean strain E (3,3), to
        ‖r‖ ≤ tolerance·‖r of u = 0‖; the residual reported is the true one.

        The dissipation, and with it mobilities and viscosities, err by less than the tolerance.
        CaseError for a strain with a trace, or a force or strain that is not finite.
        """
        _check(force, strain)
        self._scale = _scales(medium)
        for component in self._direction:
            component[:] = 0.0
        reference = self._true_residual(medium, force, strain, self._direction)
        if reference <= self._round_off(medium, force, strain):
            reference = 0.0
        if not self._true_residual(medium, force, strain, self.velocity) <= reference:
            # A start that is worse than none.
            for component in self.velocity:
                component[:] = 0.0
            self._true_residual(medium, force, strain, self.velocity)
        report = conjugate_gradients(
            lambda direction, image: self._operator(medium, direction, image),
            self._precondition,
            self.velocity,
            self._residual,
            self._direction,
            self._image,
            reference=reference,
            tolerance=tolerance,
            limit=limit,
        )
        # Last, for it leaves the pressure and the stress of the solution.
        left = self._true_residual(medium, force, strain, self.velocity)
        self.mean_gradient = self._project.mean.copy()
        residual = left / reference if reference else 0.0
        status = report.status
        if status == "converged" and residual > DRIFT * tolerance:
            status = "stagnated"
        return SolveReport(report.iterations, residual, status)

    def _operator(self, medium: SmoothedViscosity, direction: Vector, image: Vector) -> float:
        for component in direction:
            fill_ghosts(component, medium.boundary)
        self.stress.divergence(direction, medium, None, image)
        self._project(image)
        return dot(direction, image)

    def _precondition(self, residual: Vector, image: Vector) -> None:
        for r, z, scale in zip(residual, image, self._scale, strict=True):
            np.multiply(r, scale, out=z)
            self._project.poisson.solve(z, 0.0)
            z *= scale
        self._project(image)

    def _round_off(self, medium, force, strain) -> float:
        """‖r‖ that round-off leaves where u = 0 is the solution, as with layers along a strain."""
        size = 0.0 if force is None else max(float(np.abs(f).max()) for f in force)
        if strain is not None:
            stiffest = max([medium.fluid, *medium.viscosity])
            size += stiffest * float(np.abs(strain).max()) * max(self.stress.rates)
        return ROUND_OFF * size * np.sqrt(3.0 * self.grid.cell_count)

    def _true_residual(self, medium, force, strain, velocity) -> float:
        """‖𝒫(f + ∇·σ)‖, which it leaves in the scratch; p and the mean are those it takes off."""
        for component in velocity:
            fill_ghosts(component, medium.boundary)
        self.stress.divergence(velocity, medium, strain, self._residual)
        for d, component in enumerate(self._residual):
            np.negative(component, out=component)
            if force is not None:
                component += force[d]
        self._project(self._residual)
        return norm(self._residual)


def effective_viscosity(
    solver: SmoothedStokes,
    medium: SmoothedViscosity,
    strain: np.ndarray,
    tolerance: float = 1e-4,
    limit: int = 5000,
) -> tuple[float, SolveReport]:
    """μ_eff/μ_f = ⟨σ⟩:E/(2μ_f E:E) of free bodies in the mean strain E (3,3).

    Of a dilute suspension 1 + 5c(R−1)/(2R+3): Einstein's 1 + 2.5c as R → ∞. CaseError where E is 0.
    """
    strain = 0.5 * (np.asarray(strain, dtype=np.float64) + np.transpose(strain))
    if not strain.any():
        raise CaseError("the mean strain is 0; an effective viscosity needs one.")
    report = solver.solve(medium, None, strain, tolerance, limit)
    mean = solver.stress.mean()
    return float((mean * strain).sum() / (2.0 * medium.fluid * (strain**2).sum())), report


def _scales(medium: SmoothedViscosity) -> tuple[np.ndarray, ...]:
    """μ^{−1/2} on the faces, μ = μ_h^{3/4} μ_a^{1/4} in layers."""
    cells = medium.cells.copy()
    at = tuple(medium.place.T)
    cells[at] *= (1.0 + medium.excess / cells[at]) ** STIFF
    fill_ghosts(cells, medium.boundary)
    return tuple((0.5 * (cells + np.roll(cells, 1, axis=d))) ** -0.5 for d in range(3))


def _check(force: Vector | None, strain: np.ndarray | None) -> None:
    if force is not None and not all(np.isfinite(f).all() for f in force):
        raise CaseError("the force density has a number that is not finite.")
    if strain is None:
        return
    given = np.asarray(strain, dtype=np.float64)
    if given.shape != (3, 3) or not np.isfinite(given).all():
        raise CaseError("the mean strain must be 3 × 3 finite numbers.")
    if abs(np.trace(given)) > 1e-12 * np.abs(given).max(initial=0.0):
        raise CaseError(
            f"the mean strain has the trace {np.trace(given):g}; it must be 0, for ∇·u = 0."
        )
