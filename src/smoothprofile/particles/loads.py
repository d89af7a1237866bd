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

    def momenta(self, painter: Painter, state: BodyState, velocity: tuple) -> tuple:
        """∂(∫φu_p, ∫r×φu_p)/∂(V, Ω) (n,6,6), and ∫φu, ∫r×φu (n,6): u_p and u as painted."""
        w = painter.windows
        sums = np.zeros((w.task.shape[0], 9))
        _momenta(sums, painter.indicator, *painter.table(), *self._sizes, state.position, *velocity)
        return _assemble(w.task, sums, state.count)

    def solid_mean(
        self, painter: Painter, state: BodyState, motion: tuple, field: np.ndarray, component: int
    ) -> float:
        """⟨φ(u_p − f)⟩ over the box, u_p of motion (V, Ω): what the impulse adds to f's mean."""
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


@njit(inline="always")
def _arms(component, x, y, z):
    """The coordinates along the axes c+1 and c+2."""
    if component == 0:
        return y, z
    return (z, x) if component == 1 else (x, y)


@njit
def _along_z(points, sizes, on_face, first, count, image, length, centre):
    """Coordinate from the body's centre, size and padded index of the points of a row."""
    z, size, index = np.empty(count), np.empty(count), np.empty(count, np.int64)
    for k in range(count):
        index[k] = wrap(first + k, points.shape[1] - 2)
        z[k] = coordinate(points, on_face, first + k, image, length) - centre
        size[k] = sizes[int(on_face), index[k]]
    return z, size, index


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
        z, dz, gk = _along_z(pz, sz, c == 2, k0, nz, image[b, c, 2], lengths[2], position[b, 2])
        c1, c2 = (c + 1) % 3, (c + 2) % 3
        spin1, spin2 = spin[b, c1], spin[b, c2]
        f0, f1, f2 = 0.0, 0.0, 0.0
        for j in range(ny):
            y = coordinate(py, c == 1, j0 + j, image[b, c, 1], lengths[1]) - position[b, 1]
            gj = wrap(j0 + j, cells[1])
            area = sx[int(c == 0), gi] * sy[int(c == 1), gj]
            at = start[b, c] + (i * ny + j) * nz
            row = field[gi, gj]
            for k in range(nz):
                p = phi[at + k]
                if p == 0.0:
                    values[at + k] = 0.0
                    continue
                r1, r2 = _arms(c, x, y, z[k])
                # (Ω×r)_c = Ω_{c+1} r_{c+2} − Ω_{c+2} r_{c+1}
                target = velocity[b, c] + spin1 * r2 - spin2 * r1
                f = p * (target - row[gk[k]])
                values[at + k] = f
                load = f * area * dz[k]
                f0, f1, f2 = f0 + load, f1 + load * r1, f2 + load * r2
        sums[t, 0], sums[t, 1], sums[t, 2] = f0, f1, f2


def _assemble(task: np.ndarray, sums: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The matrix and the momenta of each body from the tasks' moments of φ and of φu.

    sums: ∫φ, ∫φr₁, ∫φr₂, ∫φr₁r₁, ∫φr₁r₂, ∫φr₂r₂, ∫φu, ∫φur₁, ∫φur₂ at the points of component c,
    r₁ and r₂ along the axes c+1 and c+2. Along c, u_p = V_c + Ω₁r₂ − Ω₂r₁.
    """
    matrix, momentum = np.zeros((count, 6, 6)), np.zeros((count, 6))
    body, c = task[:, 0], task[:, 1]
    force, arm, other = c, 3 + (c + 1) % 3, 3 + (c + 2) % 3
    m, s1, s2, q11, q12, q22, p, p1, p2 = sums.T
    for row, signed in ((force, (m, s2, -s1)), (arm, (s2, q22, -q12)), (other, (-s1, -q12, q11))):
        for column, values in zip((force, arm, other), signed, strict=True):
            np.add.at(matrix, (body, row, column), values)
    for row, values in ((force, p), (arm, p2), (other, -p1)):
        np.add.at(momentum, (body, row), values)
    return matrix, momentum


@njit(parallel=True, cache=True)
def _momenta(
    sums, phi, task, first, count, image, start, px, py, pz, lengths, sx, sy, sz, position, u, v, w,
):  # fmt: skip
    cells = (px.shape[1] - 2, py.shape[1] - 2, pz.shape[1] - 2)
    for t in prange(task.shape[0]):
        b, c, i = task[t]
        field = u if c == 0 else (v if c == 1 else w)
        i0, j0, k0 = first[b, c]
        ny, nz = count[b, c, 1], count[b, c, 2]
        x = coordinate(px, c == 0, i0 + i, image[b, c, 0], lengths[0]) - position[b, 0]
        gi = wrap(i0 + i, cells[0])
        z, dz, gk = _along_z(pz, sz, c == 2, k0, nz, image[b, c, 2], lengths[2], position[b, 2])
        m, s1, s2, q11, q12, q22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        p, p1, p2 = 0.0, 0.0, 0.0
        for j in range(ny):
            y = coordinate(py, c == 1, j0 + j, image[b, c, 1], lengths[1]) - position[b, 1]
            gj = wrap(j0 + j, cells[1])
            area = sx[int(c == 0), gi] * sy[int(c == 1), gj]
            at = start[b, c] + (i * ny + j) * nz
            row = field[gi, gj]
            for k in range(nz):
                if phi[at + k] == 0.0:
                    continue
                r1, r2 = _arms(c, x, y, z[k])
                weight = phi[at + k] * area * dz[k]
                m, s1, s2 = m + weight, s1 + weight * r1, s2 + weight * r2
                q11 += weight * r1 * r1
                q12 += weight * r1 * r2
                q22 += weight * r2 * r2
                load = weight * row[gk[k]]
                p, p1, p2 = p + load, p1 + load * r1, p2 + load * r2
        sums[t, 0], sums[t, 1], sums[t, 2] = m, s1, s2
        sums[t, 3], sums[t, 4], sums[t, 5] = q11, q12, q22
        sums[t, 6], sums[t, 7], sums[t, 8] = p, p1, p2


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
