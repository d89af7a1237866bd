"""Lubrication below the resolved gap, against the leading terms of the resistance functions."""

import math

import numpy as np
import pytest

from contact_scenes import Scene, grid
from smoothprofile import shapes
from smoothprofile.particles.contact import ContactParameters
from smoothprofile.particles.contact_law import Law, shear_resistances, squeeze_impulse

VISCOSITY, OUTER, INNER = 0.7, 0.2, 1e-3
LAW = Law(0.1, 0.0, 0.0, 1.0, VISCOSITY, OUTER, INNER)


def lubricated(count, **changes):
    """Lubrication alone: a repulsion of no range to speak of."""
    options = {"range": 1e-9, "viscosity": VISCOSITY, "outer_gap": OUTER, "inner_gap": INNER}
    return ContactParameters(touch_force=np.full(count, 1e-9), **(options | changes))


def pair(a, b, gap, **changes):
    """Two spheres along x, the first to the left."""
    position = [[4.0, 5.0, 5.0], [4.0 + a + b + gap, 5.0, 5.0]]
    balls = [shapes.sphere(a), shapes.sphere(b)]
    return Scene(balls, position, parameters=lubricated(2, **changes))


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (1.0, 2.5), (0.4, 1.3), (1.0, math.inf)])
def test_shear_has_the_leading_terms_of_jeffrey_and_onishi(a, b):
    """Y^A, Y^B, Y^C of J. Fluid Mech. 139 (1984), at leading order, as λ = b/a.

    6πμa Y^A = 6πμa·4λ(2+λ+2λ²)/15(1+λ)³,  4πμa²Y^B = −4πμa²·λ(4+λ)/5(1+λ)²,
    8πμa³Y^C₁₁ = 8πμa³·2λ/5(1+λ),  πμ(a+b)³Y^C₁₂ = πμ(a+b)³·4λ²/5(1+λ)⁴, each times ln(1/h).
    """
    A, B, C = shear_resistances(LAW, OUTER / math.e, a, b)
    x = 1e9 if math.isinf(b) else b / a
    mu = VISCOSITY * math.pi
    force = 6 * mu * a * 4 * x * (2 + x + 2 * x**2) / (15 * (1 + x) ** 3)
    turn = 4 * mu * a**2 * x * (4 + x) / (5 * (1 + x) ** 2)
    couple = 8 * mu * a**3 * 2 * x / (5 * (1 + x))
    # A sphere of 1e9 radii stands for a wall.
    assert force == pytest.approx(A, rel=1e-8)
    assert A * a + B == pytest.approx(turn, rel=1e-8)
    assert A * a**2 + 2 * B * a + C == pytest.approx(couple, rel=1e-8)
    if math.isfinite(b):
        cross = mu * (a + b) ** 3 * 4 * x**2 / (5 * (1 + x) ** 4)
        assert A * a * b + B * (b - a) - C == pytest.approx(cross, rel=1e-8)
        other = shear_resistances(LAW, OUTER / math.e, b, a)
        assert other == pytest.approx((A, -B, C), rel=1e-12)


@pytest.mark.parametrize(("a", "b"), [(1.0, 1.0), (0.5, 1.5)])
def test_squeezing_slows_as_the_reduced_radius_says(a, b):
    """F = −6πμ(ab/(a+b))²U(1/h − 1/h_c): of equal spheres −(3/2)πμa²U/h."""
    gap, dt, scene = 0.01, 1e-9, pair(a, b, 0.01)
    scene.velocity[:, 0] = 0.5, -0.5
    force = scene.step(dt).impulse[:, 0] / dt
    expected = 6 * math.pi * VISCOSITY * (a * b / (a + b)) ** 2 * (1 / gap - 1 / OUTER)
    # The speed changes by 1e-7 in Δt.
    assert force == pytest.approx([-expected, expected], rel=1e-5)
    if a == b:
        equal = 1.5 * math.pi * VISCOSITY * a**2 / gap * (1 - gap / OUTER)
        assert expected == pytest.approx(equal, rel=1e-12)


