"""Force and torque by the Maxwell stress on a closed surface around a body.

    F = ∮ ε(E E·n − ½E²n) dS,   T = ∮ r × (the same) dS,   ε that of the fluid

The surface must lie in clear fluid: its field is interpolated linearly, and the error is of second
order in the cell and in ξ. Source: the thesis, (4.20)–(4.21).
"""

from dataclasses import dataclass

import numpy as np

from smoothprofile.grid import Grid
from smoothprofile.sampling import interpolate


@dataclass(frozen=True, eq=False)
class Surface:
    """points (m,3) from its centre, outward normals (m,3) and areas (m,)."""

    points: np.ndarray
    normals: np.ndarray
    areas: np.ndarray


def sphere_surface(radius: float, rings: int = 24) -> Surface:
    """Gauss points in cos θ and equal steps in azimuth; exact to degree 2·rings − 1."""
    cosine, weight = np.polynomial.legendre.leggauss(rings)
    angle = 2 * np.pi * (np.arange(2 * rings) + 0.5) / (2 * rings)
    sine = np.sqrt(1.0 - cosine**2)
    normals = np.stack(
        [
            np.outer(sine, np.cos(angle)),
            np.outer(sine, np.sin(angle)),
            np.repeat(cosine[:, None], angle.size, axis=1),
        ],
        axis=-1,
    ).reshape(-1, 3)
    areas = np.repeat(weight, angle.size) * radius**2 * 2 * np.pi / angle.size
    return Surface(radius * normals, normals, areas)


def maxwell_loads(
    grid: Grid, faces: tuple, permittivity: float, centre, surface: Surface
) -> tuple[np.ndarray, np.ndarray]:
    """Force (3,) and torque (3,) about `centre`, from the E of `PotentialSolver.field`."""
    centre = np.asarray(centre, dtype=np.float64)
    e = field_at(grid, faces, centre + surface.points)
    along = np.einsum("ma,ma->m", e, surface.normals)
    square = np.einsum("ma,ma->m", e, e)
    traction = permittivity * (along[:, None] * e - 0.5 * square[:, None] * surface.normals)
    pull = traction * surface.areas[:, None]
    return pull.sum(axis=0), np.cross(surface.points, pull).sum(axis=0)


def field_at(grid: Grid, faces: tuple, points: np.ndarray) -> np.ndarray:
    """E (m,3) at points (m,3), each component linear between its own faces."""
    return np.stack([interpolate(grid, e, c, points) for c, e in enumerate(faces)], axis=1)
