"""Balls that fill a triangulated surface, for contact: what they leave free is thin.

    r(P) = max { r : −d(P − r n) ≥ r }

is the radius of the largest ball inside that touches the surface at P, n the normal there. Balls
are taken one by one where those before leave most free.
"""

from functools import lru_cache

import numpy as np

from smoothprofile.parts import Part, distance_to, table_of

MOST_BALLS, NEAR = 256, 0.01
"""Balls at most, and the room between them and the surface, over the depth, that is near enough,
also the radius of the smallest ball that is taken."""
SLACK = 1e-6
POINTS = 4000


@lru_cache(maxsize=16)
def filling_balls(part: Part) -> np.ndarray:
    """(k, 4): centres, in the frame of a part of triangles, and radii of balls inside it."""
    surface = part.surface
    own = table_of([Part(part.kind, part.size, surface=surface)])
    points, normals = _scattered(surface.vertices, surface.faces)
    free = np.full(len(points), np.inf)
    balls = []
    while len(balls) < MOST_BALLS and free.max() > NEAR * surface.depth:
        farthest = int(np.argmax(free))
        p, n = points[farthest], normals[farthest]
        low, high = 0.0, 1.01 * surface.depth
        # Fourfold sections, ten times: a millionth of the depth.
        for _ in range(10):
            tried = np.linspace(low, high, 5)
            fits = -distance_to(own, p - tried[:, None] * n) >= tried - SLACK * surface.depth
            last = int(np.argmin(fits)) if not fits.all() else 4
            low, high = tried[max(last - 1, 0)], tried[last]
        if low < NEAR * surface.depth:
            # An edge or a corner: no ball of any use touches it.
            free[farthest] = 0.0
            continue
        centre = p - low * n
        balls.append([*centre, low])
        free = np.minimum(free, np.linalg.norm(points - centre, axis=1) - low)
        free[farthest] = 0.0
    return np.array(balls)


def _scattered(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """POINTS places on the triangles, spread evenly over their area, and the normals there."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    across = np.cross(b - a, c - a)
    areas = np.linalg.norm(across, axis=1)
    generator = np.random.default_rng(0)
    which = np.searchsorted(np.cumsum(areas) / areas.sum(), (np.arange(POINTS) + 0.5) / POINTS)
    u, v = generator.uniform(size=(2, POINTS, 1))
    u, v = np.where(u + v > 1.0, 1.0 - u, u), np.where(u + v > 1.0, 1.0 - v, v)
    places = a[which] + u * (b - a)[which] + v * (c - a)[which]
    return places, across[which] / areas[which, None]
