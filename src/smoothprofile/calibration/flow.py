"""Where to paint a surface so that it acts where it is, and which time step needs no such shift.

The impulse of the smoothed profile method is a drag of resistance γ₀φ/Δt on the predicted
velocity uˢ. At steady state every past velocity is uⁿ = (1−φ)uˢ (in the frame of the solid), and
viscosity acts on W = θuˢ + (1−θ)uⁿ = (1 − (1−θ)φ)uˢ, so that

    ν∇²W − ∇p = γ₀φ/((1 − (1−θ)φ)Δt) W,    ∇·(gW) = 0,    g = (1−φ)/(1 − (1−θ)φ):

a Brinkman problem. With lengths in ξ and k = √(νΔt)/ξ a flat wall depends on k alone. γ₀ and θ
are the scheme's. Exact for the incremental coupling at steady state and Re = 0.
"""

import math
from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from smoothprofile.errors import CaseError
from smoothprofile.profiles import Profile, profile_named
from smoothprofile.schemes import Scheme, scheme_named
from smoothprofile.theory import elements, planar, radial, sharp, straining

THICKEST = 0.8
# Of the radius, for ξ and √(νΔt): r in units of either then still has eight digits.
THINNEST = 1e-8
WALL = 8.0

SHARP: dict[tuple[str, str], tuple[int, Callable[[float, float], float]]] = {
    ("sphere", "translation"): (3, sharp.sphere_drag),
    ("cylinder", "translation"): (2, sharp.cylinder_drag),
    ("sphere", "rotation"): (3, sharp.sphere_torque),
    ("cylinder", "rotation"): (2, sharp.cylinder_torque),
    ("sphere", "straining"): (3, sharp.sphere_stresslet),
}
"""Dimensions of the radial problem, and the exact resistance, by shape and motion."""


def interface_shift(
    profile: Profile | str, k: float, scheme: Scheme | str = "backward-euler"
) -> float:
    """s₀ in W → slope·(y + ξs₀): how far, in ξ, a flat wall painted at y = 0 retreats.

    W'' = χW with χξ² = γ₀φ/((1−(1−θ)φ)k²), k = √(νΔt)/ξ. For tanh and θ = 1

        s₀ = −Γ − ψ(1/(2k')) − k',    k' = k/√γ₀

    (`theory.planar.tanh_shift` has the derivation, and θ < 1); the other profiles are solved
    for. Positive: the solid acts as if smaller than painted. A sphere acts with radius a − ξs₀,
    to first order in ξ.
    """
    profile, scheme = _resolved(profile, scheme)
    _positive(k=k)
    return _interface_shift(profile, float(k), scheme)


@lru_cache(maxsize=1024)
def _interface_shift(profile: Profile, k: float, scheme: Scheme) -> float:
    ratio = k / math.sqrt(scheme.gamma)
    if profile.name == "tanh":
        return planar.tanh_shift(ratio, scheme.implicit)
    resistance, _ = _coefficients(profile, scheme, 0.0, 1.0, k)
    return planar.planar_shift(resistance, profile.core, profile.edge)


def best_ratio(profile: Profile | str = "tanh", scheme: Scheme | str = "backward-euler") -> float:
    """The k = √(νΔt)/ξ with s₀(k) = 0, at which a flat wall acts where it is painted.

    tanh: 0.755222, 0.806794, 0.924955, 1.022576 for backward Euler, Crank–Nicolson, BDF2, BDF3.
    """
    return _best_ratio(*_resolved(profile, scheme))


@lru_cache(maxsize=64)
def _best_ratio(profile: Profile, scheme: Scheme) -> float:
    return brentq(lambda k: _interface_shift(profile, k, scheme), 0.02, 5.0, xtol=1e-13)


def best_time_step(
    thickness: float,
    kinematic_viscosity: float,
    profile: Profile | str = "tanh",
    scheme: Scheme | str = "backward-euler",
) -> float:
    """Δt = (kξ)²/ν with k = `best_ratio`: the step whose flat walls need no shift."""
    _positive(thickness=thickness, kinematic_viscosity=kinematic_viscosity)
    return (best_ratio(profile, scheme) * thickness) ** 2 / kinematic_viscosity


