"""A uniform body force that holds the mean velocity along periodic axes.

    uˢ ← uˢ + g w,   (1 − c∇²) w = Δt/γ,   g = (U − ⟨uˢ⟩)/⟨w⟩

w is what a unit force does to one step. Along a periodic axis the projection does not change the
mean, so that it is exactly U after the step.
"""

from collections.abc import Callable

import numpy as np
from numba import njit, prange

from smoothprofile.grid import Grid
from smoothprofile.staggered import volume_mean

Mean = Callable[[np.ndarray, int, bool], float]
_AT_REST = ((0.0, 0.0),) * 3


class MeanFlow:
    """Holds targets[axis]; None leaves that component free."""

    def __init__(self, grid: Grid, targets: tuple, viscosity: tuple):
        self.grid = grid
        self.targets = {d: U for d, U in enumerate(targets) if U is not None}
        self._viscosity = viscosity
        self._response: dict[int, np.ndarray] = {}
        self._response_mean: dict[int, float] = {}
        self._key = None
        self.force = np.zeros(3)

    def prepare(self, implicit: float, step: float) -> None:
        """Find w for c = implicit and Δt/γ = step, unless it is known already."""
        if not self.targets or self._key == (implicit, step):
            return
        for d in self.targets:
            w = self._response.setdefault(d, self.grid.zeros())
            w[1:-1, 1:-1, 1:-1] = step
            self._viscosity[d].solve(w, implicit, _AT_REST)
            self._response_mean[d] = volume_mean(self.grid, w, d)
        self._key = (implicit, step)

    def hold(self, velocity: tuple, mean: Mean | None = None) -> None:
        """Add the force's response. mean(field, axis, is_velocity) is taken after what follows.

        What follows the predictor, rigid bodies say, may change the mean: it passes its own
        `mean`, which must be affine in a velocity and linear in a response.
        """
        mean = mean or self.plain_mean
        for d, target in self.targets.items():
            g = (target - mean(velocity[d], d, True)) / mean(self._response[d], d, False)
            _add(velocity[d], velocity[d].dtype.type(g), self._response[d])
            self.force[d] = g

    def added(self) -> list[tuple[int, np.ndarray]]:
        """The axes that are held, and what a unit force does to their velocity in one step."""
        return [(d, self._response[d]) for d in self.targets]

    def plain_mean(self, field: np.ndarray, axis: int, is_velocity: bool = True) -> float:
        """Volume mean of a field that lies where velocity component `axis` does.

        What is no velocity is w of that axis, whose mean stays the same from step to step.
        """
        return volume_mean(self.grid, field, axis) if is_velocity else self._response_mean[axis]


@njit(parallel=True, cache=True)
def _add(field, factor, other):
    for i in prange(field.shape[0]):
        field[i] += factor * other[i]
