"""Bodies without inertia: speeds beside theory, order in Δt, balances, and what changes no bit."""

import math
from functools import partialmethod
from itertools import pairwise

import numpy as np
import pytest

from quasistatic_boxes import STILL, ball, box, marched, run_of_box
from restarts import files_digest, run_stopping, state_digest
from smoothprofile.config import load_case
from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.retrying import change_step
from smoothprofile.runs import run_of
from smoothprofile.selfcheck import error_card
from smoothprofile.simulation import Simulation
from smoothprofile.stokes_simulation import StokesSimulation
from smoothprofile.theory.pair_images import image_flow
from smoothprofile.theory.two_spheres import pair_mobility
from smoothprofile.viscous.stokes import RigidStokes

STOKES = 6.0 * math.pi


def hasimoto(side):
    """V/V₀ of a sphere in a periodic cube of `side` radii (J. Fluid Mech. 5, 1959)."""
    return 1.0 - 2.837297 / side + 4.0 * math.pi / (3.0 * side**3) - 27.4 / side**6


def array(**changes):
    side = (4.0 * math.pi / 0.3) ** (1 / 3)
    fluid = {"mean_velocity": {**STILL, "x": 1.0}}
    return run_of_box(ball([0, 0, 0], "held"), side=side, cells=24, fluid=fluid, **changes)


def test_simple_cubic_array_has_the_drag_of_zick_and_homsy_and_takes_one_solve():
    run = marched(array())
    # 7 cells to the radius; .4 % with 24³, and falling with the cells (.1 % with 64³).
    assert run.particles[0]["force"][0] == pytest.approx(3.64245 * STOKES, rel=6e-3)
    assert (run.status, run.steps, len(run.history["time"])) == ("steady", 0, 1)
    # Painted where it is, its layer lets fluid through.
    bare = marched(array(profile={"retract": False}))
    assert abs(bare.particles[0]["force"][0] / STOKES / 3.64245 - 1.0) > 0.01


def test_what_drives_the_fluid_is_what_bodies_take():
    run = marched(array())
    volume = math.prod(run.grid.lengths)
    # f = G on the mean, to the residual of the solve.
    assert run.driving_force * volume == pytest.approx(run.particles[0]["force"], abs=1e-4)
    assert run.mean_velocity == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)


def test_lone_sphere_settles_by_its_weight_in_the_fluid():
    gravity = {"gravity": [0.0, 0.0, -3.0]}
    run = run_of_box(ball([1.1, 2.3, 3.2], density=3.0), fluid=gravity)
    run.step_once()
    speed = (3.0 - 1.0) * 4.0 / 3.0 * math.pi * 3.0 / STOKES * hasimoto(8.0)
    # Four cells to the radius: .5 %.
    assert run.particles[0]["velocity"][2] == pytest.approx(-speed, rel=5e-3)
    assert run.particles[0]["force"][2] == pytest.approx(8.0 * math.pi, rel=1e-9)


@pytest.mark.parametrize("opposite", [False, True])
def test_pair_moves_along_its_line_as_theory_says(opposite):
    side, apart = 16.0, 4.0
    pulls = [1.0, -1.0 if opposite else 1.0]
    places = ([8.0, 8.0, 8.0 - 0.5 * apart], [8.0, 8.0, 8.0 + 0.5 * apart])
    bodies = [ball(x, force=[0.0, 0.0, f * STOKES]) for x, f in zip(places, pulls, strict=True)]
    run = run_of_box(*bodies, side=side, cells=64, fluid={"tolerance": 1e-5})
    run.step_once()
    sign = -1.0 if opposite else 1.0
    images = STOKES * (image_flow(0.0, side) + sign * image_flow(apart, side))
    expected = pair_mobility(apart, opposite=opposite) + images
    found = run.particles[0]["velocity"][2]
    # Of the images only their forces count: (a/L)³ ~ 3e-4 is left out, four times over.
    assert found == pytest.approx(expected, rel=6e-3)


def test_free_sphere_turns_by_its_torque_and_its_attitude_is_the_exact_rotation():
    torque, end = 8.0 * math.pi, 1.5
    body = ball([4.0, 4.0, 4.0], torque=[0.0, torque, 0.0])
    run = marched(run_of_box(body, time={"end": end, "step": 0.5}))
    # In a periodic cube the mean vorticity is zero, which takes off the volume fraction.
    rate = 1.0 - 4.0 / 3.0 * math.pi / 8.0**3
    row = run.particles[0]
    assert row["angular_velocity"][1] == pytest.approx(rate, rel=5e-3)
    half = 0.5 * row["angular_velocity"][1] * end
    # The place hardly moves, so that Ω is the same to the tolerance of the solve.
    assert row["orientation"] == pytest.approx([math.cos(half), 0, math.sin(half), 0], abs=1e-5)


def trio(step, **time):
    """Three spheres that settle around one another."""
    places = ([2.1, 3.5, 3.5], [4.9, 3.7, 4.4], [3.7, 6.0, 1.8])
    bodies = [ball(x, density=d) for x, d in zip(places, (2.0, 2.5, 3.0), strict=True)]
    changes = {"fluid": {"gravity": [0.0, 0.0, -4.5], "tolerance": 1e-10}}
    return run_of_box(
        *bodies, side=7.0, cells=24, time={"end": 0.8, "step": step, **time}, **changes,
        contact={"range": 0.05},
    )  # fmt: skip


