"""Indicator functions: their definitions, their symmetries, and kernel against array form."""

import numpy as np
import pytest
from numba import njit, prange
from scipy.integrate import quad

from smoothprofile.errors import CaseError
from smoothprofile.profiles import PROFILES, indicator, profile_named

ALL = pytest.mark.parametrize("profile", PROFILES.values(), ids=PROFILES.keys())
Z = np.linspace(-9.0, 9.0, 3601)


@njit(parallel=True)
def _painted(code, z, out):
    for i in prange(z.size):
        out[i] = indicator(code, z[i])


@ALL
def test_kernel_equals_the_array_form(profile):
    out = np.empty_like(Z)
    _painted(profile.code, Z, out)
    # Two libraries' tanh and sin differ in their last bits only.
    np.testing.assert_allclose(out, profile.value(Z), rtol=0, atol=1e-15)


@ALL
def test_one_inside_zero_outside_and_falling_between(profile):
    phi = profile.value(Z)
    assert np.all(np.diff(phi) <= 0)
    # half_width promises that what is cut off is below 1.2e-7 (tanh) or nothing (compact).
    left_out = 1.2e-7 if profile.name == "tanh" else 0.0
    assert np.all(phi[profile.half_width <= Z] <= left_out)
    assert np.all(1 - phi[-profile.half_width >= Z] <= left_out)
    assert np.all(phi[profile.core >= Z] == 1.0)
    assert np.all(phi[profile.edge <= Z] == 0.0)


@ALL
def test_slopes_are_derivatives(profile):
    # Away from the kinks of the second derivative; the fluid slope where 1−φ is not round-off.
    z = np.linspace(max(profile.core, -3) + 0.01, min(profile.edge, 3) - 0.01, 201)
    h = 1e-5
    central = (profile.value(z + h) - profile.value(z - h)) / (2 * h)
    # h²φ'''/6 ≤ 1e-9, and round-off 1e-16/h = 1e-11.
    np.testing.assert_allclose(profile.slope(z), central, rtol=0, atol=2e-9)
    np.testing.assert_allclose(
        profile.fluid_slope(z) * (1 - profile.value(z)), -profile.slope(z), rtol=0, atol=1e-13
    )


@pytest.mark.parametrize(
    ("name", "excess"), [("tanh", 0), ("quartic", 1 / 30), ("quartic-centred", 0), ("sine", 0)]
)
def test_excess_of_solid(name, excess):
    value = PROFILES[name].value
    solid = quad(lambda z: value(z) - 1.0, -20, 0, points=[-0.6, -0.5], limit=200)[0]
    fluid = quad(value, 0, 20, points=[0.4, 0.5], limit=200)[0]
    # quad's own default tolerance is 1.5e-8.
    assert solid + fluid == pytest.approx(excess, abs=3e-8)


def test_the_quartic_is_the_printed_one():
    xi = 0.3
    depth = np.linspace(0, xi, 11)  # the thesis' z, in lengths
    printed = (depth + xi) ** 2 * (depth - xi) ** 2 / xi**4
    ours = PROFILES["quartic"].value((depth - xi / 2) / xi)
    np.testing.assert_allclose(ours, printed, rtol=0, atol=1e-15)  # round-off


def test_codes_are_distinct_and_names_are_known():
    assert len({p.code for p in PROFILES.values()}) == len(PROFILES)
    assert all(profile_named(name).name == name for name in PROFILES)
    with pytest.raises(CaseError, match="tanh, quartic"):
        profile_named("tahn")
