"""Cases with fluid.flow = "stokes": what they may say, what is checked, what the commands show."""

import json

import pytest

from case_makers import refusal
from quasistatic_boxes import ball, box
from smoothprofile.config import load_case
from smoothprofile.numbers import numbers_of
from smoothprofile.runs import run_of
from smoothprofile.stokes_assembly import flow_speed
from smoothprofile.stokes_simulation import StokesSimulation


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"time": {"scheme": "bdf2"}}, "time.scheme is \"bdf2\"; in Stokes flow bodies are moved"),
        ({"time": {"coupling": "thesis"}}, "time.coupling is \"thesis\"; in Stokes flow fluid and"),
        ({"fluid": {"advection": False}}, "fluid.advection is false; in Stokes flow there is none"),
        ({"fluid": {"initial_velocity": [0, 0, 0]}}, "the flow has no memory of a start"),
        ({"contact": {"restitution": 0.5}}, "bodies without inertia do not bounce"),
        ({"domain": {"precision": "single"}}, 'Stokes flow needs "double"'),
        ({"profile": {"retract": "radial"}}, 'it must be true, false or "planar"'),
        ({"fluid": {"tolerance": 1.0}}, "it must be from 1e-12 to 0.1"),
        ({"fluid": {"flow": "creeping"}}, 'it must be "inertial" or "stokes"'),
        ({"fluid": {"flow": "inertial"}}, 'fluid.tolerance is 1e-07; only flow = "stokes" has one'),
        ({"fluid": {"mean_velocity": {"x": 0.0, "y": 0.0}}}, "fluid.mean_velocity.z is missing"),
        ({"fluid": {"body_force": [0, 0.5, 0]}}, "along y the mean velocity is held, whatever"),
    ],
)  # fmt: skip
def test_what_has_no_meaning_without_inertia_is_refused(changes, sentence):
    assert sentence in refusal(box(ball([4, 4, 4]), **changes))


def test_a_force_towards_walls_drives_nothing():
    towards = {"mean_velocity": {}, "body_force": [0.0, 50.0, 0.0]}
    walled = {"boundaries": ("periodic", "wall", "periodic")}
    case = load_case(box(ball([4, 4, 4], "held"), fluid=towards, **walled))
    assert flow_speed(case) == 0.0
    assert numbers_of(case).get("Re") is None
    along = {"mean_velocity": {}, "body_force": [50.0, 0.0, 0.0]}
    assert flow_speed(load_case(box(ball([4, 4, 4], "held"), fluid=along, **walled))) > 1.0


def test_bodies_and_starts_that_have_no_meaning_are_refused():
    text = refusal(box(ball([4, 4, 4], velocity=[1.0, 0, 0])))
    assert "in Stokes flow a free body has the motion that its loads give it" in text
    held = box(ball([4, 4, 4], "held"), start=[{"cells": [8, 8, 8]}])
    assert "every step is a flow of its own" in refusal(held)


def test_a_case_comes_back_from_its_own_text(tmp_path):
    case = load_case(box(ball([4, 4, 4])))
    text = case.to_toml()
    assert "scheme" not in text
    assert "restitution" not in text
    path = tmp_path / "case.toml"
    path.write_text(text)
    assert load_case(path) == case


def test_the_step_is_a_tenth_of_the_time_that_a_body_takes_for_its_radius():
    pulled = box(ball([4, 4, 4], force=[0.0, 0.0, 56.548668]))
    assert StokesSimulation(load_case(pulled)).time_step == pytest.approx(0.1 / 3.0)
    sheared = box(
        ball([4, 4, 4]), boundaries=("periodic", "wall", "periodic"),
        fluid={"mean_velocity": {}, "wall_velocity": {"y_high": [80.0, 0, 0]}},
    )  # fmt: skip
    assert StokesSimulation(load_case(sheared)).time_step == pytest.approx(0.4 / 80.0)


