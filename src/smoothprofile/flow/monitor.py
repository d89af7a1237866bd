"""Watch on a flow: its largest speed and change, and whether it is still a flow."""

from dataclasses import dataclass

import numpy as np

from smoothprofile.errors import BlowUpError
from smoothprofile.flow.state import FlowState
from smoothprofile.grid import AXIS_NAMES, Grid

LARGEST_COURANT = 100.0


@dataclass(frozen=True)
class Extremes:
    """max|u| and max|uⁿ⁺¹−uⁿ| of each component, over the last step."""

    speed: tuple[float, float, float] = (0.0, 0.0, 0.0)
    change: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, planes: np.ndarray) -> "Extremes":
        """From (planes, 6): speeds and changes per plane; NaN wins."""
        found = planes.max(axis=0)
        return cls(tuple(found[:3].tolist()), tuple(found[3:].tolist()))

    def rate(self, dt: float) -> float:
        """max|∂u/∂t| / max|u|, per unit time; 0 for a fluid at rest."""
        return max(self.change) / (dt * max(self.speed)) if max(self.speed) > 0 else 0.0


def watch(grid: Grid, state: FlowState, found: Extremes, dt: float, advection: bool) -> None:
    """BlowUpError, naming field, cell, time and limit, once the flow has ceased to be one.

    The direct solves spread a NaN over the whole field within one step. With advection, a
    Courant number Σ|u_d|Δt/h_d over 100 is no stable step of any scheme here.
    """
    bad = [c for c in range(3) if not np.isfinite(found.speed[c])]
    if bad:
        c = bad[0]
        raise BlowUpError(
            f"{_place(grid, state, c, ~np.isfinite(state.velocity[c][1:-1, 1:-1, 1:-1]))} is not "
            f"finite; the step Δt = {dt:.4g} is too large for this flow."
        )
    courant = sum(s * dt / h for s, h in zip(found.speed, grid.smallest_widths, strict=True))
    if advection and courant > LARGEST_COURANT:
        c = int(np.argmax(found.speed))
        size = np.abs(state.velocity[c][1:-1, 1:-1, 1:-1])
        raise BlowUpError(
            f"{_place(grid, state, c, size == size.max())} has grown to {found.speed[c]:.3g}: the "
            f"Courant number is {_beyond(courant)} and may not exceed {LARGEST_COURANT:g}; "
            f"the step Δt = {dt:.4g} is too large for this flow."
        )


def _beyond(courant: float) -> str:
    """In three digits, or as many as show that it exceeds what it may be."""
    digits = (f"{courant:.{n}g}" for n in range(3, 18))
    return next(text for text in digits if float(text) > LARGEST_COURANT)


def _place(grid: Grid, state: FlowState, c: int, where: np.ndarray) -> str:
    cell = np.unravel_index(int(np.argmax(where)), where.shape)
    centre = ", ".join(f"{a.centres[i]:.4g}" for a, i in zip(grid.axes, cell, strict=True))
    index = ", ".join(str(int(i)) for i in cell)
    return (
        f"At time {state.time:.6g} (step {state.steps}) the velocity component {AXIS_NAMES[c]} "
        f"in cell ({index}) at ({centre})"
    )
