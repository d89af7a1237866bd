"""The radial problem of a strained sphere: its stresslet, and where it is painted for it."""

import math

import numpy as np
import pytest
from scipy.special import spherical_in

from smoothprofile import calibration
from smoothprofile.calibration import painted_radius, resistance_ratio
from smoothprofile.theory import sharp
from smoothprofile.theory.straining import core_conditions, penalised_stresslet


def nothing(r):
    return np.zeros_like(r)


def test_without_a_sphere_there_is_no_stresslet():
    edges = np.geomspace(1e-3, 8.0, 40)
    # Sums of terms as large as R³ = 512 cancel.
    assert abs(penalised_stresslet(nothing, nothing, edges)) < 1e-9


def test_the_sharp_stresslet_is_einsteins_without_a_wall():
    assert sharp.sphere_stresslet(2.0, 1e9) == pytest.approx(20 / 3 * math.pi * 8.0, rel=1e-12)


@pytest.mark.parametrize("wall", [1.5, 3.0, 8.0])
def test_the_sharp_stresslet_solves_stokes_equation(wall):
    """A = c₁r + c₂r³ + c₃r⁻² + c₄r⁻⁴, B = c₁r/2 + 5c₂r³/6 − c₄r⁻⁴/3; S = −(8π/3)c₃."""

    def flow(r):
        return [[r, r**3, r**-2, r**-4], [r / 2, 5 * r**3 / 6, 0.0, -(r**-4) / 3]]

    found = np.linalg.solve(np.array(flow(1.0) + flow(wall)), [0.0, 0.0, wall, wall / 2])
    exact = sharp.sphere_stresslet(1.0, wall)
    # A system whose condition number is about wall⁷.
    assert exact == pytest.approx(-8 / 3 * math.pi * found[2], rel=1e-8)


def test_a_porous_ball_of_little_resistance_is_strained_with_the_fluid():
    """χ → 0: ∫x(χE·x)dV = χ(4π/15)a⁵E to first order."""
    small = 1e-6
    edges = np.concatenate([np.geomspace(1e-3, 1.0, 20), np.linspace(1.0, 8.0, 20)[1:]])
    found = penalised_stresslet(lambda r: np.where(r < 1.0, small, 0.0), nothing, edges)
    # Of second order in χ, and of the first edge's fifth power.
    assert found == pytest.approx(small * 4 * math.pi / 15, rel=1e-3)


@pytest.mark.parametrize(
    ("profile", "coefficient"), [("tanh", 5.0), ("quartic-centred", 0.2), ("sine", 0.2)]
)
def test_at_the_best_step_the_error_is_of_second_order(profile, coefficient):
    """No first-order error is left where a flat wall acts where it is painted."""
    k = calibration.best_ratio(profile)
    errors = [
        abs(resistance_ratio(1.0, 1.0, xi, k * xi, profile, motion="straining") - 1.0)
        for xi in (0.01, 0.02)
    ]
    # Slopes between two layers this thin are within a tenth of their limit.
    assert math.log2(errors[1] / errors[0]) == pytest.approx(2.0, abs=0.1)
    # The defect of the flux through the layer, (π²/12)ξ² for tanh, and its like elsewhere.
    assert errors[1] < coefficient * 0.02**2


def test_the_painted_radius_gives_the_sharp_stresslet():
    for profile in ("tanh", "quartic-centred"):
        k = 1.3 * calibration.best_ratio(profile)
        painted = painted_radius(2.0, 0.4, 0.4 * k, profile, motion="straining")
        ratio = resistance_ratio(2.0, painted, 0.4, 0.4 * k, profile, motion="straining")
        assert ratio == pytest.approx(1.0, abs=1e-7)


def test_radii_for_drag_and_stresslet_differ_in_second_order():
    k = calibration.best_ratio("tanh")
    radii = {
        motion: [painted_radius(1.0, xi, k * xi, motion=motion) for xi in (0.1, 0.2, 0.3)]
        for motion in ("translation", "straining")
    }
    # Digits of the table in the docstring of painted_radius.
    assert np.allclose(radii["straining"], [1.01069, 1.02831, 1.04058], atol=5e-6)
    assert np.allclose(radii["translation"], [1.00643, 1.02100, 1.03983], atol=5e-6)


def test_the_start_lies_where_it_likes_in_the_clear():
    """A porous shell about a clear centre: inside it the two regular flows are all there is."""
    shell = np.linspace(0.5, 1.0, 12)
    beyond = np.linspace(1.0, 8.0, 20)[1:]

    def resistance(r):
        return np.where((r > 0.5) & (r < 1.0), 40.0, 0.0)

    found = [
        penalised_stresslet(resistance, nothing, np.concatenate([start, shell[1:], beyond]))
        for start in (np.geomspace(1e-3, 0.5, 20), np.array([0.4, 0.5]), np.array([0.2, 0.5]))
    ]
    # The first starts at 1e-3 of the radius, and is wrong by some of its square.
    assert np.allclose(found, found[1], rtol=1e-7)


def test_the_core_lets_its_three_flows_out():
    """∇(r²Y) with p = −χr²Y, ∇(fY), and A = f/r, joined so that A = 0 at the rim."""
    radius, resistance, small = 0.7, 3.0, 1e-5
    root = math.sqrt(resistance)

    def f(r):
        return spherical_in(2, root * r)

    def slope(r):
        return root * spherical_in(2, root * r, derivative=True)

    flows = [
        (lambda r: 2 * r, lambda r: r, -resistance * radius**2),
        (slope, lambda r: f(r) / r, 0.0),
        (lambda r: f(r) / r, lambda r: (f(r) / r + slope(r)) / 6, 0.0),
    ]

    def central(function):
        return (function(radius + small) - function(radius - small)) / (2 * small)

    states = []
    for a, b, pressure in flows:
        shear, traction = radius * central(b), radius * (central(a) - pressure)
        states.append([a(radius), b(radius), shear, 6 * b(radius) - traction])
    states = np.array(states)
    first, second = core_conditions(radius, resistance)
    assert first.tolist() == [1, 0, 0, 0]
    for one, other in ((0, 1), (0, 2), (1, 2)):
        joined = states[one] * states[other, 0] - states[other] * states[one, 0]
        # Central differences leave 1e-10.
        assert abs(second @ joined) < 1e-7 * np.abs(joined).max()
