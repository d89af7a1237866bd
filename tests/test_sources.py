"""Bodies by the dozen: lattices, random packings and CSV files in place of a position."""

import math
import time
import tomllib

import numpy as np
import pytest

from case_makers import refusal, small_case, sphere
from smoothprofile import rotations
from smoothprofile.config import build_shape, load_case

PERIODIC = ["periodic"] * 3


def beads(**changes):
    return {"shape": "sphere", "radius": 0.3, **changes}


def cube(*particles, side=10.0, boundaries=PERIODIC, thickness=0.05):
    """A cube with a corner at the origin."""
    case = small_case(*particles, boundaries=boundaries)
    case["domain"] |= {"lengths": [side] * 3, "cells": [8] * 3, "origin": [0, 0, 0]}
    case["profile"]["thickness"] = thickness
    return case


def positions(case):
    return np.array([particle.position for particle in case.particles])


def radii(case):
    return np.array([particle.radius for particle in case.particles])


def gaps(case):
    """(n, n) from surface to surface of spheres, over periodic ends; inf of a sphere to itself."""
    x, a = positions(case), radii(case)
    apart = x[:, None] - x
    periods = np.array(case.domain.lengths)
    apart -= np.where(case.domain.periodic, periods * np.round(apart / periods), 0.0)
    found = np.linalg.norm(apart, axis=2) - a[:, None] - a
    np.fill_diagonal(found, np.inf)
    return found


@pytest.mark.parametrize(
    ("kind", "each", "nearest"),
    [("cubic", 1, 1.0), ("bcc", 2, math.sqrt(3) / 2), ("fcc", 4, math.sqrt(0.5))],
)
def test_lattices_fill_the_domain(kind, each, nearest):
    case = load_case(cube(beads(lattice={"kind": kind, "counts": [5, 5, 5]})))
    assert len(case.particles) == 125 * each
    # Cells of side 2: all bodies have their nearest neighbour as far as the lattice says.
    least = gaps(case).min(axis=1) + 0.6
    np.testing.assert_allclose(least, 2.0 * nearest, rtol=1e-13)
    low, high = positions(case).min(axis=0), positions(case).max(axis=0)
    np.testing.assert_allclose(low, 10.0 - high, rtol=1e-13)


def test_a_lattice_stands_where_it_is_told():
    table = {"counts": [2, 1, 3], "spacing": [2.0, 1.0, 1.5], "origin": [-3, 0.5, -2]}
    case = load_case(small_case(beads(lattice=table, name="bead", motion="free", density=2.0)))
    expected = [[x, 0.5, z] for x in (-3, -1) for z in (-2, -0.5, 1)]
    assert positions(case).tolist() == expected
    assert [p.name for p in case.particles] == [f"bead {i}" for i in range(6)]
    assert {p.motion for p in case.particles} == {"free"}
    # As many of spacing 2 as fit 10 × 8 × 8.
    assert len(load_case(small_case(beads(lattice={"spacing": 2.0}))).particles) == 5 * 4 * 4


@pytest.mark.parametrize("boundaries", [PERIODIC, ["wall"] * 3])
def test_random_packings_keep_their_distance_and_their_seed(boundaries):
    table = {"count": 150, "seed": 3, "gap": 0.05}
    case = load_case(cube(beads(random=table), boundaries=boundaries, side=5.0))
    assert len(case.particles) == 150
    assert gaps(case).min() >= 0.05
    if boundaries != PERIODIC:
        walls = np.minimum(positions(case), 5.0 - positions(case)) - 0.3
        assert walls.min() >= 0.05
    again = load_case(cube(beads(random=table), boundaries=boundaries, side=5.0))
    assert again == case
    other = cube(beads(random=table | {"seed": 4}), boundaries=boundaries, side=5.0)
    assert load_case(other) != case


