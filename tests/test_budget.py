"""The budgets of momentum and energy of a step: where they close, and that they can fail."""

import numpy as np
import pytest

from coupled import settle, simulation, sphere, steps
from smoothprofile.budget import step_with_budget
from smoothprofile.flow.energy import kinetic_sums
from smoothprofile.grid import interior
from smoothprofile.selfcheck import error_card

SCHEMES = ("backward-euler", "crank-nicolson", "bdf2", "bdf3")
STRETCHED = {
    "boundaries": ["periodic", "wall", "slip"],
    "stretching": ["uniform", {"focus": 1.0, "ratio": 2.0}, "uniform"],
    "wall_velocity": {"y_high": [1.0, 0.0, 0.0], "y_low": [0.0, 0.0, 0.5]},
}


def budget_of(run, step=None):
    """Of the next step, which the run takes."""

    def once():
        run._couple(run.flow, run.bodies, run.state, run.time_step)

    return step_with_budget(run, step or once)


def stirred(run, seed=1):
    """Any velocity without divergence."""
    choose = np.random.default_rng(seed)
    for field in run.state.velocity:
        field[...] = choose.normal(size=field.shape)
    run.flow.fill(run.state.velocity, 0.0)
    run.flow.projection.make_divergence_free(run.state.velocity)
    run.flow.fill(run.state.velocity, 0.0)
    return run


@pytest.mark.parametrize("walls", [{}, STRETCHED], ids=["periodic", "stretched, sliding walls"])
def test_walls_less_dissipation_is_what_the_viscous_term_does(walls):
    """W − D = Σu·∇²u δV of any velocity, to round-off: what is summed by parts is the same."""
    run = stirred(simulation(**walls))
    velocity, grid = run.state.velocity, run.grid
    sums = kinetic_sums(grid, velocity, velocity, None)
    power = 0.0
    for c, field in enumerate(velocity):
        laplacian = grid.zeros()
        run.flow._viscosity[c].add_explicit(field, 1.0, laplacian)
        sizes = [
            (a.padded_distances if d == c else a.padded_widths)[1:-1]
            for d, a in enumerate(grid.axes)
        ]
        product = interior(field) * interior(laplacian)
        power += np.einsum("ijk,i,j,k->", product, *sizes)
    assert sums.gain == 0.0 and sums.dissipation > 0.0 and bool(sums.walls) == bool(walls)
    # Sums of 1700 terms that are each of the size of the whole over 1700.
    assert sums.walls - sums.dissipation == pytest.approx(power, rel=1e-12)


def vortices(scheme, step, cells=12):
    """Taylor and Green's, which decay as exp(−2νk²t), after six steps."""
    run = simulation(scheme=scheme, viscosity=0.05, step=step, cells=[cells, cells, 4])
    k = 2.0 * np.pi / 4.0
    at = [run.grid.face_coordinates(c) for c in range(2)]
    u, v, _ = run.state.velocity
    u[...] = np.sin(k * at[0][0])[:, None, None] * np.cos(k * at[0][1])[None, :, None]
    v[...] = -np.cos(k * at[1][0])[:, None, None] * np.sin(k * at[1][1])[None, :, None]
    run.flow.fill(run.state.velocity, 0.0)
    return steps(run, 6)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_energy_of_vortices_closes_with_the_order_of_the_scheme(scheme):
    """What is left is the error of time stepping; what decays is what viscosity takes.

    Of schemes of third order too it is of second: the powers are those of the mean of two levels.
    """
    coarse, fine = (budget_of(vortices(scheme, step)) for step in (0.08, 0.04))
    assert fine.momentum < 1e-12
    assert fine.gain == pytest.approx(-fine.viscous, rel=0.1)
    if scheme == "crank-nicolson":
        # Its own mean of two levels is that of the budget.
        assert fine.energy < 1e-12
        return
    slope = np.log2(coarse.energy / fine.energy)
    assert slope > (0.8 if scheme == "backward-euler" else 1.8), slope


