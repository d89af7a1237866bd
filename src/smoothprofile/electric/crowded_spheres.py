"""Loads at points that the layers of several spheres reach, and no other body's.

The sums over bodies of `layers.stack`, and the loads of `forces`, with n = r/|r| written out: this
takes a tenth of the time. Each point's torque is zero, as of every force on a sphere.
"""

import math

import numpy as np
from numba import njit

from smoothprofile.electric.layers import SHARP, STEP, VANISHING, level
from smoothprofile.electric.layers import slope as profile_slope
from smoothprofile.electric.permittivity import ARITHMETIC

MOST_RIVALS = 64
"""Spheres that may reach one row of points beside its own; with more, the row is left out."""
OF_RIVAL = 7


@njit
def rivals(b, x, y, pad, meets, position, permittivity, ball, outer, found):
    """How many other spheres may reach a row of points along z at (x, y) from b.

    −1 if they are too many, or some body that may is no sphere. found[m]: height above b and reach
    along z, where b is seen from (3), painted radius, ε; negative for those painted after b.
    """
    start, others, shift = meets
    count, later = 0, False
    for m in range(start[b], start[b + 1]):
        o = others[m]
        if o == b and shift[m, 0] == 0.0 and shift[m, 1] == 0.0 and shift[m, 2] == 0.0:
            later = True
            continue
        dx = position[b, 0] - position[o, 0] - shift[m, 0]
        dy = position[b, 1] - position[o, 1] - shift[m, 1]
        square = (outer[o] + pad) ** 2 - (x + dx) ** 2 - (y + dy) ** 2
        if square < 0.0:
            continue
        if count == MOST_RIVALS or ball[o] <= 0.0 or outer[o] == np.inf:
            return -1
        row = found[count]
        row[0] = position[o, 2] + shift[m, 2] - position[b, 2]
        row[1] = math.sqrt(square)
        row[2], row[3], row[4] = dx, dy, -row[0]
        row[5] = ball[o]
        row[6] = -permittivity[o] if later else permittivity[o]
        count += 1
    return count


@njit(inline="always")
def near_rivals(count, found, z, near):
    """How many of them reach the point at height z of their row; their rows into near."""
    n = 0
    for m in range(count):
        if abs(z - found[m, 0]) <= found[m, 1]:
            near[n] = m
            n += 1
    return n


@njit
def crowded_face(c, at, field, volume, value, law, found, near, n, total):
    """As `forces` at a face: value is the painted ε there."""
    code, xi, half_width, radius, inside, fluid, mode = law
    x, y, z = at
    r = math.sqrt(x * x + y * y + z * z)
    s = (r - radius) / xi
    if s > half_width:
        return
    phi = level(code, s, half_width)
    above, below, left, uncovered = fluid, 1.0 / fluid, 1.0 - phi, 1.0
    for m in range(n):
        dx, dy, dz, size, other = _rival(found[near[m]])
        t = (math.sqrt((x + dx) ** 2 + (y + dy) ** 2 + (z + dz) ** 2) - size) / xi
        if t > half_width:
            continue
        psi = level(code, t, half_width)
        left *= 1.0 - psi
        if other > 0.0:
            above += psi * (other - above)
            below += psi * (1.0 / other - below)
        else:
            uncovered *= 1.0 - psi
    if phi > 0.0:
        total[6 + c] += volume * phi * uncovered / (1.0 - left) * (value - fluid) * field
    if s < -half_width:
        return
    if mode == ARITHMETIC:
        rate = (inside - above) * uncovered
    else:
        rate = (below - 1.0 / inside) * uncovered * value * value
    size = -0.5 * volume * field * field * rate * profile_slope(code, s) / xi
    size /= r if r > 0.0 else 1.0
    push(total, size * x, size * y, size * z)


