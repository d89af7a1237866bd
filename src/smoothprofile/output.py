"""The run directory: everything a run leaves behind, and reading it back.

    case.toml       the case as it was run, every default filled in
    run.json        status, versions, machine, checks before the run
    history.csv     one row per recorded step
    particles.csv   one row per recorded step and particle
    trajectory.gsd  one frame per recorded step, if bodies move (see trajectories.py)
    lines.csv       velocity along the lines, and shear along the wall line, at the end
    structure.csv   pairs of beads by distance, at the end, if a field moves them
    plane.npz       the fields in one plane, at the end
    fields.h5       snapshots of the fields (see fields.py)
    summary.json    the result in one object

Tables are flushed row by row, so that a run that is killed keeps what it had computed.
"""

import fcntl
import math
import os
import platform
import shlex
import sys
import time as clock
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import IO, Any

import numpy as np

from smoothprofile import structure
from smoothprofile.checkpoint import write_checkpoint
from smoothprofile.csvtables import GrowingTable, flat_row
from smoothprofile.errors import BlowUpError, CaseError, StoppedError
from smoothprofile.fields import FieldsFile
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.jsontext import plain, to_json
from smoothprofile.runrecord import read_json
from smoothprofile.trajectories import NoTrajectory, Trajectory, cut_back, trajectory_of

# How far the files of a new run are: none is there.
NOTHING_YET = {
    "history": None,
    "particles": None,
    "rows": 0,
    "next_snapshot": None,
    "snapshots": {"times": [], "names": []},
}
LOCK = "lock"
LIBRARIES = ("smoothprofile", "numpy", "scipy", "numba", "ducc0", "h5py", "gsd")


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
        self, path: Path | str, case_toml: str, preflight: Iterable[Mapping[str, Any]] = ()
    ):
        """Make the directory. CaseError if anything of that name exists or it cannot be made."""
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
        self._lock = lock(self.path)
        (self.path / "case.toml").write_text(case_toml, encoding="utf-8")
        self._case_toml = case_toml
        self._run = {
            "status": "running",
            "message": None,
            "started": _now(),
            "ended": None,
            "command": shlex.join(sys.argv),
            "versions": _versions(),
            "machine": _machine(),
            "preflight": list(preflight),
            "resumed": [],
        }
        self._write_run()
        self._open(NOTHING_YET)

    @classmethod
    def resumed(
        cls, path: Path, saved: Mapping[str, Any] | None, simulation: Any
    ) -> "RunDirectory":
        """Go on in a directory that is there, from what `saved` gave; None: from the start.

        What was written after that checkpoint is cut off. CaseError if another run is at work.
        """
        self = cls.__new__(cls)
        self.path, self._lock = Path(path), lock(Path(path))
        self._case_toml = (self.path / "case.toml").read_text(encoding="utf-8")
        self._run = read_json(self.path / "run.json")
        entry = {"at": _now(), "step": simulation.steps, "versions": _versions()}
        self._run["resumed"] = [*self._run.get("resumed", ()), entry]
        self._run |= {"status": "running", "message": None, "ended": None}
        self._write_run()
        cut_back(self.path / "trajectory.gsd", simulation.steps if saved else -1)
        self._open(saved or {**NOTHING_YET, "history": 0, "particles": 0})
        fields = self.path / "fields.h5"
        if self._snapshots["times"]:
            self._fields = FieldsFile(fields, simulation.grid)
            self._fields.cut_back(**self._snapshots)
        else:
            fields.unlink(missing_ok=True)
        (self.path / "lines.csv").unlink(missing_ok=True)
        return self

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

    def checkpoint(self, simulation: Any) -> None:
        """Write where the run and its files are now, so that it can go on from here."""
        tree = {"simulation": simulation.saved(), "directory": self.saved()}
        write_checkpoint(self.path, self._case_toml, tree)
        self._last_checkpoint = clock.monotonic()

    def __enter__(self) -> "RunDirectory":
        return self

    def __exit__(self, kind, error, traceback) -> None:
        if error is not None:
            self._run["status"] = _status_of(error)
            self._run["message"] = str(error) or type(error).__name__
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
        due = simulation.case.output.checkpoint_every
        if due and clock.monotonic() - self._last_checkpoint >= due:
            self.checkpoint(simulation)

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
        self._record_lines(simulation)
        self._record_plane(simulation)
        structure.write_pairs(self.path / structure.TABLE, simulation)
        case = simulation.case
        summary = {
            "title": case.title,
            "reference": case.reference,
            **simulation.summary(),
            "table": simulation.table(),
        }
        _write(self.path / "summary.json", to_json(summary))
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

    def _record_lines(self, simulation: Any) -> None:
        output = simulation.case.output
        lines = [
            ("velocity", line.name, simulation.sample_line(line.axis, line.through, line.component))
            for line in output.lines or ()
        ]
        if output.wall_line is not None:
            wall = output.wall_line
            sample = simulation.wall_shear(wall.wall, wall.component, wall.along, wall.at)
            lines.append(("wall_shear", wall.wall, sample))
        table = GrowingTable(self.path / "lines.csv")
        for quantity, name, (coordinates, values) in lines:
            for coordinate, value in zip(coordinates, values, strict=True):
                row = {"quantity": quantity, "name": name, "coordinate": coordinate, "value": value}
                table.append(row)
        table.close()

    def _record_plane(self, simulation: Any) -> None:
        plane = simulation.case.output.plane
        across = simulation.grid.axes[AXIS_NAMES.index(plane.axis)]
        at = across.low + 0.5 * across.length if plane.at is None else plane.at
        sample = simulation.sample_plane(plane.axis, at)
        np.savez_compressed(self.path / "plane.npz", axis=plane.axis, at=at, **sample)

    def _write_run(self) -> None:
        _write(self.path / "run.json", to_json(self._run))

    def _close(self) -> None:
        if self._run["ended"] is None:
            if self._run["status"] == "running":
                self._run["status"] = "unfinished"
            self._run["ended"] = _now()
            self._write_run()
        self._history.close()
        self._particles.close()
        if self._trajectory is not None:
            self._trajectory.close()
            self._trajectory = None
        (self.path / LOCK).unlink(missing_ok=True)
        self._lock.close()


def _status_of(error: BaseException) -> str:
    if isinstance(error, BlowUpError):
        return "blew_up"
    return "interrupted" if isinstance(error, KeyboardInterrupt | StoppedError) else "failed"


def _machine() -> dict[str, Any]:
    """What a timing depends on: system, processor, number of cores."""
    processor = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        names = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        processor = names[0].partition(":")[2].strip() if names else processor
    return {"system": platform.platform(), "processor": processor, "cores": os.cpu_count()}


def _versions() -> dict[str, str]:
    return {"python": platform.python_version()} | {name: version(name) for name in LIBRARIES}


def lock(path: Path) -> IO:
    """Hold a directory for this process; CaseError if another run holds it."""
    handle = (path / LOCK).open("w")
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        handle.close()
        raise CaseError(f"another run is at work in {path}.") from None
    return handle


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _write(path: Path, text: str) -> None:
    """Replace a file in one go: a reader sees the old text or the new, never half of it."""
    draft = path.with_name(path.name + ".new")
    draft.write_text(text + "\n", encoding="utf-8")
    draft.replace(path)
