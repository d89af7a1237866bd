"""What is told and kept of a run that stopped being a solution."""

from typing import Any

import numpy as np

from smoothprofile.errors import BlowUpError
from smoothprofile.flow.monitor import watch
from smoothprofile.flow.stability import largest_stable_step
from smoothprofile.pairing import ADVECTIVE_SHARE

SMALLER = 0.5


def watch_flow(run: Any) -> None:
    """BlowUpError once the flow has ceased to be one, with a Δt that would have held."""
    advection = run.case.fluid.advection
    try:
        watch(run.grid, run.state, run.extremes, run.time_step, advection)
    except BlowUpError as error:
        held = step_that_holds(run)
        raise BlowUpError(
            f"{str(error).rstrip('.')}; Δt = {held:.3g} would have held by the speeds before it.",
            held,
        ) from None


def step_that_holds(run: Any) -> float:
    """The stable step at the median of the largest speeds so far; half of the step at most."""
    speeds = np.array(run.history.get("max_speed", ()), dtype=np.float64)
    speeds = speeds[np.isfinite(speeds)]
    usual = float(np.median(speeds)) if speeds.size else max(run.pairing.speed)
    sides = run.case.domain.sides
    walled = tuple(sides[f"{d}_low"] == sides[f"{d}_high"] == "wall" for d in "xyz")
    parameters = run.flow.parameters
    limit = largest_stable_step(
        run.grid, walled, parameters.kinematic_viscosity, (usual,) * 3, parameters.scheme
    )
    return min(SMALLER * run.time_step, ADVECTIVE_SHARE * limit)
