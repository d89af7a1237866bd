"""Loads at points that the layers of spheres alone reach, in closed form.

Of most points of a suspension, the layer of one: with n = r/|r|, Δ = ε_b − ε_fluid,
Δ' = 1/ε_b − 1/ε_fluid and no other body near,

    faces    f = −½V E² (−Δ'/H²) φ′ n           (Δ for the arithmetic ε)
    corners  f = −½V |t|²(Δ + Δ'/H²) φ′ n + V (ε_a − ε_h) (n·Ē) t/|r|,   t = Ē − (n·Ē)n

which is what `forces` finds there by sums over bodies and by differences; this takes a twentieth of
the time. Others are in `crowded_spheres`. Each point's torque is zero.
"""

import math

import numpy as np
from numba import njit, prange

from smoothprofile.electric.crowded_spheres import (
    MOST_RIVALS,
    OF_RIVAL,
    crowded_corner,
    crowded_face,
    near_rivals,
    push,
    rivals,
)
from smoothprofile.electric.layers import SHARP, level
from smoothprofile.electric.layers import slope as profile_slope
from smoothprofile.electric.operator import corner_field
from smoothprofile.electric.permittivity import ARITHMETIC, TENSOR, place
from smoothprofile.particles.paint import wrap


@njit(inline="always")
def margin(points):
    """How far the faces and the corner of one cell lie from its low corner, at most."""
    total = 0.0
    for axis in points:
        widest = 0.0
        for m in range(1, axis.shape[1] - 1):
            widest = max(widest, axis[1, m + 1] - axis[1, m])
        total += widest
    return total


@njit(parallel=True, cache=True, error_model="numpy")
def sphere_loads(
    task, first, count, image, meets, points, lengths, periodic, position, permittivity, fluid,
    layer, ball, outer, mode, faces, layers, psi, e0, w, d, share, sums,
):  # fmt: skip
    """sums[t] of the tasks of spheres: force 0–2, dipole 6–8, size 9, as in `forces`."""
    px, py, pz = points
    nx, ny, nz = psi.shape[0] - 2, psi.shape[1] - 2, psi.shape[2] - 2
    pad = margin(points)
    for t in prange(task.shape[0]):
        b, plane = task[t]
        if not (ball[b] > 0.0 and outer[b] < math.inf):
            continue
        found, near = np.empty((MOST_RIVALS, OF_RIVAL)), np.empty(MOST_RIVALS, np.int64)
        p, total = np.empty((2, 3)), sums[t]
        law = (layer[0], layer[1], layer[2], ball[b], permittivity[b], fluid, mode)
        i = first[b, 0] + plane
        gi = wrap(i, nx) if periodic[0] else i
        for f in range(2):
            p[f, 0] = place(px, f, i, image[b, 0], lengths[0], periodic[0]) - position[b, 0]
        for j in range(first[b, 1], first[b, 1] + count[b, 1]):
            gj = wrap(j, ny) if periodic[1] else j
            for f in range(2):
                p[f, 1] = place(py, f, j, image[b, 1], lengths[1], periodic[1]) - position[b, 1]
            across = p[1, 0] ** 2 + p[1, 1] ** 2
            if across > (outer[b] + pad) ** 2:
                continue
            others = rivals(
                b, p[1, 0], p[1, 1], pad, meets, position, permittivity, ball, outer, found
            )
            if others < 0:
                continue
            for k in range(first[b, 2], first[b, 2] + count[b, 2]):
                gk = wrap(k, nz) if periodic[2] else k
                for f in range(2):
                    p[f, 2] = place(pz, f, k, image[b, 2], lengths[2], periodic[2])
                    p[f, 2] -= position[b, 2]
                if across + p[1, 2] ** 2 > (outer[b] + pad) ** 2:
                    continue
                n = near_rivals(others, found, p[1, 2], near)
                ends = (gi > nx, gj > ny, gk > nz)
                if not (ends[1] or ends[2]):
                    field = e0[0] - (psi[gi, gj, gk] - psi[gi - 1, gj, gk]) / d[0][gi]
                    volume = share[0][gi] * w[1][gj] * w[2][gk]
                    value = faces[0][gi, gj, gk]
                    at = (p[1, 0], p[0, 1], p[0, 2])
                    _face(0, at, field, volume, value, law, found, near, n, total)
                if not (ends[0] or ends[2]):
                    field = e0[1] - (psi[gi, gj, gk] - psi[gi, gj - 1, gk]) / d[1][gj]
                    volume = w[0][gi] * share[1][gj] * w[2][gk]
                    value = faces[1][gi, gj, gk]
                    at = (p[0, 0], p[1, 1], p[0, 2])
                    _face(1, at, field, volume, value, law, found, near, n, total)
                if not (ends[0] or ends[1]):
                    field = e0[2] - (psi[gi, gj, gk] - psi[gi, gj, gk - 1]) / d[2][gk]
                    volume = w[0][gi] * w[1][gj] * share[2][gk]
                    value = faces[2][gi, gj, gk]
                    at = (p[0, 0], p[0, 1], p[1, 2])
                    _face(2, at, field, volume, value, law, found, near, n, total)
                if mode != TENSOR:
                    continue
                q = (layers[0][gi, gj, gk], layers[1][gi, gj, gk], layers[2][gi, gj, gk])
                if q[0] != 0.0 or q[1] != 0.0 or q[2] != 0.0:
                    e = corner_field(psi, e0, d, gi, gj, gk)
                    volume = share[0][gi] * share[1][gj] * share[2][gk]
                    at = (p[1, 0], p[1, 1], p[1, 2])
                    if n == 0:
                        _lone_corner(at, e, q, volume, law, total)
                    else:
                        crowded_corner(at, e, q, volume, law, found, near, n, total)


