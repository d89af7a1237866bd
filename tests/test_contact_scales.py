"""How stiff contact is by itself: from what a case's field, weight, shear and speeds press with."""

import math

import numpy as np
import pytest

import smoothprofile as sp
from coupled import sphere
from smoothprofile.contact_scales import near_force
from smoothprofile.particles.contact_law import repulsion
from smoothprofile.theory.two_spheres import pair_force

VOLUME, RANGE = 4.0 / 3.0 * math.pi, 0.25
MASS = 1.5 * VOLUME


def run_of(electric=None, walls=0.0, viscosity=10.0, density=1.0, ratio=10.0, **fluid):
    """A free bead of radius 1 between walls 6 apart; Δx = .25."""
    kinds = {} if electric is None else {"permittivity": ratio}
    bead = sphere([3, 3, 3], 1.0, motion="free", density=density, **kinds)
    case = {
        "domain": {
            "lengths": [6.0] * 3,
            "cells": [24] * 3,
            "boundaries": ["periodic", "periodic", "wall"],
        },
        "fluid": {"density": 1.0, "viscosity": viscosity, **fluid},
        "profile": {"thickness": 0.3, "retract": False},
        "time": {"step": 1e-3, "end": 1.0},
        "particles": [bead],
    }
    if walls:
        case["fluid"]["wall_velocity"] = {"z_low": [-walls, 0, 0], "z_high": [walls, 0, 0]}
    if electric:
        case["electric"] = {"electrodes": {"axis": "z", "low": 0.0, "high": 6.0 * electric}}
    return sp.Simulation(sp.load_case(case))


def touch_force(*arguments, **keys):
    return float(run_of(*arguments, **keys).bodies.free.contact.parameters.touch_force[0])


EXACT = {
    (0.1, 0.1): 0.464779,
    (0.1, 0.3): 0.369327,
    (10.0, 0.05): 8.917476,
    (10.0, 0.1): 6.166166,
    (10.0, 0.3): 2.671459,
    (1e3, 0.05): 31.856190,
    (1e3, 0.1): 17.381519,
    (1e3, 0.3): 5.797813,
}


@pytest.mark.parametrize(("ratio", "gap"), EXACT)
def test_the_force_of_near_spheres_is_about_the_exact_one(ratio, gap):
    # The fit is good to 8 % here; without its second term it would be 2 to 50 times too large.
    assert float(near_force(np.array(ratio), gap)) == pytest.approx(EXACT[ratio, gap], rel=0.1)


def test_the_exact_ones_are_those_of_the_theory():
    for ratio in (0.1, 10.0, 1e3):
        assert -pair_force(2.3, ratio)[0] == pytest.approx(EXACT[ratio, 0.3], rel=1e-5)
    assert near_force(np.array(1.0), 0.1) == 0.0


@pytest.mark.parametrize("field", [1.0, 2.0])
def test_a_field_sets_what_two_beads_keep_of_their_range(field):
    """8Fᵉ: the pair, half as stiff, is at rest at half the range."""
    force = field**2 * float(near_force(np.array(10.0), 0.5 * RANGE))
    found = touch_force(field)
    assert found == pytest.approx(8.0 * force, rel=1e-12)
    law = run_of(field).bodies.free.contact.parameters.law
    assert repulsion(law, 0.5 * RANGE, 0.5 * found)[0] == pytest.approx(force, rel=1e-12)


def test_shear_sets_it_where_the_field_is_weak():
    rate = 2.0 / 6.0
    expected = 8.0 * 6.0 * math.pi * 10.0 * rate
    for field in (None, 0.1):
        assert touch_force(field, walls=1.0) == pytest.approx(expected, rel=1e-12)


def test_weight_sets_it_where_a_body_is_heavy():
    weight = 2.0 * VOLUME * 9.0
    expected = 4.0 * weight
    found = touch_force(density=3.0, gravity=[0, 0, -9.0], viscosity=100.0)
    assert found == pytest.approx(expected, rel=1e-12)


def test_speed_sets_it_where_bodies_are_fast():
    expected = 6.0 * MASS * 10.0**2 / RANGE
    for field in (None, 1.0):
        found = touch_force(field, initial_velocity=[10.0, 0, 0], advection=False)
        assert found == pytest.approx(expected, rel=1e-12)


def test_a_thin_fluid_lets_the_field_set_the_speed():
    """Uᵉ = √(2aFᵉ/3m), for Stokes' law would give more: F₀ = 6mUᵉ²/s = 4aFᵉ/s."""
    force = float(near_force(np.array(10.0), 0.5 * RANGE))
    assert touch_force(1.0, viscosity=0.01) == pytest.approx(4.0 * force / RANGE, rel=1e-12)


def test_where_nothing_is_announced_viscosity_sets_it():
    """U = ν/Δx; and so for R = 1, where a field pulls at nothing."""
    expected = 6.0 * MASS * (10.0 / 0.25) ** 2 / RANGE
    for field in (None, 1.0):
        assert touch_force(field, ratio=1.0) == pytest.approx(expected, rel=1e-12)
