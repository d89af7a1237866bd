"""Shapes of bodies: parts with a signed distance, and what a rigid body needs to know of them.

    V = ∫dV,   c = ∫r dV / V,   I = ∫(|r − c|² 1 − (r − c)(r − c)ᵀ) dV   (density one)

A `Shape` is one part or a union of several, in the frame of the body, whose origin the body turns
about. The scalar kernels `signed_distance` and `curvature` work on one part in its own frame.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

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
from smoothprofile.distances import curvature as curvature
from smoothprofile.distances import signed_distance as signed_distance
from smoothprofile.distances import union_distance as union_distance
from smoothprofile.errors import CaseError

# What parts share is measured on about 16³ cells, those on its surface halved this many times
# unless they become too many.
_OVERLAP_CELLS, _HALVINGS, _MOST_CELLS = 4096, 4, 1_000_000
# An infinite part tilted from an axis by no more than round-off is taken to be normal to it.
_ROUND_OFF = 1e-14


def _frozen(values: ArrayLike) -> np.ndarray:
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
        object.__setattr__(self, "size", _frozen(self.size))
        object.__setattr__(self, "position", _frozen(self.position))
        object.__setattr__(self, "quaternion", _frozen(rotations.normalise(self.quaternion)))

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


@dataclass(frozen=True, eq=False)
class Shape:
    """What a rigid body needs to know of its form; lengths in the caller's unit, density one.

    `parts` make it up; `volume`; `centroid` (3,) from the body's origin; `inertia` (3, 3) about
    the centroid, along the body's axes; `reach`, radius of a ball about the origin that holds the
    shape; `extents` (3,), half sides of such a box along the body's axes; `curvature_varies` says
    whether κ₁ + κ₂ differs between places of the surface.

    Without end: an infinite cylinder's volume and moment about its axis are per unit length and
    its other moments inf; for a plane and its unions, volume and moments are inf and the centroid
    the origin.
    """

    name: str
    parts: tuple[Part, ...]
    volume: float
    centroid: np.ndarray
    inertia: np.ndarray
    reach: float
    extents: np.ndarray
    curvature_varies: bool

    def distance(self, points: ArrayLike) -> np.ndarray:
        """minᵢ dᵢ at `points` (..., 3) of the body's frame; (...), negative inside."""
        return _distance(self.parts, np.asarray(points, dtype=np.float64))


def sphere(radius: float) -> Shape:
    """|x| < a.  V = 4πa³/3, I = 2Va²/5.  CaseError unless the radius is finite and > 0."""
    return _assemble("sphere", (Part(SPHERE, (_positive("sphere radius", radius), 0.0, 0.0)),))


def ellipsoid(radii: Sequence[float]) -> Shape:
    """Σ(xᵢ/eᵢ)² < 1.  V = 4πe₁e₂e₃/3, I₁₁ = V(e₂² + e₃²)/5.

    CaseError unless the three radii are finite and > 0.
    """
    return _assemble("ellipsoid", (Part(ELLIPSOID, _positive("ellipsoid radii", radii, (3,))),))


def cylinder(radius: float, length: float | None = None) -> Shape:
    """x² + y² < a², |z| < L/2.  V = πa²L, I₃₃ = Va²/2, I₁₁ = V(a²/4 + L²/12).

    No length: infinite along z, V = πa² and I₃₃ = πa⁴/2 per unit length.
    CaseError unless the sizes are finite and > 0.
    """
    a = _positive("cylinder radius", radius)
    if length is not None:
        half = 0.5 * _positive("cylinder length", length)
        return _assemble("cylinder", (Part(CYLINDER, (a, half, 0.0)),))
    endless = _assemble("cylinder", (Part(CYLINDER, (a, math.inf, 0.0)),))
    inertia = np.diag([math.inf, math.inf, 0.5 * math.pi * a**4])
    return replace(endless, volume=float(math.pi * a**2), inertia=_frozen(inertia))


def capsule(radius: float, length: float) -> Shape:
    """√(x² + y² + (z − clip(z, −L/2, L/2))²) < a: a cylinder of length L with half-ball ends.

    V = πa²L + 4πa³/3.  CaseError unless the sizes are finite and > 0.
    """
    a = _positive("capsule radius", radius)
    half = 0.5 * _positive("capsule length", length)
    return _assemble("capsule", (Part(CAPSULE, (a, half, 0.0)),))


