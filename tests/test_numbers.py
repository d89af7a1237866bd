"""Dimensionless numbers: what a case amounts to, and cases that are given by them."""

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import smoothprofile as sp
from case_makers import refusal
from smoothprofile.cli import app
from smoothprofile.config import load_case
from smoothprofile.numbers import number_rows, numbers_of

BETA = 0.75  # of R = 10


def shear_cell(**fluid):
    """A bead of radius 2 in a cell 16 high whose walls slide at ±4 along x: γ̇ = .5, E = 3."""
    return {
        "domain": {
            "lengths": [16, 16, 16],
            "cells": [16, 16, 16],
            "boundaries": ["periodic", "periodic", "wall"],
        },
        "fluid": {
            "density": 0.2,
            "viscosity": 5.0,
            "wall_velocity": {"z_low": [-4, 0, 0], "z_high": [4, 0, 0]},
            **fluid,
        },
        "electric": {"electrodes": {"axis": "z", "low": 10, "high": 58}, "permittivity": 2.0},
        "profile": {"thickness": 0.5},
        "particles": [
            {
                "shape": "sphere",
                "radius": 2.0,
                "position": [8, 8, 8],
                "motion": "free",
                "density": 0.6,
                "permittivity": 20.0,
            }
        ],
        "time": {"end": 10.0, "step": 0.01},
    }


def without(case, *keys):
    """The case less some dotted keys."""
    case = json.loads(json.dumps(case))
    for key in keys:
        *tables, last = key.split(".")
        place = case
        for table in tables:
            place = place[int(table) if table.isdigit() else table]
        del place[last]
    return case


KNOWN = {
    # ρ γ̇ a²/μ = .2 · .5 · 4/5, and μγ̇/(2 ε β² E²) = 2.5/(2 · 2 · .5625 · 9).
    "Re": 0.08,
    "Mn": 2.5 / 20.25,
    "R": 10.0,
    "volume_fraction": 4 / 3 * math.pi * 8 / 4096,
    "contrast": BETA,
    "density_ratio": 3.0,
    "St": 2 / 9 * 3 * 0.08,
    # t ε E²/μ = 10 · 2 · 9/5.
    "electric_times": 36.0,
    "layer": 4.0,
}


def test_numbers_of_a_shear_cell_by_hand():
    assert numbers_of(load_case(shear_cell())) == pytest.approx(KNOWN, rel=1e-14)


def test_alternating_fields_count_by_their_mean_square():
    case = without(shear_cell(), "electric.electrodes", "fluid.wall_velocity")
    case["domain"]["boundaries"] = ["periodic"] * 3
    case["electric"] |= {"field": [3, 0, 0], "angular_frequency": 1.0}
    assert numbers_of(load_case(case))["electric_times"] == pytest.approx(18.0, rel=1e-14)
    case["electric"] |= {"quadrature": [0, 3, 0]}
    found = numbers_of(load_case(case))
    # A field of one size that turns has its full mean square, and ε E² a/μ = 7.2 is the speed.
    assert found["electric_times"] == pytest.approx(36.0, rel=1e-14)
    assert found["Re"] == pytest.approx(0.2 * 7.2 * 2 / 5, rel=1e-14)
    # A run replaces that speed by its bodies' own.
    assert numbers_of(load_case(case), 1.0)["Re"] == pytest.approx(0.08, rel=1e-14)


@pytest.mark.parametrize("name", ["duct", "settling-sphere", "dielectric-lattice", "channel"])
def test_any_case_has_its_numbers(name):
    case = load_case(name)
    found, rows = numbers_of(case), number_rows(case)
    assert len(rows) == len(found) and all(math.isfinite(value) for value in found.values())
    assert "Mn" not in found
    if name == "duct":
        # Re = 10 by diameter.
        assert found["Re"] == pytest.approx(5.0, rel=1e-14)


