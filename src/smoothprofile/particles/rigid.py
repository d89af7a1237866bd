"""Rotation of rigid bodies: the implicit midpoint rule, which keeps what a free top keeps.

    L₁ = L₀ + Δt L̄×Ω̄,   L̄ = (L₀+L₁)/2 = J Ω̄        (Euler's equations along the body's axes)
    q₁ = q₀ (1, ΔtΩ̄/2)/|…|                            (Cayley: tan(θ/2) = Δt|Ω̄|/2)

The Cayley turn C obeys C L₁ = L₀, so that the angular momentum R L stays the same vector in space,
and (L₁−L₀)·Ω̄ = 0 keeps the energy, both to round-off at any Δt. A torque acts in two halves, before
and after the free turn, so that RL grows by exactly ΔtT. Second order in Δt.
"""

import numpy as np
from numba import njit

from smoothprofile import rotations

# Newton's steps on Ω̄, begun at Ω₀: the error squares each time, from (ΔtΩ)² ~ .01 to round-off.
_NEWTON_STEPS = 5


def advance_rotation(
    quaternion: np.ndarray,
    angular_velocity: np.ndarray,
    inertia: np.ndarray,
    torque: np.ndarray,
    dt: float,
) -> tuple[np.ndarray, np.ndarray]:
    """q and Ω at t+Δt: RL₁ = RL₀ + ΔtT, L = J RᵀΩ.

    `quaternion` (n,4) from body to space; `angular_velocity` and `torque` (n,3) in space, about
    the centre of mass, the torque held over the step; `inertia` J (n,3,3) along the body's axes.
    Δt|Ω| of more than about 1 leaves Newton's method short of round-off.
    """
    q = np.array(quaternion, dtype=np.float64)
    spin = np.array(angular_velocity, dtype=np.float64)
    forced = np.broadcast_to(np.asarray(torque, dtype=np.float64), spin.shape)
    _advance(q, spin, np.asarray(inertia, dtype=np.float64), forced, dt)
    return rotations.normalise(q), spin


def angular_momentum(
    quaternion: np.ndarray, angular_velocity: np.ndarray, inertia: np.ndarray
) -> np.ndarray:
    """R J RᵀΩ (n,3), in space."""
    turn = rotations.matrix(quaternion)
    return np.einsum("nij,njk,nlk,nl->ni", turn, inertia, turn, angular_velocity)


@njit(cache=True)
def _advance(quaternion, spin, inertia, torque, dt):
    known = np.empty(3)
    for b in range(spin.shape[0]):
        q, j = quaternion[b], inertia[b]
        turn = _matrix(q)
        rate = turn.T @ spin[b]
        momentum = j @ rate + 0.5 * dt * (turn.T @ torque[b])
        for _ in range(_NEWTON_STEPS):
            turning = j @ rate
            known[:] = 2.0 * (turning - momentum) - dt * _cross(turning, rate)
            slope = 2.0 * j - dt * (_hat(turning) - _hat(rate) @ j)
            rate = rate - np.linalg.solve(slope, known)
        momentum = 2.0 * (j @ rate) - momentum
        half = 0.5 * dt * rate
        w, x = q[0], q[1:].copy()
        q[0] = w - x @ half
        q[1:] = x + w * half + _cross(x, half)
        q /= np.sqrt(q @ q)
        turn = _matrix(q)
        momentum = momentum + 0.5 * dt * (turn.T @ torque[b])
        spin[b] = turn @ np.linalg.solve(j, momentum)


@njit(cache=True)
def _matrix(q):
    """R of a unit quaternion, as `rotations.matrix` of one."""
    w, x, y, z = q
    turn = np.empty((3, 3))
    turn[0, 0], turn[0, 1] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z)
    turn[0, 2] = 2 * (x * z + w * y)
    turn[1, 0], turn[1, 1] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z)
    turn[1, 2] = 2 * (y * z - w * x)
    turn[2, 0], turn[2, 1] = 2 * (x * z - w * y), 2 * (y * z + w * x)
    turn[2, 2] = 1 - 2 * (x * x + y * y)
    return turn


@njit(cache=True)
def _hat(a):
    """The matrix of a×."""
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


@njit(cache=True)
def _cross(a, b):
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
