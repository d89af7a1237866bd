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


def rubbed(friction):
    """A bead that a field draws to the lower of two sliding walls, three steps later."""
    run = sheared(field=3.0)
    bead = run.case.particles[0].model_copy(update={"position": (3.0, 3.0, 1.02)})
    contact = run.case.contact.model_copy(update={"friction": friction})
    run = sp.Simulation(run.case.model_copy(update={"particles": (bead,), "contact": contact}))
    for _ in range(3):
        momentum = whole_momentum(run)
        run.step_once()
    return run, (whole_momentum(run) - momentum) / run.time_step


def whole_momentum(run):
    """Along the slide, of the fluid; the bead is as dense."""
    cell = run.grid.volume / run.grid.cell_count
    return run.state.velocity[0][1:-1, 1:-1, 1:-1].sum() * cell


def test_walls_feel_the_friction_of_beads_and_momentum_is_whole_with_it():
    run, gained = rubbed(0.5)
    friction = run.bodies.free.wall_impulse[2, :, 0].sum() / run.time_step
    assert abs(friction) > 1e-2
    total = run.wall_force["total"][0] + friction
    # What the walls lose all else gains, to round-off of the pressure's solve.
    assert gained == pytest.approx(-total, abs=1e-9)
    assert abs(gained + run.wall_force["total"][0]) > 1e-2


def test_friction_on_walls_is_part_of_their_stress_and_of_contact_s():
    run, _ = rubbed(0.5)
    wall, contact = (run.history[f"{name}_stress"][-1] for name in ("wall", "contact"))
    low, high = run.bodies.free.wall_impulse[2, :, 0] / run.time_step
    rub = 0.5 * (low - high) * 6.0 / run.grid.volume
    forces = run.wall_force
    fluid = 0.5 * (forces["z_low"] - forces["z_high"])[0] * 6.0 / run.grid.volume
    assert abs(rub) > 1e-3
    assert wall - fluid == pytest.approx(rub, rel=1e-9)
    # Of the pair of bead and wall, −Δz·F: the wall 3 below the middle, the bead where it is.
    height = run.bodies.state.position[0, 2] - 3.0
    assert contact == pytest.approx(-(height - (-3.0)) * -low / run.grid.volume, rel=1e-9)
    smooth, _ = rubbed(0.0)
    assert smooth.bodies.free.wall_impulse[2, :, 0] == pytest.approx([0.0, 0.0], abs=1e-15)
