"""A run from Python: how it starts, when it stops, what it tells, and that it repeats."""

import json
from functools import cache

import numpy as np
import pytest

import smoothprofile as sp
from case_makers import small_case, sphere
from coupled import simulation
from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.jsontext import to_json
from smoothprofile.threads import available_threads, set_thread_count


def channel(**time):
    """Poiseuille flow u = 1 − y² between walls at ∓1, which the scheme holds exactly."""
    return {
        "domain": {
            "lengths": [0.5, 2.0, 0.5],
            "cells": [2, 16, 2],
            "origin": [0.0, -1.0, 0.0],
            "boundaries": ["periodic", "wall", "periodic"],
        },
        "fluid": {"density": 2.0, "viscosity": 1.0, "body_force": [2.0, 0.0, 0.0]},
        "time": {"step": 0.1, "end": 50.0, **time},
    }


def array(**changes):
    """A sphere in a periodic cube of side 4 through which the fluid is drawn."""
    case = small_case(sphere(), boundaries=["periodic"] * 3)
    case["domain"] |= {"lengths": [4, 4, 4], "cells": [12, 12, 12], "origin": [-2, -2, -2]}
    case["fluid"] |= {"mean_velocity": {"x": 1.0}, "density": 0.5}
    case["profile"]["thickness"] = 0.35
    case["time"] = {"end": 1000.0}
    return case | changes


def all_arrays(simulation):
    state = simulation.state
    return [*state.velocity, state.pressure, simulation.bodies.state.force,
            simulation.bodies.state.torque, simulation.indicator]  # fmt: skip


@pytest.fixture(scope="module")
def finished():
    """Built-in cases run to their end, each once, on all threads."""

    @cache
    def run(name):
        set_thread_count(available_threads())
        simulation = sp.Simulation.from_file(name)
        simulation.run()
        return simulation

    return run


def test_a_case_comes_from_a_name_a_file_or_a_dictionary(tmp_path):
    by_name = sp.Simulation.from_file("couette", {"time.end": 2})
    assert by_name.case.time.end == 2.0
    file = tmp_path / "case.toml"
    file.write_text(by_name.case.to_toml(), encoding="utf-8")
    assert sp.Simulation.from_file(file).case == by_name.case
    assert sp.Simulation.from_file(str(file), ["time.end=3"]).case.time.end == 3.0
    assert sp.Simulation.from_file(channel()).time_step == 0.1
    with pytest.raises(CaseError, match=r"time\.step is 1; .* stable only up to"):
        sp.Simulation.from_file("duct", {"time.step": 1})


def test_a_steady_run_stops_by_its_tolerance_and_is_right():
    run = sp.Simulation.from_file(channel(steady_tolerance=1e-8))
    assert run.status == "running"
    summary = run.run()
    assert summary["status"] == run.status == "steady"
    assert 0 < run.extremes.rate(run.time_step) < 1e-8
    y, u = run.sample_line("y", (0.25, 0.25), "x")
    assert (y[0], y[-1], u[0], u[-1]) == (-1.0, 1.0, 0.0, 0.0)
    # The half cell at the wall lifts the discrete parabola by h²/4; what is left is its approach
    # to the steady state, a few times the tolerance.
    lifted = 1 - y[1:-1] ** 2 + (2 / 16) ** 2 / 4
    assert u[1:-1] == pytest.approx(lifted, abs=1e-6)
    assert run.wall_force["y_high"] == pytest.approx([0.25 * 2.0, 0, 0], abs=1e-6)
    assert run.wall_force["total"][0] == pytest.approx(2.0 * 0.5, rel=1e-6)  # force × volume
    assert run.driving_force == pytest.approx([2.0, 0.0, 0.0])


def test_a_run_ends_at_its_end_or_after_its_steps():
    run = sp.Simulation.from_file(channel(end=1.0))
    run.run()
    assert (run.status, run.steps) == ("finished", 10)
    assert run.time == pytest.approx(1.0, rel=1e-12)  # a sum of ten
    run = sp.Simulation.from_file(channel(end=1.05))
    run.run()
    assert run.steps == 11
    run = sp.Simulation.from_file(channel(max_steps=3))
    assert run.run()["status"] == "max_steps"
    assert run.steps == 3
    assert run.run()["steps"] == 3


def test_history_has_a_row_every_so_often_and_one_at_the_end():
    seen = []
    case = array(output={"every": 4}, time={"end": 1.0, "max_steps": 10})
    run = sp.Simulation.from_file(case)
    run.run(lambda running: seen.append(running.steps))
    assert seen == list(range(1, 11))
    assert run.history["step"] == [4, 8, 10]
    assert {len(column) for column in run.history.values()} == {3}
    assert run.history["time"][-1] == run.time
    assert run.history["body_force"][-1] == pytest.approx(run.particles[0]["force"], rel=1e-15)
    assert np.shape(run.history["wall_force"]) == (3, 3)


