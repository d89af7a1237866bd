"""The coupled step: against the equations, its limits, its books, its symmetries, known flows."""

import itertools

import numpy as np
import pytest

import smoothprofile as sp
from coupled import (
    SCHEMES,
    Books,
    body_coordinates,
    digest,
    settle,
    simulation,
    sphere,
    steps,
)
from plain_step import PlainStep
from smoothprofile.coupling import coupling_named
from smoothprofile.grid import interior

COUPLINGS = ("incremental", "thesis")
WALLED = {
    "boundaries": ["periodic", ["wall", "slip"], "wall"],
    "wall_velocity": {
        "y_low": [1.0, 0.0, 0.2],
        "z_high": {"amplitude": [0.5, 0.0, 0.0], "angular_frequency": 4.0},
    },
}
STRETCHED = {
    "stretching": ["uniform", {"focus": 2.0, "ratio": 2.0}, {"focus": 1.0, "ratio": 3.0}],
}
MOVING = (
    sphere([1, 2, 2.1], velocity=[0.4, 0.1, 0], angular_velocity=[0, 0.5, 1]),
    {
        "shape": "ellipsoid",
        "radii": [0.5, 0.6, 0.7],
        "position": [3.2, 2.0, 1.9],
        "angular_velocity": {"amplitude": [0, 0, 1], "angular_frequency": 3},
    },
)
HELD = sphere([3.1, 2, 2], radius=0.6)


# --- against the equations ------------------------------------------------------------------


def both(scheme, coupling, count, plain_coupling=None):
    """A run and the same steps in plain NumPy; largest differences of velocity and pressure."""
    ball = sphere([3.7, 2, 2.1], velocity=[1.4, 0.1, 0], angular_velocity=[0, 0.5, 1.0])
    force = [0.3, 0.1, 0.0]
    run = simulation(
        ball,
        lengths=[4.0, 4.4, 3.6],
        cells=[12, 11, 10],
        body_force=force,
        initial_velocity=[0.5, 0, 0],
        # Thin, so that the layer does not meet its own image, whose u_p is another.
        thickness=0.1,
        scheme=scheme,
        coupling=coupling,
    )
    books = Books(run)
    widths = [axis.widths[0] for axis in run.grid.axes]
    start = [interior(f) for f in run.state.velocity]
    plain = PlainStep(widths, start, scheme, plain_coupling or coupling, 0.3, 0.02, force)
    for _ in range(count):
        books.step()
        body = run.bodies.state
        phi = np.array([interior(run.bodies.painter.dense(c)) for c in range(3)])
        spin = body.angular_velocity[0]
        target = [
            body.velocity[0, c] + np.cross(spin, body_coordinates(run, c), axisb=0, axisc=0)[c]
            for c in range(3)
        ]
        plain.step(phi, np.array(target))
    velocity = np.array([interior(f) for f in run.state.velocity])
    return run, plain, books, np.abs(velocity - plain.velocity).max()


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_steps_are_those_of_the_equations(scheme, coupling):
    """The thesis' (2.6)–(2.12), and the incremental form, in every scheme from its first step."""
    run, plain, books, difference = both(scheme, coupling, 5)
    # Round-off of five steps: 3e-15 was seen, of velocities of 1.4 and pressures of 2.
    assert difference < 1e-13
    assert np.abs(interior(run.state.pressure) - plain.pressure).max() < 1e-12
    rate = run.flow.parameters.scheme.gamma / 0.02
    volume = run.grid.volume / run.grid.cell_count
    impulse = rate * plain.impulse.sum(axis=(1, 2, 3)) * volume
    assert books.impulse == pytest.approx(impulse, abs=1e-11)
    # V and Ω are constant, so the load is the impulse alone, but for Ω×(Ω×r), which sums to
    # zero over a sphere as well as its few cells can.
    assert run.bodies.state.force[0] == pytest.approx(-impulse, abs=3e-3 * np.abs(impulse).max())


def test_steps_tell_the_couplings_apart():
    *_, difference = both("backward-euler", "incremental", 3, "thesis")
    assert difference > 1e-3


