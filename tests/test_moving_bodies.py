"""Bodies that move freely: momentum of crowds, light bodies, impulses of contact."""

import numpy as np
import pytest

import smoothprofile as sp
from coupled import SCHEMES, STILL, free, momentum, simulation, steps
from smoothprofile import shapes
from smoothprofile.particles.dynamics import _flatness
from smoothprofile.schemes import SCHEMES as TABLES


def crowd(count, densities, cells, seed=3, **more):
    """Spheres that fly about in a periodic cube and collide: (run, spheres' excess mass (n,))."""
    generator = np.random.default_rng(seed)
    side, radius = 4.0, 0.4
    places = [
        p + 0.02 * generator.uniform(-1, 1, 3)
        for p in np.ndindex(4, 4, 4)
        for p in [0.5 + np.array(p)]
    ]
    bodies = [
        free(
            list(place % side),
            float(densities[i % len(densities)]),
            radius,
            velocity=generator.normal(size=3).tolist(),
            angular_velocity=(0.5 * generator.normal(size=3)).tolist(),
        )
        for i, place in enumerate(places[:count])
    ]
    run = simulation(
        *bodies, cells=[cells] * 3, thickness=0.15, viscosity=0.2, step=0.01, retract=False, **more
    )
    excess = np.array([p.density for p in run.case.particles]) - run.case.fluid.density
    return run, excess * run.bodies.displaced.volume


def drift(run, excess, count):
    """Largest drift of the momentum in `count` steps over Σ|mV|; and how many bodies collided."""
    state = run.bodies.state
    whole = lambda: momentum(run) + excess @ state.velocity  # noqa: E731
    mass = excess + run.case.fluid.density * run.bodies.displaced.volume
    scale = np.sum(mass * np.linalg.norm(state.velocity, axis=1))
    start, worst, hit = whole(), 0.0, np.zeros(len(mass), dtype=bool)
    for _ in range(count):
        steps(run, 1)
        hit |= np.any(run.bodies.free.contact_history.velocity_gain != 0.0, axis=1)
        worst = max(worst, np.abs(whole() - start).max())
    return worst / scale, int(hit.sum())


@pytest.mark.parametrize("scheme", ["backward-euler", "bdf2"])
def test_what_collides_keeps_its_momentum(scheme):
    worst, hit = drift(*crowd(20, (1.0, 2.0, 8.0), 24, scheme=scheme), 20)
    assert hit > 5
    # Sums over 14 000 cells, 20 times: round-off.
    assert worst < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("scheme", SCHEMES[:3])
def test_fifty_colliding_bodies_for_a_thousand_steps(scheme):
    sp.threads.set_thread_count(2)
    worst, hit = drift(*crowd(50, (1.0, 2.0, 8.0), 32, scheme=scheme), 1000)
    print(f"\n{scheme}: drift {worst:.1e} of Σ|mV|, {hit} of 50 collided")
    assert hit > 40
    assert worst < 1e-12


@pytest.mark.parametrize("scheme", ["backward-euler", "bdf2"])
@pytest.mark.parametrize("count", [30, pytest.param(1000, marks=pytest.mark.slow)])
def test_light_bodies_give_back_what_their_inertia_takes_late(count, scheme):
    """∫ρu dV + Σ(M−ρV)Vⁿ + C(Vⁿ−Vⁿ⁻¹) is constant, and the last sum is small."""
    run, excess = crowd(20, (0.5, 2.0), 24, scheme=scheme)
    state, virtual = run.bodies.state, run.bodies.free._virtual
    mass = excess + run.case.fluid.density * run.bodies.displaced.volume
    scale = np.sum(mass * np.linalg.norm(state.velocity, axis=1))
    start = momentum(run) + excess @ state.velocity
    steps(run, count - 1)
    before = state.velocity.copy()
    steps(run, 1)
    change = momentum(run) + excess @ state.velocity - start
    owed = virtual @ (state.velocity - before)
    # Round-off, as without light bodies.
    assert np.abs(change + owed).max() < 1e-12 * scale
    assert np.abs(change).max() < 2e-3 * scale


