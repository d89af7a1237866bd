"""What a run needs of disk and time, as told before it starts."""

import shutil
from types import SimpleNamespace

import pytest

from case_makers import small_case, sphere
from smoothprofile import needs
from smoothprofile.config import load_case
from smoothprofile.runs import run_of


def rows_of(**tables):
    """The checks of a small case by name, steps .01 unless told; tables change its own."""
    case = small_case(sphere(), boundaries=["periodic"] * 3)
    case["time"]["step"] = 0.01
    for name, changes in tables.items():
        case[name] = case.get(name, {}) | changes
    return {row["name"]: row for row in run_of(load_case(case)).preflight()}


def disk(**tables):
    return rows_of(**tables)["disk (GiB)"]


def test_snapshots_are_one_a_step_at_most_and_none_without_fields():
    # 640 cells of one field in single precision.
    one = 640 * 4 / 2**30
    often = {"fields": ["pressure"], "fields_every": 1e-9}
    assert disk(output={"fields": ["pressure"]})["value"] == one
    assert disk(output=often | {"fields_every": 0.25})["value"] == 5 * one
    found = disk(output=often, time={"end": 0.1})
    assert found["value"] == 11 * one and found["note"].startswith("11 snapshots")
    assert disk(output=often, time={"max_steps": 4})["value"] == 5 * one
    assert disk(output=often | {"fields": []})["value"] == 0.0


def test_a_stokes_flow_in_which_nothing_moves_has_one_snapshot():
    still = {"fluid": {"flow": "stokes", "mean_velocity": {"x": 1.0, "y": 0.0, "z": 0.0}}}
    fields = {"fields": ["pressure"], "fields_every": 1e-9}
    case = small_case(sphere(), boundaries=["periodic"] * 3)
    case["fluid"] |= still["fluid"]
    rows = run_of(load_case(case | {"output": fields})).preflight()
    assert next(r for r in rows if r["name"] == "disk (GiB)")["note"].startswith("1 snapshot,")


def test_fields_larger_than_the_free_disk_are_a_warning(monkeypatch):
    plenty = disk()
    assert plenty["verdict"] == "ok" and plenty["limit"] > plenty["value"]
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1000))
    scarce = disk()
    assert scarce["verdict"] == "warn" and scarce["limit"] == 1000 / 2**30
    assert "output.fields_every" in scarce["note"]


@pytest.mark.parametrize(
    ("seconds", "verdict", "words"),
    [
        (3600.0, "ok", "steps"),
        (2 * 86400.0, "ok", "2 days; steps"),
        (31 * 86400.0, "warn", "31 days; steps"),
        (3e9, "warn", "95.1 years; steps"),
    ],
)
def test_a_run_of_more_than_thirty_days_is_a_warning(seconds, verdict, words):
    row = needs.time_check(seconds, "steps")
    assert (row["verdict"], row["note"], row["value"]) == (verdict, words, seconds)


def test_both_kinds_of_flow_tell_days_and_years():
    ages, moving = {"end": 1e12}, [1e-13, 0.0, 0.0]
    for flow in ("inertial", "stokes"):
        case = small_case(sphere(velocity=moving), boundaries=["periodic"] * 3)
        case["fluid"]["flow"] = flow
        case["time"] = ages | {"step": 0.01}
        row = next(r for r in run_of(load_case(case)).preflight() if r["name"] == "time (s)")
        assert row["verdict"] == "warn" and "years; " in row["note"]
