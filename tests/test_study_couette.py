"""The Couette study: the reduced problem against closed forms, and every confirmed number."""

import math

import numpy as np
import pytest

from smoothprofile import calibration
from smoothprofile.profiles import PROFILES
from smoothprofile.schemes import SCHEMES
from smoothprofile.studies import couette as study
from smoothprofile.studies import couette_curves as flows
from smoothprofile.studies.couette_curves import CHANNEL, flow_at, wall_of
from smoothprofile.theory import couette
from smoothprofile.theory.couette import Channel, Wall

EULER, NICOLSON = "backward-euler", "crank-nicolson"
H = CHANNEL.height


def digits(value):
    """Half a unit of the last digit of a number written as text."""
    mantissa, _, exponent = value.partition("e")
    return 0.5 * 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def confirms(ours, printed):
    """Whether `ours` rounds to the number printed as text."""
    return abs(ours - float(printed)) <= digits(printed)


def test_a_sharp_penalised_wall_in_closed_form():
    # φ = H(y − h): u* − V = −A sinh((2h−y)/ℓ) above, ℓ = √(νΔt/γ), linear below.
    channel = Channel(height=2.0, speed=1.5, viscosity=0.7)
    time_step, gamma = 0.3, 1.5
    length = math.sqrt(0.7 * time_step / gamma)
    wall = Wall(lambda z: np.where(z < 0, 1.0, 0.0), 0.1, 2.0, -1.0, 0.0)
    flow = couette.penalised(channel, wall, time_step, gamma)
    fluid = flow.mesh.y <= 2.0
    retreat = length * math.tanh(2.0 / length)
    slope = 1.5 / (2.0 + retreat)
    # Round-off of a few hundred elements.
    np.testing.assert_allclose(flow.predicted[fluid], slope * flow.mesh.y[fluid], atol=1e-12)
    # The wall ends at 2h, where what is left of the shear, 1/cosh, is the plate's own force.
    passed_on = 1 - 1 / math.cosh(2.0 / length)
    assert flow.stress == pytest.approx(0.7 * slope * passed_on, rel=1e-12)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("profile", PROFILES)
def test_the_equations_hold(profile, scheme):
    # The flow is found for W; here the scheme's own equation is integrated twice from the plate:
    # ν(W − W(0)) = τy − ∫₀^y (y − y')f dy', at the wall's far side, where W = uⁿ = V.
    known = SCHEMES[scheme]
    flow = flow_at(0.4, 0.2, profile, scheme)
    mesh, phi = flow.mesh, wall_of(profile, 0.2).value(flow.mesh.y)
    top = 2 * H
    impulse = phi * (CHANNEL.speed - flow.predicted)
    time_step = (0.4 * 0.2) ** 2
    np.testing.assert_allclose(flow.velocity, flow.predicted + impulse, atol=1e-13)
    np.testing.assert_allclose(flow.force, known.gamma * impulse / time_step, atol=1e-11)
    assert flow.predicted[[0, -1]] == pytest.approx([0, CHANNEL.speed], abs=1e-12)
    # Eight Gauss points on each panel: 1e-11 (test_the_mesh_is_fine_enough).
    assert flow.stress == pytest.approx(mesh.integral(flow.force), abs=1e-11)
    reached = flow.stress * top - mesh.integral((top - mesh.y) * flow.force)
    assert reached == pytest.approx(CHANNEL.speed, abs=1e-10)


def test_a_wall_that_reaches_the_plate_leaves_it_at_rest():
    # ξ = h/2: φ(0) = 0.018, and Crank–Nicolson's W differs from u* − V by half of it.
    flow = couette.penalised(CHANNEL, wall_of("tanh", 1.5), 1.0, 1.0, 0.5)
    assert flow.predicted[0] == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("implicit", [1.0, 0.5])
