"""A run that was stopped ends with the bits of one that was not: state and files."""

import json
from itertools import pairwise, product

import pytest

from restarts import (
    NO_CHECKPOINTS_OF_THEIR_OWN,
    files_digest,
    observer,
    run_stopping,
    state_digest,
)
from smoothprofile.checkpoint import read_checkpoint
from smoothprofile.config import load_case
from smoothprofile.errors import StoppedError
from smoothprofile.output import RunDirectory
from smoothprofile.running import taken_up
from smoothprofile.runs import run_of

STEPS = 14


def body(place, motion="held", **changes):
    found = {"shape": "sphere", "radius": 1.0, "position": place, "motion": motion}
    if motion == "free":
        found["density"] = 2.0
    return found | changes


def box(*bodies, boundaries=("periodic",) * 3, cells=(14, 12, 12), **changes):
    case = {
        "domain": {
            "lengths": [n / 2.0 for n in cells],
            "cells": list(cells),
            "boundaries": list(boundaries),
        },
        "fluid": {"density": 1.0, "viscosity": 1.0},
        "profile": {"thickness": 0.4},
        "particles": list(bodies),
        "time": {"step": 0.02, "end": 1.0, "max_steps": STEPS, "scheme": "backward-euler"},
        "output": {"every": 3, "fields_every": 0.07},
    }
    for table, values in changes.items():
        case[table] = {**case.get(table, {}), **values} if isinstance(values, dict) else values
    return case


def touching():
    """Two free bodies pressed on each other and on a wall, with all that contact can do."""
    pair = (
        body([2.4, 3.0, 1.3], "free", velocity=[1.0, 0.0, -1.0], angular_velocity=[0, 3, 0]),
        body([4.6, 3.0, 1.4], "free", density=0.7, velocity=[-1.0, 0.0, 0.0]),
    )
    fluid = {"density": 1.0, "viscosity": 0.5, "gravity": [0.0, 0.0, -4.0]}
    contact = {"friction": 0.4, "lubrication": True, "restitution": 0.7}
    walls = ("periodic", "periodic", "wall")
    return box(
        *pair,
        boundaries=walls,
        fluid=fluid,
        contact=contact,
        time={"step": 0.01},
        profile={"retract": "planar"},
    )


def dielectric(every):
    """A free and a held body in a field that turns."""
    bodies = (
        body([2.3, 3.0, 3.0], "free", permittivity=8.0),
        body([4.9, 3.2, 3.0], permittivity=0.1),
    )
    field = {"field": [1.0, 0.0, 0.0], "quadrature": [0.0, 1.0, 0.0], "angular_frequency": 6.0}
    return box(*bodies, electric={**field, "permittivity": 1.0, "every": every})