@pytest.mark.parametrize(
    ("left_out", "numbers"),
    [
        (["fluid.viscosity"], {"Mn": 0.5}),
        (["fluid.viscosity"], {"Re": 0.5}),
        (["fluid.density"], {"Re": 0.5}),
        (["fluid.viscosity", "fluid.density"], {"Mn": 0.5, "Re": 0.01}),
        (["fluid.wall_velocity"], {"Mn": 0.5}),
        (["fluid.wall_velocity"], {"Re": 0.5}),
        (["fluid.wall_velocity", "fluid.viscosity"], {"Re": 0.5, "Mn": 0.02}),
        (["fluid.wall_velocity", "fluid.density"], {"Re": 0.5, "Mn": 0.02}),
        (["electric.electrodes"], {"Mn": 0.5}),
        (["electric.electrodes.high"], {"Mn": 0.5}),
        (["electric.electrodes", "fluid.density"], {"Mn": 0.5, "Re": 0.3}),
        (["particles.0.permittivity"], {"R": 4.0}),
        (["particles.0.density", "fluid.density"], {"density_ratio": 1.0, "Re": 0.1}),
        ([], {"Re": 0.08, "Mn": 2.5 / 20.25, "R": 10.0, "density_ratio": 3.0}),
        ([], {"volume_fraction": 0.00818}),
    ],
)
def test_what_is_left_out_follows_from_the_numbers(left_out, numbers):
    case = load_case({**without(shear_cell(), *left_out), "numbers": numbers})
    found = numbers_of(case)
    for name, value in numbers.items():
        # Of volume fractions only whole numbers of bodies are possible.
        near = 1e-3 if name == "volume_fraction" else 1e-12
        assert found[name] == pytest.approx(value, rel=near), name
    # What was given stays as it is.
    given = load_case(shear_cell())
    for key in ("density", "viscosity"):
        if f"fluid.{key}" not in left_out:
            assert getattr(case.fluid, key) == getattr(given.fluid, key)
    if "fluid.wall_velocity" not in left_out:
        assert case.fluid.wall_velocity == given.fluid.wall_velocity
    assert load_case(case) == case


