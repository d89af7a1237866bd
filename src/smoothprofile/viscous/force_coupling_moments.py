"""Forces, torques and stresslets of spheres as one array, and their conjugate motions.

    D_ij = ∫f_i r_j dV = −½ε_ijk T_k − S_ij,   Ω_i = −½ε_ijk G_jk,   E = sym G − ⅓ tr G
    F·V + D:G = F·V + T·Ω − S:E

Moments and motions are (n,3,4): component i, then F_i and D_ij, or V_i and G_ij = ∂_j u_i. T is the
torque on the fluid, S the stresslet with Batchelor's sign: (20/3)πμa³E in a straining flow E.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from smoothprofile.particles.loads import LEVI_CIVITA
from smoothprofile.particles.stress import straining
from smoothprofile.solvers.krylov import LIMIT, Progress, SolveReport

Operator = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, eq=False)
class Scale:
    """One number a sphere (n,) for each part: monopole, antisymmetric and symmetric dipole."""

    force: np.ndarray | float
    torque: np.ndarray | float
    stresslet: np.ndarray | float

    def __call__(self, moments: np.ndarray) -> np.ndarray:
        """Each part times its number; the trace of the dipole is dropped."""
        slope = moments[:, :, 1:]
        turning = 0.5 * (slope - np.swapaxes(slope, 1, 2))
        straining = strain(moments)
        out = np.empty_like(moments)
        out[:, :, 0] = _column(self.force) * moments[:, :, 0]
        out[:, :, 1:] = _column(self.torque)[..., None] * turning
        out[:, :, 1:] += _column(self.stresslet)[..., None] * straining
        return out


def monopole_width(radius: np.ndarray) -> np.ndarray:
    """σ_M = a/√π: the mean velocity of a lone sphere under a force F is F/6πμa."""
    return radius / math.sqrt(math.pi)


def dipole_width(radius: np.ndarray) -> np.ndarray:
    """σ_D = a/(6√π)^(1/3): that sphere under a torque T turns at T/8πμa³."""
    return radius / (6.0 * math.sqrt(math.pi)) ** (1.0 / 3.0)


def lone_resistance(radius: np.ndarray, viscosity: float, inertia: float = 0.0) -> Scale:
    """6πa(μ + 2ρ'σ_M²), 4πa³(μ + ⅔ρ'σ_D²), (20/3)πa³(μ + ⅔ρ'σ_D²): moment over motion.

    Of a lone sphere in steady flow with ρ' = inertia = 0; ρ' = γρ/Δt adds what resists in one short
    step. The second is half of 8πμa³, for D:G = T·Ω and D:D = ½T².
    """
    drag = viscosity + 2.0 * inertia * monopole_width(radius) ** 2
    turning = viscosity + 2.0 / 3.0 * inertia * dipole_width(radius) ** 2
    return Scale(
        6.0 * np.pi * radius * drag,
        4.0 * np.pi * radius**3 * turning,
        20.0 / 3.0 * np.pi * radius**3 * turning,
    )


def moments_of(force, torque, stresslet) -> np.ndarray:
    """(n,3,4) of F (n,3), T (n,3) and S (n,3,3)."""
    moments = np.empty((*np.shape(force), 4))
    moments[:, :, 0] = force
    moments[:, :, 1:] = -0.5 * np.einsum("ijk,nk->nij", LEVI_CIVITA, torque) - stresslet
    return moments


def spin(motion: np.ndarray) -> np.ndarray:
    """Ω_i = −½ε_ijk G_jk (n,3)."""
    return -0.5 * np.einsum("ijk,njk->ni", LEVI_CIVITA, motion[:, :, 1:])


def strain(motion: np.ndarray) -> np.ndarray:
    """The symmetric part of G without its trace (n,3,3)."""
    return straining(motion[:, :, 1:])


def conjugate_gradients(
    operator: Operator,
    precondition: Operator,
    solution: np.ndarray,
    residual: np.ndarray,
    *,
    reference: float,
    tolerance: float,
    limit: int,
) -> SolveReport:
    """A x = b for moments (n,3,4), in place, from the residual b − Ax that belongs to `solution`.

    α = r·z/p·Ap,  x ← x + αp,  r ← r − αAp,  z = M⁻¹r. Stops at √(r·z) ≤ tolerance·reference: r·z
    is a power, and does not depend on units of forces and torques.
    """
    z = precondition(residual)
    direction, product = z, power(residual, z)
    progress = Progress(float(np.sqrt(product)), tolerance * reference)
    iterations, status = 0, ""
    if product <= (tolerance * reference) ** 2:
        status, limit = "converged", 0
    while iterations < limit:
        image = operator(direction)
        curvature = power(direction, image)
        iterations += 1
        if not curvature > 0.0:
            status = "diverged"
            break
        step = product / curvature
        solution += step * direction
        residual -= step * image
        z = precondition(residual)
        before, product = product, power(residual, z)
        size = np.sqrt(product)
        status = progress.verdict(size)
        if status:
            break
        direction = z + product / before * direction
    size = float(np.sqrt(product))
    return SolveReport(iterations, size / float(reference) if reference else size, status or LIMIT)


def power(moments: np.ndarray, motion: np.ndarray) -> float:
    """F·V + D:G of all spheres."""
    return float((moments * motion).sum())


def _column(values: np.ndarray | float) -> np.ndarray:
    """One row a sphere."""
    return np.asarray(values, dtype=np.float64).reshape(-1, 1)
