"""The momentum impulse of rigid motion, and the force and torque that it amounts to.

    f = φ(u_p − u),   u_p = V + Ω×r,   u ← u + f
    F = F_displaced − (ργ/Δt) ∫ f dV,   T = T_displaced − (ργ/Δt) ∫ r×f dV

What the fluid gains the body loses; the fluid inside, which the body displaces, needs a force of
its own to speed up (`inertia.py`). r is counted from the body's position.
"""

import numpy as np
from numba import njit, prange

from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.paint import Painter, coordinate, wrap


class Impulse:
    """Imposes rigid motion on a velocity field and measures what that took."""

    def __init__(self, grid: Grid):
        self.grid = grid
        self._sizes = [np.stack([a.padded_widths, a.padded_distances]) for a in grid.axes]
        self._values = np.empty(0, grid.dtype)

    def impose(self, painter: Painter, state: BodyState, velocity: tuple) -> tuple:
        """u ← u + φ(u_p − u); returns ∫f dV and ∫r×f dV of each body, (n,3).

        Overlapping layers all see the velocity before the impulse.
        """
        motion = (state.velocity, state.angular_velocity)
        gained = self._integrals(painter, state, motion, velocity)
        w = painter.windows
        _add(self._values, w.task, w.first, w.count, w.start, w.order, w.group, *velocity)
        return gained

    def solid_mean(
        self, painter: Painter, state: BodyState, field: np.ndarray, component: int, moving: bool
    ) -> float:
        """⟨φ(u_p − f)⟩ over the box: what the impulse will add to the mean of a field.

        With moving = False, u_p counts as zero.
        """
        zero = np.zeros_like(state.velocity)
        motion = (state.velocity, state.angular_velocity) if moving else (zero, zero)
        gained, _ = self._integrals(painter, state, motion, (field,) * 3)
        return float(gained[:, component].sum()) / self.grid.volume

    def _integrals(
        self, painter: Painter, state: BodyState, motion: tuple, velocity: tuple
    ) -> tuple[np.ndarray, np.ndarray]:
        """∫f dV and ∫r×f dV, (n,3) each; f itself is left in the scratch values."""
        w = painter.windows
        if self._values.size < w.points:
            self._values = np.empty(w.points, self.grid.dtype)
        sums = np.zeros((w.task.shape[0], 3))
        _impulse(
            self._values,
            sums,
            painter.indicator,
            *painter.table(),
            *self._sizes,
            state.position,
            *motion,
            *velocity,
        )
        return _gather(w.task, sums, state.count)


def _gather(task: np.ndarray, sums: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Sum what the tasks found, in their order: (n,3) of force and of torque."""
    force, torque = np.zeros((count, 3)), np.zeros((count, 3))
    body, c = task[:, 0], task[:, 1]
    np.add.at(force, (body, c), sums[:, 0])
    # r×F of a force along c: r_{c+2} F_c along c+1, −r_{c+1} F_c along c+2.
    np.add.at(torque, (body, (c + 1) % 3), sums[:, 2])
    np.add.at(torque, (body, (c + 2) % 3), -sums[:, 1])
    return force, torque


@njit(parallel=True, cache=True)
def _impulse(
    values, sums, phi, task, first, count, image, start, px, py, pz, lengths, sx, sy, sz,
    position, velocity, spin, u, v, w,
):  # fmt: skip
    cells = (px.shape[1] - 2, py.shape[1] - 2, pz.shape[1] - 2)
    for t in prange(task.shape[0]):
        b, c, i = task[t]
        field = u if c == 0 else (v if c == 1 else w)
        i0, j0, k0 = first[b, c]
        ny, nz = count[b, c, 1], count[b, c, 2]
        x = coordinate(px, c == 0, i0 + i, image[b, c, 0], lengths[0]) - position[b, 0]
        gi = wrap(i0 + i, cells[0])
        c1, c2 = (c + 1) % 3, (c + 2) % 3
        spin1, spin2 = spin[b, c1], spin[b, c2]
        f0, f1, f2 = 0.0, 0.0, 0.0
        for j in range(ny):
            y = coordinate(py, c == 1, j0 + j, image[b, c, 1], lengths[1]) - position[b, 1]
            gj = wrap(j0 + j, cells[1])
            area = sx[int(c == 0), gi] * sy[int(c == 1), gj]
            at = start[b, c] + (i * ny + j) * nz
            for k in range(nz):
                z = coordinate(pz, c == 2, k0 + k, image[b, c, 2], lengths[2]) - position[b, 2]
                gk = wrap(k0 + k, cells[2])
                # (Ω×r)_c = Ω_{c+1} r_{c+2} − Ω_{c+2} r_{c+1}
                if c == 0:
                    r1, r2 = y, z
                elif c == 1:
                    r1, r2 = z, x
                else:
                    r1, r2 = x, y
                target = velocity[b, c] + spin1 * r2 - spin2 * r1
                f = phi[at + k] * (target - field[gi, gj, gk])
                values[at + k] = f
                load = f * area * sz[int(c == 2), gk]
                f0, f1, f2 = f0 + load, f1 + load * r1, f2 + load * r2
        sums[t, 0], sums[t, 1], sums[t, 2] = f0, f1, f2


@njit(parallel=True, cache=True)
def _add(values, task, first, count, start, order, group, u, v, w):
    for g in prange(group.size - 1):
        for m in range(group[g], group[g + 1]):
            b, c, i = task[order[m]]
            field = u if c == 0 else (v if c == 1 else w)
            n0, n1, n2 = field.shape[0] - 2, field.shape[1] - 2, field.shape[2] - 2
            i0, j0, k0 = first[b, c]
            ny, nz = count[b, c, 1], count[b, c, 2]
            gi = wrap(i0 + i, n0)
            for j in range(ny):
                gj = wrap(j0 + j, n1)
                at = start[b, c] + (i * ny + j) * nz
                for k in range(nz):
                    gk = wrap(k0 + k, n2)
                    field[gi, gj, gk] += values[at + k]
