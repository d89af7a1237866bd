"""From a run and its directory to its end: what `spm run` and `spm resume` do alike."""

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import typer

from smoothprofile.checkpoint import has_checkpoint, read_checkpoint
from smoothprofile.config import load_case, seeds_of
from smoothprofile.console import BLEW_UP, Watcher, leave, print_json, print_table, say
from smoothprofile.errors import BlowUpError, CaseError, OutputError, StoppedError
from smoothprofile.gap_checks import lattice_rows
from smoothprofile.output import RunDirectory, next_free_directory
from smoothprofile.preflight import Check
from smoothprofile.provenance import LOCK, lock, unlock
from smoothprofile.repeating import OTHER, check_repeatable, compared
from smoothprofile.report import write_report
from smoothprofile.retrying import (
    can_be_retried,
    due_changes,
    gone_back,
    plan_of,
    would_go_back,
)
from smoothprofile.runrecord import read_json
from smoothprofile.runs import Run, run_of
from smoothprofile.safefiles import reason
from smoothprofile.stops import Stops

RUNS = "runs"
"""Where a run directory is made if none is named."""
UNBEGUN = {LOCK, "run.json", "run.json.new", "case.toml.new"}
"""What may be in a directory whose run had not begun."""
ENDED = ("finished", "steady", "max_steps")


def start(case: str, settings: list[str], out: Path | None, json: bool, retry: int = 0) -> None:
    """Run a case in a new directory; after a blow-up, up to `retry` times with a smaller Δt."""
    loaded, seeds = load_case(case, settings), seeds_of(case, settings)
    with Watcher(quiet=json) as watcher:
        simulation = run_of(loaded)
        checks = simulation.preflight() + lattice_rows(case, settings)
        for row in checks:
            if row["verdict"] == "warn":
                say(_warning(row))
        path = out or next_free_directory(RUNS, Path(case).stem)
        text = simulation.case.to_toml()
        directory = RunDirectory(path, text, checks, say, seeds)
        ended = _to_its_end(simulation, directory, watcher, retry)
    _tell(simulation, path, ended, json)


def _warning(row: Check) -> str:
    beside = "" if row["limit"] in (None, math.inf) else f", against {row['limit']:.3g}"
    return f"Note: {row['name']} is {row['value']:.3g}{beside}: {row['note']}."


def start_or_go_on(
    case: str, settings: list[str], out: Path | None, json: bool, retry: int = 0
) -> None:
    """Run a case in `out` (runs/CASE if None), or what is left of it if the directory is there.

    One in which a run was killed before it had written its case is begun anew. Nothing is left of a
    run that has ended, which is said and is no failure: a job may be queued again after its end.
    """
    out = out or Path(RUNS, Path(case).stem)
    if out.is_dir() and not {entry.name for entry in out.iterdir()} - UNBEGUN:
        held = lock(out)
        for name in UNBEGUN - {LOCK}:
            (out / name).unlink(missing_ok=True)
        unlock(out, held)
        out.rmdir()
    status = None
    if (out / "case.toml").is_file():
        _check_same(case, settings, out)
        status = read_json(out / "run.json").get("status")
    if status in ENDED:
        if json:
            print_json({**read_json(out / "summary.json"), "directory": str(out)})
        say(f"{_has_ended(out, status)}; there is nothing left to do.")
    elif out.exists():
        go_on(out, json, retry)
    else:
        start(case, settings, out, json, retry)


def _check_same(case: str, settings: list[str], out: Path) -> None:
    """CaseError if a directory holds the run of another case, which would else go on unnoticed."""
    if load_case(case, settings) != load_case(out / "case.toml"):
        what = f"{case} with these settings" if settings else case
        raise CaseError(
            f"{out} holds the run of another case than {what}; take another directory, or go on "
            f"with that run by spm resume {out}."
        )


def go_on(path: Path, json: bool, retry: int = 0) -> None:
    """Run what is left of the run in a directory. CaseError if nothing is, or it has no case."""
    if not (path / "case.toml").is_file():
        raise CaseError(f"{path} is not a run directory: it holds no case.toml.")
    status = read_json(path / "run.json").get("status")
    if status in ENDED:
        raise CaseError(f"{_has_ended(path, status)}.")
    with Watcher(quiet=json) as watcher:
        simulation, directory = taken_up(path, say)
        where = directory.checkpoint_at or "the start, for it left no checkpoint"
        say(f"Going on in {path} from {where}.")
        ended = _to_its_end(simulation, directory, watcher, retry)
    _tell(simulation, path, ended, json)


def _has_ended(path: Path, status: str) -> str:
    return f"the run in {path} has ended already: {status}"


def repeat(path: Path, out: Path | None, json: bool) -> None:
    """Run the case of a directory again in a new one, and compare. Exit code 3 if bits differ."""
    for remark in check_repeatable(path):
        say(f"Note: {remark}; bits may differ.")
    case = load_case(path / "case.toml", {"output.stop_after": None})
    with Watcher(quiet=json) as watcher:
        simulation = run_of(case)
        new = out or next_free_directory(path.parent, f"{path.name}-again")
        directory = RunDirectory(new, simulation.case.to_toml(), simulation.preflight(), say)
        plan = plan_of(read_json(path / "summary.json"))
        with Stops(None, say) as stops:
            ended = _run(simulation, directory, watcher, stops, plan=plan)
    if isinstance(ended, BaseException):
        leave(ended, json, new, _report(new))
    found = compared(path, new)
    if json:
        print_json({"directory": str(new), "compared": found})
    else:
        print_table(f"{path} and {new}", ("file", "verdict"), list(found.items()))
    if OTHER in found.values():
        say(f"The run in {new} differs from that in {path}.")
        raise typer.Exit(BLEW_UP)


