"""Painting: the indicator φ of each body at the velocity points of its window.

    φ = φ(d(x)/ξ),   d = min over the parts of d_part − offset₀ − offset₁(κ₁+κ₂)

The cost is proportional to the painted volume.
"""

from dataclasses import replace

import numpy as np

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.distances import ELLIPSOID, SPHERE
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState, Forms
from smoothprofile.particles.painting import Parts, add, by_body, fill
from smoothprofile.particles.painting import body_distance as body_distance
from smoothprofile.particles.windows import Memory, Windows, windows_around
from smoothprofile.particles.windows import coordinate as coordinate
from smoothprofile.particles.windows import wrap as wrap
from smoothprofile.profiles import Profile, profile_named

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
        f = forms
        self._parts = Parts(f.part_start, f.kind, f.size, f.place, f.turn, f.offset)
        self.windows: Windows | None = None
        self._memory = Memory()
        self.indicator = np.empty(0, grid.dtype)
        self._painted_at: tuple[np.ndarray, np.ndarray] | None = None

    def sharpened(self) -> "Painter":
        """One that paints the surfaces where they truly are, as thin as the cells allow."""
        forms = replace(self.forms, offset=np.zeros_like(self.forms.offset))
        cell = min(self.grid.smallest_widths)
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
        balls = self._balls(rotation)
        half = np.minimum(self.half_sides(rotation), np.abs(balls[:, :3]) + balls[:, 3:])
        w = windows_around(self.grid, self._boundaries, state.position, half, balls, self._memory)
        self.indicator = self._memory.take("indicator", (w.points,), self.grid.dtype)
        sums = self._memory.take("sums", (w.task.shape[0], 10), np.float64)
        fill(
            self.indicator,
            sums,
            w,
            self._parts,
            self.forms.samples,
            rotation,
            balls,
            self.profile.code,
            self.thickness,
            self.profile.half_width,
        )
        self.windows, self.sums = w, by_body(w.task, sums, state.count)
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

    def _balls(self, rotation: np.ndarray) -> np.ndarray:
        """(n,4) centre from the body's position and radius of all that is painted of a sphere."""
        f, n = self.forms, rotation.shape[0]
        balls = np.zeros((n, 4))
        balls[:, 3] = np.inf
        first = f.part_start[:-1]
        one = np.flatnonzero((np.diff(f.part_start) == 1) & (f.kind[first] == SPHERE))
        part = first[one]
        balls[one, :3] = np.einsum("nij,nj->ni", rotation[one], f.place[part])
        radius = f.size[part, 0] + f.offset[part, 0]
        edge = min(self.profile.edge, self.profile.half_width)
        balls[one, 3] = np.maximum(radius + edge * self.thickness, 0.0)
        return balls

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
        w = self.windows
        add(field, self.indicator, w, *w.part[component : component + 2])
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
        shape = w.count[body, component]
        block = np.zeros(shape)
        for t in np.flatnonzero((w.task[:, :2] == (body, component)).all(axis=1)):
            at = w.start[t]
            for m in range(int(w.run[t]), int(w.run[t + 1])):
                j, k, n = (int(v) for v in (w.y[m], w.z[m], w.length[m]))
                j, k = j - w.axis[body, component, 1], k - w.axis[body, component, 2]
                block[w.task[t, 2], j, k : k + n] = self.indicator[at : at + n]
                at += n
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
