"""Sub-steps of bodies in contact: one kernel, serial, in the candidates' order.

    V(t) = V̄ + V̇(t − Δt/2) + Σ J/m,   Ω likewise,   t from 0 to Δt

Velocity Verlet, in sub-steps δt: every pair in reach is pushed apart and rubbed, for δt/2 at both
ends of the step and for δt between its sub-steps; then pairs are lubricated for δt; then what would
still pass through another surface within δt is stopped, the walls last; then the bodies drift by
δtV and turn by δtΩ, at the V and Ω of the sub-step's middle. Each law sees what the one before did.

Each impulse acts on both bodies, equal and opposite, at one point: ΣJ = 0 and Σ(R×J + T) = 0.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from smoothprofile.distances import PLANE, SPHERE
from smoothprofile.particles.contact_gap import feature_gap, part_gap
from smoothprofile.particles.contact_hits import (
    inverse_mass,
    keep_within_walls,
    lubricate_all,
    push_all,
    stop_all,
)
from smoothprofile.particles.rigid import rotation_matrix


class PartTable(NamedTuple):
    """Parts (m): owner, kind, size, place and turn in the body, radius of an enclosing ball."""

    body: np.ndarray
    kind: np.ndarray
    size: np.ndarray
    place: np.ndarray
    turn: np.ndarray
    radius: np.ndarray


class MassTable(NamedTuple):
    """Bodies (n): 1/m, J⁻¹ along the body's axes, F₀, reach, and whether it is a centred ball."""

    inverse_mass: np.ndarray
    inverse_inertia: np.ndarray
    touch_force: np.ndarray
    reach: np.ndarray
    ball: np.ndarray


class Box(NamedTuple):
    """Corners (3,), periods (0 on walled axes), and wall velocities (axis, side, 3)."""

    low: np.ndarray
    high: np.ndarray
    period: np.ndarray
    wall_velocity: np.ndarray


class Course(NamedTuple):
    """Motion without contact (n,3): start R₀, V̄, V̇, Ω̄, Ω̇."""

    origin: np.ndarray
    velocity: np.ndarray
    velocity_rate: np.ndarray
    spin: np.ndarray
    spin_rate: np.ndarray


class Scratch(NamedTuple):
    """What contact has done so far (n,3): J, T, ΣJ/m, ΣJ⁻¹T, ΣδtJ/m; and where bodies are now."""

    impulse: np.ndarray
    angular_impulse: np.ndarray
    gain: np.ndarray
    spin_gain: np.ndarray
    shift: np.ndarray
    wall_impulse: np.ndarray
    quaternion: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    mobility: np.ndarray
    centre: np.ndarray
    frame: np.ndarray


class Hits(NamedTuple):
    """Pairs in reach in this sub-step: first and second body, gap, 1/m along n, n, the arms.

    radius: of both if they are spheres (∞ for a plane), else 0.
    """

    pair: np.ndarray
    radius: np.ndarray
    gap: np.ndarray
    inverse: np.ndarray
    normal: np.ndarray
    arm: np.ndarray
    other_arm: np.ndarray


@njit(cache=True, error_model="numpy")
def sweep(first, count, dt, rows, start, built, slack, cutoff, parts, masses, box, law, course, s):
    """Sub-steps `first` … `count`, the last of which only pushes, or until a part has moved by
    `slack` since the rows were `built`; returns the next sub-step and the least gap met."""
    n, size = course.origin.shape[0], rows.shape[0]
    h, hits = dt / count, room_for(size)
    least = np.inf
    for k in range(first, count + 1):
        fastest = set_out(k * h, dt, n, masses, course, s)
        weight = 0.5 if k in (0, count) else 1.0
        if place_parts(parts, s, built) > slack and k > first:
            return k, least
        met = meet(rows, start, max(cutoff, 2.0 * fastest * h), parts, masses, box, s, hits)
        for c in range(met):
            least = min(least, hits.gap[c])
        push_all(met, weight * h, hits, masses, box, law, s)
        if k == count:
            break
        speed_up(0.5 * h, n, course, s)
        if law.viscosity > 0.0:
            lubricate_all(met, h, hits, masses, box, law, s)
        stop_all(met, h, hits, masses, box, law, s)
        keep_within_walls(met, h, hits, masses, box, s)
        drift(h, n, s)
    return count + 1, least


@njit(error_model="numpy")
def room_for(size):
    """Hits of as many pairs, with anything in them."""
    return Hits(
        np.empty((size, 2), np.int64), np.empty((size, 2)), np.empty(size), np.empty(size),
        np.empty((size, 3)), np.empty((size, 3)), np.empty((size, 3)),
    )  # fmt: skip


@njit(error_model="numpy")
def set_out(t, dt, n, masses, course, s):
    """Places and velocities at t, J⁻¹ in space; returns the fastest speed."""
    fastest = 0.0
    for b in range(n):
        q, inverse = s.quaternion[b], masses.inverse_inertia[b]
        speed, turning = 0.0, 0.0
        late, bend = t - 0.5 * dt, 0.5 * t * (t - dt)
        for d in range(3):
            s.position[b, d] = (
                course.origin[b, d] + t * course.velocity[b, d] + bend * course.velocity_rate[b, d]
            ) + s.shift[b, d]
            v = course.velocity[b, d] + late * course.velocity_rate[b, d] + s.gain[b, d]
            w = course.spin[b, d] + late * course.spin_rate[b, d] + s.spin_gain[b, d]
            s.velocity[b, d], s.spin[b, d] = v, w
            speed, turning = speed + v * v, turning + w * w
        fastest = max(fastest, math.sqrt(speed) + math.sqrt(turning) * masses.reach[b])
        if masses.ball[b]:
            for d in range(3):
                s.mobility[b, d, d] = inverse[d, d]
        elif masses.inverse_mass[b] > 0.0:
            turn = np.empty((3, 3))
            rotation_matrix(q, turn)
            for d in range(3):
                for e in range(3):
                    total = 0.0
                    for f in range(3):
                        for g in range(3):
                            total += turn[d, f] * inverse[f, g] * turn[e, g]
                    s.mobility[b, d, e] = total
    return fastest