def test_forces_balance_when_the_flow_is_steady():
    case = array()
    case["time"]["steady_tolerance"] = 1e-8
    run = sp.Simulation.from_file(case)
    summary = run.run()
    assert summary["mean_velocity"] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)  # held: round-off
    volume = np.prod(run.grid.lengths)
    # What is left of ∂u/∂t is below 1e-8 of the speed, per unit time.
    assert run.driving_force * volume == pytest.approx(run.particles[0]["force"], abs=1e-6)
    assert run.particles[0]["force"][0] > 6 * np.pi
    assert np.linalg.norm(run.particles[0]["interior_velocity"]) < 0.05


def test_fields_have_the_shapes_and_units_they_promise():
    run = sp.Simulation.from_file(array(time={"end": 1000.0, "max_steps": 20}))
    run.run()
    shape = (12, 12, 12)
    assert run.velocity.shape == (3, *shape)
    assert run.velocity.mean(axis=(1, 2, 3)) == pytest.approx([1, 0, 0], abs=1e-12)
    assert run.pressure.shape == run.indicator.shape == shape
    assert abs(run.pressure.mean()) < 1e-10
    assert 0 <= run.indicator.min() < 0.01
    assert 0.95 < run.indicator.max() <= 1  # three ξ inside
    painted = 1.0 + run.particles[0]["painted_offset"]
    volume = run.indicator.sum() / 27
    # ∫φ of a tanh sphere: (4π/3)(R³ + R(πξ)²/4), up to the quadrature of ξ/Δx = 1.
    exact = 4 / 3 * np.pi * (painted**3 + painted * (np.pi * 0.35) ** 2 / 4)
    assert volume == pytest.approx(exact, rel=1e-2)
    doubled = array(time={"end": 1000.0, "max_steps": 20, "step": run.time_step})
    doubled["fluid"] |= {"density": 1.0, "viscosity": 2.0}
    twice = sp.Simulation.from_file(doubled)
    twice.run()
    # The same ν: the same velocities, and pressure and force in proportion to the density.
    assert twice.velocity == pytest.approx(run.velocity, abs=1e-12)
    assert twice.pressure == pytest.approx(2 * run.pressure, abs=1e-9)
    assert twice.particles[0]["force"] == pytest.approx(2 * run.particles[0]["force"], abs=1e-9)


def test_samples_lie_where_they_are_asked():
    case = small_case(sphere(position=[1.0, 0.0, 0.0]))
    case["domain"]["cells"] = [20, 16, 16]
    case["fluid"]["wall_velocity"] = {"y_high": [1.0, 0.0, 0.5]}
    case["profile"]["thickness"] = 0.5
    case["time"] = {"end": 1.0, "max_steps": 10}
    run = sp.Simulation.from_file(case)
    run.run()
    plane = run.sample_plane("z", 0.25)
    assert (plane["x"].size, plane["y"].size, plane["labels"]) == (20, 16, ("x", "y"))
    assert plane["speed"].shape == plane["indicator"].shape == (20, 16)
    assert plane["velocity"].shape == (2, 20, 16)
    u = run.velocity
    # z = .25 is a plane of cell centres, x and y as well: the mean of two faces.
    k = 8
    assert plane["velocity"] == pytest.approx(u[:2, :, :, k], abs=1e-12)
    assert plane["speed"] == pytest.approx(np.linalg.norm(u[:, :, :, k], axis=0), abs=1e-12)
    assert plane["indicator"] == pytest.approx(run.indicator[:, :, k], abs=1e-12)
    peak = np.unravel_index(plane["indicator"].argmax(), (20, 16))
    # The body's centre, within a cell of .5.
    assert abs(plane["x"][peak[0]] - 1.0) <= 0.5
    y, w = run.sample_line("y", (-3.0, 0.25), "z")
    assert (y[0], y[-1]) == (-4.0, 4.0)
    assert (w[0], w[-1]) == pytest.approx((0.0, 0.5), abs=1e-15)  # the mean of cell and ghost
    x, shear = run.wall_shear("y_high", "x", "x", 0.25)
    total = run.wall_force["y_high"][0]
    # A line through the middle stands for the wall only roughly: sign and size.
    assert shear.mean() * 10 * 8 == pytest.approx(-total, rel=0.5)
    assert x.min() >= -5.0
    assert x.max() <= 5.0


