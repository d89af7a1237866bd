"""Force-coupled spheres in a flow with inertia: Stokes' limit, books of momentum, drag, order."""

import math
from itertools import pairwise

import numpy as np
import pytest

from coupled import settle, simulation
from flows import box, make_flow, slope, start
from smoothprofile.errors import CaseError
from smoothprofile.flow.state import fluid_at_rest
from smoothprofile.flow.walls import Walls
from smoothprofile.force_coupled_flow import ForceCoupledFlow, Spheres
from smoothprofile.grid import interior
from smoothprofile.theory.release import periodic_resistance, speed_after_release
from smoothprofile.threads import set_thread_count
from smoothprofile.viscous.force_coupling import ForceCoupling
from smoothprofile.viscous.force_coupling_moments import strain

LENGTH = 8.0
STILL = (0.0, 0.0, 0.0)


def whirl(flow):
    """A smooth flow that moves, turns and strains what is in it."""
    k = 2.0 * math.pi / LENGTH
    return start(
        flow,
        (
            lambda x, y, z: np.cos(k * y) + 0 * (x + z),
            lambda x, y, z: np.sin(k * z) + 0 * (x + y),
            lambda x, y, z: np.sin(k * x) + 0 * (y + z),
        ),
    )


def pair(scheme="bdf2", cells=16, density=1.0, moving=True, tolerance=1e-9, mean=STILL, **changes):
    """Two unlike spheres, each under a force and a torque."""
    grid = box((cells,) * 3, (LENGTH,) * 3, (True,) * 3)
    flow = make_flow(grid, scheme, mean_velocity=mean, **changes)
    spheres = Spheres.of(
        [1.0, 1.3], density, [[5.0, 0.0, 0.0], [0.0, 0.0, -3.0]], [[0.0, 0.0, 4.0], [1.0, 2.0, 0.0]]
    )
    state = whirl(flow) if moving else fluid_at_rest(grid)
    place = [[3.0, 3.3, 4.0], [6.0, 4.4, 5.0]]
    return ForceCoupledFlow(flow, state, spheres, place, tolerance=tolerance)


def hold_places(run, monkeypatch):
    monkeypatch.setattr(run, "_move", lambda dt: None)


@pytest.mark.parametrize("density", [0.2, 1.0, 5.0])
def test_without_inertia_it_comes_to_rest_at_the_mobility_of_stokes_flow(density, monkeypatch):
    run = pair("backward-euler", density=density, moving=False, advection=False)
    hold_places(run, monkeypatch)
    place = run.motion.position
    for _ in range(30):
        report = run.step(5.0)
        assert report.converged
    stokes = ForceCoupling(run.flow.grid, 1.0, run.spheres.radius, tolerance=1e-9)
    exact = stokes.solve(place, run.spheres.force, run.spheres.torque)
    ours = run.motion
    # e^(−.6·150) is left of the start, and the two tolerances.
    assert np.allclose(ours.velocity, exact.velocity, atol=1e-7)
    assert np.allclose(ours.angular_velocity, exact.angular_velocity, atol=1e-7)
    assert np.allclose(ours.stresslet, exact.stresslet, atol=1e-6)
    assert np.allclose(ours.force, run.spheres.force, atol=1e-6)
    assert np.allclose(ours.torque, run.spheres.torque, atol=1e-6)
    for one, other in zip(run.state.velocity, stokes.velocity, strict=True):
        assert np.allclose(interior(one), interior(other), atol=1e-7)


def test_spheres_of_no_weight_leave_the_flow_alone():
    """The same bits as without them: neutral, unloaded, and not kept from being strained."""
    flows = [make_flow(box((16,) * 3, (LENGTH,) * 3, (True,) * 3), "bdf2") for _ in range(2)]
    states = [whirl(flow) for flow in flows]
    run = ForceCoupledFlow(flows[0], states[0], Spheres.of([1.0], 1.0), [[1.0] * 3], rigid=False)
    for _ in range(3):
        run.step(0.05)
        flows[1].step(states[1], 0.05)
    for ours, plain in zip(states[0].velocity, states[1].velocity, strict=True):
        assert np.array_equal(ours, plain)
    assert run.motion.velocity.any()


