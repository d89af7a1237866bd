"""Figures and report, made from a run directory that a fake simulation wrote."""

import io
import re
import shutil
from dataclasses import replace
from html.parser import HTMLParser

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.image import imread

from smoothprofile import report, webpage
from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.figures import PALETTE
from smoothprofile.output import RunDirectory
from smoothprofile.plots import pictures
from smoothprofile.runrecord import read_run
from test_output import CASE, FakeSimulation, write_run

REFERENCE = {
    "title": "A body-fitted solution",
    "label": "body-fitted",
    "source": "nowhere & <invented>",
    "force": 164.138,
    "mean_velocity": 4.41792,
    "centre_velocity": 0.0,
    "thesis": {
        "label": "thesis",
        "force": 145.46,
        "runs": [
            {"cells": [40, 14, 14], "thickness": 0.3, "step": 0.2, "force": 150.0},
            {"cells": [80, 28, 28], "thickness": 0.1, "step": 0.015, "centre_velocity": 0.16},
        ],
    },
    "lines": {
        "centreline": {"coordinate": [-10.0, -5.0, 2.0, 5.0], "value": [3.7, 3.7, 1.2, 3.2]},
        "somewhere else": {"coordinate": [0.0], "value": [1.0]},
    },
    "wall_line": {"coordinate": [-5.0, 0.5, 5.0], "value": [0.79, -0.70, 0.67]},
}

VOID = {"meta", "img"}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "run"
    write_run(path)
    return path


@pytest.fixture(scope="module")
def with_reference():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report.cases, "reference", {"duct": REFERENCE}.__getitem__, raising=False)
        yield


@pytest.fixture(scope="module")
def page(run, with_reference):
    return report.write_report(run).read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def drawn(run):
    return by_name(run)