ELLIPSOID = {"shape": "ellipsoid", "radii": [1.2, 0.8, 0.9], "position": [3.0, 3.0, 3.0]}
PHYSICS = {
    "flow alone": box(
        fluid={"initial_velocity": [1.0, 0.0, 0.5], "body_force": [1.0, 0.0, 0.0]},
        boundaries=("periodic", "wall", "periodic"),
    ),
    "prescribed": box(
        ELLIPSOID
        | {
            "motion": "prescribed",
            "velocity": {"amplitude": [1.0, 0.0, 0.0], "angular_frequency": 5.0},
            "angular_velocity": [0.0, 2.0, 1.0],
        }
    ),
    "free": box(
        ELLIPSOID | {"motion": "free", "density": 0.5, "angular_velocity": [1.0, 2.0, 0.0]},
        fluid={"body_force": [0.0, 2.0, 0.0]},
    ),
    "contact": touching(),
    "held mean": box(
        body([3.0, 3.0, 3.0], "free", force=[5.0, 0.0, 0.0]),
        fluid={"mean_velocity": {"x": 1.0, "y": 0.0}},
        boundaries=("periodic", "periodic", "wall"),
    ),
    "field": dielectric(1),
    "field, every third step": dielectric(3),
    "sliding walls": box(
        body([3.0, 3.0, 3.0], "free"),
        boundaries=("periodic", "wall", "periodic"),
        fluid={"wall_velocity": {"y_high": {"amplitude": [2.0, 0, 0], "angular_frequency": 8.0}}},
    ),
    "stretched": box(
        body([3.0, 3.0, 3.0]),
        boundaries=("periodic", "wall", "wall"),
        domain={
            "lengths": [7.0, 6.0, 6.0],
            "cells": [14, 12, 12],
            "boundaries": ["periodic", "wall", "wall"],
            "stretching": ["uniform", {"focus": 3.0, "ratio": 2.0}, "uniform"],
        },
        fluid={"initial_velocity": [1.0, 0.0, 0.0]},
    ),
    "no advection": box(
        body([3.0, 3.0, 3.0], "free", force=[1.0, 0.0, 0.0]), fluid={"advection": False}
    ),
}
SCHEMES = ("backward-euler", "crank-nicolson", "bdf2", "bdf3")
COUPLINGS = ("incremental", "thesis")
FAST = [
    ("flow alone", "bdf3", "incremental", 1, 2, "double"),
    ("contact", "bdf2", "incremental", 1, 2, "double"),
    ("field, every third step", "bdf2", "incremental", 2, 1, "double"),
    ("held mean", "crank-nicolson", "incremental", 1, 1, "single"),
    ("prescribed", "bdf3", "thesis", 1, 1, "double"),
]
ALL = [
    (*chosen, 1 + number % 2, 1 + (number // 2) % 2, "double")
    for number, chosen in enumerate(product(PHYSICS, SCHEMES, COUPLINGS))
]
ALL += [
    (name, scheme, "incremental", 2, 1, "single")
    for name, scheme in product(PHYSICS, SCHEMES)
    if "field" not in name
]


def case_of(physics, scheme, coupling, precision):
    case = {key: dict(v) if isinstance(v, dict) else v for key, v in PHYSICS[physics].items()}
    case["time"] |= {"scheme": scheme, "coupling": coupling}
    case["domain"]["precision"] = precision
    return case


def same_as_unbroken(case, tmp_path, stops, threads):
    """The unbroken run, with one thread, and each stopped one end alike."""
    whole = run_stopping(case, tmp_path / "whole")
    state, files = state_digest(whole), files_digest(tmp_path / "whole")
    for number, places in enumerate(stops):
        broken = run_stopping(case, tmp_path / f"{number}", places, threads)
        assert state_digest(broken) == state
        assert files_digest(tmp_path / f"{number}") == files
    return whole


@pytest.mark.parametrize("choice", FAST, ids=lambda choice: ", ".join(map(str, choice)))
def test_a_stopped_run_ends_with_the_same_bits(tmp_path, choice):
    *what, first, then, precision = choice
    same_as_unbroken(case_of(*what, precision), tmp_path, [(5,), (1, 7)], (first, then))


@pytest.mark.slow
@pytest.mark.parametrize("choice", ALL, ids=lambda choice: ", ".join(map(str, choice)))
def test_the_matrix_of_restarts(tmp_path, choice):
    *what, first, then, precision = choice
    # After one, two and three steps schemes of several levels are still growing into themselves.
    stops = [(1,), (2,), (3,), (8,), (STEPS - 1,), (4, 5), (1, 1, 1)]
    same_as_unbroken(case_of(*what, precision), tmp_path, stops, (first, then, 1))


def test_a_run_stopped_before_its_own_first_step_goes_on(tmp_path):
    """Preliminary runs are part of the run: stopped in the first, in the second, and after them."""
    case = box(
        body([3.5, 3.0, 3.0]),
        fluid={"initial_velocity": [1.0, 0.0, 0.0]},
        time={"max_steps": 4},
        start=[{"cells": [10, 9, 9], "end": 0.08}, {"cells": [12, 10, 10], "end": 0.06}],
    )
    whole = same_as_unbroken(case, tmp_path, [(2,), (5,), (9,), (2, 4, 3)], (1,))
    assert [row["steps"] for row in whole.preliminary] == [4, 3]


def test_a_run_to_a_steady_state_stops_at_the_same_step(tmp_path):
    case = box(body([3.5, 3.0, 3.0]), fluid={"body_force": [1.0, 0.0, 0.0]})
    case["time"] = {"step": 0.2, "end": 100.0, "steady_tolerance": 0.1}
    case["output"] = {"every": 3}
    whole = same_as_unbroken(case, tmp_path, [(2,), (3, 1)], (1,))
    assert whole.status == "steady" and whole.steps > 5


def test_what_was_written_after_a_checkpoint_is_cut_off(tmp_path):
    """A kill leaves rows, frames and snapshots beyond the checkpoint; none comes twice."""
    case = touching()
    run_stopping(case, tmp_path / "whole")
    simulation = run_of(load_case(case, NO_CHECKPOINTS_OF_THEIR_OWN))
    directory = RunDirectory(tmp_path / "killed", simulation.case.to_toml())
    record = observer(simulation, directory)

    def observe(running):
        record(running)
        if running.steps == 4:
            directory.checkpoint(running)
        if running.steps == 11:
            raise StoppedError("as good as killed")

    with pytest.raises(StoppedError), directory:
        simulation.run(observe)
    longer = (tmp_path / "killed" / "history.csv").stat().st_size
    simulation, directory = taken_up(tmp_path / "killed", pytest.fail)
    assert (tmp_path / "killed" / "history.csv").stat().st_size < longer
    with directory:
        simulation.run(observer(simulation, directory))
        directory.finish(simulation)
    assert files_digest(tmp_path / "killed") == files_digest(tmp_path / "whole")


def test_a_run_without_a_checkpoint_starts_anew(tmp_path):
    case = touching()
    whole = run_stopping(case, tmp_path / "whole")
    simulation = run_of(load_case(case, NO_CHECKPOINTS_OF_THEIR_OWN))
    directory = RunDirectory(tmp_path / "killed", simulation.case.to_toml())

    def observe(running):
        directory.record(running)
        if running.steps == 11:
            raise StoppedError("as good as killed")

    with pytest.raises(StoppedError), directory:
        simulation.run(observe)
    simulation, directory = taken_up(tmp_path / "killed", pytest.fail)
    with directory:
        simulation.run(observer(simulation, directory))
        directory.finish(simulation)
    assert state_digest(simulation) == state_digest(whole)


@pytest.mark.parametrize(
    ("place", "change"),
    [
        (("flow_state", "past_velocity"), lambda value: []),
        (("bodies", "past_velocity"), lambda value: []),
        (("bodies", "free", "velocity_gain"), lambda value: 0.0 * value),
        (("flow_state", "pressure"), lambda value: value * (1 + 1e-15)),
    ],
)
def test_what_a_checkpoint_holds_is_needed(tmp_path, place, change):
    """Each piece that is lost or wrong by one bit shows: the comparison is no empty one."""
    case = case_of("contact", "bdf2", "incremental", "double")
    whole = run_stopping(case, tmp_path / "whole")
    simulation = run_of(load_case(case, NO_CHECKPOINTS_OF_THEIR_OWN))
    with pytest.raises(StoppedError):
        directory = RunDirectory(tmp_path / "stopped", simulation.case.to_toml())
        with directory:
            simulation.run(observer(simulation, directory, 6))
    tree = read_checkpoint(tmp_path / "stopped", (tmp_path / "stopped" / "case.toml").read_text())[
        "simulation"
    ]
    inner = tree
    for name in place[:-1]:
        inner = inner[name]
    inner[place[-1]] = change(inner[place[-1]])
    again = run_of(load_case(case, NO_CHECKPOINTS_OF_THEIR_OWN))
    again.restore(tree)
    again.run()
    assert state_digest(again) != state_digest(whole)


def test_no_bit_depends_on_the_number_of_threads(tmp_path):
    case = case_of("contact", "bdf2", "incremental", "double")
    digests = [state_digest(run_stopping(case, tmp_path / f"{n}", threads=(n,))) for n in (1, 2)]
    assert all(a == b for a, b in pairwise(digests))


def test_only_a_run_that_left_something_to_do_is_gone_on_with(spm, tmp_path):
    (tmp_path / "none").mkdir()
    run_stopping(box(time={"max_steps": 2}), tmp_path / "done")
    for name, words in (("none", "not a run directory"), ("done", "has ended already")):
        code, out, err = spm("resume", tmp_path / name)
        assert (code, out) == (2, "") and words in err and len(err.splitlines()) == 1


def test_a_run_killed_before_its_first_row_goes_on(tmp_path):
    """What a kill at the very start may leave: a case, and nothing else."""
    case = box(time={"max_steps": 2})
    whole = run_stopping(case, tmp_path / "whole")
    (tmp_path / "killed").mkdir()
    (tmp_path / "killed" / "case.toml").write_bytes((tmp_path / "whole" / "case.toml").read_bytes())
    simulation, directory = taken_up(tmp_path / "killed", pytest.fail)
    with directory:
        simulation.run(observer(simulation, directory))
        directory.finish(simulation)
    assert state_digest(simulation) == state_digest(whole)
    assert files_digest(tmp_path / "killed") == files_digest(tmp_path / "whole")


@pytest.mark.parametrize("left", [(), ("lock",), ("lock", "run.json", "case.toml.new")])
def test_a_directory_whose_run_had_not_begun_is_begun(spm, tmp_path, monkeypatch, left):
    monkeypatch.setattr("smoothprofile.running.write_report", lambda path: path / "report.html")
    (tmp_path / "run").mkdir()
    for name in left:
        (tmp_path / "run" / name).write_text("{}")
    text = load_case(box(time={"max_steps": 2})).to_toml()
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    assert spm("run", "case.toml", "--out", "run", "--resume-if-exists")[0] == 0
    for words in ("", "nothing left to do"):
        code, _, err = spm("run", "case.toml", "--resume-if-exists")
        assert code == 0 and words in err
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["case"]
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.txt").write_text("mine")
    code, _, err = spm("run", "case.toml", "--out", "run", "--resume-if-exists")
    assert code == 0 and "has ended already: max_steps; there is nothing left to do." in err
    code, out, _ = spm("run", "case.toml", "--out", "run", "--resume-if-exists", "--json")
    assert code == 0 and json.loads(out)["status"] == "max_steps"
    code, _, err = spm("run", "case.toml", "--out", "other", "--resume-if-exists")
    assert code == 2 and "not a run directory" in err
    changed = ("--set", "time.max_steps=3")
    code, _, err = spm("run", "case.toml", "--out", "run", "--resume-if-exists", *changed)
    assert code == 2 and "run holds the run of another case than case.toml with these" in err
    assert (tmp_path / "other" / "mine.txt").read_text() == "mine"


def test_a_repeated_run_is_compared_bit_by_bit(spm, tmp_path, monkeypatch):
    monkeypatch.setattr("smoothprofile.running.write_report", lambda path: path / "report.html")
    text = load_case(box(body([3.0, 3.0, 3.0], "free"), time={"max_steps": 3})).to_toml()
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    assert spm("run", "case.toml", "--out", "run")[0] == 0
    code, out, _ = spm("rerun", "run", "--json")
    assert code == 0 and set(json.loads(out)["compared"].values()) == {"same bits"}
    table = tmp_path / "run" / "history.csv"
    table.write_text(table.read_text().replace("0", "5", 1))
    code, out, err = spm("rerun", "run", "--json")
    assert code == 3 and json.loads(out)["compared"]["history.csv"] == "differs"
    assert "differs from that in run" in err
    (tmp_path / "run" / "case.toml").write_text(text + "\n")
    code, _, err = spm("rerun", "run")
    assert code == 2 and "not the case that was run" in err
