"""Rotation of rigid bodies against Euler's and Jacobi's tops."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from smoothprofile import rotations
from smoothprofile.particles.rigid import advance_rotation

MOMENTS = np.array([1.0, 2.0, 3.0])
INERTIA = np.diag(MOMENTS)[None]
TILTED = rotations.from_axis_angle([1.0, 2.0, -0.5], 0.7)[None]
STILL = np.zeros((1, 3))


def angular_momentum(
    quaternion: np.ndarray, angular_velocity: np.ndarray, inertia: np.ndarray
) -> np.ndarray:
    """R J RᵀΩ (n,3), in space."""
    turn = rotations.matrix(quaternion)
    return np.einsum("nij,njk,nlk,nl->ni", turn, inertia, turn, angular_velocity)


def energy(quaternion, spin, inertia=INERTIA):
    return 0.5 * np.sum(spin * angular_momentum(quaternion, spin, inertia), axis=1)


def turn(quaternion, spin, dt, count, torque=STILL, inertia=INERTIA):
    for _ in range(count):
        quaternion, spin = advance_rotation(quaternion, spin, inertia, torque, dt)
    return quaternion, spin


@pytest.mark.parametrize("turns", [30, pytest.param(1000, marks=pytest.mark.slow)])
def test_a_free_top_keeps_energy_and_angular_momentum(turns):
    spin = np.array([[0.6, 0.7, -0.4]])
    q, dt = TILTED, 2 * np.pi / np.linalg.norm(spin) / 60
    before, power = angular_momentum(q, spin, INERTIA), energy(q, spin)
    q, after = turn(q, spin, dt, 60 * turns)
    # 60 000 roundings of 1e-16 add up to less than 1e-11 even if they all have one sign; a rule
    # that were only second order accurate would be off by (ΔtΩ)² ~ 1e-2.
    drift = angular_momentum(q, after, INERTIA) - before
    assert np.abs(drift).max() < 1e-11 * np.linalg.norm(before)
    assert energy(q, after) == pytest.approx(power, rel=1e-11)
    assert np.abs(after - spin).max() > 0.1


def flips(dt, spin, until):
    """Times at which Ω along the middle axis of the body changes sign, by linear interpolation."""
    q, w = TILTED, rotations.rotate(TILTED, spin[None])
    along = [spin[1]]
    while len(along) * dt < until:
        q, w = advance_rotation(q, w, INERTIA, STILL, dt)
        along.append(rotations.rotate(rotations.conjugate(q), w)[0, 1])
    along = np.array(along)
    at = np.flatnonzero(along[1:] * along[:-1] < 0)
    return dt * (at + along[at] / (along[at] - along[at + 1]))


def test_the_middle_axis_flips_after_half_of_jacobis_period():
    """T = 4K(k)√(I₁I₂I₃/((I₃−I₂)(L²−2EI₁))), k² = (I₂−I₁)(2EI₃−L²)/((I₃−I₂)(L²−2EI₁))."""
    spin = np.array([0.02, 1.0, 0.01])
    twice_energy, square = np.sum(MOMENTS * spin**2), np.sum((MOMENTS * spin) ** 2)
    low, middle, high = MOMENTS
    # The roles of the two outer axes change with the sign of L² − 2EI₂.
    if square < twice_energy * middle:
        low, high = high, low
    scale = (high - middle) * (square - twice_energy * low)
    k2 = (middle - low) * (twice_energy * high - square) / scale
    half_period = 2 * ellipk(k2) * np.sqrt(np.prod(MOMENTS) / scale)
    errors = []
    for dt in (0.08, 0.04):
        between = np.diff(flips(dt, spin, 6 * half_period))
        assert len(between) >= 4
        errors.append(np.abs(between / half_period - 1).max())
    # Second order: 4 within what the interpolation of the sign change adds.
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.15)
    assert errors[1] < 1e-3


@pytest.mark.parametrize("angle", [0.3, 2.0, 3.6, 5.5, -1.2])
@pytest.mark.parametrize("axis", range(3))
def test_the_quaternion_turns_as_the_matrix_in_all_quadrants(axis, angle):
    """About a main axis, from another attitude: R(t) = exp(angle ê)R₀, ê = the axis in space."""
    attitude = rotations.from_axis_angle([0.3, -1.0, 2.0], 1.1 + angle)
    space = rotations.matrix(attitude)[:, axis]
    count = 400
    q, w = turn(attitude[None], angle * space[None], 1 / count, count)
    expected = rotations.matrix(rotations.from_axis_angle(space, angle)) @ rotations.matrix(
        attitude
    )
    # The Cayley map's angle is off by θ³/(12·400²) ≤ 9e-5.
    assert rotations.matrix(q[0]) == pytest.approx(expected, abs=1e-4)
    assert w[0] == pytest.approx(angle * space, abs=1e-11)


def reference(quaternion, spin, torque, time):
    """q̇ = (0, Ω)q/2 and L̇ = T in space, by an eighth-order method."""
    start = angular_momentum(quaternion, spin, INERTIA)[0]

    def rate(t, q):
        q = q / np.linalg.norm(q)
        r = rotations.matrix(q)
        w = r @ ((r.T @ (start + t * torque[0])) / MOMENTS)
        return 0.5 * rotations.multiply(np.array([0.0, *w]), q)

    return solve_ivp(rate, (0, time), quaternion[0], method="DOP853", rtol=1e-12, atol=1e-12).y[
        :, -1
    ]


@pytest.mark.parametrize("torque", [STILL, np.array([[0.5, -0.3, 0.8]])])
def test_the_attitude_is_of_second_order(torque):
    spin, time = np.array([[0.9, -0.4, 0.7]]), 3.0
    exact = rotations.matrix(reference(TILTED, spin, torque, time))
    errors = []
    for count in (40, 80, 160):
        q, w = turn(TILTED, spin, time / count, count, torque)
        errors.append(np.abs(rotations.matrix(q[0]) - exact).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.1)
    # L grows by exactly the torque's impulse.
    gained = angular_momentum(q, w, INERTIA) - angular_momentum(TILTED, spin, INERTIA)
    assert gained == pytest.approx(time * torque, abs=1e-12)


def test_bodies_do_not_see_each_other():
    generator = np.random.default_rng(1)
    q = rotations.normalise(generator.normal(size=(5, 4)))
    spin, torque = generator.normal(size=(2, 5, 3))
    inertia = np.array([np.diag(row) for row in generator.uniform(1, 2, (5, 3))])
    together = advance_rotation(q, spin, inertia, torque, 0.1)
    for b in range(5):
        row = slice(b, b + 1)
        alone = advance_rotation(q[row], spin[row], inertia[row], torque[row], 0.1)
        assert all(np.array_equal(t[row], a) for t, a in zip(together, alone, strict=True))
