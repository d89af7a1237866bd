"""A ball of smoothed viscosity: the radial problem against closed forms, and where to paint it."""

import math

import numpy as np
import pytest

from smoothprofile.errors import CaseError
from smoothprofile.profiles import profile_named
from smoothprofile.theory import viscous_drop
from smoothprofile.theory.dielectric import flat_offsets
from smoothprofile.viscous.smoothed_viscosity_radius import MOTIONS, error_of, painted_radius

RATIOS = (0.1, 10.0, 1000.0)


def errors(motion, ratio, smoothing, thicknesses, profile="tanh"):
    return np.array([error_of(motion, 1.0, xi, ratio, profile, smoothing) for xi in thicknesses])


def test_sharp_limits():
    # Rigid spheres: Stokes and Einstein; a bubble: 4πμa.
    assert viscous_drop.sharp_mobility(1e12) == pytest.approx(1 / (6 * math.pi), rel=1e-11)
    assert viscous_drop.sharp_mobility(0.0) == pytest.approx(1 / (4 * math.pi), rel=1e-14)
    assert viscous_drop.sharp_spin(1e12) == pytest.approx(1 / (8 * math.pi), rel=1e-11)
    assert viscous_drop.sharp_stresslet(1e12) == pytest.approx(20 * math.pi / 3, rel=1e-11)


@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("ratio", [0.1, 10.0])
def test_the_tensor_is_of_second_order(motion, ratio):
    found = np.abs(errors(motion, ratio, "tensor", (0.1, 0.05, 0.025)))
    # ξ³ takes part: 1.9 to 2.4.
    assert np.all(np.log2(found[:-1] / found[1:]) > 1.85)
    assert found[-1] < (0.02 if motion == "torque" else 0.004)


@pytest.mark.parametrize("motion", ["drag", "stresslet"])
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("smoothing", viscous_drop.SMOOTHINGS)
@pytest.mark.parametrize("profile", ["tanh", "quartic"])
def test_first_order_is_that_of_the_closed_form(motion, ratio, smoothing, profile):
    known = profile_named(profile)
    layer = known.value, ratio, smoothing, known.core, known.edge
    normal, tangential = flat_offsets(*layer)
    excess = flat_offsets(known.value, ratio, "tensor", known.core, known.edge)[0]
    if motion == "stresslet":
        slope = viscous_drop.stresslet_slope(ratio, normal, tangential)
    else:
        # Where a harmonic layer is loaded is where an arithmetic one would shear, turned inside.
        inward = flat_offsets(known.value, ratio, "harmonic", known.core, known.edge)[1]
        load = inward if smoothing == "harmonic" and ratio > 1.0 else excess
        slope = -viscous_drop.mobility_slope(ratio, normal, tangential, load)
    xi = np.array([4e-4, 2e-4])
    found = errors(motion, ratio, smoothing, xi, profile) / xi
    # Two ξ, extrapolated: what is left is of the order Rξ², the tensor's R(ξ/a)³ over ξ.
    assert 2 * found[1] - found[0] == pytest.approx(slope, abs=3e-3 * max(1.0, abs(slope)))


def test_swapping_the_tensors_viscosities_is_of_first_order(monkeypatch):
    right = viscous_drop.viscosities
    monkeypatch.setattr(viscous_drop, "viscosities", lambda *a: right(*a)[::-1])
    found = np.abs(errors("drag", 10.0, "tensor", (0.05, 0.025)))
    assert np.log2(found[0] / found[1]) < 1.2 and found[1] > 0.015


def test_less_viscosity_never_resists_more():
    # μ_h ≤ tensor ≤ μ_a in every strain, and the dissipation follows (its least value).
    found = [error_of("stresslet", 1.0, 0.2, 30.0, "tanh", s) for s in
             ("harmonic", "tensor", "arithmetic")]  # fmt: skip
    assert found[0] < found[1] < found[2]


def test_of_one_viscosity_nothing_is_smoothed():
    # A ball of force density in a uniform fluid: 1/(5πa) when sharp; the layer is of second order.
    found = [error_of("drag", 1.0, xi, 1.0, "tanh", "tensor") for xi in (0.1, 0.05)]
    assert found == [error_of("drag", 1.0, xi, 1.0, "tanh", "harmonic") for xi in (0.1, 0.05)]
    assert math.log2(found[0] / found[1]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("smoothing", viscous_drop.SMOOTHINGS)
@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("motion", MOTIONS)
def test_the_painted_radius_has_no_error(smoothing, ratio, motion):
    painted = painted_radius(2.0, 0.1, ratio, "tanh", smoothing, motion)
    assert error_of(motion, painted / 2, 0.05, ratio, "tanh", smoothing) == pytest.approx(
        0.0, abs=1e-8
    )


def test_arithmetic_is_harmonic_moved_by_half_a_logarithm():
    # 1 + (R−1)φ(z) = 1/(1 + (1/R−1)φ(z − ½ ln R)) for tanh; so is what they load.
    ratio, xi = 1000.0, 0.1
    moved = painted_radius(1.0, xi, ratio, "tanh", "harmonic") - 0.5 * xi * math.log(ratio)
    # φ and the harmonic layer's loads are the same, but for R−1 beside R.
    assert painted_radius(1.0, xi, ratio, "tanh", "arithmetic") == pytest.approx(moved, abs=2e-5)


def test_spheres_that_slide_on_one_another():
    # A rigid core of uniform shells: Ω/T = ∫3L²/(8πμr⁴)dr, by a plain sum; the load is φ.
    ratio, xi = 10.0, 0.1
    r = (np.arange(400000) + 0.5) * 1e-5
    phi = profile_named("tanh").value((r - 1.0) / xi)
    within = np.cumsum(phi * r**4) / (phi * r**4).sum()
    plain = (3 * within**2 / (8 * math.pi * (1 + (ratio - 1) * phi) * r**4)).sum() * 1e-5
    plain += 1 / (8 * math.pi * 4.0**3)
    exact = viscous_drop.sharp_spin(ratio) / plain - 1.0
    # Of the sum, whose L is at the panels' ends.
    assert error_of("torque", 1.0, xi, ratio, "tanh", "arithmetic") == pytest.approx(
        exact, abs=1e-4
    )


def test_retracted_for_its_drag_the_stresslet_is_nearly_right():
    # R = 1000, ξ = .1a: as painted 134 and −6 %.
    for smoothing, profile in (("arithmetic", "tanh"), ("harmonic", "tanh")):
        painted = painted_radius(1.0, 0.1, 1000.0, profile, smoothing)
        assert abs(error_of("stresslet", painted, 0.1, 1000.0, profile, smoothing)) < 0.01


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((1.0, 0.9, 10.0), "between 0.0001 and 0.8"),
        ((1.0, 0.1, 1e7), "between 1e-06 and 1e.06"),
        ((1.0, 0.1, -1.0), "positive"),
        ((1.0, 0.1, 10.0, "tanh", "geometric"), "arithmetic, harmonic, tensor"),
        ((1.0, 0.1, 1.0, "tanh", "tensor", "stresslet"), "other than 1"),
        ((1.0, 0.2, 1e4, "tanh", "arithmetic"), "thinner layer"),
    ],
)
def test_refusals(arguments, said):
    with pytest.raises(CaseError, match=said):
        painted_radius(*arguments)
