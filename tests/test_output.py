"""The run directory, written by a fake simulation and read back."""

import json
import math
import tomllib
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from smoothprofile.csvtables import read_table
from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.output import RunDirectory, next_free_directory, to_json
from smoothprofile.runrecord import read_run

CASE = """\
title = "A sphere <held> in a duct"
reference = "duct"

[domain]
lengths = [20.0, 7.0, 7.0]
cells = [40, 14, 14]

[time]
steady_tolerance = 1e-3

[output]
every = 1
fields = ["velocity", "pressure", "indicator"]
wall_line = { wall = "y_high", component = "x", along = "x", at = 0.0 }

[[output.lines]]
name = "centreline"
axis = "x"
through = [0.0, 0.0]
component = "x"

[[output.lines]]
name = "wake"
axis = "y"
through = [2.0, 0.0]
component = "x"
"""


class FakeSimulation:
    """Stokes flow past a fixed sphere with a made-up approach to a steady state."""

    bodies_move = False

    def __init__(self, case_toml: str = CASE, time_step: float = 0.05, bodies: int = 1):
        data = tomllib.loads(case_toml)
        output = {"fields_every": None, "checkpoint_every": 300.0, "wall_line": None} | data[
            "output"
        ]
        output["plane"] = SimpleNamespace(axis="z", at=None)
        output["lines"] = [SimpleNamespace(**line) for line in output.get("lines", ())]
        if output["wall_line"]:
            output["wall_line"] = SimpleNamespace(**output["wall_line"])
        self.case = SimpleNamespace(
            title=data["title"],
            electric=None,
            reference=data.get("reference"),
            domain=SimpleNamespace(**data["domain"]),
            output=SimpleNamespace(**output),
        )
        lengths, cells = data["domain"]["lengths"], data["domain"]["cells"]
        self.grid = Grid(
            tuple(
                uniform_axis(name, -length / 2, length, count, name == "x")
                for name, length, count in zip("xyz", lengths, cells, strict=True)
            )
        )
        self.time, self.steps, self.time_step, self.status = 0.0, 0, time_step, "running"
        self.bodies = bodies
        self.history = {"step": [], "time": [], "change_rate": [], "mean_velocity": []}
        x, y, z = np.meshgrid(*(axis.centres for axis in self.grid.axes), indexing="ij")
        r = np.maximum(np.sqrt(x**2 + y**2 + z**2), 1.0)
        towards = 0.75 * (x / r**3) * (1 - 1 / r**2)
        self.velocity = 4.4 * np.stack(
            [1 - 0.75 / r - 0.25 / r**3 - towards * x, -towards * y, -towards * z]
        )
        self.pressure = -6.6 * x / r**3
        self.indicator = 0.5 * (1 - np.tanh((np.sqrt(x**2 + y**2 + z**2) - 1) / 0.3))

    @property
    def force(self) -> float:
        return 163.6 + 2000 * math.exp(-self.time / 0.2)

    @property
    def particles(self) -> list[dict]:
        body = {
            "shape": "sphere",
            "position": np.zeros(3),
            "velocity": np.zeros(3),
            "angular_velocity": np.zeros(3),
            "orientation": np.array([1.0, 0.0, 0.0, 0.0]),
            "force": np.array([self.force, 0.0, 0.0]),
            "torque": np.zeros(3),
            "interior_velocity": np.array([0.007, 0.0, 0.0]),
            "painted_offset": 0.04,
        }
        return [{"name": f"sphere-{n + 1}"} | body for n in range(self.bodies)]

    def run(self, steps: int, observer=None) -> None:
        for _ in range(steps):
            self.steps += 1
            self.time += self.time_step
            self.history["step"].append(self.steps)
            self.history["time"].append(self.time)
            self.history["change_rate"].append(3.0 * math.exp(-self.time))
            self.history["mean_velocity"].append(np.array([4.4, 0.0, 0.0]))
            if observer:
                observer(self)
        self.status = "steady"

    def summary(self) -> dict:
        return {
            "status": self.status,
            "steps": self.steps,
            "time": self.time,
            "time_step": np.float64(self.time_step),
            "wall_seconds": 2.5,
            "seconds_per_step": 0.0083,
            "cells": self.grid.cell_count,
            "threads": 4,
            "bodies": [
                {"name": body["name"]}
                | {
                    key: body[key]
                    for key in ("force", "torque", "position", "velocity", "interior_velocity")
                }
                for body in self.particles
            ],
            "wall_force": {"y_high": np.array([-self.force / 4, 0, 0]), "total": [np.nan, 0, 0]},
            "mean_velocity": [4.41, 0.0, 0.0],
            "max_divergence": 3e-14,
            "change_rate": 9e-4,
            "resolution": {"a/ξ": 3.333, "ξ/Δx": 1.92, "√(νΔt)/ξ": 0.755},
            "start": [{"cells": [20, 7, 7], "steps": 100, "time": 5.0, "status": "steady"}],
        }

    def table(self) -> list[tuple[str, str, str]]:
        return [
            ("force on sphere-1", f"({self.force:.6g}, 0, 0)", ""),
            ("time step", f"{self.time_step:.6g}", "stable up to 0.1"),
        ]

    def sample_line(self, axis, through, component):
        """Nearest cell: good enough for a fake."""
        number = "xyz".index(axis)
        centres = [a.centres for a in self.grid.axes]
        others = iter(through)
        index = [
            slice(None) if n == number else int(np.abs(c - next(others)).argmin())
            for n, c in enumerate(centres)
        ]
        return centres[number], self.velocity[("xyz".index(component), *index)]

    def sample_plane(self, axis, at):
        number = "xyz".index(axis)
        first, second = (n for n in range(3) if n != number)
        k = int(np.abs(self.grid.axes[number].centres - at).argmin())
        velocity = np.take(self.velocity, k, axis=number + 1)
        return {
            "x": self.grid.axes[first].centres,
            "y": self.grid.axes[second].centres,
            "speed": np.sqrt((velocity**2).sum(axis=0)),
            "velocity": velocity[[first, second]],
            "indicator": np.take(self.indicator, k, axis=number),
            "labels": ("xyz"[first], "xyz"[second]),
        }

    def wall_shear(self, wall, component, along, at):
        x = self.grid.axes["xyz".index(along)].centres
        return x, 0.8 - 1.5 * np.exp(-(((x - 0.5) / 2.0) ** 2))


