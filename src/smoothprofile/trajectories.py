"""trajectory.gsd: places, attitudes and motions of all bodies, frame by frame, for viewers.

GSD (General Simulation Data, schema hoomd) is what OVITO, freud and HOOMD-blue open. Its box is
centred at the origin, so that

    X = R − centre − image·L,    image = ⌊(R − low)/L⌋ along periodic axes, 0 along walled ones

A frame stands for each row of history. Bodies without an end are left out. Numbers are of single
precision; particles.csv has all digits. Format: https://gsd.readthedocs.io.
"""

import os
import time as clock
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import gsd.hoomd
import numpy as np
from scipy.spatial import ConvexHull

from smoothprofile.config import body_shape
from smoothprofile.distances import BOX, CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.safefiles import writing
from smoothprofile.shapes import Part, Shape

AROUND = 32
"""Points around a round shape that is written as a polyhedron."""
BETWEEN_FLUSHES = 0.1
"""Seconds: bringing a frame to the disk takes five milliseconds, more than small steps do."""


class Trajectory:
    """A GSD file that grows: after a kill all frames but those of the last 0.1 s can be read."""

    def __init__(
        self,
        path: Path | str,
        grid: Grid,
        shapes: Sequence[Shape],
        mass: Sequence[float],
        names: Sequence[str],
    ):
        """mass (n,): NaN where it is not known; names (n,): what a type of several is named after.

        Frames that the file holds already are kept.
        """
        self._low = np.array([axis.low for axis in grid.axes])
        self._lengths = np.array(grid.lengths)
        self._periodic = np.array(grid.periodic)
        self._rows = np.flatnonzero([np.isfinite(shape.reach) for shape in shapes])
        self._still = _unchanging([shapes[b] for b in self._rows], [names[b] for b in self._rows])
        known = np.asarray(mass, dtype=np.float64)[self._rows]
        if np.isfinite(known).any():
            self._still["mass"] = _single(np.nan_to_num(known, nan=0.0))
            inertia = _principal([shapes[b] for b in self._rows], known)
            self._still["moment_inertia"] = _single(inertia)
        self._path = Path(path)
        with writing(self._path):
            self._file = gsd.hoomd.open(str(path), mode="a")
        self._flushed = -np.inf

    def append(self, simulation: Any) -> None:
        """Add a frame; force, torque and angular velocity go to its log, as does the time."""
        frame, rows, state = gsd.hoomd.Frame(), self._rows, simulation.bodies.state
        frame.configuration.step = simulation.steps
        frame.configuration.box = _single([*self._lengths, 0.0, 0.0, 0.0])
        frame.configuration.dimensions = 3
        particles = frame.particles
        particles.N = rows.size
        for key, values in self._still.items():
            setattr(particles, key, values)
        places = state.position[rows] - self._low
        images = np.where(self._periodic, np.floor(places / self._lengths), 0.0)
        particles.position = _single(places - (images + 0.5) * self._lengths)
        particles.image = images.astype(np.int32)
        particles.orientation = _single(state.quaternion[rows])
        particles.velocity = _single(state.velocity[rows])
        frame.log = {
            "time": np.array([simulation.time]),
            "particles/force": _single(state.force[rows]),
            "particles/torque": _single(state.torque[rows]),
            "particles/angular_velocity": _single(state.angular_velocity[rows]),
        }
        with writing(self._path):
            self._file.append(frame)
        if clock.monotonic() > self._flushed + BETWEEN_FLUSHES:
            self.flush()
            self._flushed = clock.monotonic()

    def flush(self) -> None:
        """Bring all frames to the file. OutputError if it cannot be written."""
        with writing(self._path):
            self._file.flush()

    def close(self) -> None:
        """OutputError if the last frames cannot be written."""
        with writing(self._path):
            self._file.close()


class NoTrajectory:
    """That of a run whose bodies all stay where they are, or have no end."""

    def append(self, simulation: Any) -> None:
        """Nothing to write."""

    def flush(self) -> None:
        """Nothing to flush."""

    def close(self) -> None:
        """Nothing to close."""


def trajectory_of(path: Path | str, simulation: Any) -> Trajectory | NoTrajectory:
    """The trajectory to write of a simulation, at its start or where it goes on."""
    particles = simulation.case.particles if simulation.bodies_move else ()
    shapes = [body_shape(particle) for particle in particles]
    if not any(np.isfinite(shape.reach) for shape in shapes):
        return NoTrajectory()
    mass = [
        np.nan if particle.density is None else particle.density * shape.volume
        for particle, shape in zip(particles, shapes, strict=True)
    ]
    return Trajectory(path, simulation.grid, shapes, mass, [p.name for p in particles])


def cut_back(path: Path | str, step: int) -> None:
    """Leave only the frames up to `step`, if there is such a file: a run goes on from there.

    CaseError if it cannot be read; with `step` below 0 it is not asked to be.
    """
    path = Path(path)
    if not path.is_file():
        return
    if step < 0:
        path.unlink()
        return
    draft = path.with_name(path.name + ".new")
    try:
        old = gsd.hoomd.open(str(path), mode="r")
    except (OSError, RuntimeError) as error:
        raise CaseError(f"{path} cannot be gone on with: it is damaged.") from error
    with old, writing(path):
        with gsd.hoomd.open(str(draft), mode="w") as new:
            new.extend(frame for frame in old if frame.configuration.step <= step)
        os.replace(draft, path)


