"""Flow, bodies and field in one step: momentum, no-ops, angles, and a pair that closes in."""

import math

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import smoothprofile as sp
from coupled import digest, momentum, sphere, steps
from dielectrics import UPRIGHT
from smoothprofile import cases, shapes
from smoothprofile.electric.field import Drive, ResolvedField
from smoothprofile.electric.forces import BodyLoads
from smoothprofile.electric.medium import dielectric_medium
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import bodies_at
from smoothprofile.theory.pair_images import image_field, periodic_pair_force
from smoothprofile.theory.two_spheres import pair_force

FIELD = {"field": [0.0, 0.3, 1.0], "tolerance": 1e-6}


def run_of(*bodies, electric=None, side=4.0, cells=16, step=0.02, viscosity=0.3, **tables):
    """A run in a periodic cube from its low corner, with a field or without."""
    case = {
        "domain": {"lengths": [side] * 3, "cells": [cells] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {"density": 1.0, "viscosity": viscosity},
        "profile": {"thickness": 0.3, "retract": False},
        "time": {"step": step, "end": 1e6},
        "output": {"every": 10**6},
        "particles": list(bodies),
        **tables,
    }
    return sp.Simulation(sp.load_case(case | ({"electric": electric} if electric else {})))


def crowd(permittivity=None, **more):
    """Eight free beads, off the points of a lattice, of three densities and given ε."""
    generator = np.random.default_rng(2)
    places = np.array(list(np.ndindex(2, 2, 2))) * 2.0 + 1.0
    places += 0.15 * generator.uniform(-1, 1, places.shape)
    kinds = {} if permittivity is None else {"permittivity": permittivity}
    return [
        sphere(place, 0.6, motion="free", density=(1.0, 2.0, 5.0)[i % 3], **kinds, **more)
        for i, place in enumerate(places)
    ]


def excess(run):
    """(n,) what each body weighs more than the fluid that it displaces."""
    density = np.array([particle.density for particle in run.case.particles])
    return (density - run.case.fluid.density) * run.bodies.displaced.volume


def books(run, count):
    """Largest |ΣF|/Σ|F| of the field, and drift of the momentum over Σ|F|t, in `count` steps."""
    whole = lambda: momentum(run) + excess(run) @ run.bodies.state.velocity  # noqa: E731
    start, worst, drift, given = whole(), 0.0, 0.0, 0.0
    for _ in range(count):
        steps(run, 1)
        force = run.action.loads.force
        scale = np.linalg.norm(force, axis=1).sum()
        given += scale * run.time_step
        worst = max(worst, np.abs(force.sum(axis=0)).max() / scale)
        drift = max(drift, np.abs(whole() - start).max() / given)
    return worst, drift


def test_forces_add_up_to_nothing_and_momentum_stays():
    worst, drift = books(run_of(*crowd(10.0), electric=FIELD), 12)
    # Round-off of sums over 8 bodies, and over 4096 cells twelve times.
    assert worst < 1e-14
    assert drift < 1e-12


def test_the_books_see_a_force_that_is_not_balanced(monkeypatch):
    """What the grid leaves unbalanced at four cells to a radius would show at once."""
    monkeypatch.setattr(BodyLoads, "balanced", lambda self, periodic: self)
    worst, drift = books(run_of(*crowd(10.0), electric=FIELD), 4)
    assert worst > 1e-6
    assert drift > 1e-7


def test_without_contrast_the_field_does_nothing():
    """R = 1: no force at all, and every bit of the run as without a field."""
    with_field, without = (
        steps(run_of(*crowd(kind), electric=field), 4)
        for kind, field in ((3.0, FIELD | {"permittivity": 3.0}), (None, None))
    )
    assert not with_field.action.loads.force.any()
    assert not with_field.action.loads.torque.any()
    assert with_field.action.history()["potential_iterations"] == 0
    assert digest(with_field) == digest(without)


def test_bodies_that_do_not_move_freely_leave_every_bit_of_the_flow():
    held = sphere([2, 2, 2], 0.8)
    driven = sphere([0.5, 0.5, 0.5], 0.4, motion="prescribed", velocity=[0.1, 0, 0])
    bare = steps(run_of(held, driven), 3)
    kinds = [body | {"permittivity": 10.0} for body in (held, driven)]
    assert digest(steps(run_of(*kinds, electric=FIELD), 3)) == digest(bare)


def test_a_contrast_does_change_the_run():
    lone, drawn = (
        steps(run_of(*crowd(kind), electric=field), 4)
        for kind, field in ((None, None), (10.0, FIELD))
    )
    assert digest(lone) != digest(drawn)


def test_a_moving_electrode_drags_the_fluid_and_the_field_stays():
    """Shear cell: walls at ±2 hold potentials, and the upper one slides."""
    bead = sphere([0, 0, 0.4], 0.6, motion="free", density=1.0, permittivity=10.0)
    run = run_of(
        bead,
        electric={"electrodes": {"axis": "z", "low": 0.0, "high": 4.0}},
        domain={
            "lengths": [4.0] * 3,
            "cells": [16] * 3,
            "origin": [-2.0] * 3,
            "boundaries": ["periodic", "periodic", "wall"],
        },
        fluid={"density": 1.0, "viscosity": 0.3, "wall_velocity": {"z_high": [0.5, 0, 0]}},
    )
    steps(run, 20)
    body = run.particles[0]
    assert body["velocity"][0] > 0.0
    # Above the middle the upper electrode is nearer.
    assert body["electric_force"][2] > 0.0
    assert body["velocity"][2] > 0.0
    assert run.action.field.drive.field == pytest.approx([0.0, 0.0, -1.0])


def pair_field(cells, side, ratio, thickness=None):
    """The field of two unit spheres of that contrast in a periodic cube, and where they may be."""
    grid = Grid(tuple(uniform_axis(name, 0.0, side, cells, True) for name in "xyz"))
    medium = dielectric_medium(grid, [shapes.sphere(1.0)] * 2, [ratio] * 2, thickness=thickness)

    def force(distance, angle=0.0, middle=0.0, field=(0.0, 0.0, 1.0)):
        """On the second, balanced, its centre at that angle to z from the first's."""
        half = 0.5 * distance * np.array([math.sin(angle), 0.0, math.cos(angle)])
        centre = 0.5 * side + middle * side / cells
        state = bodies_at([centre - half, centre + half], [UPRIGHT] * 2)
        solver = ResolvedField(medium, Drive(field), tolerance=1e-5)
        solver.solver.potential[:] = 0.0
        assert solver.solve(state).converged
        return solver.loads(state).force[1]

    return force


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [2.0, 10.0])
@pytest.mark.parametrize("gap", [0.3, 0.5, 1.0])
def test_static_pair_at_sixteen_cells_to_a_radius(ratio, gap):
    """Against multipoles with images, good to .1 % (R = 2) and .3 % (R = 10) at L = 8."""
    sp.threads.set_thread_count(2)
    force = pair_field(128, 8.0, ratio)(2.0 + gap, middle=0.31)[2]
    exact = periodic_pair_force(2.0 + gap, ratio, 8.0)
    print(f"\nR = {ratio:g}, gap {gap}: {force:.6f}, {100 * (force / exact - 1):+.2f} %")
    assert force == pytest.approx(exact, rel=0.02)