@pytest.mark.parametrize("left_out", ["viscosity", "density"])
@pytest.mark.parametrize("asked", [0.05, 3.0, 200.0])
def test_the_reynolds_number_of_a_body_that_settles_may_be_given(left_out, asked):
    case = {
        "domain": {"lengths": [8.0] * 3, "cells": [16] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {"density": 2.0, "viscosity": 3.0, "gravity": [0, 0, -1.5]},
        "profile": {"kind": "tanh", "thickness": 0.5},
        "particles": [{"shape": "sphere", "radius": 1.5, "position": [4, 4, 4], "motion": "free"}],
        "time": {"step": 1e-3, "end": 1.0},
    }
    del case["fluid"][left_out]
    case["numbers"] = {"Re": asked, "density_ratio": 2.5}
    found = load_case(case)
    rho, mu, volume = found.fluid.density, found.fluid.viscosity, 4.5 * math.pi
    # By hand: Stokes' speed, or Newton's if that is less.
    weight = 1.5 * rho * volume * 1.5
    stokes = weight / (6 * math.pi * mu * 1.5)
    newton = math.sqrt(weight / (0.22 * math.pi * rho * 1.5**2))
    assert rho * min(stokes, newton) * 1.5 / mu == pytest.approx(asked, rel=1e-12)
    # Which way it falls does not matter.
    tilted = {**case, "fluid": {**case["fluid"], "gravity": [0.9, 0.0, -1.2]}}
    assert getattr(load_case(tilted).fluid, left_out) == pytest.approx(
        getattr(found.fluid, left_out), rel=1e-12
    )


def test_the_reynolds_number_of_a_body_force_between_walls_may_be_given():
    case = {
        "domain": {
            "lengths": [8.0] * 3,
            "cells": [16] * 3,
            "boundaries": ["periodic", "periodic", "wall"],
        },
        "fluid": {"density": 2.0, "body_force": [0.3, 0, 0]},
        "time": {"step": 1e-3, "end": 1.0},
        "numbers": {"Re": 0.7},
    }
    mu = load_case(case).fluid.viscosity
    # U = gL²/(8μ), by the distance of the walls.
    assert 2.0 * (0.3 * 64 / (8 * mu)) * 8 / mu == pytest.approx(0.7, rel=1e-12)


def test_a_rate_becomes_two_walls_that_slide_apart():
    case = load_case({**without(shear_cell(), "fluid.wall_velocity"), "numbers": {"Re": 0.16}})
    low, high = (case.fluid.wall_velocity.given()[side].constant for side in ("z_low", "z_high"))
    # γ̇ = 1 over a height of 16.
    assert low == pytest.approx((-8.0, 0.0, 0.0))
    assert high == pytest.approx((8.0, 0.0, 0.0))


def test_a_random_suspension_from_numbers_and_units():
    case = shear_cell()
    case["domain"]["lengths"] = ["160 um"] * 3
    case["profile"]["thickness"] = "5 um"
    case["electric"] = {"field": [0, 0, 0], "permittivity": 2.0}
    case["electric"] = {"electrodes": {"axis": "z", "high": "160 V"}, "permittivity": 2.0}
    case["particles"] = [
        {"shape": "sphere", "radius": "10 um", "motion": "free", "random": {"seed": 1}}
    ]
    case["fluid"] = {"density": "1 g/cm^3"}
    case["time"] = {"end": "1 s"}
    case["numbers"] = {"Re": 1e-4, "Mn": 0.01, "R": 10, "volume_fraction": 0.1, "density_ratio": 1}
    loaded = load_case(case)
    found = numbers_of(loaded)
    assert {key: found[key] for key in ("Re", "Mn", "R")} == pytest.approx(
        {"Re": 1e-4, "Mn": 0.01, "R": 10}, rel=1e-12
    )
    # 98 beads of 97.78.
    assert len(loaded.particles) == 98
    # μγ̇ = .01 · 2 ε₀ ε β² E² and ρ γ̇ a² = 1e-4 μ give μ² = 1e-2 · 1e4 · 2ε₀ · 2 · .5625 · E² ρ a².
    stress = 0.02 * 8.8541878188e-12 * 2 * BETA**2 * 1e12
    assert loaded.fluid.viscosity == pytest.approx(
        math.sqrt(stress * 1000 * 1e-10 / 1e-4), rel=1e-9
    )


@pytest.mark.parametrize(
    ("left_out", "numbers", "sentence"),
    [
        (
            [],
            {"Mn": 0.2},
            "numbers.Mn is 0.2; electric.electrodes.high, fluid.viscosity, permittivities and the "
            "rate of shear of the case make it 0.1234568.",
        ),
        ([], {"Re": 0.08 * (1 + 3e-6)}, "numbers.Re is "),
        ([], {"R": 9.0}, "numbers.R is 9.0; the permittivities of the case make it 10."),
        ([], {"volume_fraction": 0.1}, "the bodies and the box of the case make it 0.0081"),
        ([], {"density_ratio": 1.0}, "the densities of the case make it 3."),
        (
            ["fluid.viscosity"],
            {"Re": 0.1, "Mn": 0.1},
            "fluid.viscosity, speeds and radii of the case make it",
        ),
        (
            ["fluid.viscosity", "fluid.density"],
            {"Mn": 0.1},
            "fluid.density is missing; numbers.Mn cannot give fluid.density and fluid.viscosity",
        ),
        ([], {"Mn": -1.0}, "numbers.Mn is -1.0; it must be a finite number above 0."),
        ([], {"mn": 1.0}, "numbers.mn is not a known key"),
        ([], {"R": 1e10}, "numbers.R is 10000000000.0; it must be a number from 1e-09 to 1e+09."),
        (["electric", "particles.0.permittivity"], {"Mn": 1.0}, "numbers.Mn is 1.0; it needs"),
        (["electric", "particles.0.permittivity"], {"R": 1.0}, "numbers.R is 1.0; the case has"),
        (
            ["particles.0.permittivity", "fluid.viscosity"],
            {"R": 1.0, "Mn": 1.0},
            "numbers.Mn is 1.0; it needs a field, bodies with R other than 1",
        ),
    ],
)
def test_numbers_that_contradict_the_case_are_refused(left_out, numbers, sentence):
    text = refusal({**without(shear_cell(), *left_out), "numbers": numbers})
    assert sentence in text


@pytest.mark.parametrize("value", [-2.0, 0.0])
@pytest.mark.parametrize(
    ("key", "name", "left_out"),
    [("electric.permittivity", "R", "permittivity"), ("fluid.density", "density_ratio", "density")],
)
def test_what_bodies_take_a_multiple_of_is_named_if_it_is_wrong(key, name, left_out, value):
    """Of a lattice too, whose bodies are read before the rest of the case."""
    case = without(shear_cell(), f"particles.0.{left_out}")
    packed = without(case, "particles.0.position")
    packed["particles"][0]["lattice"] = {"kind": "simple-cubic", "counts": [2, 2, 2]}
    for each in (case, packed):
        text = refusal({**each, "numbers": {name: 8.0}}, {key: value})
        assert text == f"{key} is {value}; it must be a finite number above 0."


def test_agreement_is_asked_to_a_part_in_a_million():
    load_case({**shear_cell(), "numbers": {"Re": 0.08 * (1 + 0.9e-6)}})
    assert "make it 0.08" in refusal({**shear_cell(), "numbers": {"Re": 0.08 * (1 + 1.1e-6)}})


def test_a_frequency_that_the_step_cannot_resolve_is_refused():
    case = shear_cell()
    case["electric"]["angular_frequency"] = 1.01 * 2 * math.pi / 16 / 0.01
    with pytest.raises(sp.CaseError, match=r"electric.angular_frequency is 39.6626; a field"):
        sp.Simulation.from_file(case)
    case["electric"]["angular_frequency"] *= 0.98
    rows = {row["name"]: row for row in sp.Simulation.from_file(case).preflight()}
    assert rows["step, turning field"]["verdict"] == "ok"
    # Held for two steps, it is solved for half as often.
    with pytest.raises(sp.CaseError, match=r"solved for every 2 steps needs a time.step of 0.005"):
        sp.Simulation.from_file(case, {"electric.every": 2})
    case["time"]["step"] = "auto"
    assert sp.Simulation.from_file(case).time_step < 0.01 / 0.98


def test_check_and_summary_tell_the_numbers(tmp_path):
    found = CliRunner().invoke(app, ["check", "sphere-in-shear", "--json"])
    assert json.loads(found.stdout)["numbers"]["Re"] == pytest.approx(0.1)
    case = shear_cell()
    case["time"]["max_steps"] = 1
    run = sp.Simulation.from_file(case)
    run.run()
    assert run.summary()["numbers"] == pytest.approx(KNOWN)
    rows = {name: value for name, value, _ in run.table()}
    assert rows["Mn"] == "0.123457"
    assert np.isclose(float(rows["β"]), BETA)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"particles": 3}, "particles is 3; it must be a list of tables"),
        ({"particles": [3]}, "particles.0 is 3; it must be a table"),
        ({"electric": 3}, "electric is 3; it must be a table"),
        ({"fluid": 3}, "fluid is 3; it must be a table"),
        ({"domain": 3}, "domain is 3; it must be a table"),
        ({"numbers": 3}, "numbers is 3; it must be a table"),
        ({"electric": {"electrodes": {"axis": "z", "low": "a"}}}, "electric.electrodes"),
        ({"electric": {"electrodes": {"axis": ["z"]}}}, "electric.electrodes.axis"),
        ({"electric": {"electrodes": {"axis": "z", "high": 1}, "permittivity": "a"}}, "permitt"),
        ({"fluid": {"density": "a"}}, 'fluid.density is "a"; it must be a finite number above 0.'),
    ],
)
def test_cases_that_are_no_cases_are_refused_with_numbers_too(changes, sentence):
    numbers = {"Re": 1.0, "Mn": 1.0, "R": 4.0, "density_ratio": 1.0, "volume_fraction": 0.1}
    assert sentence in refusal({**shear_cell(), "numbers": numbers, **changes})
