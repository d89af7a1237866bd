"""The momentum impulse of rigid motion, and the force and torque that it amounts to.

    f = φ(u_p − u),   u_p = V + Ω×r,   u ← u + f
    F = (ργ/Δt) ∫ (φ δu_p − f) dV,   T = (ργ/Δt) ∫ r×(φ δu_p − f) dV

What the fluid gains the body loses. φ δu_p is the inertia of the fluid that the body displaces,
δu_p = (γu_pⁿ⁺¹ − Σα_q u_pⁿ⁻q)/γ being the scheme's own difference; r is counted from its position.
"""

import numpy as np
from numba import njit, prange

from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.paint import Painter, coordinate


class Impulse:
    """Imposes rigid motion on a velocity field and measures what that took."""

    def __init__(self, grid: Grid, density: float):
        self.grid, self.density = grid, density
        self._sizes = [np.stack([a.padded_widths, a.padded_distances]) for a in grid.axes]
        self._values = np.empty(0, grid.dtype)

    def impose(
        self, painter: Painter, state: BodyState, change: tuple, velocity: tuple, rate: float
    ) -> None:
        """u ← u + φ(u_p − u); loads into state.force, state.torque. rate = γ/Δt.

        change = (δV, δΩ), each (n,3). Overlapping layers all see the velocity before the impulse.
        """
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
            state.velocity,
            state.angular_velocity,
            *change,
            *velocity,
        )
        _add(self._values, w.task, w.first, w.count, w.start, w.order, w.group, *velocity)
        factor = self.density * rate
        state.force[:], state.torque[:] = _gather(w.task, sums, state.count)
        state.force *= factor
        state.torque *= factor

    def solid_mean(
        self, painter: Painter, state: BodyState, field: np.ndarray, component: int, moving: bool
    ) -> float:
        """⟨φ(u_p − f)⟩ over the box: what the impulse will add to the mean of a field.

        With moving = False, u_p counts as zero.
        """
        velocity = [field] * 3
        zero = np.zeros_like(state.velocity)
        motion = (state.velocity, state.angular_velocity) if moving else (zero, zero)
        sums = np.zeros((painter.windows.task.shape[0], 3))
        values = np.empty(painter.windows.points, self.grid.dtype)
        _impulse(
            values, sums, painter.indicator, *painter.table(), *self._sizes,
            state.position, *motion, zero, zero, *velocity,
        )  # fmt: skip
        force, _ = _gather(painter.windows.task, sums, state.count)
        return -float(force[:, component].sum()) / self.grid.volume


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
    position, velocity, spin, change, spin_change, u, v, w,
):  # fmt: skip
    cells = (px.shape[1] - 2, py.shape[1] - 2, pz.shape[1] - 2)
    for t in prange(task.shape[0]):
        b, c, i = task[t]
        field = u if c == 0 else (v if c == 1 else w)
        i0, j0, k0 = first[b, c]
        ny, nz = count[b, c, 1], count[b, c, 2]
        x = coordinate(px, c == 0, i0 + i, image[b, c, 0], lengths[0]) - position[b, 0]
        gi = i0 + i - cells[0] if i0 + i > cells[0] else i0 + i
        total, first_moment, second_moment = 0.0, 0.0, 0.0
        for j in range(ny):
            y = coordinate(py, c == 1, j0 + j, image[b, c, 1], lengths[1]) - position[b, 1]
            gj = j0 + j - cells[1] if j0 + j > cells[1] else j0 + j
            area = sx[int(c == 0), gi] * sy[int(c == 1), gj]
            at = start[b, c] + (i * ny + j) * nz
            for k in range(nz):
                z = coordinate(pz, c == 2, k0 + k, image[b, c, 2], lengths[2]) - position[b, 2]
                gk = k0 + k - cells[2] if k0 + k > cells[2] else k0 + k
                # (Ω×r)_c = Ω_{c+1} r_{c+2} − Ω_{c+2} r_{c+1}
                if c == 0:
                    r1, r2 = y, z
                elif c == 1:
                    r1, r2 = z, x
                else:
                    r1, r2 = x, y
                c1, c2 = (c + 1) % 3, (c + 2) % 3
                target = velocity[b, c] + spin[b, c1] * r2 - spin[b, c2] * r1
                inertia = change[b, c] + spin_change[b, c1] * r2 - spin_change[b, c2] * r1
                p = phi[at + k]
                f = p * (target - field[gi, gj, gk])
                values[at + k] = f
                load = (p * inertia - f) * area * sz[int(c == 2), gk]
                total += load
                first_moment += load * r1
                second_moment += load * r2
        sums[t, 0], sums[t, 1], sums[t, 2] = total, first_moment, second_moment


@njit(parallel=True, cache=True)
def _add(values, task, first, count, start, order, group, u, v, w):
    for g in prange(group.size - 1):
        for m in range(group[g], group[g + 1]):
            b, c, i = task[order[m]]
            field = u if c == 0 else (v if c == 1 else w)
            n0, n1, n2 = field.shape[0] - 2, field.shape[1] - 2, field.shape[2] - 2
            i0, j0, k0 = first[b, c]
            ny, nz = count[b, c, 1], count[b, c, 2]
            gi = i0 + i - n0 if i0 + i > n0 else i0 + i
            for j in range(ny):
                gj = j0 + j - n1 if j0 + j > n1 else j0 + j
                at = start[b, c] + (i * ny + j) * nz
                for k in range(nz):
                    gk = k0 + k - n2 if k0 + k > n2 else k0 + k
                    field[gi, gj, gk] += values[at + k]
