"""The study of effective viscosity: the series that it leans on, and all of it by hand."""

import pytest

from smoothprofile.studies.viscosity import EXACT, lattice, run, series


def test_the_series_agrees_with_the_multipoles():
    # What it leaves out is of the order c^{10/3}: 1e-6 at c = .01, 1e-5 at .03.
    assert series(0.01, "xy") == pytest.approx(EXACT[0.01], abs=1e-6)
    assert series(0.03, "xy") == pytest.approx(EXACT[0.03], abs=1.1e-5)


@pytest.mark.parametrize("strain", ["xy", "xx"])
def test_the_series_begins_as_einsteins(strain):
    assert (series(1e-6, strain) - 1.0) / 1e-6 == pytest.approx(2.5, rel=1e-5)


def test_one_sphere_fills_the_fraction():
    side = lattice(0.05, 0.2, 32)["domain"]["lengths"][0]
    assert 4.18879 / side**3 == pytest.approx(0.05, rel=1e-5)


@pytest.mark.slow
def test_every_number_agrees():
    study = run()
    assert study.agrees
    assert {picture.name for picture in study.pictures} == {"effective-viscosity", "layer"}
    assert all(picture.png for picture in study.pictures)