def test_march_is_of_second_order_in_the_step():
    places = [marched(trio(step)).bodies.state.position.copy() for step in (0.2, 0.1, 0.05)]
    coarse, fine = (np.linalg.norm(a - b) for a, b in pairwise(places))
    # The first step is of first order, which is one error of second order at the end.
    assert 1.7 < math.log2(coarse / fine) < 2.4


@pytest.mark.slow
def test_one_level_alone_is_of_first_order(monkeypatch):
    def euler(self, dt):
        return [(now.copy(), np.zeros_like(now)) for now in self.own]

    monkeypatch.setattr("smoothprofile.particles.creeping.CreepingBodies._courses", euler)
    places = [marched(trio(step)).bodies.state.position.copy() for step in (0.2, 0.1, 0.05)]
    coarse, fine = (np.linalg.norm(a - b) for a, b in pairwise(places))
    assert math.log2(coarse / fine) < 1.4


def between_walls(**changes):
    """Two spheres, one held, in a sheared and driven slit, in a field that turns."""
    bodies = (
        ball([2.6, 3.0, 1.25], permittivity=5.0),
        ball([5.0, 3.0, 1.9], permittivity=5.0),
        ball([7.6, 2.8, 3.1], "held", permittivity=5.0),
    )
    fluid = {
        "gravity": [0.0, 0.0, -2.0],
        "body_force": [0.3, 0.0, 0.0],
        "wall_velocity": {"z_high": {"constant": [0.5, 0, 0], "amplitude": [0.2, 0, 0],
                                     "angular_frequency": 3.0}},
        "tolerance": 1e-6,
    }  # fmt: skip
    electric = {"field": [1.0, 0, 0], "quadrature": [0, 1.0, 0], "angular_frequency": 2.0}
    case = box(
        *bodies, side=[10.0, 6.0, 5.0], cells=[40, 24, 20],
        boundaries=("periodic", "periodic", "wall"), fluid=fluid, electric=electric,
        contact={"friction": 0.3, "lubrication": True},
        time={"end": 0.5, "step": 0.1}, output={"every": 2, "fields_every": 0.2},
    )  # fmt: skip
    for table, values in changes.items():
        case[table] = {**case[table], **values}
    return case


def test_forces_of_bodies_walls_and_drive_balance():
    run = marched(run_of(load_case(between_walls())))
    by_name = {line["name"]: line for line in run.summary()["error_card"]}
    # The walls' shear is read off the flow, right to the tolerance of the solve, 1e-6.
    assert by_name["momentum"]["value"] < 1e-5
    assert by_name["divergence"]["value"] < 1e-12
    free = run.bodies.free
    given = free.constant + free.pulls[0] + run.bodies._contact()
    # What the fluid gives a free body undoes its loads, to round-off.
    assert run.bodies.state.force[free.rows] == pytest.approx(-given[:, :3], abs=1e-9)
    assert run.bodies.state.torque[free.rows] == pytest.approx(-given[:, 3:], abs=1e-9)
    assert run.summary()["apparent_viscosity"] > 1.0


def test_walls_bear_a_body_force_that_ends_in_them():
    between = ("periodic", "periodic", "wall")
    fluid = {"body_force": [0.0, 0.0, -2.0]}
    run = marched(run_of_box(ball([4, 4, 3], "held"), boundaries=between, cells=32, fluid=fluid))
    assert run.wall_force["total"] == pytest.approx([0.0, 0.0, -2.0 * 512.0], abs=1e-9)
    z = run.grid.axes[2].centres
    assert np.ptp(run.pressure + 2.0 * (z - 4.0)) < 1e-12
    assert error_card(run)[2]["name"] == "momentum"
    assert error_card(run)[2]["value"] < 1e-12


