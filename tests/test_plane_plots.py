"""Outlines of spheres in planes, and which bodies a report calls moving."""

import tomllib
from dataclasses import replace

import numpy as np
import pytest

from case_makers import small_case
from smoothprofile.config import PlaneCut, load_case
from smoothprofile.plane_plots import discs_cut, plane_pictures
from smoothprofile.plots import pictures
from smoothprofile.runrecord import read_run
from test_output import write_run


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("planes") / "run"
    write_run(path)
    return path


def test_spheres_are_outlined_where_they_are_with_their_images(run):
    """A sphere of 1 at height .6 over the plane leaves a disc of .8, and one across a side two."""
    record = read_run(run)
    body = {"shape": "sphere", "radius": 1.0}
    bodies = [
        body | {"name": "held", "position": [2.0, 0.5, 0.6]},
        body | {"name": "held too", "position": [9.5, 1.0, 0.0]},
        body | {"name": "clear", "position": [-4.0, 0.0, 1.5]},
    ]
    domain = {"lengths": [20.0, 7.0, 7.0], "origin": [-10.0, -3.5, -3.5]}
    domain["boundaries"] = ["periodic", "wall", "wall"]
    plane = record.plane | {"axis": np.array("z"), "at": np.array(0.0)}
    case = {"domain": domain, "particles": bodies}
    cut = replace(record, case=case, plane=plane, particles={})
    found = discs_cut(cut)
    seen = found[np.abs(found[:, 0]) < 11.0]
    assert seen == pytest.approx(np.array([[-10.5, 1, 1], [2, 0.5, 0.8], [9.5, 1, 1]]))
    axes = plane_pictures(cut)[0].figure.axes[0]
    assert axes.figure.legends[0].get_texts()[0].get_text() == "surface of a particle"
    assert np.allclose(axes.get_xlim(), plane["x"][[0, -1]])
    # Other shapes are outlined as they are painted.
    assert discs_cut(replace(cut, case={"domain": domain, "particles": [{"shape": "box"}]})) is None


@pytest.mark.parametrize(
    ("fluid", "electric", "axis"),
    [
        ({}, None, "z"),
        ({"gravity": [0, 0, -1]}, None, "y"),
        ({"gravity": [0, -1e-3, -1]}, None, "x"),
        ({"body_force": [0, 0, 1]}, None, "y"),
        ({"mean_velocity": {"z": 2.0, "y": 0.0}}, None, "y"),
        ({"mean_velocity": {"z": 0.0}}, None, "z"),
        ({}, {"field": [0, 0, 1]}, "y"),
        ({}, {"field": [0, 1, 0], "quadrature": [0, 0, 1], "angular_frequency": 1}, "x"),
        ({}, {"electrodes": {"axis": "z", "high": 1.0}}, "y"),
        ({"wall_velocity": {"z_high": [1, 0, 0]}}, None, "y"),
        ({"wall_velocity": {"z_high": [0, 0, 0]}}, None, "z"),
        ({"wall_velocity": {"z_high": [0, 1, 0]}, "body_force": [1, 0, 0]}, None, "z"),
    ],
)
def test_the_plane_lies_where_what_acts_is_seen(fluid, electric, axis):
    walled = "wall_velocity" in fluid or "electrodes" in (electric or {})
    case = small_case(boundaries=("periodic", "periodic", "wall" if walled else "periodic"))
    case["fluid"] |= fluid
    if electric:
        case["electric"] = electric
    loaded = load_case(case)
    assert loaded.output.plane == PlaneCut(axis=axis)
    again = load_case(tomllib.loads(loaded.to_toml()))
    assert again == loaded and again.output.plane.axis == axis
    given = load_case(case | {"output": {"plane": {"axis": "x", "at": 1.0}}})
    assert given.output.plane == PlaneCut(axis="x", at=1.0)


def test_round_off_is_no_motion(tmp_path):
    write_run(tmp_path / "run", steps=20)
    record = read_run(tmp_path / "run")
    ((name, columns),) = record.particles.items()
    time = columns["time"]

    def drawn_at(speed):
        moving = {
            f"{what}_{axis}": speed * time for what in ("velocity", "position") for axis in "xyz"
        }
        history = record.history | {"max_speed": np.ones(time.size)}
        found = pictures(replace(record, particles={name: columns | moving}, history=history))
        return "motion" in [picture.name for picture in found]

    assert drawn_at(1e-6)
    assert not drawn_at(1e-15)
