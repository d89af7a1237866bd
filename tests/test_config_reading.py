"""From names, files and overrides to cases and back; the built-in cases and their references."""

import math
import tomllib

import numpy as np
import pytest

from case_makers import refusal, small_case, sphere
from smoothprofile.cases import case_path, list_cases, reference
from smoothprofile.config import load_case
from smoothprofile.config.tomltext import document
from smoothprofile.errors import CaseError

NAMES = [entry.name for entry in list_cases()]


def full_case():
    """A case with something in every table."""
    held = {"shape": "box", "sides": [1, 2, 1], "position": [3, 0, 0]}
    held["orientation"] = {"axis": [0, 0, 2], "angle": 30}
    ball = {"shape": "sphere", "radius": 0.5, "position": [0, 0, 0.5]}
    rod = {"shape": "capsule", "radius": 0.4, "length": 1, "position": [0, 0, 0], "axis": [1, 1, 0]}
    moving = {"shape": "union", "parts": [ball, rod], "position": [0, 0, 0], "name": 'dumb "bell"'}
    moving["angular_velocity"] = {"amplitude": [1, 0, 0], "angular_frequency": 2, "phase": 0.1}
    case = small_case(held, moving)
    case["title"] = 'Tab\t, quote ", back\\slash, delete \x7f, Greek ξ and 𝜉'
    case["reference"] = "duct"
    faces = [-4, -3, -2, -1, 0, 1, 2, 3, 4]
    case["domain"]["stretching"] = ["uniform", {"focus": 0, "ratio": 2}, {"faces": faces}]
    case["fluid"]["mean_velocity"] = {"x": 1}
    case["fluid"]["wall_velocity"] = {"y_low": [1, 0, 0], "z_low": {"constant": [0, 1, 0]}}
    case["time"] |= {"step": 1e-3, "steady_tolerance": 1e-5, "max_steps": 7}
    case["start"] = [{"cells": [5, 4, 8], "thickness": 0.4, "end": 2}]
    case["output"] = {"lines": [{"name": "a", "axis": "x", "through": [0, 0]}], "fields": []}
    case["output"]["wall_line"] = {"wall": "z_high", "along": "y", "at": 1}
    return case


@pytest.mark.parametrize("name", NAMES)
def test_built_in_cases_survive_a_round_trip(name, tmp_path):
    case = load_case(name)
    file = tmp_path / "case.toml"
    file.write_text(case.to_toml(), encoding="utf-8")
    assert load_case(file) == case == load_case(str(case_path(name))) == load_case(case)
    spelled_out = tomllib.loads(case.to_toml())
    assert spelled_out["domain"]["precision"] == "double"
    assert spelled_out["output"]["every"] >= 1


def test_a_case_with_everything_survives_a_round_trip():
    case = load_case(full_case())
    again = load_case(tomllib.loads(case.to_toml()))
    assert again == case
    assert again.title == full_case()["title"]
    assert load_case(full_case(), {"time.max_steps": 8}) != case


def test_built_in_cases_agree_with_their_references():
    for entry in list_cases():
        assert entry.title and entry.description.endswith(".")
        assert entry.takes.startswith("about "), entry.name
        case = load_case(entry.name)
        if case.reference is None:
            continue
        known = reference(case.reference)
        assert {"title", "label", "source"} <= known.keys()
        assert set(known.get("lines", {})) <= {line.name for line in case.output.lines}
        assert ("wall_line" in known) <= (case.output.wall_line is not None)
        for curve in [*known.get("lines", {}).values(), *filter(None, [known.get("wall_line")])]:
            assert len(curve["coordinate"]) == len(curve["value"])
            assert np.all(np.diff(curve["coordinate"]) > 0)


def test_numbers_of_built_in_cases_are_those_of_their_comments():
    array = load_case("sphere-array").domain.lengths[0]
    assert 4 * math.pi / 3 / array**3 == pytest.approx(0.216, rel=1e-14)
    assert reference("sphere-array")["force"] == pytest.approx(6 * math.pi * 7.44195, rel=1e-5)
    assert math.pi / load_case("cylinder-array").domain.lengths[0] ** 2 == pytest.approx(0.1)
    layer = load_case("stokes-layer").fluid.wall_velocity.y_high
    depth = -3 / math.sqrt(2)
    for time in (0.0, 1.3):
        exact = math.exp(depth) * math.cos(time + depth)
        assert layer.at(time)[0] == pytest.approx(exact, rel=1e-14)
    duct = reference("duct")
    assert (duct["force"], duct["thesis"]["force"]) == (164.138, 145.46)
    assert load_case("duct").particles[0].position == (0.0, 0.0, 0.0)


