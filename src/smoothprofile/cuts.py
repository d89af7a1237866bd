"""What a run knows on one plane, at the cell centres: of its flow, and of its electric field."""

from typing import Any

import numpy as np

from smoothprofile import sampling
from smoothprofile.config import build_shape
from smoothprofile.electric.field import padded
from smoothprofile.grid import AXIS_NAMES, Grid
from smoothprofile.particles.bodies import BodyState


def of_run(run: Any, axis: str, at: float) -> dict[str, Any]:
    """Speed, in-plane velocity, φ, and the electric field of a run of the flow."""
    found = frame(run.grid, axis, at, run.indicator)
    found |= flow_cut(run.grid, run.state.velocity, axis, at)
    if run.case.electric is None or run.action.loads is None:
        return found
    reach = np.array([build_shape(particle).reach for particle in run.case.particles])
    force = run.action.loads.force
    return {
        **found,
        **field_cut(run.grid, run.electric_field, run.potential, axis, at),
        **forces_in_cut(run.grid, run.bodies.state, reach, force, axis, at),
    }


def frame(grid: Grid, axis: str, at: float, indicator: np.ndarray) -> dict[str, Any]:
    """Coordinates and names of the plane's axes, and φ on it, from φ (nx,ny,nz) at the centres."""
    first, second = others(axis)
    return {
        "x": grid.axes[first].centres,
        "y": grid.axes[second].centres,
        "indicator": centred_cut(grid, indicator, axis, at),
        "labels": (AXIS_NAMES[first], AXIS_NAMES[second]),
    }


def flow_cut(grid: Grid, velocity: tuple, axis: str, at: float) -> dict[str, Any]:
    """Speed and in-plane velocity, of padded fields with filled ghosts."""
    a, (first, second) = AXIS_NAMES.index(axis), others(axis)
    cut = [sampling.on_plane(grid, field, c, a, at) for c, field in enumerate(velocity)]
    speed = np.sqrt(sum(c**2 for c in cut))
    return {"speed": speed, "velocity": np.stack([cut[first], cut[second]])}


def field_cut(
    grid: Grid, vectors: np.ndarray, potential: np.ndarray, axis: str, at: float
) -> dict[str, Any]:
    """|E|, in-plane E and V, from E (3,nx,ny,nz) and V (nx,ny,nz) at the centres."""
    first, second = others(axis)
    field = [centred_cut(grid, part, axis, at) for part in vectors]
    return {
        "strength": np.sqrt(sum(part**2 for part in field)),
        "electric_field": np.stack([field[first], field[second]]),
        "potential": centred_cut(grid, potential, axis, at),
    }


def forces_in_cut(
    grid: Grid, state: BodyState, reach: np.ndarray, force: np.ndarray, axis: str, at: float
) -> dict[str, Any]:
    """Places and forces (m,2), within the plane, of the bodies of those reaches that it cuts."""
    a = AXIS_NAMES.index(axis)
    away = state.position[:, a] - at
    if grid.axes[a].periodic:
        away -= grid.axes[a].length * np.rint(away / grid.axes[a].length)
    rows = np.ix_(np.abs(away) < reach, others(axis))
    return {"places": sampling.in_box(grid, state.position)[rows], "forces": force[rows]}


def others(axis: str) -> tuple[int, int]:
    """The numbers of the two other axes, in order."""
    first, second = (d for d in range(3) if AXIS_NAMES[d] != axis)
    return first, second


def centred_cut(grid: Grid, values: np.ndarray, axis: str, at: float) -> np.ndarray:
    """Values (nx,ny,nz) at the cell centres, on the plane."""
    a = AXIS_NAMES.index(axis)
    return sampling.on_plane(grid, padded(grid, values), sampling.CENTRED, a, at)
