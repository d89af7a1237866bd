"""Kernels that paint φ, plane of the grid after plane, and take its moments.

φᵢ ← φᵢ/max(1, Σφ)      where layers of several bodies overlap
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from smoothprofile.distances import CAPSULE, ELLIPSOID, MESH, curvature, signed_distance
from smoothprofile.particles.windows import plane_of
from smoothprofile.profiles import QUARTIC, QUARTIC_CENTRED, SINE, TANH, indicator
from smoothprofile.surfaces import sampled_distance

# |d| may change by a little more than the way, where the painted surface is moved by curvature.
STEEPEST = 1.5


class Parts(NamedTuple):
    """The parts of all bodies as kernels take them, see `bodies.Forms`."""

    start: np.ndarray
    kind: np.ndarray
    size: np.ndarray
    place: np.ndarray
    turn: np.ndarray
    offset: np.ndarray


@njit(parallel=True, cache=True, error_model="numpy")
def fill(phi, sums, w, parts, samples, rotation, ball, code, xi, half_width):
    """φ of every task, and into sums (t,10) ∫φ, ∫φ(x, y, z), ∫φ(xx, xy, xz, yy, yz, zz).

    ball (n,4): as in `windows_around`.
    """
    for g in prange(w.group.size - 1):
        scratch = np.empty(w.most)
        begin, end = w.group[g], w.group[g + 1]
        for t in range(begin, end):
            b = w.task[t, 0]
            line = phi[w.start[t] : w.start[t + 1]]
            if ball[b, 3] < np.inf:
                _ball_distances(scratch, w, t, parts, ball[b], 1.0 / xi)
                _indicators(line, scratch, code, half_width)
            else:
                _distances(scratch, w, t, parts, samples, rotation[b], xi, half_width)
                for m in range(line.size):
                    line[m] = level(code, scratch[m], half_width)
        shared = _may_overlap(w, begin, end)
        total = _total(phi, w, begin, end) if shared else scratch
        for t in range(begin, end):
            _moments(sums[t], phi, w, t, shared, total)


@njit
def _distances(s, w, t, parts, samples, r, xi, half_width):
    """d/ξ at the points of a task; beyond the layer, that of a point nearer to it stands in."""
    b, c, i = w.task[t]
    x, at = w.arm[w.axis[b, c, 0] + i], 0
    for m in range(w.run[t], w.run[t + 1]):
        y, k, end = w.arm[w.y[m]], int(w.z[m]), int(w.z[m] + w.length[m])
        while k < end:
            z = w.arm[k]
            d = body_distance(
                r[0, 0] * x + r[1, 0] * y + r[2, 0] * z,
                r[0, 1] * x + r[1, 1] * y + r[2, 1] * z,
                r[0, 2] * x + r[1, 2] * y + r[2, 2] * z,
                parts.start[b], parts.start[b + 1], parts.kind, parts.size, parts.place,
                parts.turn, parts.offset, samples,
            )  # fmt: skip
            # ξ to spare, for the painted distance jumps a little where a capsule's caps begin.
            clear = z + (abs(d) - (half_width + 1.0) * xi) / STEEPEST
            s[at] = d / xi
            at, k = at + 1, k + 1
            while k < end and w.arm[k] < clear:
                s[at] = d / xi
                at, k = at + 1, k + 1


@njit(inline="always")
def _ball_distances(s, w, t, parts, centre, sharpness):
    """The same of a sphere: only the distance from its centre counts, the body is not turned."""
    b, c, i = w.task[t]
    part = parts.start[b]
    x, at = w.arm[w.axis[b, c, 0] + i] - centre[0], np.uint64(0)
    for m in range(w.run[t], w.run[t + 1]):
        across, z = x * x + (w.arm[w.y[m]] - centre[1]) ** 2, w.z[m]
        for k in range(w.length[m]):
            s[at + k] = across + (w.arm[z + k] - centre[2]) ** 2
        at += w.length[m]
    radius = parts.size[part, 0] + parts.offset[part, 0]
    for k in range(at):
        s[k] = (math.sqrt(s[k]) - radius) * sharpness


@njit(error_model="numpy")
def _indicators(line, s, code, half_width):
    """φ(s) for s ≤ half_width; a loop for each profile, which the compiler vectorises."""
    if code == TANH:
        for k in range(line.size):
            line[k] = logistic(s[k]) if s[k] > -half_width else 1.0
    elif code == SINE:
        for k in range(line.size):
            line[k] = indicator(SINE, s[k])
    elif code == QUARTIC:
        for k in range(line.size):
            line[k] = indicator(QUARTIC, s[k])
    else:
        for k in range(line.size):
            line[k] = indicator(QUARTIC_CENTRED, s[k])


@njit(inline="always")
def logistic(s):
    """½(1 − tanh s) = 1/(1 + e²ˢ) for |s| ≤ 8, without a call to a library: e²ˢ = (e^(s/32))⁶⁴."""
    x = s * (1.0 / 32.0)
    # Taylor's series to x¹¹: |x| ≤ ¼ leaves 1e-16, times 64.
    e = 1.0 + x / 11.0
    e = 1.0 + x * (1.0 / 10.0) * e
    e = 1.0 + x * (1.0 / 9.0) * e
    e = 1.0 + x * (1.0 / 8.0) * e
    e = 1.0 + x * (1.0 / 7.0) * e
    e = 1.0 + x * (1.0 / 6.0) * e
    e = 1.0 + x * (1.0 / 5.0) * e
    e = 1.0 + x * (1.0 / 4.0) * e
    e = 1.0 + x * (1.0 / 3.0) * e
    e = 1.0 + x * (1.0 / 2.0) * e
    e = 1.0 + x * e
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    e *= e
    return 1.0 / (1.0 + e)


@njit(inline="always")
def level(code, s, half_width):
    """φ(s), 0 and 1 beyond the layer."""
    if s > half_width:
        return 0.0
    if s < -half_width:
        return 1.0
    return indicator(code, s)


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


@njit(inline="always")
def _may_overlap(w, begin, end):
    """Two windows on one plane, or one that is longer than the box and meets itself."""
    if end - begin > 1:
        return True
    b, c, _ = w.task[begin]
    return w.count[b, c, 1] > w.cells[1] or w.count[b, c, 2] > w.cells[2]


@njit
def _total(phi, w, begin, end):
    """Σφ on a plane, flat."""
    total = np.zeros((w.cells[1] + 2) * (w.cells[2] + 2))
    at = w.start[begin]
    for m in range(w.run[begin], w.run[end]):
        h = w.place[m]
        for k in range(w.length[m]):
            total[h + k] += phi[at + k]
        at += w.length[m]
    return total


@njit(inline="always", error_model="numpy")
def _moments(sums, phi, w, t, shared, total):
    """Moments of a task's φ, of which it first gives what is too much where bodies share points."""
    b, c, i = w.task[t]
    at = w.start[t]
    s, sy, sz, syy, syz, szz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for m in range(w.run[t], w.run[t + 1]):
        h, z = w.place[m], w.z[m]
        p, pz, pzz = 0.0, 0.0, 0.0
        for k in range(w.length[m]):
            if shared:
                phi[at + k] /= max(1.0, total[h + k])
            q = phi[at + k]
            p += q * w.width[z + k]
            q *= w.lever[z + k]
            pz += q
            pzz += q * w.arm[z + k]
        at += w.length[m]
        y, dy, hy = w.arm[w.y[m]], w.width[w.y[m]], w.lever[w.y[m]]
        s, sz, szz = s + dy * p, sz + dy * pz, szz + dy * pzz
        sy, syz, syy = sy + hy * p, syz + hy * pz, syy + hy * y * p
    x, dx = w.arm[w.axis[b, c, 0] + i], w.width[w.axis[b, c, 0] + i]
    sums[0], sums[1], sums[2], sums[3] = dx * s, dx * x * s, dx * sy, dx * sz
    sums[4], sums[5], sums[6] = dx * x * x * s, dx * x * sy, dx * x * sz
    sums[7], sums[8], sums[9] = dx * syy, dx * syz, dx * szz


@njit(cache=True)
def by_body(task, sums, count):
    """(bodies, component, m): the tasks' sums (t, m) added up, in their order."""
    total = np.zeros((count, 3, sums.shape[1]))
    for t in range(task.shape[0]):
        for m in range(sums.shape[1]):
            total[task[t, 0], task[t, 1], m] += sums[t, m]
    return total


@njit(parallel=True, cache=True)
def add(field, phi, w, first, last):
    """field += φ, at the points of the groups first … last−1."""
    for g in prange(first, last):
        plane = field[plane_of(w, w.group[g])].reshape(-1)
        at = w.start[w.group[g]]
        for m in range(w.run[w.group[g]], w.run[w.group[g + 1]]):
            h = w.place[m]
            for k in range(w.length[m]):
                plane[h + k] += phi[at + k]
            at += w.length[m]
