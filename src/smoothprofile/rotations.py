"""Rotations as unit quaternions q = (w, x, y, z), w first; q and −q are the same rotation.

    v′ = q v q*,   q = (cos θ/2, n sin θ/2)

Angles in radians, right-handed. A body's quaternion takes body coordinates to space, its
conjugate takes space back to the body. Leading axes broadcast, so one call rotates many.
"""

import numpy as np
from numpy.typing import ArrayLike

from smoothprofile.errors import CaseError

# Below this 1 + a·b the cross product of opposite directions no longer gives an accurate axis.
_NEARLY_OPPOSITE = 1e-6


def normalise(quaternion: ArrayLike) -> np.ndarray:
    """q/|q|, shape (..., 4).

    CaseError if a quaternion is zero or not finite.
    """
    return _unit(quaternion, 4, "quaternion")


def from_axis_angle(axis: ArrayLike, angle: ArrayLike) -> np.ndarray:
    """q = (cos θ/2, n sin θ/2), n = axis/|axis|.

    `axis` (..., 3) of any length, `angle` (...) in radians; the result is (..., 4).
    CaseError if an axis is zero or not finite.
    """
    n = _unit(axis, 3, "rotation axis")
    half = 0.5 * np.asarray(angle, dtype=np.float64)[..., None]
    w, n = np.broadcast_arrays(np.cos(half), n)
    return np.concatenate((w[..., :1], n * np.sin(half)), axis=-1)


def from_vector(vector: ArrayLike) -> np.ndarray:
    """q = exp(v/2): the rotation by the angle |v| about the direction of v, shape (..., 4).

    `vector` (..., 3); zero gives the identity.
    """
    v = np.asarray(vector, dtype=np.float64)
    half = 0.5 * np.linalg.norm(v, axis=-1, keepdims=True)
    return np.concatenate((np.cos(half), 0.5 * np.sinc(half / np.pi) * v), axis=-1)


def from_two_vectors(start: ArrayLike, end: ArrayLike) -> np.ndarray:
    """q of the shortest rotation with R(q) a/|a| = b/|b|: q ∝ (1 + a·b, a × b) for unit a, b.

    `start` and `end` (3,), of any length; opposite directions give about a half turn, about some
    axis normal to them. CaseError if one of them is zero or not finite.
    """
    a = _unit(start, 3, "direction")
    b = _unit(end, 3, "direction")
    if 1.0 + a @ b > _NEARLY_OPPOSITE:
        return normalise(np.array([1.0 + a @ b, *np.cross(a, b)]))
    farthest = np.eye(3)[np.argmin(np.abs(a))]
    half_turn = np.array([0.0, *_unit(np.cross(a, farthest), 3, "direction")])
    return multiply(normalise(np.array([1.0 - a @ b, *np.cross(b, a)])), half_turn)


def conjugate(quaternion: ArrayLike) -> np.ndarray:
    """q* = (w, −x, −y, −z): the inverse rotation of a unit quaternion, shape (..., 4)."""
    return np.asarray(quaternion, dtype=np.float64) * np.array([1.0, -1.0, -1.0, -1.0])


def multiply(second: ArrayLike, first: ArrayLike) -> np.ndarray:
    """pq = (p₀q₀ − p·q, p₀q + q₀p + p × q): first q, then p; R(pq) = R(p)R(q).

    Shapes (..., 4), broadcast.
    """
    p = np.asarray(second, dtype=np.float64)
    q = np.asarray(first, dtype=np.float64)
    w = p[..., :1] * q[..., :1] - np.sum(p[..., 1:] * q[..., 1:], axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate((w, v), axis=-1)


def rotate(quaternion: ArrayLike, vectors: ArrayLike) -> np.ndarray:
    """v′ = v + 2w(u × v) + 2u × (u × v), q = (w, u) a unit quaternion.

    `quaternion` (..., 4) and `vectors` (..., 3), broadcast.
    """
    q = np.asarray(quaternion, dtype=np.float64)
    v = np.asarray(vectors, dtype=np.float64)
    t = 2.0 * np.cross(q[..., 1:], v)
    return v + q[..., :1] * t + np.cross(q[..., 1:], t)


def matrix(quaternion: ArrayLike) -> np.ndarray:
    """R with R v = q v q*, shape (..., 3, 3); its columns are the body's axes in space.

    R = 1 + 2(uuᵀ − |u|² + w[u]ₓ) of a unit quaternion (w, u).
    """
    w, x, y, z = np.moveaxis(np.asarray(quaternion, dtype=np.float64), -1, 0)
    turn = np.empty((*w.shape, 3, 3))
    turn[..., 0, 0], turn[..., 0, 1] = 1 - 2 * (y * y + z * z), 2 * (x * y - w * z)
    turn[..., 1, 0], turn[..., 1, 1] = 2 * (x * y + w * z), 1 - 2 * (x * x + z * z)
    turn[..., 2, 0], turn[..., 2, 1] = 2 * (x * z - w * y), 2 * (y * z + w * x)
    turn[..., 0, 2], turn[..., 1, 2] = 2 * (x * z + w * y), 2 * (y * z - w * x)
    turn[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return turn


def _unit(values: ArrayLike, size: int, name: str) -> np.ndarray:
    vectors = np.asarray(values, dtype=np.float64)
    if vectors.shape[-1:] != (size,):
        raise CaseError(f"{name} is {vectors.tolist()}; it must have {size} numbers.")
    # Dividing by the largest component first keeps tiny and huge vectors from under- or overflow.
    largest = np.max(np.abs(vectors), axis=-1, keepdims=True)
    if not np.all(np.isfinite(largest)) or np.any(largest == 0.0):
        raise CaseError(f"{name} is {vectors.tolist()}; it must be finite and not zero.")
    scaled = vectors / largest
    return scaled / np.sqrt(np.sum(scaled * scaled, axis=-1, keepdims=True))
