"""How large a smoothed dielectric sphere is to an electric field, and where to paint it instead.

    (r²ε_n F')' = l(l+1) ε_t F,    F → E rˡ − B r^{−(l+1)},    B = E K_l a_eff^{2l+1}

K_l = l(R−1)/(lR+l+1), R = ε₁/ε₂. The effective radius a_eff is that of the sharp sphere with the
same moment B in the same field: all that the field outside, and the force, know of the sphere.
Two effects of the layer, of thickness ξ, part it from the painted radius a:

    a_eff = a + ξ (lR s_n + (l+1) s_t)/(lR + l + 1) + O(ξ²)

The layer drops the potential along its normal as a sharp surface moved out by s_nξ would, and
carries flux along itself as one moved out by s_tξ would; `theory.dielectric` has the derivation.
Arithmetic smoothing errs in the first, harmonic in the second. The tensor, harmonic along the
normal and arithmetic across it, has s_n = s_t = m₀ = ∫(φ − H(−z))dz, zero for centred profiles.
Of the tensor more is known. Let y(r) be a_eff^{2l+1} of the part of the sphere within r. Written
for y, the problem is

    y' = φ r^{2l} [2l+1 + C l(l+1)/(2l+1) (1 − y/r^{2l+1})²],    C = (R−1)²/R,    y(0) = 0

(`solve_multipole` has E and B as functions of r; take B/E = K_l y). C is the same for R and 1/R,
hence so is a_eff. The last term vanishes where φ = 1 and counts as ξ³, so that

    a_eff^{2l+1} = (2l+1)∫φ r^{2l}dr + O(ξ³),    a_eff = a + m₀ξ + 2l m₁ξ²/a + O(ξ³)

with m₁ = ∫(φ − H)z dz about the profile's centre: whatever R, the dipole's radius is that of the
sharp sphere of the same volume. The rest is positive, and grows with C and with the width of the
tails: at R = 100 and ξ = 0.1a it is 0.031a for tanh, and below 0.001a for the compact profiles.
"""

import math
from functools import lru_cache

import numpy as np

from smoothprofile.calibration.flow import THICKEST, THINNEST
from smoothprofile.errors import CaseError
from smoothprofile.profiles import Profile, profile_named
from smoothprofile.theory import dielectric

TOLERANCE = 1e-11
TRIALS = 30
# Beyond it or its inverse the radial problem is singular to round-off.
LARGEST_RATIO = 1e9


def effective_radius(
    radius: float,
    thickness: float,
    permittivity_ratio: float,
    profile: Profile | str = "tanh",
    smoothing: str = "tensor",
    multipole: int = 1,
) -> float:
    """a_eff = (B/(E K_l))^{1/(2l+1)} of a sphere painted with `radius`, by the radial problem.

    permittivity_ratio: R = ε₁/ε₂, particle over fluid; at R = 1 the limit, where
    a_eff^{2l+1} = (2l+1)∫φ r^{2l}dr. smoothing: "arithmetic", "harmonic" or "tensor".
    multipole: l; 1 is the dipole, in a uniform field. Tensor smoothing has the same a_eff for R
    and 1/R. The order in ξ/a is first for arithmetic and harmonic, second for tensor and a
    centred profile. (a_eff − a)/a of the dipole, tanh:

        R       smoothing       ξ/a = 0.05    0.1         0.2
        2       arithmetic      0.01039       0.02427     0.06220
        2       harmonic       −0.00691      −0.01014    −0.00515
        2       tensor          0.00208       0.00837     0.03310
        100     arithmetic      0.11120       0.22014     0.43492
        100     harmonic       −0.00410      −0.01113    −0.02922
        100     tensor          0.00766       0.03935     0.15353

    Source: thesis (4.8–4.12, 4.24). CaseError if ξ > 0.8a or ξ < 1e-8a, if R or 1/R > 1e9, or if
    an argument makes no sense.
    """
    profile = _checked(radius, thickness, permittivity_ratio, profile, smoothing, multipole)
    sphere = (float(permittivity_ratio), profile, smoothing, int(multipole))
    return radius * _effective_radius(1.0, float(thickness / radius), *sphere)


def dielectric_radius(
    radius: float,
    thickness: float,
    permittivity_ratio: float,
    profile: Profile | str = "tanh",
    smoothing: str = "tensor",
    multipole: int = 1,
) -> float:
    """The painted radius a* with `effective_radius`(a*) = `radius`.

        a* = a − ξ·`dielectric_slope` − O(ξ²);    tensor: a* = a − m₀ξ − 2l m₁ξ²/a + O(ξ³)

    The moment B of one multipole is then that of the sharp sphere to round-off, for any ξ; the
    others keep an error, of second order in ξ with tensor smoothing. (The thesis paints with
    a²/a_eff instead, which leaves an error of second order in all.) Solved once for each set of
    arguments, in some 10 ms.

    CaseError as for `effective_radius`, and where a* would be below ξ.
    """
    profile = _checked(radius, thickness, permittivity_ratio, profile, smoothing, multipole)
    sphere = (float(permittivity_ratio), profile, smoothing, int(multipole))
    return radius * _dielectric_radius(float(thickness / radius), *sphere)


def dielectric_slope(
    permittivity_ratio: float,
    profile: Profile | str = "tanh",
    smoothing: str = "tensor",
    multipole: int = 1,
) -> float:
    """lim (a_eff − a)/ξ = (lR s_n + (l+1) s_t)/(lR + l + 1) as ξ → 0.

    tanh: arithmetic lR ln R/(2(lR+l+1)), harmonic −(l+1) ln R/(2(lR+l+1)), tensor 0. The thesis
    calls it k f(ε₁), and finds it by laying curves upon each other.
    """
    profile = _checked(1.0, 0.1, permittivity_ratio, profile, smoothing, multipole)
    offsets = _flat_offsets(profile, float(permittivity_ratio), smoothing)
    return dielectric.radius_slope(multipole, permittivity_ratio, *offsets)


