"""The points at which bodies resist the fluid, in one flat array, and what a vector on them is.

    f = Σ_b √χ_b g_b,   √χ_b u,   Z(V, Ω) = √χ_b (V + Ω×r)

χ_b = (μ/ℓ²)φ_b is the resistance of body b. A vector g has one number for each painted point of
each body, so that the vectors of different bodies are orthogonal even where their layers overlap.
On stretched axes √χ is shared out by the volumes v of the cells, √(χ/v) on the way to the fluid
and √(χv) on the way back, which keeps the plain sum of products as the inner product.
"""

import numpy as np
from numba import njit, prange

from smoothprofile.errors import CaseError
from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.loads import Impulse, vectors
from smoothprofile.particles.paint import Painter
from smoothprofile.particles.painting import by_body
from smoothprofile.particles.stress import cross_matrix, straining
from smoothprofile.particles.windows import plane_of

SINGULAR = 1e-12
"""Of the largest eigenvalue of ZᵀZ, its diagonal scaled to one so that no unit of length counts:
below it, a body's points do not tell its motions apart."""


class BodyLayers:
    """All bodies' points, painted by `painter`, with the resistance μ/ℓ² of their insides."""

    def __init__(
        self,
        painter: Painter,
        resistance: float,
        compliance: np.ndarray | None = None,
        viscosity: float = 1.0,
    ):
        """compliance (n,3): V/F, Ω/T and E/S that bodies have besides, times the viscosity."""
        self.painter, self.resistance = painter, float(resistance)
        # ∫f dV is this times Σ√χ g.
        self.cell = painter.grid.volume / painter.grid.cell_count
        self._impulse = Impulse(painter.grid)
        given = compliance is not None and np.any(compliance)
        self.compliance = np.asarray(compliance, float) / viscosity if given else None

    def paint(self, state: BodyState) -> None:
        """Bring the points to where the bodies are; a vector before has no meaning after."""
        self.painter.paint(state)
        w = self.painter.windows
        self.size, self.count = w.points, state.count
        root = np.sqrt(self.resistance * self.painter.indicator[: w.points])
        self.down = self.up = root
        if not all(axis.uniform for axis in self.painter.grid.axes):
            volume = np.empty(w.points)
            _volumes(volume, w, 1.0 / self.cell)
            np.sqrt(volume, out=volume)
            self.up, self.down = root * volume, root / volume
        self.gram = self._impulse.matrix(self.painter) * (self.resistance / self.cell)
        self.totals = self.gram[:, range(3), range(3)]
        diagonal = np.sqrt(np.diagonal(self.gram, axis1=1, axis2=2))
        scale = np.divide(1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal > 0.0)
        sizes = np.linalg.eigvalsh(scale[:, :, None] * self.gram * scale[:, None, :])
        for body in np.flatnonzero(~(sizes[:, 0] > SINGULAR * sizes[:, -1]))[:1]:
            raise CaseError(
                f"particles.{body} meets no points of the grid that could move and turn it; a body "
                f"in Stokes flow must lie in the box and be some cells across."
            )
        self.inverse = np.linalg.inv(self.gram)

    def spread(self, g: np.ndarray, fields: tuple) -> None:
        """f += √χ g."""
        w = self.painter.windows
        for c, field in enumerate(fields):
            _spread(field, self.down, g, w, w.part[c], w.part[c + 1])

    def gather(self, fields: tuple, g: np.ndarray, out: np.ndarray, factor: float = 1.0) -> None:
        """out = g + factor·√χ u; `out` may be g."""
        w = self.painter.windows
        for c, field in enumerate(fields):
            _gather(out, self.up, g, w, w.part[c], w.part[c + 1], field, factor)

    def moments(self, g: np.ndarray) -> np.ndarray:
        """Σ√χ g and Σ√χ g r (n,3,4) of each body; times `cell`, ∫f dV and ∫f r dV."""
        w = self.painter.windows
        sums = np.empty((w.task.shape[0], 4))
        _moments(sums, self.up, g, w)
        return by_body(w.task, sums, self.count)

    def add_linear(self, g: np.ndarray, velocity: np.ndarray, slope: np.ndarray) -> None:
        """g += √χ (V + A r), V (n,3), A (n,3,3)."""
        _add_linear(g, self.up, self.painter.windows, velocity, slope)

    def comply(self, g: np.ndarray, out: np.ndarray) -> None:
        """out += √χ (V + Ω×r + E·r), what the loads of g make of bodies by their compliance."""
        if self.compliance is not None:
            self.add_linear(out, *self.yielding(self.moments(g)))

    def yielding(self, moments: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """V (n,3) and ∂(Ω×r + E·r)/∂r (n,3,3) that `moments` make of bodies by their compliance."""
        if self.compliance is None:
            return np.zeros((self.count, 3)), np.zeros((self.count, 3, 3))
        velocity, turn, strain = (self.cell * self.compliance).T[..., None]
        slope = strain[..., None] * straining(moments[:, :, 1:])
        slope += cross_matrix(turn * vectors(moments)[:, 3:])
        return np.ascontiguousarray(velocity * moments[:, :, 0]), slope


@njit(parallel=True, cache=True)
def _spread(field, root, g, w, first, last):
    for a in prange(first, last):
        plane = field[plane_of(w, w.group[a])].reshape(-1)
        at = w.start[w.group[a]]
        for m in range(w.run[w.group[a]], w.run[w.group[a + 1]]):
            h = w.place[m]
            for k in range(w.length[m]):
                plane[h + k] += root[at + k] * g[at + k]
            at += w.length[m]


@njit(parallel=True, cache=True)
def _gather(out, root, g, w, first, last, field, factor):
    for a in prange(first, last):
        plane = field[plane_of(w, w.group[a])].reshape(-1)
        at = w.start[w.group[a]]
        for m in range(w.run[w.group[a]], w.run[w.group[a + 1]]):
            h = w.place[m]
            for k in range(w.length[m]):
                out[at + k] = g[at + k] + factor * root[at + k] * plane[h + k]
            at += w.length[m]


@njit(parallel=True, cache=True)
def _moments(sums, root, g, w):
    for t in prange(w.task.shape[0]):
        b, c, i = w.task[t]
        at = w.start[t]
        s, sy, sz = 0.0, 0.0, 0.0
        for m in range(w.run[t], w.run[t + 1]):
            z, p, pz = w.z[m], 0.0, 0.0
            for k in range(w.length[m]):
                q = root[at + k] * g[at + k]
                p += q
                pz += q * w.arm[z + k]
            at += w.length[m]
            s, sy, sz = s + p, sy + w.arm[w.y[m]] * p, sz + pz
        x = w.arm[w.axis[b, c, 0] + i]
        sums[t, 0], sums[t, 1], sums[t, 2], sums[t, 3] = s, x * s, sy, sz


@njit(parallel=True, cache=True)
def _add_linear(g, root, w, velocity, slope):
    for t in prange(w.task.shape[0]):
        b, c, i = w.task[t]
        base, at = velocity[b, c] + slope[b, c, 0] * w.arm[w.axis[b, c, 0] + i], w.start[t]
        for m in range(w.run[t], w.run[t + 1]):
            z, here = w.z[m], base + slope[b, c, 1] * w.arm[w.y[m]]
            for k in range(w.length[m]):
                g[at + k] += root[at + k] * (here + slope[b, c, 2] * w.arm[z + k])
            at += w.length[m]


@njit(parallel=True, cache=True)
def _volumes(out, w, scale):
    for t in prange(w.task.shape[0]):
        b, c, i = w.task[t]
        dx, at = scale * w.width[w.axis[b, c, 0] + i], w.start[t]
        for m in range(w.run[t], w.run[t + 1]):
            z, area = w.z[m], dx * w.width[w.y[m]]
            for k in range(w.length[m]):
                out[at + k] = area * w.width[z + k]
            at += w.length[m]
