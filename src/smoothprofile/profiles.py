"""Indicator functions φ(d; ξ): one inside a particle, zero in the fluid, smooth between.

d is the signed distance to the surface, negative inside, ξ the thickness of the interface and
z = d/ξ. Every profile exists twice: as NumPy functions for theory and tests, and as the scalar
kernel `indicator` for the loops that paint.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numba import njit

from smoothprofile.errors import CaseError

TANH = 0
QUARTIC = 1
QUARTIC_CENTRED = 2
SINE = 3

# ∫(φ − H(−z))dz of the quartic as printed: its mean over the transition is 8/15, not ½.
QUARTIC_EXCESS = 1.0 / 30.0


@dataclass(frozen=True)
class Profile:
    """φ(z), z = d/ξ, with what painting and theory must know of it.

    code         the number `indicator` knows the profile by
    half_width   |z| beyond which φ counts as 0 or 1 (for tanh, 1e-7 from it)
    core, edge   φ = 1 exactly for z ≤ core and 0 exactly for z ≥ edge; infinite for tanh
    value        z -> φ
    slope        z -> dφ/dz
    fluid_slope  z -> d ln(1−φ)/dz, without cancellation; +inf where φ = 1
    """

    name: str
    code: int
    half_width: float
    core: float
    edge: float
    value: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    slope: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    fluid_slope: Callable[[np.ndarray], np.ndarray] = field(repr=False)


def _tanh_value(z):
    return 0.5 * (1.0 - np.tanh(z))


def _tanh_slope(z):
    return -2.0 * _tanh_value(z) * _tanh_value(np.negative(z))


def _tanh_fluid_slope(z):
    return 2.0 * _tanh_value(z)


def _quartic_value(z):
    t = np.clip(np.add(z, 0.5), 0.0, 1.0)
    return (1.0 - t * t) ** 2


def _quartic_slope(z):
    t = np.clip(np.add(z, 0.5), 0.0, 1.0)
    return -4.0 * t * (1.0 - t * t)


def _quartic_fluid_slope(z):
    t = np.clip(np.add(z, 0.5), 0.0, 1.0)
    inside = t == 0.0
    s = np.where(inside, 1.0, t)
    return np.where(inside, np.inf, 4.0 * (1.0 - s * s) / (s * (2.0 - s * s)))


def _centred(function):
    # Moved into the solid by the excess: the curve that stood at z + 1/30 stands at z.
    return lambda z: function(np.add(z, QUARTIC_EXCESS))


def _sine_value(z):
    return 0.5 * (1.0 - np.sin(np.pi * np.clip(z, -0.5, 0.5)))


def _sine_slope(z):
    return -0.5 * np.pi * np.cos(np.pi * np.clip(z, -0.5, 0.5))


def _sine_fluid_slope(z):
    z = np.clip(z, -0.5, 0.5)
    return np.where(z == -0.5, np.inf, np.pi * np.tan(0.5 * np.pi * (0.5 - z)))


PROFILES = {
    profile.name: profile
    for profile in (
        Profile("tanh", TANH, 8.0, -np.inf, np.inf, _tanh_value, _tanh_slope, _tanh_fluid_slope),
        Profile(
            "quartic", QUARTIC, 0.5, -0.5, 0.5, _quartic_value, _quartic_slope, _quartic_fluid_slope
        ),
        Profile(
            "quartic-centred",
            QUARTIC_CENTRED,
            0.5 + QUARTIC_EXCESS,
            -0.5 - QUARTIC_EXCESS,
            0.5 - QUARTIC_EXCESS,
            _centred(_quartic_value),
            _centred(_quartic_slope),
            _centred(_quartic_fluid_slope),
        ),
        Profile("sine", SINE, 0.5, -0.5, 0.5, _sine_value, _sine_slope, _sine_fluid_slope),
    )
}
"""The profiles by name.

    tanh             ½(1 − tanh z)                     the thesis' (2.2)
    quartic          (1−t²)², t = z+½ kept in [0,1]    the thesis' (4.13–4.14)
    quartic-centred  the same moved by −1/30, so that ∫(φ − H(−z))dz = 0
    sine             ½(1 − sin πz) for |z| ≤ ½
"""


def profile_named(name: str) -> Profile:
    """The profile of that name; CaseError with the list of names otherwise."""
    if name not in PROFILES:
        raise CaseError(f"profile.kind is {name!r}; it must be one of {', '.join(PROFILES)}.")
    return PROFILES[name]


@njit(inline="always")
def indicator(code, z):
    """φ(z) of the profile numbered `code`; scalar, for use inside kernels. z = d/ξ."""
    if code == TANH:
        phi = 0.5 * (1.0 - math.tanh(z))
    elif code == SINE:
        phi = 0.5 * (1.0 - math.sin(math.pi * min(max(z, -0.5), 0.5)))
    else:
        shift = 0.5 if code == QUARTIC else 0.5 + QUARTIC_EXCESS
        t = min(max(z + shift, 0.0), 1.0)
        phi = (1.0 - t * t) ** 2
    return phi
