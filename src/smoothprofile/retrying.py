"""Another Δt from where a run is, and how a run that blew up is tried again with a smaller one.

    Δt ← Δt/2ᵐ,   the least m ≥ 1 for which it is at most the Δt that would have held, m ≤ 3

Where the case cannot be run with that, as where no painted radius belongs to so short a step, m is
the largest below it with which the case can.

Schemes of several levels begin anew there, with their first steps. Free bodies keep their
acceleration: the level before becomes V − g − (Δt'/Δt)(V − V⁻ − g), g what contact gave in the last
step; and what a virtual mass C has taken late, C(V − V⁻), is still owed to them.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from smoothprofile.checkpoint import has_checkpoint, read_checkpoint
from smoothprofile.errors import BlowUpError, CaseError, OutputError
from smoothprofile.output import RunDirectory

MOST_HALVINGS = 3
"""In one retry: the speeds from which a step is found may be those of the blow-up itself."""


def smaller_step(step: float, held: float | None) -> float:
    """The step halved once, or up to three times to come to the one that would have held."""
    found = 0.5 * step
    for _ in range(MOST_HALVINGS - 1):
        if held is not None and found > held:
            found *= 0.5
    return found


def steps_to_try(step: float, held: float | None) -> list[float]:
    """The step that `smaller_step` gives, then the longer halvings of `step`, up to its half."""
    found = [smaller_step(step, held)]
    while found[-1] < 0.5 * step:
        found.append(2.0 * found[-1])
    return found


def change_step(run: Any, step: float, why: str) -> dict[str, Any]:
    """Go on from where a run is with another Δt; returns what it keeps in `retries`.

    CaseError if the case cannot be run with it; the run is then as it was.
    """
    note = {
        "step": run.steps,
        "time": run.time,
        "time_step_before": run.time_step,
        "time_step": step,
        "why": why,
    }
    saved, ratio = run.saved(), step / run.time_step
    owed = _remembered(run)[0] if run.has_inertia else None
    try:
        run.take_step(step)
    except CaseError:
        run.take_step(note["time_step_before"])
        run.restore(saved)
        raise
    run.restore({**saved, "time_step": step, "retries": [*saved["retries"], note]})
    if not run.has_inertia:
        return note
    run.state.past_velocity.clear()
    run.state.past_advection.clear()
    _begin_anew(run, owed, ratio)
    return note


def _remembered(run: Any) -> tuple[Any, Any]:
    """C(Vⁿ − Vⁿ⁻¹) and CVⁿ (m,6) of the free bodies; adds the level to what they remember."""
    free, first = run.bodies.free, not run.bodies.free.past_late
    free.remember(run.bodies.state, run.flow.parameters.scheme.levels)
    now = free.past_late[0]
    return (0.0 * now if first else now - free.past_late[1]), now


def _begin_anew(run: Any, owed: Any, ratio: float) -> None:
    bodies, free = run.bodies, run.bodies.free
    if bodies.past_velocity:
        now = (bodies.state.velocity, bodies.state.angular_velocity)
        gains = (free.contact_history.velocity_gain, free.contact_history.spin_gain)
        level = zip(now, bodies.past_velocity[0], gains, strict=True)
        bodies.past_velocity = [tuple(v - g - ratio * (v - old - g) for v, old, g in level)]
    free.past_late = []
    late = _remembered(run)[1] - owed
    free.past_late, free.past_spin, free.past_turning = [late], [], []
    free.contact_impulses = []


def gone_back(
    simulation: Any,
    path: Path,
    why: str,
    tried: float,
    held: float | None,
    older: bool,
    tell: Callable[[str], None],
) -> RunDirectory:
    """A run that blew up and its directory, back at its last checkpoint with a smaller Δt.

    Without a checkpoint, back at the start. tried: the Δt that blew up; held: one that would have
    held, if known; older: take the checkpoint before the last. CaseError or OutputError if there
    is no way to go on.
    """
    where, files = len(simulation.preliminary), None
    if has_checkpoint(path):
        text = (path / "case.toml").read_text(encoding="utf-8")
        tree = read_checkpoint(path, text, tell, newest_first=not older)
        if older and _runs_before(tree) != where:
            tree = read_checkpoint(path, text, tell)
        simulation.restore(tree["simulation"])
        files = tree["directory"]
    elif simulation.case.start:
        raise CaseError("there is no checkpoint to go back to.")
    else:
        notes = simulation.retries
        simulation.take_step(simulation.time_step)
        simulation.retries = notes
    if len(simulation.preliminary) != where:
        raise CaseError("what blew up has no checkpoint of its own to go back to.")
    run = simulation.under_way
    before = run.time_step
    note = _change_to_one_of(run, steps_to_try(min(tried, before), held), why)
    directory = RunDirectory.resumed(path, files, simulation, tell)
    if run is not simulation:
        note = {"preliminary_run": where + 1, **note}
    directory.note_retry(note)
    try:
        directory.checkpoint(simulation, keep=False)
    except OutputError as error:
        tell(str(error))
    now = run.time_step
    tell(f"Trying again from {simulation.moment} with Δt = {now:.4g} instead of {before:.4g}.")
    return directory


def _change_to_one_of(run: Any, steps: list[float], why: str) -> dict[str, Any]:
    """As `change_step` with the first step that the case can be run with."""
    refused = None
    for step in steps:
        try:
            return change_step(run, step, why)
        except CaseError as error:
            refused = refused or error
    raise refused


def _runs_before(tree: dict[str, Any]) -> int:
    """How many preliminary runs were over when a checkpoint was written."""
    saved = tree["simulation"]
    return len(saved["stages"]["rows"] if "stages" in saved else saved.get("preliminary", ()))


def due_changes(simulation: Any, running: Any, plan: list[dict[str, Any]]) -> None:
    """Change Δt where a run that is repeated did: in the entries of `plan` for where it is now."""
    here = None if running is simulation else len(simulation.preliminary) + 1
    for note in plan:
        new = len(running.retries) < sum(n.get("preliminary_run") == here for n in plan)
        if new and note.get("preliminary_run") == here and note["step"] == running.steps:
            change_step(running, note["time_step"], note["why"])


def plan_of(summary: dict[str, Any]) -> list[dict[str, Any]]:
    """All changes of Δt that a summary tells of, in the order of the runs."""
    rows = enumerate(summary.get("start", ()), 1)
    earlier = [{"preliminary_run": k, **note} for k, row in rows for note in row.get("retries", ())]
    return earlier + list(summary.get("retries", ()))


def can_be_retried(simulation: Any, ended: Any) -> bool:
    """Whether it is a blow-up that a smaller Δt may avoid, of a run that can take another."""
    known = isinstance(ended, BlowUpError) and ended.step is not None
    return known and hasattr(simulation, "take_step")


def would_go_back(simulation: Any, path: Path, ended: Any) -> bool:
    """Whether another retry of a run that is over could begin: there is a way back, and a step.

    The run itself is given up for it: it is left at its beginning.
    """
    lost = simulation.case.start and not has_checkpoint(path)
    if lost or not can_be_retried(simulation, ended):
        return False
    run = simulation.under_way
    for step in steps_to_try(run.time_step, ended.step):
        try:
            run.take_step(step)
            return True
        except CaseError:
            continue
    return False