def taken_up(path: Path, tell: Callable[[str], None]) -> tuple[Run, RunDirectory]:
    """A run as its last checkpoint left it, or as it was at its start if it left none.

    CaseError if what there is cannot be gone on with.
    """
    text = (path / "case.toml").read_text(encoding="utf-8")
    simulation, saved = run_of(load_case(path / "case.toml")), None
    if simulation.case.time is not None and has_checkpoint(path):
        tree = read_checkpoint(path, text, tell)
        saved = tree["directory"]
        simulation.restore(tree["simulation"])
    return simulation, RunDirectory.resumed(path, saved, simulation, tell)


def _to_its_end(simulation: Run, directory: RunDirectory, watcher: Watcher, retry: int) -> Any:
    """The summary, or what broke the run off; after a blow-up it goes back, `retry` times at most.

    A retry that blows up no later than the one before goes back by one more checkpoint. The limit
    of wall-clock time is for all of them together.
    """
    with Stops(simulation.case.output.stop_after, say) as stops:
        return _with_retries(simulation, directory, watcher, stops, retry)


def _with_retries(
    simulation: Run, directory: RunDirectory, watcher: Watcher, stops: Stops, retry: int
) -> Any:
    ended, farthest = _run(simulation, directory, watcher, stops, retry > 0), (0, 0.0)
    for _ in range(retry):
        if not can_be_retried(simulation, ended):
            break
        run = simulation.under_way
        at = (len(simulation.preliminary), run.time)
        older, farthest = at <= farthest, max(at, farthest)
        say(str(ended))
        try:
            directory = gone_back(
                simulation, directory.path, str(ended), run.time_step, ended.step, older, say
            )
        except (CaseError, OutputError) as error:
            say(f"It cannot be tried again: {error}")
            break
        ended = _run(simulation, directory, watcher, stops, True)
    else:
        path = directory.path
        if would_go_back(simulation, path, ended):
            back = "goes back to its last checkpoint" if has_checkpoint(path) else "begins again"
            ended.add_note(f"spm resume {path} --retry 1 {back}, with a smaller Δt.")
    return ended


def _run(
    simulation: Run,
    directory: RunDirectory,
    watcher: Watcher,
    stops: Stops,
    to_go_back: bool = False,
    plan: Sequence[dict] = (),
) -> Any:
    """The summary, or what broke the run off.

    to_go_back: with a checkpoint after the first step too. plan: where Δt is changed.
    """

    def observe(running: Run) -> None:
        watcher(running)
        if running is simulation:
            directory.record(running)
        if running.status != "running":
            return
        if reason := stops.reason():
            _stop(simulation, directory, f"Stopped by {reason} at t = {running.time:.6g}")
        directory.checkpoint_if_due(simulation, now=to_go_back and running.steps == 1)
        due_changes(simulation, running, plan)

    try:
        with directory:
            if plan and not simulation.case.start:
                due_changes(simulation, simulation, plan)
            _watched(simulation, directory, observe)
            return directory.finish(simulation)
    except OutputError as error:
        return OutputError(f"{str(error).rstrip('.')}; {_goes_on(directory)}.")
    except (BlowUpError, KeyboardInterrupt, StoppedError) as error:
        return error


def _watched(simulation: Run, directory: RunDirectory, observe: Callable[[Run], None]) -> None:
    """Run to the end; of a run that blows up the fields are kept."""
    try:
        simulation.run(observe)
    except BlowUpError:
        if simulation.case.time is not None:
            directory.postmortem(simulation.under_way)
        raise


def _stop(simulation: Run, directory: RunDirectory, why: str) -> None:
    """StoppedError, after a checkpoint."""
    try:
        directory.checkpoint(simulation)
    except OutputError as error:
        why = f"{why}; {str(error).rstrip('.')}"
    raise StoppedError(f"{why}; {_goes_on(directory)}.")


def _goes_on(directory: RunDirectory) -> str:
    return f"spm resume {directory.path} goes on from {directory.checkpoint_at or 'its start'}"


def _tell(simulation: Run, path: Path, ended: Any, json: bool) -> None:
    page = _report(path)
    if isinstance(ended, BaseException):
        leave(ended, json, path, page)
    if json:
        print_json({**ended, "directory": str(path), "report": page and str(page)})
        return
    print_table(simulation.case.title, ("quantity", "value", ""), simulation.table())
    say(f"Everything is in {path}" + (f"; open {page}." if page else "."))


def _report(path: Path) -> Path | None:
    """The report of what there is; a run is not lost where it cannot be written."""
    try:
        return write_report(path)
    except OSError as error:
        say(f"The report cannot be written: {reason(error)}; spm report {path} makes it anew.")
        return None
