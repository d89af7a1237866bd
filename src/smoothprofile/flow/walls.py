"""Walls of the box: no-slip and moving, or free-slip, and the force that the fluid puts on them.

no-slip: u = U(t);   free slip: u·n = 0, ∂u_t/∂n = 0
F_t = μ ∫ ∂u_t/∂n dA,   F_n = −∫ p n dA            n into the fluid
p n = (p₁ + ρu₁²) n − ½Δx f

where p₁ and the normal velocity u₁ are those at the centres of the cells at the wall and f, per
volume, drives the fluid: the half cell between has no momentum of its own, and hands to the wall
what drives it and what is carried into it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from smoothprofile.boundaries import SIDES
from smoothprofile.grid import AXIS_NAMES, Grid

WallVelocity = Callable[[float], tuple[float, float, float]]


def at_rest(time: float) -> tuple[float, float, float]:
    """The velocity of a wall that does not move."""
    return (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Walls:
    """kinds[axis] = (low, high) of "wall" or "slip"; velocity[name](t) for those that move."""

    kinds: tuple[tuple[str, str], ...] = (("wall", "wall"),) * 3
    velocity: dict[str, WallVelocity] = field(default_factory=dict)

    def values(self, component: int, time: float) -> tuple[tuple[float, float], ...]:
        """values[axis][side] of velocity `component` at the walls, for ghosts and solves."""
        return tuple(
            tuple(
                0.0 if d == component else self.velocity_at(d, side, time)[component]
                for side in range(2)
            )
            for d in range(3)
        )

    def velocity_at(self, axis: int, side: int, time: float) -> tuple[float, float, float]:
        return self.velocity.get(wall_name(axis, side), at_rest)(time)

    def velocities(self, time: float) -> np.ndarray:
        """(axis, side, 3): the velocities of all walls."""
        return np.array([[self.velocity_at(d, side, time) for side in range(2)] for d in range(3)])


def wall_name(axis: int, side: int) -> str:
    """x_low, x_high, … z_high."""
    return f"{AXIS_NAMES[axis]}_{SIDES[side]}"


def viscous_forces(
    grid: Grid, walls: Walls, velocity: tuple, viscosity: float, time: float
) -> dict[str, np.ndarray]:
    """Viscous force of the fluid on each wall, (3,) each, from the dynamic viscosity.

    The slopes are those that the discrete viscous term sees: of a tangential velocity between the
    nearest layer and the wall, of the normal one across the nearest cell, where it goes to zero as
    the cells shrink. So the budget of momentum closes to round-off when `velocity` is the one the
    viscous term acted on.
    """
    forces = {}
    for axis, side in _walled_sides(grid):
        force = np.zeros(3)
        speed, width = walls.velocity_at(axis, side, time), grid.axes[axis].widths[-side]
        for c in range(3):
            if c == axis:
                # The first unknown normal velocity lies one cell in, on either side.
                inward = np.moveaxis(velocity[c], axis, 0)[2 if side == 0 else -2, 1:-1, 1:-1]
                slope = inward / width if grid.shape[axis] > 1 else 0.0 * inward
            elif walls.kinds[axis][side] == "wall":
                slope = (_layer(grid, velocity[c], axis, side) - speed[c]) * (2 / width)
            else:
                continue
            force[c] = viscosity * (slope * _areas(grid, axis, c)).sum()
        forces[wall_name(axis, side)] = force
    return forces


def pressure_forces(
    grid: Grid, pressure: np.ndarray, density: float, drive: Sequence[float]
) -> dict[str, np.ndarray]:
    """Normal force of the fluid on each wall, (3,) each, from the kinematic pressure.

    drive: f of the whole fluid, per volume.
    """
    forces = {}
    for axis, side in _walled_sides(grid):
        force = np.zeros(3)
        outward = 1.0 if side == 1 else -1.0
        half = 0.5 * grid.axes[axis].widths[-side] * drive[axis]
        at_wall = outward * density * _layer(grid, pressure, axis, side) + half
        force[axis] = (at_wall * _areas(grid, axis, axis)).sum()
        forces[wall_name(axis, side)] = force
    return forces


def carried_forces(grid: Grid, velocity: tuple, density: float) -> dict[str, np.ndarray]:
    """Momentum that advection carries to each wall in a second, (3,) each: ρ∫u₁² dA."""
    forces = {}
    for axis, side in _walled_sides(grid):
        force = np.zeros(3)
        faces = np.moveaxis(velocity[axis], axis, 0)
        first, other = (1, 2) if side == 0 else (-2, -1)
        centre = 0.5 * (faces[first, 1:-1, 1:-1] + faces[other, 1:-1, 1:-1])
        outward = 1.0 if side == 1 else -1.0
        force[axis] = outward * density * (centre**2 * _areas(grid, axis, axis)).sum()
        forces[wall_name(axis, side)] = force
    return forces


def _walled_sides(grid: Grid):
    return [(d, side) for d in range(3) if not grid.axes[d].periodic for side in range(2)]


def _layer(grid: Grid, field: np.ndarray, axis: int, side: int) -> np.ndarray:
    """The interior values next to a wall."""
    index = 1 if side == 0 else grid.shape[axis]
    return np.moveaxis(field, axis, 0)[index, 1:-1, 1:-1]


def _areas(grid: Grid, axis: int, component: int) -> np.ndarray:
    """Wall area that belongs to each point of `component` in the layer next to the wall.

    A face on another wall carries no unknown, and no viscous term takes shear from it.
    """
    sides = []
    for d in range(3):
        if d == axis:
            continue
        size = grid.axes[d].widths
        if d == component:
            size = grid.axes[d].padded_distances[1:-1].copy()
            size[0] *= grid.axes[d].periodic
        sides.append(size)
    return np.outer(*sides)
