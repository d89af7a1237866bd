"""A long run of many moving particles: memory and files that do not grow beyond their data.

pytest -m soak tests/test_soak.py                  40 minutes
SOAK_MINUTES=3 pytest -m soak tests/test_soak.py   shorter
"""

import os
import time
from pathlib import Path

import numpy as np
import pytest

from smoothprofile.checkpoint import NEWEST, PREVIOUS
from smoothprofile.config import load_case
from smoothprofile.output import RunDirectory
from smoothprofile.running import taken_up
from smoothprofile.runs import run_of
from smoothprofile.threads import set_thread_count

MINUTES = float(os.environ.get("SOAK_MINUTES", "40"))
SECONDS_BETWEEN_CHECKPOINTS = min(60.0, 5.0 * MINUTES)
PAGE = os.sysconf("SC_PAGE_SIZE")


def suspension(beads=1000, cells=96):
    """Beads of 3 cells to their radius that sink in a periodic box, 13 % of it, with contact."""
    return {
        "domain": {
            "lengths": [cells / 5.0] * 3,
            "cells": [cells] * 3,
            "boundaries": ["periodic"] * 3,
        },
        "fluid": {
            "density": 1.0,
            "viscosity": 1.0,
            "gravity": [0.0, 0.0, -1.0],
            # Else the box as a whole would fall, ever faster.
            "mean_velocity": {"x": 0.0, "y": 0.0, "z": 0.0},
        },
        "profile": {"thickness": 0.25},
        "particles": [
            {
                "shape": "sphere",
                "radius": 0.6,
                "motion": "free",
                "density": 2.0,
                "random": {"count": beads, "seed": 1},
            }
        ],
        "time": {"end": 1e9},
        "output": {
            "every": 20,
            "fields": ["velocity"],
            "fields_every": 1e9,
            "checkpoint_every": SECONDS_BETWEEN_CHECKPOINTS,
        },
    }


def resident() -> float:
    """MiB of this process that are in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * PAGE / 2**20


class Log:
    """What a run takes, at each checkpoint."""

    def __init__(self, path):
        self.path, self.began, self.rows = path, time.monotonic(), []

    @property
    def minutes(self):
        return (time.monotonic() - self.began) / 60.0

    def look(self, run, directory):
        def size(name):
            file = self.path / name
            return file.stat().st_size if file.exists() else 0

        rows = directory.saved()["rows"]
        self.rows.append(
            (
                self.minutes,
                run.steps,
                rows,
                resident(),
                size(NEWEST),
                size(PREVIOUS),
                size("history.csv"),
                size("particles.csv"),
                size("trajectory.gsd"),
                len(list(self.path.rglob("*"))),
            )
        )
        print("  ".join(f"{value:.6g}" for value in self.rows[-1]), flush=True)


@pytest.mark.soak
def test_memory_and_files_stay_as_they_are(tmp_path):
    """Memory flat within 1 %, checkpoints to what history adds, rows of equal size, no new files.

    At its end it is taken up from its last checkpoint, and goes on.
    """
    set_thread_count(2)
    simulation = run_of(load_case(suspension()))
    directory, log = RunDirectory(tmp_path / "run", simulation.case.to_toml()), None
    log = Log(tmp_path / "run")
    print("minutes, steps, rows, MiB, checkpoint, previous, bytes of three tables, files")
    written = directory.checkpoint_at
    with directory:
        while log.minutes < MINUTES:
            simulation.step_once()
            directory.record(simulation)
            directory.checkpoint_if_due(simulation)
            if directory.checkpoint_at != written:
                written = directory.checkpoint_at
                log.look(simulation, directory)
        directory.checkpoint(simulation)
    assert_flat(np.array(log.rows), simulation)
    again, directory = taken_up(tmp_path / "run", pytest.fail)
    with directory:
        assert again.steps == simulation.steps
        again.step_once()


def assert_flat(rows, simulation):
    """Of all but the first two checkpoints, when buffers have come to their size."""
    settled = rows[min(2, len(rows) // 2) :]
    third = max(1, len(settled) // 3)
    # One look at the memory is worth 1 %: a checkpoint's buffers may or may not be given back.
    first, last = settled[:third, 3].mean(), settled[-third:, 3].mean()
    print(f"memory {first:.5g} MiB, then {last:.5g} MiB; {np.ptp(settled[:, 3]):.3g} up and down")
    assert abs(last / first - 1.0) <= 0.01
    newest, recorded, files = settled[:, 4], settled[:, 2], settled[:, 9]
    # A row of history is some tens of numbers of 8 bytes; HDF5 aligns what it holds.
    width = sum(np.size(column[-1]) for column in simulation.history.values())
    most = 16.0 * width * (recorded[-1] - recorded[0]) + 4096.0
    assert np.ptp(newest) <= most, newest
    half = len(settled) // 2
    for table in settled[:, 6:9].T:
        early = (table[half] - table[0]) / (recorded[half] - recorded[0])
        late = (table[-1] - table[half]) / (recorded[-1] - recorded[half])
        print(f"{early:.6g} bytes a row, then {late:.6g}")
        # Of a table, as many digits as the numbers have; of frames, an index that grows in blocks.
        assert abs(late / early - 1.0) <= 0.05
    assert np.ptp(files) == 0, files