def test_the_differential_equation_holds_pointwise(implicit):
    # ν[θu* + (1−θ)uⁿ]'' + f = 0 by the second derivative of the panel's own polynomial.
    flow = couette.penalised(CHANNEL, wall_of("tanh", 0.2), 0.02, 1.0, implicit)
    y = flow.mesh.y
    centre = np.searchsorted(y, H + 0.05)
    near = slice(centre - 5, centre + 6)
    w = implicit * flow.predicted[near] + (1 - implicit) * flow.velocity[near]
    polynomial = np.polynomial.Polynomial.fit(y[near], w, 10)
    # Ten powers over half a thickness leave 1e-6 of f, which is about one.
    assert polynomial.deriv(2)(y[centre]) == pytest.approx(-flow.force[centre], abs=1e-5)


def test_the_mesh_is_fine_enough(monkeypatch):
    cases = [(k, xi, p, EULER) for k in (0.05, 0.755, 2.0) for xi in (0.2, 0.02) for p in PROFILES]
    found = [flow_at(*case) for case in cases]
    monkeypatch.setattr(couette, "GROWTH", 1.12)
    for case, flow in zip(cases, found, strict=True):
        finer = flow_at(*case)
        # What the study promises.
        assert flow.error == pytest.approx(finer.error, abs=1e-11)
        assert flow.stress == pytest.approx(finer.stress, abs=1e-11)


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("ratio", [0.1, 0.3, 0.9])
def test_the_wall_acts_where_the_flat_layer_says(ratio, profile, scheme):
    # τ = Vν/(h + ξs₀). Two different problems, each solved to 1e-11; s₀ is the stress over ξ/h.
    flow = flow_at(ratio, 0.05, profile, scheme)
    expected = calibration.interface_shift(profile, ratio, scheme)
    assert flows.solved_shift(flow, 0.05) == pytest.approx(expected, abs=1e-8)
    assert flow.stress == pytest.approx(CHANNEL.retreated_stress(0.05 * expected), rel=1e-10)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_best_ratios_of_the_stress(profile, scheme):
    known = {
        "tanh": ("0.755222", "0.806794", "0.924955", "1.022576"),
        "quartic": ("0.190", "0.208", "0.232", "0.257"),
        "sine": ("0.170", "0.183", "0.208", "0.230"),
    }
    ours = flows.best_stress_ratio(0.05, profile, scheme)
    if profile in known:
        assert confirms(ours, known[profile][list(SCHEMES).index(scheme)])
    # A root of the channel's stress, s₀/h times 0.05 to 1e-11, beside one of the flat layer.
    assert ours == pytest.approx(calibration.best_ratio(profile, scheme), abs=1e-8)


def test_the_best_ratio_of_the_stress_is_the_same_for_any_thickness():
    # Within what e^{−2h/ξ} = 1e-13 at ξ = 0.2 and k⁻² make of it.
    at_two = [flows.best_stress_ratio(xi) for xi in (0.2, 0.05)]
    assert at_two[0] == pytest.approx(at_two[1], abs=1e-7)


@pytest.mark.parametrize(("xi", "ratio"), [(0.2, "0.7526"), (0.1, "0.7541"), (0.05, "0.7547")])
def test_best_ratios_of_the_velocity(xi, ratio):
    assert confirms(flows.best_velocity_ratio(xi), ratio)


def test_errors_at_the_best_ratio_and_at_the_thesis_one():
    assert confirms(flow_at(flows.best_velocity_ratio(0.05), 0.05).error, "5.241e-4")
    assert confirms(flow_at(0.75, 0.05).error, "5.402e-4")
    assert confirms(flow_at(0.75, 0.05).stress_error, "1.497e-4")
    # Printed 2.995e-4, which is 2.99465e-4.
    assert confirms(flow_at(0.75, 0.1).stress_error, "2.995e-4")


