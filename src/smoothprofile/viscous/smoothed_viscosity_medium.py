"""The viscosity of given shapes, each surface moved to where it acts as it should."""

import math
from collections.abc import Sequence

import numpy as np

from smoothprofile.distances import CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import Forms
from smoothprofile.parts import Part
from smoothprofile.profiles import profile_named
from smoothprofile.shapes import Shape
from smoothprofile.theory.dielectric import flat_offsets
from smoothprofile.viscous.smoothed_viscosity_radius import painted_radius
from smoothprofile.viscous.tensor_viscosity import (
    SmoothedViscosity,
    Smoothing,
    checked_smoothing,
    checked_viscosity,
)

CELLS = 1.0
"""ξ over the widest cell."""
STIFF = 30.0
"""Viscosity over the fluid's from which on harmonic smoothing is better than the tensor."""


def viscous_medium(
    grid: Grid,
    shapes: Sequence[Shape],
    viscosity: Sequence[float],
    fluid: float = 1.0,
    profile: str = "tanh",
    thickness: float | None = None,
    smoothing: Smoothing | None = None,
    retract: str | bool = "drag",
) -> SmoothedViscosity:
    """μ of bodies of those shapes and viscosities in a fluid, not yet painted.

    thickness: ξ, the widest cell if left out. smoothing: if left out, the tensor where every
    contrast is below 30, else harmonic. retract: move each surface by `surface_offset`, so that a
    lone sphere has its "drag", its "torque" or its "stresslet"; False leaves it where it is.
    """
    xi = CELLS * max(float(a.widths.max()) for a in grid.axes) if thickness is None else thickness
    if not (math.isfinite(xi) and xi > 0.0):
        raise CaseError(f"the thickness is {xi:g}; it must be a finite number above 0.")
    if len(shapes) != len(viscosity):
        raise CaseError(
            f"{len(shapes)} bodies have {len(viscosity)} viscosities; give one to each."
        )
    for value in (*viscosity, fluid):
        checked_viscosity(value)
    if smoothing is None:
        contrast = max((max(v / fluid, fluid / v) for v in viscosity), default=1.0)
        smoothing = "tensor" if contrast < STIFF else "harmonic"
    checked_smoothing(smoothing)
    offsets = [np.zeros((len(shape.parts), 2)) for shape in shapes]
    for rows, shape, value in zip(offsets, shapes, viscosity, strict=True):
        for row, part in zip(rows, shape.parts, strict=True):
            if retract and value != fluid:
                motion = "drag" if retract is True else retract
                row[:] = surface_offset(part, xi, value / fluid, profile, smoothing, motion)
    forms = Forms.of(shapes, offsets)
    return SmoothedViscosity(grid, forms, viscosity, fluid, profile_named(profile), xi, smoothing)


def surface_offset(
    part: Part, thickness: float, ratio: float, profile: str, smoothing: Smoothing, motion: str
) -> tuple[float, float]:
    """(o₀, o₁) of a part, painted with the distance d − o₀ − o₁(κ₁+κ₂).

    A sphere's is exact; ellipsoids and capsules take the sphere's correction by their local
    curvature, a cylinder at its own, 1/a; flat parts the one at which shear along them is right,
    −s_nξ with s_n = ∫(φ_n − H)dz: 0 for the tensor and a centred profile, −½ξ ln R for arithmetic
    smoothing and tanh.
    """
    known = profile_named(profile)
    shear, _ = flat_offsets(known.value, ratio, smoothing, known.core, known.edge)
    flat = -thickness * shear
    radius = float(part.size[0])
    if part.kind == SPHERE:
        painted = painted_radius(radius, thickness, ratio, profile, smoothing, motion)
        return painted - radius, 0.0
    if part.kind in (ELLIPSOID, CAPSULE, CYLINDER):
        mean = float(np.cbrt(np.prod(part.size))) if part.kind == ELLIPSOID else radius
        painted = painted_radius(mean, thickness, ratio, profile, smoothing, motion)
        curved = 0.5 * mean * (painted - mean - flat)
        return (flat + curved / radius, 0.0) if part.kind == CYLINDER else (flat, curved)
    return flat, 0.0