def resistance_ratio(
    radius: float,
    painted: float,
    thickness: float,
    viscous_length: float,
    profile: Profile | str = "tanh",
    scheme: Scheme | str = "backward-euler",
    motion: str = "translation",
    shape: str = "sphere",
    wall: float = WALL,
) -> float:
    """Drag, torque or stresslet of a body painted with radius `painted` over that of `radius`.

    Both in creeping flow inside a concentric wall of radius wall·radius, by the radial problem
    of `theory.radial`. viscous_length: √(νΔt), in the unit of the radius, as the thickness.
    """
    profile, scheme = _resolved(profile, scheme)
    dimension, exact = _sharp(shape, motion)
    _positive(radius=radius, painted=painted, thickness=thickness, viscous_length=viscous_length)
    turning = motion == "rotation"
    resistance, slope = _coefficients(profile, scheme, painted, thickness, viscous_length)
    edges = elements.radial_edges(
        painted, thickness, wall * radius, profile.core, profile.edge, turning
    )
    core = math.isfinite(profile.core)
    if turning:
        found = radial.penalised_torque(dimension, resistance, edges)
    elif motion == "straining":
        found = straining.penalised_stresslet(resistance, slope, edges, core)
    else:
        found = radial.penalised_drag(dimension, resistance, slope, edges, core)
    return found / exact(radius, wall * radius)


def painted_radius(
    radius: float,
    thickness: float,
    viscous_length: float,
    profile: Profile | str = "tanh",
    scheme: Scheme | str = "backward-euler",
    motion: str = "translation",
    shape: str = "sphere",
    wall: float = WALL,
) -> float:
    """The radius a* for which `resistance_ratio` = 1: the sharp body's drag or torque.

        a* = a + s₀ξ + cξ²/a + …

    c is about 0.8 for translation of either shape and tanh, 0.03 for the compact profiles. For
    shear alone c = 0: in u'' + (j/r)u' = χu, which governs both rotations and a cylinder along
    its axis, u = r^{−j/2}v leaves the flat wall's equation but for terms in r⁻². c comes from
    the pressure and from the flow through the layer. (a* − a)/a with the best k, tanh, wall 8a:

        ξ/a                     0.05      0.1       0.2       0.3
        sphere, translation     0.00181   0.00643   0.02100   0.03983
        sphere, rotation       −0.00014  −0.00103  −0.00745  −0.02319
        sphere, straining       0.00329   0.01069   0.02831   0.04058
        cylinder, translation   0.00200   0.00744   0.02645   0.05435
        cylinder, rotation     −0.00005  −0.00039  −0.00279  −0.00880

    One radius cannot serve all: a sphere painted for translation has a torque 0.6, 2.3, 8.7 and
    19 % high at these ξ, and a stresslet 0.4, 1.3, 2.2 and 0.2 % low. The wall matters little: at
    16a the last column of translation is 0.03893 and 0.05086.

    viscous_length: √(νΔt). motion: "translation" (a cylinder's, across its axis), "rotation" (a
    sphere's about a diameter, a cylinder's about its axis) or "straining" (a sphere's). wall: in
    radii, from 3 up. CaseError if ξ > 0.8a, if ξ or √(νΔt) < 1e-8a, or if the radius found would
    be below ξ or above half the wall's.
    """
    profile, scheme = _resolved(profile, scheme)
    _sharp(shape, motion)
    _check_layer(radius, thickness, viscous_length, wall)
    relative = _painted_radius(
        float(thickness / radius),
        float(viscous_length / radius),
        *(profile, scheme, motion, shape, float(wall)),
    )
    return radius * relative


def _check_layer(radius: float, thickness: float, viscous_length: float, wall: float) -> None:
    _positive(radius=radius, thickness=thickness, viscous_length=viscous_length)
    if not wall >= 3.0:
        raise CaseError(f"wall is {wall}; it must be at least 3 radii.")
    if thickness > THICKEST * radius:
        raise CaseError(
            f"profile.thickness is {thickness:g}, {thickness / radius:.2g} of the particle's "
            f"radius {radius:g}; it may be at most {THICKEST:g} of it for the surface to be moved."
        )
    for name, length in (("profile.thickness", thickness), ("√(νΔt) of time.step", viscous_length)):
        if length < THINNEST * radius:
            raise CaseError(
                f"{name} is {length:g}; it must be at least {THINNEST:g} of the particle's "
                f"radius {radius:g} for the surface to be moved."
            )


