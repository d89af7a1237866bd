"""Gaussian envelopes of the force coupling method, on the velocity points around each sphere.

    Δ(r) = (2πσ²)^(−3/2) e^(−r²/2σ²),   σ_M = a/√π,   σ_D = a/(6√π)^(1/3)
    f_i += F_i Δ_M − D_ij ∂_jΔ_D,   V_i = ∫u_i Δ_M dV,   G_ij = −∫u_i ∂_jΔ_D dV

A force F and a dipole D, ∫f_i r_j dV, of each sphere are spread; its velocity V and velocity
gradient G are averages with the same weights, so that F·V + D:G is the power ∫f·u dV. The two
widths give a lone sphere the drag 6πμaV, the torque 8πμa³Ω and the stresslet (20/3)πμa³E.

An envelope is a product of weights along the three axes, each with Σ w h = 1 and a slope with
Σ w′h = 0 and −Σ w′rh = 1: forces and dipoles are exact to round-off wherever a sphere lies.

On the grid 1/k² becomes (1 + h²Σk_d⁴/12k²)/k², which averages to (1 + h²k²/20)/k²: velocities and
turning rates of lone spheres would be h²/40σ_M² and 3h²/40σ_D² too high. Envelopes that are wider,
σ² + h²/20, undo that.

Maxey & Patel, Int. J. Multiphase Flow 27 (2001); Lomholt & Maxey, J. Comput. Phys. 184 (2003).
"""

import math

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.particles.painting import by_body
from smoothprofile.particles.windows import Windows, plane_of, windows_around
from smoothprofile.viscous.force_coupling_moments import dipole_width, monopole_width

REACH = 5.0
"""Widths σ_M out to which an envelope is evaluated: beyond lie 2e-6 of it."""
FEWEST = 2.0
"""Cells to a radius below which mobilities depend on where a sphere lies between grid points."""


class Envelopes:
    """The envelopes of spheres of given radii, on the velocity points of one grid."""

    def __init__(
        self, grid: Grid, boundaries: tuple[FieldBoundary, ...], radius: np.ndarray | float
    ):
        """boundaries: of the three velocity components. radius: a (n,), or one number."""
        self.grid, self._boundaries = grid, boundaries
        self.radius = np.atleast_1d(np.asarray(radius, dtype=np.float64))
        for axis in grid.axes:
            if not axis.uniform:
                raise CaseError(
                    f"domain.stretching: the force coupling method needs equal cells along "
                    f"{axis.name}."
                )
        widest = max(float(axis.widths.max()) for axis in grid.axes)
        for number in np.flatnonzero(~(self.radius >= FEWEST * widest))[:1]:
            raise CaseError(
                f"particles.{number}.radius is {self.radius[number]:g}; the force coupling method "
                f"needs at least {FEWEST:g} cells to a radius, {FEWEST * widest:g}."
            )
        cell = np.mean([(axis.length / axis.cells) ** 2 for axis in grid.axes])
        widths = np.stack([monopole_width(self.radius), dipole_width(self.radius)])
        self._widths = np.sqrt(widths**2 + cell / 20.0)
        self._windows: Windows | None = None

    @property
    def count(self) -> int:
        return self.radius.size

    def place(self, position: np.ndarray) -> None:
        """Bring the envelopes to the spheres' positions (n,3)."""
        for d, axis in enumerate(self.grid.axes):
            inside = (position[:, d] >= axis.low) & (position[:, d] <= axis.high)
            for number in np.flatnonzero(~(inside | (axis.periodic & np.isfinite(position[:, d]))))[
                :1
            ]:
                raise CaseError(
                    f"particles.{number}.position is {position[number, d]:g} along {axis.name}; "
                    f"it must be between {axis.low:g} and {axis.high:g}."
                )
        reach = np.repeat(REACH * self._widths.max(axis=0)[:, None], 3, axis=1)
        box = np.full((self.count, 4), np.inf)
        w = windows_around(self.grid, self._boundaries, position, reach, box)
        self._weights = np.empty((3, w.arm.size))
        _weigh(self._weights, w.axis, w.count, w.arm, w.width, self._widths)
        self._sums = self._weights * w.width
        self._windows = w

    def spread(self, moments: np.ndarray, fields: tuple) -> None:
        """f_i += F_i Δ_M − D_ij ∂_jΔ_D on the interior; moments (n,3,4) are F_i, D_ix, D_iy, D_iz.

        A torque T is the dipole −½ε_ijk T_k, see `force_coupling_moments`.
        """
        w = self._windows
        for c, field in enumerate(fields):
            _spread(field, moments, self._weights, w, w.part[c], w.part[c + 1])

    def gather(self, velocity: tuple) -> np.ndarray:
        """V_i = ∫u_i Δ_M dV and G_ij = −∫u_i ∂_jΔ_D dV (n,3,4), the adjoint of `spread`."""
        w, found = self._windows, np.zeros((self.count, 3, 4))
        for c, field in enumerate(velocity):
            begin, end = w.group[w.part[c]], w.group[w.part[c + 1]]
            sums = np.empty((end - begin, 4))
            _gather(sums, field, self._sums, w, w.part[c], w.part[c + 1])
            found[:, c] = by_body(w.task[begin:end], sums, self.count)[:, c]
        return found


