"""Parts of bodies: simple solids of one kind, turned and placed in the body's frame."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from smoothprofile import rotations
from smoothprofile.distances import BOX, CAPSULE, ELLIPSOID, PLANE, SPHERE, fill_union_distance

# An infinite part tilted from an axis by no more than round-off is taken to be normal to it.
_ROUND_OFF = 1e-14


def frozen(values: ArrayLike) -> np.ndarray:
    """A read-only array of those numbers."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array


@dataclass(frozen=True, eq=False)
class Part:
    """x = X + R(q) x′: a solid of one `kind` (see `distances`), turned and placed in the body.

    `size` (3,) as the kind's kernel reads it, `position` X (3,), `quaternion` q (4,) w first,
    normalised here; kept as read-only arrays.
    """

    kind: int
    size: ArrayLike
    position: ArrayLike = (0.0, 0.0, 0.0)
    quaternion: ArrayLike = (1.0, 0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", frozen(self.size))
        object.__setattr__(self, "position", frozen(self.position))
        object.__setattr__(self, "quaternion", frozen(rotations.normalise(self.quaternion)))

    @property
    def bounded(self) -> bool:
        return self.kind != PLANE and bool(np.all(np.isfinite(self.size)))

    @property
    def half_extents(self) -> np.ndarray:
        """hᵢ = max |eᵢ·R x′| over the part: half the box along the body's axes around X, (3,)."""
        tilt = np.abs(rotations.matrix(self.quaternion))
        radius, half_length = self.size[0], self.size[1]
        if self.kind == SPHERE:
            return np.full(3, radius)
        if self.kind == ELLIPSOID:
            return np.sqrt(tilt**2 @ self.size**2)
        if self.kind == BOX:
            return tilt @ self.size
        if self.kind == PLANE:
            return np.full(3, math.inf)
        along = np.array([half_length * t if t > _ROUND_OFF else 0.0 for t in tilt[:, 2]])
        if self.kind == CAPSULE:
            return along + radius
        return along + radius * np.hypot(tilt[:, 0], tilt[:, 1])


def distance(parts: tuple[Part, ...], points: np.ndarray) -> np.ndarray:
    """minᵢ dᵢ at `points` (..., 3) of the body's frame; (...), negative inside."""
    flat = np.ascontiguousarray(points).reshape(-1, 3)
    out = np.empty(len(flat))
    fill_union_distance(
        np.array([part.kind for part in parts]),
        np.array([part.size for part in parts]),
        np.array([part.position for part in parts]),
        np.array([rotations.matrix(part.quaternion) for part in parts]),
        flat,
        out,
    )
    return out.reshape(points.shape[:-1])