def test_a_sphere_is_slowed_by_a_wall_and_not_beyond_the_outer_gap():
    """6πμa²U/h."""
    for gap in (0.02, 0.3):
        scene = Scene(
            [shapes.sphere(1.0)],
            [[5.0, 5.0, 1.0 + gap]],
            box=grid(periodic=(True, True, False)),
            parameters=lubricated(1),
        )
        scene.velocity[0, 2] = -1.0
        force = scene.step(1e-9).impulse[0, 2] / 1e-9
        expected = 6 * math.pi * VISCOSITY * (1 / gap - 1 / OUTER) if gap < OUTER else 0.0
        assert force == pytest.approx(expected, rel=1e-5)


def test_resistance_is_no_stronger_than_at_the_inner_gap():
    touching = squeeze_impulse(LAW, 0.0, -1.0, 0.5, 1.0, 1e-9)
    assert touching == squeeze_impulse(LAW, INNER, -1.0, 0.5, 1.0, 1e-9)
    assert touching > squeeze_impulse(LAW, 2 * INNER, -1.0, 0.5, 1.0, 1e-9)


@pytest.mark.parametrize("dt", [1e-6, 1e-3, 1.0, 1e6])
def test_one_step_of_any_size_only_slows(dt):
    """Exactly as exp(−Zt/m) does along the line of centres."""
    gap = 0.05
    left = 1 + squeeze_impulse(LAW, gap, -1.0, 0.5, 2.0, dt) / 2.0 * -1.0
    rate = 6 * math.pi * VISCOSITY * 0.25 * (1 / gap - 1 / OUTER) / 2.0
    assert left == pytest.approx(math.exp(-rate * dt), rel=1e-9, abs=1e-15)
    scene = pair(1.0, 1.3, gap, most_substeps=1)
    generator = np.random.default_rng(1)
    scene.velocity[:], scene.spin[:] = 1e-9 * generator.normal(size=(2, 2, 3))
    before, momentum, turning = scene.energy, scene.momentum, scene.angular_momentum
    for _ in range(5):
        scene.step(dt)
        assert scene.energy <= before * (1 + 1e-12)
        before = scene.energy
    scale = np.abs(scene.mass[:, None] * scene.velocity).sum() + 1e-12
    assert scene.momentum == pytest.approx(momentum, abs=1e-13 * scale)
    if dt <= 1.0:
        assert scene.angular_momentum == pytest.approx(turning, abs=1e-12 * 10 * scale)


def test_spheres_that_turn_as_one_body_feel_nothing():
    scene = pair(0.6, 1.1, 0.02)
    spin = np.array([0.3, -0.7, 0.5])
    scene.spin[:] = spin
    scene.velocity[:] = np.cross(spin, scene.position)
    moved = scene.step(1e-9)
    # Resistances are of order 1 to 100; in Δt the line of centres turns by 1e-9.
    assert np.abs(moved.impulse).max() < 1e-9 * 1e-6
    assert np.abs(moved.angular_impulse).max() < 1e-9 * 1e-6


def test_shearing_and_rolling_match_the_resistances():
    """Force and torque on the first of two unequal spheres of which one moves or turns."""
    a, b, gap, dt = 1.0, 0.5, 0.01, 1e-9
    A, B, C = shear_resistances(LAW, gap, a, b)
    scene = pair(a, b, gap)
    scene.velocity[0, 1] = 1.0
    moved = scene.step(dt)
    arm = a + 0.5 * gap
    assert moved.impulse[0, 1] / dt == pytest.approx(-A, rel=1e-5)
    # The line of centres is along x: r×F = (0, 0, arm·F), and the couple with it.
    assert moved.angular_impulse[0, 2] / dt == pytest.approx(-(A * arm + B), rel=1e-5)
    scene = pair(a, b, gap)
    scene.spin[0, 2] = 1.0
    moved = scene.step(dt)
    assert moved.impulse[0, 1] / dt == pytest.approx(-(A * arm + B), rel=1e-5)
    torque = -(A * arm**2 + 2 * B * arm + C)
    assert moved.angular_impulse[0, 2] / dt == pytest.approx(torque, rel=1e-5)


def test_switched_off_it_changes_nothing():
    scenes = [pair(1.0, 1.0, 0.01, viscosity=v) for v in (0.0, VISCOSITY)]
    for scene in scenes:
        scene.velocity[0] = 0.1, 0.2, 0.0
    assert not scenes[0].step(1e-3).impulse.any()
    assert scenes[1].step(1e-3).impulse.all(axis=0)[:2].all()
