"""What is read off a finite element solution: integrals, values where a figure wants them."""

from collections.abc import Sequence
from dataclasses import dataclass

import ngsolve as ng
import numpy as np

from smoothprofile.body_fitted.facets import places
from smoothprofile.body_fitted.meshes import CURVED

STEPS = 6
"""Steps to an edge of a facet of a slice."""
INWARDS = 1e-7
"""From the axis, where the meshes end, into them."""


@dataclass(frozen=True, eq=False)
class Slice:
    """A plane as curved triangles, one of each cell that has a face there.

    place, velocity  (facets, points, 3): points as in facets.py, with STEPS steps to an edge
    """

    place: np.ndarray
    velocity: np.ndarray


def integral(mesh: ng.Mesh, function: ng.CoefficientFunction, order: int) -> float:
    """∫ function dV over the mesh; `order`: of the elements that it is made of."""
    return float(ng.Integrate(function, mesh, order=order + 3 * CURVED - 1))


def on_axis(mesh: ng.Mesh, velocity: ng.CoefficientFunction, x: Sequence[float]) -> np.ndarray:
    """u_x(x, 0, 0) for each x, outside the sphere."""
    return np.array([velocity(mesh(float(place), INWARDS, INWARDS))[0] for place in x])


def on_mirror(mesh: ng.Mesh, name: str, velocity: ng.CoefficientFunction) -> Slice:
    """The velocity on a mirror plane."""
    points = places(STEPS)
    rule = ng.IntegrationRule([tuple(point) for point in points], [0.0] * len(points))
    where = mesh.MapToAllElements(rule, mesh.Boundaries(name))
    shape = (-1, len(points), 3)
    position = ng.CF((ng.x, ng.y, ng.z))
    return Slice(position(where).reshape(shape), velocity(where).reshape(shape))
