"""[numbers] of a case: Re, Mn, R, c and density ratio in place of what they are made of.

    Re ∝ ρ γ̇/μ,   Mn ∝ μ γ̇/E²
    Re ∝ ρ E²/μ² of the field's own flow, ρ/μ² of a body force's, and of a body that settles
    max(6Re, .22Re²) ∝ ρ/μ², or (ρ/μ)² if its density is that of the fluid times a number

What the case leaves out of ρ, μ, γ̇ and E is first taken as 1; the factors that then give Re and Mn
solve a linear system of logarithms. Afterwards all numbers are worked out from the whole case, and
one that differs from what was asked is refused.
"""

import math
from collections.abc import Callable
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from smoothprofile.config.case import Case
from smoothprofile.config.domain import Domain
from smoothprofile.config.electric import LARGEST_RATIO
from smoothprofile.config.refusals import MISSING, Refusal
from smoothprofile.config.sources import checked
from smoothprofile.config.values import AXES, POSITIVE, Positive, Table, is_finite
from smoothprofile.numbers import Scales, mason, numbers_of, reynolds, scales_of
from smoothprofile.pairing import settling_pull

NEAR = 1e-6
"""How far a number may be from what the case's own values make it."""
KEYS = {
    "density": "fluid.density",
    "viscosity": "fluid.viscosity",
    "rate": "fluid.wall_velocity",
    "field": "electric.field",
}
MADE_OF = {
    "Re": "fluid.density, fluid.viscosity, speeds and radii",
    "Mn": "electric.field, fluid.viscosity, permittivities and the rate of shear",
    "R": "the permittivities",
    "volume_fraction": "the bodies and the box",
    "density_ratio": "the densities",
}


RATIO = f"a number from {1.0 / LARGEST_RATIO:g} to {LARGEST_RATIO:g}"
Ratio = Annotated[float, Field(ge=1.0 / LARGEST_RATIO, le=LARGEST_RATIO)]


class Numbers(Table):
    """[numbers]: dimensionless numbers, as `numbers.py` defines them."""

    Re: Positive | None = Field(None, description=POSITIVE)
    Mn: Positive | None = Field(None, description=POSITIVE)
    R: Ratio | None = Field(None, description=RATIO)
    volume_fraction: Annotated[float, Field(gt=0, lt=1)] | None = Field(
        None, description="a number above 0 and below 1"
    )
    density_ratio: Positive | None = Field(None, description=POSITIVE)


def case_of_numbers(data: dict[str, Any], read: Callable[[dict], Case]) -> Case:
    """The case of plain data with [numbers]; `read` makes a case of data without it.

    CaseError if the numbers do not give what is left out, or contradict what is there.
    """
    wanted = checked(Numbers, data["numbers"], "numbers")
    data = {key: value for key, value in data.items() if key != "numbers"}
    data = _with_bodies(data, wanted)
    missing = _missing(data, wanted)
    if missing:
        scales = scales_of(read(_filled(data, wanted, dict.fromkeys(missing, 1.0))))
        data = _filled(data, wanted, _solved(scales, wanted, missing))
    else:
        data = _filled(data, wanted, {})
    case = read(data)
    _check(case, wanted)
    return case


def _with_bodies(data: dict, wanted: Numbers) -> dict:
    """Bodies with the permittivity and sources with the volume fraction that they leave out."""
    entries = data.get("particles")
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        return data
    fluid = _given(data, "electric", "permittivity", 1.0) if _table(data, "electric") else None
    found = []
    for entry in entries:
        if wanted.R is not None and fluid is not None:
            entry = {"permittivity": wanted.R * fluid, **entry}
        packing = entry.get("random")
        if wanted.volume_fraction is not None and isinstance(packing, dict):
            given = {"count", "volume_fraction"} & packing.keys()
            packing = {} if given else {"volume_fraction": wanted.volume_fraction}
            entry = {**entry, "random": {**packing, **entry["random"]}}
        found.append(entry)
    return {**data, "particles": found}


def _given(data: dict, table: str, key: str, usual: float) -> float:
    """What a table says, before bodies take a multiple of it; Refusal if not above 0."""
    value = data[table].get(key, usual)
    if not is_finite(value) or value <= 0:
        raise Refusal(f"{table}.{key}", value, f"it must be {POSITIVE}")
    return value


def _table(data: dict, key: str) -> bool:
    return isinstance(data.get(key), dict)


def _missing(data: dict, wanted: Numbers) -> list[str]:
    """Which of density, viscosity, rate and field the numbers have to give."""
    given = [name for name in ("Re", "Mn") if getattr(wanted, name) is not None]
    fluid = data.get("fluid", {})
    if not given or not isinstance(fluid, dict):
        return []
    missing = [key for key in ("density", "viscosity") if key not in fluid]
    if "Mn" in given and _table(data, "electric") and not _has_field(data["electric"]):
        missing.append("field")
    drives = ("wall_velocity", "mean_velocity", "initial_velocity", "gravity", "body_force")
    still = not any(key in fluid for key in drives)
    if still and len(missing) < len(given) and _walled(data) is not None:
        missing.append("rate")
    return missing


def _has_field(electric: dict) -> bool:
    ends = electric.get("electrodes")
    held = ends is not None and not (isinstance(ends, dict) and "high" not in ends)
    return held or "field" in electric or "quadrature" in electric


