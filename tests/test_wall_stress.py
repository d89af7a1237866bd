"""What bears the stress of sliding walls: the balance of ∫ρz u dV, closed to round-off."""

import numpy as np
import pytest

import smoothprofile as sp
from smoothprofile.particles.stress import displaced_moments

PLACES = ((2.0, 2.0, 1.9), (2.3, 2.2, 3.95), (4.6, 4.5, 3.2))


def sheared(density=1.0, field=2.0, axis="z", **settings):
    """Three beads between electrodes that slide, two of them in contact, one alone."""
    order = {"z": [0, 1, 2], "y": [0, 2, 1]}[axis]
    beads = [
        {
            "shape": "sphere",
            "radius": 1.0,
            "position": [place[d] for d in order],
            "motion": "free",
            "density": density,
            "permittivity": 10.0,
        }
        for place in PLACES
    ]
    kinds = ["wall" if name == axis else "periodic" for name in "xyz"]
    case = {
        "domain": {"lengths": [6.0] * 3, "cells": [24] * 3, "boundaries": kinds},
        "fluid": {
            "density": 1.0,
            "viscosity": 1.0,
            "advection": False,
            "wall_velocity": {f"{axis}_low": [-1.5, 0.0, 0.0], f"{axis}_high": [1.5, 0.0, 0.0]},
        },
        "electric": {
            "electrodes": {"axis": axis, "low": 0.0, "high": 6.0 * field},
            "tolerance": 1e-8,
        },
        "contact": {"range": 0.3},
        "profile": {"kind": "quartic-centred", "thickness": 0.7},
        "particles": beads,
        "time": {"step": 0.1, "end": 1.0, **settings},
    }
    return sp.Simulation.from_file(case)


def moment_of_inertia_terms(run, before, axis):
    """[ρ d/dt∫z u dV − Σ∫ρz a dV + Σz m a]/V by the velocities of a backward Euler step."""
    grid, dt, bodies = run.grid, run.time_step, run.bodies
    shape = [1, 1, 1]
    shape[axis] = -1
    z = (grid.axes[axis].centres - 3.0).reshape(shape)
    change = (run.state.velocity[0][1:-1, 1:-1, 1:-1] - before[0]) / dt
    cell = grid.volume / grid.cell_count
    acceleration = (bodies.state.velocity - before[1]) / dt
    spinning = (bodies.state.angular_velocity - before[2]) / dt
    moved = displaced_moments(bodies.displaced, bodies.state, acceleration, spinning)
    height = bodies.state.position[:, axis] - 3.0
    volume = bodies.displaced.volume
    excess = np.array([p.density for p in run.case.particles]) - 1.0
    total = (z * change).sum() * cell - moved[:, axis, 0].sum()
    return (total + (height * excess * volume * acceleration[:, 0]).sum()) / grid.volume


def balance(run, axis=2, steps=4):
    """(τ − its parts, inertia, the parts) of the last of some steps."""
    for _ in range(steps):
        before = (
            run.state.velocity[0][1:-1, 1:-1, 1:-1].copy(),
            run.bodies.state.velocity.copy(),
            run.bodies.state.angular_velocity.copy(),
        )
        run.step_once()
    row = {name: run.history[name][-1] for name in run.history if name.endswith("_stress")}
    parts = [row[f"{name}_stress"] for name in ("viscous", "contact", "electric")]
    return row["wall_stress"] - sum(parts), moment_of_inertia_terms(run, before, axis), parts


@pytest.mark.parametrize(("axis", "density"), [("z", 1.0), ("y", 1.0), ("z", 2.0)])
def test_the_parts_and_inertia_are_the_stress_on_the_walls(axis, density):
    run = sheared(density, axis=axis)
    rest, inertia, parts = balance(run, "xyz".index(axis))
    # Each part matters, and the sums on the grid close to round-off of the pressure's solve.
    assert min(map(abs, parts)) > 1e-3
    assert rest == pytest.approx(inertia, abs=1e-10)


def test_a_wrong_sign_of_any_part_would_be_seen():
    rest, inertia, parts = balance(sheared())
    assert all(abs(rest + 2.0 * part - inertia) > 1e-3 for part in parts)


def test_the_parts_scale_as_what_makes_them():
    """Without a field and apart, the viscous part is all; the electric goes with the square."""
    runs = [sheared(field=field) for field in (0.1, 0.2)]
    for run in runs:
        run.step_once()
    small, large = (run.history["electric_stress"][-1] for run in runs)
    # The beads are in the same places in the first step, to what the field moves them in it.
    assert large == pytest.approx(4.0 * small, rel=1e-3)


def test_nothing_is_said_without_sliding_walls():
    case = sheared().case
    fluid = case.fluid.model_copy(update={"wall_velocity": type(case.fluid.wall_velocity)()})
    quiet = sp.Simulation(case.model_copy(update={"fluid": fluid}))
    quiet.step_once()
    assert "wall_stress" not in quiet.history and "apparent_viscosity" not in quiet.summary()
