"""What is refused before a run: steps that move surfaces too far, ranges, paths; and its time."""

import json
import math
import re

import gsd.hoomd
import numpy as np
import pytest

import smoothprofile as sp
from case_makers import refusal, small_case, sphere
from smoothprofile import calibration
from smoothprofile.config.particle import SIZES
from smoothprofile.errors import CaseError
from smoothprofile.pairing import can_be_moved, ratio_range
from smoothprofile.trajectories import trajectory_of

NUMBER = r"[-+.\de]+\d"


def free_sphere(**changes):
    return sphere(motion="free", density=2.0, **changes)


def run_of(*particles, boundaries=("periodic",) * 3, **tables):
    """A simulation in the box of `small_case`, at rest; tables change the case's own."""
    case = small_case(*particles, boundaries=boundaries)
    for name, changes in tables.items():
        case[name] = case.get(name, {}) | changes
    return sp.Simulation(sp.load_case(case))


def refused(*particles, **tables):
    with pytest.raises(CaseError) as caught:
        run_of(*particles, **tables)
    text = str(caught.value)
    assert text.endswith(".") and "\n" not in text
    return text


@pytest.mark.parametrize(
    ("boundaries", "why"),
    [
        (["periodic"] * 3, "half the period along y"),
        (["periodic", "wall", "wall"], "the ends of y"),
    ],
)
def test_a_contact_range_beyond_half_the_box_is_refused(boundaries, why):
    case = small_case(free_sphere(), boundaries=boundaries)
    sp.load_case(case | {"contact": {"range": 4.0}})
    for value in (4.001, 9.0, 1e9):
        text = refusal(case | {"contact": {"range": value}})
        assert text.startswith(f"contact.range is {value}; it must be at most 4, ")
        assert why in text


@pytest.mark.parametrize("retract", ["planar", True])
@pytest.mark.parametrize("kind", ["tanh", "quartic-centred"])
@pytest.mark.parametrize("step", [1e4, 1e8])
def test_a_step_that_moves_a_surface_out_of_its_box_is_refused(kind, retract, step):
    profile, time = {"kind": kind, "retract": retract}, {"step": step, "end": 1e9}
    text = refused(sphere(), profile=profile, time=time)
    assert text.startswith(f"time.step is {step:g}; with fluid.viscosity 1, fluid.density 1")
    least, most = map(float, re.search(f"a step from ({NUMBER}) to ({NUMBER})", text).groups())
    # Painted 3a out, s₀ξ = k ξ − .8ξ/k: the step is a little over (3a)²/ν.
    assert least < 0.1 and 9.0 < most < 12.0
    planar = {"kind": kind, "retract": "planar"}
    run_of(sphere(), profile=planar, time={"step": 0.99 * most, "end": 100.0})
    refused(sphere(), profile=planar, time={"step": 1.01 * most, "end": 100.0})


def test_a_surface_that_is_not_moved_takes_any_step():
    run = run_of(sphere(), profile={"retract": False}, time={"step": 1e4, "end": 1e5})
    assert run.particles[0]["painted_offset"] == 0.0


def test_a_plane_may_be_moved_by_half_the_room_that_it_faces():
    plane = {"shape": "plane", "position": [0.0, 2.0, 0.0], "normal": [0.0, -1.0, 0.0]}
    box = {"lengths": [0.4, 8.0, 0.4], "cells": [2, 16, 2], "origin": [-0.2, -4.0, -0.2]}
    sides = ("periodic", "wall", "periodic")
    # 1.9 out of a box .4 wide along the plane: that width does not count.
    run_of(plane, boundaries=sides, domain=box, time={"step": 4.0, "end": 8.0})
    text = refused(plane, boundaries=sides, domain=box, time={"step": 25.0, "end": 50.0})
    assert "surface of plane" in text


@pytest.mark.parametrize(("half", "room"), [(1.0, 8.0), (2.0, 5.0), (math.inf, 6.0)])
@pytest.mark.parametrize("kind", ["tanh", "quartic-centred", "sine"])
def test_the_range_of_ratios_is_where_surfaces_can_be_moved(kind, half, room):
    run = run_of(sphere(), profile={"kind": kind, "retract": "planar"})

    def movable(ratio):
        shift = calibration.interface_shift(kind, ratio)
        pairing = type(run.pairing)(1.0, 1.0, (0.0,) * 3, 1.0, ratio, 1.0, shift)
        return can_be_moved(run.case, pairing, half, room)

    low, high = ratio_range(run.case, half, room)
    # brentq finds the logarithm to 2e-12.
    assert movable(low * 1.0001) and movable(high * 0.9999)
    assert not movable(high * 1.0001)
    # A plane behind a compact profile may be painted for any short step.
    assert movable(low * 0.9999) == (math.isinf(half) and kind != "tanh")


