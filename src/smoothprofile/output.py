"""The run directory: everything a run leaves behind, and reading it back.

    case.toml       the case as it was run, every default filled in
    run.json        status, versions, machine, checks before the run
    history.csv     one row per recorded step
    particles.csv   one row per recorded step and particle
    trajectory.gsd  one frame per recorded step, if bodies move (see trajectories.py)
    lines.csv       velocity along the lines, and shear along the wall line, at the end
    plane.npz       the fields in one plane, at the end
    fields.h5       snapshots of the fields (see fields.py)
    summary.json    the result in one object

Tables are flushed row by row, so that a run that is killed keeps what it had computed.
"""

import json
import math
import os
import platform
import shlex
import sys
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from smoothprofile.csvtables import GrowingTable, flat_row, grouped_by, number_columns, read_table
from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.fields import FieldsFile
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.jsontext import plain, to_json
from smoothprofile.trajectories import NoTrajectory, Trajectory, trajectory_of

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
        (self.path / "case.toml").write_text(case_toml, encoding="utf-8")
        self._run = {
            "status": "running",
            "message": None,
            "started": _now(),
            "ended": None,
            "command": shlex.join(sys.argv),
            "versions": {"python": platform.python_version()}
            | {name: version(name) for name in LIBRARIES},
            "machine": _machine(),
            "preflight": list(preflight),
        }
        self._write_run()
        self._history = GrowingTable(self.path / "history.csv")
        self._particles = GrowingTable(self.path / "particles.csv")
        self._rows = 0
        self._fields: FieldsFile | None = None
        self._trajectory: Trajectory | NoTrajectory | None = None
        self._next_snapshot: float | None = None

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


@dataclass(frozen=True, eq=False)
class RunRecord:
    """A run directory read back; whatever a broken-off run did not write is empty."""

    path: Path
    case_toml: str
    case: dict[str, Any]
    run: dict[str, Any] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)
    history: dict[str, np.ndarray] = field(default_factory=dict)
    """Column name to values."""
    particles: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)
    """Particle name to columns."""
    lines: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    """Line name to coordinates and velocity component."""
    wall_shear: tuple[np.ndarray, np.ndarray] | None = None
    plane: dict[str, np.ndarray] = field(default_factory=dict)


def read_run(path: Path | str) -> RunRecord:
    """Everything in a run directory. CaseError if the directory is not one, or is damaged."""
    path = Path(path)
    if not (path / "case.toml").is_file():
        raise CaseError(f"{path} is not a run directory: it holds no case.toml.")
    try:
        return _record(path)
    except (ValueError, BadZipFile) as error:
        raise CaseError(f"a file in {path} is damaged: {error}.") from error


def _record(path: Path) -> RunRecord:
    case_toml = (path / "case.toml").read_text(encoding="utf-8")
    sampled = grouped_by(read_table(path / "lines.csv"), "quantity")
    velocity = grouped_by(sampled.get("velocity", []), "name")
    shear = sampled.get("wall_shear", [])
    plane = {}
    if (path / "plane.npz").is_file():
        with np.load(path / "plane.npz") as data:
            plane = {name: data[name] for name in data.files}
    return RunRecord(
        path=path,
        case_toml=case_toml,
        case=tomllib.loads(case_toml),
        run=_read_json(path / "run.json"),
        summary=_read_json(path / "summary.json"),
        history=number_columns(read_table(path / "history.csv")),
        particles={
            name: number_columns(rows)
            for name, rows in grouped_by(read_table(path / "particles.csv"), "name").items()
        },
        lines={name: _curve(rows) for name, rows in velocity.items()},
        wall_shear=_curve(shear) if shear else None,
        plane=plane,
    )


def _curve(rows: list[dict[str, str]]) -> tuple[np.ndarray, np.ndarray]:
    columns = number_columns(rows)
    return columns["coordinate"], columns["value"]


def _status_of(error: BaseException) -> str:
    if isinstance(error, BlowUpError):
        return "blew_up"
    return "interrupted" if isinstance(error, KeyboardInterrupt) else "failed"


def _machine() -> dict[str, Any]:
    """What a timing depends on: system, processor, number of cores."""
    processor = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        names = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        processor = names[0].partition(":")[2].strip() if names else processor
    return {"system": platform.platform(), "processor": processor, "cores": os.cpu_count()}


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")


def _write(path: Path, text: str) -> None:
    """Replace a file in one go: a reader sees the old text or the new, never half of it."""
    draft = path.with_name(path.name + ".new")
    draft.write_text(text + "\n", encoding="utf-8")
    draft.replace(path)


def _read_json(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
