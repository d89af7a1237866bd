"""Rotation of rigid bodies: the implicit midpoint rule, which keeps what a free top keeps.

    L₁ = L₀ + Δt L̄×Ω̄,   L̄ = (L₀+L₁)/2 = J Ω̄        (Euler's equations along the body's axes)
    q₁ = q₀ (1, ΔtΩ̄/2)/|…|                            (Cayley: tan(θ/2) = Δt|Ω̄|/2)

The Cayley turn C obeys C L₁ = L₀, so that the angular momentum R L stays the same vector in space,
and (L₁−L₀)·Ω̄ = 0 keeps the energy, both to round-off at any Δt. A torque acts in two halves, before
and after the free turn, so that RL grows by exactly ΔtT. Second order in Δt.
"""

import numpy as np
from numba import njit, prange

from smoothprofile import rotations

# Newton's steps on Ω̄, at most: the error squares each time, from (ΔtΩ)² ~ .01 to round-off.
_NEWTON_STEPS = 6
_ROUND_OFF = 4e-16


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


@njit(parallel=True, cache=True, error_model="numpy")
def _advance(quaternion, spin, inertia, torque, dt):
    for b in prange(spin.shape[0]):
        q, j = quaternion[b], inertia[b]
        turn, slope = np.empty((3, 3)), np.empty((3, 3))
        start, half_kick, rate, turning, left = np.empty((5, 3))
        rotation_matrix(q, turn)
        _to_body(turn, spin[b], rate)
        _to_body(turn, torque[b], half_kick)
        _times(j, rate, start)
        for d in range(3):
            half_kick[d] *= 0.5 * dt
            start[d] += half_kick[d]
        # Of a ball this is Ω̄ already.
        _solve(j, half_kick, left)
        for d in range(3):
            rate[d] += left[d]
        _mean_rate(j, start, dt, rate, turning, left, slope)
        _cayley(q, dt, rate)
        rotation_matrix(q, turn)
        _times(j, rate, turning)
        for d in range(3):
            left[d] = 2.0 * turning[d] - start[d]
        _solve(j, left, rate)
        _times(turn, rate, spin[b])
        # The torque's other half acts where the body has come to.
        _to_body(turn, torque[b], half_kick)
        for d in range(3):
            half_kick[d] *= 0.5 * dt
        _solve(j, half_kick, left)
        _times(turn, left, rate)
        for d in range(3):
            spin[b, d] += rate[d]


@njit
def _mean_rate(j, start, dt, rate, turning, left, slope):
    """2(JΩ̄ − L₀) = Δt JΩ̄×Ω̄ by Newton's method, from the Ω̄ given."""
    for _ in range(_NEWTON_STEPS):
        _times(j, rate, turning)
        size, error = 0.0, 0.0
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            gyre = dt * (turning[e] * rate[f] - turning[f] * rate[e])
            left[d] = gyre - 2.0 * (turning[d] - start[d])
            size, error = max(size, abs(turning[d])), max(error, abs(left[d]))
        if error <= _ROUND_OFF * size:
            break
        for d in range(3):
            e, f = (d + 1) % 3, (d + 2) % 3
            for g in range(3):
                # Row d of 2J − Δt(JΩ̄ₓ − Ω̄ₓJ), aₓ the matrix of a×.
                slope[d, g] = 2.0 * j[d, g] + dt * (rate[e] * j[f, g] - rate[f] * j[e, g])
            slope[d, e] += dt * turning[f]
            slope[d, f] -= dt * turning[e]
        _solve(slope, left, turning)
        for d in range(3):
            rate[d] += turning[d]


@njit
def _cayley(q, dt, rate):
    """q(1, ΔtΩ̄/2)/|…|, Ω̄ along the body's axes."""
    x, y, z = 0.5 * dt * rate[0], 0.5 * dt * rate[1], 0.5 * dt * rate[2]
    a, b, c, d = q
    q[0] = a - b * x - c * y - d * z
    q[1] = b + a * x + c * z - d * y
    q[2] = c + a * y + d * x - b * z
    q[3] = d + a * z + b * y - c * x
    size = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for i in range(4):
        q[i] /= size


@njit
def rotation_matrix(q, turn):
    """R of a unit quaternion, as `rotations.matrix` of one."""
    w, x, y, z = q
    turn[0, 0], turn[0, 1] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z)
    turn[0, 2] = 2 * (x * z + w * y)
    turn[1, 0], turn[1, 1] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z)
    turn[1, 2] = 2 * (y * z - w * x)
    turn[2, 0], turn[2, 1] = 2 * (x * z - w * y), 2 * (y * z + w * x)
    turn[2, 2] = 1 - 2 * (x * x + y * y)


@njit
def _times(matrix, a, out):
    for d in range(3):
        out[d] = matrix[d, 0] * a[0] + matrix[d, 1] * a[1] + matrix[d, 2] * a[2]


@njit
def _to_body(turn, a, out):
    for d in range(3):
        out[d] = turn[0, d] * a[0] + turn[1, d] * a[1] + turn[2, d] * a[2]


@njit(error_model="numpy")
def _solve(m, a, out):
    """m⁻¹a by Cramer's rule."""
    total = 0.0
    for d in range(3):
        out[d] = 0.0
    for d in range(3):
        e, f = (d + 1) % 3, (d + 2) % 3
        for g in range(3):
            h, i = (g + 1) % 3, (g + 2) % 3
            minor = m[e, h] * m[f, i] - m[e, i] * m[f, h]
            out[g] += minor * a[d]
            if d == 0:
                total += m[0, g] * minor
    for g in range(3):
        out[g] /= total
