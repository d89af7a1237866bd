"""Which physical dimension each number of a case has: a table from keys to kinds of quantity."""

import math
from dataclasses import dataclass

from smoothprofile.config.values import AXES, SIDES

VACUUM_PERMITTIVITY, VACUUM_PERMEABILITY = 8.8541878188e-12, 1.25663706127e-6
"""ε₀ in F/m and μ₀ in H/m (CODATA 2022)."""


@dataclass(frozen=True)
class Kind:
    """A kind of quantity.

    name, example   in words and as in a case
    unit            in SI
    powers          of the case's units of length, time and mass; all 0: in fixed units
    factor          what its SI value is taken times
    others          kinds that may stand for it: the magnetic ones of the same equations
    angle           in radians, what 1 means; 0 if it is no angle
    """

    name: str
    example: str
    unit: str
    powers: tuple[float, float, float] = (0.0, 0.0, 0.0)
    factor: float = 1.0
    others: tuple["Kind", ...] = ()
    angle: float = 0.0

    def __str__(self) -> str:
        return f'{self.name} such as "{self.example}"'


LENGTH = Kind("a length", "10 um", "m", (1, 0, 0))
TIME = Kind("a time", "1 ms", "s", (0, 1, 0))
MASS = Kind("a mass", "1 ng", "kg", (0, 0, 1))
RATE = Kind("a rate", "10 1/s", "1/s", (0, -1, 0))
SPIN = Kind("an angular frequency", "50 rad/s", "rad/s", (0, -1, 0))
VELOCITY = Kind("a velocity", "1 mm/s", "m/s", (1, -1, 0))
ACCELERATION = Kind("an acceleration", "9.81 m/s^2", "m/s^2", (1, -2, 0))
DENSITY = Kind("a density", "2.5 g/cm^3", "kg/m^3", (-3, 0, 1))
VISCOSITY = Kind("a dynamic viscosity", "50 mPa s", "Pa s", (-1, -1, 1))
BODY_FORCE = Kind("a force per unit volume", "10 N/m^3", "N/m^3", (-2, -2, 1))
FORCE = Kind("a force", "1 nN", "N", (1, -2, 1))
TORQUE = Kind("a torque", "1 nN um", "N m", (2, -2, 1))
# √ε₀E and √μ₀H = B/√μ₀ are roots of a pressure, potentials these times a length.
_E, _M = math.sqrt(VACUUM_PERMITTIVITY), math.sqrt(VACUUM_PERMEABILITY)
_STRENGTH, _VOLTAGE = (-0.5, -1, 0.5), (0.5, -1, 0.5)
_MAGNETIC = (
    Kind("a magnetic field", "20 kA/m", "A/m", _STRENGTH, _M),
    Kind("a magnetic field", "25 mT", "T", _STRENGTH, 1.0 / _M),
)
FIELD = Kind("an electric field", "2 kV/mm", "V/m", _STRENGTH, _E, _MAGNETIC)
_CURRENT = Kind("a magnetic potential", "1 A", "A", _VOLTAGE, _M)
POTENTIAL = Kind("a potential", "1 kV", "V", _VOLTAGE, _E, (_CURRENT,))
_PERMEABILITY = Kind("a permeability", "1e-5 H/m", "H/m", factor=1.0 / VACUUM_PERMEABILITY)
PERMITTIVITY = Kind(
    "a permittivity", "2.4e-11 F/m", "F/m", (0, 0, 0), 1.0 / VACUUM_PERMITTIVITY, (_PERMEABILITY,)
)
DEGREES = Kind("an angle", "30 deg", "deg", angle=math.pi / 180)
RADIANS = Kind("an angle", "90 deg", "rad", angle=1.0)
WALL_CLOCK = Kind("a time", "10 min", "s")
FIXED = (PERMITTIVITY, DEGREES, RADIANS, WALL_CLOCK)
"""Kinds whose plain numbers mean the same in every case."""


def _signal(key: str, kind: Kind) -> dict[str, Kind]:
    """A vector, or a sinusoid of one."""
    parts = {"constant": kind, "amplitude": kind, "angular_frequency": SPIN, "phase": RADIANS}
    return {key: kind} | {f"{key}.{part}": found for part, found in parts.items()}


def _solid(key: str) -> dict[str, Kind]:
    """What every shape has."""
    sizes = ("radius", "radii", "length", "sides", "position")
    return {f"{key}.{size}": LENGTH for size in sizes} | {f"{key}.orientation.angle": DEGREES}


DIMENSIONS: dict[str, Kind] = {
    "units.length": LENGTH,
    "units.time": TIME,
    "units.mass": MASS,
    "units.density": DENSITY,
    "domain.lengths": LENGTH,
    "domain.origin": LENGTH,
    "domain.stretching.focus": LENGTH,
    "domain.stretching.core": LENGTH,
    "domain.stretching.faces": LENGTH,
    "fluid.density": DENSITY,
    "fluid.viscosity": VISCOSITY,
    "fluid.body_force": BODY_FORCE,
    "fluid.gravity": ACCELERATION,
    "fluid.initial_velocity": VELOCITY,
    **{f"fluid.mean_velocity.{axis}": VELOCITY for axis in AXES},
    **{k: v for s in SIDES for k, v in _signal(f"fluid.wall_velocity.{s}", VELOCITY).items()},
    "electric.field": FIELD,
    "electric.quadrature": FIELD,
    "electric.electrodes.low": POTENTIAL,
    "electric.electrodes.high": POTENTIAL,
    "electric.angular_frequency": SPIN,
    "electric.permittivity": PERMITTIVITY,
    "electric.thickness": LENGTH,
    "profile.thickness": LENGTH,
    **_solid("particles"),
    **_solid("particles.parts"),
    **{f"particles.radius.{k}": LENGTH for k in ("mean", "deviation", "smallest", "largest")},
    "particles.radius.sizes": LENGTH,
    "particles.scale": LENGTH,
    "particles.lattice.spacing": LENGTH,
    "particles.lattice.origin": LENGTH,
    "particles.random.gap": LENGTH,
    "particles.random.box.low": LENGTH,
    "particles.random.box.high": LENGTH,
    **_signal("particles.velocity", VELOCITY),
    **_signal("particles.angular_velocity", SPIN),
    "particles.density": DENSITY,
    "particles.permittivity": PERMITTIVITY,
    "particles.force": FORCE,
    "particles.torque": TORQUE,
    "contact.range": LENGTH,
    "time.step": TIME,
    "time.end": TIME,
    "time.steady_tolerance": RATE,
    "start.thickness": LENGTH,
    "start.step": TIME,
    "start.end": TIME,
    "start.steady_tolerance": RATE,
    "output.fields_every": TIME,
    "output.checkpoint_every": WALL_CLOCK,
    "output.stop_after": WALL_CLOCK,
    "output.plane.at": LENGTH,
    "output.lines.through": LENGTH,
    "output.wall_line.at": LENGTH,
}
"""Keys without the numbers of list entries: particles.position, not particles.0.position."""
