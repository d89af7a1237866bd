"""Bodies that move freely."""

import math
from dataclasses import replace

import numpy as np
import pytest

from coupled import SCHEMES, STILL, free, momentum, simulation, sphere, steps
from smoothprofile import rotations
from smoothprofile.errors import CaseError
from smoothprofile.particles.contact import ContactHistory
from smoothprofile.schemes import SCHEMES as SCHEME_TABLES


def total_momentum(run):
    """Of fluid and bodies: the fluid's fills the bodies too, so that theirs is the excess."""
    state, body = run.bodies.state, run.bodies.displaced
    excess = np.array([p.density for p in run.case.particles]) - run.case.fluid.density
    return momentum(run) + ((excess * body.volume)[:, None] * state.velocity).sum(axis=0)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_what_the_fluid_gains_bodies_lose(scheme):
    """Two spheres of other densities set going in a periodic box, spinning, at 30 steps each."""
    bodies = [
        free([1.2, 2, 2], 3.0, velocity=[0.3, 0.1, 0.0], angular_velocity=[0.0, 1.0, 2.0]),
        free([2.9, 2, 2.1], 1.5, velocity=[-0.2, 0.1, 0.4]),
    ]
    run = simulation(*bodies, scheme=scheme, cells=[20] * 3, thickness=0.2)
    start = total_momentum(run)
    scale = np.abs(start).max()
    steps(run, 30)
    # Sums over 8000 cells, 30 times: round-off.
    assert np.abs(total_momentum(run) - start).max() < 1e-12 * scale
    assert np.ptp(run.bodies.state.velocity, axis=0).max() > 1e-3 * scale


@pytest.mark.parametrize("density", [0.1, 1.5, 10.0])
def test_a_sphere_falls_at_its_terminal_velocity(density):
    """Stokes' drag over Hasimoto's factor for a cubic lattice at c = .0082, K = 1.530."""
    ball = free([4.0, 4.0, 4.0], density, radius=1.0)
    run = simulation(
        ball,
        lengths=[8.0] * 3,
        cells=[40] * 3,
        thickness=0.3,
        mean_velocity=STILL,
        gravity=[0.0, 0.0, -1.0],
        advection=False,
        step=0.2,
        viscosity=1.0,
    )
    steps(run, 30 if density < 2 else 100)
    c = 4 / 3 * math.pi / 512
    slowed = 1 - 1.7601 * c ** (1 / 3) + c - 1.5593 * c**2
    terminal = (1 - density) * 4 / 3 * math.pi / (6 * math.pi) * slowed
    # A few time constants; the mesh of 3/2 cells to ξ leaves a percent.
    assert run.bodies.state.velocity[0, 2] == pytest.approx(terminal, rel=0.03)
    weight = (density - 1) * 4 / 3 * math.pi
    assert run.bodies.state.force[0, 2] == pytest.approx(weight, rel=0.03)


def tumble(scheme, turns):
    """A free ellipsoid that no fluid acts on, turned as runs turn bodies: energies, momenta."""
    top = {"shape": "ellipsoid", "radii": [1.0, 0.7, 0.5], "position": [2, 2, 2]}
    turning = {"density": 2.0, "motion": "free", "angular_velocity": [0.9, 0.4, -0.2]}
    bodies = simulation({**top, **turning}, scheme=scheme, retract=False).bodies
    state, free, used = bodies.state, bodies.free, SCHEME_TABLES[scheme]
    nothing = np.zeros((1, 6, 6)), np.zeros((1, 6))
    dt = 2 * np.pi / np.linalg.norm(state.angular_velocity) / 60
    past, energies, momenta = [], [], []
    for n in range(60 * turns + 1):
        turn, inertia = state.rotation, 2.0 * bodies.displaced.inertia
        spin = (turn @ inertia @ np.swapaxes(turn, 1, 2))[0] @ state.angular_velocity[0]
        momenta.append(spin)
        energies.append(0.5 * spin @ state.angular_velocity[0])
        past.insert(0, (state.velocity.copy(), state.angular_velocity.copy()))
        free.remember(state, used.levels)
        free.place(state, past, (n + 1) * dt, n * dt)
        free.solve(state, past, used.with_levels(min(n + 1, used.levels)), dt, *nothing)
        del past[2:]
    return np.array(energies), np.array(momenta), state


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("turns", [10, pytest.param(1000, marks=pytest.mark.slow)])
def test_a_top_in_vacuum_keeps_its_energy_and_its_angular_momentum(scheme, turns):
    """60 steps to a turn. Turning it by extrapolated Ω loses 1e-3 in ten turns, with any scheme."""
    energies, momenta, state = tumble(scheme, turns)
    assert np.ptp(energies) < 1e-10 * energies[0]
    assert np.abs(momenta - momenta[0]).max() < 1e-10 * np.linalg.norm(momenta[0])
    # It does tumble, far from where it began.
    assert np.abs(state.angular_velocity - [0.9, 0.4, -0.2]).max() > 0.1


