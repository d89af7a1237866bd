"""Drag on a sphere in a duct and in simple cubic arrays, by elements of several orders on a mesh.

Units: a = μ = 1. Every problem is solved with each order of the velocity, on one mesh of exact
enough geometry, and extrapolated from the last three.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import ngsolve as ng
import numpy as np

from smoothprofile.body_fitted.flow import FiniteElements
from smoothprofile.body_fitted.ladder import Limit, limit_of
from smoothprofile.body_fitted.meshes import array_mesh, duct_mesh
from smoothprofile.body_fitted.samples import Slice, integral, on_axis, on_mirror
from smoothprofile.threads import thread_count

ORDERS = (3, 4, 5)
DUCT_SPACING, DUCT_ON_SPHERE = 1.4, 0.5
ARRAY_SPACING, ARRAY_ON_SPHERE = 0.6, 0.35
ACROSS_GAPS = 3.0
"""Largest edge on a sphere, over half the gap to its neighbour."""


@dataclass(frozen=True, eq=False)
class Ladder:
    """What each order found of one number, and what that tends to.

    orders, unknowns, values  one of each order
    """

    orders: tuple[int, ...]
    unknowns: np.ndarray
    values: np.ndarray

    @property
    def limit(self) -> Limit:
        return limit_of(self.values)


@dataclass(frozen=True, eq=False)
class Duct:
    """A sphere held in the duct 20×7×7.

    creeping       force over the walls' speed, Stokes flow
    force          force at the density and wall speed asked for
    mean_velocity  u_x over the cross-section, zero in the sphere
    axis           x and u_x of the highest order on the axis
    plane          its velocity in the plane z = 0, where y > 0
    """

    creeping: Ladder
    force: Ladder
    mean_velocity: Ladder
    axis: dict[str, np.ndarray]
    plane: Slice


def duct(
    density: float = 1.0,
    wall_speed: float = 5.0,
    orders: Sequence[int] = ORDERS,
    finer: float = 1.0,
    axis: np.ndarray = (),
) -> Duct:
    """F of the fluid on a sphere in a square duct whose walls slide, Re = 2ρU/μ, and Re → 0.

    No mean pressure gradient. finer: divides the edges of the mesh. axis: x at which u_x(x, 0, 0)
    is wanted, off the sphere.
    """
    ng.SetNumThreads(thread_count())
    part = duct_mesh(DUCT_SPACING / finer, DUCT_ON_SPHERE / finer)
    unknowns, rows = [], []
    with ng.TaskManager():
        for order in orders:
            elements = FiniteElements(part.mesh, order)
            slow = elements.solve(wall_speed=1.0)
            found = elements.solve(density, wall_speed)
            unknowns.append(elements.unknowns)
            flux = integral(part.mesh, found.velocity[0], order)
            whole = np.array([slow.reaction, found.reaction, flux / part.volume])
            rows.append(part.parts * whole)
        line = {"x": np.asarray(axis), "u": on_axis(part.mesh, found.velocity, axis)}
        plane = on_mirror(part.mesh, "z", found.velocity)
    ladders = [
        Ladder(tuple(orders), np.array(unknowns), np.array(v)) for v in zip(*rows, strict=True)
    ]
    return Duct(*ladders, line, plane)


def cubic_array(fraction: float, orders: Sequence[int] = ORDERS, finer: float = 1.0) -> Ladder:
    """K = F/(6πμaU) = L³g/(6πU) of a simple cubic array of spheres held in Stokes flow.

    g: the mean pressure gradient, which all the drag balances: F = gL³. U: mean velocity over
    the cube of side L, in which the sphere fills `fraction`; ValueError unless it lies between 0
    and π/6, where spheres touch. By ∫μ∇u:∇u = gUL³ the error of U is that of the energy.
    """
    if not 0.0 < fraction < math.pi / 6.0:
        raise ValueError(f"fraction is {fraction}; it must lie between 0 and π/6")
    ng.SetNumThreads(thread_count())
    gap = 0.5 * (4.0 * math.pi / (3.0 * fraction)) ** (1.0 / 3.0) - 1.0
    on_sphere = min(ARRAY_ON_SPHERE, ACROSS_GAPS * gap)
    spacing = min(ARRAY_SPACING, 2.0 * on_sphere)
    part = array_mesh(fraction, spacing / finer, on_sphere / finer)
    unknowns, values = [], []
    with ng.TaskManager():
        for order in orders:
            elements = FiniteElements(part.mesh, order)
            found = elements.solve(body_force=1.0)
            mean = part.parts * integral(part.mesh, found.velocity[0], order) / part.volume
            unknowns.append(elements.unknowns)
            values.append(part.volume / (6.0 * math.pi * mean))
    return Ladder(tuple(orders), np.array(unknowns), np.array(values))
