"""What stops a run before its end: signals, time limits, and a solution that ceased to be one."""

import json
import os
import signal
from dataclasses import replace

import h5py
import numpy as np
import pytest

from case_makers import small_case, sphere
from restarts import files_digest, run_stopping, state_digest
from smoothprofile.config import load_case
from smoothprofile.config.tomltext import document
from smoothprofile.errors import BlowUpError
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.watch import BodyWatch
from smoothprofile.runs import run_of
from smoothprofile.selfcheck import error_card
from smoothprofile.stops import BEFORE_JOB_ENDS, Stops
from test_resume import body, box, touching


@pytest.fixture
def told():
    return []


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGUSR1])
def test_the_first_signal_waits_for_the_step_and_the_second_does_not(told, number):
    before = signal.getsignal(number)
    with Stops(None, told.append) as stops:
        assert stops.reason() == ""
        os.kill(os.getpid(), number)
        assert stops.reason() == signal.Signals(number).name
        assert len(told) == 1
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), number)
    assert signal.getsignal(number) is before


def test_limits_of_time_stop_a_run(told, monkeypatch):
    now = [1000.0]
    monkeypatch.setattr("smoothprofile.stops.clock.monotonic", lambda: now[0])
    monkeypatch.setattr("smoothprofile.stops.clock.time", lambda: now[0])
    limited = Stops(50.0, told.append)
    monkeypatch.setenv("SLURM_JOB_END_TIME", f"{now[0] + BEFORE_JOB_ENDS + 80.0}")
    in_a_job = Stops(None, told.append)
    monkeypatch.setenv("SLURM_JOB_END_TIME", "soon")
    elsewhere = Stops(None, told.append)
    assert not limited.reason() and not in_a_job.reason()
    now[0] += 49.0
    assert not limited.reason()
    now[0] += 1.0
    assert limited.reason() == "output.stop_after" and not in_a_job.reason()
    now[0] += 30.0
    assert in_a_job.reason() == "the end of the job" and not elsewhere.reason()


def test_a_run_that_is_stopped_goes_on_to_the_same_bits(spm, tmp_path, monkeypatch):
    """Through the commands: exit code 4, a sentence, and one line that a queue can repeat."""
    monkeypatch.setattr("smoothprofile.running.write_report", lambda path: path / "report.html")
    case = touching()
    case["output"]["checkpoint_every"] = 1e9
    whole = run_stopping(case, tmp_path / "whole")
    line = ("run", tmp_path / "whole" / "case.toml", "--out", "queued", "--resume-if-exists")
    passed = []

    def ask(self):
        passed.append(None)
        return "SIGTERM" if len(passed) in (3, 7) else ""

    monkeypatch.setattr(Stops, "reason", ask)
    for _ in range(2):
        code, out, err = spm(*line)
        assert (code, out) == (4, "")
        assert "Stopped by SIGTERM at t = " in err and "spm resume queued goes on from step" in err
    assert json.loads((tmp_path / "queued" / "run.json").read_text())["status"] == "interrupted"
    assert spm(*line)[0] == 0
    assert files_digest(tmp_path / "queued") == files_digest(tmp_path / "whole")
    assert state_digest(whole)


def test_a_run_that_blows_up_leaves_its_last_fields_and_says_what_would_hold(spm, tmp_path):
    """A force in a periodic box drives what no check can know beforehand."""
    case = box(
        body([3.5, 3.0, 3.0]),
        fluid={"viscosity": 1e-3, "body_force": [40.0, 3.0, 0.0]},
        profile={"retract": False},
        time={"step": 0.1, "end": 40.0, "max_steps": 100},
    )
    (tmp_path / "case.toml").write_text(load_case(case).to_toml(), encoding="utf-8")
    code, _, err = spm("run", "case.toml", "--out", "run")
    assert code == 3
    sentence = next(line for line in err.splitlines() if line.startswith("At time"))
    for words in ("velocity component", "in cell (", "Courant number", "may not exceed 100"):
        assert words in sentence
    held = float(sentence.rpartition("Δt = ")[2].split()[0])
    assert 0.0 < held <= 0.05
    with h5py.File(tmp_path / "run" / "postmortem.h5") as file:
        assert np.abs(file["velocity"][0]).max() > 50.0


def test_seeds_are_in_the_record_of_a_run(spm, tmp_path, monkeypatch):
    """The case that is kept has places and radii written out, and no seed."""
    monkeypatch.setattr("smoothprofile.running.write_report", lambda path: path / "report.html")
    drawn = {"shape": "sphere", "radius": 0.5, "random": {"count": 2, "seed": 7}}
    dealt = {
        "shape": "sphere",
        "radius": {"sizes": [0.3, 0.4], "shares": [1, 1]},
        "lattice": {"kind": "cubic", "counts": [1, 1, 2]},
    }
    case = box(dealt, drawn, body([3.5, 3.0, 3.0], radius=0.5), time={"max_steps": 1})
    case["profile"]["thickness"] = 0.2
    (tmp_path / "case.toml").write_text(document(case), encoding="utf-8")
    code, _, err = spm("run", "case.toml", "--out", "run", "--set", "particles.1.random.seed=8")
    assert code == 0, err
    record = json.loads((tmp_path / "run" / "run.json").read_text())
    assert record["seeds"] == {"particles.0.radius": 0, "particles.1.random": 8}