@pytest.mark.slow
def test_the_radial_force_changes_sign_at_the_magic_angle_when_far_apart():
    """cos²θ = 1/3 for point dipoles that have no images; R = 2, 8 cells to a radius, L = 16a.

    The images of a cube pull along its axes, and their part is taken out as point dipoles'.
    """
    sp.threads.set_thread_count(2)
    force, beta = pair_field(128, 16.0, 2.0, thickness=0.125), 0.25
    apart = []
    for distance in (3.0, 4.0, 5.0):
        # F = cos²θ F_∥ + sin²θ F_⊥ of an unbounded pair; the line stays along z, the field turns.
        parts = [
            np.mean([force(distance, 0.0, m, field)[2] for m in (0.0, 0.5)])
            - periodic_part(distance, 16.0, beta, across)
            for across, field in enumerate(((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)))
        ]
        angle = math.degrees(math.atan(math.sqrt(-parts[0] / parts[1])))
        exact = [pair_force(distance, 2.0, turn)[0] for turn in (0.0, math.pi / 2)]
        exact = math.degrees(math.atan(math.sqrt(-exact[0] / exact[1])))
        print(f"\n{distance}: {angle:.2f}, exact {exact:.2f} degrees")
        assert angle == pytest.approx(exact, abs=1.0)
        apart.append(abs(angle - 54.7356))
    assert apart[-1] < 1.0


def periodic_part(distance, side, beta, across):
    """Force on a point dipole 4πβ of the images of one like it, `distance` along z."""
    step = 1e-3
    slope = (image_field(distance + step, side) - image_field(distance - step, side)) / (2 * step)
    # Dipoles across the line feel −½ of the field along it, by Laplace's equation and symmetry.
    return (4 * math.pi * beta) ** 2 * slope * (-0.5 if across else 1.0)


def test_slopes_that_cancel_on_grid_points_half_way_do_no_harm():
    """There ∇ε is round-off, and what is divided by it would be any number."""
    force = pair_field(40, 8.0, 10.0)
    for distance in np.linspace(2.8, 3.3, 9):
        # Five cells to a radius; what went wrong was orders of magnitude.
        exact = periodic_pair_force(distance, 10.0, 8.0)
        assert force(distance)[2] == pytest.approx(exact, rel=0.3)