def test_a_packing_as_loaded_needs_no_seed():
    case = load_case(cube(beads(random={"count": 20, "seed": 1})))
    text = case.to_toml()
    assert "seed" not in text and "random" not in text
    assert load_case(tomllib.loads(text)) == case


def test_half_of_space_can_be_filled():
    case = load_case(cube(beads(random={"volume_fraction": 0.5}), side=4.0))
    share = np.sum(4 / 3 * math.pi * radii(case) ** 3) / 4.0**3
    # A whole number of spheres, each .18 % of the cube.
    assert share == pytest.approx(0.5, abs=1e-3)
    assert gaps(case).min() > 0.0


def test_a_packing_is_stirred_until_it_has_forgotten_how_it_came_about():
    case = load_case(cube(beads(random={"volume_fraction": 0.3}), side=8.0))
    found = gaps(case)
    # In a fluid of hard spheres at φ = .3, g(contact) = (1 − φ/2)/(1 − φ)³ = 2.48 (Carnahan &
    # Starling): each has 24 φ g δ/(2a) = 1.8 neighbours nearer than δ = .1·2a, a little less as g
    # falls with distance. Spheres that merely slid apart would have three times as many.
    touching = np.sum(found < 0.06) / len(found)
    assert 1.2 < touching < 2.2


def test_packings_go_around_what_stands():
    standing = [
        sphere(position=[5, 5, 5], radius=2.0),
        {"shape": "box", "sides": [2, 3, 2], "position": [0.5, 5, 9.5]},
        {"shape": "plane", "position": [5, 1, 5], "normal": [0, 1, 0]},
    ]
    packed = beads(random={"volume_fraction": 0.15, "gap": 0.1})
    boundaries = ["periodic", "wall", "periodic"]
    case = load_case(cube(packed, *standing, boundaries=boundaries))
    points = positions(case)[:-3]
    ball, box, plane = (build_shape(p) for p in case.particles[-3:])
    assert ball.distance(points - [5, 5, 5]).min() > 0.4
    across = points - [0.5, 5, 9.5]
    across -= np.array([10, 0, 10]) * np.round(across / 10)
    assert box.distance(across).min() > 0.4
    assert np.min(points[:, 1]) > 1.4
    assert plane.name == "plane"


def test_packings_stay_in_their_box():
    box = {"low": [1, 2, 3], "high": [4, 5, 9]}
    case = load_case(cube(beads(random={"count": 60, "box": box}, radius=[0.2, 0.4])))
    assert np.all(positions(case) - radii(case)[:, None] >= np.array([1, 2, 3]) - 1e-12)
    assert np.all(positions(case) + radii(case)[:, None] <= np.array([4, 5, 9]) + 1e-12)
    assert radii(case)[:4].tolist() == [0.2, 0.4, 0.2, 0.4]


def test_radii_can_be_spread():
    table = {"mean": 0.3, "deviation": 0.06}
    for kind in ("normal", "lognormal"):
        packed = beads(random={"count": 800}, radius=table | {"kind": kind})
        found = radii(load_case(cube(packed)))
        # Four standard errors of the mean and of the deviation of 800, the cut tails being small.
        assert found.mean() == pytest.approx(0.3, abs=4 * 0.06 / math.sqrt(800))
        assert found.std() == pytest.approx(0.06, rel=4 / math.sqrt(1600))
        assert found.min() >= 0.12 and found.max() <= 0.48
    cut = beads(random={"count": 100}, radius=table | {"smallest": 0.29, "largest": 0.33})
    found = radii(load_case(cube(cut)))
    assert found.min() >= 0.29 and found.max() <= 0.33
    two = beads(random={"count": 100}, radius={"sizes": [0.2, 0.5], "shares": [3, 1]})
    assert np.sum(radii(load_case(cube(two))) == 0.2) == 75


