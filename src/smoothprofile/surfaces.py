"""Signed distance of closed triangulated surfaces, sampled once for painting.

    d(x) = Σ w_c (d_c + ½ ∇d_c·(x − x_c))      over the eight corners c of a cell, w trilinear

The mean of the trilinear interpolation and of the corners' tangents: exact for quadratic fields,
third order where the surface is smooth. Cells that a kink of the field crosses (behind edges, and
on the medial surface) are known beforehand, and there the nearest triangle is searched for.
Beyond the sampled box d is the distance to the foot of the perpendicular from the box's side.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from smoothprofile.nearest import nearest, tree_of

NODES = 500_000
"""Nodes of the grid on which a surface is sampled."""
MARGIN = 0.2
"""Room around a surface within that grid, over the cube root of its bounding box's volume."""
KINK = 0.025
"""Miss of the interpolation, over the spacing, from which on a cell counts as kinked."""

ROUND_OFF = 1e-6


class Samples(NamedTuple):
    """Sampled surfaces, one row each of `grid`, `frame` and `range`.

    grid (s, 4): first node and the numbers of nodes along x, y, z; frame (s, 4): low corner and
    spacing; range (s, 3): first box, the one behind the last, first triangle. values (n, 4): d and
    ∇d at the nodes; kinked (n,): of the cell whose low corner the node is. The rest is that of the
    surfaces' trees, see `nearest.Tree`; kernels take flat tuples only.
    """

    grid: np.ndarray
    frame: np.ndarray
    range: np.ndarray
    values: np.ndarray
    kinked: np.ndarray
    boxes: np.ndarray
    links: np.ndarray
    corners: np.ndarray
    normals: np.ndarray


NO_SAMPLES = Samples(
    np.zeros((0, 4), np.int64),
    np.zeros((0, 4)),
    np.zeros((0, 3), np.int64),
    np.zeros((0, 4), np.float32),
    np.zeros(0, np.bool_),
    np.zeros((0, 6)),
    np.zeros((0, 3), np.int64),
    np.zeros((0, 9)),
    np.zeros((0, 7, 3)),
)


@dataclass(frozen=True, eq=False)
class Surface:
    """A closed surface: its corners (v, 3) and triangles (t, 3), what it encloses, its samples.

    volume, first = ∫r dV and second = ∫rrᵀ dV about the origin; depth, radius of the largest ball
    about a node that lies inside.
    """

    vertices: np.ndarray
    faces: np.ndarray
    volume: float
    first: np.ndarray
    second: np.ndarray
    depth: float
    samples: Samples


def joined(surfaces: Sequence[Surface]) -> Samples:
    """The samples of several surfaces in one table, row m for surfaces[m]."""
    if not surfaces:
        return NO_SAMPLES
    if len(surfaces) == 1:
        return surfaces[0].samples
    tables = [surface.samples for surface in surfaces]
    grid, ranges = [], []
    nodes, boxes, triangles = 0, 0, 0
    for table in tables:
        grid.append(table.grid + np.array([nodes, 0, 0, 0]))
        ranges.append(table.range + np.array([boxes, boxes, triangles]))
        nodes += len(table.values)
        boxes += len(table.boxes)
        triangles += len(table.corners)
    columns = Samples(*(np.concatenate(column) for column in zip(*tables, strict=True)))
    return columns._replace(grid=np.concatenate(grid), range=np.concatenate(ranges))


def sample(vertices: np.ndarray, faces: np.ndarray) -> tuple[Samples, np.ndarray]:
    """The samples of a closed surface, and its winding number at each node (nx, ny, nz).

    The winding number is 1 inside and 0 outside of a surface that does not cross itself.
    """
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    sides = high - low
    margin = MARGIN * np.cbrt(np.prod(sides))
    spacing = float(np.cbrt(np.prod(sides + 2.0 * margin) / NODES))
    counts = np.ceil((sides + 2.0 * margin) / spacing).astype(np.int64) + 1
    start = 0.5 * (low + high) - 0.5 * spacing * (counts - 1)
    tree = tree_of(vertices, faces)
    samples = Samples(
        np.array([[0, *counts]], dtype=np.int64),
        np.array([[*start, spacing]]),
        np.array([[0, len(tree.boxes), 0]], dtype=np.int64),
        np.empty((int(np.prod(counts)), 4), np.float32),
        np.zeros(int(np.prod(counts)), np.bool_),
        *tree,
    )
    _fill_samples(samples.values, samples)
    _mark_kinks(samples.kinked, samples, KINK * spacing)
    winding = np.zeros(counts, np.int32)
    _count_crossings(winding, start, spacing, vertices, faces)
    return samples, np.cumsum(winding[:, :, ::-1], axis=2)[:, :, ::-1]


