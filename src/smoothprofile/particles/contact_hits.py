"""Impulses of one pair in contact, as kernels: each on both bodies at one point.

    V₁ += J/m₁,  Ω₁ += I₁⁻¹(r₁×J),   V₂ −= J/m₂,  Ω₂ −= I₂⁻¹(r₂×J)

r is the way from a body's position to the point. A wall, or a body that is held or moved, has
1/m = 0 and I⁻¹ = 0. The pair is number `c` of the hits; its second body is below 0 for a wall.

Kernels read tables by single numbers and branch little: then the compiler sees that no array is
let go and leaves the counting of references out, which takes thirty times what the sums do.
"""

import math

from numba import njit

from smoothprofile.particles.contact_law import (
    friction_impulse,
    normal_impulse,
    shear_resistances,
    squeeze_impulse,
    squeeze_resistance,
    stopping_impulse,
)


@njit(error_model="numpy")
def push_all(met, dt, hits, masses, box, law, s):
    """Repulsion with damping, and the friction that it allows, of one pair after the other."""
    for c in range(met):
        pressed = _pushing(c, dt, hits, masses, box, law, s)
        if pressed > 0.0:
            kick(c, pressed, _row(hits.normal, c), hits, masses, s)
            if law.friction > 0.0:
                _rub(c, pressed, hits, masses, box, law, s)


@njit(error_model="numpy")
def stop_all(met, dt, hits, masses, box, law, s):
    """No surface passes through another within Δt, and the friction of what stops it."""
    for c in range(met):
        pressed = _stopping(c, dt, hits, box, s)
        if pressed > 0.0:
            kick(c, pressed, _row(hits.normal, c), hits, masses, s)
            if law.friction > 0.0:
                _rub(c, pressed, hits, masses, box, law, s)


@njit(error_model="numpy")
def stop(c, dt, hits, masses, box, s):
    """No surface of this pair passes through the other within Δt."""
    pressed = _stopping(c, dt, hits, box, s)
    if pressed > 0.0:
        kick(c, pressed, _row(hits.normal, c), hits, masses, s)


@njit(error_model="numpy")
def _pushing(c, dt, hits, masses, box, law, s):
    touch = _touch_force(hits.pair[c, 0], hits.pair[c, 1], masses.touch_force)
    rate = _dot(approach(c, hits, box, s), _row(hits.normal, c))
    return normal_impulse(law, hits.gap[c], rate, touch, 1.0 / hits.inverse[c], dt)


@njit(error_model="numpy")
def _touch_force(first, other, forces):
    if other < 0:
        return forces[first]
    return 1.0 / (1.0 / forces[first] + 1.0 / forces[other])


@njit(error_model="numpy")
def _stopping(c, dt, hits, box, s):
    rate = _dot(approach(c, hits, box, s), _row(hits.normal, c))
    return stopping_impulse(hits.gap[c], rate, 1.0 / hits.inverse[c], dt)


@njit(error_model="numpy")
def hold(c, dt, hits, masses, box, s):
    """What is left towards a wall after all that is taken from the body's velocity as a whole.

    Impulses at several corners of one body undo each other a little; this one cannot.
    """
    rate = _dot(approach(c, hits, box, s), _row(hits.normal, c))
    mass = 1.0 / masses.inverse_mass[hits.pair[c, 0]]
    pressed = stopping_impulse(hits.gap[c], rate, mass, dt)
    if pressed > 0.0:
        for d in range(3):
            hits.arm[c, d] = 0.0
        kick(c, pressed, _row(hits.normal, c), hits, masses, s)


@njit(error_model="numpy")
def _rub(c, pressed, hits, masses, box, law, s):
    slip = _across(approach(c, hits, box, s), _row(hits.normal, c))
    speed = math.sqrt(_dot(slip, slip))
    along = _unit(slip, speed)
    mass = 1.0 / inverse_mass(c, hits, masses, s, along)
    kick(c, -friction_impulse(law, pressed, speed, mass), along, hits, masses, s)


@njit(error_model="numpy")
def lubricate_all(met, dt, hits, masses, box, law, s):
    """Squeezing of spheres and, where they are bodies by themselves, shearing."""
    for c in range(met):
        a, b = hits.radius[c, 0], hits.radius[c, 1]
        if a > 0.0 and hits.gap[c] < law.outer_gap:
            rate = _dot(approach(c, hits, box, s), _row(hits.normal, c))
            mass = 1.0 / hits.inverse[c]
            squeezed = squeeze_impulse(law, hits.gap[c], rate, _reduced_radius(a, b), mass, dt)
            kick(c, squeezed, _row(hits.normal, c), hits, masses, s)
            if _are_balls(masses.ball, hits.pair[c, 0], hits.pair[c, 1]):
                _shear_apart(c, dt, hits, masses, box, law, s)


