"""The study of profiles: exact values, and that its recommendation follows from its numbers."""

import numpy as np
import pytest

from smoothprofile.calibration import dielectric_offset
from smoothprofile.shapes import cylinder
from smoothprofile.studies import profiles_curves, study_named
from smoothprofile.studies.profiles_curves import (
    CELLS,
    CHOSEN_WIDTH,
    RADIUS,
    RATIOS,
    WIDTHS,
    cylinder_errors,
    depolarisation,
    energies,
    layer_width,
    one_thread,
    spheroid_errors,
    theory_error,
)
from smoothprofile.studies.study import NEW
from smoothprofile.theory.arrays import square_array
from smoothprofile.threads import thread_count


def test_widths_of_layers():
    # artanh(.8)·2 and 2·arcsin(.8)/π; brentq's 2e-12.
    assert layer_width("tanh") == pytest.approx(2 * np.arctanh(0.8), abs=1e-11)
    assert layer_width("sine") == pytest.approx(2 * np.arcsin(0.8) / np.pi, abs=1e-11)
    assert layer_width("quartic") == pytest.approx(layer_width("quartic-centred"), abs=1e-11)
    assert layer_width("quartic") == pytest.approx(0.600, abs=5e-4)


def test_depolarisation_factors():
    assert depolarisation(2.0) == pytest.approx((0.1735640, 0.4132180), abs=5e-8)


def test_tanh_is_one_whatever_the_isotropic_mean_once_retracted():
    for ratio in (0.1, 10.0):
        found = [theory_error(2, ratio, "tanh", mean, True) for mean in ("arithmetic", "harmonic")]
        # The same ε, painted at radii found to 1e-11.
        assert found[0] == pytest.approx(found[1], abs=1e-9)
    assert theory_error(1, 10.0, "sine", "tensor", True) == pytest.approx(0.0, abs=1e-10)


def test_retraction_leaves_a_tenth_of_the_error_of_cylinders():
    with one_thread():
        painted, _ = cylinder_errors(10.0, "tanh", CHOSEN_WIDTH, False)
        retracted, holding = cylinder_errors(10.0, "tanh", CHOSEN_WIDTH, True)
        _, sine_holding = cylinder_errors(10.0, "sine", CHOSEN_WIDTH, True)
    # .36 and .029 %; a retraction of the wrong sign or size would not take 10/11 of it.
    assert painted == pytest.approx(3.63e-3, abs=1e-5)
    assert abs(retracted) < 3.5e-4
    assert holding < 0.1 < 0.3 < sine_holding


def test_the_iteration_leaves_the_least_holding_forces_as_they_are(monkeypatch):
    """They are 1e-5 of the energy, which the residual enters squared, ten times it at R = 100."""
    with one_thread():
        _, found = cylinder_errors(100.0, "tanh", WIDTHS[-1], False)
        monkeypatch.setattr(profiles_curves, "TOLERANCE", 1e-10)
        _, exact = cylinder_errors(100.0, "tanh", WIDTHS[-1], False)
    # 1e-5 of it is left; with a tolerance of 1e-3 it is 45 % off.
    assert found == pytest.approx(exact, rel=1e-3)


def test_positions_between_grid_points_are_told_by_one_a_quarter_off():
    """The first harmonic is zero there, so that one position is as good as the mean of four."""
    moved = dielectric_offset(RADIUS, 0.75 / CELLS, 2.0, "tanh", "tensor")[1] / RADIUS
    places = np.array([[0.25, 0.25, 0], [0, 0, 0], [0.5, 0, 0], [0, 0.5, 0], [0.5, 0.5, 0]])
    with one_thread():
        one, *four = energies(
            *(cylinder(RADIUS), (moved, 0.0), (CELLS, CELLS, 1)),
            *((2.0, "tanh", 0.75, "tensor"), places),
        )
    # The second harmonic of tanh is e^(−π²ξ/Δx) of the first.
    assert abs(one - np.mean(four)) < 0.05 * np.ptp(four)
    assert one == pytest.approx(square_array(2.0, np.pi * RADIUS**2), rel=5e-5)


def test_the_number_of_threads_is_given_back():
    before = thread_count()
    with pytest.raises(ZeroDivisionError), one_thread():
        assert thread_count() == 1
        raise ZeroDivisionError
    assert thread_count() == before


@pytest.mark.slow
def test_the_harmonic_mean_is_for_spheres_alone():
    tensor, harmonic = spheroid_errors(10.0, "tensor"), spheroid_errors(10.0, "harmonic")
    # 2e-3 of them is the exact value's own error.
    assert max(np.abs(tensor)) < 0.015
    assert harmonic[0] < -0.07 and harmonic[1] > 0.02


@pytest.mark.slow
def test_the_study():
    study = study_named("profiles")()
    assert study.agrees
    # 3 exact values; 4 lattices with each of 3 retracted layers.
    assert len([row for row in study.rows if row.verdict != NEW]) == 15
    assert study.pictures[0].name == "recommendation"
    for picture in study.pictures:
        for axes in picture.figure.axes:
            assert axes.get_title(loc="left") and axes.get_xlabel() and axes.get_ylabel()
    for columns in study.curves.values():
        assert len({len(values) for values in columns.values()}) == 1
    at = WIDTHS.index(CHOSEN_WIDTH)
    tanh, sine, quartic = (
        study.curves[f"cylinders_{name}"] for name in ("tanh", "sine", "quartic-centred")
    )
    # The recommendation: least in both measures, over every R.
    for name, allowed in (("retracted_worst", 3.1e-3), ("retracted_hold_worst", 0.15)):
        assert tanh[name][at] < allowed
        assert tanh[name][at] < 0.6 * min(sine[name].min(), quartic[name].min())
    for ratio in RATIOS:
        gain = tanh[f"painted_R{ratio:g}"][at] / tanh[f"retracted_R{ratio:g}"][at]
        assert gain > 4