def momentum(run, excess=1.0):
    """∫ρu dV + Σ(m_p − m_f)V."""
    cell = (LENGTH / run.flow.grid.shape[0]) ** 3
    fluid = np.array([interior(u).sum() * cell for u in run.state.velocity])
    return fluid + excess * (run.excess[0][:, None] * run.motion.velocity).sum(axis=0)


@pytest.mark.parametrize("wrong", [False, True])
def test_fluid_and_spheres_gain_what_the_forces_give(wrong):
    run = pair("backward-euler", density=4.0, mean=(None, None, None), tolerance=1e-12)
    before = momentum(run, 0.5 if wrong else 1.0)
    for _ in range(10):
        run.step(0.05)
    gain = momentum(run, 0.5 if wrong else 1.0) - before
    given = 0.5 * run.spheres.force.sum(axis=0)
    # Round-off, and 1e-12 of the loads; half the inertia would show.
    assert np.allclose(gain, given, atol=1e-9) is not wrong


@pytest.mark.parametrize("scheme", ["backward-euler", "crank-nicolson", "bdf2", "bdf3"])
def test_each_step_obeys_newton_and_strains_no_sphere(scheme):
    run = pair(scheme, density=np.array([3.0, 1.5]))
    for _ in range(4):
        assert run.step(0.05).converged
        found = run.envelopes.gather(run.state.velocity)
        speed = np.abs(run.motion.velocity).max()
        assert np.abs(strain(found)).max() < 1e-7 * speed
        mass, inertia = run.excess
        change, turn = run.motion.change
        # 1e-9 of the power, of which they are the roots.
        assert np.allclose(run.motion.force, run.spheres.force - mass[:, None] * change, atol=1e-6)
        assert np.allclose(
            run.motion.torque, run.spheres.torque - inertia[:, None] * turn, atol=1e-6
        )


@pytest.mark.parametrize(("density", "least"), [(0.2, 0.9), (1.0, 1.7), (5.0, 1.8)])
def test_order_in_time(density, least):
    """Two, from rest; one for spheres lighter than the fluid, whose inertia comes a step late."""
    sizes, found = (0.1, 0.05, 0.025), []
    for dt in (*sizes, 0.0125):
        run = pair(density=density, moving=False, tolerance=1e-7)
        for _ in range(round(0.6 / dt)):
            run.step(dt)
        found.append(np.concatenate([run.motion.velocity, run.motion.position]))
    changes = [np.abs(a - b).max() for a, b in pairwise(found)]
    assert slope(sizes, changes) > least


def released(density, times, cells=24, step=0.1):
    grid = box((cells,) * 3, (LENGTH,) * 3, (True,) * 3)
    flow = make_flow(grid, "bdf2", mean_velocity=STILL, advection=False)
    weight = 6.0 * math.pi * 1e-3
    volume = 4.0 / 3.0 * math.pi
    # As gravity on what exceeds the fluid, so slow that it stays where it is.
    gravity = (weight / ((density - 1.0) * volume), 0.0, 0.0)
    run = ForceCoupledFlow(
        flow, fluid_at_rest(grid), Spheres.of([1.0], density, gravity=gravity), [[4.0] * 3]
    )
    found = []
    for _ in range(round(max(times) / step)):
        run.step(step)
        if any(abs(run.state.time - t) < 1e-9 for t in times):
            found.append(run.motion.velocity[0, 0])
    resistance = periodic_resistance(1.0, 1.0, 1.0, LENGTH)
    exact = speed_after_release(np.array(times), weight, density * volume, volume, resistance)
    return np.array(found) / exact - 1.0