class Checker(HTMLParser):
    """Collects what a page would load, and fails on a tag that is not closed in its turn."""

    def __init__(self, page: str):
        super().__init__()
        self.open, self.loads, self.text = [], [], []
        self.feed(page)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        if tag not in VOID:
            self.open.append(tag)
        self.loads += [v for k, v in attributes if k in ("src", "href") or tag == "link"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def labelled(figure):
    """Each curve of the first axes by its label in the legend."""
    handles, labels = figure.axes[0].get_legend_handles_labels()
    return dict(zip(labels, handles, strict=True))


def by_name(path, reference=REFERENCE):
    return {picture.name: picture for picture in pictures(read_run(path), reference)}


def test_every_figure_is_drawn_and_named(drawn):
    assert list(drawn) == [
        "plane",
        "force",
        "velocity-x-along-x",
        "velocity-x-along-y",
        "wall-shear",
        "convergence",
    ]


def test_axes_are_titled_and_carry_units(drawn):
    for picture in drawn.values():
        axes = picture.figure.axes[0]
        assert axes.get_title(loc="left")
        assert re.search(r"\((length|time)\)$", axes.get_xlabel())
        assert re.search(r"\(.*(length|time).*\)$", axes.get_ylabel())
        assert picture.figure.legends


def test_curves_hold_the_data_of_the_run(run, drawn):
    record = read_run(run)
    force = labelled(drawn["force"].figure)
    assert list(force) == ["Fx, sphere-1", "body-fitted"]
    expected = record.particles["sphere-1"]
    assert np.array_equal(force["Fx, sphere-1"].get_ydata(), expected["force_x"])
    assert list(force["body-fitted"].get_ydata()) == [164.138, 164.138]
    profile = labelled(drawn["velocity-x-along-y"].figure)["wake (x = 2, z = 0)"]
    assert np.array_equal(profile.get_xydata().T, record.lines["wake"])
    shear = labelled(drawn["wall-shear"].figure)["this run"]
    assert np.array_equal(shear.get_xydata().T, record.wall_shear)


def test_reference_curves_are_drawn_in_where_there_are_some(run, drawn):
    def points(picture):
        curves = [line for line in picture.figure.axes[0].lines if line.get_marker() == "o"]
        return [c.get_xydata().T.tolist() for c in curves if len(c.get_xdata())]

    known = REFERENCE["lines"]["centreline"]
    assert points(drawn["velocity-x-along-x"]) == [[known["coordinate"], known["value"]]]
    assert points(drawn["velocity-x-along-y"]) == []
    assert len(points(drawn["wall-shear"])) == 1
    assert points(by_name(run, {})["wall-shear"]) == []


def test_plane_is_the_right_way_up(drawn):
    """The particle is outlined where its indicator is a half: a circle of radius 1 at 0, 0."""
    axes = drawn["plane"].figure.axes[0]
    outline = axes.collections[-1].get_paths()[0].vertices
    radius = np.hypot(*outline.T)
    # Half a cell is .25; linear contouring of a smooth field keeps well within it.
    assert np.abs(radius - 1).max() < 0.1
    assert axes.get_xlabel() == "x (length)"
    assert axes.get_ylabel() == "y (length)"
    assert np.ptp(axes.get_xlim()) > 2 * np.ptp(axes.get_ylim())


def test_start_up_peak_does_not_flatten_the_force_and_is_told(drawn):
    axes = drawn["force"].figure.axes[0]
    peak = FakeSimulation().force
    assert axes.get_ylim()[1] < 0.6 * peak
    # The first row, at t = .05: 163.6 + 2000 exp(-.25).
    assert axes.get_title(loc="right") == "beyond the frame: 1721 at t = 0.05"
    assert not axes.texts


def test_nothing_is_cut_off(drawn):
    """The outermost pixels of each image are white, and it has about 150 dots to the inch."""
    for picture in drawn.values():
        image = imread(io.BytesIO(picture.png))[..., :3]
        edges = [image[0], image[-1], image[:, 0], image[:, -1]]
        assert all((edge == 1).all() for edge in edges), picture.name
        # The margin is trimmed or widened to fit: a tenth of the width at most.
        assert image.shape[1] == pytest.approx(150 * picture.figure.get_figwidth(), rel=0.1)


def test_many_particles_stay_legible(tmp_path):
    write_run(tmp_path / "run", steps=20, bodies=12)
    force = labelled(by_name(tmp_path / "run")["force"].figure)
    assert list(force) == ["Fx, each of 12 particles"]
    write_run(tmp_path / "few", steps=20, bodies=3)
    force = labelled(by_name(tmp_path / "few")["force"].figure)
    assert [to_hex(line.get_color()).upper() for line in force.values()] == list(PALETTE[:3])


def test_drawing_leaves_matplotlib_as_it_was(run):
    before = dict(matplotlib.rcParams)
    assert by_name(run)["convergence"].png
    assert dict(matplotlib.rcParams) == before


def test_report_is_one_file_that_loads_nothing(run, page, drawn):
    checker = Checker(page)
    assert len(checker.loads) == 6
    assert all(source.startswith("data:image/png;base64,") for source in checker.loads)
    assert "http" not in page.partition("<details>")[0]
    assert sorted(path.stem for path in (run / "figures").glob("*.png")) == sorted(drawn)


def test_a_figure_that_is_no_longer_drawn_goes(tmp_path):
    write_run(tmp_path / "run", steps=20, bodies=2)
    report.write_report(tmp_path / "run")
    figures = tmp_path / "run" / "figures"
    (figures / "mine.png").write_bytes(b"mine")
    assert (figures / "force.png").is_file()
    (tmp_path / "run" / "particles.csv").unlink()
    report.write_report(tmp_path / "run")
    # Its own figure goes with its data; one that somebody else put there stays.
    assert not (figures / "force.png").exists() and (figures / "mine.png").is_file()


def test_report_escapes_what_users_wrote(page):
    assert "<held>" not in page
    assert "A sphere &lt;held&gt; in a duct" in page
    assert "nowhere &amp; &lt;invented&gt;" in page


def test_report_shows_the_numbers(page):
    text = " ".join(Checker(page).text)
    for shown in (
        "163.6",
        "164.14",
        "−0.33 %",
        "145.46",
        "−11.38 %",
        "steady",
        "thin for this mesh",
        "(20, 7, 7)",
    ):
        assert shown in text
    assert 'name = "centreline"' in text


def test_report_is_rebuilt_from_the_directory_alone(run, page, tmp_path):
    shutil.copytree(run, tmp_path / "moved")
    (tmp_path / "moved" / "report.html").unlink()
    rebuilt = report.write_report(tmp_path / "moved").read_text(encoding="utf-8")
    assert rebuilt == page


def test_comparison_takes_the_largest_component_and_the_slip(run):
    body = {
        "force": [-150.0, 1.0, 0.0],
        "torque": [0.0, 0.0, 0.0],
        "velocity": [5.0, 0.0, 0.0],
        "interior_velocity": [5.0, 0.3, 0.4],
    }
    record = replace(read_run(run), summary={"bodies": [body]})
    assert report.comparison(record, REFERENCE) == [
        ("force", -150.0, 164.138, [145.46]),
        ("centre velocity", pytest.approx(0.5), 0.0, [0.16]),  # √(.3² + .4²), round-off
    ]
    assert report.comparison(replace(record, summary={}), REFERENCE) == []


def test_other_computations_are_matched_by_resolution(run):
    case = {"domain": {"cells": [40, 14, 14]}, "profile": {"thickness": 0.3}}
    record = replace(read_run(run), case=case, summary={"time_step": 0.2})
    assert report.other_computations(record, REFERENCE)["thesis"]["force"] == 150.0
    record = replace(record, summary={"time_step": 0.1})
    last = report.other_computations(record, REFERENCE)["thesis"]
    assert (last["force"], last["centre_velocity"]) == (145.46, 0.16)


def test_curve_difference_finds_the_largest_and_skips_what_is_outside():
    x = np.linspace(0.0, 2.0, 21)
    exact = {"coordinate": [-1.0, 0.45, 1.35, 3.0], "value": [9.0, 1.45, 2.35, -10.0]}
    points, largest, share = report.curve_difference((x, 1 + x + 0.1 * (x > 0.75)), exact)
    # Both curves are straight where they are compared: only round-off is left.
    assert (points, largest, share) == pytest.approx((2, 0.1, 0.01), abs=1e-12)
    assert report.curve_difference(None, exact) == (0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (163.6001, "163.6"),
        (-1.25e-7, "−1.25e−07"),
        (259200, "259\u202f200"),
        (None, "–"),
        ([1.0, -2.0, None], "(1, −2, –)"),
        ([163.3, 8e-15, -3e-8], "(163.3, 0, 0)"),
        ([2e-14, 0.0, -4e-13], "(2e−14, 0, −4e−13)"),
        ("auto", "auto"),
        (True, "True"),
    ],
)
def test_numbers_are_written_for_people(value, text):
    assert webpage.number(value) == text


