"""No-slip walls as thin layers that resist the fluid in a box whose walls slip.

    f = χ_w (U_w − u),   χ_w = 2μ/h²

at the tangential velocities in the cells beside a wall, h the width of those cells: this is all in
which ∇² differs between a wall that holds the fluid, with 2U_w − u beyond it, and one that lets it
slip, with u. So a no-slip wall is one more body in the problem of `stokes`, without error, and the
direct solve, which needs walls that slip, serves any box.

The preconditioner of one pair of walls is the inverse of (1 + √χ_w 𝒮 √χ_w) for them alone, with 𝒮
without pressure, which is diagonal in the bases along the walls:

    𝒮_ij = Σ_m q_mi q_mj/(μ(λ + λ_m)),   λ of the bases along, q_m and λ_m of that across the wall.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from smoothprofile.grid import Grid
from smoothprofile.transforms import Basis, basis_for, second_difference
from smoothprofile.viscous.direct import DirectStokes


@dataclass(frozen=True, eq=False)
class _Plane:
    """One tangential component at both walls of one axis.

    at: where in a vector, (n along the rest, with 2 along the axis); points: padded slices of the
    two layers; up, down: √χ_w v^±½, zero at a wall that slips; bases by axis; inverse: entries 00,
    01 and 11 of the 2×2 inverse for each mode.
    """

    axis: int
    component: int
    at: slice
    shape: tuple[int, int, int]
    points: tuple
    up: np.ndarray
    down: np.ndarray
    width: np.ndarray
    bases: dict[int, Basis]
    inverse: tuple[np.ndarray, np.ndarray, np.ndarray]


class WallLayers:
    """All no-slip walls of a box; no walls is a valid instance, of size 0."""

    def __init__(self, grid: Grid, direct: DirectStokes, walls: Sequence):
        self.grid, self.kinds, self._direct = grid, tuple(tuple(pair) for pair in walls), direct
        self.cell = grid.volume / grid.cell_count
        self.size = 0
        self._planes: list[_Plane] = []
        for axis in range(3):
            kinds = self.kinds[axis]
            if grid.axes[axis].periodic or "wall" not in kinds:
                continue
            for component in range(3):
                if component != axis:
                    self._add(axis, component, kinds)
        self.totals = np.zeros(3)
        for p in self._planes:
            self.totals[p.component] += float((p.up**2).sum())

    def spread(self, g: np.ndarray, fields: tuple) -> None:
        """f += √χ g."""
        for p in self._planes:
            layers, added = fields[p.component][p.points], p.down * g[p.at].reshape(p.shape)
            # Both walls of an axis of one cell hold that cell.
            layers += added if layers.shape == p.shape else added.sum(axis=p.axis, keepdims=True)

    def gather(self, fields: tuple, g: np.ndarray, out: np.ndarray, factor: float = 1.0) -> None:
        """out = g + factor·√χ u; `out` may be g."""
        for p in self._planes:
            added = g[p.at].reshape(p.shape) + factor * p.up * fields[p.component][p.points]
            out[p.at] = added.reshape(-1)

    def sums(self, g: np.ndarray) -> np.ndarray:
        """Σ√χ g of each wall (3,2,3), by axis, side and component."""
        found = np.zeros((3, 2, 3))
        for p in self._planes:
            along = tuple(d for d in range(3) if d != p.axis)
            found[p.axis, :, p.component] = (p.up * g[p.at].reshape(p.shape)).sum(axis=along)
        return found

    def forces(self, g: np.ndarray) -> np.ndarray:
        """∫f dV (3,2,3), the force of each wall on the fluid, along it."""
        return self.cell * self.sums(g)

    def add_uniform(self, g: np.ndarray, velocity: np.ndarray) -> None:
        """g += √χ U_w, U_w (3,2,3)."""
        for p in self._planes:
            sides = np.moveaxis(velocity[p.axis, :, p.component].reshape(2, 1, 1), 0, p.axis)
            g[p.at] += (p.up * sides).reshape(-1)

    def precondition(self, r: np.ndarray, out: np.ndarray) -> None:
        """out = (1 + √χ 𝒮 √χ)⁻¹ r, each component of each pair of walls alone, without pressure."""
        for p in self._planes:
            # The bases are orthogonal to the cells' widths along the wall, vectors to their roots.
            modes = r[p.at].reshape(p.shape) / p.width
            for d, basis in p.bases.items():
                basis.forward(modes, d)
            low, high = np.take(modes, [0], axis=p.axis), np.take(modes, [1], axis=p.axis)
            a, b, c = p.inverse
            modes = np.concatenate([a * low + b * high, b * low + c * high], axis=p.axis)
            for d, basis in p.bases.items():
                basis.backward(modes, d)
            out[p.at] = (modes * p.width).reshape(-1)

    def _add(self, axis: int, component: int, kinds: tuple) -> None:
        grid, boundary = self.grid, self._direct.boundaries[component]
        n = grid.shape[axis]
        points = list(boundary.unknowns(grid))
        # The two layers as one slice.
        points[axis] = slice(1, n + 1, n - 1) if n > 1 else slice(1, 2)
        along = [d for d in range(3) if d != axis]
        shape = [s.stop - s.start for s in points]
        shape[axis] = 2
        if min(shape) == 0:
            return
        widths = grid.axes[axis].padded_widths[[1, n]]
        strength = np.array([kind == "wall" for kind in kinds]) * 2.0 / widths**2
        root = np.sqrt(self._direct.viscosity * strength)
        width = np.full((1, 1, 1), math.sqrt(1.0 / self.cell))
        for d in along:
            a = grid.axes[d]
            sizes = a.padded_distances if d == component else a.padded_widths
            width = width * np.sqrt(sizes[points[d]]).reshape(_line(d))
        volume = width * np.sqrt(widths).reshape(_line(axis))
        across = root.reshape(_line(axis))
        bases = {d: basis_for(grid, boundary, d) for d in along}
        self._planes.append(
            _Plane(
                axis=axis,
                component=component,
                at=slice(self.size, self.size + int(np.prod(shape))),
                shape=tuple(shape),
                points=tuple(points),
                up=across * volume,
                down=across / volume,
                width=width,
                bases=bases,
                inverse=self._inverse(axis, component, strength, bases),
            )
        )
        self.size += int(np.prod(shape))

    def _inverse(self, axis: int, component: int, strength: np.ndarray, bases: dict) -> tuple:
        """The inverse of δ_ij + √(s_i s_j) Σ_m q_mi q_mj/(λ + λ_m), i, j the two walls."""
        boundary = self._direct.boundaries[component]
        difference = second_difference(self.grid.axes[axis], boundary, axis)
        root = np.sqrt(difference.weights)
        symmetric = difference.dense() * root[:, None] / root[None, :]
        across, vectors = scipy.linalg.eigh(0.5 * (symmetric + symmetric.T))
        ends = vectors[[0, -1]] * np.sqrt(strength)[:, None]
        along = np.zeros(())
        for d, basis in bases.items():
            along = along + basis.eigenvalues.reshape(_line(d))
        small = 1e-12 * across.max()
        entries = [np.zeros(along.shape) for _ in range(3)]
        for m, own in enumerate(across):
            total = along + own
            response = np.where(total > small, 1.0 / np.where(total > small, total, 1.0), 0.0)
            for entry, (i, j) in zip(entries, ((0, 0), (0, 1), (1, 1)), strict=True):
                entry += ends[i, m] * ends[j, m] * response
        a, b, c = entries[0] + 1.0, entries[1], entries[2] + 1.0
        scale = np.prod([basis.norm for basis in bases.values()]) * (a * c - b * b)
        return c / scale, -b / scale, a / scale


def _line(axis: int) -> list[int]:
    """The shape of a line along that axis."""
    return [-1 if d == axis else 1 for d in range(3)]