def dielectric_offset(
    radius: float,
    thickness: float,
    permittivity_ratio: float,
    profile: Profile | str = "tanh",
    smoothing: str = "tensor",
) -> tuple[float, float]:
    """(o₀, o₁) such that a surface is painted with the distance d − o₀ − o₁κ, κ = κ₁ + κ₂.

        o₀ = −ξ·`dielectric_slope`,    o₁ = (a* − a − o₀)/κ,    κ = 2/a, the dipole of a sphere

    o₀ is a length, o₁ a length squared. For tensor smoothing o₀ = −m₀ξ is zero for a centred
    profile, and exact for a flat interface whatever the field's direction; and o₁ → −m₁ξ², which
    is the cylinder's across the field too: there a_eff = a + m₀ξ + (2l−1)m₁ξ²/a, and κ = 1/a.
    Painting so keeps the volume, and it serves shapes of any curvature.

    For the other smoothings no offset does: a flat interface must be moved by −s_nξ where the
    field is normal to it and by −s_tξ where it is along it. What is returned is the mixture that
    is right for a sphere.
    """
    painted = dielectric_radius(radius, thickness, permittivity_ratio, profile, smoothing)
    flat = -thickness * dielectric_slope(permittivity_ratio, profile, smoothing)
    return flat, 0.5 * radius * (painted - radius - flat)


@lru_cache(maxsize=1024)
def _flat_offsets(profile: Profile, ratio: float, smoothing: str) -> tuple[float, float]:
    return dielectric.flat_offsets(profile.value, ratio, smoothing, profile.core, profile.edge)


@lru_cache(maxsize=1024)
def _effective_radius(
    painted: float, thickness: float, ratio: float, profile: Profile, smoothing: str, degree: int
) -> float:
    edges = dielectric.interface_edges(painted, thickness, profile.core, profile.edge, ratio)

    def indicator(r: np.ndarray) -> np.ndarray:
        return profile.value((r - painted) / thickness)

    found = dielectric.solve_multipole(degree, ratio, indicator, smoothing, edges)
    return found.effective_radius


@lru_cache(maxsize=1024)
def _dielectric_radius(
    thickness: float, ratio: float, profile: Profile, smoothing: str, degree: int
) -> float:
    """`dielectric_radius` for a sphere of radius one, by the secant method.

    a_eff rises with the painted radius, for both permittivities move away from the fluid's
    everywhere; so a root is the only one.
    """

    def excess(painted: float) -> float:
        arguments = (thickness, ratio, profile, smoothing, degree)
        return _effective_radius(painted, *arguments) - 1.0

    slope = dielectric.radius_slope(degree, ratio, *_flat_offsets(profile, ratio, smoothing))
    old = max(1.0 - slope * thickness, thickness)
    old_excess = excess(old)
    new = max(old - old_excess, thickness)
    for _ in range(TRIALS):
        new_excess = excess(new)
        if abs(new_excess) < TOLERANCE:
            return new
        if new == thickness and new_excess > 0.0:
            break
        step = new_excess * (new - old) / (new_excess - old_excess)
        old, old_excess, new = new, new_excess, max(new - step, thickness)
    other = "" if smoothing == "tensor" else ', or electric.smoothing = "tensor"'
    raise CaseError(
        f"electric.thickness is {thickness:.3g} of a sphere's radius, and no painted radius gives "
        f"it its own moment at a permittivity ratio of {ratio:g} with {smoothing} smoothing; take "
        f"a thinner layer (left out, it is .75 of a cell){other}."
    )


def _checked(
    radius: float,
    thickness: float,
    permittivity_ratio: float,
    profile: Profile | str,
    smoothing: str,
    multipole: int,
) -> Profile:
    """The profile; CaseError if any argument makes no sense."""
    lengths = {"radius": radius, "thickness": thickness, "permittivity_ratio": permittivity_ratio}
    for name, value in lengths.items():
        if not (math.isfinite(value) and value > 0.0):
            raise CaseError(f"{name} is {value}; it must be a positive number.")
    if not 1.0 / LARGEST_RATIO <= permittivity_ratio <= LARGEST_RATIO:
        allowed = f"between {1.0 / LARGEST_RATIO:g} and {LARGEST_RATIO:g}"
        raise CaseError(f"permittivity_ratio is {permittivity_ratio:g}; it must be {allowed}.")
    if smoothing not in dielectric.SMOOTHINGS:
        known = ", ".join(dielectric.SMOOTHINGS)
        raise CaseError(f"electric.smoothing is {smoothing!r}; it must be one of {known}.")
    if not (multipole == int(multipole) and multipole >= 1):
        raise CaseError(f"multipole is {multipole}; it must be 1, 2, 3, …")
    if thickness > THICKEST * radius:
        raise CaseError(
            f"electric.thickness is {thickness:g}, {thickness / radius:.2g} of the particle's "
            f"radius {radius:g}; it may be at most {THICKEST:g} of it for a dielectric sphere."
        )
    if thickness < THINNEST * radius:
        raise CaseError(
            f"electric.thickness is {thickness:g}; it must be at least {THINNEST:g} of the "
            f"particle's radius {radius:g} for a dielectric sphere."
        )
    return profile_named(profile) if isinstance(profile, str) else profile
