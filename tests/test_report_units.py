"""What a report says of the units of its numbers, and of places outside the box."""

from dataclasses import replace

from smoothprofile import report
from smoothprofile.labels import in_units
from smoothprofile.plots import pictures
from smoothprofile.runrecord import read_run
from test_output import CASE, write_run


def test_what_1_means_stands_under_the_title_and_in_the_axes(tmp_path):
    units = '[units]\nlength = "20 um"\ntime = "1 ms"\ndensity = "1 g/cm^3"\n'
    write_run(tmp_path / "run", f"{CASE}\n{units}", steps=20)
    text = report.write_report(tmp_path / "run").read_text(encoding="utf-8")
    header = text[text.index("<header>") : text.index("</header>")]
    assert "1 means 20 um, 1 ms, 1 g/cm^3<" in header
    drawn = {p.name: p for p in pictures(read_run(tmp_path / "run"))}
    axes = drawn["velocity-x-along-x"].figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (20 um)", "ux (20 um/ms)")
    bar = drawn["plane"].figure.axes[1]
    assert bar.get_ylabel() == "speed |u| (20 um/ms)"
    # A force is no product of these that could be read.
    assert drawn["force"].figure.axes[0].get_ylabel() == "force (mass·length/time²)"


def test_rates_are_named_in_units():
    assert in_units("Ω (1/time)", {"length": "1 m", "time": "10 ms"}) == "Ω (1/(10 ms))"
    assert in_units("Ω (1/time)", {"length": "1 m", "time": "1 ms"}) == "Ω (1/ms)"
    assert in_units("ux (length/time)", {"length": "1 m", "time": "1 s"}) == "ux (m/s)"
    assert in_units("ux (length/time)", {}) == "ux (length/time)"


def test_places_past_a_periodic_side_are_told(tmp_path):
    write_run(tmp_path / "run", steps=3)
    record = read_run(tmp_path / "run")
    assert "1 means" not in report.page(record, [], {})
    told = "go on past periodic sides"
    body = {"name": "bead", "position": [0.0, 0.0, None]}
    inside = replace(record, summary={"bodies": [body]})
    outside = replace(record, summary={"bodies": [body, body | {"position": [21.0, 0.0, 0.0]}]})
    assert told not in report.page(inside, [], {}) and told in report.page(outside, [], {})