# --- limits ---------------------------------------------------------------------------------


@pytest.mark.parametrize("where", ["periodic", "walled"])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_without_particles_the_coupled_step_is_the_flow_step(scheme, where):
    changes = {"scheme": scheme, "cells": [9, 10, 11], "initial_velocity": [0.3, 0, 0]}
    if where == "periodic":
        changes |= {"mean_velocity": {"x": 0.4, "z": 0.1}}
    else:
        changes |= {**WALLED, **STRETCHED, "body_force": [0.3, 0.0, 0.1]}
    coupled, alone = simulation(**changes), simulation(**changes)
    for _ in range(5):
        coupling_named("incremental")(coupled.flow, coupled.bodies, coupled.state, 0.02)
        alone.flow.step(alone.state, 0.02)
    assert np.abs(interior(alone.state.velocity[0])).max() > 0.1
    assert digest(coupled) == digest(alone)
    # A body of no influence but for its last digits is seen.
    alone.state.velocity[1][3, 3, 3] = np.nextafter(alone.state.velocity[1][3, 3, 3], 1.0)
    assert digest(coupled) != digest(alone)


def test_inside_a_held_body_the_fluid_rests():
    """At steady state the incremental coupling leaves nothing inside; the thesis' leaks Δt∇q."""
    inside = {}
    for coupling in COUPLINGS:
        run = simulation(
            sphere([2, 2, 2], radius=1.0),
            cells=[20] * 3,
            thickness=0.2,
            coupling=coupling,
            mean_velocity={"x": 1.0},
            viscosity=1.0,
        )
        settle(run, 1e-5)
        inside[coupling] = abs(run.particles[0]["interior_velocity"][0])
    # φ at the centre is 1 − e^{−10}.
    assert inside["incremental"] < 1e-3
    assert inside["thesis"] > 0.05


@pytest.mark.parametrize("scheme", SCHEMES)
def test_uniform_acceleration_needs_no_impulse(scheme):
    """Fluid and body that a force speeds up alike: the flow stays uniform, the force is its own."""

    def course(t):
        rest = np.array([1.0, 0, 0, 0]), np.array([0.5 * t, 0, 0]), np.zeros(3)
        return np.array([2 + 0.25 * t**2, 2, 2]), *rest

    run = simulation(
        sphere([2, 2, 2], name="ball"),
        courses={"ball": course},
        body_force=[1.0, 0, 0],
        density=2.0,
        thickness=0.1,
        cells=[24] * 3,
        retract=False,
        scheme=scheme,
    )
    books = Books(run)
    for _ in range(4):
        books.step()
        assert np.ptp(interior(run.state.velocity[0])) < 1e-14
        assert np.abs(books.impulse).max() < 1e-11
    assert interior(run.state.velocity[0])[0, 0, 0] == pytest.approx(0.5 * run.time)
    # ρV·½ of the true V: what is painted is π²/4·(ξ/a)² = 4 % more. Round-off otherwise.
    force = run.bodies.state.force[0]
    assert force == pytest.approx([4 / 3 * np.pi * 0.8**3, 0, 0], rel=1e-10, abs=1e-11)


# --- the same bits --------------------------------------------------------------------------

BITS = {
    "walls": {**WALLED, "cells": [13, 11, 14], "scheme": "backward-euler"},
    "stretched, thesis": {
        **WALLED,
        **STRETCHED,
        "cells": [13, 11, 14],
        "coupling": "thesis",
        "scheme": "bdf3",
    },
    "closed box": {"boundaries": ["wall"] * 3, "cells": [17, 13, 11], "scheme": "crank-nicolson"},
    "periodic, mean held": {"cells": [19, 13, 17], "mean_velocity": {"x": 0.5}, "scheme": "bdf2"},
}


