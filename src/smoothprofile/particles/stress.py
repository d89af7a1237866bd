"""The stresslet: how a body resists being strained, from the impulse that keeps it rigid.

    S = dev sym( ∫ρ r⊗a dV − (ργ/Δt) ∫r⊗f dV ),    f = φ(u_p − u)

The body's surface moment ∮r⊗σ·n dA is ∫(r⊗∇·σ + σ)dV of the fluid that the body displaces, where
∇·σ = ρa − (ργ/Δt)f, and σ has no part but pressure, for what is in the body does not strain. a is
the acceleration of rigid motion; the antisymmetric part of the same moment is the torque. dev takes
the trace off. A torque-free sphere in a creeping strain E has S = (20/3)πμa³E (Einstein).
Source: Batchelor, J. Fluid Mech. 41 (1970).
"""

import numpy as np

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.inertia import DisplacedFluid

_ROWS, _COLUMNS = (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)


def stresslets(
    gained: np.ndarray,
    needed: np.ndarray,
    rate: float,
    density: float,
) -> np.ndarray:
    """ρ dev sym(∫r⊗a dV − (γ/Δt)∫r⊗f dV) (n,3,3).

    gained: ∫r_i f_j dV (n,3,3) of the impulse; needed: ∫r_i a_j dV, see `displaced_moments`;
    rate: γ/Δt; density: ρ of the fluid.
    """
    return straining(density * (needed - rate * gained))


def straining(moments: np.ndarray) -> np.ndarray:
    """dev sym M = ½(M + Mᵀ) − ⅓ tr M of each (n,3,3)."""
    symmetric = 0.5 * (moments + np.swapaxes(moments, 1, 2))
    trace = np.trace(symmetric, axis1=1, axis2=2)
    return symmetric - trace[:, None, None] / 3.0 * np.eye(3)


def displaced_moments(
    displaced: DisplacedFluid,
    state: BodyState,
    acceleration: np.ndarray,
    angular_acceleration: np.ndarray,
) -> np.ndarray:
    """∫r_i a_j dV (n,3,3) = V c_i A_j + Q_ik B_jk of rigid motion, a = A + B r.

    A and Ω̇ (n,3) along the box's axes, B = [Ω̇]× + [Ω]×², Q = ∫r⊗r dV about the body's position.
    """
    turn = state.rotation
    centroid = np.einsum("nij,nj->ni", turn, displaced.centroid)
    inertia = np.einsum("nij,njk,nlk->nil", turn, displaced.inertia, turn)
    half = 0.5 * np.trace(inertia, axis1=1, axis2=2)
    volume = displaced.volume[:, None, None]
    second = half[:, None, None] * np.eye(3) - inertia
    second += volume * centroid[:, :, None] * centroid[:, None, :]
    spin = cross_matrix(state.angular_velocity)
    slope = cross_matrix(angular_acceleration) + spin @ spin
    moved = volume * centroid[:, :, None] * acceleration[:, None, :]
    return moved + second @ np.swapaxes(slope, 1, 2)


def components(tensor: np.ndarray) -> np.ndarray:
    """xx, yy, zz, yz, xz, xy (..., 6) of symmetric tensors (..., 3, 3)."""
    return tensor[..., _ROWS, _COLUMNS]


def cross_matrix(vectors: np.ndarray) -> np.ndarray:
    """[v]× (n,3,3): [v]× r = v × r."""
    matrix = np.zeros((len(vectors), 3, 3))
    for i in range(3):
        matrix[:, i - 1, i - 2], matrix[:, i - 2, i - 1] = vectors[:, i], -vectors[:, i]
    return matrix
