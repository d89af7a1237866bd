"""Gaps between the true surfaces of two parts, as scalar kernels.

    h = min over x in B of d_A(x),   n = −∇d_A(x):   ∂h/∂t = n·(v_A − v_B) at x

n points from B to A, and a force f(h) along it on A, its opposite on B, both at one point of the
line of n through x, is the gradient of a potential of h (the minimum does not change with x).
h is the distance of parts that are apart, and minus the depth of B's deepest point of those that
overlap. Round parts (spheres, and capsules, which are segments with a radius) are found in closed
form from each other; so are a plane's distances. For the rest x descends d_A, which is convex on
the convex body B. Points are in space; a part has a centre c and a matrix R, from it to space.
"""

import math

from numba import njit

from smoothprofile.distances import (
    BOX,
    CAPSULE,
    CYLINDER,
    ELLIPSOID,
    PLANE,
    SPHERE,
    _ellipsoid_root,
    signed_distance,
)

# Steps of the descent; from where the sub-step before ended, a few are enough.
_MOST_STEPS = 60
# A move of x that is this fraction of the part's size ends the descent: h is off by its square.
_AT_REST = 1e-7
# Sections of a segment by the golden ratio: .618³⁶ = 3e-8 of its length; h is off by its square.
_SECTIONS = 36
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
# ∇d from differences over this fraction of the size: errors of 1e-10 from curvature and rounding.
_DIFFERENCE = 1e-5


@njit(error_model="numpy")
def is_round(kind):
    """Whether the part is a segment, or a point, with a radius."""
    return kind in (SPHERE, CAPSULE)


def feature_count(kind: int) -> int:
    """How many points of a part stand for it against a plane: ends, corners, or the lowest one."""
    return {SPHERE: 1, ELLIPSOID: 1, CAPSULE: 2, BOX: 8, CYLINDER: 8}[kind]


