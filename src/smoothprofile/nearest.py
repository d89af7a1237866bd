"""The nearest point of a triangulated surface: a tree of boxes and the kernels to search it.

    d(x) = ±min over triangles and their points y of |x − y|,   − inside

The side is that of the normal n of the feature on which y lies, (x − y)·n < 0 inside: the face, the
mean of the two faces at an edge, the mean weighted by angle at a corner, which is right at every
point for closed surfaces that do not cross themselves (Bærentzen & Aanæs, IEEE Trans. Vis. Comput.
Graph. 11, 2005).
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

LEAF = 2
"""Triangles that one box of the tree may hold undivided."""


class Tree(NamedTuple):
    """Boxes in the order of a walk that goes down first; `links`: next box outside this one's
    subtree, first triangle, triangles in a leaf or 0.

    boxes (m, 6) low and high corners; links (m, 3); corners (t, 9) of the triangles; normals
    (t, 7, 3) of their three corners, three edges (ab, bc, ca) and face, unit vectors.
    """

    boxes: np.ndarray
    links: np.ndarray
    corners: np.ndarray
    normals: np.ndarray


def tree_of(vertices: np.ndarray, faces: np.ndarray) -> Tree:
    """The tree of triangles faces (t, 3) over vertices (v, 3); no triangle may have area 0."""
    triangles = vertices[faces]
    low, high = triangles.min(axis=1), triangles.max(axis=1)
    order, boxes, links = np.arange(len(faces)), [], []

    def grow(begin: int, end: int) -> None:
        node, mine = len(boxes), order[begin:end]
        boxes.append(np.concatenate([low[mine].min(axis=0), high[mine].max(axis=0)]))
        links.append((node + 1, begin, end - begin))
        if end - begin <= LEAF:
            return
        middles, half = low[mine] + high[mine], (end - begin) // 2
        axis = np.argmax(np.ptp(middles, axis=0))
        order[begin:end] = mine[np.argpartition(middles[:, axis], half, kind="introselect")]
        grow(begin, begin + half)
        grow(begin + half, end)
        links[node] = (len(boxes), 0, 0)

    grow(0, len(faces))
    normals = _feature_normals(vertices, faces)
    return Tree(
        np.array(boxes),
        np.array(links, dtype=np.int64),
        np.ascontiguousarray(triangles[order].reshape(-1, 9)),
        np.ascontiguousarray(normals[order]),
    )


def _feature_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """(t, 7, 3): of each triangle the normals of its corners, edges and face."""
    a, b, c = np.moveaxis(vertices[faces], 1, 0)
    face = _units(np.cross(b - a, c - a))
    at_corner = np.zeros_like(vertices)
    for corner, (p, q, r) in enumerate(((a, b, c), (b, c, a), (c, a, b))):
        cosine = np.sum(_units(q - p) * _units(r - p), axis=1)
        angle = np.arccos(np.clip(cosine, -1.0, 1.0))
        np.add.at(at_corner, faces[:, corner], angle[:, None] * face)
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    _, which = np.unique(edges, axis=0, return_inverse=True)
    at_edge = np.zeros((which.max() + 1, 3))
    np.add.at(at_edge, which.ravel(), np.repeat(face, 3, axis=0))
    corners = _units(at_corner)[faces]
    return np.concatenate([corners, _units(at_edge)[which.reshape(-1, 3)], face[:, None]], axis=1)


def _units(vectors: np.ndarray) -> np.ndarray:
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)


@njit(error_model="numpy")
def nearest(
    tree: Tree, root: int, last: int, base: int, x: float, y: float, z: float, reach: float
) -> tuple[float, float, float, float]:
    """d and its gradient (d, ∇d) at a point known to be nearer to the surface than `reach`.

    `root` and `last`: first box of the surface in the tree and the one behind its own; `base`: its
    first triangle. `links` count from these.
    """
    best, node = reach * reach, root
    tx, ty, tz, triangle, feature = math.nan, math.nan, math.nan, -1, 6
    while node < last:
        out_x = max(tree.boxes[node, 0] - x, x - tree.boxes[node, 3], 0.0)
        out_y = max(tree.boxes[node, 1] - y, y - tree.boxes[node, 4], 0.0)
        out_z = max(tree.boxes[node, 2] - z, z - tree.boxes[node, 5], 0.0)
        count = tree.links[node, 2]
        if out_x * out_x + out_y * out_y + out_z * out_z > best:
            node = root + tree.links[node, 0]
            continue
        begin = base + tree.links[node, 1]
        for t in range(begin, begin + count):
            qx, qy, qz, f = closest_on_triangle(tree.corners[t], x, y, z)
            away = (x - qx) ** 2 + (y - qy) ** 2 + (z - qz) ** 2
            if away <= best:
                best, tx, ty, tz, triangle, feature = away, qx, qy, qz, t, f
        node += 1
    if triangle < 0:
        return math.inf, 0.0, 0.0, 0.0
    n = tree.normals[triangle, feature]
    gx, gy, gz = x - tx, y - ty, z - tz
    d = math.copysign(math.sqrt(best), gx * n[0] + gy * n[1] + gz * n[2])
    if abs(d) > 0.0:
        return d, gx / d, gy / d, gz / d
    return 0.0, n[0], n[1], n[2]


@njit(error_model="numpy")
def closest_on_triangle(
    corners: np.ndarray, x: float, y: float, z: float
) -> tuple[float, float, float, int]:
    """The point of a triangle nearest to (x, y, z), and where it lies: 0–2 corners, 3–5 edges, 6.

    By the regions of Ericson, *Real-Time Collision Detection*, 5.1.5.
    """
    ax, ay, az = corners[0], corners[1], corners[2]
    bx, by, bz = corners[3], corners[4], corners[5]
    cx, cy, cz = corners[6], corners[7], corners[8]
    ux, uy, uz = bx - ax, by - ay, bz - az
    vx, vy, vz = cx - ax, cy - ay, cz - az
    px, py, pz = x - ax, y - ay, z - az
    d1, d2 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    if d1 <= 0.0 and d2 <= 0.0:
        return ax, ay, az, 0
    px, py, pz = x - bx, y - by, z - bz
    d3, d4 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    if d3 >= 0.0 and d4 <= d3:
        return bx, by, bz, 1
    along_c = d1 * d4 - d3 * d2
    if along_c <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / (d1 - d3)
        return ax + t * ux, ay + t * uy, az + t * uz, 3
    px, py, pz = x - cx, y - cy, z - cz
    d5, d6 = ux * px + uy * py + uz * pz, vx * px + vy * py + vz * pz
    if d6 >= 0.0 and d5 <= d6:
        return cx, cy, cz, 2
    along_b = d5 * d2 - d1 * d6
    if along_b <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6)
        return ax + t * vx, ay + t * vy, az + t * vz, 5
    along_a = d3 * d6 - d5 * d4
    if along_a <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return bx + t * (cx - bx), by + t * (cy - by), bz + t * (cz - bz), 4
    scale = 1.0 / (along_a + along_b + along_c)
    s, t = along_b * scale, along_c * scale
    return ax + s * ux + t * vx, ay + s * uy + t * vy, az + s * uz + t * vz, 6
