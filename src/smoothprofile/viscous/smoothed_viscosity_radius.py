"""Where a sphere of smoothed viscosity is painted so that it acts as large as it is.

    drag:       U/F of the painted ball = U/F of the sharp one (Hadamard and Rybczynski)
    torque:     Ω/T of the painted ball = Ω/T of the sharp one
    stresslet:  S/E of the painted ball = S/E of the sharp one

by the radial problem of `theory.viscous_drop`; the one that is chosen is then exact for a lone
sphere in an unbounded fluid, whatever ξ, and the others keep an error.
"""

import math
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from smoothprofile.errors import CaseError
from smoothprofile.profiles import Profile, profile_named
from smoothprofile.theory import viscous_drop

MOTIONS = ("drag", "torque", "stresslet")
LARGEST = 1e6
"""Of R and 1/R."""
THICKEST, THINNEST = 0.8, 1e-4
"""Of ξ over the radius."""


def error_of(
    motion: str,
    painted: float,
    thickness: float,
    ratio: float,
    profile: Profile | str = "tanh",
    smoothing: str = "tensor",
) -> float:
    """Drag F/U, torque T/Ω or stresslet S/E of a lone sphere, over a sharp one's, a = 1, less 1.

    painted, thickness: in radii of the sharp sphere. ratio: R = μ_s/μ_f. Positive: acts larger.
    """
    profile = profile_named(profile) if isinstance(profile, str) else profile
    edges = viscous_drop.interface_edges(painted, thickness, profile.core, profile.edge, ratio)

    def indicator(r: np.ndarray) -> np.ndarray:
        return profile.value((r - painted) / thickness)

    if motion == "torque":
        found = viscous_drop.spin(ratio, indicator, smoothing, edges)
        return viscous_drop.sharp_spin(ratio) / found - 1.0
    if motion == "drag":
        found = viscous_drop.mobility(ratio, indicator, smoothing, edges)
        return viscous_drop.sharp_mobility(ratio) / found - 1.0
    found = viscous_drop.stresslet(ratio, indicator, smoothing, edges)
    return found / viscous_drop.sharp_stresslet(ratio) - 1.0


def painted_radius(
    radius: float,
    thickness: float,
    ratio: float,
    profile: Profile | str = "tanh",
    smoothing: str = "tensor",
    motion: str = "drag",
) -> float:
    """The radius a* to paint with: `error_of`(motion, a*) = 0.

    tanh, drag, (a* − a)/a:

        R       smoothing       ξ/a = 0.05    0.1         0.2
        10      arithmetic     −0.04243     −0.08518    −0.18626
        10      harmonic        0.01514      0.02995     0.04400
        10      tensor         −0.00590     −0.02548    −0.10538
        1000    arithmetic     −0.16648     −0.32324    −0.61977
        1000    harmonic        0.00622      0.02215     0.07101
        1000    tensor         −0.05647     −0.16654    −0.42861

    Arithmetic smoothing with tanh is harmonic smoothing moved out by ½ξ ln R, which is why the
    two agree once they are retracted. The tensor resists strains along its layer from where
    Rφ ~ 1 on, which no motion of a rigid surface has, and needs R(ξ/a)³ ≪ 1.

    CaseError if ξ > 0.8a or ξ < 1e-4a, if R or 1/R > 1e6, if R = 1 for the stresslet, or if no
    radius above ξ (tanh) does it, as for arithmetic smoothing at high R and thick layers.
    """
    profile = profile_named(profile) if isinstance(profile, str) else profile
    for name, value in (("radius", radius), ("thickness", thickness), ("ratio", ratio)):
        if not (math.isfinite(value) and value > 0.0):
            raise CaseError(f"{name} is {value}; it must be a positive number.")
    if not THINNEST <= thickness / radius <= THICKEST:
        raise CaseError(
            f"thickness is {thickness / radius:.3g} of the radius; it must lie between "
            f"{THINNEST:g} and {THICKEST:g} of it."
        )
    if not 1.0 / LARGEST <= ratio <= LARGEST:
        raise CaseError(f"ratio is {ratio:g}; it must lie between {1 / LARGEST:g} and {LARGEST:g}.")
    if smoothing not in viscous_drop.SMOOTHINGS:
        known = ", ".join(viscous_drop.SMOOTHINGS)
        raise CaseError(f"smoothing is {smoothing!r}; it must be one of {known}.")
    if motion not in MOTIONS or (motion == "stresslet" and ratio == 1.0):
        raise CaseError(
            f"motion is {motion!r} at a ratio of {ratio:g}; it must be drag, torque, or "
            "stresslet at a ratio other than 1."
        )
    sphere = (float(thickness / radius), float(ratio), profile, smoothing, motion)
    return radius * _painted_radius(*sphere)


@lru_cache(maxsize=1024)
def _painted_radius(
    thickness: float, ratio: float, profile: Profile, smoothing: str, motion: str
) -> float:
    def excess(painted: float) -> float:
        return error_of(motion, painted, thickness, ratio, profile, smoothing)

    # A profile that ends needs no more than its own half width inside.
    reach = 1.0 if math.isinf(profile.core) else -profile.core
    low, high = 1.01 * reach * thickness, 1.0
    below, above = excess(low), excess(high)
    while below * above > 0.0 and high < 2.0:
        high *= 1.1
        above = excess(high)
    if below * above > 0.0:
        raise CaseError(
            f"thickness is {thickness:.3g} of a sphere's radius, and no painted radius gives it "
            f"its own {motion} at a viscosity ratio of {ratio:g} with {smoothing} smoothing; take "
            "a thinner layer, or another smoothing."
        )
    return float(brentq(excess, low, high, xtol=1e-10))
