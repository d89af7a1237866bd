"""Runs that are stopped and gone on with, and what has to be the same afterwards."""

import hashlib
import json
from pathlib import Path

import gsd.hoomd
import h5py
import numpy as np

from smoothprofile.checkpoint import _packed
from smoothprofile.config import load_case
from smoothprofile.errors import StoppedError
from smoothprofile.output import RunDirectory
from smoothprofile.running import taken_up
from smoothprofile.runs import run_of
from smoothprofile.threads import set_thread_count

# What depends on the clock and on the machine, in a summary and in what is saved.
TIMINGS = {"wall_seconds", "seconds_per_step", "threads"}
NO_CHECKPOINTS_OF_THEIR_OWN = {"output.checkpoint_every": 1e9}


def observer(simulation, directory, stop_at=None):
    """What a run does after each step; at the step `stop_at` it is stopped with a checkpoint.

    Steps are counted over the preliminary runs too.
    """
    passed = 0

    def observe(running):
        nonlocal passed
        passed += 1
        if running is simulation:
            directory.record(running)
        if running.status == "running" and passed == stop_at:
            directory.checkpoint(simulation)
            raise StoppedError("stopped")

    return observe


def run_stopping(case, path: Path, stops=(), threads=(1,)):
    """Run a case, stopped after so many steps of each go, each go with its number of threads."""
    set_thread_count(threads[0])
    simulation = run_of(load_case(case, NO_CHECKPOINTS_OF_THEIR_OWN))
    directory = RunDirectory(path, simulation.case.to_toml())
    for go, stop in enumerate((*stops, None)):
        if go:
            set_thread_count(threads[go % len(threads)])
            simulation, directory = taken_up(path, lambda sentence: None)
        try:
            with directory:
                simulation.run(observer(simulation, directory, stop))
                directory.finish(simulation)
        except StoppedError:
            continue
        assert stop is None, f"the run ended before step {stop} of go {go + 1}"
    return simulation


def state_digest(simulation) -> dict[str, str]:
    """Name to SHA-256 of everything that a checkpoint would hold."""
    found = {}

    def visit(name, value):
        if isinstance(value, dict):
            for key, inner in value.items():
                if key not in TIMINGS:
                    visit(f"{name}.{key}", inner)
            return
        if isinstance(value, list) and value and isinstance(value[0], dict):
            for number, inner in enumerate(value):
                visit(f"{name}.{number}", inner)
            return
        arrays = []
        text = json.dumps(_packed(value, arrays))
        total = hashlib.sha256(text.encode())
        for array in arrays:
            total.update(f"{array.dtype} {array.shape}".encode() + array.tobytes())
        found[name] = total.hexdigest()

    visit("run", simulation.saved())
    return found


def files_digest(path: Path) -> dict[str, object]:
    """Name to content, or its SHA-256, of every file that a run leaves, without times of clocks."""
    found: dict[str, object] = {}
    for name in ("case.toml", "history.csv", "particles.csv", "lines.csv", "plane.npz"):
        file = path / name
        found[name] = hashlib.sha256(file.read_bytes()).hexdigest() if file.is_file() else None
    summary = json.loads((path / "summary.json").read_text())
    for table in (summary, *summary.get("start", ())):
        for key in TIMINGS:
            table.pop(key, None)
    found["summary.json"] = {
        key: value for key, value in summary.items() if key not in ("table", "resolution")
    }
    found["fields.h5"] = fields_digest(path / "fields.h5")
    found["trajectory.gsd"] = frames(path / "trajectory.gsd")
    return found


def fields_digest(path: Path) -> dict[str, str] | None:
    if not path.is_file():
        return None
    with h5py.File(path) as file:
        arrays = {name: data[()] for name, data in file.items() if isinstance(data, h5py.Dataset)}
    assert not any(np.isnan(a).any() for a in arrays.values() if a.dtype.kind == "f")
    return {
        name: hashlib.sha256(f"{a.shape}".encode() + a.tobytes()).hexdigest()
        if a.dtype.kind == "f"
        else str(a)
        for name, a in arrays.items()
    }


def frames(path: Path) -> list[str] | None:
    """One SHA-256 a frame."""
    if not path.is_file():
        return None
    found = []
    with gsd.hoomd.open(str(path)) as file:
        for frame in file:
            total = hashlib.sha256(f"{frame.configuration.step} {frame.configuration.box}".encode())
            for part in (frame.particles.__dict__, frame.log):
                for name, value in sorted(part.items()):
                    content = value.tobytes() if isinstance(value, np.ndarray) else str(value)
                    total.update(f"{name} {content}".encode())
            found.append(total.hexdigest())
    return found
