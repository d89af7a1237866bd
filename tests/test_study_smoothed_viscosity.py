"""The study of smoothed viscosity: what it leans on, and all of it by hand."""

import pytest

from smoothprofile.studies.smoothed_viscosity import run
from smoothprofile.studies.smoothed_viscosity_curves import (
    EXACT,
    constrained_drag,
    dilute_exact,
    lattice_drag,
)


def test_the_series_of_drops_is_that_of_rigid_spheres():
    # Multipole series, six digits.
    assert dilute_exact(1e9) == pytest.approx(1.024813, abs=1e-6)
    # Drops of the fluid are none, bubbles that change their shape make it thinner.
    assert dilute_exact(1.0) == 1.0 and dilute_exact(0.0) < 1.0


def test_both_solvers_find_one_drag():
    # c = .064, 24³: .2 % by imposing rigid motion, 1.7 % by μ with ξ = .2a.
    assert constrained_drag(24).value == pytest.approx(EXACT, rel=0.005)
    found = lattice_drag(1000.0, 0.2, 24, "harmonic", "drag")
    assert found.value == pytest.approx(EXACT, rel=0.02) and found.iterations < 25


@pytest.mark.slow
def test_every_number_agrees():
    study = run()
    assert study.agrees
    assert {p.name for p in study.pictures} == {"drag", "lone-sphere", "effective-viscosity"}
    assert all(picture.png for picture in study.pictures)
