"""Whatever is given as a case: a case, or one sentence, soon."""

import random
import re

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from case_makers import small_case, sphere
from refusals import sentence_of
from restarts import run_stopping
from smoothprofile.cases import case_path, list_cases
from smoothprofile.config import load_case
from smoothprofile.errors import CaseError

TEXTS = [case_path(entry.name).read_text(encoding="utf-8") for entry in list_cases()]
NASTY = (
    "nan", "-inf", "0", "-1", "1e308", "-1e-308", "1e999", "9" * 400, "0x7fffffffffffffff", "true",
    '""', '"../x"', '"/etc/passwd"', r'"\u0000"', r'"\ud800"', '"ξ𝜉"', "[]", "{}", "[[]]", "[nan]",
    "1979-05-27", "07:32:00", "[1, [2, [3]]]", "{a = {b = {}}}", "[" + "0," * 3000 + "]", "''",
    '"' + "x" * 5000 + '"', "{ count = 1000000, seed = 1 }", "{ file = '../x.csv' }",
    "[1e300, 1, 1]",
    "{ lattice = 'fcc' }", "2147483648", "-9223372036854775808", "1_000", "+.5", "[true, 1, 2]",
)  # fmt: skip
VALUE = re.compile(r"(?<== )[^#\n]+")
NUMBER = re.compile(r"-?\d+\.?\d*(e-?\d+)?")
KEY = re.compile(r"^[\[ ]*[\w.]+", re.MULTILINE)


def mutated(text: str, choose: random.Random) -> str:
    """The text of a case with one to four things wrong, or merely otherwise."""
    for _ in range(choose.choice((1, 1, 2, 4))):
        kind = choose.randrange(8)
        places = list((VALUE, NUMBER, KEY)[kind % 3].finditer(text)) if kind < 4 else []
        lines = text.split("\n")
        if places:
            place = choose.choice(places)
            new = choose.choice(NASTY) if kind < 3 else place.group() + choose.choice("0e-.x\"'")
            text = text[: place.start()] + new + text[place.end() :]
        elif kind == 4:
            at = choose.randrange(len(text) + 1)
            text = (
                text[:at]
                + chr(choose.choice((0, 9, 10, 34, 91, 93, 123, 0x3BE, 0x202E)))
                + text[at:]
            )
        elif kind == 5:
            del lines[choose.randrange(len(lines))]
            text = "\n".join(lines)
        elif kind == 6:
            lines.insert(choose.randrange(len(lines)), choose.choice(lines))
            text = "\n".join(lines)
        else:
            text += "\n" + choose.choice(choose.choice(TEXTS).split("\n"))
    return text


def assert_case_or_sentence(source) -> bool:
    """Whether it was refused."""
    sentence = sentence_of(lambda: load_case(source))
    assert sentence is None or (sentence.endswith(".") and len(sentence) < 2000), sentence
    return sentence is not None


def fuzz(tmp_path, count: int, seed: int) -> int:
    """How many of `count` mutated cases are refused; none does anything else but run."""
    choose, file, refused = random.Random(seed), tmp_path / "case.toml", 0
    short = [text for text in TEXTS if len(text) < 4000]
    for _ in range(count):
        text = mutated(choose.choice(short), choose)
        file.write_bytes(text.encode("utf-8", "surrogatepass"))
        try:
            refused += assert_case_or_sentence(file)
        except Exception:
            print(text)
            raise
    return refused


def test_mutated_cases_are_cases_or_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # Most mutations break something; some must not, or the rules are never reached.
    assert 500 < fuzz(tmp_path, 1000, 1) < 980


@pytest.mark.slow
def test_fifty_thousand_mutated_cases_are_cases_or_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert fuzz(tmp_path, 50_000, 2) > 25_000


LEAVES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["sphere", "free", "held", "tanh", "auto", "../x", "x", "wall", b"bytes", 1j])
)
VALUES = st.recursive(
    LEAVES,
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=3)
    ),
    max_leaves=8,
)
TABLES = {
    "domain": ("lengths", "cells", "origin", "boundaries", "stretching", "precision"),
    "fluid": ("density", "viscosity", "gravity", "body_force", "mean_velocity", "wall_velocity"),
    "profile": ("kind", "thickness", "retract"),
    "time": ("step", "end", "scheme", "coupling", "steady_tolerance", "max_steps"),
    "output": (
        "every",
        "fields",
        "fields_every",
        "checkpoint_every",
        "plane",
        "lines",
        "wall_line",
    ),
    "electric": ("field", "permittivity", "every", "tolerance", "electrodes"),
    "contact": ("range", "friction", "restitution", "lubrication"),
    "particles": ("shape", "radius", "position", "motion", "density", "name", "source", "parts"),
    "start": ("cells", "thickness", "end"),
}


@settings(
    max_examples=150, derandomize=True, deadline=None, suppress_health_check=list(HealthCheck)
)
@given(st.data())
def test_any_value_at_any_key_is_taken_or_refused(data):
    case = small_case(sphere())
    for _ in range(data.draw(st.integers(1, 3))):
        table = data.draw(st.sampled_from(sorted(TABLES)))
        key, value = data.draw(st.sampled_from(TABLES[table])), data.draw(VALUES)
        place = case.setdefault(table, {})
        if isinstance(place, list):
            place.append({key: value})
        elif data.draw(st.booleans()) or not isinstance(place, dict):
            case[table] = value
        else:
            case[table] = {**place, key: value}
    assert_case_or_sentence(case)


@pytest.mark.parametrize("trick", ["../x", "/tmp/x", "..", "a/b", "\\..\\x", "x\nname", "CON", " "])
def test_names_lead_nowhere(tmp_path, trick):
    """Names of bodies and lines are words in tables: no file is called after them."""
    case = small_case(sphere(name=trick, motion="free", density=2.0))
    case["output"] = {"lines": [{"name": trick, "axis": "x", "through": [2.0, 2.0]}]}
    case["time"] = {"step": 0.05, "end": 0.1}
    (tmp_path / "inner").mkdir()
    try:
        run_stopping(case, tmp_path / "inner" / "run")
    except CaseError as error:
        assert "name" in str(error)
    assert [entry.name for entry in tmp_path.iterdir()] == ["inner"]
    assert {entry.name for entry in (tmp_path / "inner").iterdir()} <= {"run"}


@pytest.mark.parametrize("name", ["../x", "/etc/passwd", "..", "duct/../duct", "duct.json", "\0"])
def test_references_are_names_and_no_paths(name):
    with pytest.raises(CaseError, match=r"reference|UTF-8"):
        load_case("duct", {"reference": name})