@njit(error_model="numpy")
def exact_distance(s: Samples, m: int, x: float, y: float, z: float) -> float:
    """d of surface m at (x, y, z), from its nearest triangle."""
    h, ny, nz = s.frame[m, 3], s.grid[m, 2], s.grid[m, 3]
    i = min(max(int((x - s.frame[m, 0]) / h), 0), s.grid[m, 1] - 2)
    j = min(max(int((y - s.frame[m, 1]) / h), 0), ny - 2)
    k = min(max(int((z - s.frame[m, 2]) / h), 0), nz - 2)
    a = x - (s.frame[m, 0] + i * h)
    b = y - (s.frame[m, 1] + j * h)
    c = z - (s.frame[m, 2] + k * h)
    reach = _nearest_foot(s.values, s.grid[m, 0] + (i * ny + j) * nz + k, ny, nz, a, b, c, h)
    first, last, base = s.range[m]
    return nearest(s, first, last, base, x, y, z, reach)[0]


@njit(error_model="numpy")
def _nearest_foot(values, at, ny, nz, a, b, c, h):
    """min |x − (x_c − d_c ∇d_c)| over the corners of a cell: there lies a place of the surface.

    (a, b, c) from the low corner of the cell, which is node `at`, to x.
    """
    best = math.inf
    for i in range(2):
        for j in range(2):
            for k in range(2):
                n = at + (i * ny + j) * nz + k
                d = float(values[n, 0])
                ux = a - i * h + d * values[n, 1]
                uy = b - j * h + d * values[n, 2]
                uz = c - k * h + d * values[n, 3]
                best = min(best, ux * ux + uy * uy + uz * uz)
    # The samples are of single precision.
    return math.sqrt(best) * (1.0 + ROUND_OFF) + ROUND_OFF * h * ny


@njit(error_model="numpy")
def sampled_distance(s: Samples, m: int, x: float, y: float, z: float) -> float:
    """d of surface m at (x, y, z) from the samples around it, exact where they kink."""
    h, nx, ny, nz = s.frame[m, 3], s.grid[m, 1], s.grid[m, 2], s.grid[m, 3]
    fx = (x - s.frame[m, 0]) / h
    fy = (y - s.frame[m, 1]) / h
    fz = (z - s.frame[m, 2]) / h
    px = min(max(fx, 0.0), nx - 1.0)
    py = min(max(fy, 0.0), ny - 1.0)
    pz = min(max(fz, 0.0), nz - 1.0)
    i, j, k = min(int(px), nx - 2), min(int(py), ny - 2), min(int(pz), nz - 2)
    at = s.grid[m, 0] + (i * ny + j) * nz + k
    beyond = px != fx or py != fy or pz != fz
    if s.kinked[at] and not beyond:
        return exact_distance(s, m, x, y, z)
    d, gx, gy, gz = _interpolated(s.values, at, ny, nz, px - i, py - j, pz - k, h)
    if not beyond:
        return d
    # From the place on the box's side to its foot on the surface, and from there to the point.
    ux, uy, uz = (fx - px) * h + d * gx, (fy - py) * h + d * gy, (fz - pz) * h + d * gz
    return math.sqrt(ux * ux + uy * uy + uz * uz)


@njit(error_model="numpy")
def _interpolated(values, at, ny, nz, a, b, c, h):
    """d and ∇d at the fractions a, b, c of the cell whose low corner is node `at`."""
    d, gx, gy, gz = 0.0, 0.0, 0.0, 0.0
    for i in range(2):
        wi, p = (a, a - 1.0) if i else (1.0 - a, a)
        for j in range(2):
            wj, q = (b, b - 1.0) if j else (1.0 - b, b)
            n, w0, w1 = at + (i * ny + j) * nz, wi * wj * (1.0 - c), wi * wj * c
            x0, y0, z0 = values[n, 1], values[n, 2], values[n, 3]
            x1, y1, z1 = values[n + 1, 1], values[n + 1, 2], values[n + 1, 3]
            low = values[n, 0] + 0.5 * h * (p * x0 + q * y0 + c * z0)
            high = values[n + 1, 0] + 0.5 * h * (p * x1 + q * y1 + (c - 1.0) * z1)
            d += w0 * low + w1 * high
            gx, gy, gz = gx + w0 * x0 + w1 * x1, gy + w0 * y0 + w1 * y1, gz + w0 * z0 + w1 * z1
    return d, gx, gy, gz


