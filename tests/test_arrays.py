"""ε_eff of square arrays of cylinders by Rayleigh's multipoles."""

import math

import numpy as np
import pytest

from smoothprofile.theory.arrays import square_array, square_sums


@pytest.mark.parametrize(("fraction", "exact"), [(0.1, 1.1782218), (0.3, 1.6520360)])
def test_known_values_to_all_digits(fraction, exact):
    assert round(square_array(10.0, fraction), 7) == exact


def test_lattice_sums():
    sums = square_sums(6)
    # Γ(1/4)⁸/(960π²); S_8 = 3S_4²/7 and S_12 = 18S_4³/143, identities of Weierstrass's ℘.
    fourth = math.gamma(0.25) ** 8 / (960 * math.pi**2)
    expected = [math.pi, fourth, 0.0, 3 * fourth**2 / 7, 0.0, 18 * fourth**3 / 143]
    # Round-off.
    assert sums == pytest.approx(expected, rel=1e-13, abs=1e-15)


def test_lattice_sums_are_sums():
    n = np.arange(-60, 61)
    points = (n[:, None] + 1j * n).ravel()
    points = points[points != 0]
    # What lies beyond 60: the first angular part that a square has, 60⁻⁶ at most.
    assert square_sums(4)[3] == pytest.approx((points**-8.0).sum().real, abs=1e-10)


@pytest.mark.parametrize("ratio", [2.0, 10.0, 1e3])
@pytest.mark.parametrize("fraction", [0.05, 0.3, 0.6])
def test_reciprocity(ratio, fraction):
    # Keller's theorem holds for the exact problem, and for each truncation of it: round-off.
    product = square_array(ratio, fraction) * square_array(1 / ratio, fraction)
    assert product == pytest.approx(1.0, abs=1e-12)


def test_few_cylinders_are_dipoles():
    # ε_eff = 1 + 2cβ/(1 − cβ), the next term 2cβ·3·(S_4 a⁴β)² of order c⁵.
    beta, c = 9 / 11, 0.01
    assert square_array(10.0, c) == pytest.approx(1 + 2 * c * beta / (1 - c * beta), abs=1e-9)


def test_multipoles_kept_are_enough():
    for ratio in (1e-6, 100.0, 1e6):
        # The neglected fall as (2a)⁴ per multipole, a = .36 of the spacing.
        few, many = (square_array(ratio, 0.4, count) for count in (20, 30))
        assert few == pytest.approx(many, abs=1e-14)


@pytest.mark.parametrize(("ratio", "fraction"), [(10.0, 0.8), (10.0, 0.0), (0.0, 0.2)])
def test_nonsense_is_refused(ratio, fraction):
    with pytest.raises(ValueError, match="it must"):
        square_array(ratio, fraction)
