"""The oscillating flat wall: closed forms, two discretisations, and the published numbers."""

import math

import numpy as np
import pytest

from known_flows import FLUID, SOLID, stokes_layer_theory
from smoothprofile.calibration import best_ratio, interface_shift
from smoothprofile.profiles import PROFILES
from smoothprofile.schemes import SCHEMES
from smoothprofile.studies import stokes_layer, stokes_layer_curves
from smoothprofile.studies.stokes_layer_curves import (
    THESIS_RATIO,
    best_k,
    end_rate_amplitude,
    oscillating_wall,
    periodic,
    root_near,
    steps_named,
    stress_errors,
)
from smoothprofile.theory.stokes_layer import (
    OscillatingWall,
    Steps,
    exact_stress,
    exact_velocity,
    fitted_response,
    fourier_coefficients,
    layer_edges,
    periodic_flow,
    relative_errors,
)
from smoothprofile.theory.stokes_march import lobatto, march

OMEGA, NU = 1.7, 0.6
every_scheme = pytest.mark.parametrize("scheme", SCHEMES)


def sharp_wall():
    """φ = H(h − y) under fluid so deep that what its top sends back is e^{−2·30·√(ω/2ν)}."""
    return OscillatingWall(
        indicator=lambda z: np.where(z < 0.0, 1.0, 0.0),
        core=-0.5,
        edge=0.5,
        thickness=0.1,
        depth=30.0,
        angular_frequency=OMEGA,
        viscosity=NU,
    )


def sharp_push(scheme, step, driven):
    """∫f dy and the slab's acceleration for a sharp wall, in closed form.

    In the solid θνΔt S″ = γS − A, so that S = A/γ + Ce^{κ(y−h)} + Be^{−κy}, κ² = γ/(θνΔt); in the
    fluid W = wS, w = θ + (1−θ)/z, decays with λ² = (γ − A)/(wνΔt). W and W′ are continuous.
    """
    turn = np.exp(1j * OMEGA * step)
    past = sum(a / turn ** (q + 1) for q, a in enumerate(scheme.past))
    gamma, theta = scheme.gamma, scheme.implicit
    moved = theta + (1 - theta) / turn
    kappa = np.sqrt(gamma / (theta * NU * step))
    decay = np.sqrt((gamma - past) / (moved * NU * step))
    inside = theta * past / gamma + (1 - theta) / turn
    # θC + inside = wD and θκC = −λwD.
    c = -decay * inside / (theta * (kappa + decay))
    b = 1 - past / gamma if driven else 0.0
    rate = (gamma - past) / step
    return rate * 3.0 - gamma / step * (c + b) / kappa, rate


@pytest.mark.parametrize("floor", ["free", "driven"])
@every_scheme
def test_a_sharp_wall_has_its_closed_form(scheme, floor):
    wall, table = sharp_wall(), SCHEMES[scheme]
    found = periodic_flow(wall, steps_named(scheme, 0.01), floor)
    push, rate = sharp_push(table, 0.01, floor == "driven")
    # Round-off: forces are differences of velocities over Δt.
    assert found.push == pytest.approx(push, abs=1e-9)
    assert found.stress == pytest.approx(push - 3.0 * rate, abs=1e-9)
    # The wall is k ξ too deep, and no better than that: the form is not the exact one.
    assert abs(found.stress / wall.exact_response - 1) > 0.01


def test_the_exact_flow_obeys_its_equation():
    wall = OscillatingWall(PROFILES["tanh"].value, -np.inf, np.inf, 0.1, 3.0, 3.0, OMEGA, NU)
    y, t, d = 3.7, 0.9, 1e-3

    def u(y, t):
        return exact_velocity(wall, np.array([y]), t)[0]

    rate = (u(y, t + d) - u(y, t - d)) / (2 * d)
    bend = (u(y + d, t) - 2 * u(y, t) + u(y - d, t)) / d**2
    # Second differences of 1e-3: ω³d²/6 and u⁗d²/12 are below 1e-6.
    assert rate == pytest.approx(NU * bend, abs=1e-6)
    assert u(3.0, t) == u(1.0, t) == pytest.approx(math.cos(OMEGA * t), abs=1e-15)
    # One-sided slope of second order: d²u‴/3 = 2e-6.
    slope = (-3 * u(3.0, t) + 4 * u(3.0 + d, t) - u(3.0 + 2 * d, t)) / (2 * d)
    assert exact_stress(wall, t) == pytest.approx(-NU * slope, abs=5e-6)
    expected = -math.sqrt(OMEGA * NU) * math.sin(OMEGA * t - math.pi / 4)
    assert exact_stress(wall, t) == pytest.approx(expected, abs=1e-15)


