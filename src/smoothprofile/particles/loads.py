"""The momentum impulse of rigid motion, and the force and torque that it amounts to.

    f = φ(u_p − u),   u_p = V + Ω×r + G r,   u ← u + f
    F = F_displaced − (ργ/Δt) ∫ f dV,   T = T_displaced − (ργ/Δt) ∫ r×f dV

What the fluid gains the body loses; the fluid inside, which the body displaces, needs a force of
its own to speed up (`inertia.py`). r is counted from the body's position. G is a velocity gradient
common to all bodies, zero unless they are held in a flow that is not part of u. As u_p is linear
in r, all integrals follow from moments of φ and of φu: no pass over the points finds f itself.
"""

import numpy as np
from numba import njit, prange

from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.paint import Painter
from smoothprofile.particles.painting import by_body
from smoothprofile.particles.stress import cross_matrix
from smoothprofile.particles.windows import plane_of

LEVI_CIVITA = np.zeros((3, 3, 3))
for _i in range(3):
    LEVI_CIVITA[_i, _i - 2, _i - 1], LEVI_CIVITA[_i, _i - 1, _i - 2] = 1.0, -1.0
# ε_ijc ε_cab for each c, which takes ∫φ r_j r_b at the points of c to ∂(∫r×φu_p)_i/∂Ω_a.
_TURNING = np.einsum("ijc,cab->cjbia", LEVI_CIVITA, LEVI_CIVITA).reshape(27, 9)
# Where xx, xy … zz stand among the moments that the painter keeps.
_SECOND = np.array([[4, 5, 6], [5, 7, 8], [6, 8, 9]])


class Impulse:
    """Imposes rigid motion on a velocity field and measures what that took."""

    def __init__(self, grid: Grid, gradient: np.ndarray | None = None):
        """gradient: G (3,3), ∂u_p,i/∂x_j beyond rigid motion."""
        self.grid = grid
        self.gradient = np.zeros((3, 3)) if gradient is None else np.array(gradient, float)
        self._fluid = np.zeros((0, 3, 4))

    def impose(
        self, painter: Painter, state: BodyState, velocity: tuple, fluid: np.ndarray | None = None
    ) -> tuple:
        """u ← u + φ(u_p − u); returns ∫f dV and ∫r×f dV of each body, (n,3).

        Overlapping layers all see the velocity before the impulse. fluid: `fluid_moments` of that
        velocity, where they are known already.
        """
        w, slope = painter.windows, self._slope(state.angular_velocity)
        if fluid is None:
            fluid = self.fluid_moments(painter, state.count, dict(enumerate(velocity)))
        for c, u in enumerate(velocity):
            groups = w.part[c], w.part[c + 1]
            _impose(painter.indicator, w, *groups, state.velocity, slope, u)
        self._fluid = fluid
        gained = _of_motion(painter, state.velocity, slope) - fluid
        return gained[:, :, 0], _torque(gained)

    def first_moments(self, painter: Painter, state: BodyState) -> np.ndarray:
        """∫ r_i f_j dV (n,3,3) of the last impulse, for the painting and the motion it had.

        Its antisymmetric part is the torque, its symmetric one the stresslet.
        """
        slope = self._slope(state.angular_velocity)
        gained = _of_motion(painter, state.velocity, slope) - self._fluid
        return np.swapaxes(gained[:, :, 1:], 1, 2)

    def momenta(self, painter: Painter, state: BodyState, velocity: tuple) -> tuple:
        """`matrix`, and `momentum` of that velocity."""
        fluid = self.fluid_moments(painter, state.count, dict(enumerate(velocity)))
        return self.matrix(painter), self.momentum(painter, fluid)

    def matrix(self, painter: Painter) -> np.ndarray:
        """∂(∫φu_p, ∫r×φu_p)/∂(V, Ω) (n,6,6), as painted."""
        sums = painter.sums
        matrix = np.zeros((sums.shape[0], 6, 6))
        matrix[:, range(3), range(3)] = sums[:, :, 0]
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            for a, c, sign in ((j, k, 1.0), (k, j, -1.0)):
                mixed = sign * sums[:, c, 1 + a]
                matrix[:, 3 + i, c], matrix[:, c, 3 + i] = mixed, mixed
        turning = sums[:, :, _SECOND].reshape(-1, 27) @ _TURNING
        matrix[:, 3:, 3:] = turning.reshape(-1, 3, 3)
        return matrix

    def momentum(self, painter: Painter, fluid: np.ndarray) -> np.ndarray:
        """∫φ(u−Gr) and ∫r×φ(u−Gr) (n,6) from the moments of φu: what V and Ω have to meet."""
        if self.gradient.any():
            still = np.zeros((fluid.shape[0], 3))
            fluid = fluid - _of_motion(painter, still, self._slope(still))
        return vectors(fluid)

    def fluid_moments(self, painter: Painter, count: int, fields: dict) -> np.ndarray:
        """∫φu dV and ∫φur dV (n,3,4) of fields {component: u}; those not given are zero."""
        w, found = painter.windows, np.zeros((count, 3, 4))
        for c, field in fields.items():
            begin, end = w.group[w.part[c]], w.group[w.part[c + 1]]
            sums = np.empty((end - begin, 4))
            _fluid_moments(sums, painter.indicator, w, w.part[c], w.part[c + 1], field)
            found[:, c] = by_body(w.task[begin:end], sums, count)[:, c]
        return found

    def solid_mean(
        self,
        painter: Painter,
        motion: tuple,
        fluid: np.ndarray,
        component: int,
        response: bool = False,
    ) -> float:
        """⟨φ(u_p − u)⟩ over the box of one component, from V and Ω of u_p and the moments of φu.

        Of a response, what is added to u and to V and Ω, it is without G.
        """
        slope = self._slope(motion[1])[:, component] - (self.gradient[component] * response)
        sums = painter.sums[:, component]
        solid = sums[:, 0] * motion[0][:, component] + (sums[:, 1:4] * slope).sum(axis=1)
        return float((solid - fluid[:, component, 0]).sum()) / self.grid.volume

    def _slope(self, spin: np.ndarray) -> np.ndarray:
        """∂u_p,i/∂r_j = ε_iaj Ω_a + G_ij, (n,3,3)."""
        return self.gradient + cross_matrix(spin)