@pytest.mark.parametrize(("density", "ratio"), [(0.1, 0.25), (0.5, 0.15)])
def test_light_bodies_are_stable_however_thin_they_are_painted(density, ratio):
    """√(νΔt) far below ξ paints a sphere so small that too little fluid sticks to it."""
    thickness, nu = 0.16, 0.3
    run = simulation(
        free([2, 2, 2], density, angular_velocity=[0.1, 0.0, 0.0]),
        scheme="bdf2",
        step=(ratio * thickness) ** 2 / nu,
        cells=[20] * 3,
        thickness=thickness,
        viscosity=nu,
        advection=False,
        gravity=[0.0, 0.0, -1.0],
        mean_velocity=STILL,
        kind="tanh",
    )
    spins, speeds = [], []
    for _ in range(150):
        state = steps(run, 1).bodies.state
        spins.append(abs(state.angular_velocity[0, 0]))
        speeds.append(state.velocity[0, 2])
    # Released from rest it speeds up ever less. Its spin may swing, but dies away; with a virtual
    # mass that knows nothing of the layer both would grow without end.
    assert 0.0 < speeds[-1] - speeds[-2] < 0.2 * max(np.diff(speeds))
    assert max(spins[-50:]) < 0.5 * spins[0]


def test_flat_bodies_take_more_virtual_mass():
    """An oblate 2.8:1 spheroid of a tenth of the fluid's density rises as steadily as any."""
    body = {"shape": "ellipsoid", "radii": [0.7, 0.7, 0.25], "position": [1.5, 1.5, 1.5]}
    turn = {"axis": [1.0, 0, 0], "angle": 20.0}
    nu, thickness = 0.1, 0.12
    speeds = []
    for scheme in ("backward-euler", "bdf2"):
        run = simulation(
            {**body, "orientation": turn, "motion": "free", "density": 0.1},
            scheme=scheme,
            step=(0.4 * thickness) ** 2 / nu,
            lengths=[3.0] * 3,
            cells=[30] * 3,
            thickness=thickness,
            viscosity=nu,
            advection=False,
            gravity=[0.0, 0.0, -1.0],
            mean_velocity=STILL,
        )
        speeds.append(steps(run, 60).bodies.state.velocity[0, 2])
    # Unstable, the two would differ by more than all of it.
    assert speeds[0] == pytest.approx(speeds[1], rel=0.03)
    inertia = np.array([shapes.sphere(1.0).inertia, shapes.ellipsoid((1, 1, 0.36)).inertia])
    assert _flatness(inertia) == pytest.approx([1.0, 5.2], abs=0.1)


@pytest.mark.parametrize("name", ["backward-euler", "crank-nicolson", "bdf2", "bdf3"])
def test_an_impulse_of_contact_shows_at_once_and_in_full(name):
    """A body alone, M dV/dt = ΣJδ: V jumps by J/M with the first step and stays."""
    run = simulation(free([2, 2, 2], 2.0), free([2, 2, 3.8], 2.0))
    moving, scheme = run.bodies.free, TABLES[name]
    jump, past = np.ones((2, 6)), [0.0] * len(scheme.past)
    moving.contact_impulses, velocity = [], []
    for step in range(5):
        moving.contact_impulses.insert(0, jump if step == 0 else 0.0 * jump)
        known = moving._kick(scheme)[0, 0] + sum(
            a * v for a, v in zip(scheme.past, past, strict=True)
        )
        velocity.append(known / scheme.gamma)
        past = [velocity[-1], *past[:-1]]
    assert velocity == pytest.approx([1.0] * 5, abs=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("density", [0.1, 1.001, 10.0])
def test_a_thousand_steps_and_a_finer_grid(density):
    """Terminal speeds in a periodic box at 4 and at 8 cells to the radius."""
    sp.threads.set_thread_count(2)
    speeds = []
    for cells in (24, 48):
        run = simulation(
            free([3, 3, 3], density, 1.0),
            lengths=[6.0] * 3,
            cells=[cells] * 3,
            kind="quartic-centred",
            thickness=0.75,
            step=0.02,
            scheme="bdf2",
            viscosity=1.0,
            gravity=[0.0, 0.0, -1.0 / abs(density - 1.0)],
            mean_velocity=STILL,
        )
        speeds.append(abs(steps(run, 1000).bodies.state.velocity[0, 2]))
    c = 4 / 3 * np.pi / 216
    stokes = 2 / 9 * (1 - 1.7601 * c ** (1 / 3) + c - 1.5593 * c**2)
    print(f"\nρp/ρf = {density}: {speeds}, Stokes {stokes:.5f}")
    # Re = .2; three cells to ξ leave the grid's mark.
    assert speeds[0] == pytest.approx(speeds[1], rel=0.01)
    assert speeds[1] == pytest.approx(stokes, rel=0.02)
