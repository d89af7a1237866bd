"""Parts of bodies: simple solids of one kind, turned and placed in the body's frame."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from smoothprofile import rotations
from smoothprofile.distances import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    PLANE,
    SPHERE,
    fill_union_distance,
)
from smoothprofile.surfaces import Samples, Surface, joined

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
    normalised here; kept as read-only arrays. A part of kind MESH has a `surface`, and for its
    size the radius of the largest ball inside.
    """

    kind: int
    size: ArrayLike
    position: ArrayLike = (0.0, 0.0, 0.0)
    quaternion: ArrayLike = (1.0, 0.0, 0.0, 0.0)
    surface: Surface | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "size", frozen(self.size))
        object.__setattr__(self, "position", frozen(self.position))
        object.__setattr__(self, "quaternion", frozen(rotations.normalise(self.quaternion)))

    @property
    def bounded(self) -> bool:
        return self.kind != PLANE and bool(np.all(np.isfinite(self.size)))

    @cached_property
    def matrix(self) -> np.ndarray:
        """R(q), (3, 3)."""
        # Most parts are not turned, and cases may have many thousands.
        return np.eye(3) if self.quaternion[0] == 1.0 else rotations.matrix(self.quaternion)

    @property
    def half_extents(self) -> np.ndarray:
        """hᵢ = max |eᵢ·R x′| over the part: half the box along the body's axes around X, (3,)."""
        if self.surface is not None:
            return np.max(np.abs(self.box), axis=0)
        radius, half_length = self.size[0], self.size[1]
        if self.kind == SPHERE:
            return np.full(3, radius)
        tilt = np.abs(self.matrix)
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

    @property
    def box(self) -> tuple[np.ndarray, np.ndarray]:
        """min and max of eᵢ·R x′ over the part, (3,) each: a box along the body's axes, from X."""
        if self.surface is None:
            half = self.half_extents
            return -half, half
        corners = self.surface.vertices @ self.matrix.T
        return corners.min(axis=0), corners.max(axis=0)

    @property
    def reach(self) -> float:
        """max |x′| over the part; inf if it has no end."""
        radius, half_length = float(self.size[0]), float(self.size[1])
        if self.surface is not None:
            return float(np.linalg.norm(self.surface.vertices, axis=1).max())
        if self.kind == CAPSULE:
            return radius + half_length
        if self.kind in (CYLINDER, BOX):
            return float(np.linalg.norm(self.size))
        return math.inf if self.kind == PLANE else float(np.max(self.size))


@dataclass(frozen=True, eq=False)
class PartTable:
    """Parts as arrays: kind (n,), MESH + m for row m of `samples`, size and place (n, 3),
    turn (n, 3, 3) from part to body."""

    kind: np.ndarray
    size: np.ndarray
    place: np.ndarray
    turn: np.ndarray
    samples: Samples


def table_of(parts: Sequence[Part]) -> PartTable:
    """The table of those parts, a surface that several of them share being held once."""
    surfaces = list({id(p.surface): p.surface for p in parts if p.surface is not None}.values())
    rows = {id(surface): row for row, surface in enumerate(surfaces)}
    quaternions = np.array([part.quaternion for part in parts], dtype=np.float64)
    return PartTable(
        kind=np.array([p.kind + rows.get(id(p.surface), 0) for p in parts], dtype=np.int64),
        size=np.array([part.size for part in parts], dtype=np.float64).reshape(-1, 3),
        place=np.array([part.position for part in parts], dtype=np.float64).reshape(-1, 3),
        turn=rotations.matrix(quaternions.reshape(-1, 4)),
        samples=joined(surfaces),
    )


def distance(parts: Sequence[Part], points: np.ndarray) -> np.ndarray:
    """minᵢ dᵢ at `points` (..., 3) of the body's frame; (...), negative inside."""
    return distance_to(table_of(parts), points)


def distance_to(t: PartTable, points: np.ndarray) -> np.ndarray:
    """As `distance`, for many calls with the same parts."""
    flat = np.ascontiguousarray(points).reshape(-1, 3)
    out = np.empty(len(flat))
    fill_union_distance(t.kind, t.size, t.place, t.turn, t.samples, flat, out)
    return out.reshape(points.shape[:-1])
