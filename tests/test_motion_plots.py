"""Figures of bodies that move freely."""

import numpy as np
import pytest

from smoothprofile import report
from smoothprofile.figures import drawing
from smoothprofile.motion_numbers import half_turns, motion_numbers
from smoothprofile.motion_plots import (
    drift_picture,
    motion_picture,
    pair_picture,
    spin_picture,
)
from smoothprofile.runrecord import RunRecord

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
    assert lines["Vz, bead"] == pytest.approx(columns()["velocity_z"])
    assert "Vx, bead" not in lines
    # Levels stand on the side to which the body moves.
    assert lines["exact"][0] == pytest.approx(-0.3)
    assert lines["lab"][0] == pytest.approx(-0.31)


def test_components_that_count_are_drawn():
    with drawing():
        lines = drawn(motion_picture({"bead": columns(sideways=0.1)}, {}))
    assert {"Vx, bead", "Vz, bead"} <= set(lines)


def test_what_stays_has_no_path_and_what_does_not_turn_no_spin():
    still = columns(fall=0.0)
    with drawing():
        assert motion_picture({"bead": still}, {}) is None
        assert spin_picture({"bead": columns()}, {}) is None


def test_the_first_axis_goes_round_with_the_body():
    """About z by Ωt: n = (cos Ωt, sin Ωt, 0)."""
    with drawing():
        lines = drawn(spin_picture({"bead": columns(spin=1.5)}, {"angular_velocity": 1.5}))
    assert lines["nx, bead"] == pytest.approx(np.cos(1.5 * TIME))
    assert lines["ny, bead"] == pytest.approx(np.sin(1.5 * TIME))
    assert lines["Ωz, bead"] == pytest.approx(1.5 + 0 * TIME)


def test_many_bodies_are_drawn_as_their_mean():
    falls = {f"bead {n}": columns(0.1 + 0.01 * n) for n in range(9)}
    with drawing():
        lines = drawn(motion_picture(falls, {"label": "law", "mean_speed": 0.2}))
    mean = np.mean([c["velocity_z"] for c in falls.values()], axis=0)
    assert lines["Vz, mean of 9 bodies"] == pytest.approx(mean)
    assert lines["law"][0] == pytest.approx(-0.2)
    assert not any(label.endswith("bead 3") for label in lines)


def test_a_reference_curve_has_the_sign_of_the_motion():
    known = {"label": "exact", "speed": {"coordinate": [0.5, 1.0], "value": [0.2, 0.25]}}
    with drawing():
        lines = drawn(motion_picture({"bead": columns()}, known))
    assert lines["exact"] == pytest.approx([-0.2, -0.25])


def pair():
    """A body over another, which it reaches and goes round."""
    turn = np.pi / 4 * TIME
    above = columns()
    apart = 3.0 - 0.4 * TIME
    below = columns()
    above["position_x"] = below["position_x"] + apart * np.sin(turn)
    above["position_z"] = below["position_z"] + apart * np.cos(turn)
    return {"below": below, "above": above}


def test_distance_and_turn_of_a_pair():
    with drawing():
        picture = pair_picture(pair(), {"contact_distance": 2.0})
        lines = drawn(picture)
        assert pair_picture(pair(), {}) is None
    assert lines["this run"] == pytest.approx(3.0 - 0.4 * TIME)
    assert lines["touch"][0] == 2.0
    assert picture.figure.axes[1].lines[0].get_ydata()[-1] == pytest.approx(90.0)


def test_drift_beside_known_places():
    with drawing():
        lines = drawn(drift_picture(pair(), {"label": "there", "places": {"x": [0.5, -0.5]}}))
    assert lines["above"] == pytest.approx(pair()["above"]["position_x"])
    assert lines["there"][0] == 0.5


def test_numbers_of_motion():
    """Final and mean speeds, least distance, and half turns about z by Ωt: π/Ω."""
    found = motion_numbers(pair())
    assert found["final_speed"] == pytest.approx(np.abs(columns()["velocity_z"][-1]))
    assert found["least_distance"] == pytest.approx(2.2)
    late = TIME >= 1.0
    assert found["mean_speed"] == pytest.approx(np.abs(columns()["velocity_z"][late]).mean())
    turning = columns(spin=5.0)
    assert motion_numbers({"bead": turning})["angular_velocity"] == 5.0
    # Crossings are interpolated over ΩΔt = .5.
    assert half_turns(turning) == pytest.approx([np.pi / 5.0] * 2, rel=0.02)


def test_the_peak_speed_stands_beside_the_reference(tmp_path):
    record = RunRecord(
        tmp_path, "", {"domain": {"cells": [2, 2, 2]}}, particles={"bead": columns()}
    )
    (row,) = report.comparison(record, QUARTER)
    fastest = np.abs(columns()["velocity_z"]).max()
    assert row == ("peak speed", pytest.approx(fastest), 0.3, [0.31])
