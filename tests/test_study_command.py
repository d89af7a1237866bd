"""`spm study`: what it lists, refuses, prints and writes."""

import csv
import json

import numpy as np
import pytest

from smoothprofile import studies
from smoothprofile.figures import Picture, drawing, new_figure
from smoothprofile.studies.study import DIFFERS, NEW, Row, Study


def small(ours):
    """A study of three rows, one curve and one figure."""
    with drawing():
        figure, axes = new_figure(2.0)
        axes.plot([0.0, 1.0], [0.0, 1.0])
    rows = [
        Row("a & b", 1.0, 1.5, ours, 0.05, "the thesis' is wrong <so>"),
        Row("c", "figure", None, 2.0, 0.0),
        Row("d", None, 3.0, 3.0, 0.0),
    ]
    curve = {"line": {"x": np.array([0.0, 1.0]), "y": np.array([0.0, 0.5])}}
    pictures = [Picture("line", "A line.", figure)]
    return Study("A study", "somewhere", "Of lines.", ["It is one."], rows, curve, pictures)


@pytest.fixture
def found(monkeypatch):
    """Sets what every study finds."""

    def find(ours):
        monkeypatch.setattr(studies, "study_named", lambda name: lambda: small(ours))

    return find


def test_verdicts():
    rows = small(1.7).rows
    assert [row.verdict for row in rows] == [DIFFERS, NEW, "agrees"]
    assert rows[0].difference == pytest.approx(0.2)
    assert not small(1.7).agrees
    assert small(1.54).agrees


def test_studies_are_listed(spm):
    code, out, _ = spm("study", "list", "--json")
    assert code == 0
    entries = json.loads(out)["studies"]
    assert [entry["name"] for entry in entries] == list(studies.STUDIES) == list(studies.TAKES)
    assert all(entry["takes"].startswith(("about ", "some ")) for entry in entries)


def test_every_study_has_its_file():
    for name in studies.STUDIES:
        assert callable(studies.study_named(name))


def test_an_unknown_study_is_refused(spm):
    code, out, err = spm("study", "cuoette")
    assert (code, out) == (2, "")
    assert err == 'no study is called "cuoette"; the nearest is couette.\n'
    assert "there are couette, stokes-layer" in spm("study", "xyz")[2]


def test_a_study_is_written_whole(spm, found, tmp_path):
    found(1.54)
    where = tmp_path / "here"
    code, out, err = spm("study", "couette", "--out", where)
    assert code == 0
    assert "agrees" in out and "It is one." in err and "the thesis has 1" in err
    names = {str(path.relative_to(where)) for path in where.rglob("*") if path.is_file()}
    assert names == {"table.csv", "line.csv", "study.json", "report.html", "figures/line.png"}
    with (where / "table.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert table[0]["verdict"] == "agrees" and float(table[0]["ours"]) == 1.54
    page = (where / "report.html").read_text(encoding="utf-8")
    assert "2 of 2 numbers agree" in page and "a &amp; b" in page and "&lt;so&gt;" in page


def test_a_number_that_differs_is_told_by_the_exit_code(spm, found, tmp_path):
    found(1.7)
    code, out, err = spm("study", "couette", "--out", tmp_path / "here", "--json")
    assert code == 3
    assert json.loads(out)["table"][0]["verdict"] == "differs"
    assert "differ" in err


def test_nothing_is_overwritten(spm, found, tmp_path):
    found(1.54)
    code, _, err = spm("study", "couette", "--out", tmp_path)
    assert code == 2
    assert "nothing was overwritten" in err


def test_a_study_begins_where_it_can_be_written_and_leaves_nothing_if_it_fails(
    spm, tmp_path, monkeypatch
):
    """Minutes of work must not end at a folder that cannot be made."""
    where, began = tmp_path / "here", []

    def failing():
        began.append(where.is_dir())
        raise KeyboardInterrupt

    monkeypatch.setattr(studies, "study_named", lambda name: failing)
    assert spm("study", "couette", "--out", where)[0] == 4
    assert began == [True] and not where.exists()


def test_all_studies_have_a_folder_each(spm, found, tmp_path):
    found(1.54)
    code, out, _ = spm("study", "all", "--out", tmp_path / "all", "--json")
    runnable = {name for name in studies.STUDIES if studies.can_run(name)}
    assert code == 0
    assert len(json.loads(out)["studies"]) == len(runnable)
    assert {path.name for path in (tmp_path / "all").iterdir()} == runnable


def test_a_study_whose_needs_are_missing_is_left_out_of_all(spm, found, tmp_path, monkeypatch):
    found(1.54)
    monkeypatch.setattr(studies, "can_run", lambda name: name not in studies.NEEDS)
    code, out, err = spm("study", "all", "--out", tmp_path / "all", "--json")
    assert code == 0
    assert "dns is left out: it needs ngsolve, which is not installed.\n" in err
    assert len(json.loads(out)["studies"]) == len(studies.STUDIES) - len(studies.NEEDS)