@njit
def crowded_corner(at, e, q, volume, law, found, near, n, total):
    """As `forces` at a corner: e is Ē there, q the painted tensor's √(ε_a − ε_h) n."""
    code, xi, half_width, radius = law[:4]
    x, y, z = at
    r = math.sqrt(x * x + y * y + z * z)
    s = (r - radius) / xi
    if s > half_width:
        return
    phi, first = level(code, s, half_width), 0.0
    if s >= -half_width:
        first = profile_slope(code, s) / xi
    unit = 1.0 / r if r > 0.0 else 0.0
    mx, my, mz = unit * x, unit * y, unit * z
    own = (phi, first * mx, first * my, first * mz)
    a, h, gx, gy, gz, da, dh, vx, vy, vz, left, uncovered = _stack(at, own, law, found, near, n)
    ex, ey, ez = e
    u, v, w = q
    if phi > 0.0:
        share = volume * phi * uncovered / (1.0 - left)
        strength, along = u * u + v * v + w * w, u * ex + v * ey + w * ez
        total[6] += share * (strength * ex - along * u)
        total[7] += share * (strength * ey - along * v)
        total[8] += share * (strength * ez - along * w)
    steep = math.sqrt(gx * gx + gy * gy + gz * gz)
    if first == 0.0 or steep <= VANISHING * abs(da * first):
        return
    # ½V δ(|Ē|² − (n·Ē)²) by δ = ε_a − ε_h, and by n = ∇ε_a/|∇ε_a|.
    gx, gy, gz = gx / steep, gy / steep, gz / steep
    ne = gx * ex + gy * ey + gz * ez
    tx, ty, tz = ex - ne * gx, ey - ne * gy, ez - ne * gz
    alpha = 0.5 * volume * (tx * tx + ty * ty + tz * tz) * (da + dh / (h * h))
    turn = -volume * max(a - 1.0 / h, 0.0) * ne / steep
    alpha += turn * (tx * vx + ty * vy + tz * vz)
    beta = turn * da
    second = (profile_slope(code, s + STEP) - profile_slope(code, s - STEP)) / (2.0 * STEP * xi**2)
    mb = beta * (mx * tx + my * ty + mz * tz)
    # ∇∇φ·b = φ″ n n·b + φ′(b − n n·b)/|r|
    curved = first / r if SHARP * r > xi else 0.0
    both, bend = second * mb + alpha * first - curved * mb, curved * beta
    push(total, -both * mx - bend * tx, -both * my - bend * ty, -both * mz - bend * tz)


@njit
def _stack(at, own, law, found, near, n):
    """A, H, ∇A (3); ∂A, ∂H, ∂(∇A) (3) by φ_b; Π(1 − φ), and that of the later ones.

    own: φ and ∇φ of b itself. See `layers.stack`; ∂(∇A) by ∇φ_b equals ∂A by φ_b.
    """
    code, xi, half_width, _, inside, fluid, _ = law
    x, y, z = at
    phi, nx, ny, nz = own
    a, h, gx, gy, gz = fluid, 1.0 / fluid, 0.0, 0.0, 0.0
    da, dh, vx, vy, vz = 0.0, 0.0, 0.0, 0.0, 0.0
    left, uncovered, met = 1.0 - phi, 1.0, False
    for m in range(n + 1):
        if not met and (m == n or found[near[m], 6] < 0.0):
            met = True
            da, dh = inside - a, 1.0 / inside - h
            vx, vy, vz = -gx, -gy, -gz
            a, h = a + phi * da, h + phi * dh
            gx = (1.0 - phi) * gx + da * nx
            gy = (1.0 - phi) * gy + da * ny
            gz = (1.0 - phi) * gz + da * nz
        if m == n:
            break
        dx, dy, dz, size, other = _rival(found[near[m]])
        dx, dy, dz = x + dx, y + dy, z + dz
        far = math.sqrt(dx * dx + dy * dy + dz * dz)
        t = (far - size) / xi
        if t > half_width:
            continue
        psi, rise = level(code, t, half_width), 0.0
        if t >= -half_width:
            rise = profile_slope(code, t) / (xi * far) if far > 0.0 else 0.0
        left *= 1.0 - psi
        if met:
            vx = vx * (1.0 - psi) - rise * dx * da * uncovered
            vy = vy * (1.0 - psi) - rise * dy * da * uncovered
            vz = vz * (1.0 - psi) - rise * dz * da * uncovered
            uncovered *= 1.0 - psi
        more = abs(other) - a
        gx = (1.0 - psi) * gx + more * rise * dx
        gy = (1.0 - psi) * gy + more * rise * dy
        gz = (1.0 - psi) * gz + more * rise * dz
        a += psi * more
        h += psi * (1.0 / abs(other) - h)
    return a, h, gx, gy, gz, da * uncovered, dh * uncovered, vx, vy, vz, left, uncovered


@njit(inline="always")
def _rival(row):
    return row[2], row[3], row[4], row[5], row[6]


@njit(inline="always")
def push(total, fx, fy, fz):
    """A force at a point, and its size."""
    total[0] += fx
    total[1] += fy
    total[2] += fz
    total[9] += math.sqrt(fx * fx + fy * fy + fz * fz)