@pytest.mark.parametrize(
    ("fluid", "words"),
    [
        ({"viscosity": 1e9}, "fluid.viscosity 1e+09"),
        ({"viscosity": 1e30}, "fluid.viscosity 1e+30"),
        ({"viscosity": 1e-30}, "fluid.viscosity 1e-30"),
        ({"density": 1e30}, "fluid.density 1e+30"),
        ({"density": 1e-30}, "fluid.density 1e-30"),
    ],
)
def test_an_absurd_fluid_is_named_with_the_ratio(fluid, words):
    text = refused(sphere(), fluid=fluid, time={"step": 0.05})
    assert text.startswith("time.step is 0.05; with ") and words in text
    nu = fluid.get("viscosity", 1.0) / fluid.get("density", 1.0)
    ratio, low, high = map(
        float, re.search(f"is ({NUMBER}), and must be from ({NUMBER}) to ({NUMBER})", text).groups()
    )
    # Written with three digits.
    assert ratio == pytest.approx(math.sqrt(nu * 0.05) / 0.3, rel=0.005)
    assert not low < ratio < high


def test_an_absurd_force_is_named_by_the_speed_that_it_drives():
    text = refused(free_sphere(force=[1e30, 0.0, 0.0]))
    assert text.startswith('time.step is "auto", here ')
    assert "as much as is stable with speeds up to (" in text and "e+" in text


def test_a_free_body_that_meets_no_point_of_the_grid_is_refused():
    box = {"lengths": [1e4] * 3, "origin": [0.0] * 3, "cells": [16] * 3}
    for density in (0.5, 2.0):
        body = free_sphere(position=[5e3] * 3) | {"density": density}
        assert refused(body, domain=box).startswith("particles.0 meets no points of the grid")


def test_numbers_beyond_single_precision_are_written_as_its_largest(tmp_path):
    run, path = run_of(free_sphere() | {"density": 1e39}), tmp_path / "trajectory.gsd"
    with np.errstate(over="raise"):
        written = trajectory_of(path, run)
        written.append(run)
        written.close()
    with gsd.hoomd.open(str(path), mode="r") as file:
        assert file[0].particles.mass[0] == np.finfo(np.float32).max


def test_a_directory_below_a_file_is_refused_before_anything_is_made(spm, tmp_path):
    (tmp_path / "file").write_text("mine")
    for command, kind in ((["run", "duct"], "output directory"), (["bench"], "file")):
        code, out, err = spm(*command, "--out", "file/x")
        assert (code, out) == (2, "")
        assert err == f"the {kind} file/x cannot be made: file is not a directory.\n"


def test_the_list_of_studies_is_written_where_it_is_asked_for(spm, tmp_path):
    code, out, _ = spm("study", "list", "--out", "list.json")
    written = json.loads((tmp_path / "list.json").read_text(encoding="utf-8"))
    assert code == 0 and "couette" in out
    assert written == json.loads(spm("study", "list", "--json")[1])
    code, _, err = spm("study", "list", "--out", "list.json")
    assert code == 2 and "exists already" in err


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (
            {"shape": "cylinder", "radius": 1, "sides": [1, 1, 1]},
            "a cylinder needs radius, and may have length and axis, and no other size",
        ),
        ({"shape": "sphere", "radius": 1, "length": 1}, "a sphere takes radius, and no other size"),
        (
            {"shape": "plane", "normal": [0, 1, 0], "radius": 1},
            "a plane takes normal, and no other size",
        ),
    ],
)
def test_the_sizes_of_a_shape_are_told_apart_from_those_it_may_have(body, words):
    assert words in refusal(small_case(body | {"position": [0, 0, 0]}))
    assert SIZES["mesh"].words == "needs file, and may have scale, repair and digest"


def test_a_layer_of_exactly_three_cells_is_enough():
    """.6 and 10/50 make 2.9999999999999996."""
    case = small_case(sphere(radius=1.8, position=[5.0] * 3))
    case["domain"] |= {"lengths": [10.0] * 3, "cells": [50] * 3, "origin": [0.0] * 3}
    case["profile"] = {"kind": "quartic-centred", "thickness": 0.6}
    rows = {row["name"]: row["verdict"] for row in sp.Simulation(sp.load_case(case)).preflight()}
    assert 0.6 / 0.2 < 3.0
    assert rows["ξ/Δx"] == rows["a/ξ"] == "ok"