@njit(error_model="numpy")
def feature_gap(kind, size, turn, centre, feature, n, level, point):
    """Gap between feature of a part and the half space n·x < level; `point` is midway."""
    nx, ny, nz = _into(turn, n[0], n[1], n[2])
    radius = 0.0
    x, y, z = 0.0, 0.0, 0.0
    if kind == SPHERE:
        radius = size[0]
    elif kind == CAPSULE:
        radius, z = size[0], size[1] * (1 - 2 * feature)
    elif kind == BOX:
        x = size[0] * (1 - 2 * (feature & 1))
        y = size[1] * (1 - (feature & 2))
        z = size[2] * (1 - (feature & 4) // 2)
    elif kind == CYLINDER:
        # Four points of each rim, the first of them the lowest.
        across = math.sqrt(nx * nx + ny * ny)
        cx, cy = (-nx / across, -ny / across) if across > 1e-12 else (1.0, 0.0)
        for _ in range(feature % 4):
            cx, cy = -cy, cx
        x, y, z = size[0] * cx, size[0] * cy, size[1] * (1 - 2 * (feature // 4))
    else:
        ex, ey, ez = size[0] * nx, size[1] * ny, size[2] * nz
        length = math.sqrt(ex * ex + ey * ey + ez * ez)
        x, y, z = -size[0] * ex / length, -size[1] * ey / length, -size[2] * ez / length
    x, y, z = _out(turn, x, y, z)
    x, y, z = x + centre[0], y + centre[1], z + centre[2]
    gap = x * n[0] + y * n[1] + z * n[2] - level - radius
    back = radius + 0.5 * gap
    point[0], point[1], point[2] = x - back * n[0], y - back * n[1], z - back * n[2]
    return gap


@njit(error_model="numpy")
def part_gap(
    kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b, start, normal, point
):
    """Gap h of two parts; `normal` from B to A and `point` midway between the surfaces.

    `start` (3,) is kept from call to call: where x was, in B's frame; NaN to begin with.
    """
    if is_round(kind_a) and is_round(kind_b):
        return _round_gap(kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b,
                          normal, point)  # fmt: skip
    if is_round(kind_a):
        gap = _round_to_solid(kind_b, size_b, turn_b, centre_b, kind_a, size_a, turn_a, centre_a,
                              normal, point)  # fmt: skip
        normal[0], normal[1], normal[2] = -normal[0], -normal[1], -normal[2]
        return gap
    if is_round(kind_b):
        return _round_to_solid(kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b,
                               normal, point)  # fmt: skip
    if kind_b < kind_a:
        # A descent down the smoother of two solids does not stall on edges.
        gap = _solid_gap(kind_b, size_b, turn_b, centre_b, kind_a, size_a, turn_a, centre_a,
                         start, normal, point)  # fmt: skip
        normal[0], normal[1], normal[2] = -normal[0], -normal[1], -normal[2]
        return gap
    return _solid_gap(kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b,
                      start, normal, point)  # fmt: skip


@njit(error_model="numpy")
def _round_gap(kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b, normal, point):
    """Nearest points a + s u, b + t v of two segments, |s| ≤ half length, |t| likewise."""
    dx, dy, dz = centre_a[0] - centre_b[0], centre_a[1] - centre_b[1], centre_a[2] - centre_b[2]
    half_a = size_a[1] if kind_a == CAPSULE else 0.0
    half_b = size_b[1] if kind_b == CAPSULE else 0.0
    s, t = 0.0, 0.0
    if half_a + half_b > 0.0:
        s, t = _nearest_on_segments(
            turn_a[0, 2], turn_a[1, 2], turn_a[2, 2], half_a,
            turn_b[0, 2], turn_b[1, 2], turn_b[2, 2], half_b, dx, dy, dz,
        )  # fmt: skip
        dx += s * turn_a[0, 2] - t * turn_b[0, 2]
        dy += s * turn_a[1, 2] - t * turn_b[1, 2]
        dz += s * turn_a[2, 2] - t * turn_b[2, 2]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if distance > 0.0:
        normal[0], normal[1], normal[2] = dx / distance, dy / distance, dz / distance
    else:
        normal[0], normal[1], normal[2] = 1.0, 0.0, 0.0
    along = size_b[0] + 0.5 * (distance - size_a[0] - size_b[0])
    for d in range(3):
        point[d] = centre_b[d] + t * turn_b[d, 2] + along * normal[d]
    return distance - size_a[0] - size_b[0]


@njit(error_model="numpy")
def _nearest_on_segments(ux, uy, uz, half_a, vx, vy, vz, half_b, dx, dy, dz):
    """s, t of least |d + s u − t v|: s for the lines, then each held to its segment in turn."""
    uv = ux * vx + uy * vy + uz * vz
    du, dv = dx * ux + dy * uy + dz * uz, dx * vx + dy * vy + dz * vz
    apart = 1.0 - uv * uv
    s = (uv * dv - du) / apart if apart > 1e-12 else _shared_middle(du, half_a, half_b)
    s = min(max(s, -half_a), half_a)
    t = min(max(dv + s * uv, -half_b), half_b)
    s = min(max(t * uv - du, -half_a), half_a)
    return s, t


@njit(error_model="numpy")
def _shared_middle(du, half_a, half_b):
    """Of parallel segments: the middle of the stretch that both share, so that no turn begins."""
    low, high = max(-half_a, -du - half_b), min(half_a, -du + half_b)
    return 0.5 * (low + high)


@njit(error_model="numpy")
def _round_to_solid(kind, size, turn, centre, round_kind, round_size, round_turn, round_centre,
                    normal, point):  # fmt: skip
    """h = min over the segment of d − radius; normal from the round part to the solid."""
    x, y, z = _into(turn, round_centre[0] - centre[0], round_centre[1] - centre[1],
                    round_centre[2] - centre[2])  # fmt: skip
    if round_kind == CAPSULE:
        half = round_size[1]
        ux, uy, uz = _into(turn, round_turn[0, 2], round_turn[1, 2], round_turn[2, 2])
        low, high = -half, half
        for _ in range(_SECTIONS):
            s, t = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
            if _distance(kind, size, x + s * ux, y + s * uy, z + s * uz) < _distance(
                kind, size, x + t * ux, y + t * uy, z + t * uz
            ):
                high = t
            else:
                low = s
        s = 0.5 * (low + high)
        x, y, z = x + s * ux, y + s * uy, z + s * uz
    d = _distance(kind, size, x, y, z)
    gx, gy, gz = _gradient(kind, size, x, y, z, d)
    gap = d - round_size[0]
    return _to_space(turn, centre, x, y, z, gx, gy, gz, round_size[0] + 0.5 * gap, gap, normal,
                     point)  # fmt: skip


@njit(error_model="numpy")
def _solid_gap(kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b, start, normal,
               point):  # fmt: skip
    """x ← P_B(x − τ∇d_A(x)), τ longer after each descent and halved otherwise; P_B the nearest
    point of B. With τ = d_A these are alternating projections."""
    bx, by, bz = start[0], start[1], start[2]
    if not math.isfinite(bx):
        bx, by, bz = _into(turn_b, centre_a[0] - centre_b[0], centre_a[1] - centre_b[1],
                           centre_a[2] - centre_b[2])  # fmt: skip
        bx, by, bz = _project(kind_b, size_b, bx, by, bz)
    ax, ay, az = _across(turn_b, centre_b, turn_a, centre_a, bx, by, bz)
    d = _distance(kind_a, size_a, ax, ay, az)
    small = _smallest(size_b)
    tau = max(d, 0.0) + 0.25 * min(_smallest(size_a), small)
    shortest = 1e-6 * small
    for _ in range(_MOST_STEPS):
        gx, gy, gz = _gradient(kind_a, size_a, ax, ay, az, d)
        nx, ny, nz = _across(turn_a, centre_a, turn_b, centre_b, ax - tau * gx, ay - tau * gy,
                             az - tau * gz)  # fmt: skip
        nx, ny, nz = _project(kind_b, size_b, nx, ny, nz)
        moved = math.sqrt((nx - bx) ** 2 + (ny - by) ** 2 + (nz - bz) ** 2)
        tx, ty, tz = _across(turn_b, centre_b, turn_a, centre_a, nx, ny, nz)
        found = _distance(kind_a, size_a, tx, ty, tz)
        if found <= d:
            bx, by, bz, ax, ay, az, d = nx, ny, nz, tx, ty, tz, found
            if moved <= _AT_REST * small:
                break
            tau *= 1.5
        else:
            tau *= 0.3
            if tau < shortest:
                break
    start[0], start[1], start[2] = bx, by, bz
    gx, gy, gz = _gradient(kind_a, size_a, ax, ay, az, d)
    return _to_space(turn_a, centre_a, ax, ay, az, gx, gy, gz, 0.5 * d, d, normal, point)


@njit(error_model="numpy")
def _to_space(turn, centre, x, y, z, gx, gy, gz, back, gap, normal, point):
    """The point `back` along −∇d from x, and −∇d, in space; returns the gap."""
    px, py, pz = _out(turn, x - back * gx, y - back * gy, z - back * gz)
    point[0], point[1], point[2] = px + centre[0], py + centre[1], pz + centre[2]
    normal[0], normal[1], normal[2] = _out(turn, -gx, -gy, -gz)
    return gap


@njit(error_model="numpy")
def _distance(kind, size, x, y, z):
    return signed_distance(kind, size[0], size[1], size[2], x, y, z)


@njit(error_model="numpy")
def _gradient(kind, size, x, y, z, d):
    """∇d, of length one; outside an ellipsoid or a box from the nearest point."""
    if d > 1e-3 * _smallest(size) and kind != PLANE:
        px, py, pz = _project(kind, size, x, y, z)
        return (x - px) / d, (y - py) / d, (z - pz) / d
    e = _DIFFERENCE * _smallest(size) if kind != PLANE else 1.0
    gx = _distance(kind, size, x + e, y, z) - _distance(kind, size, x - e, y, z)
    gy = _distance(kind, size, x, y + e, z) - _distance(kind, size, x, y - e, z)
    gz = _distance(kind, size, x, y, z + e) - _distance(kind, size, x, y, z - e)
    length = math.sqrt(gx * gx + gy * gy + gz * gz)
    if length == 0.0:
        return 1.0, 0.0, 0.0
    return gx / length, gy / length, gz / length


@njit(error_model="numpy")
def _project(kind, size, x, y, z):
    """The nearest point of an ellipsoid, box or cylinder; the point itself inside."""
    if kind == BOX:
        return (min(max(x, -size[0]), size[0]), min(max(y, -size[1]), size[1]),
                min(max(z, -size[2]), size[2]))  # fmt: skip
    if kind == CYLINDER:
        r = math.sqrt(x * x + y * y)
        shrink = size[0] / r if r > size[0] else 1.0
        return x * shrink, y * shrink, min(max(z, -size[1]), size[1])
    a, b, c = size[0], size[1], size[2]
    if (x / a) ** 2 + (y / b) ** 2 + (z / c) ** 2 <= 1.0:
        return x, y, z
    _, _, _, _, wa, wb, wc = _ellipsoid_root(a, b, c, x, y, z)
    return a * a * wa * x, b * b * wb * y, c * c * wc * z


@njit(error_model="numpy")
def _smallest(size):
    """The least of the sizes that are not 0."""
    least = size[0]
    for d in range(1, 3):
        if size[d] > 0.0:
            least = min(least, size[d])
    return least


@njit(error_model="numpy")
def _into(turn, x, y, z):
    """Rᵀv."""
    return (turn[0, 0] * x + turn[1, 0] * y + turn[2, 0] * z,
            turn[0, 1] * x + turn[1, 1] * y + turn[2, 1] * z,
            turn[0, 2] * x + turn[1, 2] * y + turn[2, 2] * z)  # fmt: skip


@njit(error_model="numpy")
def _out(turn, x, y, z):
    """Rv."""
    return (turn[0, 0] * x + turn[0, 1] * y + turn[0, 2] * z,
            turn[1, 0] * x + turn[1, 1] * y + turn[1, 2] * z,
            turn[2, 0] * x + turn[2, 1] * y + turn[2, 2] * z)  # fmt: skip


@njit(error_model="numpy")
def _across(turn, centre, to_turn, to_centre, x, y, z):
    """A point of one part's frame, in the frame of another."""
    x, y, z = _out(turn, x, y, z)
    return _into(to_turn, x + centre[0] - to_centre[0], y + centre[1] - to_centre[1],
                 z + centre[2] - to_centre[2])  # fmt: skip
