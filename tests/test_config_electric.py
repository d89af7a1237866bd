"""[electric] of a case: what it fills in, and what it refuses."""

import pytest

import smoothprofile as sp
from case_makers import refusal, small_case
from smoothprofile.config import load_case


def field_case(**changes):
    """A bead in a periodic box with a field along z."""
    bead = {"shape": "sphere", "radius": 1.0, "position": [0, 0, 0], "permittivity": 10.0}
    case = {
        "domain": {
            "lengths": [8, 8, 8],
            "cells": [32, 32, 32],
            "origin": [-4, -4, -4],
            "boundaries": ["periodic"] * 3,
        },
        "electric": {"field": [0, 0, 1]},
        "particles": [bead],
    }
    return {**case, **changes}


def test_a_field_alone_needs_no_fluid_and_no_time():
    case = load_case(field_case())
    assert case.fluid is None
    assert case.time is None
    assert case.output.fields == ("indicator", "potential", "electric_field")


def test_a_case_written_out_loads_as_an_equal_one(tmp_path):
    case = load_case(field_case())
    path = tmp_path / "again.toml"
    path.write_text(case.to_toml(), encoding="utf-8")
    assert load_case(path) == case


def test_defaults_follow_the_discretisation():
    plain = load_case(field_case()).electric
    assert (plain.smoothing, plain.retract, plain.method) == ("tensor", True, "conjugate-gradients")
    spectral = load_case(field_case(), ["electric.discretisation=fourier"]).electric
    assert (spectral.smoothing, spectral.retract) == ("arithmetic", False)


ELECTRODES = "electric.electrodes={axis='z', low=0, high=1}"
WALLED = "domain.boundaries=['periodic','periodic','wall']"


@pytest.mark.parametrize(
    ("overrides", "words"),
    [
        (["electric.field=[0,0,0]"], "electric.field is [0.0, 0.0, 0.0]; a case needs a field"),
        (["electric.field=[0,0]"], "electric.field is [0, 0]; it must be three finite numbers"),
        (["electric.field=[0,0,nan]"], "it must be three finite numbers"),
        ([ELECTRODES], "the electrodes already set the field along z"),
        (
            ["electric.field=[0,0,0]", ELECTRODES],
            'electric.electrodes.axis is "z"; electrodes need an axis with walls',
        ),
        ([WALLED], "the walls of z let no flux through"),
        (
            [WALLED, "electric.field=[0,0,0]", "electric.electrodes={axis='z',low=1,high=1}"],
            "electric.electrodes.high is 1.0; the electrodes need different potentials",
        ),
        (["electric.permittivity=0"], "electric.permittivity is 0; it must be a finite number"),
        (["particles.0.permittivity=-2"], "particles.0.permittivity is -2; it must be"),
        (["electric.thickness=1.5"], "it may not exceed 1, the smallest radius"),
        (["electric.method=fixed-point"], 'it is a method of discretisation = "fourier"'),
        (
            ["electric.discretisation=fourier", "electric.smoothing=tensor"],
            'electric.smoothing is "tensor"; discretisation = "fourier" takes "arithmetic" alone',
        ),
        (
            ["electric.discretisation=fourier", "electric.retract=true"],
            "electric.retract is true",
        ),
        (
            [
                "electric.discretisation=fourier",
                WALLED,
                "electric.field=[1,0,0]",
            ],
            'electric.discretisation is "fourier"; it needs three periodic axes',
        ),
        (["electric.smoothing=wrong"], 'electric.smoothing is "wrong"; it must be "tensor"'),
        (["electric.profile=wrong"], 'electric.profile is "wrong"; it must be one of'),
        (["electric.tolerance=0"], "electric.tolerance is 0; it must be a number from 1e-14"),
        (["electric.feld=[1,0,0]"], "electric.feld is not a known key; the nearest is"),
        (["domain.precision=single"], 'a case with [electric] needs "double"'),
        (["profile.thickness=0.3"], "a case without [fluid] has no profile"),
        (["time.end=1"], "a case without [fluid] has no time"),
        (["output.fields=['pressure']"], "a case without [fluid] has no pressure"),
        (["particles.0.velocity=[1,0,0]"], 'bodies of a case without [fluid] are "held"'),
        (["particles.0.position=[3.5,0,0]", "particles.0.radius=4.2"], "overlaps"),
    ],
)
def test_refusals(overrides, words):
    assert words in refusal(field_case(), overrides)


def test_a_bead_without_permittivity_is_refused():
    bead = {"shape": "sphere", "radius": 1.0, "position": [0, 0, 0]}
    assert "particles.0.permittivity is missing" in refusal(field_case(particles=[bead]))


def test_a_permittivity_without_a_field_is_refused():
    bead = {"shape": "sphere", "radius": 1.0, "position": [0, 0, 0], "permittivity": 2.0}
    assert "a case without [electric] has none" in refusal(small_case(bead))


def test_a_lattice_whose_spheres_overlap_is_refused():
    bead = {"shape": "sphere", "radius": 1.1, "permittivity": 2.0}
    lattice = {**bead, "lattice": {"kind": "cubic", "counts": [4, 4, 4]}}
    assert "overlaps" in refusal(field_case(particles=[lattice]))


def test_neither_fluid_nor_field_is_refused():
    case = field_case()
    del case["electric"]
    assert "a case needs [fluid] with density and viscosity, or [electric]" in refusal(case)


def test_a_free_box_in_a_field_is_refused_and_a_held_one_warned_of():
    box = {"shape": "box", "sides": [1, 1, 1], "position": [0, 0, 0], "permittivity": 5.0}
    case = field_case(particles=[box])
    checks = {row["name"]: row for row in sp.Electrostatics.from_file(case).preflight()}
    assert checks["bodies with edges"]["verdict"] == "warn"
    flow = {"fluid": {"density": 1, "viscosity": 1}, "time": {"end": 1}}
    moving = {**case, **flow, "profile": {"thickness": 0.2}}
    moving["particles"] = [{**box, "motion": "free", "density": 1.0}]
    assert 'particles.0.shape is "box"; a field turns it wrongly' in refusal(moving)
