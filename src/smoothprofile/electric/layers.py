"""Kernels for φ of one body at a point, its slopes, and how bodies lie over each other.

    A ← A + φ(ε_b − A),   H ← H + φ(1/ε_b − H),   ∇A ← (1 − φ)∇A + (ε_b − A)∇φ

from A = ε_fluid, H = 1/ε_fluid, body after body: the arithmetic permittivity A, the harmonic one
1/H, and the direction of ∇A. Where bodies overlap a later one covers an earlier one, so that what
is not fluid never passes one. A coated body is the solid of its shell, followed by its core.
"""

import math

import numpy as np
from numba import njit

from smoothprofile.distances import SPHERE
from smoothprofile.electric.windows import Boxes
from smoothprofile.particles.bodies import Forms
from smoothprofile.particles.paint import body_distance as body_distance
from smoothprofile.particles.painting import STEEPEST
from smoothprofile.profiles import QUARTIC, QUARTIC_EXCESS, SINE, TANH, indicator

# Steps of the central differences of d, of its gradient, and of φ′, over the layer's thickness:
# truncation (step·ξ/a)² and round-off 1e-16/step² both stay below 1e-9.
STEP = 1e-3
# Where slopes cancel to less than this part of a body's own, or its surface bends within ξ/SHARP,
# as on its axis or half way between two bodies, n swings round within a cell. The derivative of W
# is unbounded on a grid point that lies there, and is left out.
VANISHING, SHARP = 0.1, 10.0


@njit(inline="always")
def level(code, z, half_width):
    """φ(z), exactly 0 or 1 beyond the half width."""
    if z > half_width:
        return 0.0
    if z < -half_width:
        return 1.0
    if code == TANH:
        # ½(1 − tanh z), in a third of the time.
        return 1.0 / (1.0 + math.exp(2.0 * z))
    return indicator(code, z)


@njit(inline="always")
def slope(code, z):
    """φ′(z)."""
    if code == TANH:
        e = math.exp(-2.0 * abs(z))
        return -2.0 * e / ((1.0 + e) * (1.0 + e))
    if code == SINE:
        return -0.5 * math.pi * math.cos(math.pi * min(max(z, -0.5), 0.5))
    t = min(max(z + (0.5 if code == QUARTIC else 0.5 + QUARTIC_EXCESS), 0.0), 1.0)
    return -4.0 * t * (1.0 - t * t)


@njit
def distance(b, x, y, z, forms):
    """Painted signed distance of body b at (x, y, z) from its position, along the box's axes.

    Of a body that fills a periodic axis, the least over its images.
    """
    reaches, lengths, ball = forms[7], forms[8], forms[9]
    i, j, k = reaches[b]
    if ball[b] > 0.0:
        x, y, z = _nearest_image(x, y, z, reaches[b], lengths)
        return math.sqrt(x * x + y * y + z * z) - ball[b]
    if i < 0 and j < 0 and k < 0:
        return _distance_of_one(b, x, y, z, forms)
    x, y, z = _nearest_image(x, y, z, reaches[b], lengths)
    i, j, k = max(i, 0), max(j, 0), max(k, 0)
    nearest = math.inf
    for u in range(-i, i + 1):
        for v in range(-j, j + 1):
            for w in range(-k, k + 1):
                at = (x + u * lengths[0], y + v * lengths[1], z + w * lengths[2])
                nearest = min(nearest, _distance_of_one(b, at[0], at[1], at[2], forms))
    return nearest


@njit(inline="always")
def _nearest_image(x, y, z, reach, lengths):
    """A point seen from the image of the body whose centre is nearest, along the axes it fills."""
    x -= lengths[0] * np.rint(x / lengths[0]) if reach[0] >= 0 else 0.0
    y -= lengths[1] * np.rint(y / lengths[1]) if reach[1] >= 0 else 0.0
    z -= lengths[2] * np.rint(z / lengths[2]) if reach[2] >= 0 else 0.0
    return x, y, z


@njit
def _distance_of_one(b, x, y, z, forms):
    rotation, part_start, kind, size, place, turn, offset = forms[:7]
    r = rotation[b]
    return body_distance(
        r[0, 0] * x + r[1, 0] * y + r[2, 0] * z,
        r[0, 1] * x + r[1, 1] * y + r[2, 1] * z,
        r[0, 2] * x + r[1, 2] * y + r[2, 2] * z,
        part_start[b], part_start[b + 1], kind, size, place, turn, offset,
    )  # fmt: skip


@njit
def normal(b, x, y, z, step, forms):
    """∇d: of a sphere r/|r|, of other bodies by central differences."""
    if forms[9][b] > 0.0:
        x, y, z = _nearest_image(x, y, z, forms[7][b], forms[8])
        size = math.sqrt(x * x + y * y + z * z)
        scale = 1.0 / size if size > 0.0 else 0.0
        return scale * x, scale * y, scale * z
    gx = 0.5 * (distance(b, x + step, y, z, forms) - distance(b, x - step, y, z, forms)) / step
    gy = 0.5 * (distance(b, x, y + step, z, forms) - distance(b, x, y - step, z, forms)) / step
    gz = 0.5 * (distance(b, x, y, z + step, forms) - distance(b, x, y, z - step, forms)) / step
    if gx * gx + gy * gy + gz * gz > STEEPEST * STEEPEST:
        # The correction by curvature jumps here, as where a capsule's cap begins.
        here = distance(b, x, y, z, forms)
        gx = _one_sided(here, distance(b, x + step, y, z, forms), gx, step)
        gy = _one_sided(here, distance(b, x, y + step, z, forms), gy, step)
        gz = _one_sided(here, distance(b, x, y, z + step, forms), gz, step)
    return gx, gy, gz