@njit(inline="always")
def _face(c, at, field, volume, value, law, found, near, n, total):
    if n == 0:
        _lone_face(c, at, field, volume, value, law, total)
    else:
        crowded_face(c, at, field, volume, value, law, found, near, n, total)


@njit(inline="always")
def _lone_face(c, at, field, volume, value, law, total):
    x, y, z = at
    code, xi, half_width, radius, inside, fluid, mode = law
    r = math.sqrt(x * x + y * y + z * z)
    s = (r - radius) / xi
    if s <= half_width:
        total[6 + c] += volume * (value - fluid) * field
        if s >= -half_width:
            rate = inside - fluid
            if mode != ARITHMETIC:
                rate = (1.0 / fluid - 1.0 / inside) * value * value
            size = -0.5 * volume * field * field * rate * profile_slope(code, s) / xi
            size /= r if r > 0.0 else 1.0
            push(total, size * x, size * y, size * z)


@njit(inline="always")
def _lone_corner(at, e, q, volume, law, total):
    x, y, z = at
    code, xi, half_width, radius, inside, fluid, _ = law
    r = math.sqrt(x * x + y * y + z * z)
    s = (r - radius) / xi
    if s <= half_width:
        ex, ey, ez = e
        u, v, k = q
        size, along = u * u + v * v + k * k, u * ex + v * ey + k * ez
        total[6] += volume * (size * ex - along * u)
        total[7] += volume * (size * ey - along * v)
        total[8] += volume * (size * ez - along * k)
        if s >= -half_width:
            unit = 1.0 / r if r > 0.0 else 0.0
            nx, ny, nz = unit * x, unit * y, unit * z
            ne = nx * ex + ny * ey + nz * ez
            tx, ty, tz = ex - ne * nx, ey - ne * ny, ez - ne * nz
            phi, steep = level(code, s, half_width), profile_slope(code, s) / xi
            a = fluid + phi * (inside - fluid)
            h = 1.0 / (1.0 / fluid + phi * (1.0 / inside - 1.0 / fluid))
            rate = inside - fluid + (1.0 / inside - 1.0 / fluid) * h * h
            rise = -0.5 * volume * (tx * tx + ty * ty + tz * tz) * rate * steep
            turn = volume * max(a - h, 0.0) * ne / r if SHARP * r > xi else 0.0
            push(total, rise * nx + turn * tx, rise * ny + turn * ty, rise * nz + turn * tz)
