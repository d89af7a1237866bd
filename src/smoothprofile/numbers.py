"""What a case amounts to: its dimensionless numbers, from its scales.

    Re = ρUa/μ, in shear ρ γ̇ a²/μ       Mn = μγ̇/(2 ε β² E²)       β = (R − 1)/(R + 2)
    St = (2/9)(ρ_p/ρ) Re                  c = Σ volumes / box        R = ε_p/ε

a is the radius of a sphere with the bodies' mean volume; ε the fluid's permittivity, E the root of
the mean square of the field in time. See docs/units.md for other definitions.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from smoothprofile.config import AXES, Case, Particle, build_shape
from smoothprofile.pairing import settling_speed

CREEPING = 0.1
"""Re below which a flow may be taken without inertia."""
ESTIMATES = ("settling", "field")
"""Speeds that a run replaces by that of its fastest body."""
SPEEDS = {
    "mean": "the mean velocity",
    "walls": "the speed of the walls",
    "bodies": "the given speed of the bodies",
    "initial": "the initial speed",
    "spin": "the given spin",
    "body force": "the speed of creeping flow",
    "settling": "the speed at which a lone body would settle",
    "field": "the speed ε E² a/μ",
}
NOTES = {
    "Mn": ("Mn", "μγ̇/(2 ε β² E²)"),
    "R": ("R", "permittivity of the bodies over that of the fluid"),
    "contrast": ("β", "(R − 1)/(R + 2)"),
    "volume_fraction": ("c", "volume of the bodies over that of the box"),
    "density_ratio": ("ρ_p/ρ", "density of the free bodies over that of the fluid"),
    "St": ("St", "(2/9)(ρ_p/ρ) Re"),
    "electric_times": ("ε E² t/μ", "end of the run in times of the field"),
    "layer": ("a/ξ", "smallest radius or half side over the layer"),
}


@dataclass(frozen=True)
class Scales:
    """The scales that a case announces, 0 or None where it has none.

    radius      a; without bounded bodies the shortest length between walls
    rate        γ̇ between two walls that slide past each other
    speed       U, as `basis` says: its key, or "settling" or "field" for estimates
    field       E, the root of the mean square in time
    ratio       R of the body that differs most from the fluid
    """

    radius: float = 0.0
    density: float = 0.0
    viscosity: float = 0.0
    rate: float = 0.0
    speed: float = 0.0
    basis: str = ""
    field: float = 0.0
    permittivity: float = 0.0
    ratio: float | None = None
    density_ratio: float | None = None


def scales_of(case: Case) -> Scales:
    """The scales of a case."""
    fluid, electric = case.fluid, case.electric
    bounded = [particle for particle in case.particles if particle.bounded]
    found = {"radius": _radius(case, bounded)}
    if electric is not None:
        ratios = [particle.permittivity / electric.permittivity for particle in case.particles]
        found |= {
            "field": field_strength(case),
            "permittivity": electric.permittivity,
            "ratio": max(ratios, key=lambda R: abs(_contrast(R)), default=None),
        }
    if fluid is not None:
        free = [particle.density for particle in case.particles if particle.motion == "free"]
        found |= {
            "density": fluid.density,
            "viscosity": fluid.viscosity,
            "rate": shear_rate(case),
            "density_ratio": float(np.mean(free)) / fluid.density if free else None,
        }
        found["speed"], found["basis"] = _speed(case, bounded, found)
    return Scales(**found)


def _radius(case: Case, bounded: list[Particle]) -> float:
    if bounded:
        volume = float(np.mean([build_shape(particle).volume for particle in bounded]))
        return math.cbrt(0.75 * volume / math.pi)
    thin = [p.thinnest[1] for p in case.particles if math.isfinite(p.thinnest[1])]
    lengths = zip(case.domain.lengths, case.domain.periodic, strict=True)
    gaps = [length for length, periodic in lengths if not periodic]
    return min(thin or gaps or case.domain.lengths)


def shear_rate(case: Case) -> float:
    """|u_high − u_low|/L between the walls of an axis that slide past each other; the largest."""
    moving, rates = case.fluid.wall_velocity.given(), [0.0]
    for axis, length in zip(AXES, case.domain.lengths, strict=True):
        ends = [moving.get(f"{axis}_{end}") for end in ("low", "high")]
        for part in ("constant", "amplitude"):
            low, high = (np.array(getattr(end, part) if end else (0, 0, 0)) for end in ends)
            rates.append(float(np.linalg.norm(high - low)) / length)
    return max(rates)


def field_strength(case: Case) -> float:
    """E: the root of the mean square in time of the mean field."""
    electric = case.electric
    field, quadrature = np.array(electric.field), np.array(electric.quadrature)
    if electric.electrodes is not None:
        ends, axis = electric.electrodes, AXES.index(electric.electrodes.axis)
        field[axis] = (ends.low - ends.high) / case.domain.lengths[axis]
    if electric.angular_frequency is None:
        return float(np.linalg.norm(field))
    return math.sqrt(0.5 * float(field @ field + quadrature @ quadrature))


def _speed(case: Case, bounded: list[Particle], found: dict) -> tuple[float, str]:
    """U and where it comes from: the first that is not 0, what is given before what is estimated.

    Estimates: a lone body that settles, g L²/(8μ) of a body force between walls, ε E² a/μ.
    """
    fluid, mean = case.fluid, [0.0, 0.0, 0.0]
    for axis, value in fluid.mean_velocity.given().items():
        mean[axis] = value
    lengths = zip(case.domain.lengths, case.domain.periodic, strict=True)
    gap = min((length for length, periodic in lengths if not periodic), default=0.0)
    pull = found.get("permittivity", 0.0) * found.get("field", 0.0) ** 2
    candidates = {
        "mean": [mean],
        "walls": [signal.maximum for signal in fluid.wall_velocity.given().values()],
        "bodies": [particle.velocity.maximum for particle in case.particles],
        "initial": [fluid.initial_velocity],
        "spin": [p.angular_velocity.maximum * found["radius"] for p in case.particles],
        "body force": [
            np.where(case.domain.periodic, fluid.body_force, 0.0) * gap**2 / (8.0 * fluid.viscosity)
        ],
        "settling": [settling_speed(case, particle) for particle in bounded],
        "field": [[pull * found["radius"] / fluid.viscosity if bounded else 0.0]],
    }
    for basis, speeds in candidates.items():
        fastest = max((float(np.linalg.norm(speed)) for speed in speeds), default=0.0)
        if fastest > 0.0:
            return fastest, basis
    return 0.0, ""


def _contrast(ratio: float) -> float:
    return (ratio - 1.0) / (ratio + 2.0)


def reynolds(s: Scales) -> float | None:
    """Re = ρ γ̇ a²/μ in shear, else ρ U a/μ; None where nothing moves."""
    speed = s.rate * s.radius or s.speed
    return s.density * speed * s.radius / s.viscosity if speed else None


def creeping_hint(case: Case) -> str:
    """What to add on Δt where no inertia counts, Re, St and ρωa²/μ small; empty where it does."""
    scales = scales_of(case)
    found = reynolds(scales)
    if found is None:
        return ""
    stokes = 2.0 / 9.0 * (scales.density_ratio or 0.0) * found
    moving = [*case.fluid.wall_velocity.given().values()]
    moving += [s for p in case.particles for s in (p.velocity, p.angular_velocity)]
    swiftest = max((s.angular_frequency for s in moving if any(s.amplitude)), default=0.0)
    swinging = scales.density * swiftest * scales.radius**2 / scales.viscosity
    if max(found, stokes, swinging) >= CREEPING:
        return ""
    return f'; at Re = {found:.2g} fluid.flow = "stokes" needs no such step'


def mason(s: Scales) -> float | None:
    """Mn = μγ̇/(2 ε β² E²); None without shear, without a field, or for R = 1."""
    pull = 2.0 * s.permittivity * (_contrast(s.ratio) * s.field) ** 2 if s.ratio else 0.0
    return s.viscosity * s.rate / pull if s.rate and pull else None


def volume_fraction(case: Case) -> float | None:
    """c of the bodies that have an end; None without any."""
    volumes = [build_shape(particle).volume for particle in case.particles if particle.bounded]
    return math.fsum(volumes) / math.prod(case.domain.lengths) if volumes else None


def numbers_of(case: Case, measured: float | None = None) -> dict[str, float]:
    """Every dimensionless number that the case has, by name.

    measured: a speed to take in place of one that could only be estimated beforehand.
    """
    s = scales_of(case)
    if measured is not None and s.basis in ESTIMATES:
        s = replace(s, speed=measured)
    found = {"Re": None, "Mn": None, "R": s.ratio, "volume_fraction": volume_fraction(case)}
    found["contrast"] = None if s.ratio is None else _contrast(s.ratio)
    if case.fluid is not None:
        found |= {"Re": reynolds(s), "Mn": mason(s), "density_ratio": s.density_ratio}
        if found["Re"] is not None and s.density_ratio is not None:
            found["St"] = 2.0 / 9.0 * s.density_ratio * found["Re"]
        found["electric_times"] = case.time.end * s.permittivity * s.field**2 / s.viscosity or None
    thin = min((particle.thinnest[1] for particle in case.particles), default=math.inf)
    if case.profile is not None and math.isfinite(thin):
        found["layer"] = thin / case.profile.thickness
    return {name: float(value) for name, value in found.items() if value is not None}


def number_rows(case: Case, measured: float | None = None) -> list[tuple[str, float, str]]:
    """The numbers as rows name, value, note, for people; `measured` as in `numbers_of`."""
    s, found = scales_of(case), numbers_of(case, measured)
    length = "radius" if any(p.thinnest[0] != "normal" for p in case.particles) else "length"
    speed = "the rate of shear" if s.rate else SPEEDS.get(s.basis)
    if measured is not None and not s.rate and s.basis in ESTIMATES:
        speed = "the fastest body's speed at the end"
    notes = {"Re": ("Re", f"by {length} and {speed}"), **NOTES}
    rows = [(notes[name][0], value, notes[name][1]) for name, value in found.items()]
    return [(name, value, note + _range(case, name)) for name, value, note in rows]


def _range(case: Case, name: str) -> str:
    """What to say of R and β where bodies differ: their number is that of the farthest one."""
    if name not in ("R", "β"):
        return ""
    ratios = [particle.permittivity / case.electric.permittivity for particle in case.particles]
    ends = [ratio if name == "R" else _contrast(ratio) for ratio in (min(ratios), max(ratios))]
    if ends[0] == ends[1]:
        return ""
    return f"; bodies go from {ends[0]:.4g} to {ends[1]:.4g}, this is the one with the largest |β|"