def test_preliminary_runs_bring_the_case_near_its_end():
    plain = array()
    plain["time"] |= {"steady_tolerance": 1e-5}
    alone = sp.Simulation.from_file(plain)
    alone.run()
    seen = []
    stages = [{"cells": [6, 6, 6], "thickness": 0.7}, {"cells": [8, 8, 8], "thickness": 0.5}]
    staged = sp.Simulation.from_file(plain | {"start": stages})
    summary = staged.run(lambda running: seen.append(running.grid.shape))
    assert [stage["cells"] for stage in summary["start"]] == [[6, 6, 6], [8, 8, 8]]
    assert [stage["status"] for stage in summary["start"]] == ["steady", "steady"]
    assert list(dict.fromkeys(seen)) == [(6, 6, 6), (8, 8, 8), (12, 12, 12)]
    assert staged.steps < alone.steps
    assert summary["wall_seconds"] >= sum(stage["wall_seconds"] for stage in summary["start"])
    assert summary["max_divergence"] < 1e-12
    # Both stopped at 1e-5 of the speed per unit time, and relax within one unit.
    assert staged.particles[0]["force"] == pytest.approx(alone.particles[0]["force"], rel=1e-3)


def test_interpolation_from_another_grid_leaves_no_divergence():
    coarse = sp.Simulation.from_file(array(time={"end": 1000.0, "max_steps": 10}))
    coarse.run()
    finer = array()
    finer["domain"]["cells"] = [16, 15, 17]
    fine = sp.Simulation.from_file(finer)
    fine.continue_from(coarse)
    assert fine.flow.projection.largest_divergence(fine.state.velocity) < 1e-12
    assert (fine.time, fine.steps) == (0.0, 0)
    # The speed between cells is interpolated in straight lines, with an error of some per cent.
    assert np.abs(fine.velocity).max() == pytest.approx(np.abs(coarse.velocity).max(), rel=0.1)


def moving_case():
    """Walls, stretched cells, advection, a moving and turning body beside a held one."""
    turning = sphere(position=[-2.0, 0.2, 0.1], velocity={"constant": [1.0, 0.5, 0.0]})
    turning |= {"angular_velocity": [0.0, 1.0, 2.0], "name": "turning"}
    case = small_case(turning, sphere(position=[2.0, -1.0, 0.5], name="held"))
    case["domain"] |= {"cells": [20, 17, 13]}
    case["domain"]["stretching"] = ["uniform", {"focus": 0.0, "ratio": 1.5}, "uniform"]
    case["fluid"]["wall_velocity"] = {"y_low": [0.5, 0.0, 0.0]}
    case["profile"] |= {"thickness": 0.6, "retract": "planar"}
    case["time"] = {"end": 10.0, "step": 0.02, "max_steps": 8, "scheme": "bdf2"}
    return case


def test_results_are_the_same_bits_for_any_number_of_threads():
    found = []
    for threads in (1, 2, 3, 1):
        set_thread_count(threads)
        run = sp.Simulation.from_file(moving_case())
        run.run()
        found.append(all_arrays(run))
    assert np.abs(found[0][0]).max() > 0.1
    for other in found[1:]:
        for first, second in zip(found[0], other, strict=True):
            assert first.tobytes() == second.tobytes()


def test_bodies_go_where_their_signals_take_them():
    run = sp.Simulation.from_file(moving_case())
    run.run()
    turning, held = run.particles
    assert (turning["name"], held["name"]) == ("turning", "held")
    t = run.time
    assert turning["position"] == pytest.approx([-2.0 + t, 0.2 + t / 2, 0.1], abs=1e-13)
    assert turning["velocity"] == pytest.approx([1.0, 0.5, 0.0])
    assert turning["angular_velocity"] == pytest.approx([0.0, 1.0, 2.0])
    assert turning["orientation"][0] == pytest.approx(np.cos(np.sqrt(5) * t / 2), abs=1e-12)
    assert held["position"] == pytest.approx([2.0, -1.0, 0.5], abs=0)
    assert run.summary()["bodies"][1]["velocity"] == pytest.approx([0, 0, 0], abs=0)


def test_a_course_from_python_overrules_the_case():
    def sway(t):
        place = np.array([0.0, 0.3 * np.sin(t), 0.0])
        return place, np.array([1.0, 0, 0, 0]), np.array([0, 0.3 * np.cos(t), 0]), np.zeros(3)

    case = small_case(sphere(name="ball"))
    case["profile"] |= {"thickness": 0.9, "retract": False}
    case["time"] = {"end": 1.0, "step": 0.1, "max_steps": 5}
    run = sp.Simulation(sp.load_case(case), {"ball": sway})
    run.run()
    body = run.particles[0]
    assert body["position"] == pytest.approx([0.0, 0.3 * np.sin(run.time), 0.0], abs=1e-15)
    assert body["velocity"][1] == pytest.approx(0.3 * np.cos(run.time), abs=1e-15)
    assert body["force"][1] < 0
    with pytest.raises(CaseError, match=r"courses names 'bal'; the bodies are ball"):
        sp.Simulation(sp.load_case(case), {"bal": sway})