PREFLIGHT = [
    {"name": "a/ξ", "value": 3.33, "limit": 3.0, "verdict": "ok", "note": "radius over thickness"},
    {"name": "ξ/Δx", "value": 1.1, "limit": 1.3, "verdict": "warn", "note": "thin for this mesh"},
]


def write_run(path, case_toml: str = CASE, steps: int = 60, **options) -> FakeSimulation:
    simulation = FakeSimulation(case_toml, **options)
    with RunDirectory(path, case_toml, PREFLIGHT) as run:
        simulation.run(steps, observer=run.record)
        run.finish(simulation)
    return simulation


@pytest.fixture
def with_snapshots():
    return CASE.replace("every = 1", "every = 1\nfields_every = 0.1")


def strict_json(path) -> dict:
    def refuse(constant: str):
        raise AssertionError(f"{constant} in {path}")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def test_a_finished_run_holds_every_file(tmp_path):
    write_run(tmp_path / "run")
    assert {path.name for path in (tmp_path / "run").iterdir()} == {
        "case.toml",
        "run.json",
        "history.csv",
        "particles.csv",
        "lines.csv",
        "plane.npz",
        "fields.h5",
        "summary.json",
    }


@pytest.mark.parametrize("kind", ["file", "directory", "filled"])
def test_nothing_that_exists_is_overwritten(tmp_path, kind):
    path = tmp_path / "run"
    path.write_text("mine") if kind == "file" else path.mkdir()
    if kind == "filled":
        (path / "notes.txt").write_text("mine")
    with pytest.raises(CaseError, match=r"run exists already; nothing was overwritten\."):
        RunDirectory(path, CASE)
    mine = path if kind == "file" else path / "notes.txt"
    assert kind == "directory" or mine.read_text() == "mine"


