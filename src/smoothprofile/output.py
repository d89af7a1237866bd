"""The run directory: everything a run leaves behind, and reading it back.

    case.toml       the case as it was run, every default filled in
    run.json        status, versions, machine, checks before the run
    history.csv     one row per recorded step
    particles.csv   one row per recorded step and particle
    trajectory.gsd  one frame per recorded step, if bodies move (see trajectories.py)
    fields.h5       snapshots of the fields (see fields.py)
    postmortem.h5   the flow at the step that blew up, if one did
    summary.json    the result in one object
    lines.csv, structure.csv, plane.npz: at the end (see samples.py)

Every row of a table is written at once, every other file beside its place and renamed, so that all
can be read at every instant. A file that cannot be written stops the run with an OutputError that
names it; a checkpoint that cannot does not, and is tried again when the next one is due.
"""

import math
import shlex
import sys
import time as clock
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from smoothprofile.checkpoint import write_checkpoint
from smoothprofile.csvtables import GrowingTable, flat_row
from smoothprofile.errors import BlowUpError, CaseError, OutputError, StoppedError
from smoothprofile.fields import FieldsFile
from smoothprofile.jsontext import plain, to_json
from smoothprofile.provenance import case_hash, lock, machine, now, unlock, versions
from smoothprofile.runrecord import read_json
from smoothprofile.safefiles import write_text
from smoothprofile.samples import write_cuts
from smoothprofile.trajectories import NoTrajectory, Trajectory, cut_back, trajectory_of

# How far the files of a new run are: none is there.
NOTHING_YET = {
    "history": None,
    "particles": None,
    "rows": 0,
    "next_snapshot": None,
    "snapshots": {"times": [], "names": []},
}


def next_free_directory(parent: Path | str, name: str) -> Path:
    """parent/name, or the first of parent/name-2, parent/name-3, … that does not exist."""
    first = Path(parent) / name
    path, number = first, 1
    while path.exists():
        number += 1
        path = first.with_name(f"{name}-{number}")
    return path


