"""What a flow is at one instant: everything that the next step reads."""

from dataclasses import dataclass, field, fields

import numpy as np

from smoothprofile.grid import Grid

Velocity = tuple[np.ndarray, np.ndarray, np.ndarray]


@dataclass
class FlowState:
    """Velocity and kinematic pressure p/ρ (padded, ghosts filled), and older time levels.

    past_velocity and past_advection hold the levels n−1, n−2, …, newest first.
    """

    velocity: Velocity
    pressure: np.ndarray
    time: float = 0.0
    steps: int = 0
    past_velocity: list[Velocity] = field(default_factory=list)
    past_advection: list[Velocity] = field(default_factory=list)

    @property
    def known_levels(self) -> int:
        return 1 + len(self.past_velocity)

    def saved(self) -> dict:
        """Everything, for a checkpoint."""
        return {item.name: getattr(self, item.name) for item in fields(self)}

    def restore(self, saved: dict) -> None:
        """Take back what `saved` gave, into the arrays that are there."""
        for own, old in zip(
            (*self.velocity, self.pressure), (*saved["velocity"], saved["pressure"]), strict=True
        ):
            own[...] = old
        self.time, self.steps = saved["time"], saved["steps"]
        self.past_velocity = [tuple(level) for level in saved["past_velocity"]]
        self.past_advection = [tuple(level) for level in saved["past_advection"]]


def zero_velocity(grid: Grid) -> Velocity:
    """Three padded fields of zeros."""
    return grid.zeros(), grid.zeros(), grid.zeros()


def fluid_at_rest(grid: Grid) -> FlowState:
    """No motion and no pressure."""
    return FlowState(zero_velocity(grid), grid.zeros())