# Kernels are compiled once more for single precision, so that two runs must do for it.
@pytest.mark.parametrize(
    ("name", "precision"),
    [
        *((name, "double") for name in BITS),
        ("stretched, thesis", "single"),
        ("periodic, mean held", "single"),
    ],
)
def test_threads_and_repetition_change_no_bit(name, precision):
    found = []
    for threads in (1, 2, 3, 1):
        sp.threads.set_thread_count(threads)
        run = simulation(MOVING[0], HELD, thickness=0.15, precision=precision, **BITS[name])
        steps(run, 4)
        found.append(digest(run))
    assert run.state.velocity[0].dtype == (np.float64 if precision == "double" else np.float32)
    assert len(set(found)) == 1
    assert digest(steps(run, 1)) != found[0]


@pytest.mark.parametrize("boundaries", [["periodic", "wall", "wall"], ["periodic"] * 3])
def test_threads_change_no_bit_of_odd_numbers_of_lines(boundaries):
    found = []
    for threads in (1, 2, 3):
        sp.threads.set_thread_count(threads)
        run = simulation(MOVING[0], HELD, thickness=0.1, cells=[64, 45, 45], boundaries=boundaries)
        found.append(digest(steps(run, 2)))
    assert len(set(found)) == 1


# --- books of momentum ----------------------------------------------------------------------


@pytest.mark.parametrize("coupling", COUPLINGS)
@pytest.mark.parametrize("scheme", SCHEMES)
def test_momentum_of_each_step(scheme, coupling):
    """γ-weighted change = body force − walls − what the bodies take, with all of them moving."""
    run = simulation(
        *MOVING,
        **WALLED,
        **STRETCHED,
        thickness=0.08,
        body_force=[0.3, 0, 0],
        density=2.0,
        scheme=scheme,
        coupling=coupling,
    )
    books = Books(run)
    for _ in range(5):
        gain, given = books.step()
        # Terms of up to 200 cancel; 3e-13 was seen.
        assert gain[0] == pytest.approx(given[0], abs=1e-11)
    assert abs(run.bodies.state.force[0, 0]) > 0.1
    assert abs(run.wall_force["total"][0]) > 0.1


@pytest.mark.parametrize("scheme", SCHEMES)
def test_momentum_with_the_mean_held(scheme):
    """The force that holds the mean acts on walls and bodies, and the mean is exact."""
    run = simulation(
        *MOVING, **WALLED, **STRETCHED, thickness=0.08, mean_velocity={"x": 0.7}, scheme=scheme
    )
    books = Books(run)
    for _ in range(5):
        gain, given = books.step()
        assert run.flow.mean_flow.plain_mean(run.state.velocity[0], 0) == pytest.approx(0.7)
        assert gain[0] == pytest.approx(given[0], abs=1e-11)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_momentum_in_a_closed_box(scheme):
    """Along all three axes, walls being normal to each; without advection to round-off."""
    run = simulation(
        sphere([2.2, 1.8, 2.1], velocity=[0.3, 0.2, -0.1]),
        boundaries=["wall", ["wall", "slip"], "wall"],
        wall_velocity={"z_high": [1.0, 0.5, 0.0]},
        stretching=["uniform", {"focus": 2.0, "ratio": 2.0}, "uniform"],
        advection=False,
        thickness=0.1,
        scheme=scheme,
    )
    books = Books(run)
    for _ in range(4):
        gain, given = books.step()
        assert gain == pytest.approx(given, abs=1e-11)


def test_walls_and_body_balance_at_steady_state():
    """A held sphere off the middle of a duct with sliding walls."""
    slide = {name: [2.0, 0.0, 0.0] for name in ("y_low", "y_high", "z_low", "z_high")}
    run = simulation(
        sphere([2.1, 2.3, 1.9]),
        boundaries=["periodic", "wall", "wall"],
        wall_velocity=slide,
        viscosity=1.0,
        step=0.05,
    )
    settle(run, 1e-6)
    force, walls = run.bodies.state.force[0], run.wall_force["total"]
    # What is left is the inertia ρV·∂u/∂t, at most 64·2e-6; 7e-7 was seen.
    assert walls[0] == pytest.approx(-force[0], rel=1e-6)
    assert force[0] > 10.0
    # Off the middle there is lift, and the walls' pressure carries it.
    assert walls[1:] == pytest.approx(-force[1:], abs=1e-3 * force[0])


# --- symmetries -----------------------------------------------------------------------------


