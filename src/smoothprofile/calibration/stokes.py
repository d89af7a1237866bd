"""Where to paint a surface for steady Stokes flow, and what a sphere still lacks then.

    μ∇²u − ∇p = χ(u − u_b),   ∇·u = 0,   χ = (μ/ℓ²)φ

A flat wall acts o₀ behind its painted place, as in `calibration.flow`, and where it is once it is
painted o₀ further out. Of a sphere one radius cannot be right for all: pressure drives fluid
through its layer, which lowers the drag and raises the a²/6 of Faxén's law. So that radius a* is
taken whose drag is right in a wide and in a narrow concentric wall *but for* a compliance m,

    1/D(a*, wall) + m = 1/D_sharp(a, wall)        for both walls,

and m, with like ones for turning and straining, is given to the body besides: V = V_layer + mF,
Ω = Ω_layer + m_r T, E = E_layer + m_s S. Then a lone sphere has exactly its drag, its torque and
its stresslet, and moves in any flow as Faxén says.

Compliances are mostly below zero. They may take back no more than the layer gives of itself,
ℓ²/(μ∫φ dV) for translation, or bodies could be pulled through each other the wrong way; where they
would, m is what is allowed, and a* the radius with the right drag in the wide wall.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from scipy.integrate import fixed_quad
from scipy.optimize import brentq

from smoothprofile.calibration.flow import THICKEST, THINNEST
from smoothprofile.errors import CaseError
from smoothprofile.profiles import Profile, profile_named
from smoothprofile.theory import elements, planar, radial, sharp, straining
from smoothprofile.theory.grid_layer import grid_shift

LAYER_RATIO = {"tanh": 0.75, "quartic": 0.2, "quartic-centred": 0.2, "sine": 0.2}
"""ℓ/ξ by profile: fluid enters to where the profile ends."""
WIDEST, NARROW = 16.0, 3.0
FARTHEST = 4.0
"""|z| at which the tails of tanh are cut, for they cost points and hold back little."""
SHARE = 0.95
"""Of the layer's own compliance: the most that is taken back."""


@dataclass(frozen=True)
class StokesSphere:
    """The painted radius a*, and m, m_r, m_s for a viscosity of one."""

    radius: float
    translation: float
    rotation: float
    straining: float


def stokes_profile(name: str) -> Profile:
    """The profile of that name, its tails cut at |z| = 4: 0 and 1 beyond."""
    profile = profile_named(name)
    if profile.half_width <= FARTHEST:
        return profile

    def value(z):
        return np.where(np.abs(z) > FARTHEST, np.less(z, 0.0) * 1.0, profile.value(z))

    return replace(profile, half_width=FARTHEST, value=value)


def stokes_shift(profile: str, thickness: float, layer: float, cell: float = 0.0) -> float:
    """o₀: how far out a flat wall is painted so that it acts where it is, a length.

    thickness ξ, layer ℓ; cell: h, the size of the grid's cells, 0 for what the limit would be.
    """
    return float(thickness * _shift(profile, layer / thickness, cell / thickness))


@lru_cache(maxsize=1024)
def _shift(name: str, ratio: float, cell: float) -> float:
    profile = stokes_profile(name)
    ends = max(profile.core, -FARTHEST), min(profile.edge, FARTHEST)

    def resistance(z: np.ndarray) -> np.ndarray:
        return profile.value(z) / ratio**2

    return planar.planar_shift(resistance, *ends) + grid_shift(resistance, cell, *ends)


def stokes_sphere(
    radius: float, thickness: float, layer: float, cell: float = 0.0, profile: str = "sine"
) -> StokesSphere:
    """a* and the compliances, as at the head of the file, of a sphere of that radius.

    thickness ξ, layer ℓ; cell: h, whose share of a flat wall's shift a* takes up. CaseError if
    ξ or ℓ is above .8 or below 1e-8 of the radius.
    """
    for key, length in (("profile.thickness", thickness), ("the layer", layer)):
        if not THINNEST * radius <= length <= THICKEST * radius:
            raise CaseError(
                f"{key} is {length:g}; of a sphere of radius {radius:g} in Stokes flow it must be "
                f"between {THINNEST * radius:g} and {THICKEST * radius:g}."
            )
    unit = _stokes_sphere(float(thickness / radius), float(layer / radius), profile)
    limit = stokes_shift(profile, thickness, layer)
    moved = stokes_shift(profile, thickness, layer, cell) - limit
    painted, cube = radius * unit.radius + moved, radius**3
    # What a coarse grid adds to a* takes from what its layer gives.
    moving, deforming = layer_yield(painted, thickness, layer, profile)
    return StokesSphere(
        painted,
        max(unit.translation / radius, -SHARE * moving),
        max(unit.rotation / cube, -SHARE * 0.5 * deforming),
        max(unit.straining / cube, -SHARE * deforming),
    )