def test_a_directory_that_cannot_be_made_is_a_case_error(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(CaseError, match=r"cannot be made"):
        RunDirectory(tmp_path / "file" / "run", CASE)


def test_next_free_directory_counts_up(tmp_path):
    names = []
    for _ in range(3):
        path = next_free_directory(tmp_path, "duct")
        path.mkdir()
        names.append(path.name)
    assert names == ["duct", "duct-2", "duct-3"]


def test_json_holds_no_nan_and_no_numpy(tmp_path):
    write_run(tmp_path / "run")
    summary = strict_json(tmp_path / "run" / "summary.json")
    assert summary["wall_force"]["total"] == [None, 0, 0]
    assert summary["time_step"] == 0.05
    assert summary["bodies"][0]["position"] == [0.0, 0.0, 0.0]
    assert strict_json(tmp_path / "run" / "run.json")["preflight"] == PREFLIGHT
    text = to_json({"a": np.float32("inf"), "b": (np.int64(3), math.nan), "c": np.bool_(True)})
    assert json.loads(text) == {"a": None, "b": [3, None], "c": True}


def test_tables_keep_every_digit(tmp_path):
    simulation = write_run(tmp_path / "run", steps=7)
    record = read_run(tmp_path / "run")
    assert record.history["time"].tolist() == simulation.history["time"]
    assert record.history["change_rate"].tolist() == simulation.history["change_rate"]
    assert record.history["mean_velocity_x"].tolist() == [4.4] * 7
    sphere = record.particles["sphere-1"]
    assert sphere["force_x"][-1] == simulation.force
    assert sphere["orientation_w"].tolist() == [1.0] * 7
    coordinates, values = record.lines["wake"]
    expected = simulation.sample_line("y", [2.0, 0.0], "x")
    assert np.array_equal(coordinates, expected[0])
    assert np.array_equal(values, expected[1])
    assert np.array_equal(record.wall_shear[1], simulation.wall_shear("y_high", "x", "x", 0)[1])
    assert np.array_equal(record.plane["speed"], simulation.sample_plane("z", 0.0)["speed"])
    assert record.case_toml == CASE


def test_rows_are_on_disk_as_the_run_goes(tmp_path):
    simulation = FakeSimulation()
    with RunDirectory(tmp_path / "run", CASE) as run:
        for number in (1, 2, 3):
            simulation.run(1, observer=run.record)
            record = read_run(tmp_path / "run")
            assert len(record.history["time"]) == number
            assert len(record.particles["sphere-1"]["time"]) == number
            assert record.run["status"] == "running"
            run.record(simulation)  # nothing new: no row


def test_a_row_cut_off_by_a_crash_is_left_out(tmp_path):
    write_run(tmp_path / "run", steps=5)
    path = tmp_path / "run" / "history.csv"
    path.write_text(path.read_text()[:-4])
    assert len(read_run(tmp_path / "run").history["time"]) == 4


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (BlowUpError("velocity is NaN in cell (1, 2, 3)"), "blew_up"),
        (KeyboardInterrupt(), "interrupted"),
        (RuntimeError("disk"), "failed"),
    ],
)
def test_what_ended_a_run_is_written_down(tmp_path, error, status):
    simulation = FakeSimulation()
    with pytest.raises(type(error)), RunDirectory(tmp_path / "run", CASE) as run:
        simulation.run(3, observer=run.record)
        raise error
    record = read_run(tmp_path / "run")
    assert record.run["status"] == status
    assert record.run["message"] == (str(error) or "KeyboardInterrupt")
    assert record.run["ended"] is not None
    assert len(record.history["time"]) == 3
    assert record.summary == {}


def test_leaving_without_finishing_is_not_called_running(tmp_path):
    with RunDirectory(tmp_path / "run", CASE):
        pass
    assert read_run(tmp_path / "run").run["status"] == "unfinished"


def test_run_json_names_versions_and_machine(tmp_path):
    write_run(tmp_path / "run", steps=1)
    run = strict_json(tmp_path / "run" / "run.json")
    assert run["status"] == "steady"
    assert {"python", "smoothprofile", "numpy", "numba", "ducc0", "h5py"} <= set(run["versions"])
    assert run["machine"]["cores"] >= 1


def test_fields_hold_the_end_only_unless_asked_otherwise(tmp_path, with_snapshots):
    simulation = write_run(tmp_path / "last", steps=5)
    write_run(tmp_path / "many", with_snapshots, steps=5)
    with h5py.File(tmp_path / "last" / "fields.h5") as file:
        assert list(file["time"]) == [simulation.time]
        assert np.allclose(file["velocity"][0].T, simulation.velocity, rtol=6e-8, atol=1e-12)
    with h5py.File(tmp_path / "many" / "fields.h5") as file:
        # .1 and .2 as asked (sums of .05), .25 because it is the end
        assert np.allclose(file["time"], [0.1, 0.2, 0.25], rtol=1e-12)


def test_only_a_run_directory_is_read(tmp_path):
    with pytest.raises(CaseError, match=r"not a run directory"):
        read_run(tmp_path)


def test_a_table_is_read_by_its_own_line_ends(tmp_path):
    """Names may hold what `str.splitlines` takes for the end of a line; a cut row is left out."""
    (tmp_path / "rows.csv").write_text('name,x\n"a\u2028b, c",1\nd\x85,2\ne,', encoding="utf-8")
    assert read_table(tmp_path / "rows.csv") == [
        {"name": "a\u2028b, c", "x": "1"},
        {"name": "d\x85", "x": "2"},
    ]
