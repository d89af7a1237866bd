"""What can be said of a case with inertia before it runs: resolution, and limits on Δt.

Each check is a row name, value, limit, verdict, note; the verdict "refuse" stops a run before it
starts, "warn" does not.
"""

import math
from typing import Any

import numpy as np

from smoothprofile import rotations
from smoothprofile.config import Case, Particle, build_shape
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.numbers import creeping_hint
from smoothprofile.pairing import (
    Pairing,
    can_be_moved,
    ratio_range,
    steps_of,
    surface_offsets,
    turning_step,
)
from smoothprofile.unheld import speeding_up

Check = dict[str, Any]

FEW_LAYERS = 3.0
FAR_FROM_BEST = 0.1
FAR_MOVED = 0.5
# Lengths that are exact multiples are so to round-off.
ROUND_OFF = 1e-9
MANY_STEPS = 10_000
"""From which on a run that no inertia counts in is warned that it could do without them."""


def checks(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    """Every check of a case on its grid with the step that it will take, but what it needs."""
    found = [_advective_limit(case, pairing)]
    refuse(found)
    found += turning_check(case, pairing)
    refuse(found)
    for axis, rate in speeding_up(case).items():
        note = f"nothing balances the loads along {axis}: fluid.mean_velocity.{axis} can hold it"
        found.append(check_row(f"d⟨u⟩/dt along {axis}", rate, 0.0, "warn", note))
    if case.particles:
        found += _layer(case, grid, pairing)
        refuse(_unmovable(case, pairing))
        found += _surfaces(case, pairing)
    return found


def refuse(found: list[Check]) -> None:
    """CaseError with the note of the first check that refuses."""
    for check in found:
        if check["verdict"] == "refuse":
            raise CaseError(check["note"])


def check_row(name: str, value: Any, limit: Any, verdict: str, note: str) -> Check:
    """One row of checks."""
    return {"name": name, "value": value, "limit": limit, "verdict": verdict, "note": note}


def _advective_limit(case: Case, pairing: Pairing) -> Check:
    speed = ", ".join(f"{s:.3g}" for s in pairing.speed)
    note = f"largest stable Δt of {case.time.scheme} with speeds up to ({speed})"
    verdict = "ok"
    driven = zip(case.fluid.body_force, pairing.speed, strict=True)
    if any(force and not speed for force, speed in driven):
        verdict = "warn"
        note += "; what the body force will drive between no walls is not known beforehand"
    if pairing.step > pairing.limit:
        verdict = "refuse"
        note = (
            f"time.step is {pairing.step:g}; with speeds up to ({speed}) {case.time.scheme} is "
            f"stable only up to {pairing.limit:.4g}{creeping_hint(case)}."
        )
    elif hint := _bodies_hint(case):
        note += hint
        if (steps := steps_of(case, pairing.step)) > MANY_STEPS:
            verdict = "warn"
            note += f", of which there are {steps}"
    return check_row("time step", pairing.step, pairing.limit, verdict, note)


def _bodies_hint(case: Case) -> str:
    """What to add on Δt where bodies move and no inertia counts."""
    moving = any(particle.motion != "held" for particle in case.particles)
    return creeping_hint(case) if moving else ""


def turning_check(case: Case, pairing: Pairing) -> list[Check]:
    """Whether an alternating field is solved for often enough in a turn."""
    most, electric = turning_step(case), case.electric
    if math.isinf(most):
        return []
    verdict, note = "ok", "a sixteenth of a turn of the field between two solves"
    if pairing.step > most:
        verdict = "refuse"
        note = (
            f"electric.angular_frequency is {electric.angular_frequency:g}; a field that is "
            f"solved for {_each(electric.every)} needs a time.step of {most:.4g} "
            f"at most, a sixteenth of a turn between two solves, and it is {pairing.step:.4g}."
        )
    return [check_row("step, turning field", pairing.step, most, verdict, note)]


def _each(steps: int) -> str:
    return "every step" if steps == 1 else f"every {steps} steps"


def _layer(case: Case, grid: Grid, pairing: Pairing) -> list[Check]:
    xi = case.profile.thickness
    smallest = min(particle.thinnest[1] for particle in case.particles)
    # A profile that is compact needs its cells within its own width, not within ξ of tanh.
    width = widest_cell(case, grid)
    across = xi / width
    rows = []
    if math.isfinite(smallest):
        layers = smallest / xi
        verdict = "ok" if layers >= FEW_LAYERS - ROUND_OFF else "warn"
        note = "smallest radius or half side over ξ; the correction for curvature is small above 3"
        rows.append(check_row("a/ξ", layers, FEW_LAYERS, verdict, note))
    least = 1.0 if case.profile.kind == "tanh" else 3.0
    verdict = "ok" if across >= least - ROUND_OFF else "warn"
    note = f"the {case.profile.kind} interface is resolved from about {least:g} cells on"
    rows.append(check_row("ξ/Δx", across, least, verdict, note))
    off = abs(pairing.ratio / pairing.best_ratio - 1.0)
    verdict = "ok" if off < FAR_FROM_BEST or case.profile.retract is not False else "warn"
    note = f"best for {case.profile.kind} and {case.time.scheme}; " + (
        "surfaces are moved for the step in use"
        if case.profile.retract is not False
        else "retract is off, so this sets how far surfaces act from where they are"
    )
    rows.append(check_row("√(νΔt)/ξ", pairing.ratio, pairing.best_ratio, verdict, note))
    return rows


def widest_cell(case: Case, grid: Grid) -> float:
    """The widest cell that a painted layer may meet: of the whole grid, or near bounded bodies."""
    widest = 0.0
    varying = [d for d in range(3) if not _invariant(case, d)]
    for particle in case.particles:
        reach = build_shape(particle).reach + 2.0 * case.profile.thickness
        for d in varying:
            axis = grid.axes[d]
            near = np.abs(axis.centres - particle.position[d]) <= reach + axis.widths
            if near.any() and axis.cells > 1:
                widest = max(widest, float(axis.widths[near].max()))
    return widest or max(float(axis.widths.max()) for axis in grid.axes)


def _invariant(case: Case, d: int) -> bool:
    """Whether no surface of the case varies along axis d, so that its cells may be wide."""
    directions = [
        (particle.direction, particle.shape, particle.bounded) for particle in case.particles
    ]
    if any(bounded or direction is None for direction, _, bounded in directions):
        return False
    return all(
        (shape == "plane" and direction[d] == 0)
        or (shape == "cylinder" and abs(direction[d]) == np.linalg.norm(direction))
        for direction, shape, _ in directions
    )


def _surfaces(case: Case, pairing: Pairing) -> list[Check]:
    xi = case.profile.thickness
    rows = [
        check_row(
            "interface shift s₀",
            round(pairing.shift, 12) + 0.0,
            0.0,
            "ok",
            _where_it_acts(pairing.shift * xi),
        )
    ]
    seen = set()
    for particle in case.particles:
        shape = build_shape(particle)
        offset = surface_offsets(case, shape, pairing.step, particle.only_turns)
        key = (particle.shape, particle.thinnest[1], particle.only_turns, offset.tobytes())
        if key in seen:
            continue
        seen.add(key)
        moved, half = float(offset[0, 0]), particle.thinnest[1]
        verdict = "ok" if abs(moved) < FAR_MOVED * half else "warn"
        note = "painted surface moved outward by this much, so that it acts where it is"
        if verdict == "warn":
            note += (
                f"; its smallest radius or half side is only {half:.4g}: take a smaller time.step"
                + creeping_hint(case)
            )
        rows.append(check_row(f"surface of {particle.name}", moved, xi, verdict, note))
    return rows


def _unmovable(case: Case, pairing: Pairing) -> list[Check]:
    """A refusal for the first body whose surface the step moves too far, if any."""
    if case.profile.retract is False:
        return []
    for particle in case.particles:
        half, room = particle.thinnest[1], _room(case, particle)
        if can_be_moved(case, pairing, half, room):
            continue
        low, high = ratio_range(case, half, room)
        xi, nu = case.profile.thickness, case.fluid.viscosity / case.fluid.density
        note = (
            f"{_taken(case, pairing)}; with fluid.viscosity {case.fluid.viscosity:g}, "
            f"fluid.density {case.fluid.density:g} and profile.thickness {xi:g}, √(νΔt)/ξ is "
            f"{pairing.ratio:.3g}, and must be from {low:.3g} to {high:.3g} for the surface of "
            f"{particle.name} to be moved: that is a step from {(low * xi) ** 2 / nu:.3g} to "
            f"{(high * xi) ** 2 / nu:.3g}{creeping_hint(case)}."
        )
        return [check_row("√(νΔt)/ξ, range", pairing.ratio, high, "refuse", note)]
    return []


def _taken(case: Case, pairing: Pairing) -> str:
    """Which step a run takes, and why, in words."""
    if case.time.step != "auto":
        return f"time.step is {pairing.step:g}"
    why = ""
    if pairing.step < pairing.paired:
        speed = ", ".join(f"{s:.3g}" for s in pairing.speed)
        why = f", as much as is stable with speeds up to ({speed})"
    return f'time.step is "auto", here {pairing.step:.3g}{why}'


def _room(case: Case, particle: Particle) -> float:
    """The shortest side of the box across the surface of a body."""
    axis = np.abs(rotations.rotate(particle.quaternion, (0.0, 0.0, 1.0)))
    across = np.full(3, True)
    if not particle.bounded:
        across = axis > 0.5 * axis.max() if particle.shape == "plane" else axis < 0.5
    return float(np.min(np.array(case.domain.lengths)[across]))


def _where_it_acts(distance: float) -> str:
    if abs(distance) < 1e-9:
        return "a flat wall acts where it is painted"
    side = "inside" if distance > 0 else "outside"
    return f"a flat wall acts {abs(distance):.4g} {side} the painted surface"
