"""The study of Mason numbers: its arithmetic, and all of it by hand."""

from importlib.resources import files

import numpy as np
import pytest

from smoothprofile.config import load_case
from smoothprofile.studies.mason import (
    CASE,
    COLUMNS,
    FACTOR,
    FIELDS,
    HEIGHT,
    RATE,
    averaged,
    fitted_slope,
    mason,
    run,
    slope,
)


def test_the_study_speaks_of_its_case():
    case = load_case(CASE, {})
    walls = case.fluid.wall_velocity.given()
    high, low = (walls[f"z_{side}"].at(0.0)[0] for side in ("high", "low"))
    assert (high - low) / case.domain.lengths[2] == pytest.approx(RATE)
    assert case.domain.lengths[2] == HEIGHT
    ratio = case.particles[0].permittivity / case.electric.permittivity
    assert 2.0 * ((ratio - 1.0) / (ratio + 2.0)) ** 2 == pytest.approx(FACTOR)
    field = case.electric.electrodes.high / HEIGHT
    told = (files("smoothprofile.cases") / f"{CASE}.toml").read_text(encoding="utf-8")
    assert f"is {mason(field):.2g} here" in told


def test_the_slope_is_that_of_what_the_field_adds():
    number = np.array([0.01, 1.0, 0.1, 100.0])
    # What is left of the field at Mn = 100 is a hundredth of what it adds at 1.
    assert slope({"Mn": number, "wall": 1.25 + 0.3 / number}) == pytest.approx(-1.0, abs=0.01)
    assert slope({"Mn": number, "wall": 1.25 + 0.3 / number**2}) == pytest.approx(-2.0, abs=0.01)


def made_up(power, noise):
    """Runs in which the field adds Mnᵖ/40 to a viscosity of 1.35, in some starts more or less."""
    return {
        (field, seed): dict.fromkeys(
            COLUMNS, RATE * (1.35 + (1.0 + noise * (seed - 2)) * mason(field) ** power / 40.0)
        )
        for field in FIELDS
        for seed in (1, 2, 3)
    }


@pytest.mark.parametrize("power", [-1.0, -1.5])
def test_starts_give_a_mean_and_its_error(power):
    # What the weakest field still adds is taken for none: less than .01 in the slope.
    assert fitted_slope(made_up(power, 0.0)) == pytest.approx((power, 0.0), abs=0.01)
    curve = averaged(made_up(-1.0, 0.1))
    row, added = FIELDS.index(1.3), mason(1.3) ** -1.0 / 40.0
    assert curve["wall"][row] == pytest.approx(1.35 + added, rel=1e-12)
    # Three starts at 0.9, 1 and 1.1 of it: σ = .1, over √3, less 2e-3 of the weakest field.
    assert curve["wall_error"][row] == pytest.approx(0.1 * added / np.sqrt(3.0), rel=0.01)
    assert curve["wall_error"][-1] == 0.0


@pytest.mark.slow
def test_the_viscosity_falls_as_one_over_mn():
    study = run()
    assert study.agrees
    curve = study.curves["viscosity"]
    falling = curve["wall"][np.argsort(curve["Mn"])]
    # The last two differ by less than the noise of one small box.
    assert np.all(np.diff(falling) < 0.03)
    assert all(picture.png for picture in study.pictures)
