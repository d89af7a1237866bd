"""What a case with fluid.flow = "stokes" may not say, for there is no inertia."""

from typing import TYPE_CHECKING, Any

import numpy as np

from smoothprofile.config.fluid import STOKES
from smoothprofile.config.refusals import MISSING, Refusal
from smoothprofile.config.values import AXES

if TYPE_CHECKING:
    from smoothprofile.config.case import Case

TOLERANCE = 1e-5
"""Of a solve, if the case gives none: the last flow starts the next, so that errors stay small."""
TOLERANCES = (1e-12, 0.1)
WITHOUT_MEANING = {
    ("time", "scheme"): "bodies are moved by the Adams-Bashforth rule",
    ("time", "coupling"): "fluid and bodies are solved for at once",
    ("fluid", "advection"): "there is none",
    ("fluid", "initial_velocity"): "the flow has no memory of a start",
    ("contact", "restitution"): "bodies without inertia do not bounce",
}
"""(table, key): why a Stokes flow has no use for it."""


def is_stokes(case: "Case") -> bool:
    """Whether the flow of a case is one without inertia."""
    return case.fluid is not None and case.fluid.flow == STOKES


def nothing_moves(case: "Case") -> bool:
    """Whether bodies and what drives the flow are the same at all times."""
    still = all(
        particle.motion != "free"
        and not particle.velocity.maximum.any()
        and not particle.angular_velocity.maximum.any()
        for particle in case.particles
    )
    walls = case.fluid.wall_velocity.given().values()
    turning = case.electric is not None and case.electric.angular_frequency is not None
    return still and not turning and not any(np.any(signal.amplitude) for signal in walls)


def check_stokes(case: "Case") -> None:
    """Refusal of what does not fit a flow without inertia."""
    for (table, key), why in WITHOUT_MEANING.items():
        given = getattr(case, table)
        if key in given.model_fields_set:
            raise Refusal(f"{table}.{key}", getattr(given, key), f"in Stokes flow {why}")
    tolerance, (low, high) = case.fluid.tolerance, TOLERANCES
    if tolerance is not None and not low <= tolerance <= high:
        raise Refusal("fluid.tolerance", tolerance, f"it must be from {low:g} to {high:g}")
    if case.domain.precision != "double":
        raise Refusal("domain.precision", case.domain.precision, 'Stokes flow needs "double"')
    if case.start:
        allowed = "in Stokes flow every step is a flow of its own, and needs no coarser one before"
        raise Refusal("start.0.cells", case.start[0].cells, allowed)
    if case.profile is not None and case.profile.retract == "radial":
        allowed = 'in Stokes flow it must be true, false or "planar"'
        raise Refusal("profile.retract", "radial", allowed)
    for number, particle in enumerate(case.particles):
        for key in ("velocity", "angular_velocity"):
            value = getattr(particle, key)
            if particle.motion == "free" and value.maximum.any():
                allowed = "in Stokes flow a free body has the motion that its loads give it"
                raise Refusal(f"particles.{number}.{key}", value.constant, allowed)
    _check_held(case)


def _check_held(case: "Case") -> None:
    """Refusal of a fluid that nothing holds along a periodic axis."""
    given, sides = case.fluid.mean_velocity.given(), case.domain.sides.values()
    bodies = any(particle.motion != "free" for particle in case.particles)
    if bodies or "wall" in sides:
        return
    for axis in np.flatnonzero(case.domain.periodic):
        if int(axis) not in given:
            allowed = "in Stokes flow it must be given where no wall and no body holds the fluid"
            raise Refusal(f"fluid.mean_velocity.{AXES[axis]}", MISSING, allowed)


def with_meaning(data: dict[str, Any]) -> dict[str, Any]:
    """The tables of a Stokes case, dumped, without the keys that it may not have."""
    found = dict(data)
    for table, key in WITHOUT_MEANING:
        if table in found:
            found[table] = {name: v for name, v in found[table].items() if name != key}
    return found