def box(sides: Sequence[float]) -> Shape:
    """|xᵢ| < Lᵢ/2.  V = L₁L₂L₃, I₁₁ = V(L₂² + L₃²)/12.

    CaseError unless the three sides are finite and > 0.
    """
    return _assemble("box", (Part(BOX, 0.5 * _positive("box sides", sides, (3,))),))


def plane(normal: Sequence[float] = (0.0, 0.0, 1.0)) -> Shape:
    """n·x < 0: the half space behind a plane through the origin.

    CaseError unless `normal` is finite and not zero.
    """
    turn = rotations.from_two_vectors((0.0, 0.0, 1.0), normal)
    return _assemble("plane", (Part(PLANE, np.zeros(3), quaternion=turn),))


def union(members: Sequence[tuple[Shape, ArrayLike, ArrayLike]]) -> Shape:
    """d = minᵢ dᵢ(R(qᵢ)ᵀ(x − Xᵢ)) of members (shape, X, q), X and q in the body's frame.

    The body's origin stays where it is given; see `Shape.centroid`. Volume and inertia are exact
    sums if no parts overlap; if some do, what they share is measured on cells of about 1/256 of
    it, with an error below 5e-5 of the union's volume. CaseError if there are no members, or if
    a position or quaternion is unusable.
    """
    if len(members) == 0:
        raise CaseError("union has no parts; it must have at least one.")
    parts = []
    for shape, position, quaternion in members:
        centre = np.asarray(position, dtype=np.float64)
        if centre.shape != (3,) or not np.all(np.isfinite(centre)):
            raise CaseError(f"union position is {position}; it must be three finite numbers.")
        turn = rotations.normalise(quaternion)
        for part in shape.parts:
            at = centre + rotations.rotate(turn, part.position)
            parts.append(Part(part.kind, part.size, at, rotations.multiply(turn, part.quaternion)))
    return _assemble("union", tuple(parts))


def _assemble(name: str, parts: tuple[Part, ...]) -> Shape:
    reach = max(float(np.linalg.norm(part.position)) + _reach(part) for part in parts)
    extents = np.max([np.abs(part.position) + part.half_extents for part in parts], axis=0)
    volume, centroid, inertia = _mass_properties(parts)
    return Shape(
        name=name,
        parts=parts,
        volume=volume,
        centroid=_frozen(centroid),
        inertia=_frozen(inertia),
        reach=min(reach, float(np.linalg.norm(extents))),
        extents=_frozen(extents),
        curvature_varies=len(set().union(*(_curvatures(part) for part in parts))) > 1,
    )


def _reach(part: Part) -> float:
    """max |x′| over the part; inf if it has no end."""
    radius, half_length = float(part.size[0]), float(part.size[1])
    if part.kind == CAPSULE:
        return radius + half_length
    if part.kind in (CYLINDER, BOX):
        return float(np.linalg.norm(part.size))
    return math.inf if part.kind == PLANE else float(np.max(part.size))


def _curvatures(part: Part) -> set[float]:
    """Values of κ₁ + κ₂ on the part; of an ellipsoid, stand-ins that differ where its radii do."""
    radius, half_length = float(part.size[0]), float(part.size[1])
    if part.kind == ELLIPSOID:
        return {2.0 / float(e) for e in part.size}
    if part.kind == CAPSULE:
        return {1.0 / radius, 2.0 / radius}
    if part.kind == CYLINDER:
        return {1.0 / radius} if math.isinf(half_length) else {1.0 / radius, 0.0}
    return {2.0 / radius} if part.kind == SPHERE else {0.0}