def test_a_spread_packing_fills_what_it_is_told():
    packed = beads(random={"volume_fraction": 0.3}, radius={"mean": 0.4, "deviation": 0.1})
    case = load_case(cube(packed))
    share = np.sum(4 / 3 * math.pi * radii(case) ** 3) / 1000.0
    # To half a sphere of the largest size.
    assert share == pytest.approx(0.3, abs=2 / 3 * math.pi * 0.7**3 / 1000)


def test_other_shapes_are_packed_by_the_balls_around_them():
    rods = {"shape": "capsule", "radius": 0.2, "length": 0.8}
    case = load_case(cube({**rods, "random": {"count": 80, "turned": True}}))
    x = positions(case)
    apart = x[:, None] - x
    apart -= 10 * np.round(apart / 10)
    away = np.linalg.norm(apart, axis=2)[~np.eye(80, dtype=bool)]
    assert away.min() >= 2 * 0.6
    turns = {particle.orientation.angle for particle in case.particles}
    assert len(turns) == 80


def test_a_packing_that_jams_is_given_up():
    # Equal spheres jam at random at .64: at .65 sliding is tried, and comes to rest too early.
    source = beads(random={"volume_fraction": 0.65}, radius=0.5)
    text = refusal(cube(source, side=4.0))
    assert text.startswith("particles.0.random.volume_fraction is 0.65; no room was found for ")


def test_csv_gives_each_body_its_own(tmp_path):
    text = (
        "\ufeffx, y, z, radius, density, vx, vy, vz, qw, qx, qy, qz\r\n"
        "# the first\r\n"
        "-3, 0, 0, .5, 2.5, 1, 0, 0, 1, 0, 0, 0\r\n\r\n"
        "3, 0, 1e-1, 0.25, 1.5, 0, 0, -1, 0.5, 0.5, -0.5, 0.5\r\n"
    )
    (tmp_path / "lists").mkdir()
    (tmp_path / "lists" / "beads.csv").write_text(text, encoding="utf-8")
    source = {"shape": "sphere", "csv": "lists/beads.csv", "motion": "free", "name": "bead"}
    case = small_case(source)
    case["profile"]["thickness"] = 0.1
    file = tmp_path / "case.toml"
    file.write_text(to_text(case), encoding="utf-8")
    first, second = load_case(file).particles
    assert (first.name, second.name) == ("bead 0", "bead 1")
    assert second.position == (3.0, 0.0, 0.1)
    assert (first.radius, second.radius, first.density) == (0.5, 0.25, 2.5)
    assert second.velocity.constant == (0.0, 0.0, -1.0)
    expected = rotations.matrix(np.array([0.5, 0.5, -0.5, 0.5]))
    # An axis and an angle in degrees, there and back.
    np.testing.assert_allclose(rotations.matrix(second.quaternion), expected, atol=1e-14)


