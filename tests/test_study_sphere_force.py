"""The study of the force in a non-uniform field: both tables, and why they come out so."""

import numpy as np
import pytest

from smoothprofile.calibration import effective_radius
from smoothprofile.studies import study_named
from smoothprofile.studies.sphere_force import CORRECTIONS, TABLE_2, corrected, force
from smoothprofile.studies.study import NEW


@pytest.fixture(scope="module")
def study():
    return study_named("sphere-force")()


def test_every_number_agrees(study):
    assert study.agrees
    # 1 sharp, 4 of table 4.1, 2 Gauss spheres, 40 errors, 4 orders, 3 cured, 40 forces.
    assert len([row for row in study.rows if row.verdict != NEW]) == 94
    assert len(study.rows) == 94 + 1 + 8 + 3 + 10


@pytest.mark.parametrize(
    ("thickness", "known"), [(0.05, -0.0313), (0.10, -0.0743), (0.15, -0.1297), (0.20, -0.1981)]
)
def test_table_1(thickness, known):
    # The digits shown.
    assert round(force(thickness, "tanh", 1 + 5 * thickness).error, 4) == known


@pytest.mark.parametrize(
    ("correction", "known"),
    [
        (
            "uncorrected",
            (-1181, -1924, -2691, -3485, -4305, -5151, -6024, -6924, -7852, -8806),
        ),
        ("dipole", (-5, -13, -25, -42, -64, -92, -127, -168, -216, -272)),
        ("quadrupole", (118, 213, 324, 450, 589, 741, 904, 1076, 1255, 1440)),
        ("both", (-5, -13, -25, -42, -64, -92, -127, -168, -216, -272)),
    ],
)
def test_table_2(correction, known):
    # All five digits shown.
    found = [round(1e5 * corrected(thickness, correction).error) for thickness in TABLE_2]
    assert found == list(known)


@pytest.mark.parametrize(("profile", "gauss"), [("quartic", 1.06), ("sine", 1.4), ("tanh", 1.99)])
@pytest.mark.parametrize("ratio", [0.2, 2.0, 30.0])
def test_the_error_is_the_dipoles(profile, gauss, ratio):
    found = force(0.1, profile, gauss, ratio=ratio).error
    size = effective_radius(1, 0.1, ratio, profile, "arithmetic")
    # tanh is not quite uniform at r = ½, and not quite fluid at r = 1.99: φ = 5e-5 and 3e-9.
    tolerance = 1e-9 if profile != "tanh" else 3e-5
    assert found == pytest.approx(1 - size**3, abs=tolerance)


def test_the_quadrupoles_radius_plays_no_part():
    errors = [force(0.2, "quartic", 1.25, (0.98, painted)).error for painted in (0.9, 0.98, 1.1)]
    # Round-off of the same dipole three times.
    assert errors == pytest.approx([errors[0]] * 3, abs=1e-12)
    moved = force(0.2, "quartic", 1.25, (0.97, 0.98)).error
    assert abs(moved - errors[0]) > 0.02


def test_a_gauss_sphere_in_the_tail_of_tanh():
    # −1.0 % in place of −3.1 %, as known.
    assert round(100 * force(0.05, "tanh", 1.125).error, 1) == -1.0
    assert round(100 * force(0.05, "tanh", 1.25).error, 1) == -3.1


def test_figures_show_the_tables(study):
    assert len(study.pictures) == 4
    captions = " ".join(picture.caption for picture in study.pictures)
    for number in (11, 12, 14):
        assert f"figure 4.{number}" in captions
    columns = study.curves["error_against_thickness"]
    for name in CORRECTIONS:
        assert len(columns[name]) == len(columns[f"thesis_{name}"]) == 10
    # In the fluid the force is the same on every Gauss sphere.
    quartic = study.curves["gauss_quartic"]
    outside = quartic["error"][quartic["r"] > 1.1]
    assert np.ptp(outside) < 1e-10
    for picture in study.pictures:
        for axes in picture.figure.axes:
            assert axes.get_ylabel()