def test_stress_on_sliding_walls_is_that_of_fluid_contact_and_field():
    """The balance of moments that `wall_stress.py` states, without any inertia left out."""
    walls = {"z_low": [-0.5, 0.0, 0.0], "z_high": [0.5, 0.0, 0.0]}
    fluid = {"wall_velocity": walls, "gravity": [0, 0, 0], "body_force": [0, 0, 0]}
    case = between_walls(fluid=fluid, time={"end": 0.2}, contact={"range": 0.4})
    case["particles"] = [{**body, "motion": "free", "density": 1.0} for body in case["particles"]]
    history = marched(run_of(load_case(case))).history
    parts = [history[f"{name}_stress"][-1] for name in ("viscous", "contact", "electric")]
    assert min(map(abs, parts)) > 1e-5
    # The walls' shear is right to the tolerance of the solve, 1e-6 of the speeds.
    assert history["wall_stress"][-1] == pytest.approx(sum(parts), abs=1e-6)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A run that was not stopped: what it held at its end, and its files."""
    path = tmp_path_factory.mktemp("whole") / "run"
    return state_digest(run_stopping(between_walls(), path)), files_digest(path)


def test_a_run_that_is_stopped_ends_with_the_bits_of_one_that_is_not(whole, tmp_path):
    parts = run_stopping(between_walls(), tmp_path / "parts", (1, 3), threads=(1, 2))
    assert (state_digest(parts), files_digest(tmp_path / "parts")) == whole


@pytest.mark.slow
def test_a_cold_start_would_show_in_the_bits(whole, tmp_path, monkeypatch):
    name = "smoothprofile.quasistatic.RigidStokes.recall"
    monkeypatch.setattr(name, lambda self, velocity, last: None)
    cold = run_stopping(between_walls(), tmp_path / "cold", (4,))
    assert state_digest(cold) != whole[0]


def test_a_field_that_bodies_do_not_feel_changes_no_bit():
    places = ([2.1, 3.5, 3.5], [4.9, 3.7, 4.4])
    changes = {"side": 7.0, "cells": 24, "time": {"end": 0.4, "step": 0.2}}
    plain = marched(run_of_box(*(ball(x, force=[3.0, 0, 1.0]) for x in places), **changes))
    # Of the fluid's own permittivity.
    seen = [ball(x, force=[3.0, 0, 1.0], permittivity=1.0) for x in places]
    dark = marched(run_of_box(*seen, electric={"field": [0.0, 0.0, 2.0]}, **changes))
    assert np.abs(dark.bodies.free.pulls[0]).max() == 0.0
    assert np.array_equal(plain.bodies.state.position, dark.bodies.state.position)
    assert np.array_equal(plain.velocity, dark.velocity)


def test_prescribed_bodies_go_where_they_are_sent_and_others_are_carried():
    sent = ball([2.0, 4.0, 4.0], "prescribed", velocity=[1.0, 0.0, 0.0])
    run = marched(run_of_box(sent, ball([5.0, 4.0, 4.0]), time={"end": 0.5, "step": 0.1}))
    first, second = run.particles
    assert first["position"] == pytest.approx([2.5, 4.0, 4.0], abs=1e-12)
    assert first["force"][0] < -STOKES
    assert 0.2 < second["velocity"][0] < 1.0
    assert second["force"] == pytest.approx([0, 0, 0], abs=1e-9)


def test_a_solve_that_does_not_converge_is_told_with_its_status(monkeypatch):
    short = partialmethod(RigidStokes.solve, limit=2)
    monkeypatch.setattr(RigidStokes, "solve", short)
    sentence = "the flow did not converge at t = 0: iteration limit after 2 iterations"
    with pytest.raises(BlowUpError, match=sentence):
        array().run()


def test_each_kind_of_run_refuses_the_cases_of_the_other():
    with pytest.raises(CaseError, match="StokesSimulation"):
        Simulation(array().case)
    with pytest.raises(CaseError, match="for Simulation"):
        StokesSimulation.from_file("sphere-array")


def test_a_smaller_step_goes_on_from_where_the_run_is():
    run = trio(0.2)
    for _ in range(3):
        run.step_once()
    change_step(run, 0.1, "tried")
    run.run()
    assert run.time == pytest.approx(0.8, abs=1e-12)
    # Δt = .2 throughout is 6e-4 off that of .1; Euler's rule 2e-2.
    fine = marched(trio(0.1)).bodies.state.position
    assert np.linalg.norm(run.bodies.state.position - fine) < 2e-3
    assert "Δt" in {line["name"] for line in run.summary()["error_card"]}


def test_weights_of_the_rule_are_exact_for_a_speed_that_grows_evenly():
    bodies = trio(0.2).bodies
    bodies.own, bodies.before = ((np.full((3, 3), v), np.zeros((3, 3))) for v in (1.0, 0.8))
    bodies.step = 0.2
    (mean, rate), _ = bodies._courses(0.1)
    assert mean == pytest.approx(1.05, rel=1e-14)
    assert rate == pytest.approx(1.0, rel=1e-14)


def test_direct_forcing_comes_to_the_same_speeds_where_re_is_small():
    """Two spheres, side by side, that settle; Re = .02, run until the fluid has come along."""
    bodies = [ball([x, 3.5, 3.5]) for x in (2.0, 4.7)]
    gravity = {"gravity": [0.0, 0.0, -0.6], "density": 1.0, "viscosity": 2.0}
    still = run_of_box(*bodies, side=7.0, cells=28, fluid=gravity)
    still.step_once()
    case = box(*bodies, side=7.0, cells=28, fluid=gravity)
    del case["fluid"]["flow"], case["fluid"]["tolerance"]
    case["profile"] = {"thickness": 0.35}
    # Viscosity takes (7/2π)²/ν = .6 across the box; by then the bodies have moved by .02.
    case["time"] = {"step": 0.05, "end": 5.0, "max_steps": 60}
    moving = Simulation(load_case(case))
    moving.run()
    creeping, inertial = (run.bodies.state.velocity for run in (still, moving))
    # Direct forcing holds a lone sphere's drag to .3 %, that of a pair at a gap of .7a to 2 %.
    assert inertial[:, 2] == pytest.approx(creeping[:, 2], rel=0.02)
