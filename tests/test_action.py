"""Loads of a field on bodies that move: when they are found, how old they are, what drives them."""

import math

import numpy as np
import pytest

from case_makers import refusal, small_case, sphere
from smoothprofile.assembly import build_action, build_grid
from smoothprofile.config import load_case
from smoothprofile.electric.action import ElectricAction, NoField
from smoothprofile.errors import BlowUpError
from smoothprofile.particles.bodies import BodyState, bodies_at

UPRIGHT = [1.0, 0.0, 0.0, 0.0]


def coupled_case(*beads, electric, boundaries=("periodic",) * 3, cells=16):
    """Beads and a fluid in a cube of side 8."""
    case = small_case(*beads, boundaries=boundaries)
    case["domain"] |= {"lengths": [8, 8, 8], "cells": [cells] * 3, "origin": [-4, -4, -4]}
    return load_case({**case, "electric": electric})


def action_of(case) -> ElectricAction:
    return build_action(case, build_grid(case.domain))


def pair(**electric):
    beads = [sphere(position=[0, 0, z], permittivity=10.0) for z in (-1.8, 1.8)]
    return coupled_case(*beads, electric={"field": [0, 0, 1], "tolerance": 1e-8, **electric})


def at_gap(gap) -> BodyState:
    half = 1.0 + gap / 2
    return bodies_at([[0, 0, -half], [0, 0, half]], [UPRIGHT] * 2)


def test_loads_are_held_for_as_many_steps_as_asked():
    action = action_of(pair(every=3))
    gaps = 1.6 - 0.05 * np.arange(7)
    found = [action(at_gap(gap), 0.1 * i)[0, 2] for i, gap in enumerate(gaps)]
    assert found[0] == found[1] == found[2]
    assert found[3] == found[4] == found[5]
    assert len({found[0], found[3], found[6]}) == 3


def test_the_lag_tells_what_holding_leaves_out():
    """Two beads that close in steadily: the held force is behind by the lag, at most."""
    every, steps = 4, 17
    held, fresh = action_of(pair(every=every)), action_of(pair())
    worst, lags = 0.0, []
    for i in range(steps):
        state = at_gap(1.6 - 0.02 * i)
        old, new = held(state, 0.0)[:, :3], fresh(state, 0.0)[:, :3]
        if i % every == 0:
            lags.append(held.lag)
        worst = max(worst, np.abs(old - new).max() / np.abs(new).max())
    # The lag counts m steps, the held loads lack at most m − 1, of a change that hardly varies.
    assert worst <= max(lags)
    assert worst >= 0.5 * max(lags)
    assert lags[0] == 0.0
    # A step changes a quarter of what four do.
    assert fresh.lag == pytest.approx(max(lags) / every, rel=0.25)


def test_every_step_it_starts_from_the_potential_before():
    """Two hundredths of a radius need fewer iterations than a start from nothing."""
    action = action_of(pair(tolerance=1e-4))
    action(at_gap(1.6), 0.0)
    first = action.report.iterations
    action(at_gap(1.59), 0.0)
    assert 0 < action.report.iterations < first


def test_an_alternating_field_passes_through_zero():
    """Where it is all but zero, the potential of the step before is no start."""
    action = action_of(pair(angular_frequency=1.0))
    full = action(at_gap(1.0), 0.0)[0, 2]
    least = action(at_gap(1.0), math.pi / 2)[0, 2]
    # cos² of a right angle's round-off is 4e-33.
    assert 0.0 <= least < 1e-30 * full
    again = action(at_gap(1.0), math.pi / 3)[0, 2]
    assert again == pytest.approx(full / 4, rel=1e-6)


def test_a_rotating_field_turns_the_drive_and_not_a_sphere():
    bead = sphere(permittivity=10.0, position=[0.13, 0.21, -0.3])
    electric = {"field": [1, 0, 0], "quadrature": [0, 1, 0], "angular_frequency": 2.0}
    action = action_of(coupled_case(bead, electric={**electric, "tolerance": 1e-8}))
    state = bodies_at([[0.13, 0.21, -0.3]], [UPRIGHT])
    angles = []
    for time in (0.0, 0.2, 0.5, 1.1):
        loads = action(state, time)
        dipole = action.loads.dipole[0]
        # Loads on a sphere are central at every point of its layer.
        assert np.abs(loads[0, 3:]).max() < 1e-12 * np.linalg.norm(dipole)
        assert action.field.drive.field == pytest.approx(
            [math.cos(2 * time), math.sin(2 * time), 0]
        )
        angles.append(math.atan2(dipole[1], dipole[0]))
    # The grid and the cubic images give the dipole back along the field to a few thousandths.
    assert angles == pytest.approx([0.0, 0.4, 1.0, 2.2], abs=0.01)


