"""Tetrahedral meshes around a sphere of radius one, curved to fit it, of what symmetry leaves.

Names of the boundaries, by which flow.py knows their conditions:

    sphere    at rest
    wall      slides along x
    y, z      mirror planes across y and z: u·n = 0, no shear
    end       plane across x on which u is normal: p and ∂u_x/∂x vanish
    seam      one of two ends that are the same place
"""

import math
from dataclasses import dataclass

import netgen.occ as occ
from ngsolve import Mesh

LENGTH, HALF_WIDTH = 20.0, 3.5
"""Of the duct: along the walls, and from its axis to each wall."""
GRADING = 0.3
CURVED = 6
"""Polynomial degree of the geometry: one for all orders of the velocity, so that all of them solve
one problem. At degree 6 a sphere of some tens of facets has its volume to 1e-7."""


@dataclass(frozen=True, eq=False)
class Symmetric:
    """A mesh, how many mirror images of it make up the whole, and the whole's volume with the
    sphere in it."""

    mesh: Mesh
    parts: int
    volume: float


def duct_mesh(spacing: float, on_sphere: float) -> Symmetric:
    """A quarter of the duct 20×7×7, sphere at the origin: 0 ≤ y, z ≤ 3.5, periodic along x.

    spacing, on_sphere: largest edges of cells, anywhere and on the sphere.
    """
    half = 0.5 * LENGTH
    box = occ.Box((-half, 0, 0), (half, HALF_WIDTH, HALF_WIDTH))
    box.faces.name = "wall"
    box.faces.Min(occ.Y).name, box.faces.Min(occ.Z).name = "y", "z"
    low, high = box.faces.Min(occ.X), box.faces.Max(occ.X)
    low.name = high.name = "seam"
    along = occ.gp_Trsf.Translation((LENGTH, 0, 0))
    low.Identify(high, "seam", occ.IdentificationType.PERIODIC, along)
    volume = LENGTH * (2.0 * HALF_WIDTH) ** 2
    return Symmetric(_around_the_sphere(box, spacing, on_sphere), 4, volume)


def array_mesh(fraction: float, spacing: float, on_sphere: float) -> Symmetric:
    """An eighth of the cube around one sphere of a simple cubic array, flow along x.

    fraction: of the cube that the sphere fills, below π/6. spacing, on_sphere: see duct_mesh.
    """
    side = (4.0 * math.pi / (3.0 * fraction)) ** (1.0 / 3.0)
    half = 0.5 * side
    box = occ.Box((0, 0, 0), (half, half, half))
    for axis, name in ((occ.X, "end"), (occ.Y, "y"), (occ.Z, "z")):
        box.faces.Min(axis).name = box.faces.Max(axis).name = name
    return Symmetric(_around_the_sphere(box, spacing, on_sphere), 8, side**3)


def _around_the_sphere(box, spacing: float, on_sphere: float) -> Mesh:
    ball = occ.Sphere((0, 0, 0), 1.0)
    ball.faces.name, ball.faces.maxh = "sphere", on_sphere
    shape = occ.OCCGeometry(box - ball)
    mesh = Mesh(shape.GenerateMesh(maxh=spacing, grading=GRADING))
    mesh.Curve(CURVED)
    return mesh
