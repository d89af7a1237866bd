"""Painting: the indicator φ of each body at the velocity points of its window.

    φ = φ(d(x)/ξ),   d = min over the parts of d_part − offset₀ − offset₁(κ₁+κ₂)

The cost is proportional to the painted volume.
"""

import math
from dataclasses import replace

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.distances import CAPSULE, ELLIPSOID, MESH, SPHERE, curvature, signed_distance
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState, Forms
from smoothprofile.particles.windows import Windows, windows_around
from smoothprofile.profiles import Profile, indicator, profile_named
from smoothprofile.surfaces import sampled_distance

THINNEST = 0.75
"""Cells to ξ (tanh) below which sums over the grid no longer find a volume to 1e-3 of a cell."""


class Painter:
    """Paints bodies of given forms with one profile and thickness ξ on one grid."""

    def __init__(
        self,
        grid: Grid,
        boundaries: tuple[FieldBoundary, ...],
        forms: Forms,
        profile: Profile,
        thickness: float,
    ):
        self.grid, self.forms, self.profile, self.thickness = grid, forms, profile, thickness
        self._boundaries = boundaries
        self._points = [np.stack([a.padded_centres, a.padded_faces]) for a in grid.axes]
        self.windows: Windows | None = None
        self.indicator = np.empty(0, grid.dtype)
        self._painted_at: tuple[np.ndarray, np.ndarray] | None = None

    def sharpened(self) -> "Painter":
        """One that paints the surfaces where they truly are, as thin as the cells allow."""
        forms = replace(self.forms, offset=np.zeros_like(self.forms.offset))
        cell = min(float(axis.widths.min()) for axis in self.grid.axes)
        thickness = min(self.thickness, THINNEST * cell)
        return Painter(self.grid, self._boundaries, forms, profile_named("tanh"), thickness)

    def paint(self, state: BodyState) -> None:
        """Bring windows and φ to where the bodies are; nothing to do for bodies that stayed."""
        if self._painted_at is not None and all(
            np.array_equal(old, new)
            for old, new in zip(self._painted_at, (state.position, state.quaternion), strict=True)
        ):
            return
        rotation = state.rotation
        self.windows = windows_around(
            self.grid, self._boundaries, state.position, self.half_sides(rotation)
        )
        if self.indicator.size < self.windows.points:
            self.indicator = np.empty(self.windows.points, self.grid.dtype)
        f = self.forms
        _paint(
            self.indicator,
            *self.table(),
            state.position,
            rotation,
            f.part_start,
            f.kind,
            f.size,
            f.place,
            f.turn,
            f.offset,
            f.samples,
            self.profile.code,
            self.thickness,
            self.profile.half_width,
        )
        self._painted_at = (state.position.copy(), state.quaternion.copy())

    def half_sides(self, rotation: np.ndarray) -> np.ndarray:
        """(n,3) half sides of the boxes that hold everything painted."""
        extents = self.forms.extents[:, None, :]
        tilted = np.where(np.abs(rotation) > 1e-14, np.abs(rotation), 0.0)
        with np.errstate(invalid="ignore"):
            reach = np.where(tilted > 0.0, tilted * extents, 0.0).sum(axis=2)
        grown = np.zeros(rotation.shape[0])
        if grown.size:
            grown = np.maximum(0.0, np.maximum.reduceat(self.growth(), self.forms.part_start[:-1]))
        return reach + (grown + self.profile.half_width * self.thickness)[:, None]

    def growth(self) -> np.ndarray:
        """(parts,) the most by which the painted surface lies outside the true one."""
        kind, size, offset = self.forms.kind, self.forms.size, self.forms.offset
        smallest = np.where(size > 0, size, np.inf).min(axis=1, initial=np.inf)
        largest = np.where(np.isfinite(size), size, 0.0).max(axis=1, initial=0.0)
        # κ₁+κ₂ is at most twice that of the sharpest tip, of radius (smallest²/largest).
        tip = np.where(kind == ELLIPSOID, largest / smallest**2, 1.0 / smallest)
        return offset[:, 0] + np.maximum(0.0, offset[:, 1] * 2.0 * tip)

    def dense(self, component: int) -> np.ndarray:
        """φ of all bodies at one component's points, as a padded field."""
        field = self.grid.zeros()
        for body in range(self.windows.first.shape[0]):
            block, places, _ = self._block(body, component)
            np.add.at(field, np.ix_(*places), block)
        return field

    def moments(self, state: BodyState, body: int) -> tuple[float, np.ndarray, np.ndarray]:
        """∫φ dV, ∫φr dV (3,) and ∫φrr dV (3,3) of one body, the mean over the components.

        r is counted from the body's position, along the box's axes.
        """
        zeroth, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
        for c in range(3):
            phi, places, images = self._block(body, c)
            r, sizes = [], []
            for d, axis in enumerate(self.grid.axes):
                on_face = int(d == c)
                r.append(self._points[d][on_face, places[d]] + images[d] * axis.length)
                r[d] -= state.position[body, d]
                sizes.append((axis.padded_distances if on_face else axis.padded_widths)[places[d]])
                if on_face and not axis.periodic:
                    # Wall faces carry no unknown: their half cells count with the next faces.
                    for end, wall in ((0, 2), (-1, self.grid.shape[d])):
                        if places[d].size and places[d][end] == wall:
                            sizes[d][end] += 0.5 * axis.padded_widths[1 if end == 0 else wall]
            mass = phi * sizes[0][:, None, None] * sizes[1][:, None] * sizes[2] / 3
            points = np.stack(np.meshgrid(*r, indexing="ij"))
            zeroth += mass.sum()
            first += np.einsum("ijk,aijk->a", mass, points)
            second += np.einsum("ijk,aijk,bijk->ab", mass, points, points)
        return float(zeroth), first, second

    def _block(self, body: int, component: int) -> tuple[np.ndarray, list, list]:
        """φ in one window, and of its points along each axis the padded indices and the images."""
        w = self.windows
        shape, at = w.count[body, component], w.start[body, component]
        block = self.indicator[at : at + shape.prod()].reshape(shape)
        places, images = [], []
        for d, n in enumerate(self.grid.shape):
            index = w.first[body, component, d] - 1 + np.arange(shape[d])
            places.append(index % n + 1)
            images.append(index // n + w.image[body, component, d])
        return block, places, images

    def centred(self) -> np.ndarray:
        """(nx,ny,nz): φ at the cell centres, the mean over the six faces of each cell."""
        total = np.zeros(self.grid.shape)
        for c in range(3):
            f = np.moveaxis(self.dense(c), c, 0)
            if self.grid.axes[c].periodic:
                f[-1] = f[1]
            else:
                # The wall faces carry no unknown and are not painted.
                f[1], f[-1] = f[2], f[-2]
            total += np.moveaxis(0.5 * (f[1:-1] + f[2:])[:, 1:-1, 1:-1], 0, c)
        return np.clip(total / 3.0, 0.0, 1.0)

    def table(self) -> tuple:
        """What every loop over windows needs: the boxes and the coordinates of their points."""
        w = self.windows
        lengths = np.array(self.grid.lengths)
        return w.task, w.first, w.count, w.image, w.start, *self._points, lengths


@njit(parallel=True, cache=True, error_model="numpy")
def _paint(
    phi, task, first, count, image, start, px, py, pz, lengths,
    position, rotation, part_start, kind, size, place, turn, offset, samples, code, xi,
    half_width,
):  # fmt: skip
    for t in prange(task.shape[0]):
        b, c, i = task[t]
        x = coordinate(px, c == 0, first[b, c, 0] + i, image[b, c, 0], lengths[0]) - position[b, 0]
        ny, nz = count[b, c, 1], count[b, c, 2]
        r, begin, end = rotation[b], part_start[b], part_start[b + 1]
        z = np.empty(nz)
        for k in range(nz):
            z[k] = coordinate(pz, c == 2, first[b, c, 2] + k, image[b, c, 2], lengths[2])
            z[k] -= position[b, 2]
        ball = end - begin == 1 and kind[begin] == SPHERE
        if ball:
            # Only its distance counts, so that the body need not be turned.
            shift = r @ place[begin]
            radius = size[begin, 0] + offset[begin, 0]
        for j in range(ny):
            y = coordinate(py, c == 1, first[b, c, 1] + j, image[b, c, 1], lengths[1])
            y -= position[b, 1]
            at = start[b, c] + (i * ny + j) * nz
            row = phi[at : at + nz]
            if ball:
                across = (x - shift[0]) ** 2 + (y - shift[1]) ** 2
                _ball_row(row, z, shift[2], across, radius, code, xi, half_width)
                continue
            for k in range(nz):
                d = body_distance(
                    r[0, 0] * x + r[1, 0] * y + r[2, 0] * z[k],
                    r[0, 1] * x + r[1, 1] * y + r[2, 1] * z[k],
                    r[0, 2] * x + r[1, 2] * y + r[2, 2] * z[k],
                    begin, end, kind, size, place, turn, offset, samples,
                )  # fmt: skip
                row[k] = _cut_off(code, d / xi, half_width)


@njit
def _ball_row(row, z, centre, across, radius, code, xi, half_width):
    """φ of a sphere along z: most points need no root."""
    outer = radius + half_width * xi
    inner = max(0.0, radius - half_width * xi)
    for k in range(z.size):
        square = across + (z[k] - centre) ** 2
        if square >= outer * outer:
            row[k] = 0.0
        elif square < inner * inner:
            row[k] = 1.0
        else:
            row[k] = _cut_off(code, (math.sqrt(square) - radius) / xi, half_width)


@njit(inline="always")
def _cut_off(code, s, half_width):
    """φ(s), 0 and 1 beyond the layer."""
    if s > half_width:
        return 0.0
    if s < -half_width:
        return 1.0
    return indicator(code, s)


@njit(inline="always")
def coordinate(points, on_face, index, image, length):
    """Coordinate of padded index `index`, which may run on through the periods of the axis."""
    n = points.shape[1] - 2
    while index > n:
        index -= n
        image += 1
    return points[1 if on_face else 0, index] + image * length


@njit(inline="always")
def wrap(index, n):
    """The padded index within the box."""
    while index > n:
        index -= n
    return index


@njit
def body_distance(x, y, z, begin, end, kind, size, place, turn, offset, samples=None):
    nearest = math.inf
    for p in range(begin, end):
        m = turn[p]
        dx, dy, dz = x - place[p, 0], y - place[p, 1], z - place[p, 2]
        a = m[0, 0] * dx + m[1, 0] * dy + m[2, 0] * dz
        b = m[0, 1] * dx + m[1, 1] * dy + m[2, 1] * dz
        c = m[0, 2] * dx + m[1, 2] * dy + m[2, 2] * dz
        d = signed_distance(kind[p], size[p, 0], size[p, 1], size[p, 2], a, b, c)
        # Compiled away where there are no samples.
        if samples is not None:  # noqa: SIM102
            if kind[p] >= MESH:
                d = sampled_distance(samples, kind[p] - MESH, a, b, c)
        d -= offset[p, 0]
        if offset[p, 1] != 0.0 and (kind[p] == ELLIPSOID or kind[p] == CAPSULE):
            d -= offset[p, 1] * curvature(kind[p], size[p, 0], size[p, 1], size[p, 2], a, b, c)
        nearest = min(nearest, d)
    return nearest