def test_the_error_is_a_function_of_viscosity_times_step():
    wall = wall_of("tanh", 0.05)
    one = couette.penalised(Channel(viscosity=1.0), wall, 2e-3)
    two = couette.penalised(Channel(viscosity=2.0), wall, 1e-3)
    # The same numbers in the same places, but for round-off.
    assert two.error == pytest.approx(one.error, rel=1e-12)
    assert two.stress_error == pytest.approx(one.stress_error, rel=1e-12)
    assert two.stress == pytest.approx(2 * one.stress, rel=1e-12)


def test_moments_of_the_force():
    moments = flow_at(0.75, 0.1).moments
    assert confirms(moments.mean, "2.99910")
    assert confirms(moments.deviation, "0.117685")
    assert confirms(moments.cubes, "0.12501")
    assert confirms(moments.third, "4.0e-4")
    assert confirms(moments.skewness, "0.246")
    parts = 3 * moments.mean * moments.deviation**2 + moments.third
    # An identity: round-off of ⟨y³⟩ = 27.
    assert moments.cubes == pytest.approx(parts, abs=1e-12)


@pytest.mark.parametrize(("ratio", "scheme"), [(0.3, EULER), (0.755, EULER), (0.8, NICOLSON)])
def test_closed_form_of_the_moments(ratio, scheme):
    known = SCHEMES[scheme]
    solved = flow_at(ratio, 0.1, "tanh", scheme).moments
    closed = couette.tanh_moments(CHANNEL, 0.1, ratio / math.sqrt(known.gamma), known.implicit)
    # Solved to 1e-11 of σ = 0.12, cubed: 1e-8 in the skewness, and far less seen.
    assert solved.mean == pytest.approx(closed.mean, abs=1e-11)
    assert solved.deviation == pytest.approx(closed.deviation, abs=1e-11)
    assert solved.cubes == pytest.approx(closed.cubes, abs=1e-10)
    assert solved.skewness == pytest.approx(closed.skewness, abs=1e-8)


@pytest.mark.parametrize("profile", PROFILES)
def test_the_force_is_centred_where_the_wall_acts(profile):
    flow = flow_at(0.4, 0.1, profile)
    acts_at = CHANNEL.speed * CHANNEL.viscosity / flow.stress
    assert flow.moments.mean == pytest.approx(acts_at, abs=1e-10)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("ratio", [0.377, 1.0])
def test_a_wall_painted_back_by_its_shift_has_the_exact_stress(profile, ratio):
    shift = calibration.interface_shift(profile, ratio)
    moved = flow_at(ratio, 0.05, profile, position=H - 0.05 * shift)
    # e^{−h/(kξ)} of the wall's far side is 1e-26.
    assert moved.stress_error == pytest.approx(0, abs=1e-10)
    # With the wrong sign the error doubles.
    wrong = flow_at(ratio, 0.05, profile, position=H + 0.05 * shift)
    as_painted = flow_at(ratio, 0.05, profile).stress_error
    assert wrong.stress_error == pytest.approx(2 * as_painted, rel=0.05)


def test_orders_in_thickness():
    def order(measure, xi=0.04):
        return math.log2(measure(xi) / measure(xi / 2))

    best = calibration.best_ratio()
    # At s₀ = 0 the whole error is a corner of width ξ and height ξ: ξ·√ξ, and nothing else.
    assert order(lambda xi: flow_at(best, xi).error) == pytest.approx(1.5, abs=1e-6)
    # h/(h + ξs₀) − 1: ξ¹ with a relative correction of ξs₀/h = 1e-4.
    assert order(lambda xi: flow_at(0.75, xi).stress_error) == pytest.approx(1, abs=3e-4)
    # Far from the best k the misplaced wall is nearly all of the L2 error too.
    assert order(lambda xi: flow_at(0.4, xi).error) == pytest.approx(1, abs=0.02)


