"""The force coupling method at Re = 0: mobility of spheres in a box.

    −∇p + μ∇²u + Σ(F Δ_M − D·∇Δ_D) = 0,   ∇·u = 0
    V = ∫uΔ_M dV,   G = −∫u∇Δ_D dV,   Ω_i = −½ε_ijk G_jk,   sym G + E∞ = 0

Nothing is painted: a sphere is its force, its torque and its stresslet S, which is whatever makes
its mean strain zero. S ↦ −E is symmetric and positive definite, and conjugate gradients need few
rounds of spreading, one direct Stokes solve and gathering.

Maxey & Patel, Int. J. Multiphase Flow 27 (2001); Lomholt & Maxey, J. Comput. Phys. 184 (2003).
"""

from dataclasses import dataclass

import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.solvers.krylov import SolveReport
from smoothprofile.viscous.direct import DirectStokes
from smoothprofile.viscous.force_coupling_envelopes import Envelopes
from smoothprofile.viscous.force_coupling_moments import (
    Scale,
    conjugate_gradients,
    lone_resistance,
    moments_of,
    power,
    spin,
    strain,
)

STRAIN_ONLY = Scale(0.0, 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Mobility:
    """V and Ω (n,3), stresslets S (n,3,3), the mean pressure gradient (3,), how the solve ended."""

    velocity: np.ndarray
    angular_velocity: np.ndarray
    stresslet: np.ndarray
    mean_gradient: np.ndarray
    report: SolveReport


class ForceCoupling:
    """Spheres of given radii in Stokes flow; `velocity` and `pressure` are the fields found last.

    rigid = False leaves the stresslets out. Axes that are not periodic end in walls that slip.
    """

    def __init__(
        self,
        grid: Grid,
        viscosity: float,
        radius: np.ndarray | float,
        *,
        rigid: bool = True,
        tolerance: float = 1e-5,
        limit: int = 200,
    ):
        """radius: a (n,). tolerance: √ of the power that strains the spheres, over the total."""
        self.stokes = DirectStokes(grid, viscosity)
        self.envelopes = Envelopes(grid, self.stokes.boundaries, radius)
        self.rigid, self.tolerance, self.limit = rigid, tolerance, limit
        self.velocity = (grid.zeros(), grid.zeros(), grid.zeros())
        self.pressure = grid.zeros()
        self._lone = lone_resistance(self.envelopes.radius, viscosity)
        self._stresslet = np.zeros((self.envelopes.count, 3, 3))

    def solve(
        self,
        position: np.ndarray,
        force: np.ndarray | float = 0.0,
        torque: np.ndarray | float = 0.0,
        mean_strain: np.ndarray | float = 0.0,
    ) -> Mobility:
        """(V, Ω, S) of spheres at position (n,3) under force and torque (n,3).

        mean_strain: E∞ (3,3), symmetric and without trace: the velocity is E∞·x + u, and V is that
        of u. The mean of u is zero. Starts from the stresslets of the solve before.
        """
        count = self.envelopes.count
        position = _rows("position", position, count)
        force, torque = _rows("force", force, count), _rows("torque", torque, count)
        ambient = np.zeros((count, 3, 4))
        ambient[:, :, 1:] = _straining(mean_strain)
        self.envelopes.place(position)
        # Where nothing drives there is no power to measure what is left of an older stresslet by.
        driven = force.any() or torque.any() or ambient.any()
        start = self._stresslet if self.rigid and driven else np.zeros_like(self._stresslet)
        moments = moments_of(force, torque, start)
        motion, gradient = self._motion(moments)
        motion += ambient
        report = SolveReport(0, 0.0, "converged")
        if self.rigid:
            report = self._make_rigid(moments, motion, ambient)
            self._stresslet = -strain(moments)
            if report.iterations:
                motion, gradient = self._motion(moments)
        return Mobility(
            velocity=motion[:, :, 0],
            angular_velocity=spin(motion),
            stresslet=self._stresslet.copy() if self.rigid else start,
            mean_gradient=gradient,
            report=report,
        )

    def _make_rigid(self, moments, motion, ambient) -> SolveReport:
        """Change the symmetric dipoles of `moments` until no sphere is strained."""

        def response(change: np.ndarray) -> np.ndarray:
            return STRAIN_ONLY(self._motion(change)[0])

        # What the spheres' own loads and the ambient flow dissipate about them.
        loads = Scale(1.0, 1.0, 0.0)(moments)
        total = abs(power(loads, motion)) + power(ambient, self._lone(ambient))
        return conjugate_gradients(
            response,
            Scale(0.0, 0.0, self._lone.stresslet),
            moments,
            -STRAIN_ONLY(motion),
            reference=np.sqrt(total),
            tolerance=self.tolerance,
            limit=self.limit,
        )

    def _motion(self, moments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """V and G (n,3,4) that the moments cause, and the mean pressure gradient."""
        for field in self.velocity:
            field[...] = 0.0
        self.envelopes.spread(moments, self.velocity)
        gradient = self.stokes.solve(self.velocity, self.velocity, self.pressure)
        return self.envelopes.gather(self.velocity), gradient


def _rows(name: str, values, count: int) -> np.ndarray:
    """(count,3), from one number, one row or all rows; CaseError for anything else."""
    values = np.asarray(values, dtype=np.float64)
    if values.ndim > 2 or (values.ndim and values.shape[-1] != 3) or not np.isfinite(values).all():
        raise CaseError(f"{name} must be one row of three finite numbers a sphere.")
    if values.ndim == 2 and values.shape[0] not in (1, count):
        raise CaseError(f"{name} has {values.shape[0]} rows; there are {count} spheres.")
    return np.broadcast_to(values, (count, 3)).copy()


def _straining(values) -> np.ndarray:
    values = np.broadcast_to(np.asarray(values, dtype=np.float64), (3, 3))
    off = max(np.abs(values - values.T).max(), abs(np.trace(values)))
    if not off <= 1e-12 * np.abs(values).max():
        raise CaseError("mean_strain must be symmetric and without trace.")
    return values
