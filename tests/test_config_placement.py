"""Bodies of a case: their shapes and attitudes, and where they may stand."""

import math

import numpy as np
import pytest

from case_makers import refusal, small_case, sphere
from smoothprofile import rotations
from smoothprofile.config import build_shape, load_case
from smoothprofile.errors import CaseError

# Each reaches 1 along x; two of them touch when their positions along it are 2 apart.
SOLIDS = [
    {"shape": "sphere", "radius": 1},
    {"shape": "ellipsoid", "radii": [1, 2, 0.5]},
    {"shape": "cylinder", "radius": 1},
    {"shape": "cylinder", "radius": 1, "length": 2},
    {"shape": "capsule", "radius": 0.5, "length": 1, "axis": [1, 0, 0]},
    {"shape": "box", "sides": [2, 2, 2]},
    {"shape": "box", "sides": [2, 1, 1], "orientation": {"axis": [1, 0, 0], "angle": 40}},
]


@pytest.mark.parametrize(
    ("body", "key", "value", "allowed"),
    [
        ({"shape": "cylinder", "radius": 1, "axis": [1, 1, 0]}, "axis", "[1.0, 1.0", "along x, y"),
        ({"shape": "plane", "normal": [1, 0, 0]}, "normal", "[1.0, 0.0", "walls"),
        ({"shape": "plane"}, "normal", "missing", "needs"),
        (
            {"shape": "capsule", "radius": 1, "length": 2, "axis": [0, 0, 0]},
            "axis",
            "[0",
            "not all",
        ),
        (
            {"shape": "capsule", "radius": 1, "length": 8.5, "axis": [1, 0, 0]},
            "position",
            "[0",
            "own",
        ),
        ({"shape": "box", "sides": [1, 9, 1]}, "position", "[0.0", "-4.5 to 4.5 along y"),
        ({"shape": "union", "parts": []}, "parts", "[]", "one or more"),
        (sphere(motion="held", velocity=[1, 0, 0]), "velocity", "[1.0, 0.0, 0.0]", "prescribed"),
        (
            {"shape": "cylinder", "radius": 1, "angular_velocity": [1, 0, 0]},
            "angular_velocity",
            "[1.0",
            "own axis",
        ),
        (
            {
                "shape": "union",
                "parts": [{"shape": "cylinder", "radius": 1, "position": [0, 0, 0]}],
            },
            "parts.0.length",
            "missing",
            "end",
        ),
    ],
)
def test_bodies_that_cannot_be_are_refused(body, key, value, allowed):
    text = refusal(small_case({"position": [0, 0, 0], **body}))
    assert text.startswith(f"particles.0.{key} is {value}")
    assert allowed in text


@pytest.mark.parametrize("centre", [0.0, -4.5, 4.5])
@pytest.mark.parametrize("other", SOLIDS)
@pytest.mark.parametrize("solid", SOLIDS)
def test_bodies_may_touch_but_not_overlap(solid, other, centre):
    def pair(distance):
        second = (centre + distance + 5.0) % 10.0 - 5.0
        return small_case(
            solid | {"position": [centre, 0, 0]}, other | {"position": [second, 0, 0]}
        )

    # A thousandth of the radius: the points of a surface meet at its poles.
    load_case(pair(2.0))
    assert "overlaps particles.0" in refusal(pair(1.999))


def test_a_sphere_is_tested_exactly_against_a_turned_box():
    turn = {"axis": [1.0, 2.0, 3.0], "angle": 50.0}
    quaternion = rotations.from_axis_angle(turn["axis"], math.radians(turn["angle"]))
    box = {"shape": "box", "sides": [2, 1, 1.5], "position": [0, 0, 0], "orientation": turn}
    rng = np.random.default_rng(3)
    for direction in rng.normal(size=(20, 3)):
        centre = 2.2 * direction / np.linalg.norm(direction)
        own = rotations.rotate(rotations.conjugate(quaternion), centre)
        gap = np.linalg.norm(own - np.clip(own, [-1, -0.5, -0.75], [1, 0.5, 0.75]))
        ball = {"shape": "sphere", "position": list(centre)}
        load_case(small_case(box, ball | {"radius": gap * (1 - 1e-6)}))
        # 1e-9 of the domain is the slack for bodies that touch; 1e-6 of the gap is above it.
        assert "overlaps" in refusal(small_case(box, ball | {"radius": gap * (1 + 1e-6)}))


def test_bodies_without_an_end_overlap_too():
    plane = {"shape": "plane", "position": [0, -1, 0], "normal": [0, 1, 0]}
    load_case(small_case(plane, sphere()))
    assert "overlaps particles.0" in refusal(small_case(plane, sphere(position=[2, -0.1, 0])))
    rod = {"shape": "cylinder", "radius": 0.5, "position": [0, 0, 0], "axis": [1, 0, 0]}
    across = {"shape": "cylinder", "radius": 0.5, "position": [3, 0.9, 0], "axis": [0, 0, 1]}
    assert "overlaps particles.0" in refusal(small_case(rod, across))
    load_case(small_case(rod, across | {"position": [3, 1.1, 0]}, boundaries=["periodic"] * 3))
    wide = {"shape": "cylinder", "radius": 4.5, "position": [0, 0, 0], "axis": [1, 0, 0]}
    assert "own periodic image" in refusal(small_case(wide, boundaries=["periodic"] * 3))


@pytest.mark.parametrize(
    ("body", "inside", "outside"),
    [
        ({"shape": "plane", "normal": [0, -1, 0]}, [0, 0.1, 0], [0, -0.1, 0]),
        (
            {"shape": "capsule", "radius": 0.5, "length": 3, "axis": [0, 1, 0]},
            [0, 1.9, 0],
            [0, 0, 1],
        ),
        ({"shape": "cylinder", "radius": 0.5, "axis": [1, 0, 0]}, [4, 0, 0], [0, 0, 1]),
        ({"shape": "ellipsoid", "radii": [1, 2, 3]}, [0, 0, 2.9], [1.1, 0, 0]),
        (
            {"shape": "box", "sides": [4, 1, 1], "orientation": {"axis": [0, 0, 1], "angle": 90}},
            [0, 1.9, 0],
            [1.9, 0, 0],
        ),
    ],
)
def test_bodies_point_where_the_case_says(body, inside, outside):
    (particle,) = load_case(small_case({"position": [0, 0, 0], **body})).particles
    own = rotations.rotate(rotations.conjugate(particle.quaternion), [inside, outside])
    depths = build_shape(particle).distance(own)
    assert depths[0] < 0 < depths[1]


def test_a_coarse_start_is_refused_for_bodies_that_travel():
    case = {
        "domain": {"lengths": [8.0] * 3, "cells": [16] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {"density": 1.0, "viscosity": 1.0},
        "profile": {"thickness": 0.5},
        "particles": [
            {"shape": "sphere", "radius": 1.0, "position": [4.0] * 3, "velocity": [1.0, 0.0, 0.0]}
        ],
        "time": {"end": 1.0},
        "start": [{"cells": [8] * 3}],
    }
    with pytest.raises(CaseError, match=r"particles\.0\.velocity .*start"):
        load_case(case)
