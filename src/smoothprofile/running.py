"""From a run and its directory to its end: what `spm run` and `spm resume` do alike."""

from pathlib import Path
from typing import Any

from smoothprofile.checkpoint import read_checkpoint
from smoothprofile.config import load_case
from smoothprofile.console import Watcher, leave, print_json, print_table, say
from smoothprofile.errors import BlowUpError, CaseError, StoppedError
from smoothprofile.output import RunDirectory, next_free_directory
from smoothprofile.report import write_report
from smoothprofile.runrecord import read_json
from smoothprofile.runs import Run, run_of
from smoothprofile.stops import Stops

ENDED = ("finished", "steady", "max_steps")


def start(case: str, loaded: Any, out: Path | None, json: bool) -> None:
    """Run a case in a new directory."""
    with Watcher(quiet=json) as watcher:
        simulation = run_of(loaded)
        for row in simulation.preflight():
            if row["verdict"] == "warn":
                say("Note: {name} is {value:.3g}, against {limit:.3g}: {note}.".format(**row))
        path = out or next_free_directory("runs", Path(case).stem)
        directory = RunDirectory(path, simulation.case.to_toml(), simulation.preflight())
        ended = _run(simulation, directory, watcher)
    _tell(simulation, path, ended, json)


def go_on(path: Path, json: bool) -> None:
    """Run what is left of the run in a directory. CaseError if nothing is, or it has no case."""
    if not (path / "case.toml").is_file():
        raise CaseError(f"{path} is not a run directory: it holds no case.toml.")
    status = read_json(path / "run.json").get("status")
    if status in ENDED:
        raise CaseError(f"the run in {path} has ended already: {status}.")
    with Watcher(quiet=json) as watcher:
        text = (path / "case.toml").read_text(encoding="utf-8")
        simulation = run_of(load_case(path / "case.toml"))
        saved = None
        if simulation.case.time is not None and any(path.glob("checkpoint*.h5")):
            tree = read_checkpoint(path, text)
            saved = tree["directory"]
            simulation.restore(tree["simulation"])
        directory = RunDirectory.resumed(path, saved, simulation)
        where = f"step {simulation.steps}" if saved else "the start, for it left no checkpoint"
        say(f"Going on in {path} from {where}.")
        ended = _run(simulation, directory, watcher)
    _tell(simulation, path, ended, json)


def _run(simulation: Run, directory: RunDirectory, watcher: Watcher) -> Any:
    """The summary, or what broke the run off."""
    limit = simulation.case.output.stop_after
    with Stops(limit, say) as stops:

        def observe(running: Run) -> None:
            watcher(running)
            if running is simulation:
                directory.record(running)
            reason = stops.reason()
            if reason and running.status == "running":
                if running is simulation:
                    directory.checkpoint(running)
                raise StoppedError(
                    f"Stopped by {reason} at t = {running.time:.6g}; "
                    f"spm resume {directory.path} goes on."
                )

        try:
            with directory:
                simulation.run(observe)
                return directory.finish(simulation)
        except (BlowUpError, KeyboardInterrupt, StoppedError) as error:
            return error


def _tell(simulation: Run, path: Path, ended: Any, json: bool) -> None:
    page = write_report(path)
    if isinstance(ended, BaseException):
        leave(ended, json, path, page)
    if json:
        print_json({**ended, "directory": str(path), "report": str(page)})
        return
    print_table(simulation.case.title, ("quantity", "value", ""), simulation.table())
    say(f"Everything is in {path}; open {page}.")
