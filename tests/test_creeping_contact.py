"""Contact without inertia: gaps, forces, and steps that hold however stiff it is."""

import math

import numpy as np
import pytest

from quasistatic_boxes import ball, run_of_box
from smoothprofile.particles import contact_creep

STOKES = 6.0 * math.pi


def chain(count, forces, gap=0.15, step=0.1, **changes):
    """Beads in a row along x, each pulled along it."""
    length = count * (2.0 + gap) + 1.85
    cells = math.ceil(3.5 * length)
    row = [
        ball([1.9 + (2.0 + gap) * n, 2.5, 2.5], force=[force, 0.0, 0.0])
        for n, force in enumerate(forces)
    ]
    changes = {"time": {"end": 2.5, "step": step}, "contact": {"range": 0.25}, **changes}
    side = [cells / 3.5, 5.0, 5.0]
    return run_of_box(
        *row, side=side, cells=[cells, 18, 18], profile={"thickness": 2.5 / 3.5}, **changes
    )


def gaps_of(run):
    return np.diff(run.bodies.state.position[:, 0]) - 2.0


def law(run, gap):
    """Force of a pair of equal bodies at that gap."""
    force = 0.5 * run.bodies.contact.parameters.touch_force[0]
    return force * (1.0 - gap / 0.25) ** 2


def test_pressed_pair_comes_to_rest_where_its_repulsion_holds_it():
    run = chain(2, [STOKES, -STOKES])
    run.run()
    (gap,) = gaps_of(run)
    assert law(run, gap) == pytest.approx(STOKES, rel=1e-3)
    # A lone bead would have moved at 1.
    assert np.abs(run.bodies.state.velocity).max() < 1e-3
    # What contact gives one it takes from the other, to round-off.
    assert run.bodies._contact().sum(axis=0) == pytest.approx(np.zeros(6), abs=1e-9)


def test_the_force_of_a_pair_is_there_within_four_steps():
    run = chain(2, [STOKES, -STOKES])
    forces = []
    for _ in range(7):
        run.step_once()
        forces.append(-run.bodies._contact()[0, 0])
    # The film makes the sub-steps' mobility that of the fluid within a third.
    assert forces[5:] == pytest.approx([STOKES] * 2, rel=0.02)
    assert max(forces) < 1.2 * STOKES


def test_long_chain_is_held_without_overlap_and_without_oscillation():
    count = 8
    pulls = STOKES * np.cos(math.pi * (np.arange(count) + 0.5) / count)
    run = chain(count, pulls)
    sizes = []
    while run.status == "running":
        run.step_once()
        assert gaps_of(run).min() > 0.0
        sizes.append(np.abs(run.bodies.state.velocity[:, 0]).max())
    # Each step is closer to rest than the one before, once contact is there.
    assert np.all(np.diff(sizes[4:]) < 1e-3)
    assert sizes[-1] < 0.05 * sizes[0]


@pytest.mark.parametrize(("share", "holds"), [(contact_creep.SHARE, True), (0.02, False)])
def test_long_steps_hold_unless_the_mobility_is_far_below_the_true_one(monkeypatch, share, holds):
    monkeypatch.setattr(contact_creep, "SHARE", share)
    # Four times what "auto" takes: kMΔt is 3 with the true mobility of the pair.
    run = chain(2, [STOKES, -STOKES], time={"end": 4.0, "step": 0.4})
    forces = []
    while run.status == "running":
        run.step_once()
        forces.append(-run.bodies._contact()[0, 0])
    last = max(forces[-4:]) - min(forces[-4:])
    assert (last < 0.05 * STOKES) == holds


def test_bodies_that_contact_does_not_reach_move_as_if_there_were_none():
    near, far = (
        chain(2, [1.0, 1.0], contact={"range": reach}, time={"end": 0.3, "step": 0.1})
        for reach in (0.01, 0.02)
    )
    near.run()
    far.run()
    assert np.array_equal(near.bodies.state.position, far.bodies.state.position)


def test_heap_on_a_wall_rests_with_gaps():
    heap = [ball([2.5, 2.5, z], density=2.0) for z in (1.1, 3.3)]
    run = run_of_box(
        *heap, side=[5.0, 5.0, 6.25], cells=[16, 16, 20],
        boundaries=("periodic", "periodic", "wall"),
        fluid={"gravity": [0.0, 0.0, -4.5]}, profile={"thickness": 0.75},
        time={"end": 4.0, "step": 0.2},
    )  # fmt: skip
    run.run()
    low, high = run.bodies.state.position[:, 2]
    assert low > 1.0
    assert high - low > 2.0
    assert np.abs(run.bodies.state.velocity).max() < 0.02
    # The wall bears both.
    weight = 2.0 * 4.5 * 4.0 / 3.0 * math.pi
    pushed = run.bodies.free.wall_impulse[2, 0, 2] / run.time_step
    assert pushed == pytest.approx(-weight, rel=0.02)


def test_lubrication_slows_what_the_grid_does_not_resolve():
    speeds, gaps = [], []
    for lubrication in (False, True):
        run = chain(
            2, [1.0, -1.0], gap=0.2, time={"end": 0.6, "step": 0.05},
            contact={"range": 0.3, "lubrication": lubrication},
        )  # fmt: skip
        # The repulsion alone is off.
        run.bodies.contact._masses.touch_force[:] = 1e-12
        while run.status == "running":
            before = gaps_of(run)[0]
            run.step_once()
        speeds.append((before - gaps_of(run)[0]) / run.time_step)
        gaps.append(gaps_of(run)[0])
    plain, slowed = speeds
    resistance = STOKES * 0.25 * (1.0 / gaps[1] - 1.0 / 0.3)
    # A pair that gives way by `plain` to a force of 1, and to what lubrication takes off it. Its
    # two runs end at gaps that differ by .002, and its speed with it by 1 %.
    assert slowed == pytest.approx(plain / (1.0 + resistance * plain), rel=0.03)
