"""Steady Stokes flow by direct solves, in boxes whose sides are periodic or slip.

    σu = −∇p + μ∇²u + f,   ∇·u = 0

There ∇² commutes with ∇· on the staggered grid, uniform or stretched, so that both equations hold
to round-off with one Poisson solve for p and one solve for each component of u:

    ∇²p = ∇·f,   (σ − μ∇²) u = f − ∇p
"""

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import fill_ghosts, pressure_boundary, velocity_boundary
from smoothprofile.grid import Grid
from smoothprofile.solvers.separable import SeparableSolver
from smoothprofile.staggered import divergence, spacings, volume_mean

SLIP = (("slip", "slip"),) * 3
Vector = tuple[np.ndarray, np.ndarray, np.ndarray]


class DirectStokes:
    """The Stokes solve of one grid; axes that are not periodic end in free-slip walls."""

    def __init__(self, grid: Grid, viscosity: float):
        self.grid, self.viscosity = grid, float(viscosity)
        self.boundaries = tuple(velocity_boundary(grid, SLIP, c) for c in range(3))
        self.pressure_boundary = pressure_boundary(grid)
        self._solvers = tuple(SeparableSolver(grid, b) for b in self.boundaries)
        self._poisson = SeparableSolver(grid, self.pressure_boundary)
        self._spacings = spacings(grid)

    def solve(
        self,
        force: Vector,
        velocity: Vector,
        pressure: np.ndarray,
        mean: tuple | None = (0.0, 0.0, 0.0),
        resistance: float = 0.0,
    ) -> np.ndarray:
        """σu = −∇p − G + μ∇²u + f, ∇·u = 0; returns G (3,), the mean pressure gradient.

        force, velocity: padded fields (u, v, w), which may be the same; pressure: padded, of zero
        mean, without the part G·x. All ghosts are filled, those of the force too.
        mean: the mean velocity along periodic axes, held by G = ⟨f⟩ − σ⟨u⟩. None, which takes a
        σ > 0, leaves it free: then G = 0. resistance: σ.
        """
        for f, boundary in zip(force, self.boundaries, strict=True):
            fill_ghosts(f, boundary)
        divergence(*force, -1.0, pressure, *self._spacings)
        self._poisson.solve(pressure, 0.0)
        fill_ghosts(pressure, self.pressure_boundary)
        gradient = np.zeros(3)
        subtract_gradient(*force, pressure, *velocity, *self._spacings)
        shift, factor = resistance / self.viscosity, 1.0 / self.viscosity
        for c, u in enumerate(velocity):
            held = mean is not None and self.grid.axes[c].periodic
            if held:
                # The gradient of p has no mean along a periodic axis.
                total = volume_mean(self.grid, u, c)
                gradient[c] = total - resistance * mean[c]
                u -= total
            self._solvers[c].solve(u, shift, factor)
            if held and mean[c]:
                u += mean[c]
            fill_ghosts(u, self.boundaries[c])
        return gradient

    def largest_divergence(self, velocity: Vector, scratch: np.ndarray) -> float:
        """max |∇·u| of a velocity with filled ghosts; overwrites `scratch`."""
        divergence(*velocity, 1.0, scratch, *self._spacings)
        return float(np.abs(scratch[1:-1, 1:-1, 1:-1]).max())


@njit(parallel=True, cache=True)
def subtract_gradient(fx, fy, fz, p, u, v, w, sx, sy, sz):
    """u = f − ∇p on the interior, which may be in place; sx, sy, sz are the `spacings`."""
    gz = sz[1]
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            here, west, south = p[i, j], p[i - 1, j], p[i, j - 1]
            a, b, c, x, y, z = fx[i, j], fy[i, j], fz[i, j], u[i, j], v[i, j], w[i, j]
            gx, gy = sx[1, i], sy[1, j]
            for k in range(1, u.shape[2] - 1):
                x[k] = a[k] - gx * (here[k] - west[k])
                y[k] = b[k] - gy * (here[k] - south[k])
                z[k] = c[k] - gz[k] * (here[k] - here[k - 1])