def test_option_1():
    flow = couette.smoothed_force(CHANNEL, 0.1)
    assert confirms(flow.error / 0.1**1.5, "0.091365")
    assert flow.error == pytest.approx(couette.smoothed_force_error(CHANNEL, 0.1), rel=1e-11)
    y, xi = flow.mesh.y, 0.1
    # The thesis' (3.5) as it stands; cosh(30) = 5e12 costs no digits.
    logarithms = np.log(np.cosh((y - H) / xi)) - np.log(np.cosh(H / xi))
    np.testing.assert_allclose(flow.velocity, (y - xi * logarithms) / (2 * H), atol=1e-13)
    assert flow.stress == pytest.approx(CHANNEL.stress, rel=1e-14)
    assert flow.mesh.integral(flow.force) == pytest.approx(CHANNEL.stress, rel=1e-11)
    # dφ/dy = sech²(z)/(2ξ) is symmetrical, and its variance is π²ξ²/12.
    moments = flow.moments
    assert moments.mean == pytest.approx(H, abs=1e-12)
    assert moments.deviation == pytest.approx(math.pi * xi / math.sqrt(12), rel=1e-10)
    assert moments.third == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize(
    ("ratio", "stress"), [(1e2, "0.35688"), (1e3, "0.37623"), (1e4, "0.39373"), (1e6, "0.43305")]
)
def test_option_2(ratio, stress):
    flow = flows.smoothed_viscosity_at(0.1, ratio)
    assert confirms(flow.stress, stress)
    closed = couette.smoothed_viscosity_stress(CHANNEL, 0.1, ratio)
    # The closed form leaves out R e^{−60} = 1e-20.
    assert flow.stress == pytest.approx(closed, abs=1e-11)
    # ν∫−u'' = ν(u'(0) − u'(2h)) = τ(1 − 1/R).
    assert flow.mesh.integral(flow.force) == pytest.approx(closed * (1 - 1 / ratio), abs=1e-10)
    # Painted ½ξ ln R deeper, what is left is the wall's own shear: Vν/(h + h/R).
    deeper = flows.smoothed_viscosity_at(0.1, ratio, H + 0.05 * math.log(ratio))
    assert deeper.stress_error == pytest.approx(-1 / (1 + ratio), abs=1e-10)


def test_option_2_with_a_profile_that_ends():
    # τ = V/∫dy/μ, by plain Gauss quadrature over the profile.
    profile, ratio, xi = PROFILES["sine"], 50.0, 0.3
    flow = couette.smoothed_viscosity(CHANNEL, wall_of("sine", xi), profile.slope, ratio)
    nodes, weights = np.polynomial.legendre.leggauss(60)
    phi = profile.value(0.5 * nodes)
    across = 0.5 * xi * weights @ (1 / (1 + (ratio - 1) * phi))
    depth = (H - xi / 2) * (1 + 1 / ratio) + across
    # Sixty points follow 1/μ, whose poles lie 0.09 from the real axis in z, to 1e-9.
    assert flow.stress == pytest.approx(1 / depth, rel=1e-8)


def test_equal_viscosities_are_no_wall():
    flow = flows.smoothed_viscosity_at(0.1, 1.0)
    np.testing.assert_allclose(flow.velocity, flow.mesh.y / (2 * H), atol=1e-13)
    assert np.abs(flow.force).max() == 0.0


def test_a_wall_that_leaves_the_channel_is_refused():
    with pytest.raises(ValueError, match="varies from"):
        couette.penalised(CHANNEL, wall_of("tanh", 0.1, position=7.0), 0.01)


@pytest.mark.slow
def test_the_study_agrees():
    done = study.run()
    assert [row.quantity for row in done.rows if row.verdict == "differs"] == []
    assert len(done.rows) >= 50
    assert [picture.name for picture in done.pictures][:2] == ["sketch", "velocity"]
    for columns in done.curves.values():
        assert len({values.size for values in columns.values()}) == 1
        assert all(np.isfinite(values).all() for values in columns.values())
