"""The permittivity of given shapes, painted as it is most accurate: the defaults of the solver.

tensor smoothing, tanh with ξ = .75Δx, surfaces moved so that the dipole of a lone body is right.
`docs/decisions.md` has the reasons, `spm study profiles` the measurements.
"""

import math
from collections.abc import Sequence

import numpy as np

from smoothprofile.calibration import dielectric_offset, dielectric_radius
from smoothprofile.distances import CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from smoothprofile.electric.permittivity import Permittivity, Smoothing, checked_permittivity
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import Forms
from smoothprofile.parts import Part
from smoothprofile.profiles import profile_named
from smoothprofile.shapes import Shape

CELLS = 0.75
"""ξ over the widest cell."""


def dielectric_medium(
    grid: Grid,
    shapes: Sequence[Shape],
    permittivity: Sequence[float],
    fluid: float = 1.0,
    profile: str = "tanh",
    thickness: float | None = None,
    smoothing: Smoothing = "tensor",
    retract: bool = True,
    around: Sequence[float] | None = None,
) -> Permittivity:
    """ε of bodies of those shapes and permittivities in a fluid, not yet painted.

    thickness: ξ, .75Δx if left out. retract: move each surface by `surface_offset`. around: of each
    body, the permittivity that its surface borders on, as a core's does on its shell's; the fluid's
    if left out.
    CaseError for a permittivity that is not above 0, and for layers thicker than .8 of a radius.
    """
    xi = default_thickness(grid) if thickness is None else thickness
    if not (math.isfinite(xi) and xi > 0.0):
        raise CaseError(f"electric.thickness is {xi:g}; it must be a finite number above 0.")
    for value in (*permittivity, fluid):
        checked_permittivity(value)
    if len(shapes) != len(permittivity):
        raise CaseError(
            f"{len(shapes)} bodies have {len(permittivity)} permittivities; give one to each."
        )
    offsets = [np.zeros((len(shape.parts), 2)) for shape in shapes]
    outside = [fluid] * len(shapes) if around is None else around
    for rows, shape, value, outer in zip(offsets, shapes, permittivity, outside, strict=True):
        for row, part in zip(rows, shape.parts, strict=True):
            if retract:
                row[:] = surface_offset(part, xi, value / outer, profile, smoothing)
    forms = Forms.of(shapes, offsets)
    return Permittivity(grid, forms, permittivity, fluid, profile_named(profile), xi, smoothing)


def default_thickness(grid: Grid) -> float:
    """ξ = .75Δx of the widest cell."""
    return CELLS * widest_cell(grid)


def widest_cell(grid: Grid) -> float:
    """Along axes that have more than one; of a grid of one cell, its longest side."""
    axes = [axis for axis in grid.axes if axis.cells > 1 or not axis.periodic] or grid.axes
    return max(float(axis.widths.max()) for axis in axes)


def surface_offset(
    part: Part, thickness: float, ratio: float, profile: str, smoothing: Smoothing
) -> tuple[float, float]:
    """(o₀, o₁) of a part, painted with the distance d − o₀ − o₁(κ₁+κ₂), so that its field is right.

    A sphere's is exact for its dipole; ellipsoids and capsules take the sphere's correction by
    their local curvature, a cylinder at its own, 1/a; flat parts the planar one, 0 for the tensor
    and a centred profile.
    """
    radius = float(part.size[0])
    if part.kind == SPHERE:
        painted = dielectric_radius(radius, thickness, ratio, profile, smoothing)
        return painted - radius, 0.0
    if part.kind in (ELLIPSOID, CAPSULE, CYLINDER):
        mean = float(np.cbrt(np.prod(part.size))) if part.kind == ELLIPSOID else radius
        flat, curved = dielectric_offset(mean, thickness, ratio, profile, smoothing)
        return (flat + curved / radius, 0.0) if part.kind == CYLINDER else (flat, curved)
    # A flat part has no radius, and its offset does not depend on the one that is named.
    flat, _ = dielectric_offset(10.0 * thickness, thickness, ratio, profile, smoothing)
    return flat, 0.0