@lru_cache(maxsize=1024)
def _painted_radius(
    thickness: float,
    viscous_length: float,
    profile: Profile,
    scheme: Scheme,
    motion: str,
    shape: str,
    wall: float,
) -> float:
    """`painted_radius` for a body of radius one."""

    def excess(painted: float) -> float:
        arguments = (profile, scheme, motion, shape, wall)
        return resistance_ratio(1.0, painted, thickness, viscous_length, *arguments) - 1.0

    lowest, highest = thickness, 0.5 * wall
    shift = _interface_shift(profile, viscous_length / thickness, scheme)
    guess = 1.0 + shift * thickness
    below = min(max(guess - thickness**2, lowest), highest)
    above = min(max(guess + thickness**2, lowest), highest)
    # Ever longer strides: thin layers reach the root in a few dozen of them.
    stride = thickness
    while below > lowest and excess(below) > 0.0:
        below, stride = max(below - stride, lowest), 2.0 * stride
    stride = thickness
    while above < highest and excess(above) < 0.0:
        above, stride = min(above + stride, highest), 2.0 * stride
    if not excess(below) <= 0.0 <= excess(above):
        raise CaseError(
            f"√(νΔt)/ξ is {viscous_length / thickness:.3g}, and with profile.thickness "
            f"{thickness:.3g} of a {shape}'s radius no painted radius gives it its own resistance "
            f"there; take a step nearer to √(νΔt)/ξ = {_best_ratio(profile, scheme):.3f}, a "
            f'thinner interface, or profile.retract = "planar".'
        )
    return brentq(excess, below, above, xtol=1e-9)


def surface_offset(
    radius: float,
    thickness: float,
    viscous_length: float,
    profile: Profile | str = "tanh",
    scheme: Scheme | str = "backward-euler",
    motion: str = "translation",
    shape: str = "sphere",
) -> tuple[float, float]:
    """(o₀, o₁) such that a surface is painted with the distance d − o₀ − o₁κ, κ = κ₁ + κ₂.

        o₀ = s₀ξ,    o₁ = (a* − a − o₀)/κ,    κ = 2/a for a sphere, 1/a for a cylinder

    a* is the `painted_radius` of `shape`. o₀ is a length, o₁ a length squared.

    No rule in κ₁ + κ₂ serves both shapes. In translation what counts is curvature along the
    flow, which both have once: the cylinder's whole correction is not half the sphere's but 1.16
    to 1.36 times it (ξ/a = 0.1 to 0.3, wall 8a; 1.10 to 1.28 in a far wall). The sphere's o₁ on
    a cylinder leaves its drag 0.4, 1.4 and 3.0 % low at ξ/a = 0.1, 0.2, 0.3 (0.6, 2.3 and 4.7 %
    without o₁). So take each shape's own o₁; where they mix, the sphere's correction with the
    larger principal curvature, 2o₁·max(κ₁, κ₂), leaves 0.1, 0.5 and 1.3 %.
    """
    painted = painted_radius(radius, thickness, viscous_length, profile, scheme, motion, shape)
    planar_part = interface_shift(profile, viscous_length / thickness, scheme) * thickness
    curvature = (2.0 if shape == "sphere" else 1.0) / radius
    return planar_part, (painted - radius - planar_part) / curvature


def _coefficients(
    profile: Profile, scheme: Scheme, surface: float, thickness: float, viscous_length: float
) -> tuple[radial.Function, radial.Function]:
    """χ(r) = γ₀φ/((1−(1−θ)φ)νΔt), and d ln g/dr = θ(d ln(1−φ)/dz)/((1−(1−θ)φ)ξ)."""
    explicit = 1.0 - scheme.implicit
    strength = scheme.gamma / viscous_length**2

    def resistance(r: np.ndarray) -> np.ndarray:
        phi = profile.value((r - surface) / thickness)
        return strength * phi / (1.0 - explicit * phi)

    def weight_slope(r: np.ndarray) -> np.ndarray:
        z = (r - surface) / thickness
        rate = scheme.implicit * profile.fluid_slope(z)
        return rate / ((1.0 - explicit * profile.value(z)) * thickness)

    return resistance, weight_slope


def _resolved(profile: Profile | str, scheme: Scheme | str) -> tuple[Profile, Scheme]:
    profile = profile_named(profile) if isinstance(profile, str) else profile
    scheme = scheme_named(scheme) if isinstance(scheme, str) else scheme
    return profile, scheme


def _sharp(shape: str, motion: str) -> tuple[int, Callable[[float, float], float]]:
    if (shape, motion) not in SHARP:
        known = "; ".join(f"{m} of a {s}" for s, m in SHARP)
        raise CaseError(f"No radial problem for {motion} of a {shape}; there is: {known}.")
    return SHARP[shape, motion]


def _positive(**values: float) -> None:
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise CaseError(f"{name} is {value}; it must be a positive number.")