def test_published_numbers():
    # Half a unit of the last digit that was printed, each.
    assert best_k("amplitude", "crank-nicolson") == pytest.approx(0.807, abs=5e-4)
    assert best_k("phase", "crank-nicolson") == pytest.approx(0.756, abs=5e-4)
    assert root_near(end_rate_amplitude, 0.8) == pytest.approx(0.846, abs=5e-4)
    assert pytest.approx(0.8718, abs=5e-5) == THESIS_RATIO
    errors = stress_errors(THESIS_RATIO)
    assert 100 * errors["amplitude"] == pytest.approx(-0.314, abs=5e-4)
    assert errors["phase"] == pytest.approx(-0.00628, abs=5e-6)
    assert abs(periodic(THESIS_RATIO, floor="driven")[1].push) == pytest.approx(3.74, abs=5e-3)


@pytest.mark.parametrize(("k", "thickness"), [(0.5, 0.05), (0.8718, 0.07)])
@pytest.mark.parametrize("profile", ["tanh", "quartic"])
def test_crank_nicolson_on_cells_of_one_size(profile, k, thickness):
    """A second discretisation: differences of second order, and their limit."""
    step = 2 * math.pi / round(2 * math.pi / (k * thickness) ** 2)
    shape = PROFILES[profile]
    wall = OscillatingWall(shape.value, shape.core, shape.edge, thickness, SOLID, FLUID)
    found = periodic_flow(wall, steps_named("crank-nicolson", step))
    coarse, fine = (
        np.array(stokes_layer_theory(k, thickness, cells, profile)) for cells in (40, 80)
    )
    limit = (4 * fine - coarse) / 3
    # The extrapolation leaves Δy⁴ = 3e-11 of a tanh. The kinks of the quartic lie anywhere in a
    # cell: a tenth of what they add of second order, 3e-7, stays.
    tolerance = 2e-10 if profile == "tanh" else 1e-7
    assert relative_errors(wall, found.stress) == pytest.approx(limit, abs=tolerance)