def test_a_run_that_blows_up_names_field_cell_time_and_limit():
    case = array()
    case["fluid"] = {"density": 1.0, "viscosity": 1e-3, "body_force": [50.0, 0.0, 0.0]}
    case["profile"]["retract"] = False
    case["time"] = {"end": 1000.0, "step": 0.2}
    run = sp.Simulation.from_file(case)
    with pytest.raises(BlowUpError) as caught:
        run.run()
    text = str(caught.value)
    for word in ("At time ", "velocity component", "in cell (", "may not exceed 100", "Δt = 0.2"):
        assert word in text
    assert "\n" not in text


def test_single_precision_is_single_throughout():
    case = array(time={"end": 1000.0, "max_steps": 10})
    double = sp.Simulation.from_file(case)
    double.run()
    case["domain"]["precision"] = "single"
    single = sp.Simulation.from_file(case)
    single.run()
    assert {field.dtype for field in (*single.state.velocity, single.state.pressure)} == {
        np.dtype(np.float32)
    }
    # Ten steps of some hundred operations each, at 6e-8.
    assert single.velocity == pytest.approx(double.velocity, abs=2e-5)
    force = double.particles[0]["force"]
    assert single.particles[0]["force"] == pytest.approx(force, abs=1e-4 * force[0])


def test_the_summary_is_plain_and_complete():
    run = sp.Simulation.from_file(array(time={"end": 1000.0, "max_steps": 2}))
    run.run()
    summary = json.loads(to_json(run.summary()))
    assert set(summary) == {
        "status", "steps", "time", "time_step", "wall_seconds", "seconds_per_step", "cells",
        "threads", "bodies", "wall_force", "driving_force", "mean_velocity", "max_divergence",
        "change_rate", "resolution", "start", "volume_fraction", "particle_stress", "numbers",
        "error_card", "retries",
    }  # fmt: skip
    assert summary["cells"] == 12**3
    names = [name for name, value, note in run.table()]
    assert {"status", "time step", "force on sphere", "driving force", "wall-clock"} <= set(names)
    assert all(isinstance(text, str) for row in run.table() for text in row)
    checks = run.preflight()
    assert {"time step", "a/ξ", "ξ/Δx", "√(νΔt)/ξ", "memory (GiB)"} <= {c["name"] for c in checks}
    assert {check["verdict"] for check in checks} <= {"ok", "warn"}
    checks.clear()
    assert run.preflight()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "measure", "expected", "share"),
    [
        # Shares: what is promised of each case as it is built in. The torque is that of a lone
        # sphere, 8π, and .4 % for its images.
        ("channel", lambda run: run.wall_force["total"][0], 0.25, 1e-6),
        ("couette", lambda run: run.wall_force["y_low"][0] / 0.04, 1 / 3, 1e-3),
        ("rotating-sphere", lambda run: run.particles[0]["torque"][2], -25.23, 5e-3),
        ("cylinder-array", lambda run: run.particles[0]["force"][0], 0.82632, 1e-2),
        ("sphere-array", lambda run: run.particles[0]["force"][0], 140.277, 1e-2),
        ("duct", lambda run: run.particles[0]["force"][0], 164.138, 5e-3),
        ("duct", lambda run: -run.wall_force["total"][0], 164.138, 5e-3),
        ("duct-thesis-coarse", lambda run: run.particles[0]["force"][0], 148.1, 2e-3),
        ("duct-thesis-coarse", lambda run: run.particles[0]["interior_velocity"][0], 0.394, 1e-2),
    ],
)
def test_built_in_cases_meet_their_references(finished, name, measure, expected, share):
    assert measure(finished(name)) == pytest.approx(expected, rel=share)


def test_a_surface_moved_far_for_its_body_is_a_warning():
    """A plate of half side .5 whose faces a long step would paint .95 further out."""
    plate = {"shape": "box", "sides": [2.0, 2.0, 1.0], "position": [4.0, 4.0, 4.0]}
    verdicts = []
    for step in (0.03, 1.0):
        changes = {"thickness": 0.25, "lengths": [8.0] * 3, "cells": [8] * 3, "step": step}
        checks = simulation(plate, **changes).preflight()
        verdicts += [check["verdict"] for check in checks if check["name"] == "surface of box"]
    assert verdicts == ["ok", "warn"]
