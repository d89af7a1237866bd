"""The permittivity of one sphere on one plane of its box: `permittivity._paint` in closed form.

d = |r| − a_painted and ∇d = r/|r| are written out, and rows go no further than the layer: this
takes a fifth of the time.
"""

import math

from numba import njit

from smoothprofile.electric.layers import lay, level
from smoothprofile.electric.layers import slope as profile_slope
from smoothprofile.particles.paint import coordinate, wrap

ARITHMETIC, HARMONIC, TENSOR = range(3)


@njit(inline="always")
def place(points, on_face, index, image, length, periodic):
    """Coordinate of a padded index, which may run on through the periods of the axis."""
    if not periodic:
        return points[1 if on_face else 0, index]
    return coordinate(points, on_face, index, image, length)


@njit(inline="always")
def cover(faces, layers, above, below, at, value):
    """Nothing but the body at a point and its faces."""
    for c in range(3):
        faces[c][at] = value
        layers[c][at] = 0.0
    above[at], below[at] = value, 1.0 / value


@njit
def paint_sphere(
    b, plane, boxes, points, lengths, periodic, centre, law, wide, faces, layers, above, below, now
):  # fmt: skip
    """Lay sphere b over what is there, on that plane of its box; now: five numbers of scratch."""
    code, xi, half_width, radius, value, mode = law
    first, count, image = boxes
    px, py, pz = points
    nx, ny, nz = px.shape[1] - 2, py.shape[1] - 2, pz.shape[1] - 2
    i0, j0, k0 = first[b, 0] + plane, first[b, 1], first[b, 2]
    gi = wrap(i0, nx) if periodic[0] else i0
    xf = place(px, 1, i0, image[b, 0], lengths[0], periodic[0]) - centre[0]
    xc = place(px, 0, i0, image[b, 0], lengths[0], periodic[0]) - centre[0]
    outer, inner = radius + half_width * xi + wide, radius - half_width * xi - wide
    for j in range(j0, j0 + count[b, 1]):
        gj = wrap(j, ny) if periodic[1] else j
        yf = place(py, 1, j, image[b, 1], lengths[1], periodic[1]) - centre[1]
        yc = place(py, 0, j, image[b, 1], lengths[1], periodic[1]) - centre[1]
        across = xf * xf + yf * yf
        if across > outer * outer:
            continue
        for k in range(k0, k0 + count[b, 2]):
            zf = place(pz, 1, k, image[b, 2], lengths[2], periodic[2]) - centre[2]
            r = math.sqrt(across + zf * zf)
            if r > outer:
                continue
            at = (gi, gj, wrap(k, nz) if periodic[2] else k)
            if r < inner:
                cover(faces, layers, above, below, at, value)
                continue
            zc = place(pz, 0, k, image[b, 2], lengths[2], periodic[2]) - centre[2]
            _face(faces[0], at, xf * xf + yc * yc + zc * zc, law)
            _face(faces[1], at, xc * xc + yf * yf + zc * zc, law)
            _face(faces[2], at, xc * xc + yc * yc + zf * zf, law)
            s = (r - radius) / xi
            if mode != TENSOR or s > half_width:
                continue
            phi, rise = level(code, s, half_width), 0.0
            if s >= -half_width:
                rise = profile_slope(code, s) / (xi * r) if r > 0.0 else 0.0
            now[0], now[1] = above[at], below[at]
            now[2], now[3], now[4] = layers[0][at], layers[1][at], layers[2][at]
            more, less = value - now[0], 1.0 / value - now[1]
            lay(now, phi, rise * xf, rise * yf, rise * zf, more, less)
            above[at], below[at] = now[0], now[1]
            layers[0][at], layers[1][at], layers[2][at] = now[2], now[3], now[4]


@njit(inline="always")
def _face(face, at, square, law):
    code, xi, half_width, radius, value, mode = law
    s = (math.sqrt(square) - radius) / xi
    if s <= half_width:
        phi = level(code, s, half_width)
        if mode == ARITHMETIC:
            face[at] += phi * (value - face[at])
        else:
            face[at] = 1.0 / ((1.0 - phi) / face[at] + phi / value)