def watch():
    grid = Grid(tuple(uniform_axis(n, 0.0, 10.0, 10, n == "x") for n in "xyz"))
    return BodyWatch(grid, np.array([1]), np.array([[1.0] * 3, [2.0, 1.0, 1.0]]), ["a", "b"])


def test_a_free_body_that_is_lost_stops_the_run_by_name():
    start = np.array([[5.0, 5.0, 5.0], [5.0, 5.0, 5.0]])

    def after(move, body=1):
        look, there = watch(), start.copy()
        look(start, 1.0, 0.1)
        there[body] += move
        look(there, 1.1, 0.1)

    after([0.49, 0.0, 0.0])
    # The first body is held, and of no concern.
    after([9.0, 9.0, 9.0], body=0)
    with pytest.raises(BlowUpError, match=r"b has moved by 1 in one step, .* Δt = 0.05 would"):
        after([0.0, 0.0, 1.0])
    with pytest.raises(BlowUpError, match=r"the place of b is not finite"):
        after([np.nan, 0.0, 0.0])
    with pytest.raises(BlowUpError, match=r"b has left the box: its z is -0.1, .* 0 and 10"):
        after([0.0, 0.0, -5.1])
    # Along a periodic axis nothing is outside.
    far = np.array([[5.0, 5.0, 5.0], [105.0, 5.0, 5.0]])
    watch()(far, 1.0, 0.1)


def test_the_error_card_turns_red_where_something_is_wrong(tmp_path):
    good = run_stopping(
        box(body([3.5, 3.0, 3.0]), fluid={"body_force": [0.05, 0.0, 0.0]})
        | {"time": {"step": 0.2, "end": 100.0, "steady_tolerance": 1e-3}, "output": {"every": 9}},
        tmp_path / "good",
    )
    card = {line["name"]: line for line in good.summary()["error_card"]}
    books = {"divergence", "momentum", "energy"}
    assert books | {"slip inside bodies", "a/ξ", "ξ/Δx"} <= set(card)
    assert {card[name]["verdict"] for name in books} == {"green"}
    assert " % is dissipated by slip" in card["energy"]["note"]
    assert all(line["verdict"] in ("green", "amber", "red") for line in card.values())
    assert all(line["note"] for line in card.values())
    for velocity in good.state.velocity:
        velocity += np.linspace(0.0, 1.0, velocity.size).reshape(velocity.shape)
    good.budget = replace(good.budget, momentum=0.06, energy=0.02)
    worse = {line["name"]: line["verdict"] for line in good.summary()["error_card"]}
    assert worse["divergence"] == worse["momentum"] == worse["slip inside bodies"] == "red"
    assert worse["energy"] == "amber"


def test_overlaps_are_on_the_error_card(tmp_path):
    """Of the nearest images: here through the periodic side."""
    pair = (body([0.9, 3.0, 3.0], radius=0.5), body([6.3, 3.0, 3.0], radius=0.5))
    run = run_stopping(
        box(*pair, profile={"thickness": 0.2}, time={"max_steps": 1}), tmp_path / "a"
    )
    card = {line["name"]: line for line in run.summary()["error_card"]}
    assert card["overlap of spheres"]["value"] == 0.0
    run.bodies.state.position[1, 0] = 7.2
    card = {line["name"]: line for line in run.summary()["error_card"]}
    # Centres .7 apart, two radii of .5: .3 deep, .6 of a radius; round-off of the places.
    assert card["overlap of spheres"]["value"] == pytest.approx(0.6, rel=1e-12)
    assert card["overlap of spheres"]["verdict"] == "red"


def resting(height, flow):
    """A sphere that has come to lie on the floor."""
    case = small_case(
        sphere(motion="free", density=2.0, position=[0.0, 0.0, height]),
        boundaries=("periodic", "periodic", "wall"),
    )
    case["fluid"] |= {"gravity": [0.0, 0.0, -1.0], "flow": flow}
    case["profile"]["thickness"] = 0.5
    run = run_of(load_case(case | {"time": {"end": 30.0}}))
    run.run()
    return run


@pytest.mark.parametrize("flow", ["inertial", "stokes"])
@pytest.mark.parametrize("height", [-2.0, None])
def test_a_body_that_lies_still_has_no_errors(height, flow):
    """Having fallen there, and having begun where it lies."""
    first = resting(-2.0, flow)
    run = first if height else resting(float(first.particles[0]["position"][2]), flow)
    assert max(run.extremes.speed) < 0.01 * max(first.history["max_speed"])
    lines = {line["name"]: line for line in error_card(run)}
    assert lines["slip inside bodies"]["verdict"] == lines["momentum"]["verdict"] == "green"