@njit(error_model="numpy")
def drag_apart_all(met, dt, hits, masses, box, law, s):
    """As `lubricate_all`, of bodies whose 1/m is a mobility over Δt: as they go without mass.

    J = −Δt Zḣ/(1 + ZM),  Z = 6πμa_r²(1/h − 1/h_c),  M = Δt/m of the pair
    """
    for c in range(met):
        a, b = hits.radius[c, 0], hits.radius[c, 1]
        if a > 0.0 and hits.gap[c] < law.outer_gap:
            rate = _dot(approach(c, hits, box, s), _row(hits.normal, c))
            resistance = squeeze_resistance(law, hits.gap[c], _reduced_radius(a, b))
            held = -dt * resistance * rate / (1.0 + resistance * dt * hits.inverse[c])
            kick(c, held, _row(hits.normal, c), hits, masses, s)
            if _are_balls(masses.ball, hits.pair[c, 0], hits.pair[c, 1]):
                _shear_apart(c, dt, hits, masses, box, law, s)


@njit(error_model="numpy")
def _reduced_radius(a, b):
    """ab/(a+b); a at something flat, b = ∞."""
    return a if math.isinf(b) else a * b / (a + b)


@njit(error_model="numpy")
def _are_balls(ball, first, other):
    """Whether each body, but for a wall, is one sphere about its own position."""
    return ball[first] and (other < 0 or ball[other])


@njit(error_model="numpy")
def _shear_apart(c, dt, hits, masses, box, law, s):
    n, first, other = _row(hits.normal, c), hits.pair[c, 0], hits.pair[c, 1]
    slip = _across(approach(c, hits, box, s), n)
    # The line of centres runs from the first to the second, against n.
    roll = _cross(n, _relative_spin(s.spin, first, other))
    force, couple = _shear(c, dt, hits, masses, law, s, slip, roll)
    kick(c, 1.0, force, hits, masses, s)
    moment = _cross(couple, n)
    _turn_by(s, first, 1.0, moment)
    if other >= 0:
        _turn_by(s, other, -1.0, moment)


@njit(error_model="numpy")
def _relative_spin(spin, first, other):
    if other < 0:
        return _row(spin, first)
    return (
        spin[first, 0] - spin[other, 0],
        spin[first, 1] - spin[other, 1],
        spin[first, 2] - spin[other, 2],
    )


@njit(error_model="numpy")
def _shear(c, dt, hits, masses, law, s, slip, roll):
    """Impulses −ΔtD(s, w)₁, D = ((A, B), (B, C)); the implicit Euler rule, stable for any Δt."""
    gap, a, b = hits.gap[c], hits.radius[c, 0], hits.radius[c, 1]
    A, B, C = shear_resistances(law, gap, a, b)
    first, other = hits.pair[c, 0], hits.pair[c, 1]
    inverse, turn = masses.inverse_mass[first], s.mobility[first, 0, 0]
    other_inverse = masses.inverse_mass[other] if other >= 0 else 0.0
    other_turn = s.mobility[other, 0, 0] if other >= 0 else 0.0
    arm = a + 0.5 * gap
    other_arm = b + 0.5 * gap if other >= 0 else 0.0
    m_ss = inverse + arm * arm * turn + (other_inverse + other_arm * other_arm * other_turn)
    m_sw, m_ww = arm * turn - other_arm * other_turn, turn + other_turn
    p, q = 1.0 + dt * (m_ss * A + m_sw * B), dt * (m_ss * B + m_sw * C)
    r, t = dt * (m_sw * A + m_ww * B), 1.0 + dt * (m_sw * B + m_ww * C)
    scale = -dt / (p * t - q * r)
    f_s, f_w = scale * (A * t - B * r), scale * (B * p - A * q)
    c_s, c_w = scale * (B * t - C * r), scale * (C * p - B * q)
    return _mixed(f_s, slip, f_w, roll), _mixed(c_s, slip, c_w, roll)