def _walled(data: dict) -> int | None:
    """The one axis with two walls, if there is one such."""
    domain = checked(Domain, data.get("domain", {}), "domain")
    walled = [d for d in range(3) if domain.sides[f"{AXES[d]}_low"] == "wall"]
    walled = [d for d in walled if domain.sides[f"{AXES[d]}_high"] == "wall"]
    return walled[0] if len(walled) == 1 else None


def _filled(data: dict, wanted: Numbers, values: dict[str, float]) -> dict:
    """The data with these densities, viscosities, rates of shear and fields put in."""
    data, fluid = dict(data), dict(data["fluid"]) if _table(data, "fluid") else {}
    fluid |= {key: values[key] for key in ("density", "viscosity") if key in values}
    if "rate" in values:
        axis = _walled(data)
        half = 0.5 * values["rate"] * data["domain"]["lengths"][axis]
        along = [0.0, half, 0.0] if axis == 0 else [half, 0.0, 0.0]
        ends = {f"{AXES[axis]}_low": [0.0 - u for u in along], f"{AXES[axis]}_high": along}
        fluid["wall_velocity"] = ends
    if fluid:
        data["fluid"] = fluid
    if "field" in values:
        data["electric"] = _with_field(data, values["field"])
    bodies = data.get("particles")
    if wanted.density_ratio is not None and "density" in fluid and isinstance(bodies, list):
        density = wanted.density_ratio * _given(data, "fluid", "density", 1.0)
        free = [isinstance(body, dict) and body.get("motion") == "free" for body in bodies]
        pairs = zip(bodies, free, strict=True)
        data["particles"] = [{"density": density, **b} if is_free else b for b, is_free in pairs]
    return data


def _with_field(data: dict, field: float) -> dict:
    """[electric] with a mean field along z, or with electrodes on the case's two walls."""
    electric, axis = data["electric"], _walled(data)
    ends = electric.get("electrodes") or {}
    axis = AXES.index(ends["axis"]) if ends.get("axis") in AXES else axis
    if axis is None:
        return {**electric, "field": [0.0, 0.0, field]}
    low = ends["low"] if is_finite(ends.get("low")) else 0.0
    high = low + field * data["domain"]["lengths"][axis]
    return {**electric, "electrodes": {"axis": AXES[axis], **ends, "high": high}}


def _solved(scales: Scales, wanted: Numbers, missing: list[str]) -> dict[str, float]:
    """What is missing, from Re and Mn at the scales of a case in which it was taken as 1."""
    settles = scales.basis == "settling" and not scales.rate
    powers = {
        "Re": _powers_of_re(scales, wanted),
        "Mn": {"viscosity": 1, "rate": 1, "field": -2},
    }
    matrix, logarithms = [], []
    for name, of in (("Re", reynolds), ("Mn", mason)):
        asked = getattr(wanted, name)
        if asked is None:
            continue
        matrix.append([powers[name].get(key, 0) for key in missing])
        found = of(scales) or _nothing(name, asked)
        if name == "Re" and settles:
            asked, found = settling_pull(asked), settling_pull(found)
        logarithms.append(math.log(asked / found))
    factors, _, rank, _ = np.linalg.lstsq(np.array(matrix, float), np.array(logarithms))
    if rank < len(missing):
        names = " and ".join(f"numbers.{n}" for n in ("Re", "Mn") if getattr(wanted, n) is not None)
        one = [KEYS[key] for key in missing]
        allowed = f"{names} cannot give {' and '.join(one)}"
        raise Refusal(
            one[0], MISSING, f"{allowed}: give {'it' if len(one) == 1 else 'one of them'}"
        )
    return {key: math.exp(factor) for key, factor in zip(missing, factors, strict=True)}


def _powers_of_re(scales: Scales, wanted: Numbers) -> dict[str, int]:
    """How Re goes with what may be missing; of a body that settles, `settling_pull` of Re."""
    powers = {
        "field": {"density": 1, "viscosity": -2, "field": 2},
        "body force": {"density": 1, "viscosity": -2},
        # The weight of a body goes with the fluid's density if its own does.
        "settling": {"density": 1 if wanted.density_ratio is None else 2, "viscosity": -2},
    }
    shear = {"density": 1, "viscosity": -1, "rate": 1}
    return shear if scales.rate else powers.get(scales.basis, shear)


def _nothing(name: str, asked: float) -> float:
    needs = {
        "Re": "nothing in the case sets a speed or a rate of shear",
        "Mn": "it needs a field, bodies with R other than 1, and walls that slide past each other",
    }
    raise Refusal(f"numbers.{name}", asked, needs[name])


def _check(case: Case, wanted: Numbers) -> None:
    """Refusal of the first number that the case's own values contradict."""
    found, count = numbers_of(case), len(case.particles)
    for name, asked in wanted.model_dump(exclude_none=True).items():
        if name not in found:
            if name in ("Re", "Mn"):
                _nothing(name, asked)
            raise Refusal(f"numbers.{name}", asked, "the case has nothing that it could be of")
        value, near = found[name], NEAR * asked
        if name == "R":
            ratios = [p.permittivity / case.electric.permittivity for p in case.particles]
            value = max(ratios, key=lambda ratio: abs(ratio - wanted.R))
        if name == "volume_fraction":
            # A whole number of bodies comes within half a body of it.
            near = max(near, 0.51 * value / count)
        if abs(value - asked) > near:
            made_of = MADE_OF[name]
            if case.electric is not None and case.electric.electrodes is not None:
                made_of = made_of.replace("electric.field", "electric.electrodes.high")
            allowed = f"{made_of} of the case make it {value:.7g}"
            raise Refusal(f"numbers.{name}", asked, allowed)