def _unchanging(shapes: Sequence[Shape], names: Sequence[str]) -> dict[str, Any]:
    """Types, type of each body, form of each type, diameters.

    All spheres are one type, told apart by their diameters; other bodies are of one type if their
    forms are the same, called after the first of them.
    """
    numbers: dict[Any, int] = {}
    types, forms, typeid = [], [], []
    for shape, name in zip(shapes, names, strict=True):
        key = SPHERE if _is_ball(shape) else _key(shape)
        if key not in numbers:
            numbers[key] = len(types)
            types.append("sphere" if key is SPHERE else name)
            forms.append(type_shape(shape))
        typeid.append(numbers[key])
    radii = [shape.parts[0].size[0] for shape in shapes if _is_ball(shape)]
    if len(set(radii)) > 1:
        forms[numbers[SPHERE]] = {}
    # A viewer scales a polyhedron by its radius, which 1 leaves as it is.
    diameter = [2.0 * s.parts[0].size[0] if _is_ball(s) else 2.0 for s in shapes]
    return {
        "types": types,
        "typeid": np.array(typeid, dtype=np.uint32),
        "type_shapes": forms,
        "diameter": _single(diameter),
    }


def type_shape(shape: Shape) -> dict[str, Any]:
    """The form of a bounded shape as GSD's type_shapes has it, about the body's position."""
    parts = shape.parts
    if all(part.kind == SPHERE for part in parts):
        if _is_ball(shape):
            return {"type": "Sphere", "diameter": 2.0 * float(parts[0].size[0])}
        return {
            "type": "SphereUnion",
            "centers": [part.position.tolist() for part in parts],
            "diameters": [2.0 * float(part.size[0]) for part in parts],
        }
    plain = len(parts) == 1 and not parts[0].position.any() and parts[0].quaternion[0] == 1.0
    if plain and parts[0].kind == ELLIPSOID:
        return {"type": "Ellipsoid"} | dict(zip("abc", parts[0].size.tolist(), strict=True))
    if len(parts) == 1 and parts[0].surface is None:
        return {"type": "ConvexPolyhedron", "vertices": _corners(parts[0]).tolist()}
    vertices, faces, count = [], [], 0
    for part in parts:
        corners, triangles = _facets(part)
        vertices += corners.tolist()
        faces += (triangles + count).tolist()
        count += len(corners)
    return {"type": "Mesh", "vertices": vertices, "indices": faces}


def _is_ball(shape: Shape) -> bool:
    """A sphere about the body's position: it looks the same however it is turned."""
    (first, *others) = shape.parts
    return first.kind == SPHERE and not others and not first.position.any()


def _key(shape: Shape) -> tuple:
    """Equal for shapes of the same form."""
    return tuple(
        (p.kind, p.size.tobytes(), p.position.tobytes(), p.quaternion.tobytes(), id(p.surface))
        for p in shape.parts
    )


def _facets(part: Part) -> tuple[np.ndarray, np.ndarray]:
    """Corners (v,3) and triangles (t,3) of one part in the body's frame, normals outward."""
    if part.surface is not None:
        return _placed(part, part.surface.vertices), np.asarray(part.surface.faces)
    corners = _corners(part)
    hull = ConvexHull(corners)
    triangles = hull.simplices.copy()
    a, b, c = (corners[triangles[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return corners, triangles


def _corners(part: Part) -> np.ndarray:
    """Points (v,3) of the body's frame whose convex hull is the part, or fits it within 1 %."""
    s = part.size
    if part.kind == BOX:
        signs = np.stack(np.meshgrid(*([-1.0, 1.0],) * 3, indexing="ij"), axis=-1)
        return _placed(part, signs.reshape(-1, 3) * s)
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    ring = np.stack([np.cos(angle), np.sin(angle), np.zeros(AROUND)], axis=1)
    if part.kind == CYLINDER:
        end = np.array([0.0, 0.0, s[1]])
        return _placed(part, np.concatenate([s[0] * ring - end, s[0] * ring + end]))
    heights = 0.5 * np.pi * np.arange(AROUND // 4) / (AROUND // 4)
    pole = np.array([[0.0, 0.0, 1.0]])
    cap = np.concatenate([np.cos(h) * ring + np.sin(h) * pole for h in heights] + [pole])
    if part.kind == CAPSULE:
        upper = s[0] * cap + s[1] * pole
        return _placed(part, np.concatenate([upper, upper * [1.0, 1.0, -1.0]]))
    radii = s if part.kind == ELLIPSOID else np.full(3, s[0])
    # The equator belongs to both halves, and is wanted once.
    return _placed(part, np.concatenate([cap, cap[AROUND:] * [1.0, 1.0, -1.0]]) * radii)


def _placed(part: Part, points: np.ndarray) -> np.ndarray:
    return part.position + points @ part.matrix.T


def _principal(shapes: Sequence[Shape], mass: np.ndarray) -> np.ndarray:
    """(n,3): mI/V about the centroid along the body's axes; 0 where unknown or not diagonal."""
    moments = np.zeros((len(shapes), 3))
    for row, shape, m in zip(moments, shapes, mass, strict=True):
        tensor = np.asarray(shape.inertia)
        mixed = np.abs(tensor - np.diag(np.diag(tensor))).max()
        if np.isfinite(m) and mixed <= 1e-9 * np.abs(tensor).max():
            row[:] = m / shape.volume * np.diag(tensor)
    return moments


def _single(values: np.ndarray) -> np.ndarray:
    """In single precision; what is beyond its range, as its largest number."""
    largest = np.finfo(np.float32).max
    return np.ascontiguousarray(np.clip(values, -largest, largest), dtype=np.float32)