def test_a_field_counts_in_the_estimate_of_time():
    """The field is most of a step; solved for every tenth step, it hardly counts."""
    flow = small_case(sphere(motion="free", density=1.0))
    beads = small_case(sphere(motion="free", density=1.0, permittivity=10.0))
    field = {"field": [0.0, 0.0, 1.0], "permittivity": 1.0}
    for case in (flow, beads):
        case["domain"] |= {"lengths": [8.0] * 3, "cells": [96] * 3, "origin": [0.0] * 3}
        case["domain"]["boundaries"] = ["periodic"] * 3
    found = []
    for case in (flow, beads | {"electric": field}, beads | {"electric": field | {"every": 10}}):
        steps = sp.Simulation(sp.load_case(case)).preflight()
        found.append(next(row["value"] for row in steps if row["name"] == "time (s)"))
    assert found[1] > 3.0 * found[0]
    assert found[0] < found[2] < 2.0 * found[0]


def falling(**tables):
    run = run_of(free_sphere(), **tables)
    return run, {
        row["name"]: row["value"] for row in run.preflight() if row["name"].startswith("d⟨u⟩")
    }


def test_a_box_that_would_fall_as_a_whole_is_foretold():
    gravity = {"gravity": [0.0, 0.0, -2.0]}
    run, rows = falling(fluid=gravity)
    assert set(rows) == {"d⟨u⟩/dt along z"}
    steps = 3
    for _ in range(steps):
        run.step_once()
    state, excess = run.bodies.state, run.bodies.displaced.volume[0]
    fluid = run.grid.volume * run.mean_velocity[2]
    # Momentum of fluid and body, of density 1 and 2, over their mass.
    found = (fluid + excess * state.velocity[0, 2]) / (run.grid.volume + excess) / run.time
    assert rows["d⟨u⟩/dt along z"] == pytest.approx(found, rel=1e-10)


@pytest.mark.parametrize(
    "tables",
    [
        {},
        {"fluid": {"gravity": [0.0, 0.0, -2.0], "mean_velocity": {"z": 0.0}}},
        {"fluid": {"gravity": [0.0, 0.0, -2.0]}, "boundaries": ("periodic", "wall", "periodic")},
    ],
)
def test_a_box_that_is_held_is_not(tables):
    assert falling(**tables)[1] == {}


def step_row(body, steps, **tables):
    """The row of Δt in a case of so many steps of .01."""
    time = {"step": 0.01, "end": 0.01 * steps}
    rows = run_of(body, time=time, **tables).preflight()
    return next(row for row in rows if row["name"] == "time step")


def test_a_case_without_inertia_is_told_that_it_could_do_without():
    """Re = .01 about a body that moves; many steps for it are a warning."""
    moved = sphere(velocity=[0.01, 0.0, 0.0])
    advice = 'at Re = 0.01 fluid.flow = "stokes" needs no such step'
    few, many = step_row(moved, 100), step_row(moved, 10_001)
    assert (few["verdict"], many["verdict"]) == ("ok", "warn")
    assert few["note"].endswith(advice)
    assert many["note"].endswith(f"{advice}, of which there are 10001")


@pytest.mark.parametrize(
    "body",
    [
        sphere(),
        sphere(velocity=[1.0, 0.0, 0.0]),
        # ρωa²/μ = 1, and St = (2/9) 100 · .01: of the fluid, and of the body, inertia counts.
        sphere(velocity={"amplitude": [0.01, 0.0, 0.0], "angular_frequency": 1.0}),
        sphere(motion="free", density=100.0, velocity=[0.01, 0.0, 0.0]),
    ],
)
def test_a_case_with_inertia_or_nothing_that_moves_is_not(body):
    row = step_row(body, 10_001)
    assert row["verdict"] == "ok" and "stokes" not in row["note"]


def test_sentences_say_an_ellipsoid():
    body = {"shape": "ellipsoid", "position": [0, 0, 0]}
    assert "an ellipsoid needs radii" in refusal(small_case(body))
    text = refusal(small_case(body | {"radii": [1, 1, 1], "radius": 1}))
    assert "an ellipsoid takes radii, and no other size" in text