def test_checks_name_what_a_run_rests_on():
    fast = box(ball([4, 4, 4], force=[0.0, 0.0, 188.5]), time={"step": 0.1})
    found = {row["name"]: row for row in StokesSimulation(load_case(fast)).preflight()}
    # U = 10: Re = 10, and a step that takes a body its whole radius.
    assert found["Re"]["value"] == pytest.approx(10.0, rel=1e-3)
    assert found["Re"]["verdict"] == found["step, farthest moved"]["verdict"] == "warn"
    assert found["a/ξ"]["value"] == pytest.approx(1.6)
    assert found["ξ/Δx"]["verdict"] == "ok"
    assert {"memory (GiB)", "disk (GiB)", "time (s)", "surface of sphere"} <= set(found)
    assert numbers_of(load_case(fast))["Re"] == pytest.approx(10.0, rel=1e-3)


def test_a_mesh_that_does_not_fit_is_refused_before_it_is_made():
    with pytest.raises(Exception, match=r"domain.cells is 30000×30000×30000"):
        run_of(load_case(box(ball([4, 4, 4]), domain={"cells": [30000] * 3})))


def test_a_built_in_case_runs_from_the_command_and_leaves_what_others_do(spm, tmp_path):
    coarse = ["--set", "domain.cells=[24,24,24]", "--set", "profile.thickness=0.36"]
    code, out, _ = spm("run", "stokes-array", "--json", "--out", tmp_path / "run", *coarse)
    assert code == 0
    summary = json.loads(out)
    assert summary["status"] == "steady"
    # 24³ cells: .4 %.
    assert summary["bodies"][0]["force"][0] == pytest.approx(68.659, rel=6e-3)
    left = {path.name for path in (tmp_path / "run").iterdir()}
    assert {"case.toml", "history.csv", "particles.csv", "fields.h5", "report.html"} <= left
    header = (tmp_path / "run" / "history.csv").read_text().splitlines()[0].split(",")
    assert {"iterations", "residual", "max_speed"} <= set(header)
    assert "Beside the reference" in (tmp_path / "run" / "report.html").read_text()


def test_bad_cases_end_the_command_with_a_sentence(spm):
    code, _, err = spm("check", "stokes-array", "--set", "time.scheme=bdf2")
    assert code == 2
    assert "in Stokes flow bodies are moved by the Adams-Bashforth rule" in " ".join(err.split())
    code, out, _ = spm("check", "stokes-sedimentation", "--json")
    assert code == 0
    assert json.loads(out)


def test_a_body_that_moves_too_far_is_tried_again_with_a_smaller_step(spm, tmp_path):
    case = load_case(box(ball([4, 4, 4], force=[0, 0, 60.0]), side=7.0, cells=16,
                         profile={"thickness": 0.7}, time={"step": 0.4, "end": 1.6}))  # fmt: skip
    (tmp_path / "far.toml").write_text(case.to_toml())
    run = ("run", "far.toml", "--json", "--out", "far")
    code, out, err = spm(*run)
    assert code == 3
    assert "has moved by" in out + err
    code, out, _ = spm(*run[:-1], "again", "--retry", "1")
    assert code == 0
    summary = json.loads(out)
    assert summary["status"] == "finished"
    assert summary["retries"][0]["time_step"] == pytest.approx(0.2)


def test_the_step_is_beside_what_really_moves_bodies():
    """Of one that is pulled and one that is pushed on at a given speed, the faster one's."""
    pulled = ball([2, 4, 4], force=[0.0, 0.0, 20.0])
    for speed, words in ((0.0, "a body's loads move it"), (9.0, "a body's given motion takes it")):
        sent = ball([6, 4, 4], "prescribed", velocity=[0.0, 0.0, speed])
        rows = StokesSimulation(load_case(box(pulled, sent))).preflight()
        note = next(row["note"] for row in rows if row["name"] == "time step")
        assert f"in which {words}" in note
