"""Figures of bodies that move freely."""

import numpy as np
import pytest

from smoothprofile import report
from smoothprofile.figures import drawing
from smoothprofile.motion_plots import motion_picture, spin_picture
from smoothprofile.output import RunRecord

TIME = np.linspace(0.0, 2.0, 21)
QUARTER = {"label": "exact", "peak_speed": 0.3, "measured": {"label": "lab", "peak_speed": 0.31}}


def columns(fall=0.3, spin=0.0, sideways=0.0):
    """A body that falls ever more slowly towards its terminal speed, and turns about z."""
    found = {"time": TIME}
    zero = np.zeros_like(TIME)
    speed = -fall * (1 - np.exp(-3 * TIME))
    for name, values in (("velocity", (sideways + zero, zero, speed)),
                         ("position", (sideways * TIME, zero, np.cumsum(speed) * 0.1)),
                         ("angular_velocity", (zero, zero, spin + zero))):  # fmt: skip
        found |= {f"{name}_{axis}": v for axis, v in zip("xyz", values, strict=True)}
    half = 0.5 * spin * TIME
    found |= {"orientation_w": np.cos(half), "orientation_x": zero, "orientation_y": zero}
    return found | {"orientation_z": np.sin(half)}


def drawn(picture):
    """Label to the y of its line, over both panels."""
    assert picture.png.startswith(b"\x89PNG")
    return {
        line.get_label(): line.get_ydata() for axes in picture.figure.axes for line in axes.lines
    }


def test_velocity_and_path_of_what_falls():
    with drawing():
        lines = drawn(motion_picture({"bead": columns()}, QUARTER))
    assert lines["V₃, bead"] == pytest.approx(columns()["velocity_z"])
    assert "V₁, bead" not in lines
    # Levels stand on the side to which the body moves.
    assert lines["exact"][0] == pytest.approx(-0.3)
    assert lines["lab"][0] == pytest.approx(-0.31)


def test_components_that_count_are_drawn():
    with drawing():
        lines = drawn(motion_picture({"bead": columns(sideways=0.1)}, {}))
    assert {"V₁, bead", "V₃, bead"} <= set(lines)


def test_what_stays_has_no_path_and_what_does_not_turn_no_spin():
    still = columns(fall=0.0)
    with drawing():
        assert motion_picture({"bead": still}, {}) is None
        assert spin_picture({"bead": columns()}, {}) is None


def test_the_first_axis_goes_round_with_the_body():
    """About z by Ωt: n = (cos Ωt, sin Ωt, 0)."""
    with drawing():
        lines = drawn(spin_picture({"bead": columns(spin=1.5)}, {"angular_velocity": 1.5}))
    assert lines["n₁, bead"] == pytest.approx(np.cos(1.5 * TIME))
    assert lines["n₂, bead"] == pytest.approx(np.sin(1.5 * TIME))
    assert lines["Ω₃, bead"] == pytest.approx(1.5 + 0 * TIME)


def test_many_bodies_share_a_colour_and_a_label():
    with drawing():
        lines = drawn(motion_picture({f"bead {n}": columns(0.1 + 0.01 * n) for n in range(9)}, {}))
    assert "V₃, each of 9 bodies" in lines
    assert not any(label.endswith("bead 3") for label in lines)


def test_the_peak_speed_stands_beside_the_reference(tmp_path):
    record = RunRecord(
        tmp_path, "", {"domain": {"cells": [2, 2, 2]}}, particles={"bead": columns()}
    )
    (row,) = report.comparison(record, QUARTER)
    fastest = np.abs(columns()["velocity_z"]).max()
    assert row == ("peak speed", pytest.approx(fastest), 0.3, [0.31])
