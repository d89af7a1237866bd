"""Physical units in a case: "2 kV/mm" becomes a plain number in the case's own units on loading.

    value = SI value / (Lᵃ Tᵇ Mᶜ),    E → √ε₀ E,  V → √ε₀ V,  H → √μ₀ H

[units] gives L, T and M; without it a case that has units is in m, s and kg. Fields and potentials
are taken times √ε₀, so that ε E² with a relative ε is a pressure in the case's own units; magnetic
ones times √μ₀.
"""

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from pydantic import Field, model_validator

from smoothprofile.config.dimensions import DIMENSIONS, FIXED, Kind
from smoothprofile.config.refusals import Refusal, shown
from smoothprofile.config.sources import checked
from smoothprofile.config.values import Table

NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
# Products of names with small powers and nothing else: pint would work out 9^9^9 if it were asked.
NAME = r"[^\W\d_]\w{0,30}(?:\s?(?:\^|\*\*)\s?-?\d{1,2}|[⁻¹²³⁴]{1,2})?"
UNIT = rf"\(?(?:1|{NAME})\)?(?:(?:\s?[*/·⋅]\s?|\s)\(?(?:1|{NAME})\)?){{0,7}}"
QUANTITY = re.compile(rf"({NUMBER})(?:\s*(?=[^\s\d.])|\s+(?=1\s?/))(.*)", re.DOTALL)
WELL_FORMED = re.compile(UNIT)
ANGLES = {"deg": math.pi / 180, "degree": math.pi / 180, "°": math.pi / 180, "rad": 1.0}
ANGLES |= {"degrees": math.pi / 180, "turn": math.tau, "turns": math.tau}


class Units(Table):
    """[units]: what 1 means in the case, for lengths, times, and masses or densities."""

    length: str = Field("1 m", description='a length such as "10 um"')
    time: str = Field("1 s", description='a time such as "1 ms"')
    mass: str | None = Field(None, description='a mass such as "1 ng"')
    density: str | None = Field(None, description='a density such as "1 g/cm^3"')

    @model_validator(mode="after")
    def _has_one_mass(self) -> "Units":
        if self.mass is not None and self.density is not None:
            raise Refusal("density", self.density, "units.mass already says what 1 means")
        return self


@dataclass(frozen=True)
class System:
    """L, T and M of a case, in m, s and kg."""

    length: float = 1.0
    time: float = 1.0
    mass: float = 1.0

    def number(self, kind: Kind, value: float) -> float:
        """The plain number of an SI value; fifteen digits, so that 80 um over 10 um is 8."""
        a, b, c = kind.powers
        return float(f"{value / (self.length**a * self.time**b * self.mass**c):.15g}")


FARTHEST = 1e30
"""How far a unit may be from SI's, either way: beyond, its powers leave the range of numbers."""


def without_units(data: dict[str, Any]) -> dict[str, Any]:
    """The case with plain numbers only, and with [units] if it had any units.

    CaseError for a unit of the wrong kind, and for plain numbers among units without [units].
    """
    given = data.get("units")
    table = None if given is None else checked(Units, given, "units")
    reader = _Reader(_system(table) if table else System())
    found = {key: reader.read(value, key, key) for key, value in data.items()}
    if table is None and reader.with_unit is not None:
        if reader.plain is not None:
            key, value, allowed = reader.plain
            because, quantity = reader.with_unit
            raise Refusal(key, value, f"because {because} is {shown(quantity)}, {allowed}")
        found["units"] = {"length": "1 m", "time": "1 s", "mass": "1 kg"}
    return found


def _system(table: Units) -> System:
    length = _unit_of(table.length, "length")
    time = _unit_of(table.time, "time")
    if table.density is not None:
        return System(length, time, _unit_of(table.density, "density") * length**3)
    return System(length, time, _unit_of(table.mass or "1 kg", "mass"))


def _unit_of(text: str, name: str) -> float:
    kind = DIMENSIONS[f"units.{name}"]
    if not QUANTITY.fullmatch(text):
        raise Refusal(f"units.{name}", text, f"it must be {kind}")
    value = si_value(kind, text, f"units.{name}")
    if not value > 0.0:
        raise Refusal(f"units.{name}", text, "it must be above 0")
    if not 1.0 / FARTHEST < value < FARTHEST:
        allowed = f"in SI it must be between {1.0 / FARTHEST:g} and {FARTHEST:g}"
        raise Refusal(f"units.{name}", text, allowed)
    return value


class _Reader:
    """Reads a case's values one by one, and remembers whether any had a unit.

    with_unit: key and value of the first that had; angles and what else is the same in all units
    do not count. plain: key, value and complaint of the first number that has none and should.
    """

    def __init__(self, system: System):
        self.system = system
        self.with_unit: tuple[str, str] | None = None
        self.plain: tuple[str, Any, str] | None = None

    def read(self, value: Any, place: str, key: str) -> Any:
        """The value with its quantities as numbers. place: its key without numbers of entries."""
        if isinstance(value, dict):
            return {k: self.read(v, f"{place}.{k}", f"{key}.{k}") for k, v in value.items()}
        if isinstance(value, list):
            return [self.read(item, place, f"{key}.{i}") for i, item in enumerate(value)]
        kind = DIMENSIONS.get(place)
        if place == "particles.csv":
            self._complain(key, value, "the numbers of a file need a table [units]")
        if kind is None or place.startswith("units."):
            return value
        if isinstance(value, str) and QUANTITY.fullmatch(value):
            if kind not in FIXED:
                self.with_unit = self.with_unit or (key, value)
            return self.system.number(kind, si_value(kind, value, key))
        if isinstance(value, int | float) and value and kind not in FIXED:
            allowed = f'it needs a unit too, such as "{kind.example}", '
            self._complain(key, value, allowed + "or the case a table [units]")
        return value

    def _complain(self, key: str, value: Any, allowed: str) -> None:
        self.plain = self.plain or (key, value, allowed)


def si_value(kind: Kind, text: str, key: str) -> float:
    """The SI value of a quantity times its kind's factor; Refusal if it is not of that kind.

    A frequency in Hz counts turns: as an angular one it is 2π of it.
    """
    number, unit = QUANTITY.fullmatch(text).groups()
    unit = f"1{unit}".strip() if unit.startswith("/") else unit.strip()
    if kind.angle:
        if unit not in ANGLES:
            raise Refusal(key, text, f"it must be {kind}")
        return float(number) * ANGLES[unit] / kind.angle
    try:
        if not WELL_FORMED.fullmatch(unit):
            raise ValueError("no product of units")
        found = _registry().parse_units(unit)
        factor, base = _registry().get_base_units(found)
        known = {k: _registry().parse_units(k.unit) for k in (kind, *kind.others)}
    # What is no unit raises whatever Python's own arithmetic, tokens and attributes do.
    except Exception:
        shown = unit if unit.isprintable() and len(unit) <= 30 else f"{unit[:30]!a} …"
        raise Refusal(key, text, f"{shown} is no known unit; it must be {kind}") from None
    same = [k for k, unit in known.items() if unit.dimensionality == base.dimensionality]
    if not same:
        raise Refusal(key, text, f"it must be {kind}")
    if kind.unit == "rad/s" and any(name.endswith("hertz") for name in found._units):
        factor *= math.tau
    return float(number) * float(factor) * same[0].factor


@cache
def _registry() -> Any:
    """pint's units. Loaded when the first unit is met: that takes a third of a second."""
    import pint

    return pint.UnitRegistry()