def translation_radius(
    radius: float, thickness: float, layer: float, profile: str = "sine", dimension: int = 3
) -> float:
    """The painted radius with the right drag, of a sphere or a cylinder that has no compliance."""
    exact = {3: sharp.sphere_drag, 2: sharp.cylinder_drag}[dimension](1.0, WIDEST)
    xi, ell = thickness / radius, layer / radius

    def excess(painted: float) -> float:
        return 1.0 / exact - 1.0 / _drag(painted, xi, ell, profile, WIDEST, dimension)

    return radius * _root(excess, 1.0 + _shift(profile, ell / xi, 0.0) * xi, xi)


@lru_cache(maxsize=1024)
def _stokes_sphere(xi: float, ell: float, profile: str) -> StokesSphere:
    """`stokes_sphere` of radius and viscosity one."""
    exact = {wall: 1.0 / sharp.sphere_drag(1.0, wall) for wall in (WIDEST, NARROW)}

    def lack(painted: float, wall: float) -> float:
        return exact[wall] - 1.0 / _drag(painted, xi, ell, profile, wall)

    guess = 1.0 + _shift(profile, ell / xi, 0.0) * xi
    painted = _root(lambda a: lack(a, WIDEST) - lack(a, NARROW), guess, xi)

    def spare(painted: float) -> float:
        return lack(painted, WIDEST) + SHARE * layer_yield(painted, xi, ell, profile)[0]

    if spare(painted) < 0.0:
        painted = _root(spare, guess, xi)
    translation = lack(painted, WIDEST)
    deforming = layer_yield(painted, xi, ell, profile)[1]
    chi, edges = _problem(painted, xi, ell, profile, WIDEST)
    torque = radial.penalised_torque(3, chi, edges)
    stresslet = straining.penalised_stresslet(chi, _no_slope, edges)
    turning = 0.5 * deforming
    rotation = max(1.0 / sharp.sphere_torque(1.0, WIDEST) - 1.0 / torque, -SHARE * turning)
    strain = max(1.0 / sharp.sphere_stresslet(1.0, WIDEST) - 1.0 / stresslet, -SHARE * deforming)
    return StokesSphere(painted, translation, rotation, strain)


@lru_cache(maxsize=1024)
def layer_yield(
    painted: float, thickness: float, layer: float, profile: str
) -> tuple[float, float]:
    """ℓ²/∫φ dV and 3ℓ²/∫φr² dV: V/F and E/S that the layer alone gives a sphere, over 1/μ."""
    shape = stokes_profile(profile)
    inner = max(painted + thickness * max(shape.core, -FARTHEST), 0.0)
    outer = painted + thickness * min(shape.edge, FARTHEST)
    moments = []
    for power in (2, 4):

        def density(r: np.ndarray, power: int = power) -> np.ndarray:
            return shape.value((r - painted) / thickness) * r**power

        within = inner ** (power + 1) / (power + 1)
        moments.append(4.0 * math.pi * (within + fixed_quad(density, inner, outer, n=64)[0]))
    return layer**2 / moments[0], 3.0 * layer**2 / moments[1]


def _drag(
    painted: float, xi: float, ell: float, profile: str, wall: float, dimension: int = 3
) -> float:
    chi, edges = _problem(painted, xi, ell, profile, wall)
    return radial.penalised_drag(dimension, chi, _no_slope, edges)


def _problem(painted: float, xi: float, ell: float, name: str, wall: float) -> tuple:
    profile = stokes_profile(name)

    def chi(r: np.ndarray) -> np.ndarray:
        return profile.value((r - painted) / xi) / ell**2

    return chi, elements.radial_edges(painted, xi, wall, profile.core, profile.edge, True)


def _no_slope(r: np.ndarray) -> np.ndarray:
    return np.zeros_like(r)


def _root(function: Callable[[float], float], guess: float, xi: float) -> float:
    """The root nearest to `guess`; `function` rises, and is steep beside ξ."""
    lowest, highest = 0.3 * xi, 0.9 * NARROW - xi
    below, above, stride = guess, guess, 0.1 * xi
    while below > lowest and function(below) > 0.0:
        below, stride = max(below - stride, lowest), 2.0 * stride
    stride = 0.1 * xi
    while above < highest and function(above) < 0.0:
        above, stride = min(above + stride, highest), 2.0 * stride
    if not function(below) <= 0.0 <= function(above):
        raise CaseError(
            f"profile.thickness is {xi:.3g} of a body's radius, too thick for its surface to be "
            f"moved to where it acts; take a thinner one."
        )
    return brentq(function, below, above, xtol=1e-10)