def to_text(case):
    from smoothprofile.config.tomltext import document

    return document(case)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "beads.csv has nothing in it"),
        ("x,y,z\n", "beads.csv has a header and no bodies in it"),
        ("x,y\n1,2\n", "beads.csv line 1 has no column z; x, y, z come together"),
        ("x,y,z,vx\n1,2,3,4\n", "has no column vy; vx, vy, vz come together"),
        ("x,y,z,radus\n1,2,3,4\n", "line 1, column 4, is 'radus'; the nearest is radius"),
        ("x,y,z,x\n1,2,3,4\n", "line 1, column 4, is 'x'; another column has that name"),
        ("x,y,z\n1,2,3\n1,2\n", "line 3 has 2 fields and not 3 as its header, from column 3 on"),
        ("x,y,z\n1,2,3,4\n", "line 2 has 4 fields and not 3 as its header, from column 4 on"),
        ("x,y,z\n1,2,3\n1,two,3\n", "line 3, column y, is 'two'; it must be a finite number"),
        ("x,y,z\n1,,3\n", "line 2, column y, is ''; it must be"),
        ("x,y,z\n1,nan,3\n", "line 2, column y, is 'nan'; it must be"),
        ("x,y,z,radius\n1,2,3,0\n", "line 2, column radius, is 0; it must be above 0"),
        ("x,y,z,density\n1,2,3,-1\n", "line 2, column density, is -1; it must be above 0"),
        ("x,y,z,qw,qx,qy,qz\n1,2,3,0,0,0,0\n", "line 2, columns qw to qz, are all 0"),
        ('x,y,z\n1,2,"3\n', "line 2"),
        (b"x,y,z\n1,2,\xff\n", "beads.csv is not UTF-8 text at line 2"),
    ],
)
def test_csv_that_cannot_be_read_is_refused_by_line_and_column(
    text, expected, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    content = text if isinstance(text, bytes) else text.encode()
    (tmp_path / "beads.csv").write_bytes(content)
    assert expected in refusal(small_case(beads(csv="beads.csv")))


def test_files_lie_with_the_case_or_are_given_whole(tmp_path, monkeypatch):
    (tmp_path / "inner").mkdir()
    monkeypatch.chdir(tmp_path / "inner")
    outside = tmp_path / "beads.csv"
    outside.write_text("x,y,z\n1,1,1\n", encoding="utf-8")
    text = refusal(small_case(beads(csv="../beads.csv")))
    assert text.startswith('particles.0.csv is "../beads.csv"; it must lie in the folder of')
    assert len(load_case(small_case(beads(csv=str(outside)))).particles) == 1
    (tmp_path / "inner" / "link.csv").symlink_to(outside)
    assert "it must lie in the folder" in refusal(small_case(beads(csv="link.csv")))
    assert "none.csv does not exist; looked for " in refusal(small_case(beads(csv="none.csv")))
    assert "cannot be read" in refusal(small_case(beads(csv=str(tmp_path))))
    assert refusal(small_case(beads(csv=3))).startswith("particles.0.csv is 3; it must be")


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ({"lattice": {}}, "particles.1.lattice.counts is missing; a lattice needs counts"),
        ({"lattice": {"count": 3}}, "lattice.count is not a known key; the nearest is"),
        ({"lattice": {"counts": [0, 1, 1]}}, "lattice.counts is [0, 1, 1]; it must be three whole"),
        ({"lattice": {"counts": [1, 1, 1], "kind": "hcp"}}, '.kind is "hcp"; it must be "cubic"'),
        ({"lattice": {"spacing": 0}}, "lattice.spacing is 0; it must be a finite number above 0"),
        ({"lattice": {"spacing": 9}}, "lattice.spacing is [9.0, 9.0, 9.0]; it must fit"),
        ({"lattice": {"counts": [99, 99, 99]}}, "these are 970299 bodies, and a case has 100000"),
        ({"lattice": 3}, "particles.1.lattice is 3; it must be a table"),
        ({"lattice": {"spacing": 4}, "position": [0, 0, 0]}, "1.position is [0, 0, 0]; lattice"),
        ({"lattice": {"spacing": 4}, "csv": "a"}, 'particles.1.csv is "a"; lattice already'),
        ({"lattice": {"spacing": 4}, "radius": 0}, "particles.1.radius is 0; it must be a finite"),
        ({"lattice": {"spacing": 4}, "radius": []}, "particles.1.radius is []; it must be"),
        ({"lattice": {"spacing": 4}, "motion": "free"}, "particles.1.density is missing; a free"),
        ({"latice": {"spacing": 4}}, "particles.1.latice is not a known key; the nearest is"),
        ({"lattice": {"counts": [30, 3, 3]}}, "the body there overlaps particles."),
        ({"lattice": {"counts": [1, 1, 1]}}, "particles.1 (point 0).position is [0.0, 0.0, 0.0]"),
        ({"random": {}}, "particles.1.random.count is missing; a random packing needs"),
        ({"random": {"count": 3, "volume_fraction": 0.1}}, "random.count is 3; volume_fraction"),
        ({"random": {"count": 0}}, "particles.1.random.count is 0; it must be a whole number"),
        ({"random": {"volume_fraction": 0.8}}, "volume_fraction is 0.8; it must be a number above"),
        ({"random": {"volume_fraction": 0.7}}, "volume_fraction is 0.7; no room was found for "),
        ({"random": {"count": 99999}}, "random.count is 99999; no room was found for 99999"),
        ({"random": {"count": 5, "seed": -1}}, "random.seed is -1; it must be a whole number"),
        ({"random": {"count": 5, "gap": -1}}, "random.gap is -1; it must be a finite number"),
        ({"random": {"count": 1, "gap": 4}}, "random.count is 1; no room was found for 1 bod"),
        (
            {"random": {"count": 5, "box": {"low": [0, 0, 0], "high": [9, 1, 1]}}},
            "random.box.high is [9.0, 1.0, 1.0]; it must lie within the domain",
        ),
        (
            {"random": {"count": 5, "box": {"low": [0, 0, 0], "high": [1, 0, 1]}}},
            "random.box.high is [1.0, 0.0, 1.0]; each number must exceed",
        ),
        ({"random": {"count": 5}, "radius": {"mean": 1}}, "particles.1.radius.deviation is miss"),
        (
            {"random": {"count": 5}, "radius": {"mean": 1, "deviation": 0.1, "largest": 0.9}},
            "particles.1.radius.mean is 1.0; it must lie between 0.7 and 0.9",
        ),
        (
            {"random": {"count": 5}, "radius": {"mean": 1, "deviation": 1, "smallest": 5}},
            "particles.1.radius.smallest is 5.0; it must be below the largest, 4",
        ),
        # Drawn again and again until one falls between the ends, these would take for ever.
        (
            {"random": {"count": 5}, "radius": {"mean": 1, "deviation": 1e6, "largest": 1.1}},
            "particles.1.radius.deviation is 1000000.0; less than 1 % of what is drawn lies",
        ),
        (
            {
                "random": {"count": 5},
                "radius": {"kind": "lognormal", "mean": 1, "deviation": 1e9},
            },
            "particles.1.radius.deviation is 1000000000.0; less than 1 %",
        ),
        (
            {"random": {"count": 5}, "radius": {"sizes": [1], "shares": [1, 2]}},
            "particles.1.radius.shares is [1.0, 2.0]; it must be 1 number",
        ),
        (
            {"random": {"count": 5}, "shape": "cylinder"},
            'particles.1.shape is "cylinder"; bodies without an end',
        ),
        (
            {"random": {"count": 5}, "shape": "capsule", "length": 1, "radius": [0.1, 0.2]},
            "particles.1.radius is [0.1, 0.2]; bodies of a random packing may differ",
        ),
    ],
)
def test_sources_that_cannot_be_are_refused(source, expected):
    assert expected in refusal(small_case(sphere(), beads(**source)))


def test_sentences_call_bodies_by_their_places_in_the_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "beads.csv").write_text("x,y,z\n-4,0,0\n0,0,9\n", encoding="utf-8")
    text = refusal(small_case(sphere(), beads(csv="beads.csv")))
    assert text.startswith("particles.1 (beads.csv line 3).position is [0.0, 0.0, 9.0]; it must")
    first = beads(lattice={"counts": [2, 1, 1]})
    text = refusal(small_case(first, sphere(position=[2.5, 0, 0])))
    assert text.startswith("particles.1.position is [2.5")
    assert "overlaps particles.0 (point 1)" in text


def test_five_thousand_bodies_load_at_once():
    case = cube(beads(random={"count": 5000}, motion="free", density=2.0), side=12.0)
    load_case(case | {"particles": [beads(random={"count": 10})]})
    # Of this process alone, though what shares its memory slows it down to a fifth.
    start = time.process_time()
    loaded = load_case(case)
    # A second and a half on a machine of its own; with pairs compared one by one, minutes.
    assert time.process_time() - start < 15.0
    assert len(loaded.particles) == 5000