@njit(error_model="numpy")
def approach(c, hits, box, s):
    """v₁ − v₂ at the point of contact."""
    first = _point_velocity(s.velocity, s.spin, hits.pair[c, 0], _row(hits.arm, c))
    other = _other_velocity(c, hits, box, s)
    return first[0] - other[0], first[1] - other[1], first[2] - other[2]


@njit(error_model="numpy")
def _other_velocity(c, hits, box, s):
    o = hits.pair[c, 1]
    if o >= 0:
        return _point_velocity(s.velocity, s.spin, o, _row(hits.other_arm, c))
    axis, side = (-1 - o) // 2, (-1 - o) % 2
    walls = box.wall_velocity
    return walls[axis, side, 0], walls[axis, side, 1], walls[axis, side, 2]


@njit(error_model="numpy")
def inverse_mass(c, hits, masses, s, along):
    """1/m = Σ(1/mᵢ + (rᵢ×u)·Iᵢ⁻¹(rᵢ×u)) of the pair, for impulses along u."""
    b, o = hits.pair[c, 0], hits.pair[c, 1]
    total = _give(masses.inverse_mass, s.mobility, b, _row(hits.arm, c), along)
    return total + _give(masses.inverse_mass, s.mobility, o, _row(hits.other_arm, c), along)


@njit(error_model="numpy")
def _give(inverse_mass, mobility, b, arm, along):
    if b < 0:
        return 0.0
    turned = _cross(arm, along)
    return inverse_mass[b] + _dot(turned, _times(mobility, b, turned))


@njit(error_model="numpy")
def keep_within_walls(met, dt, hits, masses, box, s):
    """The last word of a sub-step: no surface passes through a wall within Δt."""
    for c in range(met):
        if hits.pair[c, 1] < 0:
            stop(c, dt, hits, masses, box, s)
    for c in range(met):
        if hits.pair[c, 1] < 0:
            hold(c, dt, hits, masses, box, s)


@njit(error_model="numpy")
def kick(c, size, along, hits, masses, s):
    """The impulse on the first body, its opposite on the second, at the point of contact."""
    b, o = hits.pair[c, 0], hits.pair[c, 1]
    _take(s, masses, b, size, along, _row(hits.arm, c))
    if o >= 0:
        _take(s, masses, o, -size, along, _row(hits.other_arm, c))
    else:
        for d in range(3):
            s.wall_impulse[(-1 - o) // 2, (-1 - o) % 2, d] -= size * along[d]


@njit(error_model="numpy")
def _take(s, masses, b, size, along, arm):
    for d in range(3):
        faster = masses.inverse_mass[b] * size * along[d]
        s.impulse[b, d] += size * along[d]
        s.gain[b, d] += faster
        s.velocity[b, d] += faster
    _turn_by(s, b, size, _cross(arm, along))


@njit(error_model="numpy")
def _turn_by(s, b, size, moment):
    turned = _times(s.mobility, b, moment)
    for d in range(3):
        faster = size * turned[d]
        s.angular_impulse[b, d] += size * moment[d]
        s.spin_gain[b, d] += faster
        s.spin[b, d] += faster


@njit(error_model="numpy")
def _point_velocity(velocity, spin, b, arm):
    x, y, z = _cross(_row(spin, b), arm)
    return x + velocity[b, 0], y + velocity[b, 1], z + velocity[b, 2]


@njit(error_model="numpy")
def _row(table, i):
    return table[i, 0], table[i, 1], table[i, 2]


@njit(error_model="numpy")
def _times(table, i, a):
    """Matrix i times a."""
    return (
        table[i, 0, 0] * a[0] + table[i, 0, 1] * a[1] + table[i, 0, 2] * a[2],
        table[i, 1, 0] * a[0] + table[i, 1, 1] * a[1] + table[i, 1, 2] * a[2],
        table[i, 2, 0] * a[0] + table[i, 2, 1] * a[1] + table[i, 2, 2] * a[2],
    )


@njit(error_model="numpy")
def _mixed(f, a, g, b):
    return f * a[0] + g * b[0], f * a[1] + g * b[1], f * a[2] + g * b[2]


@njit(error_model="numpy")
def _unit(a, size):
    """a over its size; where that is zero, a."""
    size = size if size > 0.0 else 1.0
    return a[0] / size, a[1] / size, a[2] / size


@njit(error_model="numpy")
def _across(a, n):
    """What of a is normal to n."""
    along = _dot(a, n)
    return a[0] - along * n[0], a[1] - along * n[1], a[2] - along * n[2]


@njit(error_model="numpy")
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(error_model="numpy")
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
