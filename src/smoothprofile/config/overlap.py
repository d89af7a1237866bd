"""Which bodies of a case overlap, periodic images counted.

    min over x of the first body's points of d(x) − ρ < 0,   d the distance to the second body

For a sphere x is its centre and ρ its radius, for a capsule or a cylinder without an end its axis
and its radius: exact against any shape. For the rest ρ = 0 and x are points of the surface, tried
both ways round. No pair that is clear of each other is found; a corner that only just enters may
pass between two points.
"""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from smoothprofile import rotations
from smoothprofile.config.domain import Domain
from smoothprofile.config.particle import Particle
from smoothprofile.shapes import BOX, CAPSULE, CYLINDER, SPHERE, Part, Shape

# Bodies that touch, their positions being computed in floating point, do not overlap.
TOUCHING = 1e-9
# Points along each edge of a surface: a hundredth to a tenth of a body's size apart.
SAMPLES = 24


@dataclass(frozen=True, eq=False)
class Placed:
    """A body in space: its number in the case, what the case says of it, and its shape.

    Nothing farther than `farthest` matters: there bodies without an end are cut off.
    """

    number: int
    particle: Particle
    shape: Shape
    farthest: float

    @property
    def key(self) -> str:
        return f"particles.{self.number}"

    @cached_property
    def position(self) -> np.ndarray:
        return np.array(self.particle.position)

    @cached_property
    def quaternion(self) -> np.ndarray:
        return self.particle.quaternion

    @property
    def axis(self) -> np.ndarray:
        """Where the shape's own z axis points."""
        return rotations.rotate(self.quaternion, (0.0, 0.0, 1.0))

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """The shape's parts, placed and turned in space."""
        return tuple(
            replace(
                part,
                position=self.position + rotations.rotate(self.quaternion, part.position),
                quaternion=rotations.multiply(self.quaternion, part.quaternion),
            )
            for part in self.shape.parts
        )

    @property
    def extents(self) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest corner of the box along the domain's axes that holds the body."""
        boxes = [part.box for part in self.parts]
        lows = [part.position + box[0] for part, box in zip(self.parts, boxes, strict=True)]
        highs = [part.position + box[1] for part, box in zip(self.parts, boxes, strict=True)]
        return np.min(lows, axis=0), np.max(highs, axis=0)

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Signed distance to points in space, (n, 3) to (n,)."""
        inverse = rotations.conjugate(self.quaternion)
        return self.shape.distance(rotations.rotate(inverse, points - self.position))

    @cached_property
    def core(self) -> tuple[np.ndarray, np.ndarray]:
        """Points x in space (n, 3) and ρ (n,): balls that lie in the body and reach its surface."""
        points, radii = [], []
        for part in self.parts:
            own, radius = _core(part, self.farthest)
            points.append(part.position + rotations.rotate(part.quaternion, own))
            radii.append(np.full(len(own), radius))
        return np.concatenate(points), np.concatenate(radii)


def first_overlap(bodies: list[Placed], domain: Domain) -> tuple[Placed, Placed] | None:
    """A body and one before it that it overlaps, or itself if it overlaps its own image."""
    for body in bodies:
        if _meets_itself(body, domain):
            return body, body
    bounded = [body for body in bodies if body.particle.bounded]
    unbounded = [body for body in bodies if not body.particle.bounded]
    near = _near_pairs(bounded, domain)
    mixed = itertools.product(bounded, unbounded)
    for first, second in itertools.chain(near, mixed, itertools.combinations(unbounded, 2)):
        if _overlap(first, second, domain):
            early, late = sorted((first, second), key=lambda body: body.number)
            return late, early
    return None


def _meets_itself(body: Placed, domain: Domain) -> bool:
    if body.particle.shape == "plane":
        return False
    periods = [length for length, p in zip(domain.lengths, domain.periodic, strict=True) if p]
    if 2.0 * body.shape.reach < min(periods, default=math.inf):
        return False
    shifts = _images(2.0 * body.shape.reach, domain)
    if not body.particle.bounded:
        # A cylinder without an end is its own image along its axis.
        shifts = shifts - np.outer(shifts @ body.axis, body.axis)
    shifts = shifts[np.linalg.norm(shifts, axis=1) > TOUCHING * max(domain.lengths)]
    return any(_enters(body, body, shift, domain) for shift in _within(body, body, shifts))


def _near_pairs(bodies: list[Placed], domain: Domain) -> Iterator[tuple[Placed, Placed]]:
    """Pairs whose enclosing balls overlap, the larger body first; each pair once."""
    if len(bodies) < 2:
        return
    periods = np.where(domain.periodic, domain.lengths, 0.0)
    places = np.array([body.position for body in bodies]) - domain.origin
    # The far end of a periodic axis is its near end.
    places = np.where((periods > 0.0) & (places >= periods), 0.0, places)
    places = np.where(periods > 0.0, np.maximum(places, 0.0), places)
    reaches = np.array([body.shape.reach for body in bodies])
    tree = cKDTree(places, boxsize=periods)
    for i, body in enumerate(bodies):
        others = np.array(tree.query_ball_point(places[i], 2.0 * reaches[i]))
        smaller = (reaches[others] < reaches[i]) | ((reaches[others] == reaches[i]) & (others < i))
        others = others[smaller]
        apart = places[others] - places[i]
        apart -= periods * np.round(apart / np.where(periods > 0.0, periods, 1.0))
        touching = (reaches[others] + reaches[i]) * (1.0 - TOUCHING)
        for j in others[np.linalg.norm(apart, axis=1) < touching]:
            yield body, bodies[j]


def _overlap(first: Placed, second: Placed, domain: Domain) -> bool:
    shifts = _images(first.shape.reach + second.shape.reach, domain)
    return any(
        _enters(first, second, shift, domain) or _enters(second, first, -shift, domain)
        for shift in _within(first, second, shifts)
    )


def _images(reach: float, domain: Domain) -> np.ndarray:
    """(n, 3) displacements to the periodic images within reach; at most two periods away."""
    counts = [
        (min(2, 1 + math.floor(reach / length)) if math.isfinite(reach) else 1) if periodic else 0
        for length, periodic in zip(domain.lengths, domain.periodic, strict=True)
    ]
    steps = itertools.product(*(range(-n, n + 1) for n in counts))
    return np.array(list(steps)) * domain.lengths


def _within(first: Placed, second: Placed, shifts: np.ndarray) -> np.ndarray:
    """The shifts of `second` that bring it into the ball that encloses `first`."""
    if second.particle.bounded:
        apart = np.linalg.norm(first.position - second.position - shifts, axis=1)
        apart -= second.shape.reach
    else:
        apart = second.distance(first.position - shifts)
    return shifts[apart < first.shape.reach]


def _enters(first: Placed, second: Placed, shift: np.ndarray, domain: Domain) -> bool:
    """Whether a point of `first` lies inside `second` moved by `shift`."""
    points, radii = first.core
    depth = second.distance(points - shift) - radii
    return bool(depth.min() < -TOUCHING * max(domain.lengths))


def _core(part: Part, farthest: float) -> tuple[np.ndarray, float]:
    if part.surface is not None:
        return points_on(part.surface.vertices, part.surface.faces, part.reach / SAMPLES), 0.0
    radius, half = part.size[0], min(part.size[1], farthest)
    grid = np.linspace(-1.0, 1.0, SAMPLES + 1)
    if part.kind == SPHERE:
        return np.zeros((1, 3)), radius
    if part.kind == CAPSULE or (part.kind == CYLINDER and not part.bounded):
        along = half * np.linspace(-1.0, 1.0, 16 * SAMPLES + 1)
        return np.outer(along, (0.0, 0.0, 1.0)), radius
    if part.kind == CYLINDER:
        angle, z = np.meshgrid(np.pi * np.linspace(-1.0, 1.0, 4 * SAMPLES + 1), half * grid)
        side = np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=-1)
        return np.concatenate([side.reshape(-1, 3), [[0.0, 0.0, half], [0.0, 0.0, -half]]]), 0.0
    cube = np.stack(np.meshgrid(grid, grid, grid, indexing="ij"), axis=-1).reshape(-1, 3)
    faces = cube[np.max(np.abs(cube), axis=1) == 1.0]
    if part.kind == BOX:
        return faces * part.size, 0.0
    return faces / np.linalg.norm(faces, axis=1, keepdims=True) * part.size, 0.0


def points_on(vertices: np.ndarray, faces: np.ndarray, spacing: float) -> np.ndarray:
    """Points (n, 3) of triangles: their corners, and a grid where a side is longer than spacing."""
    points = [vertices]
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    longest = np.max([np.linalg.norm(q - p, axis=1) for p, q in ((a, b), (b, c), (c, a))], axis=0)
    divisions = np.ceil(longest / spacing).astype(int)
    for n in np.unique(divisions[divisions > 1]):
        i, j = np.meshgrid(np.arange(n + 1), np.arange(n + 1), indexing="ij")
        u, v = i[i + j <= n] / n, j[i + j <= n] / n
        p, q, r = (corner[divisions == n][:, None, :] for corner in (a, b, c))
        points.append((p + u[:, None] * (q - p) + v[:, None] * (r - p)).reshape(-1, 3))
    return np.concatenate(points)
