"""Impulses of one pair in contact, as kernels: each on both bodies at one point.

    V₁ += J/m₁,  Ω₁ += I₁⁻¹(r₁×J),   V₂ −= J/m₂,  Ω₂ −= I₂⁻¹(r₂×J)

r is the way from a body's position to the point. A wall, or a body that is held or moved, has
1/m = 0 and I⁻¹ = 0. The pair is number `c` of the hits; its second body is below 0 for a wall.
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


@njit
def push(c, dt, hits, masses, box, law, s):
    """Repulsion with damping, and the friction that it allows."""
    b, o = hits.pair[c, 0], hits.pair[c, 1]
    softness = 1.0 / masses.touch_force[b]
    if o >= 0:
        softness += 1.0 / masses.touch_force[o]
    rate = _dot(approach(c, hits, box, s), hits.normal[c])
    pressed = normal_impulse(law, hits.gap[c], rate, 1.0 / softness, 1.0 / hits.inverse[c], dt)
    if pressed > 0.0:
        kick(c, pressed, _row(hits.normal, c), hits, masses, s)
        _rub(c, pressed, hits, masses, box, law, s)


@njit
def stop(c, dt, hits, masses, box, law, s, rubbing):
    """No surface passes through another within Δt."""
    rate = _dot(approach(c, hits, box, s), hits.normal[c])
    pressed = stopping_impulse(hits.gap[c], rate, 1.0 / hits.inverse[c], dt)
    if pressed > 0.0:
        kick(c, pressed, _row(hits.normal, c), hits, masses, s)
        if rubbing:
            _rub(c, pressed, hits, masses, box, law, s)


@njit
def hold(c, dt, hits, masses, box, s):
    """What is left towards a wall after all that is taken from the body's velocity as a whole.

    Impulses at several corners of one body undo each other a little; this one cannot.
    """
    rate = _dot(approach(c, hits, box, s), hits.normal[c])
    mass = 1.0 / masses.inverse_mass[hits.pair[c, 0]]
    pressed = stopping_impulse(hits.gap[c], rate, mass, dt)
    if pressed > 0.0:
        for d in range(3):
            hits.arm[c, d] = 0.0
        kick(c, pressed, _row(hits.normal, c), hits, masses, s)


@njit
def _rub(c, pressed, hits, masses, box, law, s):
    if law.friction <= 0.0:
        return
    slip = _across(approach(c, hits, box, s), hits.normal[c])
    speed = math.sqrt(_dot(slip, slip))
    if speed <= 0.0:
        return
    along = (slip[0] / speed, slip[1] / speed, slip[2] / speed)
    mass = 1.0 / inverse_mass(c, hits, masses, s, along)
    kick(c, -friction_impulse(law, pressed, speed, mass), along, hits, masses, s)


@njit
def lubricate(c, dt, hits, masses, box, law, s, a, b):
    """Squeezing, and shearing of round bodies, of spheres of radii a and b (∞: a wall)."""
    gap, n = hits.gap[c], _row(hits.normal, c)
    if gap >= law.outer_gap:
        return
    rate = _dot(approach(c, hits, box, s), n)
    reduced = a if math.isinf(b) else a * b / (a + b)
    squeezed = squeeze_impulse(law, gap, rate, reduced, 1.0 / hits.inverse[c], dt)
    kick(c, squeezed, n, hits, masses, s)
    shear(c, dt, hits, masses, box, law, s, a, b)


@njit
def drag_apart(c, dt, hits, masses, box, law, s, a, b):
    """As `lubricate`, of bodies whose 1/m is a mobility over Δt: what they would do without mass.

    J = −Δt Zḣ/(1 + ZM),  Z = 6πμa_r²(1/h − 1/h_c),  M = Δt/m of the pair
    """
    gap, n = hits.gap[c], _row(hits.normal, c)
    if gap >= law.outer_gap:
        return
    rate = _dot(approach(c, hits, box, s), n)
    reduced = a if math.isinf(b) else a * b / (a + b)
    resistance = squeeze_resistance(law, gap, reduced)
    held = -dt * resistance * rate / (1.0 + resistance * dt * hits.inverse[c])
    kick(c, held, n, hits, masses, s)
    shear(c, dt, hits, masses, box, law, s, a, b)


@njit
def shear(c, dt, hits, masses, box, law, s, a, b):
    """What shearing adds to `lubricate`."""
    n, first, second = _row(hits.normal, c), hits.pair[c, 0], hits.pair[c, 1]
    if not masses.ball[first] or (second >= 0 and not masses.ball[second]):
        return
    slip = _across(approach(c, hits, box, s), n)
    w = _row(s.spin, first)
    if second >= 0:
        w = (w[0] - s.spin[second, 0], w[1] - s.spin[second, 1], w[2] - s.spin[second, 2])
    # The line of centres runs from the first to the second, against n.
    force, couple = _shear(c, dt, hits, masses, law, s, a, b, slip, _cross(n, w))
    kick(c, 1.0, force, hits, masses, s)
    moment = _cross(couple, n)
    _turn_by(s, first, 1.0, moment)
    if second >= 0:
        _turn_by(s, second, -1.0, moment)


@njit
def _shear(c, dt, hits, masses, law, s, a, b, slip, roll):
    """Impulses −ΔtD(s, w)₁, D = ((A, B), (B, C)); the implicit Euler rule, stable for any Δt."""
    gap, first, second = hits.gap[c], hits.pair[c, 0], hits.pair[c, 1]
    A, B, C = shear_resistances(law, gap, a, b)
    arm, turn = a + 0.5 * gap, s.mobility[first, 0, 0]
    m_ss = masses.inverse_mass[first] + arm * arm * turn
    m_sw, m_ww = arm * turn, turn
    if second >= 0:
        arm, turn = b + 0.5 * gap, s.mobility[second, 0, 0]
        m_ss += masses.inverse_mass[second] + arm * arm * turn
        m_sw -= arm * turn
        m_ww += turn
    p, q = 1.0 + dt * (m_ss * A + m_sw * B), dt * (m_ss * B + m_sw * C)
    r, t = dt * (m_sw * A + m_ww * B), 1.0 + dt * (m_sw * B + m_ww * C)
    scale = -dt / (p * t - q * r)
    f_s, f_w = scale * (A * t - B * r), scale * (B * p - A * q)
    c_s, c_w = scale * (B * t - C * r), scale * (C * p - B * q)
    return _mixed(f_s, slip, f_w, roll), _mixed(c_s, slip, c_w, roll)


@njit
def approach(c, hits, box, s):
    """v₁ − v₂ at the point of contact."""
    b, o = hits.pair[c, 0], hits.pair[c, 1]
    x, y, z = _point_velocity(s, b, hits.arm[c])
    if o >= 0:
        u, v, w = _point_velocity(s, o, hits.other_arm[c])
    else:
        u, v, w = _row(box.wall_velocity[(-1 - o) // 2], (-1 - o) % 2)
    return x - u, y - v, z - w


@njit
def inverse_mass(c, hits, masses, s, along):
    """1/m = Σ(1/mᵢ + (rᵢ×u)·Iᵢ⁻¹(rᵢ×u)) of the pair, for impulses along u."""
    b, o = hits.pair[c, 0], hits.pair[c, 1]
    total = _give(masses, s, b, hits.arm[c], along)
    if o >= 0:
        total += _give(masses, s, o, hits.other_arm[c], along)
    return total


@njit
def _give(masses, s, b, arm, along):
    turned = _cross(arm, along)
    total = masses.inverse_mass[b]
    for d in range(3):
        total += turned[d] * _dot(s.mobility[b, d], turned)
    return total


@njit
def keep_within_walls(met, dt, hits, masses, box, law, s):
    """The last word of a sub-step: no surface passes through a wall within Δt."""
    for c in range(met):
        if hits.pair[c, 1] < 0:
            stop(c, dt, hits, masses, box, law, s, False)
    for c in range(met):
        if hits.pair[c, 1] < 0:
            hold(c, dt, hits, masses, box, s)


@njit
def kick(c, size, along, hits, masses, s):
    """The impulse on the first body, its opposite on the second, at the point of contact."""
    b, o = hits.pair[c, 0], hits.pair[c, 1]
    _take(s, masses, b, size, along, hits.arm[c])
    if o >= 0:
        _take(s, masses, o, -size, along, hits.other_arm[c])
    else:
        for d in range(3):
            s.wall_impulse[(-1 - o) // 2, (-1 - o) % 2, d] -= size * along[d]


@njit
def _take(s, masses, b, size, along, arm):
    for d in range(3):
        faster = masses.inverse_mass[b] * size * along[d]
        s.impulse[b, d] += size * along[d]
        s.gain[b, d] += faster
        s.velocity[b, d] += faster
    _turn_by(s, b, size, _cross(arm, along))


@njit
def _turn_by(s, b, size, moment):
    for d in range(3):
        faster = size * _dot(s.mobility[b, d], moment)
        s.angular_impulse[b, d] += size * moment[d]
        s.spin_gain[b, d] += faster
        s.spin[b, d] += faster


@njit
def _point_velocity(s, b, arm):
    x, y, z = _cross(s.spin[b], arm)
    return x + s.velocity[b, 0], y + s.velocity[b, 1], z + s.velocity[b, 2]


@njit
def _row(table, i):
    return table[i, 0], table[i, 1], table[i, 2]


@njit
def _mixed(f, a, g, b):
    return f * a[0] + g * b[0], f * a[1] + g * b[1], f * a[2] + g * b[2]


@njit
def _across(a, n):
    """What of a is normal to n."""
    along = _dot(a, n)
    return a[0] - along * n[0], a[1] - along * n[1], a[2] - along * n[2]


@njit
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit
def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
