"""The Maxwell stress around every body that has clear fluid about it.

    F = ∮ ε(E E·n − ½E²n) dS   on a sphere of radius reach + 2·clearance about the body

It knows nothing of the bodies' permittivities, nor of how they are smoothed: beside the force by
virtual work it is an independent measurement.
"""

import math
from collections.abc import Sequence

import numpy as np

from smoothprofile.electric.stress import maxwell_loads, sphere_surface
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState
from smoothprofile.shapes import Shape

RINGS = 24


def enclosing_loads(
    grid: Grid,
    faces: tuple,
    permittivity: float,
    shapes: Sequence[Shape],
    state: BodyState,
    clearance: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Force and torque (n,3) about each body's position; NaN for those without room.

    faces: E as padded fields on the faces. permittivity: of the fluid. clearance: how far from
    every body the surface stays.
    """
    force, torque = (np.full((state.count, 3), math.nan) for _ in range(2))
    reach = np.array([shape.reach for shape in shapes])
    for b in np.flatnonzero(np.isfinite(reach)):
        surface = sphere_surface(reach[b] + 2.0 * clearance, RINGS)
        points = state.position[b] + surface.points
        if _clear(grid, points, shapes, state, b, clearance):
            force[b], torque[b] = maxwell_loads(
                grid, faces, permittivity, state.position[b], surface
            )
    return force, torque


def _clear(grid: Grid, points, shapes, state: BodyState, own: int, clearance: float) -> bool:
    """Whether a surface stays off the walls, the other bodies, and its own images."""
    for d, axis in enumerate(grid.axes):
        low, high = points[:, d].min(), points[:, d].max()
        if axis.periodic:
            if high - low > axis.length - clearance:
                return False
        elif low < axis.low + axis.widths[0] or high > axis.low + axis.length - axis.widths[-1]:
            return False
    rotation = state.rotation
    for b, shape in enumerate(shapes):
        if b == own:
            continue
        r = points - state.position[b]
        for d, axis in enumerate(grid.axes):
            if axis.periodic:
                r[:, d] -= axis.length * np.rint(r[:, d] / axis.length)
        if np.linalg.norm(r, axis=1).min() > shape.reach + clearance:
            continue
        if shape.distance(r @ rotation[b]).min() < clearance:
            return False
    return True