def test_overrides_reach_everything():
    texts = [
        "time.end=2",
        "profile.thickness=.2",
        "particles.0.radius = 0.75",
        "domain.cells=[64, 23, 23]",
        "domain.lengths.0=21.0",
        "title=A bare = text",
        "fluid.mean_velocity.x=1e-3",
        'time.scheme="bdf2"',
    ]
    case = load_case("duct", texts)
    assert (case.time.end, case.profile.thickness, case.particles[0].radius) == (2.0, 0.2, 0.75)
    assert case.domain.cells == (64, 23, 23)
    assert case.domain.lengths == (21.0, 7.0, 7.0)
    assert (case.title, case.time.scheme) == ("A bare = text", "bdf2")
    assert case.fluid.mean_velocity.given() == {0: 0.001}
    assert load_case("duct", {"time.end": 2}).time.end == 2.0
    assert len(load_case("duct-thesis-fine").start) == 2
    assert load_case("duct-thesis-fine", ["start=[]"]).start == ()


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"title = \n", "not TOML at line 1, column 9"),
        (b"[domain]\n\n[domain]\n", "not TOML at line 3, column 8"),
        (b'a = 1\nb = "open', "not TOML at line 2, column 10"),
        (b"\x7fELF\x00", "not TOML at line 1, column 1"),
        (b'title = "ok"\nx = "\xc3\x28"', "not UTF-8 text at line 2, column 6"),
        (b"", "domain is missing"),
        (b"x = " + b"[" * 100_000, "too deeply"),
        (b"x = " + b"{a=" * 5_000, "too deeply"),
        (b"a." * 100_000 + b"a = 1", "too deeply"),
        (b"x = " + b"[" * 40 + b"]" * 40, "too deeply"),
        (b"x = " + b"9" * 5_000, "not TOML at line 1"),
        (b"x = 1\ny = [1, -.5]", "line 2, column 9: a number needs a digit before its point"),
        (b"#" * (64 * 2**20 + 1), "too large"),
    ],
)
def test_files_that_are_no_case_are_refused(content, expected, tmp_path):
    file = tmp_path / "case.toml"
    file.write_bytes(content)
    assert expected in refusal(file)


def test_sources_that_are_not_there_are_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "the nearest is duct" in refusal("ducct")
    assert "case.toml does not exist" in refusal("case.toml")
    assert "does not exist" in refusal(tmp_path / "none" / "case")
    assert "is a directory" in refusal(tmp_path)
    assert "cannot be read" in refusal("no\0name.toml")
    assert "not of type int" in refusal(3)
    with pytest.raises(CaseError, match="the nearest is duct"):
        reference("duc")


@pytest.mark.parametrize(
    ("override", "expected"),
    [
        ("foo", 'override "foo" must be written as table.key=value'),
        ("=3", 'override "=3" must be'),
        ("domain..cells=3", 'override "domain..cells=3" must be'),
        (".=3", 'override ".=3" must be'),
        ("\x1b[31m=3", r'"\u001b[31m" is not a known key'),
        ("x" * 500 + "=3", f'"{"x" * 68}… is not a known key'),
        ("particles.5.radius=1", "particles has 1 entry, counted from 0"),
        ("title.x=3", 'title is "Sphere held'),
        ("fluid.body_force.0=3", "sets no list fluid.body_force"),
        ("fluid.viscosity=1\ntitle = 'x'", "fluid.viscosity is "),
    ],
)
def test_overrides_that_do_not_fit_are_refused(override, expected):
    assert expected in refusal("duct", [override])


def test_numpy_values_are_numbers_and_odd_objects_are_not():
    case = small_case(sphere(position=np.zeros(3), radius=np.float32(0.5)))
    assert load_case(case).particles[0].radius == 0.5
    assert refusal(small_case(sphere(radius=object()))).startswith("particles.0.radius is ")
    assert "keys are texts" in refusal({3: 4})
    assert refusal(small_case() | {"title": "\ud800"}).startswith("title is ")


def test_toml_text_reads_back():
    table = {"a": [1, 2.5, True, "x\ty"], "b": {"c": {}, "d": [{"e": 1e-300}, {"e": [[]]}]}}
    again = tomllib.loads(document(table))
    assert again == {"a": table["a"], "b": {"d": table["b"]["d"]}}


def test_a_table_in_a_wrong_place_is_shown_on_one_line():
    text = refusal(small_case(sphere(shape={"\n": False})))
    assert text.startswith('particles.0.shape is { "\\n" = false }; it must be one of')


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[fluid]\ndensity = 1\ndensity = 2\n", "line 3, column 12: the key density is given"),
        ("fluid.density = 1\nfluid.density = [\n1]\n", "3, column 3: the key fluid.density is"),
        ("[fluid]\na = 1\n[fluid]\nb = 2\n", "line 3, column 7: the table [fluid] is given"),
        ("[a.b]\n[a.b]\n", "line 2, column 5: the table [a.b] is given"),
        ("a = { x = 1, x = 2 }\n", "line 1, column 19: the key x is given"),
    ],
)
def test_what_is_given_twice_is_named(tmp_path, text, told):
    (tmp_path / "case.toml").write_text(text)
    sentence = refusal(tmp_path / "case.toml")
    assert told in sentence and sentence.endswith(" twice.")
