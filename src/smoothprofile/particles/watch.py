"""Watch on free bodies: whether each is still where a step may take it.

    |Rⁿ⁺¹ − Rⁿ| ≤ a/2,   low ≤ Rⁿ⁺¹ ≤ high along axes with walls

a is the smallest half extent of the body. Faster bodies outrun what the step can know of the fluid
around them; those beyond a wall have left it.
"""

from collections.abc import Sequence

import numpy as np

from smoothprofile.errors import BlowUpError
from smoothprofile.grid import AXIS_NAMES, Grid

FARTHEST = 0.5


class BodyWatch:
    """Looks at the free bodies of one run after each step."""

    def __init__(self, grid: Grid, rows: np.ndarray, extents: np.ndarray, names: Sequence[str]):
        """rows (m,) of the free bodies, extents (n,3) of all, names (n,)."""
        self._rows, self._names = rows, names
        self._farthest = FARTHEST * extents[rows].min(axis=1)
        walled = ~np.array(grid.periodic)
        self._low = np.where(walled, [axis.low for axis in grid.axes], -np.inf)
        self._high = np.where(walled, [axis.high for axis in grid.axes], np.inf)
        self._before: np.ndarray | None = None

    def __call__(self, position: np.ndarray, time: float, dt: float) -> None:
        """BlowUpError for the first body that is lost, with what it did and what is allowed."""
        if not self._rows.size:
            return
        here, before = position[self._rows], self._before
        self._before = here
        if not np.isfinite(here).all():
            b = int(np.argmin(np.isfinite(here).all(axis=1)))
            raise BlowUpError(
                f"At time {time:.6g} the place of {self._name(b)} is not finite; the step "
                f"Δt = {dt:.4g} is too large for its motion.",
                0.5 * dt,
            )
        outside = (here < self._low) | (here > self._high)
        if outside.any():
            b, d = np.argwhere(outside)[0]
            raise BlowUpError(
                f"At time {time:.6g} {self._name(b)} has left the box: its {AXIS_NAMES[d]} is "
                f"{here[b, d]:.4g}, and the walls are at {self._low[d]:.4g} and "
                f"{self._high[d]:.4g}; take a step below Δt = {dt:.4g}, or a larger contact.range.",
                0.5 * dt,
            )
        if before is None:
            return
        moved = np.linalg.norm(here - before, axis=1)
        if np.any(moved > self._farthest):
            b = int(np.argmax(moved > self._farthest))
            held = dt * self._farthest[b] / moved[b]
            raise BlowUpError(
                f"At time {time:.6g} {self._name(b)} has moved by {moved[b]:.4g} in one step, and "
                f"may move by half its smallest radius, {self._farthest[b]:.4g}; at that speed "
                f"Δt = {held:.3g} would have held, and it was {dt:.4g}.",
                held,
            )

    def _name(self, row: int) -> str:
        return self._names[self._rows[row]]
