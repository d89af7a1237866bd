"""The table that a run ends with."""

import pytest

import smoothprofile as sp
from case_makers import small_case, sphere
from smoothprofile.running import _warning
from smoothprofile.runs import run_of
from smoothprofile.tables import _of_body, result_table


def table_of(case):
    run = sp.Simulation(sp.load_case(case))
    run.run()
    return {name: (value, note) for name, value, note in result_table(run)}


def short(*particles, **tables):
    case = small_case(*particles, boundaries=("periodic",) * 3)
    case["time"] = case["time"] | {"max_steps": 1}
    return case | tables


def test_a_free_body_is_told_with_its_spin_and_whose_force_it_feels():
    table = table_of(short(sphere(motion="free", density=2.0, angular_velocity=[0.0, 0.0, 0.5])))
    (name,) = (row.removeprefix("spin of ") for row in table if row.startswith("spin of "))
    spin = [float(value) for value in table[f"spin of {name}"][0].strip("()").split(",")]
    # The fluid slows it down a little in a step.
    assert 0.3 < spin[2] <= 0.5
    assert table[f"force on {name}"][1] == "of the fluid"
    held = table_of(short(sphere()))
    assert not any(row.startswith("spin of") for row in held)


@pytest.mark.parametrize(("offset", "where"), [(-0.414, "inside"), (0.414, "outside")])
def test_a_surface_is_told_to_be_painted_inside_or_outside(offset, where):
    body = sp.Simulation(sp.load_case(short(sphere()))).particles[0]
    rows = _of_body(body | {"painted_offset": offset}, False, lambda _, v: str(v), True)
    assert ("surface of sphere", "0.414", f"painted this far {where}") in rows


def test_slip_in_a_layer_without_inertia_is_not_called_an_error():
    fluid = {"density": 1, "viscosity": 1, "flow": "stokes", "body_force": [1, 0, 0]}
    run = run_of(sp.load_case(short(sphere(), fluid=fluid)))
    run.run()
    (note,) = (note for name, _, note in run.table() if name.startswith("slip inside"))
    assert "of the layer" in note and "exact" not in note
    assert table_of(short(sphere()))["slip inside sphere"][1].endswith("0 is exact")


@pytest.mark.parametrize(("first", "told"), [(9.0, True), (1.0, False)])
def test_a_first_step_that_is_most_of_the_time_is_told(first, told):
    run = sp.Simulation(sp.load_case(short(sphere(), time={"end": 1, "max_steps": 5})))
    run.run()
    run.wall_seconds, run._first_seconds = first + 4.0, first
    (note,) = (note for name, _, note in result_table(run) if name == "wall-clock")
    assert ("of which the first step, with compiling, 9 s" in note) == told


def test_walls_are_told_of_where_there_are_some():
    case = short(sphere())
    assert "force on the walls" not in table_of(case)
    case["domain"] = case["domain"] | {"boundaries": ["periodic", "wall", "periodic"]}
    assert "force on the walls" in table_of(case)


@pytest.mark.parametrize(
    ("units", "told"),
    [
        ({"length": "10 um", "time": "1 ms", "mass": "1 ng"}, "10 um, 1 ms, 1 ng"),
        ({"length": "10 um", "density": "1 g/cm^3"}, "10 um, 1 s, 1 g/cm^3"),
        ({}, "1 m, 1 s, 1 kg"),
    ],
)
def test_the_units_of_the_numbers_are_told(units, told):
    table = table_of(short(sphere(), units=units))
    assert table["units"][0] == told
    assert table["units"][1].startswith("length, time, ")
    assert "√ε₀" not in table["units"][1]
    assert "units" not in table_of(short(sphere()))


@pytest.mark.parametrize(
    ("limit", "told"),
    [
        (float("inf"), "Note: time step is 0.4: a remark."),
        (None, "Note: time step is 0.4: a remark."),
        (0.25, "Note: time step is 0.4, against 0.25: a remark."),
    ],
)
def test_a_warning_has_a_limit_beside_it_where_there_is_one(limit, told):
    row = {"name": "time step", "value": 0.4, "limit": limit, "verdict": "warn", "note": "a remark"}
    assert _warning(row) == told


def test_micrometres_in_metres_are_no_round_off():
    """A bead of .04 pN, in units where forces are 1e-14."""
    case = {
        "domain": {"lengths": [8e-6] * 3, "cells": [12] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {
            "density": 1e3,
            "viscosity": 1e-3,
            "gravity": [0.0, 0.0, -9.81],
            "mean_velocity": {"x": 0.0, "y": 0.0, "z": 0.0},
        },
        "profile": {"thickness": 8e-7},
        "particles": [
            {"shape": "sphere", "radius": 2e-6, "position": [4e-6] * 3, "motion": "free"}
            | {"density": 2e3}
        ],
        "time": {"end": 1e-5, "step": 1e-6},
    }
    table = table_of(case)
    force = table["force on sphere"][0].strip("()").split(", ")
    assert force[:2] == ["0", "0"] and 0.0 < float(force[2]) < 1e-12
    assert table["torque on sphere"][0] == "(0, 0, 0)"