def test_a_light_body_goes_on_turning_as_contact_made_it():
    """After a push, the step without contact turns it by the mean of its rates before and after."""
    grain = {"shape": "ellipsoid", "radii": [1.2, 0.7, 0.7], "position": [2, 2, 2]}
    run = simulation(
        {**grain, "motion": "free", "density": 0.1},
        lengths=[4.0] * 3, cells=[16] * 3, kind="quartic-centred", thickness=0.45, viscosity=0.1,
        step=0.02, scheme="bdf2",
    )  # fmt: skip
    steps(run, 3)
    state, free = run.bodies.state, run.bodies.free
    move, moment = free.contact.move, np.array([[0.0, 0.01, 0.0]])

    def push(*arguments):
        gain = (np.linalg.inv(free._own_inertia) @ moment[..., None])[..., 0]
        history = ContactHistory(np.zeros((1, 3)), gain)
        free.contact.move = move
        return replace(move(*arguments), angular_impulse=moment, history=history)

    free.contact.move = push
    steps(run, 1)
    before, spin = state.quaternion[0].copy(), state.angular_velocity[0, 1]
    steps(run, 1)
    turn = rotations.multiply(state.quaternion[0], before * [1, -1, -1, -1])
    # Half of the jump is the most that a rate extrapolated across it may be off by. Taking all of
    # the moment for the body's own, a thirtieth of what turns at first, misses by 6 times the rate.
    mean = 0.5 * (spin + state.angular_velocity[0, 1])
    assert 2.0 * turn[2] / 0.02 == pytest.approx(mean, abs=0.5 * spin)


def test_the_table_tells_of_a_few_bodies_and_counts_the_rest():
    lattice = [free([1 + 2 * i, 1 + 2 * j, 1 + 2 * k], 2.0)
               for i in range(2) for j in range(2) for k in range(2)]  # fmt: skip
    run = simulation(*lattice, gravity=[0.0, 0.0, -1.0], mean_velocity=STILL)
    steps(run, 2)
    table = {name: (value, note) for name, value, note in run.table()}
    assert sum(name.startswith("velocity of") for name in table) == 6
    assert table["other bodies"] == ("2", "see particles.csv")
    assert table["mean velocity"][1] == "of all 8 bodies"
    # What is true of all stands before the first of more than three bodies.
    names = list(table)
    first = next(name for name in names if name.startswith("velocity of"))
    assert names.index("mean velocity") < names.index(first)


def test_a_free_body_that_starts_spinning_is_painted_for_its_drag():
    """Only one that is turned in its place, as prescribed, is painted for its torque."""
    spin = {"angular_velocity": [0.0, 0.0, 1.0]}
    offsets = [
        simulation(body).particles[0]["painted_offset"]
        for body in (free([2, 2, 2], 2.0), free([2, 2, 2], 2.0, **spin), sphere([2, 2, 2], **spin))
    ]
    assert offsets[0] == offsets[1]
    assert offsets[2] != pytest.approx(offsets[0], rel=0.01)


def test_a_free_body_takes_no_course():
    with pytest.raises(CaseError, match=r"'bead', which moves freely"):
        simulation(free([2, 2, 2], 2.0, name="bead"), courses={"bead": None})
