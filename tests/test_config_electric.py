"""[electric] of a case: what it fills in, and what it refuses."""

import pytest

import smoothprofile as sp
from case_makers import refusal, small_case
from smoothprofile.config import load_case
from smoothprofile.numbers import number_rows


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
    assert (plain.smoothing, plain.retract, plain.method) == ("auto", True, "conjugate-gradients")
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
        (["electric.smoothing=wrong"], 'electric.smoothing is "wrong"; it must be "auto"'),
        (["electric.profile=wrong"], 'electric.profile is "wrong"; it must be one of'),
        (["electric.tolerance=0"], "electric.tolerance is 0; it must be a number from 1e-14"),
        (["electric.feld=[1,0,0]"], "electric.feld is not a known key; the nearest is"),
        (["domain.precision=single"], 'a case with [electric] needs "double"'),
        (["profile.thickness=0.3"], "a case without [fluid] has no profile"),
        (["time.end=1"], "a case without [fluid] has no time"),
        (["output.fields_every=1"], "output.fields_every is 1.0; a case without [fluid] has no"),
        (["contact.friction=0.2"], "contact.friction is 0.2; a case without [fluid] has no cont"),
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


def test_the_effective_permittivity_is_asked_of_a_field_alone():
    bead = {"shape": "sphere", "radius": 1.0, "position": [0, 0, 0], "permittivity": 2.0}
    case = small_case(bead, boundaries=["periodic"] * 3)
    case["electric"] = {"field": [0, 0, 1], "effective": True}
    assert "electric.effective is true; it takes a field of its own" in refusal(case)
    assert not load_case({**case, "electric": {"field": [0, 0, 1]}}).electric.effective


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


ROUND = {"shape": "sphere", "radius": 1.0, "position": [0, 0, 0], "permittivity": 10.0}
LONG = {"shape": "ellipsoid", "radii": [1, 1, 1.5], "position": [0, 0, 0], "permittivity": 10.0}
FREE = {"motion": "free", "density": 1.0}
FLOW = {
    "fluid": {"density": 1, "viscosity": 1},
    "time": {"end": 1},
    "profile": {"thickness": 0.3},
}


@pytest.mark.parametrize(
    ("body", "given", "taken"),
    [
        (ROUND, "auto", "tensor"),
        (ROUND | FREE, "auto", "harmonic"),
        (ROUND | {"motion": "prescribed", "velocity": [0.1, 0, 0]}, "auto", "harmonic"),
        (ROUND | FREE, "tensor", "tensor"),
        (LONG | FREE, "auto", "tensor"),
        (ROUND, "harmonic", "harmonic"),
    ],
)
def test_how_permittivity_is_smoothed_by_itself_and_told(body, given, taken):
    electric = {"field": [0, 0, 1], "smoothing": given}
    run = sp.Simulation(load_case(field_case(particles=[body], electric=electric, **FLOW)))
    assert run.action.field.medium.smoothing == taken
    told = {name: (value, note) for name, value, note in run.table()}["smoothing of ε"]
    assert told[0] == taken
    assert ("auto" in told[1]) == (given == "auto")
    assert {row["name"]: row["value"] for row in run.preflight()}["smoothing"] == taken


def test_messages_name_the_keys_of_the_field():
    def words(**electric):
        case = field_case(electric={"field": [0, 0, 1], **electric}, **FLOW)
        with pytest.raises(sp.CaseError) as caught:
            sp.Simulation(load_case(case))
        return str(caught.value)

    assert "electric.thickness is 0.9; 1, the smallest radius" in words(thickness=0.9)
    assert "electric.thickness is 1e-12; it must be at least" in words(thickness=1e-12)
    tensor, mean = (words(thickness=0.75, smoothing=kind) for kind in ("tensor", "arithmetic"))
    assert "electric.thickness is 0.75" in tensor and "electric.thickness is 0.75" in mean
    assert 'electric.smoothing = "tensor"' in mean
    assert 'electric.smoothing = "tensor"' not in tensor


def test_a_contrast_that_no_radius_is_known_for_is_refused_by_its_key():
    told = refusal(field_case(), ["particles.0.permittivity=1e12"])
    assert "particles.0.permittivity is 1000000000000.0; beside electric.permittivity" in told


def check_of(case, name):
    return {row["name"]: row for row in sp.Electrostatics.from_file(case).preflight()}[name]


def test_the_contrast_that_is_told_is_that_of_the_body_that_differs_most():
    small = ROUND | {"radius": 0.5, "position": [2, 2, 2]}
    check = check_of(field_case(particles=[ROUND | {"permittivity": 0.01}]), "permittivity ratio")
    assert check["value"] == pytest.approx(0.01)
    bodies = [ROUND | {"permittivity": 0.01}, small]
    check = check_of(field_case(particles=bodies), "permittivity ratio")
    assert check["value"] == pytest.approx(0.01)
    assert "from 0.01 to 10" in check["note"]
    table = sp.Electrostatics.from_file(field_case(particles=bodies)).case
    notes = {name: note for name, _, note in number_rows(table)}
    assert "bodies go from 0.01 to 10" in notes["R"]
    assert "bodies go from -0.4925 to 0.75" in notes["β"]
    assert "bodies go" not in {n: t for n, _, t in number_rows(load_case(field_case()))}["R"]


@pytest.mark.parametrize(
    ("body", "gap"),
    [
        # Turned by 60° from z: half extents by hand.
        ({**LONG, "orientation": {"axis": [0, 1, 0], "angle": 60}}, 4 - (0.75 + 1.5**2 / 4) ** 0.5),
        ({"shape": "capsule", "radius": 0.5, "length": 4.0}, 4 - 2.5),
        ({"shape": "box", "sides": [1, 1, 2]}, 3.0),
    ],
)
def test_gaps_to_electrodes_are_those_of_the_bodies_own_ends(body, gap):
    body = {"position": [0, 0, 0], "permittivity": 5.0, **body}
    domain = {**field_case()["domain"], "boundaries": ["periodic", "periodic", "wall"]}
    electric = {"electrodes": {"axis": "z", "low": 0.0, "high": 8.0}}
    case = field_case(domain=domain, electric=electric, particles=[body])
    assert check_of(case, "electrode gap")["value"] == pytest.approx(gap, abs=1e-12)


def test_a_step_that_draws_beads_far_is_warned_of():
    bodies = [ROUND | FREE | {"position": [0, 0, z]} for z in (-1.2, 1.2)]
    for field, verdict in ((1.0, "ok"), (9.0, "warn")):
        case = field_case(particles=bodies, electric={"field": [0, 0, field]}, **FLOW)
        rows = {row["name"]: row for row in sp.Simulation(load_case(case)).preflight()}
        assert rows["step, near pair"]["verdict"] == verdict
