"""Steady Stokes flow around given shapes: layer, painted surfaces and compliances put together.

painted distance = d − o₀ − o₁(κ₁+κ₂)
"""

import math
from collections.abc import Sequence

import numpy as np

from smoothprofile.boundaries import velocity_boundary
from smoothprofile.calibration.stokes import (
    LAYER_RATIO,
    stokes_profile,
    stokes_shift,
    stokes_sphere,
    translation_radius,
)
from smoothprofile.distances import CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import Forms
from smoothprofile.particles.paint import Painter
from smoothprofile.parts import Part
from smoothprofile.shapes import Shape
from smoothprofile.viscous.direct import SLIP
from smoothprofile.viscous.stokes import RigidStokes

CELLS_TO_XI = {"tanh": 0.6, "quartic": 2.5, "quartic-centred": 2.5, "sine": 2.5}
"""The thickness that is taken if none is given: as thin as the grid hardly shows."""
NO_SLIP = (("wall", "wall"),) * 3


def stokes_around(
    grid: Grid,
    shapes: Sequence[Shape],
    viscosity: float,
    *,
    profile: str = "sine",
    thickness: float | None = None,
    layer: float | None = None,
    retract: bool | str = True,
    walls: Sequence = NO_SLIP,
) -> RigidStokes:
    """A solver for bodies of those shapes.

    thickness ξ: 2.5 cells of the compact profiles, .6 of tanh if left out; layer ℓ: `LAYER_RATIO`
    of ξ. retract: True paints spheres by `stokes_sphere`, which makes lone ones exact, curved
    shapes by their curvature, others by the planar shift; "planar" takes that for all, False none.
    walls: as in `RigidStokes`. CaseError where a surface cannot be moved to where it acts.
    """
    cell = float(np.cbrt(np.prod(grid.smallest_widths)))
    painting = stokes_profile(profile)
    thickness = CELLS_TO_XI[profile] * cell if thickness is None else float(thickness)
    layer = LAYER_RATIO[profile] * thickness if layer is None else float(layer)
    arguments = thickness, layer, cell, profile
    offsets = [_offsets(shape, arguments, retract) for shape in shapes]
    compliance = np.array([_compliance(shape, arguments, retract) for shape in shapes])
    forms = Forms.of(shapes, offsets)
    boundaries = tuple(velocity_boundary(grid, SLIP, component) for component in range(3))
    painter = Painter(grid, boundaries, forms, painting, thickness)
    return RigidStokes(grid, painter, viscosity, layer, compliance.reshape(-1, 3), walls)


def _lone_sphere(shape: Shape) -> Part | None:
    one = len(shape.parts) == 1 and shape.parts[0].kind == SPHERE
    return shape.parts[0] if one else None


def _compliance(shape: Shape, arguments: tuple, retract: bool | str) -> tuple:
    part = _lone_sphere(shape)
    if part is None or retract is not True:
        return 0.0, 0.0, 0.0
    found = stokes_sphere(float(part.size[0]), *arguments)
    return found.translation, found.rotation, found.straining


def _offsets(shape: Shape, arguments: tuple, retract: bool | str) -> np.ndarray:
    """(parts, 2): offset₀ and offset₁ of each part."""
    offsets = np.zeros((len(shape.parts), 2))
    if retract is False:
        return offsets
    thickness, layer, cell, profile = arguments
    planar = stokes_shift(profile, thickness, layer, cell)
    offsets[:, 0] = planar
    if retract == "planar":
        return offsets
    part = _lone_sphere(shape)
    if part is not None:
        radius = float(part.size[0])
        offsets[0, 0] = stokes_sphere(radius, *arguments).radius - radius
        return offsets
    for row, part in zip(offsets, shape.parts, strict=True):
        row[:] = _curved(part, planar, arguments)
    return offsets


def _curved(part: Part, planar: float, arguments: tuple) -> tuple[float, float]:
    """Of a part that has no compliance: by its drag, spread by local curvature."""
    thickness, layer, _, profile = arguments
    if part.kind not in (SPHERE, CYLINDER, ELLIPSOID, CAPSULE):
        return planar, 0.0
    radius = float(np.cbrt(np.prod(part.size)) if part.kind == ELLIPSOID else part.size[0])
    dimension = 2 if part.kind == CYLINDER and math.isinf(part.size[1]) else 3
    flat = stokes_shift(profile, thickness, layer)
    extra = translation_radius(radius, thickness, layer, profile, dimension) - radius - flat
    if part.kind in (SPHERE, CYLINDER):
        return planar + extra, 0.0
    return planar, 0.5 * radius * extra
