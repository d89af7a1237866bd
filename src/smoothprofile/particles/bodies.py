"""State and form of all bodies, as arrays with one row a body.

A body is a union of parts; the parts of all bodies stand in one table, body b owning the rows
part_start[b] … part_start[b+1].
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from smoothprofile import rotations
from smoothprofile.parts import table_of
from smoothprofile.shapes import Shape
from smoothprofile.surfaces import Samples


@dataclass
class BodyState:
    """What changes in time: position, orientation, velocities, and the loads of the last step."""

    position: np.ndarray
    quaternion: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray
    force: np.ndarray
    torque: np.ndarray

    @property
    def count(self) -> int:
        return self.position.shape[0]

    @property
    def rotation(self) -> np.ndarray:
        """(n,3,3), from the body's axes to the box's."""
        return rotations.matrix(self.quaternion)

    def saved(self) -> dict:
        """Everything, for a checkpoint."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def restore(self, saved: dict) -> None:
        """Take back what `saved` gave, into the arrays that are there."""
        for name, values in saved.items():
            getattr(self, name)[...] = values


def bodies_at(positions, quaternions) -> BodyState:
    """Bodies at rest, at those places and orientations."""
    position = np.array(positions, dtype=np.float64).reshape(-1, 3)
    quaternion = np.array(quaternions, dtype=np.float64).reshape(-1, 4)
    return BodyState(position, quaternion, *(np.zeros_like(position) for _ in range(4)))


@dataclass(frozen=True, eq=False)
class Forms:
    """The bodies' parts, and by how much the painted surface of each is moved.

    The painted signed distance of a part is d − offset₀ − offset₁(κ₁+κ₂), positive offsets
    making the body larger. volume (n,), centroid (n,3) and inertia (n,3,3) are those of the true
    bodies; the volume of one without end is infinite.
    """

    part_start: np.ndarray
    kind: np.ndarray
    size: np.ndarray
    place: np.ndarray
    turn: np.ndarray
    offset: np.ndarray
    extents: np.ndarray
    volume: np.ndarray
    centroid: np.ndarray
    inertia: np.ndarray
    samples: Samples

    @classmethod
    def of(cls, shapes: Sequence[Shape], offsets: Sequence[np.ndarray]) -> "Forms":
        """offsets[b] is (parts of b, 2): offset₀ and offset₁ of each part."""
        parts = [part for shape in shapes for part in shape.parts]
        counts = [len(shape.parts) for shape in shapes]
        table = table_of(parts)
        return cls(
            part_start=np.concatenate([[0], np.cumsum(counts)]).astype(np.int64),
            kind=table.kind,
            size=table.size,
            place=table.place,
            turn=table.turn,
            offset=np.concatenate([np.zeros((0, 2)), *offsets]).reshape(-1, 2),
            extents=np.array([shape.extents for shape in shapes], dtype=np.float64).reshape(-1, 3),
            volume=np.array([s.volume if np.isfinite(s.reach) else np.inf for s in shapes]),
            centroid=np.array([shape.centroid for shape in shapes]).reshape(-1, 3),
            inertia=np.array([shape.inertia for shape in shapes]).reshape(-1, 3, 3),
            samples=table.samples,
        )