def _mass_properties(parts: tuple[Part, ...]) -> tuple[float, np.ndarray, np.ndarray]:
    """V, c = ∫r dV/V and I = tr(M)1 − M, M = ∫rrᵀdV − Vccᵀ, parts not counted twice."""
    if not all(part.bounded for part in parts):
        return math.inf, np.zeros(3), np.diag(np.full(3, math.inf))
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for i, part in enumerate(parts):
        own_volume, own_second = _own_moments(part)
        turn, at = rotations.matrix(part.quaternion), part.position
        shared_volume, shared_first, shared_second = _shared_moments(part, parts[:i])
        volume += own_volume - shared_volume
        first += own_volume * at - shared_first
        second += turn @ np.diag(own_second) @ turn.T + own_volume * np.outer(at, at)
        second -= shared_second
    centroid = first / volume
    second -= volume * np.outer(centroid, centroid)
    return volume, centroid, np.trace(second) * np.eye(3) - second


def _own_moments(part: Part) -> tuple[float, np.ndarray]:
    """V and ∫xᵢ²dV, (3,), of a bounded part about its own centre and axes."""
    radius, half = float(part.size[0]), float(part.size[1])
    across, along = np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    if part.kind == BOX:
        volume = 8.0 * float(np.prod(part.size))
        return volume, volume * part.size**2 / 3.0
    if part.kind in (SPHERE, ELLIPSOID):
        radii = part.size if part.kind == ELLIPSOID else np.full(3, radius)
        volume = 4.0 / 3.0 * math.pi * float(np.prod(radii))
        return volume, volume * radii**2 / 5.0
    volume = 2.0 * math.pi * radius**2 * half
    second = volume * (radius**2 / 4.0 * across + half**2 / 3.0 * along)
    if part.kind == CYLINDER:
        return volume, second
    ball = 4.0 / 3.0 * math.pi * radius**3
    second += ball * (radius**2 / 5.0 + (half**2 + 0.75 * half * radius) * along)
    return volume + ball, second


def _shared_moments(part: Part, earlier: tuple[Part, ...]) -> tuple[float, np.ndarray, np.ndarray]:
    """∫dV, ∫r dV, ∫rrᵀdV where d = max(d_part, d_earlier) < 0; exactly 0 where nothing is shared.

    As |∇d| ≤ 1, a cell of half diagonal ≤ |d| at its centre is all in or all out; the others are
    halved, and the smallest count by ½ − d/h between 0 and 1, the share of a cell behind a plane.
    """
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    if not earlier:
        return volume, first, second
    low = np.min([other.position - other.half_extents for other in earlier], axis=0)
    high = np.max([other.position + other.half_extents for other in earlier], axis=0)
    low = np.maximum(low, part.position - part.half_extents)
    sides = np.minimum(high, part.position + part.half_extents) - low
    if np.any(sides <= 0.0):
        return volume, first, second
    counts = np.ceil(sides / np.cbrt(np.prod(sides) / _OVERLAP_CELLS)).clip(4, 64).astype(int)
    h = sides / counts
    points = low + h * (np.indices(counts).reshape(3, -1).T + 0.5)
    for halving in range(_HALVINGS + 1):
        d = np.maximum(_distance((part,), points), _distance(earlier, points))
        cut = np.abs(d) < 0.5 * np.linalg.norm(h)
        weights = np.where(cut, 0.0, d < 0.0)
        last = halving == _HALVINGS or 8 * np.count_nonzero(cut) > _MOST_CELLS
        if last:
            # Parts that only touch are not to share a volume by the round-off of d.
            shared = volume > 0.0 or np.min(d, initial=0.0) < -1e-6 * np.min(h)
            weights = np.clip(0.5 - d / np.min(h), 0.0, 1.0) * shared
        weights = weights * np.prod(h)
        volume += float(np.sum(weights))
        first += weights @ points
        second += (points.T * weights) @ points + np.diag(np.sum(weights) * h**2 / 12.0)
        if last:
            break
        h = 0.5 * h
        eighths = h * (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5)
        points = (points[cut, None, :] + eighths).reshape(-1, 3)
    return volume, first, second


def _distance(parts: tuple[Part, ...], points: np.ndarray) -> np.ndarray:
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


def _positive(name: str, values: ArrayLike, shape: tuple[int, ...] = ()) -> np.ndarray:
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array(math.nan)
    if numbers.shape != shape or not np.all((numbers > 0.0) & np.isfinite(numbers)):
        allowed = "three finite numbers" if shape else "a finite number"
        raise CaseError(f"{name} is {values!r}; it must be {allowed} above 0.")
    return numbers
