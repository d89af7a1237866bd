"""The divergence-free part of a field on the faces of a periodic box, without its mean.

    f ← f − ⟨f⟩ − ∇p,    ∇²p = ∇·f

An orthogonal projection: f·g of two divergence-free fields is what it was.
"""

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.grid import Grid
from smoothprofile.solvers.separable import SeparableSolver

Vector = tuple[np.ndarray, np.ndarray, np.ndarray]


class Projection:
    """The projection of one grid of uniform periodic axes; `pressure` is the last p, zero mean."""

    def __init__(self, grid: Grid):
        self.rates = tuple(float(1.0 / axis.widths[0]) for axis in grid.axes)
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
        divergence(*field, self.rates, -1.0, self.pressure)
        self.poisson.solve(self.pressure, 0.0)
        fill_ghosts(self.pressure, self.boundary)
        _subtract_gradient(*field, self.pressure, self.rates)
        for component in field:
            fill_ghosts(component, self.boundary)


@njit(parallel=True, cache=True)
def divergence(u, v, w, rates, factor, out):
    """out = factor·∇·u in the cells; the ghosts of u must be filled."""
    rx, ry, rz = factor * rates[0], factor * rates[1], factor * rates[2]
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            for k in range(1, u.shape[2] - 1):
                out[i, j, k] = (
                    rx * (u[i + 1, j, k] - u[i, j, k])
                    + ry * (v[i, j + 1, k] - v[i, j, k])
                    + rz * (w[i, j, k + 1] - w[i, j, k])
                )


@njit(parallel=True, cache=True)
def _subtract_gradient(u, v, w, p, rates):
    rx, ry, rz = rates
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            for k in range(1, u.shape[2] - 1):
                here = p[i, j, k]
                u[i, j, k] -= rx * (here - p[i - 1, j, k])
                v[i, j, k] -= ry * (here - p[i, j - 1, k])
                w[i, j, k] -= rz * (here - p[i, j, k - 1])
