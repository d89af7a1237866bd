"""What a run of a flow records: a row of its history, and a row a body."""

from typing import TYPE_CHECKING, Any

import numpy as np

from smoothprofile import sampling, structure, suspension, wall_stress
from smoothprofile.numbers import numbers_of
from smoothprofile.particles.stress import components
from smoothprofile.selfcheck import error_card

if TYPE_CHECKING:
    from smoothprofile.simulation import Simulation


def history_row(run: "Simulation") -> dict[str, Any]:
    """The numbers of the whole run at its present time."""
    return {
        "step": run.steps,
        "time": run.time,
        "max_speed": max(run.extremes.speed),
        "change_rate": run.extremes.rate(run.time_step),
        "wall_force": run.wall_force["total"],
        "body_force": run.bodies.state.force.sum(axis=0),
        "driving_force": run.driving_force,
        **suspension.history_row(run),
        **wall_stress.history_row(run),
        **run.action.history(),
        **structure.history_row(run),
    }


def totals(run: "Simulation") -> dict[str, Any]:
    """What a summary says of the whole: the suspension, the stress on sliding walls, the field."""
    return {
        **suspension.totals(run),
        **wall_stress.history_row(run),
        **run.action.history(),
        **structure.history_row(run),
        "numbers": numbers_of(run.case, fastest(run)),
        "error_card": error_card(run),
    }


def fastest(run: "Simulation") -> float | None:
    """The largest |V| of a free body; None if none is free."""
    free = [b for b, particle in enumerate(run.case.particles) if particle.motion == "free"]
    return float(np.linalg.norm(run.bodies.state.velocity[free], axis=1).max()) if free else None


def body_rows(run: "Simulation") -> list[dict[str, Any]]:
    """One dict a body: place, motion, loads, and the fluid's velocity at its centre."""
    state = run.bodies.state
    stresslets = components(run.bodies.stresslets())
    electric = run.action.body_rows(state.count)
    forms = run.bodies.painter.forms
    offset = forms.offset[forms.part_start[:-1], 0]
    inside = [
        sampling.interpolate(run.grid, field, c, state.position)
        for c, field in enumerate(run.state.velocity)
    ]
    return [
        {
            "name": particle.name,
            "shape": particle.shape,
            "position": state.position[b].copy(),
            "velocity": state.velocity[b].copy(),
            "angular_velocity": state.angular_velocity[b].copy(),
            "orientation": state.quaternion[b].copy(),
            "force": state.force[b].copy(),
            "torque": state.torque[b].copy(),
            "stresslet": stresslets[b],
            "interior_velocity": np.array([values[b] for values in inside]),
            "painted_offset": float(offset[b]),
            **electric[b],
        }
        for b, particle in enumerate(run.case.particles)
    ]