@njit(error_model="numpy")
def place_parts(parts, s, built):
    """Centres and frames of all parts; returns how far the farthest has moved since `built`."""
    farthest = 0.0
    turn = np.empty((3, 3))
    last = -1
    for p in range(parts.body.size):
        b = parts.body[p]
        place = parts.place[p]
        plain = parts.kind[p] == SPHERE and place[0] == 0.0 and place[1] == 0.0 and place[2] == 0.0
        if not plain and b != last:
            rotation_matrix(s.quaternion[b], turn)
            last = b
        moved = 0.0
        for d in range(3):
            x = s.position[b, d]
            if not plain:
                x += turn[d, 0] * place[0] + turn[d, 1] * place[1] + turn[d, 2] * place[2]
                for e in range(3):
                    s.frame[p, d, e] = (
                        turn[d, 0] * parts.turn[p, 0, e]
                        + turn[d, 1] * parts.turn[p, 1, e]
                        + turn[d, 2] * parts.turn[p, 2, e]
                    )
            s.centre[p, d] = x
            moved += (x - built[p, d]) ** 2
        farthest = max(farthest, moved)
    return math.sqrt(farthest)


@njit(error_model="numpy")
def meet(rows, start, reach, parts, masses, box, s, hits):
    """Fill `hits` with the candidates whose gap is less than `reach`; returns how many."""
    met = 0
    normal, point, other = np.empty(3), np.empty(3), np.empty(3)
    for i in range(rows.shape[0]):
        p, o = rows[i, 0], rows[i, 1]
        b = parts.body[p]
        if o < 0:
            axis, side = (-1 - o) // 2, (-1 - o) % 2
            normal[0], normal[1], normal[2] = 0.0, 0.0, 0.0
            normal[axis] = 1.0 - 2.0 * side
            level = box.low[axis] if side == 0 else -box.high[axis]
            gap = feature_gap(parts.kind[p], parts.size[p], s.frame[p], s.centre[p], rows[i, 2],
                              normal, level, point)  # fmt: skip
            body = -1 - 2 * axis - side
        else:
            body = parts.body[o]
            apart = 0.0
            for d in range(3):
                x = s.centre[o, d] - s.centre[p, d]
                if box.period[d] > 0.0:
                    x -= box.period[d] * math.floor(x / box.period[d] + 0.5)
                other[d] = s.centre[p, d] + x
                apart += x * x
            if apart > (reach + parts.radius[p] + parts.radius[o]) ** 2:
                continue
            if parts.kind[o] == PLANE:
                level = 0.0
                for d in range(3):
                    normal[d] = s.frame[o, d, 2]
                    level += normal[d] * other[d]
                gap = feature_gap(parts.kind[p], parts.size[p], s.frame[p], s.centre[p],
                                  rows[i, 2], normal, level, point)  # fmt: skip
            else:
                gap = part_gap(parts.kind[p], parts.size[p], s.frame[p], s.centre[p],
                               parts.kind[o], parts.size[o], s.frame[o], other, start[i],
                               normal, point)  # fmt: skip
        if gap > reach:
            continue
        hits.pair[met, 0], hits.pair[met, 1], hits.gap[met] = b, body, gap
        _note_radii(p, o, parts, hits.radius[met])
        for d in range(3):
            hits.normal[met, d] = normal[d]
            hits.arm[met, d] = point[d] - s.position[b, d]
            if body >= 0:
                image = other[d] - s.centre[o, d]
                hits.other_arm[met, d] = point[d] - image - s.position[body, d]
        hits.inverse[met] = inverse_mass(met, hits, masses, s, normal)
        met += 1
    return met


@njit(error_model="numpy")
def _note_radii(p, o, parts, radius):
    flat = o < 0 or parts.kind[o] == PLANE
    both = parts.kind[p] == SPHERE and (flat or parts.kind[o] == SPHERE)
    radius[0] = parts.size[p, 0] if both else 0.0
    radius[1] = np.inf if flat else parts.size[o, 0]


@njit(error_model="numpy")
def speed_up(h, n, course, s):
    for b in range(n):
        for d in range(3):
            s.velocity[b, d] += h * course.velocity_rate[b, d]
            s.spin[b, d] += h * course.spin_rate[b, d]


@njit(error_model="numpy")
def drift(h, n, s):
    for b in range(n):
        for d in range(3):
            s.shift[b, d] += h * s.gain[b, d]
        wx, wy, wz = s.spin[b]
        speed = math.sqrt(wx * wx + wy * wy + wz * wz)
        if speed == 0.0:
            continue
        c, f = math.cos(0.5 * h * speed), math.sin(0.5 * h * speed) / speed
        x, y, z = f * wx, f * wy, f * wz
        q0, q1, q2, q3 = s.quaternion[b]
        s.quaternion[b, 0] = c * q0 - x * q1 - y * q2 - z * q3
        s.quaternion[b, 1] = c * q1 + x * q0 + y * q3 - z * q2
        s.quaternion[b, 2] = c * q2 + y * q0 + z * q1 - x * q3
        s.quaternion[b, 3] = c * q3 + z * q0 + x * q2 - y * q1