def test_walls_bear_a_body_force_that_ends_in_them():
    """In stretched cells: the walls of a fluid at rest take all of fV."""
    run = simulation(
        boundaries=["periodic", "wall", "periodic"],
        stretching=["uniform", {"focus": 1.0, "ratio": 2.0}, "uniform"],
        body_force=[0.0, 0.5, 0.0],
    )
    found = budget_of(steps(run, 5))
    # The halves of the cells at the walls are 3 % of the box.
    assert run.wall_force["total"][1] == pytest.approx(0.5 * run.grid.volume, rel=1e-12)
    assert found.momentum < 1e-12


def test_a_sphere_held_between_sliding_walls_closes_both_budgets():
    """At the steady state: walls work, the sphere rests, viscosity and its layer take it all."""
    run = settle(
        simulation(
            sphere([2.0, 2.0, 2.0]),
            boundaries=["periodic", "wall", "periodic"],
            wall_velocity={"y_high": [0.3, 0.0, 0.0]},
            advection=False,
            step=0.1,
        ),
        1e-7,
    )
    found = budget_of(run)
    assert found.walls > 0.0 and found.bodies == 0.0 and abs(found.gain) < 1e-5 * found.walls
    assert 0.0 < found.layers < 0.5 * found.viscous
    # The rate of change that is left, over the time that viscosity takes.
    assert found.energy < 1e-5 and found.momentum < 1e-12


@pytest.mark.parametrize("scheme", SCHEMES)
def test_free_bodies_and_the_fluid_share_their_energy(scheme):
    """One sinks, one turns as it is told: the work of both, step by step."""
    falling = sphere([1.0, 1.0, 2.0], motion="free", density=3.0)
    turning = sphere([3.0, 3.0, 2.0], motion="prescribed", angular_velocity=[0.0, 0.0, 2.0])
    run = simulation(falling, turning, scheme=scheme, gravity=[0.0, 0.0, -5.0], retract="planar")
    found = budget_of(steps(run, 30))
    assert found.bodies > 0.0 and found.momentum < 1e-12
    # Measured 5e-4 for backward Euler and up to 2e-4 for others, halved with Δt.
    assert found.energy < 1e-3


def test_a_wrong_sign_or_coefficient_shows(monkeypatch):
    run = simulation(
        sphere([2.0, 2.0, 2.0]), body_force=[0.5, 0.0, 0.0], boundaries=["periodic", "wall", "wall"]
    )
    steps(run, 20)
    assert budget_of(run).momentum < 1e-12
    real = run.bodies.given
    monkeypatch.setattr(run.bodies, "given", lambda: tuple(-part for part in real()))
    assert budget_of(run).momentum > 0.05
    monkeypatch.undo()

    def wrong():
        run._couple(run.flow, run.bodies, run.state, run.time_step)
        for field in run.state.velocity:
            field *= 1.01

    assert budget_of(run, wrong).energy > 0.05


def test_watching_a_step_changes_no_bit():
    runs = [
        simulation(sphere([2.0] * 3, motion="free", density=1.5, velocity=[1, 0, 0]))
        for _ in range(2)
    ]
    steps(runs[0], 3)
    for _ in range(3):
        budget_of(runs[1])
    for a, b in zip(runs[0].state.velocity, runs[1].state.velocity, strict=True):
        assert a.tobytes() == b.tobytes()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_walls_take_what_advection_carries_into_the_cells_at_them(scheme):
    """A lid drives a closed box, nothing else: all walls together bear no more than the gain."""
    run = simulation(
        boundaries=["wall", "wall", "slip"],
        stretching=["uniform", {"focus": 1.0, "ratio": 2.0}, "uniform"],
        wall_velocity={"y_high": [1.0, 0.0, 0.0]},
        scheme=scheme,
        viscosity=0.05,
    )
    # Past the first steps, which other schemes take.
    steps(run, 3)
    assert budget_of(run).momentum < 1e-12
    assert max(np.abs(force).max() for force in run.flow._carried.values()) > 1e-6


def test_a_fluid_at_rest_under_a_force_has_no_errors():
    """Between free-slip walls across a body force: what moves is round-off."""
    run = simulation(boundaries=["slip", "periodic", "periodic"], body_force=[1.0, 0.0, 0.0])
    run.budget = budget_of(steps(run, 10))
    assert 0.0 <= max(run.extremes.speed) < 1e-12
    assert {line["verdict"] for line in error_card(run)} == {"green"}