class RunDirectory:
    """Writes a run directory while a simulation goes on.

        with RunDirectory(path, case_toml, preflight) as run:
            simulation.run(observer=run.record)
            run.finish(simulation)

    Leaving the block by an exception records what ended the run in run.json.
    """

    def __init__(
        self,
        path: Path | str,
        case_toml: str,
        preflight: Iterable[Mapping[str, Any]] = (),
        tell: Callable[[str], None] = lambda sentence: None,
        seeds: Mapping[str, int] | None = None,
    ):
        """Make the directory. CaseError if anything of that name exists or it cannot be made.

        tell: takes a sentence when a checkpoint cannot be written. seeds: for run.json alone.
        """
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True)
        except FileExistsError as error:
            raise CaseError(
                f"the output directory {self.path} exists already; nothing was overwritten."
            ) from error
        except OSError as error:
            raise CaseError(
                f"the output directory {self.path} cannot be made: {error.strerror}."
            ) from error
        self._hold(case_toml, tell)
        self._run = {
            "status": "running",
            "message": None,
            "started": now(),
            "ended": None,
            "command": shlex.join(sys.argv),
            "case": case_hash(case_toml),
            "seeds": dict(seeds or {}),
            "versions": versions(),
            "machine": machine(),
            "preflight": list(preflight),
            "resumed": [],
        }
        try:
            self._write_run()
            # Last, so that a directory with a case in it can be gone on with.
            write_text(self.path / "case.toml", case_toml)
            self._open(NOTHING_YET)
        except OutputError:
            unlock(self.path, self._lock)
            raise

    @classmethod
    def resumed(
        cls,
        path: Path,
        saved: Mapping[str, Any] | None,
        simulation: Any,
        tell: Callable[[str], None] = lambda sentence: None,
    ) -> "RunDirectory":
        """Go on in a directory that is there, from what `saved` gave; None: from the start.

        What was written after that checkpoint is cut off. CaseError if another run is at work, or
        if a file holds less than the checkpoint says.
        """
        self = cls.__new__(cls)
        self.path = Path(path)
        self._hold((self.path / "case.toml").read_text(encoding="utf-8"), tell)
        try:
            self._take_up(saved, simulation)
        except BaseException:
            unlock(self.path, self._lock)
            raise
        return self

    def _hold(self, case_toml: str, tell: Callable[[str], None]) -> None:
        self._lock, self._case_toml, self._tell = lock(self.path), case_toml, tell
        self.checkpoint_at: str | None = None
        self._closed = False

    def _take_up(self, saved: Mapping[str, Any] | None, simulation: Any) -> None:
        self._run = read_json(self.path / "run.json")
        entry = {"at": now(), "step": simulation.steps, "versions": versions()}
        self._run["resumed"] = [*self._run.get("resumed", ()), entry]
        self._run |= {"status": "running", "message": None, "ended": None}
        self._write_run()
        cut_back(self.path / "trajectory.gsd", simulation.steps if saved else -1)
        self._open(saved or {**NOTHING_YET, "history": 0, "particles": 0})
        if saved:
            self.checkpoint_at = simulation.moment
        snapshots = FieldsFile(self.path / "fields.h5", simulation.grid)
        snapshots.cut_back(**self._snapshots)
        if self._snapshots["times"]:
            self._fields = snapshots

    def _open(self, saved: Mapping[str, Any]) -> None:
        self._history = GrowingTable(self.path / "history.csv", saved["history"])
        self._particles = GrowingTable(self.path / "particles.csv", saved["particles"])
        self._rows, self._next_snapshot = saved["rows"], saved["next_snapshot"]
        self._snapshots = saved["snapshots"]
        self._fields: FieldsFile | None = None
        self._trajectory: Trajectory | NoTrajectory | None = None
        self._last_checkpoint = clock.monotonic()

    def saved(self) -> dict[str, Any]:
        """How far each file has come, for a checkpoint."""
        if self._trajectory is not None:
            self._trajectory.flush()
        written = self._fields
        return {
            "history": self._history.size,
            "particles": self._particles.size,
            "rows": self._rows,
            "next_snapshot": self._next_snapshot,
            "snapshots": {
                "times": written.times if written else [],
                "names": written.names if written else [],
            },
        }

    def checkpoint(self, simulation: Any, keep: bool = True) -> None:
        """Write where the run and its files are now, so that it can go on from here.

        keep = False: in the place of the last one. OutputError if it cannot be written; the one
        before then stands.
        """
        self._write_checkpoint(simulation, self.saved(), keep)

    def note_retry(self, note: Mapping[str, Any]) -> None:
        """Tell in run.json where the run goes on with another Δt, and why."""
        self._run["retries"] = [*self._run.get("retries", ()), {"at": now(), **note}]
        self._write_run()

    def checkpoint_if_due(self, simulation: Any, now: bool = False) -> None:
        """A checkpoint if one is due, or `now`; if it cannot be written, the run goes on.

        OutputError if what was written before is not safe, or if the directory is gone.
        """
        due = 0.0 if now else simulation.case.output.checkpoint_every
        if simulation.status != "running" or clock.monotonic() - self._last_checkpoint < due:
            return
        files = self.saved()
        try:
            self._write_checkpoint(simulation, files)
        except OutputError as error:
            if not (self.path / "case.toml").is_file():
                raise
            last = f"the one at {self.checkpoint_at}" if self.checkpoint_at else "the start"
            self._tell(
                f"{error} The run goes on and will try again; a resumed one begins at {last}."
            )

    def _write_checkpoint(
        self, simulation: Any, files: Mapping[str, Any], keep: bool = True
    ) -> None:
        self._last_checkpoint = clock.monotonic()
        tree = {"simulation": simulation.saved(), "directory": files}
        write_checkpoint(self.path, self._case_toml, tree, keep)
        self.checkpoint_at = simulation.moment

    def postmortem(self, simulation: Any) -> None:
        """postmortem.h5: the flow at the step that blew up, in double precision."""
        path = self.path / "postmortem.h5"
        try:
            path.unlink(missing_ok=True)
            file = FieldsFile(path, simulation.grid, precision="double")
            names = ("velocity", "pressure", "indicator")
            file.append(simulation.time, {name: getattr(simulation, name) for name in names})
        except (OSError, OutputError) as error:
            self._tell(str(error))

    def __enter__(self) -> "RunDirectory":
        return self

    def __exit__(self, kind, error, traceback) -> None:
        if error is None:
            self._close()
            return
        self._run |= {"status": _status_of(error), "message": str(error) or type(error).__name__}
        # What ended the run is what is told, whatever else cannot be written then.
        with suppress(OutputError):
            self._close()

    def record(self, simulation: Any) -> None:
        """Append the history rows that are new, the particles with them, a snapshot if due.

        To be called after each step of one simulation, not of its preliminary runs.
        """
        history = simulation.history
        count = len(next(iter(history.values()), ()))
        for row in range(self._rows, count):
            values = {name: column[row] for name, column in history.items()}
            self._history.append(flat_row(values))
        if count > self._rows:
            self._record_particles(simulation)
        self._rows = count
        self._record_snapshot(simulation)

    def _record_snapshot(self, simulation: Any) -> None:
        every = simulation.case.output.fields_every
        if every is None:
            return
        if self._next_snapshot is None:
            self._next_snapshot = every
        # Times are sums of steps: half a part in 10⁹ early is on time.
        if simulation.time >= self._next_snapshot * (1 - 1e-9):
            self._record_fields(simulation)
            self._next_snapshot = every * (math.floor(simulation.time / every + 1e-9) + 1)

    def finish(self, simulation: Any) -> dict[str, Any]:
        """Write the final fields, lines, plane and summary; returns what summary.json holds."""
        self.record(simulation)
        self._record_fields(simulation)
        write_cuts(self.path, simulation)
        case = simulation.case
        summary = {
            "title": case.title,
            "reference": case.reference,
            **simulation.summary(),
            "table": simulation.table(),
        }
        write_text(self.path / "summary.json", to_json(summary) + "\n")
        self._run["status"] = simulation.status
        self._close()
        return plain(summary)

    def _record_particles(self, simulation: Any) -> None:
        for particle in simulation.particles:
            values = {key: value for key, value in particle.items() if key != "shape"}
            self._particles.append(flat_row({"time": simulation.time, **values}))
        if self._trajectory is None:
            self._trajectory = trajectory_of(self.path / "trajectory.gsd", simulation)
        self._trajectory.append(simulation)

    def _record_fields(self, simulation: Any) -> None:
        output = simulation.case.output
        if not output.fields:
            return
        if self._fields is None:
            self._fields = FieldsFile(self.path / "fields.h5", simulation.grid)
        if simulation.time not in self._fields.times[-1:]:
            fields = {name: getattr(simulation, name) for name in output.fields}
            self._fields.append(simulation.time, fields)

    def _write_run(self) -> None:
        write_text(self.path / "run.json", to_json(self._run) + "\n")

    def _close(self) -> None:
        """Close all files, once, and only then have an OutputError of one of them stand."""
        if self._closed:
            return
        self._closed, ended = True, self._trajectory
        try:
            if ended is not None:
                ended.close()
            if self._run["status"] == "running":
                self._run["status"] = "unfinished"
            self._run["ended"] = now()
            self._write_run()
        finally:
            self._history.close()
            self._particles.close()
            unlock(self.path, self._lock)


def _status_of(error: BaseException) -> str:
    if isinstance(error, BlowUpError):
        return "blew_up"
    return "interrupted" if isinstance(error, KeyboardInterrupt | StoppedError) else "failed"