def _of_motion(painter: Painter, velocity: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """∫φu_p dV and ∫φu_p r dV (n,3,4), u_p = V + A r."""
    first, second = painter.sums[:, :, 1:4], painter.sums[:, :, _SECOND]
    found = painter.sums[:, :, :4] * velocity[:, :, None]
    found[:, :, 0] += (slope * first).sum(axis=2)
    found[:, :, 1:] += (slope[:, :, None] @ second)[:, :, 0]
    return found


def vectors(moments: np.ndarray) -> np.ndarray:
    """∫f dV and ∫r×f dV (n,6) of ∫f dV and ∫fr dV (n,3,4)."""
    return np.concatenate([moments[:, :, 0], _torque(moments)], axis=1)


def _torque(moments: np.ndarray) -> np.ndarray:
    m = moments[:, :, 1:]
    return np.stack([m[:, i - 1, i - 2] - m[:, i - 2, i - 1] for i in range(3)], axis=1)


@njit(parallel=True, cache=True)
def _fluid_moments(sums, phi, w, first, last, field):
    before = w.group[first]
    for g in prange(first, last):
        begin, end = w.group[g], w.group[g + 1]
        # In one piece, which is what brings a plane into the cache.
        plane = field[plane_of(w, begin)].copy().reshape(-1)
        for t in range(begin, end):
            _moments(sums[t - before], phi, w, t, plane)


@njit(inline="always")
def _moments(sums, phi, w, t, u):
    """∫φu and ∫φu(x, y, z) of a task."""
    b, c, i = w.task[t]
    at = w.start[t]
    s, sy, sz = 0.0, 0.0, 0.0
    for m in range(w.run[t], w.run[t + 1]):
        h, z = w.place[m], w.z[m]
        p, pz = 0.0, 0.0
        for k in range(w.length[m]):
            q = phi[at + k] * u[h + k]
            p += q * w.width[z + k]
            pz += q * w.lever[z + k]
        at += w.length[m]
        dy = w.width[w.y[m]]
        s, sy, sz = s + dy * p, sy + w.lever[w.y[m]] * p, sz + dy * pz
    x, dx = w.arm[w.axis[b, c, 0] + i], w.width[w.axis[b, c, 0] + i]
    sums[0], sums[1], sums[2], sums[3] = dx * s, dx * x * s, dx * sy, dx * sz


@njit(parallel=True, cache=True)
def _impose(phi, w, first, last, velocity, slope, field):
    for g in prange(first, last):
        begin, end = w.group[g], w.group[g + 1]
        plane = field[plane_of(w, begin)].reshape(-1)
        before = plane.copy()
        for t in range(begin, end):
            b, c, i = w.task[t]
            base, at = velocity[b, c] + slope[b, c, 0] * w.arm[w.axis[b, c, 0] + i], w.start[t]
            for m in range(w.run[t], w.run[t + 1]):
                h, z = w.place[m], w.z[m]
                here = base + slope[b, c, 1] * w.arm[w.y[m]]
                for k in range(w.length[m]):
                    target = here + slope[b, c, 2] * w.arm[z + k]
                    plane[h + k] += phi[at + k] * (target - before[h + k])
                at += w.length[m]