@pytest.mark.slow
def test_two_free_beads_draw_each_other_in():
    """The case `pair-attraction`, against force times mobility in its periodic cube."""
    sp.threads.set_thread_count(2)
    run = sp.Simulation.from_file("pair-attraction")
    known = cases.reference("pair-attraction")["distance"]
    times, apart = [], []

    def watch(run):
        upper, lower = run.bodies.state.position
        times.append(run.time)
        apart.append(np.linalg.norm(upper - lower))

    run.run(watch)
    theory = CubicSpline(-np.array(known["value"]), known["coordinate"])
    share = {}
    for distance in (3.5, 3.0, 2.5):
        exact = float(theory(-distance))
        share[distance] = np.interp(-distance, -np.array(apart), times) / exact - 1.0
    print(f"\nlate at 3.5, 3, 2.5: {share}, least distance {min(apart):.4f}")
    # Measured +.1, −.5 and −.9 %. At eight cells to a radius static forces are 2 to 3 % high at
    # gaps below .5a, and the mobility is right to 1 %.
    assert all(abs(value) < 0.02 for value in share.values())
    # Mirror symmetry: round-off.
    assert np.abs(run.bodies.state.velocity.sum(axis=0)).max() < 1e-10
    # Off the line, what round-off has grown to by the end.
    assert np.abs(run.bodies.state.angular_velocity).max() < 1e-4


@pytest.mark.parametrize(("smoothing", "scatter"), [("tensor", 0.05), ("harmonic", 0.02)])
def test_forces_in_a_narrow_gap_are_steady_with_the_smoothing_of_moving_spheres(smoothing, scatter):
    """Five cells to a radius, gap .3a, R = 10; the pair moves across a cell along its line."""
    grid = Grid(tuple(uniform_axis(name, 0.0, 6.0, 30, True) for name in "xyz"))
    spheres = [shapes.sphere(1.0)] * 2
    medium = dielectric_medium(grid, spheres, [10.0] * 2, smoothing=smoothing)
    solver, forces = ResolvedField(medium, Drive((0.0, 0.0, 1.0)), tolerance=1e-4), []
    for part in (0.0, 0.25, 0.5, 0.75):
        centre = np.array([3.06, 3.03, 3.0 + 0.2 * part])
        half = np.array([0.0, 0.0, 1.15])
        state = bodies_at([centre - half, centre + half], [UPRIGHT] * 2)
        assert solver.solve(state).converged
        forces.append(solver.loads(state).force[1, 2])
    spread = np.std(forces) / abs(np.mean(forces))
    if smoothing == "harmonic":
        # Measured .7 %, and its mean is 1 % from the exact force.
        assert spread < scatter
        assert np.mean(forces) == pytest.approx(periodic_pair_force(2.3, 10.0, 6.0), rel=0.04)
    else:
        # Measured some 15 %: the reason why spheres that move have the other.
        assert spread > scatter


@pytest.mark.parametrize("ratio", [0.1, 10.0])
def test_the_residual_that_is_reported_is_the_true_one(ratio):
    grid = Grid(tuple(uniform_axis(name, 0.0, 4.0, 20, True) for name in "xyz"))
    medium = dielectric_medium(grid, [shapes.sphere(1.0)], [ratio])
    field = ResolvedField(medium, Drive((0.0, 0.0, 1.0)), tolerance=1e-7)
    report = field.solve(bodies_at([[2.03, 2.01, 1.98]], [UPRIGHT]))
    solver = field.solver
    none = solver._true_residual(medium, (0.0, 0.0, 1.0), grid.zeros())
    true = solver._true_residual(medium, (0.0, 0.0, 1.0), solver.potential) / none
    # Round-off of 1e-15 in a residual of 1e-7.
    assert report.residual == pytest.approx(true, rel=1e-6)
    assert report.iterations > 0


@pytest.mark.parametrize("density", [0.1, 1.0, 10.0])
def test_contact_knows_the_mass_that_an_impulse_moves(density):
    """V = J/m with m = (ρ_p + ρ/2)V, once the pressure has answered; contact's sub-steps take m."""
    bead = sphere([3, 3, 3], 1.0, motion="free", density=density)
    profile = {"kind": "quartic-centred", "thickness": 0.75, "retract": "planar"}
    run = run_of(bead, side=6.0, cells=24, viscosity=0.01, profile=profile)
    mass = 4.0 / 3.0 * math.pi * (density + 0.5)
    for step in range(12):
        run.bodies.free.loads[0, 0] = mass / run.time_step if step == 0 else 0.0
        run.step_once()
    # Viscosity and the fluid carried along in the layer take some; without ρ/2 it would be 1.05 to
    # 6 times as much at ρ_p = 10 to .1.
    assert run.bodies.state.velocity[0, 0] == pytest.approx(1.0, abs=0.25)
