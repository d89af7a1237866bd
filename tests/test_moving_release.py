"""Bodies that set off: spheres released from rest, against Basset and its periodic kin."""

from dataclasses import replace

import numpy as np
import pytest

from coupled import simulation, sphere, steps
from smoothprofile.theory.release import (
    periodic_resistance,
    speed_after_release,
    unbounded_resistance,
)

STILL = {"x": 0.0, "y": 0.0, "z": 0.0}
VOLUME = 4.0 / 3.0 * np.pi
TIMES = (0.1, 0.5, 1.0, 2.0)
# V/V_t of a lone sphere at νt/a² = .1, .5, 1, 2, from added mass and Basset's force in closed form.
BASSET = {
    1.5: (0.132716, 0.366252, 0.496779, 0.620717),
    5.0: (0.065827, 0.241006, 0.376722, 0.533123),
}


@pytest.mark.parametrize("ratio", BASSET)
def test_a_lone_sphere_speeds_up_as_basset_says(ratio):
    drag = unbounded_resistance(1.0, 1.0, 1.0)
    found = speed_after_release(TIMES, 6 * np.pi, ratio * VOLUME, VOLUME, drag)
    # To the digits of the closed form.
    assert found == pytest.approx(BASSET[ratio], abs=1e-6)


def test_a_lattice_of_spheres_has_hasimotos_drag_and_ends_as_a_lone_one():
    """K = 1/(1 − 1.7601c^⅓ + c − 1.5593c²); far apart, Basset's resistance at any s."""
    slow = np.array([1e-9 + 0j])
    for length in (8.0, 12.0):
        c = VOLUME / length**3
        hasimoto = 6 * np.pi / (1 - 1.7601 * c ** (1 / 3) + c - 1.5593 * c**2)
        # Terms c^(8/3) were left out of Hasimoto's series.
        assert periodic_resistance(1, 1, 1, length)(slow).real == pytest.approx(hasimoto, rel=2e-4)
    s = np.array([1.0 + 0j, 3 + 3j])
    # A lone sphere moves in fluid at rest, one in a cell against its backflow, c = 2e-5 of it, and
    # images 60a away.
    far = periodic_resistance(1, 1, 1, 60.0)(s)
    assert far == pytest.approx(unbounded_resistance(1, 1, 1)(s), rel=5e-3)


def release(ratio, cells, thickness, dt, times, side=6.0):
    """V over the exact one at those times, of a sphere of radius 1 in a periodic cube."""
    run = simulation(
        sphere([side / 2] * 3, 1.0, motion="free", density=ratio),
        scheme="bdf2",
        step=dt,
        lengths=[side] * 3,
        cells=[cells] * 3,
        kind="quartic-centred",
        thickness=thickness,
        viscosity=1.0,
        advection=False,
        gravity=[0.0, 0.0, -1.0],
        mean_velocity=STILL,
    )
    pull = (ratio - 1.0) * VOLUME
    drag = periodic_resistance(1.0, 1.0, 1.0, side)
    exact = speed_after_release(times, pull, ratio * VOLUME, VOLUME, drag)
    found = []
    for time in times:
        steps(run, round((time - run.time) / dt))
        found.append(-run.bodies.state.velocity[0, 2])
    return np.array(found) / exact


@pytest.mark.parametrize("ratio", [0.1, 5.0])
def test_a_sphere_released_in_a_periodic_box(ratio):
    """At νt/a² = .5 and 1, ξ = .6a: 1.3 % were seen, of second order in ξ over √(νt)."""
    assert release(ratio, 30, 0.6, 0.02, (0.5, 1.0)) == pytest.approx(1.0, abs=0.025)


@pytest.mark.slow
@pytest.mark.parametrize("ratio", BASSET)
def test_release_with_a_thin_layer(ratio):
    """Two per cent from νt/a² = .1 on, where √(νt) is the layer's own thickness, ξ = .3a."""
    found = release(ratio, 64, 0.3, 0.005, TIMES)
    print(f"\nρp/ρf = {ratio}: V/exact − 1 = {100 * (found - 1)} %")
    assert found == pytest.approx(1.0, abs=0.02)


def speed_in_a_shaken_box(scheme, dt, density=3.0):
    """V at t = 1.28 of a sphere in fluid that a smooth push sets going, all slow."""
    run = simulation(
        sphere([2, 2, 2], 0.9, motion="free", density=density),
        scheme=scheme,
        step=dt,
        cells=[24] * 3,
        thickness=0.25,
        viscosity=0.3,
        advection=False,
    )
    still, push = run.grid.zeros(), run.grid.zeros() + 1e-6

    def forcing(t):
        return still, still, np.sin(np.pi * t / 1.28) ** 4 * push

    run.flow.parameters = replace(run.flow.parameters, forcing=forcing)
    return 1e6 * steps(run, round(1.28 / dt)).bodies.state.velocity[0, 2]


@pytest.mark.slow
@pytest.mark.parametrize(("scheme", "order"), [("backward-euler", 1), ("bdf2", 2)])
def test_free_motion_has_the_order_of_the_scheme(scheme, order):
    """Δt halved three times, the surface painted anew for each."""
    speeds = np.array([speed_in_a_shaken_box(scheme, dt) for dt in (0.16, 0.08, 0.04, 0.02)])
    changes = np.abs(np.diff(speeds))
    found = np.log2(changes[:-1] / changes[1:])
    print(f"\n{scheme}: orders {found}")
    # What painting leaves, 1e-4, bounds the finest; where errors change sign, orders look higher.
    assert found.min() > order - 0.2
    if order == 1:
        assert found.max() < 1.6


@pytest.mark.parametrize("density", [1.0, 2.0])
def test_a_free_body_starts_at_its_velocity(density):
    """The fluid inside and around moves with it from the start: hardly any is lost in a step."""
    run = simulation(
        sphere(
            [2, 2, 2],
            motion="free",
            density=density,
            velocity=[0.5, 0, 0],
            angular_velocity=[0, 0, 1.0],
        ),
        cells=[20] * 3,
        viscosity=0.02,
        retract=False,
        step=0.005,
    )
    inside = run.particles[0]["interior_velocity"]
    steps(run, 1)
    # Without it, a body of the fluid's density would come to rest at once. The layer's own fluid
    # takes a share within a step, ξ/a of the whole at most.
    assert inside == pytest.approx([0.5, 0, 0], abs=0.01)
    assert 0.42 < run.bodies.state.velocity[0, 0] < 0.5
    assert 0.7 < run.bodies.state.angular_velocity[0, 2] < 1.0


def test_bodies_at_rest_in_fluid_at_rest_start_from_nothing():
    run = simulation(sphere([2, 2, 2], motion="free", density=2.0))
    assert not any(np.any(component) for component in run.state.velocity)