def test_a_heavy_sphere_is_released():
    """Slow at first: a Gaussian sets more fluid in motion than the surface of a sphere does."""
    errors = released(5.0, (1.0, 2.0, 4.0))
    # Does not go away with cells or steps; .4 % at νt = 4a².
    assert np.all(np.abs(errors) < (0.03, 0.015, 0.005))
    assert np.all(errors < 0.0)


def test_walls_take_what_the_spheres_give():
    grid = box((16, 16, 16), (8.0, 8.0, 8.0), (True, True, False))
    kinds = (("periodic",) * 2, ("periodic",) * 2, ("wall", "wall"))
    flow = make_flow(grid, "backward-euler", walls=Walls(kinds))
    spheres = Spheres.of([1.0], 2.0, [[3.0, 0.0, 0.0]])
    run = ForceCoupledFlow(flow, fluid_at_rest(grid), spheres, [[4.0, 4.0, 2.0]], tolerance=1e-12)
    for _ in range(10):
        before = momentum(run)
        run.step(0.2)
    walls = flow.wall_force(run.state)
    rate = (momentum(run) - before) / 0.2
    # Along the walls, to round-off and 1e-12 of the loads; the nearer one takes more.
    assert np.allclose((rate + sum(walls.values()))[:2], [3.0, 0.0], atol=1e-10)
    assert walls["z_low"][0] > walls["z_high"][0] > 0.01


def test_threads_change_no_bit():
    found = []
    for threads in (1, 3):
        set_thread_count(threads)
        run = pair(density=3.0)
        for _ in range(2):
            run.step(0.05)
        found.append((run.state.velocity, run.motion))
    (one, ours), (other, theirs) = found
    assert all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
    assert np.array_equal(ours.velocity, theirs.velocity)
    assert np.array_equal(ours.stresslet, theirs.stresslet)


def test_what_cannot_be_run_is_refused():
    flow = make_flow(box((16,) * 3, (LENGTH,) * 3, (True,) * 3))
    with pytest.raises(CaseError, match="density of a sphere must be a number above 0"):
        Spheres.of([1.0], -1.0)
    with pytest.raises(CaseError, match="position has 2 rows; there are 1 spheres"):
        ForceCoupledFlow(flow, fluid_at_rest(flow.grid), Spheres.of([1.0], 1.0), np.zeros((2, 3)))


def terminal_speed(viscosity, force, rigid=True, cells=24):
    grid = box((cells,) * 3, (LENGTH,) * 3, (True,) * 3)
    flow = make_flow(grid, "bdf2", mean_velocity=STILL, viscosity=viscosity)
    spheres = Spheres.of([1.0], 1.0, [[force, 0.0, 0.0]])
    run = ForceCoupledFlow(flow, fluid_at_rest(grid), spheres, [[4.0] * 3], rigid=rigid)
    old = 0.0
    while abs(run.motion.velocity[0, 0] - old) > 2e-7 * old or run.state.steps < 20:
        old = run.motion.velocity[0, 0]
        run.step(0.1)
    return run.motion.velocity[0, 0]


@pytest.mark.slow
@pytest.mark.parametrize(("viscosity", "tolerance"), [(2.0, 0.01), (0.4, 0.01), (0.2, 0.02)])
def test_drag_with_inertia_is_that_of_the_smoothed_profile_method(viscosity, tolerance):
    """Re = 2aV/ν = 1, 5.7, 12; without stresslets Re = 12 is 3 % off."""
    force = 6.0 * math.pi * viscosity / 0.6532 * (1.0 + 0.06 * (2.0 / viscosity) ** 0.8)
    speed = terminal_speed(viscosity, force)
    run = simulation(
        {"shape": "sphere", "radius": 1.0, "position": [4.0] * 3},
        lengths=[LENGTH] * 3,
        cells=[48] * 3,
        viscosity=viscosity,
        thickness=0.25,
        mean_velocity={"x": speed},
        scheme="bdf2",
        step=0.05,
    )
    settle(run, 1e-5)
    assert run.particles[0]["force"][0] == pytest.approx(force, rel=tolerance)