@njit(parallel=True, cache=True, error_model="numpy")
def _weigh(weights, axis, count, arm, width, sigma):
    """Along each axis of each window Δ_M, Δ_D and −Δ_D′."""
    for b in prange(axis.shape[0]):
        narrow = (0.5 / sigma[0, b] ** 2, 0.5 / sigma[1, b] ** 2)
        for c in range(3):
            for d in range(3):
                begin = axis[b, c, d]
                end = begin + count[b, c, d]
                monopole, dipole, first = 0.0, 0.0, 0.0
                for m in range(begin, end):
                    square = arm[m] * arm[m]
                    weights[0, m] = math.exp(-square * narrow[0])
                    weights[1, m] = math.exp(-square * narrow[1])
                    monopole += weights[0, m] * width[m]
                    dipole += weights[1, m] * width[m]
                    first += weights[1, m] * arm[m] * width[m]
                mean, second = first / dipole, 0.0
                for m in range(begin, end):
                    weights[0, m] /= monopole
                    weights[1, m] /= dipole
                    weights[2, m] = (arm[m] - mean) * weights[1, m]
                    second += weights[2, m] * arm[m] * width[m]
                for m in range(begin, end):
                    weights[2, m] /= second


@njit(parallel=True, cache=True)
def _spread(field, moments, weights, w, first, last):
    """One component: tasks of one plane in their order, so that threads change no bit."""
    mono, value, slope = weights
    for g in prange(first, last):
        plane = field[plane_of(w, w.group[g])].reshape(-1)
        for t in range(w.group[g], w.group[g + 1]):
            b, c, i = w.task[t]
            f, dx, dy, dz = moments[b, c]
            x = w.axis[b, c, 0] + i
            for m in range(w.run[t], w.run[t + 1]):
                h, y, z = w.place[m], w.y[m], w.z[m]
                p = f * mono[x] * mono[y]
                q = dx * slope[x] * value[y] + dy * value[x] * slope[y]
                s = dz * value[x] * value[y]
                for k in range(w.length[m]):
                    plane[h + k] += p * mono[z + k] + q * value[z + k] + s * slope[z + k]


@njit(parallel=True, cache=True)
def _gather(sums, field, weights, w, first, last):
    before = w.group[first]
    mono, value, slope = weights
    for g in prange(first, last):
        plane = field[plane_of(w, w.group[g])].reshape(-1)
        for t in range(w.group[g], w.group[g + 1]):
            b, c, i = w.task[t]
            x = w.axis[b, c, 0] + i
            v, gx, gy, gz = 0.0, 0.0, 0.0, 0.0
            for m in range(w.run[t], w.run[t + 1]):
                h, y, z = w.place[m], w.y[m], w.z[m]
                p, q, s = 0.0, 0.0, 0.0
                for k in range(w.length[m]):
                    u = plane[h + k]
                    p += u * mono[z + k]
                    q += u * value[z + k]
                    s += u * slope[z + k]
                v += mono[x] * mono[y] * p
                gx += slope[x] * value[y] * q
                gy += value[x] * slope[y] * q
                gz += value[x] * value[y] * s
            row = sums[t - before]
            row[0], row[1], row[2], row[3] = v, gx, gy, gz
