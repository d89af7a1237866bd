"""Shapes of bodies: parts with a signed distance, and what a rigid body needs to know of them.

    V = ∫dV,   c = ∫r dV / V,   I = ∫(|r − c|² 1 − (r − c)(r − c)ᵀ) dV   (density one)

A `Shape` is one part or a union of several, in the frame of the body, whose origin the body turns
about. The scalar kernels `signed_distance` and `curvature` work on one part in its own frame.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from smoothprofile import rotations
from smoothprofile.balls import filling_balls
from smoothprofile.distances import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    MESH,
    PLANE,
    SPHERE,
)
from smoothprofile.distances import curvature as curvature
from smoothprofile.distances import signed_distance as signed_distance
from smoothprofile.distances import union_distance as union_distance
from smoothprofile.errors import CaseError
from smoothprofile.moments import mass_properties
from smoothprofile.parts import Part as Part
from smoothprofile.parts import PartTable, distance_to, frozen, table_of
from smoothprofile.surfaces import Surface


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
        return distance_to(self._table, np.asarray(points, dtype=np.float64))

    @cached_property
    def _table(self) -> PartTable:
        return table_of(self.parts)


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
    return replace(endless, volume=float(math.pi * a**2), inertia=frozen(inertia))


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


def mesh(surface: Surface) -> Shape:
    """Inside a closed triangulated surface, whose own origin is the body's.

    V = Σ a·(b × c)/6 and so on: volume and inertia are those of the facets, exactly.
    """
    return _assemble("mesh", (Part(MESH, (surface.depth, 0.0, 0.0), surface=surface),))


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
            turned = rotations.multiply(turn, part.quaternion)
            parts.append(replace(part, position=at, quaternion=turned))
    return _assemble("union", tuple(parts))


def touching(shape: Shape) -> Shape:
    """The same body for contact: triangulated parts are the balls that fill them."""
    if all(part.surface is None for part in shape.parts):
        return shape
    parts = []
    for part in shape.parts:
        if part.surface is None:
            parts.append(part)
            continue
        for *centre, radius in filling_balls(part):
            at = part.position + rotations.rotate(part.quaternion, centre)
            parts.append(Part(SPHERE, (radius, 0.0, 0.0), at))
    return replace(shape, parts=tuple(parts))


def centred(shape: Shape) -> Shape:
    """The same body with its origin at its centroid."""
    if not np.any(shape.centroid):
        return shape
    parts = (replace(part, position=part.position - shape.centroid) for part in shape.parts)
    return _assemble(shape.name, tuple(parts))


def _assemble(name: str, parts: tuple[Part, ...]) -> Shape:
    reach = max(float(np.linalg.norm(part.position)) + part.reach for part in parts)
    corners = [part.position + end for part in parts for end in part.box]
    extents = np.max(np.abs(corners), axis=0)
    volume, centroid, inertia = mass_properties(parts)
    return Shape(
        name=name,
        parts=parts,
        volume=volume,
        centroid=frozen(centroid),
        inertia=frozen(inertia),
        reach=min(reach, float(np.linalg.norm(extents))),
        extents=frozen(extents),
        curvature_varies=len(set().union(*(_curvatures(part) for part in parts))) > 1,
    )


def _curvatures(part: Part) -> set[float]:
    """Values of κ₁ + κ₂ on the part; of an ellipsoid, stand-ins that differ where its radii do.

    Of a triangulated surface, whatever it approximates, two that differ.
    """
    if part.surface is not None:
        return {0.0, 1.0}
    radius, half_length = float(part.size[0]), float(part.size[1])
    if part.kind == ELLIPSOID:
        return {2.0 / float(e) for e in part.size}
    if part.kind == CAPSULE:
        return {1.0 / radius, 2.0 / radius}
    if part.kind == CYLINDER:
        return {1.0 / radius} if math.isinf(half_length) else {1.0 / radius, 0.0}
    return {2.0 / radius} if part.kind == SPHERE else {0.0}


def _positive(name: str, values: ArrayLike, shape: tuple[int, ...] = ()) -> np.ndarray:
    try:
        numbers = np.array(values, dtype=np.float64)
    except (TypeError, ValueError):
        numbers = np.array(math.nan)
    if numbers.shape != shape or not np.all((numbers > 0.0) & np.isfinite(numbers)):
        allowed = "three finite numbers" if shape else "a finite number"
        raise CaseError(f"{name} is {values!r}; it must be {allowed} above 0.")
    return numbers