def test_a_rotating_field_attracts_in_its_plane():
    """Over a turn ⟨3cos²θ − 1⟩ is ½, a quarter of what it is along a steady field."""
    electric = {"field": [0, 0, 1], "quadrature": [0, 1, 0], "angular_frequency": 1.0}
    turning = action_of(pair(**electric))
    times = np.arange(4) * math.pi / 4
    mean = np.mean([turning(at_gap(1.0), t)[0, 2] for t in times])
    along = turning(at_gap(1.0), 0.0)[0, 2]
    across = turning(at_gap(1.0), math.pi / 2)[0, 2]
    assert across < 0.0 < along
    # Four equal steps of half a turn hold the mean of cos² and sin² exactly.
    assert mean == pytest.approx((along + across) / 2, rel=1e-5)


def test_between_electrodes_the_near_one_attracts():
    """A polarised bead and its image in the electrode; potentials alone drive it."""
    wall = ("periodic", "periodic", "wall")
    electric = {"electrodes": {"axis": "z", "low": -4.0, "high": 4.0}, "tolerance": 1e-8}
    bead = sphere(permittivity=10.0, position=[0, 0, -2.2])
    action = action_of(coupled_case(bead, electric=electric, boundaries=wall, cells=24))
    forces = [action(bodies_at([[0, 0, z]], [UPRIGHT]), 0.0)[0, 2] for z in (-2.2, 0.0, 2.2)]
    assert forces[0] < 0.0 < forces[2]
    # Mirror images, solved to 1e-8 and found by different sums.
    assert forces[0] == pytest.approx(-forces[2], rel=1e-5)
    assert abs(forces[1]) < 1e-5 * forces[2]
    # (3/32π)p²/(ε z⁴) of a point dipole and its image 2z away, z = 1.8, p = 4πβ, β = .75; other
    # images and the bead's size change it by some tens of per cent.
    image = 3 / (32 * math.pi) * (4 * math.pi * 0.75) ** 2 / 1.8**4
    assert forces[2] == pytest.approx(image, rel=0.5)


def test_a_potential_that_does_not_converge_stops_the_run():
    action = action_of(pair(max_iterations=1))
    with pytest.raises(BlowUpError, match="the potential did not converge at t = 0"):
        action(at_gap(1.0), 0.0)


def test_without_bodies_or_field_nothing_acts():
    case = load_case(small_case(sphere()))
    action = build_action(case, build_grid(case.domain))
    assert isinstance(action, NoField)
    assert not action(bodies_at([[0, 0, 0]], [UPRIGHT]), 0.0).any()
    assert (action.history(), action.saved(), action.body_rows(1)) == ({}, {}, [{}])


@pytest.mark.parametrize(
    ("electric", "words"),
    [
        ({"every": 0}, "electric.every is 0; it must be a whole number"),
        ({"every": 1.5}, "electric.every is 1.5; it must be a whole number"),
        (
            {"quadrature": [1, 0, 0]},
            "electric.quadrature is [1.0, 0.0, 0.0]; it needs electric.ang",
        ),
        ({"angular_frequency": -1}, "electric.angular_frequency is -1; it must be"),
        ({"discretisation": "fourier"}, 'a case with [fluid] takes "finite-volume"'),
        (
            {"electrodes": {"axis": "z", "low": 0, "high": 1}},
            "the electrodes already set the field along z",
        ),
    ],
)
def test_what_a_moving_case_refuses(electric, words):
    case = small_case(sphere(permittivity=2.0), boundaries=("periodic",) * 3)
    assert words in refusal({**case, "electric": {"field": [0, 0, 1], **electric}})


@pytest.mark.parametrize(
    ("key", "value"), [("angular_frequency", 1.0), ("every", 2), ("quadrature", [1.0, 0.0, 0.0])]
)
def test_a_field_alone_has_no_time(key, value):
    case = small_case(sphere(permittivity=2.0), boundaries=("periodic",) * 3)
    for table in ("fluid", "profile", "time"):
        del case[table]
    assert f"electric.{key} is" in refusal({**case, "electric": {"field": [0, 0, 1], key: value}})
