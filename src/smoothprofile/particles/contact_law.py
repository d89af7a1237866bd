"""Laws of contact for one pair, as scalar kernels that return impulses of one sub-step.

    f = F₀((s−h)/s)²           0 ≤ h < s        U = F₀(s−h)³/3s²
    f = F₀(1 − 2h/s)           h < 0            U = F₀(s/3 − h + h²/s)
    f_d = −√3 ζ√(m f′) ḣ,      e = exp(−2ζ arccos ζ/√(1−ζ²))

h the gap, s the range, F₀ the force at touch, m the mass of the pair (1/m = n·M⁻¹n at the point of
contact). f + f_d never pulls. With y ∝ (s−h)^{3/2} the damped motion at h ≥ 0 is that of a linear
spring of damping ratio ζ, so that the restitution e is one number for all speeds.

Friction:  f_t = −μ f_n v_t/max(|v_t|, v₀), and never more than brings v_t to rest.
"""

import math
from typing import NamedTuple

from numba import njit
from scipy.optimize import brentq

# A repulsion that is stiff beyond the sub-step's reach, or that starts deep in overlap, drives
# the pair apart no faster than the energy F₀s/3 that it stores at touch would.
_STORED = 2.0 / 3.0


class Law(NamedTuple):
    """s; √3ζ; μ; v₀; and of lubrication: viscosity (0 for none), largest and smallest gap."""

    range: float
    damping: float
    friction: float
    slip_speed: float
    viscosity: float
    outer_gap: float
    inner_gap: float


def restitution_of(ratio: float) -> float:
    """e = exp(−2ζ arccos ζ/√(1−ζ²)), 0 ≤ ζ; exp(−2ζ arcosh ζ/√(ζ²−1)) above 1."""
    if ratio < 1.0:
        return math.exp(-2.0 * ratio * math.acos(ratio) / math.sqrt(1.0 - ratio**2))
    if ratio == 1.0:
        return math.exp(-2.0)
    return math.exp(-2.0 * ratio * math.acosh(ratio) / math.sqrt(ratio**2 - 1.0))


def damping_ratio(restitution: float) -> float:
    """ζ of that restitution e, 0 < e ≤ 1."""
    if restitution >= 1.0:
        return 0.0
    high = 1.0
    while restitution_of(high) > restitution:
        high *= 2.0
    return float(brentq(lambda z: restitution_of(z) - restitution, 0.0, high, xtol=1e-14))


@njit(error_model="numpy")
def repulsion(law, gap, touch_force):
    """f and −df/dh."""
    s = law.range
    if gap >= s:
        return 0.0, 0.0
    if gap >= 0.0:
        closed = (s - gap) / s
        return touch_force * closed * closed, 2.0 * touch_force * closed / s
    return touch_force * (1.0 - 2.0 * gap / s), 2.0 * touch_force / s


@njit(error_model="numpy")
def normal_impulse(law, gap, rate, touch_force, mass, dt):
    """J ≥ 0 along n in Δt, of a pair whose gap changes at `rate` ḣ."""
    force, slope = repulsion(law, gap, touch_force)
    if force <= 0.0:
        return 0.0
    push = (force - law.damping * math.sqrt(mass * slope) * rate) * dt
    s = law.range
    fastest = min(math.sqrt(_STORED * touch_force * s / mass), (s - gap) / dt)
    return max(min(push, mass * (fastest - rate)), 0.0)


@njit(error_model="numpy")
def stopping_impulse(gap, rate, mass, dt):
    """J ≥ 0 that leaves a pair no closer than touching after Δt, or no deeper than it is."""
    slowest = -max(gap, 0.0) / dt
    return max(mass * (slowest - rate), 0.0)


@njit(error_model="numpy")
def friction_impulse(law, pressed, slip, mass):
    """|J_t| against a slip of that speed, `pressed` the normal impulse, `mass` along the slip."""
    if slip <= 0.0:
        return 0.0
    return min(law.friction * pressed * min(1.0, slip / law.slip_speed), mass * slip)


@njit(error_model="numpy")
def squeeze_impulse(law, gap, rate, reduced_radius, mass, dt):
    """J = −mḣ(1 − exp(−ZΔt/m)),  Z = 6πμa_r²(1/h − 1/h_c): exact for the pair by itself.

    a_r = a₁a₂/(a₁+a₂); a wall has a₂ = ∞ (Jeffrey & Onishi, J. Fluid Mech. 139, 1984).
    """
    resistance = squeeze_resistance(law, gap, reduced_radius)
    return mass * rate * math.expm1(-resistance * dt / mass)


@njit(error_model="numpy")
def squeeze_resistance(law, gap, reduced_radius):
    """Z, of the gap h or of the smallest, whichever is larger; 0 from h_c on."""
    h = max(gap, law.inner_gap)
    if h >= law.outer_gap:
        return 0.0
    square = reduced_radius * reduced_radius
    return 6.0 * math.pi * law.viscosity * square * (1.0 / h - 1.0 / law.outer_gap)


@njit(error_model="numpy")
def shear_resistances(law, gap, a, b):
    """A, B, C of f = −(As + Bw), c = −(Bs + Cw): leading logarithms, times ln(h_c/h).

    s is the slip at the point of contact and w the difference of the spins across the line of
    centres; f acts on the first sphere at the point of contact and c is a couple on it, with their
    opposites on the second. So put, two rigidly turning spheres feel nothing, and
    A = (8/5)πμa_r(2a²+ab+2b²)/(a+b)², B = (12/5)πμa_r²(a−b)/(a+b), C = (24/5)πμa_r³
    are Jeffrey & Onishi's Y^A, Y^B, Y^C. b = ∞ is a wall.
    """
    h = max(gap, law.inner_gap)
    if h >= law.outer_gap:
        return 0.0, 0.0, 0.0
    share = 1.0 if math.isinf(b) else b / (a + b)
    r = a * share
    scale = math.pi * law.viscosity * math.log(law.outer_gap / h)
    mixed = 2.0 * (1.0 - share) ** 2 + share * (1.0 - share) + 2.0 * share**2
    return (1.6 * scale * r * mixed, 2.4 * scale * r * r * (1.0 - 2.0 * share),
            4.8 * scale * r**3)  # fmt: skip
