"""One problem by one method on one mesh, timed: what the study of methods is made of."""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from smoothprofile.assembly import build_grid
from smoothprofile.config import load_case
from smoothprofile.flow.advance import Flow, FlowParameters
from smoothprofile.flow.state import fluid_at_rest
from smoothprofile.flow.walls import Walls
from smoothprofile.force_coupled_flow import ForceCoupledFlow, Spheres
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import BodyState, bodies_at
from smoothprofile.schemes import scheme_named
from smoothprofile.shapes import sphere
from smoothprofile.simulation import Simulation
from smoothprofile.studies.refinement_runs import cored, uniform
from smoothprofile.viscous.around import stokes_around
from smoothprofile.viscous.force_coupling import ForceCoupling
from smoothprofile.viscous.smoothed_viscosity import SmoothedStokes
from smoothprofile.viscous.smoothed_viscosity_bodies import mobility
from smoothprofile.viscous.smoothed_viscosity_medium import viscous_medium

LONE, LONE_SPIN = 6.0 * math.pi, 8.0 * math.pi
PULL, TURN = np.array([[1.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
"""A force and a torque, a speed and a spin, of one."""
ACROSS, ALONG, WALL_SPEED = 7.0, 20.0, 5.0
LAYER = 1.3
"""ξ in cells, of direct forcing in the duct, tanh."""
CUBE_LAYER, CUBE_RATIO = 3.0, 0.3
"""ξ in cells and √(νΔt)/ξ, of direct forcing in arrays, the centred quartic: no tails in gaps."""
STIFF = 1000.0
TOLERANCE = 1e-4
"""Of every iteration."""
STEADY = 1e-4
"""max|∂u/∂t|/max|u| at which a march in time ends."""
FCM_STEP, FCM_LONG_STEP, FCM_STEPS = 0.05, 5.0, 400
FCM_GAIN = 6.0
"""By how much the force on a held sphere answers to its speed, each step: of 6πμa ~ 19."""


@dataclass(frozen=True)
class Timed:
    """F/(6πμaU), or in the duct F or F/U; cells or unknowns, and seconds with all preparation."""

    value: float
    cells: int
    seconds: float


Solve = Callable[[], tuple[float, int]]


def timed(solve: Solve) -> Timed:
    """solve: () -> value, cells. The least of as many runs as fit into a second, three at most."""
    seconds: list[float] = []
    while not seconds or (len(seconds) < 3 and sum(seconds) < 1.0):
        begin = time.perf_counter()
        value, cells = solve()
        seconds.append(time.perf_counter() - begin)
    return Timed(value, cells, min(seconds))


def side_of(fraction: float) -> float:
    """The cube that a sphere of radius one fills to that fraction."""
    return (4.0 * math.pi / (3.0 * fraction)) ** (1.0 / 3.0)


def cube(side: float, per_radius: float) -> Grid:
    """A periodic cube from −side/2 on, of about so many cells to a radius."""
    cells = round(side * per_radius)
    return Grid(tuple(uniform_axis(name, -0.5 * side, side, cells, True) for name in "xyz"))


def centre() -> BodyState:
    """One sphere at the origin."""
    return bodies_at([[0.0] * 3], [(1.0, 0.0, 0.0, 0.0)])


def forced_array(fraction: float, per_radius: float, turns: bool = False) -> Solve:
    """Direct forcing, marched to rest: a force at unit mean velocity, a torque at unit spin."""
    side = side_of(fraction)

    def solve() -> tuple[float, int]:
        changes = _cube_changes(side, per_radius)
        if turns:
            changes["fluid.mean_velocity"] = {"x": 0.0, "y": 0.0, "z": 0.0}
            changes["particles.0.motion"] = "prescribed"
            changes["particles.0.angular_velocity"] = TURN[0].tolist()
        run = Simulation.from_file("sphere-array", changes)
        run.run()
        body, cells = run.particles[0], run.grid.cell_count
        if turns:
            return -float(body["torque"][2]) / LONE_SPIN, cells
        return float(body["force"][0]) / LONE, cells

    return solve


def _cube_changes(side: float, per_radius: float) -> dict[str, object]:
    cells = round(side * per_radius)
    thickness = CUBE_LAYER * side / cells
    return {
        "domain.lengths": [side] * 3,
        "domain.origin": [-0.5 * side] * 3,
        "domain.cells": [cells] * 3,
        "profile.thickness": thickness,
        "time.step": (CUBE_RATIO * thickness) ** 2,
        "time.steady_tolerance": STEADY,
        "reference": None,
    }


def forced_duct(per_radius: float, advection: bool, refined: bool) -> Solve:
    """Direct forcing in the duct, marched to rest; F, or F over the walls' speed as Re → 0."""

    def solve() -> tuple[float, int]:
        changes = duct_mesh(per_radius, refined) | {
            "fluid.advection": advection,
            "profile.thickness": LAYER / per_radius,
            "time.end": 20.0,
            "time.steady_tolerance": STEADY,
        }
        run = Simulation.from_file("duct", changes)
        run.run()
        over = 1.0 if advection else WALL_SPEED
        return float(run.particles[0]["force"][0]) / over, run.grid.cell_count

    return solve


def duct_mesh(per_radius: float, refined: bool) -> dict[str, object]:
    """Equal cells, so many to a radius, or as narrow as that in a core around the sphere."""
    if refined:
        return cored(round(5.6 * per_radius), round(6.0 * per_radius)).changes()
    return uniform(round(ALONG * per_radius), round(ACROSS * per_radius)).changes()


def stokes_array(fraction: float, per_radius: float, turns: bool = False) -> Solve:
    """The steady rigid-body solver: a force at unit mean velocity, a torque at unit spin."""

    def solve() -> tuple[float, int]:
        grid = cube(side_of(fraction), per_radius)
        solver = stokes_around(grid, [sphere(1.0)], 1.0)
        if turns:
            found = solver.resistance(centre(), 0.0, TURN, tolerance=TOLERANCE)
            return -float(found.torque[0, 2]) / LONE_SPIN, grid.cell_count
        flow = {"mean_velocity": (1.0, 0.0, 0.0), "tolerance": TOLERANCE}
        found = solver.resistance(centre(), 0.0, 0.0, **flow)
        return float(found.force[0, 0]) / LONE, grid.cell_count

    return solve


def stokes_duct(per_radius: float, refined: bool) -> Solve:
    """The steady rigid-body solver between walls that move with one."""

    def solve() -> tuple[float, int]:
        grid = duct_grid(per_radius, refined)
        solver = stokes_around(grid, [sphere(1.0)], 1.0)
        walls = np.zeros((3, 2, 3))
        walls[:, :, 0] = 1.0
        options = {"mean_velocity": (None, 0.0, 0.0), "wall_velocity": walls}
        found = solver.resistance(centre(), 0.0, 0.0, tolerance=TOLERANCE, **options)
        return float(found.force[0, 0]), grid.cell_count

    return solve


def duct_grid(per_radius: float, refined: bool) -> Grid:
    """The mesh of `duct_mesh`."""
    return build_grid(load_case("duct", duct_mesh(per_radius, refined)).domain)


def viscous_array(fraction: float, per_radius: float, turns: bool = False) -> Solve:
    """Smoothed viscosity: motion of the sphere under a force or a torque."""

    def solve() -> tuple[float, int]:
        grid, state = cube(side_of(fraction), per_radius), centre()
        medium = viscous_medium(grid, [sphere(1.0)], [STIFF], retract="torque" if turns else "drag")
        medium.paint(state)
        loads = (np.zeros((1, 3)), TURN) if turns else (PULL, None)
        found = mobility(SmoothedStokes(grid), medium, state, *loads, TOLERANCE)
        return _resistance(found, turns), grid.cell_count

    return solve


def coupled_array(fraction: float, per_radius: float, turns: bool = False) -> Solve:
    """Force coupling: motion of the sphere under a force or a torque."""

    def solve() -> tuple[float, int]:
        grid = cube(side_of(fraction), per_radius)
        spheres = ForceCoupling(grid, 1.0, [1.0], tolerance=TOLERANCE)
        loads = {"torque": TURN} if turns else {"force": PULL}
        return _resistance(spheres.solve([[0.0] * 3], **loads), turns), grid.cell_count

    return solve


def _resistance(found, turns: bool) -> float:
    """Of a sphere under a load of one, over that of a lone one."""
    if turns:
        return 1.0 / LONE_SPIN / float(found.angular_velocity[0, 2])
    return 1.0 / LONE / float(found.velocity[0, 0])


def coupled_duct(per_radius: float, advection: bool) -> Solve:
    """Force coupling in the flow solver: the force that holds a sphere between sliding walls."""

    def solve() -> tuple[float, int]:
        grid = duct_grid(per_radius, False)
        kinds = (("periodic",) * 2, ("wall",) * 2, ("wall",) * 2)
        sides = [f"{axis}_{end}" for axis in "yz" for end in ("low", "high")]
        moving = {side: lambda t: np.array([WALL_SPEED, 0.0, 0.0]) for side in sides}
        parameters = FlowParameters(
            walls=Walls(kinds, moving),
            scheme=scheme_named("backward-euler"),
            advection=advection,
        )
        flow = Flow(grid, parameters)
        state = fluid_at_rest(grid)
        flow.fill(state.velocity, 0.0)
        run = ForceCoupledFlow(flow, state, Spheres.of([1.0], 1.0), [[0.0] * 3])
        force = _held(run, FCM_STEP if advection else FCM_LONG_STEP)
        return force if advection else force / WALL_SPEED, grid.cell_count

    return solve


def _held(run: ForceCoupledFlow, step: float) -> float:
    """The force that keeps the sphere at rest, found along with the flow."""
    for _ in range(FCM_STEPS):
        run.step(step)
        change = FCM_GAIN * float(run.motion.velocity[0, 0])
        run.load[0, 0] -= change
        if run.state.time > 2.0 and abs(change) < TOLERANCE * abs(run.load[0, 0]):
            break
    return -float(run.load[0, 0])
