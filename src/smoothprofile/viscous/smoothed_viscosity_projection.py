"""The divergence-free part of a field on the faces of a periodic box, without its mean.

    f ← f − ⟨f⟩ − ∇p,    ∇²p = ∇·f

An orthogonal projection: f·g of two divergence-free fields is what it was.
"""

import numpy as np

from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.grid import Grid
from smoothprofile.solvers.separable import SeparableSolver
from smoothprofile.staggered import divergence
from smoothprofile.viscous.direct import Vector, subtract_gradient


class Projection:
    """The projection of one grid of uniform periodic axes; `pressure` is the last p, zero mean."""

    def __init__(self, grid: Grid):
        self._spacings = tuple(np.full((2, a.cells + 2), 1.0 / a.widths[0]) for a in grid.axes)
        self.boundary = pressure_boundary(grid)
        self.poisson = SeparableSolver(grid, self.boundary)
        self.pressure = grid.zeros()
        self.mean = np.zeros(3)

    def __call__(self, field: Vector) -> None:
        """In place; fills the ghosts. `mean` is what was taken off."""
        for d, component in enumerate(field):
            inner = component[1:-1, 1:-1, 1:-1]
            self.mean[d] = inner.mean()
            inner -= self.mean[d]
            fill_ghosts(component, self.boundary)
        divergence(*field, -1.0, self.pressure, *self._spacings)
        self.poisson.solve(self.pressure, 0.0)
        fill_ghosts(self.pressure, self.boundary)
        subtract_gradient(*field, self.pressure, *field, *self._spacings)
        for component in field:
            fill_ghosts(component, self.boundary)