def loads(run):
    return np.concatenate([run.bodies.state.force[0], run.bodies.state.torque[0]])


def oblong(order, mirror=(1, 1, 1), shift=(0, 0, 0)):
    """An ellipsoid near a wall, its axes renamed by `order` and mirrored; its loads named back."""
    sign = np.array(mirror)
    base = {
        "lengths": [4.0, 4.4, 5.0],
        "cells": [12, 11, 14],
        "boundaries": ["periodic", "wall", "slip"],
    }
    position = np.array([1.0, 1.1, 2.6]) + np.multiply(shift, np.divide([4, 4.4, 5], [12, 11, 14]))
    turn = np.array([1.0, -0.6, 0.4])
    velocity, spin = np.array([0.5, 0.1, -0.2]), np.array([0.3, -0.4, 0.8])
    wall = np.array([1.0, 0.0, 0.5])
    # A mirror turns axial vectors the other way about.
    axial = sign * np.prod(sign)
    position = np.where(sign > 0, position, np.array(base["lengths"]) - position)
    near = "y_low" if mirror[1] > 0 else "y_high"

    def named(values):
        return [values[d] for d in order]

    letters = {"xyz"[d]: "xyz"[i] for i, d in enumerate(order)}
    # An odd renaming of the axes is a mirror too.
    parity = np.linalg.det(np.eye(3)[list(order)])
    body = {
        "shape": "ellipsoid",
        "radii": named([0.7, 0.5, 0.6]),
        "position": named(position.tolist()),
        "orientation": {"axis": named((turn * axial * parity).tolist()), "angle": 35.0},
        "velocity": named((velocity * sign).tolist()),
        "angular_velocity": named((spin * axial * parity).tolist()),
    }
    run = simulation(
        body,
        **{key: named(value) for key, value in base.items()},
        wall_velocity={letters["y"] + near[1:]: named((wall * sign).tolist())},
        scheme="bdf2",
        thickness=0.2,
    )
    steps(run, 4)
    back = np.argsort(order)
    state = run.bodies.state
    return np.concatenate([state.force[0][back] * sign, state.torque[0][back] * axial * parity])


@pytest.mark.parametrize("order", list(itertools.permutations(range(3)))[1:])
def test_axes_may_be_renamed(order):
    plain = oblong((0, 1, 2))
    # Transforms, sweeps and sums in another order: round-off of solves of condition ~100.
    assert oblong(order) == pytest.approx(plain, abs=1e-10 * np.abs(plain).max())


@pytest.mark.parametrize("mirror", [(-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, -1)])
def test_the_world_in_a_mirror(mirror):
    plain = oblong((0, 1, 2))
    assert np.abs(plain).min() > 1e-4 * np.abs(plain).max()  # none of the six is zero by symmetry
    assert oblong((0, 1, 2), mirror) == pytest.approx(plain, abs=1e-10 * np.abs(plain).max())


def test_a_shift_by_whole_cells_along_a_periodic_axis():
    plain = oblong((0, 1, 2))
    for cells in (-3, 5, 8):
        shifted = oblong((0, 1, 2), shift=(cells, 0, 0))
        assert shifted == pytest.approx(plain, abs=1e-10 * np.abs(plain).max())


def test_torque_is_counted_from_the_position():
    """A sphere, and a union that holds it off its origin: T′ = T + c×F."""
    offset = np.array([0.5, -0.2, 0.3])
    part = {"shape": "sphere", "radius": 0.6, "position": (-offset).tolist()}
    where = np.array([2.0, 1.8, 2.1])
    bodies = (
        sphere(where, radius=0.6),
        {"shape": "union", "parts": [part], "position": (where + offset).tolist()},
    )
    runs = [steps(simulation(b, thickness=0.1, **WALLED), 5) for b in bodies]
    (force, torque), (same, other) = (
        (run.bodies.state.force[0], run.bodies.state.torque[0]) for run in runs
    )
    assert same == pytest.approx(force, rel=1e-11)
    assert other == pytest.approx(torque + np.cross(-offset, force), abs=1e-10)
    assert np.linalg.norm(other) > 2 * np.linalg.norm(torque)
