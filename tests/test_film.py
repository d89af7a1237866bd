"""Films of run directories, and figures of chains, from a short run of three beads."""

import gsd.hoomd
import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import smoothprofile as sp
from smoothprofile import film
from smoothprofile.cli import app
from smoothprofile.csvtables import number_columns, read_table
from smoothprofile.errors import CaseError
from smoothprofile.output import RunDirectory
from smoothprofile.plots import pictures
from smoothprofile.runrecord import read_run
from smoothprofile.structure import Beads, measures


def three_beads():
    """Two beads behind one another along the field, and one apart."""
    places = ([3.1, 3.1, 1.6], [3.1, 3.1, 3.7], [6.6, 6.6, 6.1])
    return {
        "title": "Three beads",
        "domain": {"lengths": [8.0] * 3, "cells": [16] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {"density": 1.0, "viscosity": 1.0},
        "electric": {"field": [0.0, 0.0, 1.0]},
        "contact": {"range": 0.1},
        "profile": {"kind": "quartic-centred", "thickness": 0.7},
        "particles": [
            {
                "shape": "sphere",
                "radius": 1.0,
                "position": place,
                "motion": "free",
                "density": 1.0,
                "permittivity": 5.0,
            }
            for place in places
        ],
        "time": {"step": 0.1, "end": 0.4},
    }


@pytest.fixture(scope="module")
def chained(tmp_path_factory):
    """A run directory of three beads after four steps."""
    path = tmp_path_factory.mktemp("film") / "run"
    run = sp.Simulation.from_file(three_beads())
    with RunDirectory(path, run.case.to_toml()) as directory:
        run.run(directory.record)
        directory.finish(run)
    return path, run


def test_a_run_records_its_chains(chained):
    path, run = chained
    record = read_run(path)
    assert record.history["mean_chain_length"].tolist() == pytest.approx([1.5] * 4)
    assert record.history["longest_chain"][-1] == 2
    assert record.history["alignment"][-1] == pytest.approx(1.0, abs=1e-6)
    places = run.bodies.state.position
    beads = Beads(places, np.ones(3), np.zeros(3), np.full(3, 8.0), np.full(3, True))
    gap = measures(beads, (0, 0, 1))["smallest_gap"]
    assert record.summary["smallest_gap"] == pytest.approx(gap)
    table = number_columns(read_table(path / "structure.csv"))
    assert list(table) == ["r", "g", "g_along", "g_across"]
    # One pair at 2.1, along the field.
    peak = table["r"][np.flatnonzero(table["g_along"])]
    assert len(peak) and abs(peak[0] - 2.1) < 0.1


def test_the_report_shows_chains(chained):
    names = [picture.name for picture in pictures(read_run(chained[0]))]
    assert {"beads", "chains", "field-energy", "pairs"} <= set(names)
    assert "wall-stress" not in names


def test_a_film_has_a_frame_for_each_of_the_trajectory(chained, tmp_path):
    path = film.write_film(chained[0], tmp_path / "beads.gif")
    with Image.open(path) as image:
        assert image.n_frames == 4
        first = np.asarray(image.convert("RGB")).astype(int)
    # Chained beads are coloured, the lone one is grey, and most of the picture is white.
    colourful = (first.max(axis=2) - first.min(axis=2) > 60).mean()
    assert 0.01 < colourful < 0.3 and (first.min(axis=2) > 250).mean() > 0.4


@pytest.mark.skipif(not film.has_encoder(), reason="imageio-ffmpeg is not installed")
def test_a_film_is_mp4_where_it_can_be(chained, tmp_path):
    result = CliRunner().invoke(app, ["film", str(chained[0]), "--json"])
    assert result.exit_code == 0, result.output
    data = (chained[0] / "film.mp4").read_bytes()
    assert data[4:8] == b"ftyp" and len(data) > 5000


def test_films_are_refused_in_one_sentence(chained, tmp_path, monkeypatch):
    with pytest.raises(CaseError, match=r"film\.avi must end in \.mp4 or \.gif\.$"):
        film.write_film(chained[0], tmp_path / "film.avi")
    with pytest.raises(CaseError, match="is not a run directory"):
        film.write_film(tmp_path)
    with pytest.raises(CaseError, match=r"cannot be written: there is no directory \S+nowhere\.$"):
        film.write_film(chained[0], tmp_path / "nowhere" / "film.gif")
    monkeypatch.setattr(film, "has_encoder", lambda: False)
    with pytest.raises(CaseError, match="needs imageio-ffmpeg"):
        film.write_film(chained[0], tmp_path / "film.mp4")
    still = tmp_path / "still"
    still.mkdir()
    (still / "case.toml").write_text((chained[0] / "case.toml").read_text())
    with pytest.raises(CaseError, match="no body of its case moves"):
        film.write_film(still)
    (still / "trajectory.gsd").write_bytes(b"nothing")
    with pytest.raises(CaseError, match="damaged"):
        film.write_film(still)
    with gsd.hoomd.open(str(still / "trajectory.gsd"), mode="w") as empty:
        empty.append(gsd.hoomd.Frame())
    with pytest.raises(CaseError, match=r"trajectory\.gsd"):
        film.write_film(still)
