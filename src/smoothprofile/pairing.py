"""Pairing of time step and smoothing: which Δt a case takes, and how far its surfaces are moved.

Δt = (k ξ)²/ν with the scheme's and the profile's best k, bounded by the advective limit
painted distance = d − offset₀ − offset₁(κ₁+κ₂)
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from smoothprofile import calibration
from smoothprofile.calibration.flow import THINNEST
from smoothprofile.config import Case, Particle, build_shape
from smoothprofile.distances import CAPSULE, CYLINDER, ELLIPSOID, SPHERE
from smoothprofile.flow.stability import largest_stable_step
from smoothprofile.grid import Grid
from smoothprofile.schemes import scheme_named
from smoothprofile.shapes import Part, Shape

ADVECTIVE_SHARE = 0.9
FREE_SHARE = 0.4
STEPS_WITHOUT_LIMIT = 200
SOLVES_A_TURN = 16
"""Of an alternating field, at the least."""
FARTHEST_MOVED = 3.0
"""Of the smallest radius or half side: as far outward as the radial problem goes in its wall."""
SMALLEST_RATIO, LARGEST_RATIO = 1e-8, 1e8


@dataclass(frozen=True)
class Pairing:
    """The step of a run and what bounds it.

    limit       largest stable Δt at the speeds expected beforehand
    paired      (k ξ)²/ν with the best k; None without particles
    ratio       √(νΔt)/ξ of the step taken, beside best_ratio; None without particles
    shift       s₀(ratio): how far a flat wall retreats, in ξ
    """

    step: float
    limit: float
    speed: tuple[float, float, float]
    paired: float | None = None
    ratio: float | None = None
    best_ratio: float | None = None
    shift: float | None = None


def pair(case: Case, grid: Grid, speed: tuple[float, float, float]) -> Pairing:
    """The step that the case asks for, or with "auto" the best one that is stable."""
    nu = case.fluid.viscosity / case.fluid.density
    scheme = scheme_named(case.time.scheme)
    walled = tuple(
        case.domain.sides[f"{name}_low"] == case.domain.sides[f"{name}_high"] == "wall"
        for name in "xyz"
    )
    moving = speed if case.fluid.advection else (0.0, 0.0, 0.0)
    limit = largest_stable_step(grid, walled, nu, moving, scheme)
    if not case.particles:
        free = FREE_SHARE * limit if math.isfinite(limit) else case.time.end / STEPS_WITHOUT_LIMIT
        step = min(free, turning_step(case)) if case.time.step == "auto" else case.time.step
        return Pairing(step, limit, speed)
    xi, kind = case.profile.thickness, case.profile.kind
    best = calibration.best_time_step(xi, nu, kind, scheme)
    auto = min(best, ADVECTIVE_SHARE * limit, ADVECTIVE_SHARE * turning_step(case))
    step = auto if case.time.step == "auto" else case.time.step
    ratio = math.sqrt(nu * step) / xi
    return Pairing(
        step,
        limit,
        speed,
        best,
        ratio,
        calibration.best_ratio(kind, scheme),
        calibration.interface_shift(kind, ratio, scheme),
    )


def steps_of(case: Case, step: float) -> int:
    """How many steps a run takes at most."""
    steps = math.ceil(case.time.end / step - 1e-9)
    return min(steps, case.time.max_steps or steps)


def turning_step(case: Case) -> float:
    """2π/(16 ω m): the largest step that resolves a field solved for every m steps; inf if still.

    Forces go with its square, twice as fast.
    """
    electric = case.electric
    if electric is None or electric.angular_frequency is None:
        return math.inf
    return math.tau / (SOLVES_A_TURN * electric.every * electric.angular_frequency)


def expected_speed(case: Case, reaches: list[float]) -> tuple[float, float, float]:
    """Largest |u| along each axis that the case's own numbers announce.

    Walls, bodies (with their spin at their reach), the initial and the mean velocity (twice it,
    for a developed profile), and the creeping flow g L²/(8μ) that a body force drives.
    """
    fluid, domain = case.fluid, case.domain
    speeds = [np.abs(fluid.initial_velocity)]
    speeds += [signal.maximum for signal in fluid.wall_velocity.given().values()]
    mean = np.zeros(3)
    for axis, value in fluid.mean_velocity.given().items():
        mean[axis] = 2.0 * abs(value)
    speeds.append(mean)
    for particle, reach in zip(case.particles, reaches, strict=True):
        spin = float(np.linalg.norm(particle.angular_velocity.maximum))
        tip = spin * reach if math.isfinite(reach) else 0.0
        speeds.append(particle.velocity.maximum + tip + settling_speed(case, particle))
    gaps = [
        length for length, free in zip(domain.lengths, domain.periodic, strict=True) if not free
    ]
    if gaps:
        # Towards walls nothing flows.
        driven = np.where(domain.periodic, np.abs(fluid.body_force), 0.0)
        speeds.append(driven * min(gaps) ** 2 / (8 * fluid.viscosity))
    return tuple(np.max(speeds, axis=0).tolist())


def settling_speed(case: Case, particle: Particle) -> np.ndarray:
    """(3,) terminal speed of a lone sphere of the body's volume under what pulls it.

    The smaller of Stokes' and Newton's: drag 6πμaU, and .44·½ρU²πa².
    """
    if particle.motion != "free":
        return np.zeros(3)
    volume, fluid = build_shape(particle).volume, case.fluid
    a = math.cbrt(0.75 * volume / math.pi)
    pull = np.array(particle.force)
    pull = np.abs(pull + (particle.density - fluid.density) * volume * np.array(fluid.gravity))
    size = float(np.linalg.norm(pull))
    stokes = size / (6 * math.pi * fluid.viscosity * a)
    newton = math.sqrt(size / (0.22 * fluid.density * math.pi * a**2))
    return pull * (min(stokes, newton) / size if size else 0.0)


def settling_pull(reynolds: float) -> float:
    """ρF/μ² of the pull F under which `settling_speed` is that of Re = ρUa/μ.

    6πRe or .22πRe², whichever is larger.
    """
    return math.pi * max(6.0 * reynolds, 0.22 * reynolds**2)


def can_be_moved(case: Case, pairing: Pairing, half: float, room: float) -> bool:
    """Whether a surface can be moved for the step, so that it acts where it is.

        −min(a, L/2) < ξs₀(k) < min(3a, L/2),    √(νΔt) ≥ 1e-8 a

    By −a nothing would be left of the body, by L/2 it would fill the box. half: a, the smallest
    radius or half side, infinite for a plane; room: L of the box across the surface.
    """
    low, high = _moves(half, room)
    shortest = THINNEST * half if math.isfinite(half) else 0.0
    xi = case.profile.thickness
    return low < xi * pairing.shift < high and xi * pairing.ratio >= shortest


def _moves(half: float, room: float) -> tuple[float, float]:
    return -min(half, 0.5 * room), min(FARTHEST_MOVED * half, 0.5 * room)


def ratio_range(case: Case, half: float, room: float) -> tuple[float, float]:
    """The k = √(νΔt)/ξ between which `can_be_moved` holds; half and room as there."""
    xi, kind, scheme = case.profile.thickness, case.profile.kind, case.time.scheme

    def beyond(logarithm: float, target: float) -> float:
        return xi * calibration.interface_shift(kind, math.exp(logarithm), scheme) - target

    thinnest = THINNEST * half / xi if math.isfinite(half) else SMALLEST_RATIO
    ends, found = (math.log(min(thinnest, SMALLEST_RATIO)), math.log(LARGEST_RATIO)), []
    for target in _moves(half, room):
        # Of a compact profile the shift is bounded below: there is no step too short for it.
        inside = beyond(ends[0], target) < 0.0 < beyond(ends[1], target)
        found.append(brentq(beyond, *ends, (target,)) if inside else ends[target > 0])
    return max(math.exp(found[0]), thinnest), math.exp(found[1])


def surface_offsets(case: Case, shape: Shape, step: float, turning: bool) -> np.ndarray:
    """(parts, 2): offset₀ and offset₁ of each part of a body, for the step in use.

    With retract = true, spheres and cylinders take the radius of the radial Stokes problem, other
    curved parts the planar shift and the sphere's correction at their local curvature, flat ones
    the planar shift. The radial theory is that of the incremental coupling, so the thesis' takes
    the planar shift. turning: the body only rotates, and is painted for its torque.
    """
    retract = case.profile.retract
    offsets = np.zeros((len(shape.parts), 2))
    if retract is False:
        return offsets
    nu = case.fluid.viscosity / case.fluid.density
    arguments = (case.profile.thickness, math.sqrt(nu * step), case.profile.kind, case.time.scheme)
    thickness, viscous_length, kind, scheme = arguments
    planar = thickness * calibration.interface_shift(kind, viscous_length / thickness, scheme)
    radial = retract != "planar" and case.time.coupling == "incremental"
    motion = "rotation" if turning else "translation"
    for row, part in zip(offsets, shape.parts, strict=True):
        row[:] = _radial_offset(part, arguments, motion) if radial else (planar, 0.0)
    return offsets


def _radial_offset(part: Part, arguments: tuple, motion: str) -> tuple[float, float]:
    radius = float(part.size[0])
    if part.kind == SPHERE:
        return calibration.painted_radius(radius, *arguments, motion, "sphere") - radius, 0.0
    if part.kind == CYLINDER:
        return calibration.painted_radius(radius, *arguments, motion, "cylinder") - radius, 0.0
    if part.kind in (ELLIPSOID, CAPSULE):
        mean = float(np.cbrt(np.prod(part.size))) if part.kind == ELLIPSOID else radius
        return calibration.surface_offset(mean, *arguments, motion)
    thickness, viscous_length, kind, scheme = arguments
    ratio = viscous_length / thickness
    return thickness * calibration.interface_shift(kind, ratio, scheme), 0.0