@njit(inline="always")
def _one_sided(here, ahead, central, step):
    """The slope on the side where it is less steep."""
    forward = (ahead - here) / step
    backward = 2.0 * central - forward
    return forward if abs(forward) < abs(backward) else backward


@njit
def bent(b, x, y, z, vx, vy, vz, step, forms):
    """(∇∇d)·v: of a sphere (v − n n·v)/|r|, of other bodies by differences of ∇d along v."""
    if forms[9][b] > 0.0:
        x, y, z = _nearest_image(x, y, z, forms[7][b], forms[8])
        square = x * x + y * y + z * z
        along = (x * vx + y * vy + z * vz) / square if square > 0.0 else 0.0
        scale = 1.0 / math.sqrt(square) if square > 0.0 else 0.0
        return scale * (vx - along * x), scale * (vy - along * y), scale * (vz - along * z)
    size = math.sqrt(vx * vx + vy * vy + vz * vz)
    if size == 0.0:
        return 0.0, 0.0, 0.0
    s = step / size
    ax, ay, az = normal(b, x + s * vx, y + s * vy, z + s * vz, step, forms)
    bx, by, bz = normal(b, x - s * vx, y - s * vy, z - s * vz, step, forms)
    scale = 0.5 / s
    return scale * (ax - bx), scale * (ay - by), scale * (az - bz)


@njit
def stack(b, x, y, z, meets, position, permittivity, fluid, layer, forms, now):
    """What φ and ∇φ of body b do to the mixture at a point, given from the body's position.

    now[0:5] becomes A, H, ∇A; now[5], now[6] become ∂A/∂φ_b, ∂H/∂φ_b; now[7:10] ∂(∇A)/∂φ_b;
    now[10] the factor of ∂(∇A)/∂(∇φ_b); now[11] the share of b in what is not fluid.
    """
    code, xi, half_width = layer
    start, others, shift = meets
    outer = forms[10]
    now[:] = 0.0
    now[0], now[1] = fluid, 1.0 / fluid
    below, share, met = 1.0, 0.0, False
    for m in range(start[b], start[b + 1]):
        o = others[m]
        own = o == b and shift[m, 0] == 0.0 and shift[m, 1] == 0.0 and shift[m, 2] == 0.0
        dx = x + position[b, 0] - position[o, 0] - shift[m, 0]
        dy = y + position[b, 1] - position[o, 1] - shift[m, 1]
        dz = z + position[b, 2] - position[o, 2] - shift[m, 2]
        if dx * dx + dy * dy + dz * dz > outer[o] * outer[o]:
            met = met or own
            continue
        s = distance(o, dx, dy, dz, forms) / xi
        if s > half_width:
            met = met or own
            continue
        phi, gx, gy, gz = level(code, s, half_width), 0.0, 0.0, 0.0
        if s > -half_width:
            gx, gy, gz = normal(o, dx, dy, dz, STEP * xi, forms)
            steep = slope(code, s) / xi
            gx, gy, gz = steep * gx, steep * gy, steep * gz
        more, less = permittivity[o] - now[0], 1.0 / permittivity[o] - now[1]
        if own:
            met, share = True, phi
            now[5], now[6], now[10] = more, less, more
            now[7], now[8], now[9] = -now[2], -now[3], -now[4]
        elif met:
            now[7] = now[7] * (1.0 - phi) - gx * now[5]
            now[8] = now[8] * (1.0 - phi) - gy * now[5]
            now[9] = now[9] * (1.0 - phi) - gz * now[5]
            now[5] *= 1.0 - phi
            now[6] *= 1.0 - phi
            now[10] *= 1.0 - phi
            share *= 1.0 - phi
        lay(now, phi, gx, gy, gz, more, less)
        below *= 1.0 - phi
    now[11] = share / (1.0 - below) if share > 0.0 else 0.0


@njit(inline="always")
def lay(now, phi, gx, gy, gz, more, less):
    """One body over what is there: A, H and ∇A at now[0:5]."""
    now[2] = (1.0 - phi) * now[2] + more * gx
    now[3] = (1.0 - phi) * now[3] + more * gy
    now[4] = (1.0 - phi) * now[4] + more * gz
    now[0] += phi * more
    now[1] += phi * less


WORK = 12
"""Numbers that `stack` leaves."""


def form_arrays(
    forms: Forms, rotation: np.ndarray, boxes: Boxes, half_sides: np.ndarray, lengths
) -> tuple:
    """Forms, orientations (n,3,3), and images along the axes, as the kernels take them.

    The last two are the painted radii (n,) of bodies that are one sphere about their position, −1
    of others, and the radii (n,) beyond which nothing of a body is painted.
    """
    first = forms.part_start[:-1]
    alone = np.diff(forms.part_start) == 1
    ball = alone & (forms.kind[first] == SPHERE) & ~forms.place[first].any(axis=1)
    cut = boxes.reaches >= 0
    outer = np.where(cut.any(axis=1), np.inf, np.linalg.norm(half_sides, axis=1))
    outer = np.where(ball & ~cut.any(axis=1), half_sides[:, 0], outer)
    return (
        np.ascontiguousarray(rotation),
        forms.part_start,
        forms.kind,
        forms.size,
        forms.place,
        forms.turn,
        forms.offset,
        boxes.reaches,
        np.array(lengths),
        np.where(ball, forms.size[first, 0] + forms.offset[first, 0], -1.0),
        outer,
    )