def test_vectors_are_round_off_beside_larger_ones_of_their_kind():
    assert webpage.number([2e-14, 0.0, -4e-13], 1e-3) == "(0, 0, 0)"


def test_a_run_that_broke_off_still_has_a_report(tmp_path):
    case = CASE.replace('reference = "duct"\n', "").replace("centreline", "U$1$^")
    simulation = FakeSimulation(case)
    with pytest.raises(BlowUpError), RunDirectory(tmp_path / "run", case) as run:
        simulation.run(5, observer=run.record)
        simulation.history["change_rate"].append(np.nan)
        for name in ("step", "time", "mean_velocity"):
            simulation.history[name].append(simulation.history[name][-1])
        run.record(simulation)
        raise BlowUpError("velocity is NaN in cell (3, 4, 5) at t = 0.3.")
    page = report.write_report(tmp_path / "run").read_text(encoding="utf-8")
    assert len(Checker(page).loads) == 2  # force and convergence
    assert "blew up" in page
    assert "velocity is NaN in cell (3, 4, 5)" in page


def test_names_with_dollar_signs_are_drawn_as_they_stand(tmp_path):
    write_run(tmp_path / "run", CASE.replace('"centreline"', '"U$1$^"'), steps=3)
    assert by_name(tmp_path / "run")["velocity-x-along-x"].png.startswith(b"\x89PNG")


def test_only_a_run_directory_gets_a_report(tmp_path):
    with pytest.raises(CaseError, match=r"not a run directory"):
        report.write_report(tmp_path)
    assert list(tmp_path.iterdir()) == []