@pytest.mark.parametrize(
    ("profile", "k"), [("tanh", 0.9), ("quartic", 0.4), ("quartic-centred", 0.4), ("sine", 0.4)]
)
@every_scheme
def test_marching_settles_into_the_periodic_state(scheme, profile, k):
    wall = oscillating_wall(profile, 0.15)
    count = 2 * round(math.pi / (k * 0.15) ** 2)
    steps = steps_named(scheme, 2 * math.pi / count)
    found, solved = march(wall, steps, 7 * count // 2), periodic_flow(wall, steps)
    last = slice(-count, None)
    fitted = fitted_response(wall, found.times[last], found.stress[last])
    # The start is wrong by some 1e-3 and dies as e^{−ν(π/h)²t} = e^{−17}: 3e-11, and round-off.
    assert fitted == pytest.approx(solved.stress, abs=2e-9)
    a, b = fourier_coefficients(found.times[last], found.push[last], 1.0)
    assert a[1] - 1j * b[1] == pytest.approx(solved.push, abs=2e-9)
    # At t = 7T/2 the amplitudes stand at −1; edges of elements are points of the march. Kinks of
    # a compact profile start short waves that Crank–Nicolson hardly damps: 2e-7 at one point.
    kinked = scheme == "crank-nicolson" and profile != "tanh"
    tolerance = {"rtol": 0.0, "atol": 5e-7 if kinked else 1e-9}
    at = np.searchsorted(found.y, solved.y - 1e-9)
    np.testing.assert_allclose(found.corrected[at], -solved.corrected.real, **tolerance)
    np.testing.assert_allclose(found.predicted[at], -solved.predicted.real, **tolerance)


def test_marching_starts_without_wiggles():
    wall, steps = oscillating_wall("tanh", 0.05), steps_named("crank-nicolson", 0.0019)
    found = march(wall, steps, 1000)
    # d²τ/dt² = τ: second differences are Δt² from a smooth curve; a sign that alternates would
    # count four times its size.
    assert np.abs(np.diff(found.stress[500:], 2)).max() < 1.1 * steps.step**2


def test_lobatto_points():
    nodes, weights, slopes = lobatto(8)
    for power in range(16):
        # Exact up to degree 2·8 − 1, to round-off.
        exact = (1 - (-1) ** (power + 1)) / (power + 1)
        assert weights @ nodes**power == pytest.approx(exact, abs=1e-14)
    for power in range(1, 9):
        np.testing.assert_allclose(slopes @ nodes**power, power * nodes ** (power - 1), atol=1e-12)


def test_the_fit_of_appendix_a():
    wall = oscillating_wall("tanh", 0.05)
    # Any whole period of equal steps; the harmonics and the mean must not count.
    times = 1.234 + 2 * math.pi * np.arange(1, 102) / 101
    tau = 0.93 * exact_stress(wall, times + 0.02) + 0.1 + 0.05 * np.cos(3 * times)
    errors = relative_errors(wall, fitted_response(wall, times, tau))
    assert errors == pytest.approx((-0.07, 0.02), abs=1e-14)
    a, b = fourier_coefficients(times, tau, 1.0, 4)
    assert math.hypot(a[1], b[1]) == pytest.approx(0.93, abs=1e-14)
    assert (a[0] / 2, a[3], b[3]) == pytest.approx((0.1, 0.05, 0.0), abs=1e-14)
    # As printed θ is arctan(b₁/a₁): −π/4 for the exact stress.
    a, b = fourier_coefficients(times, exact_stress(wall, times), 1.0)
    assert math.atan(b[1] / a[1]) == pytest.approx(-math.pi / 4, abs=1e-14)


@every_scheme
def test_the_best_ratio_tends_to_the_flat_walls(scheme):
    flat, thicknesses = best_ratio("tanh", scheme), (0.05, 0.025, 0.0125)
    amplitude, phase = (
        [best_k(name, scheme, "tanh", xi, stokes_layer.DEEP) for xi in thicknesses]
        for name in ("amplitude", "phase")
    )
    # The next order makes the last halving's slope wrong by a third of ξ or so.
    assert np.log2(np.divide(*(np.array(amplitude[1:]) - flat))) == pytest.approx(2.0, abs=0.06)
    assert np.log2(np.divide(*(np.array(phase[1:]) - flat))) == pytest.approx(1.0, abs=0.03)
    # Fourth order is what is left: (ξ/√(ν/ω))⁴ = 4e-7 at ξ = .025, a sixteenth of it after that.
    assert stokes_layer.extrapolated(amplitude, (2, 3)) == pytest.approx(flat, abs=1e-7)


def test_extrapolation_takes_out_the_orders_it_is_told():
    xi = 0.1 * 0.5 ** np.arange(4)
    values = 0.7 + 2 * xi**2 - 3 * xi**3 + 5 * xi**4
    assert stokes_layer.extrapolated(list(values), (2, 3, 4)) == pytest.approx(0.7, abs=1e-14)
    assert stokes_layer.extrapolated(list(values), (1, 2, 3)) != pytest.approx(0.7, abs=1e-6)


@pytest.mark.parametrize("profile", PROFILES)
@every_scheme
def test_every_profile_has_the_best_ratio_of_a_flat_wall(scheme, profile):
    """The slab weighs h whatever is painted; with the printed quartic's h + ξ/30 it is .02 off."""
    found = best_k("amplitude", scheme, profile)
    # ωξ²/ν and the far boundary: 5e-4 of tanh at ξ = .05.
    assert found == pytest.approx(best_ratio(profile, scheme), abs=6e-4)


@pytest.mark.parametrize("k", [0.5, 1.2])
@every_scheme
def test_errors_are_those_of_a_displaced_wall(scheme, k):
    """Both errors are −s₀ξ√(ω/2ν) + O(ξ²)."""
    shift = interface_shift("tanh", k, scheme)
    left = []
    for xi in (0.02, 0.01):
        errors = stress_errors(k, scheme, "tanh", xi, stokes_layer.DEEP)
        left.append([errors[name] + shift * xi * math.sqrt(0.5) for name in errors])
    orders = np.log2(np.abs(np.divide(*left)))
    # The amplitude's next term is the square of the first, both of second order.
    assert orders == pytest.approx([2.0, 2.0], abs=0.15)


def test_frequency_and_viscosity_only_set_the_scales():
    """The same problem in other units of length and time."""
    length, time = 2.0, 0.7
    shape, table = PROFILES["tanh"], SCHEMES["bdf2"]
    plain = OscillatingWall(shape.value, shape.core, shape.edge, 0.1)
    scaled = OscillatingWall(
        *(shape.value, shape.core, shape.edge, 0.1 * length, 3.0 * length, 3.0 * length),
        angular_frequency=1 / time,
        viscosity=length**2 / time,
    )
    one = periodic_flow(plain, Steps(0.008, table.gamma, table.past, table.implicit))
    other = periodic_flow(scaled, Steps(0.008 * time, table.gamma, table.past, table.implicit))
    # Round-off, as above.
    assert relative_errors(scaled, other.stress) == pytest.approx(
        relative_errors(plain, one.stress), abs=1e-9
    )


def test_what_is_refused():
    with pytest.raises(ValueError, match="floor is 'wet'"):
        periodic_flow(oscillating_wall("tanh", 0.05), steps_named("bdf2", 0.01), "wet")
    with pytest.raises(ValueError, match="does not fit"):
        layer_edges(oscillating_wall("tanh", 0.4))


@pytest.mark.slow
def test_the_study():
    study = stokes_layer.run()
    assert study.agrees, [row for row in study.rows if row.verdict == "differs"]
    for name, columns in study.curves.items():
        assert len({values.size for values in columns.values()}) == 1, name
    assert [picture.name for picture in study.pictures] == [
        "sketch",
        "velocity",
        "wall-stress",
        "errors",
        "errors-by-scheme",
        "limits",
    ]
    # The marches of figure 3.13 lie on its curves: 2e-5 of the start, 3e-4 of interpolation.
    errors, marched = study.curves["errors"], study.curves["errors-marched"]
    for name in stokes_layer_curves.ERRORS:
        np.testing.assert_allclose(
            marched[name], np.interp(marched["k"], errors["k"], errors[name]), atol=4e-4
        )