@njit(parallel=True, cache=True, error_model="numpy")
def _fill_samples(values, s):
    """d and ∇d of the first surface at its nodes, each search bounded by the node before."""
    nx, ny, nz = s.grid[0, 1], s.grid[0, 2], s.grid[0, 3]
    h, boxes = s.frame[0, 3], s.boxes.shape[0]
    for i in prange(nx):
        x = s.frame[0, 0] + i * h
        for j in range(ny):
            y = s.frame[0, 1] + j * h
            reach = math.inf
            for k in range(nz):
                z = s.frame[0, 2] + k * h
                d, gx, gy, gz = nearest(s, 0, boxes, 0, x, y, z, reach)
                v = values[(i * ny + j) * nz + k]
                v[0], v[1], v[2], v[3] = d, gx, gy, gz
                # The foot of this node's perpendicular is a place of the surface.
                reach = math.sqrt(d * d + 2.0 * d * gz * h + h * h) + ROUND_OFF * h


@njit(parallel=True, cache=True, error_model="numpy")
def _mark_kinks(kinked, s, tolerance):
    """Mark the cells of the first surface in which the interpolation misses."""
    nx, ny, nz = s.grid[0, 1], s.grid[0, 2], s.grid[0, 3]
    for i in prange(nx - 1):
        for j in range(ny - 1):
            for k in range(nz - 1):
                at = (i * ny + j) * nz + k
                miss = max(_rise_missed(s, at), _middle_missed(s, i, j, k))
                kinked[at] = miss > tolerance


@njit(error_model="numpy")
def _rise_missed(s, at):
    """max |d_b − d_a − h(∇d_a + ∇d_b)/2| along the edges of a cell: kinks off the middle."""
    ny, nz, h, miss = s.grid[0, 2], s.grid[0, 3], s.frame[0, 3], 0.0
    for axis in range(3):
        step = ny * nz if axis == 0 else (nz if axis == 1 else 1)
        one = ny * nz if axis != 0 else nz
        two = 1 if axis != 2 else nz
        for m in range(4):
            a = at + (m & 1) * one + (m >> 1) * two
            rise = 0.5 * h * (s.values[a, 1 + axis] + s.values[a + step, 1 + axis])
            miss = max(miss, abs(s.values[a + step, 0] - s.values[a, 0] - rise))
    return miss


@njit(error_model="numpy")
def _middle_missed(s, i, j, k):
    """|d − interpolation| at the middle of a cell: kinks there."""
    ny, nz, h = s.grid[0, 2], s.grid[0, 3], s.frame[0, 3]
    at = (i * ny + j) * nz + k
    x = s.frame[0, 0] + (i + 0.5) * h
    y = s.frame[0, 1] + (j + 0.5) * h
    z = s.frame[0, 2] + (k + 0.5) * h
    d = exact_distance(s, 0, x, y, z)
    return abs(_interpolated(s.values, at, ny, nz, 0.5, 0.5, 0.5, h)[0] - d)


@njit(cache=True, error_model="numpy")
def _count_crossings(change, start, h, vertices, faces):
    """change[i, j, k] += ±1 for each triangle that column (i, j) crosses above node k, below k+1.

    + where the triangle faces up. Whether a column passes left or right of an edge is decided by
    the edge alone, as if columns stood off the nodes by (ε, ε²): neighbours agree, no gap is left.
    """
    nx, ny, nz = change.shape
    for t in range(faces.shape[0]):
        a, b, c = vertices[faces[t, 0]], vertices[faces[t, 1]], vertices[faces[t, 2]]
        lows = (min(a[0], b[0], c[0]), min(a[1], b[1], c[1]))
        highs = (max(a[0], b[0], c[0]), max(a[1], b[1], c[1]))
        i0, i1 = math.ceil((lows[0] - start[0]) / h), math.floor((highs[0] - start[0]) / h)
        j0, j1 = math.ceil((lows[1] - start[1]) / h), math.floor((highs[1] - start[1]) / h)
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        for i in range(max(i0 - 1, 0), min(i1 + 2, nx)):
            x = start[0] + i * h
            for j in range(max(j0 - 1, 0), min(j1 + 2, ny)):
                y = start[1] + j * h
                side = _left_of(a, b, x, y)
                if side != _left_of(b, c, x, y) or side != _left_of(c, a, x, y) or area == 0.0:
                    continue
                u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
                v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
                z = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
                k = min(math.floor((z - start[2]) / h), nz - 1)
                if k >= 0:
                    change[i, j, k] += 1 if side else -1


@njit(error_model="numpy")
def _left_of(a, b, x, y):
    """Whether the point lies left of the way from a to b, in the plane of x and y."""
    turned = a[0] > b[0] or (a[0] == b[0] and a[1] > b[1])
    p, q = (b, a) if turned else (a, b)
    ux, uy = q[0] - p[0], q[1] - p[1]
    e = ux * (y - p[1]) - uy * (x - p[0])
    if e == 0.0:
        e = -uy if uy != 0.0 else ux
    return (e > 0.0) != turned
