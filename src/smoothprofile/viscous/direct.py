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
        self._spacings = tuple(
            np.stack([1 / a.padded_widths, 1 / a.padded_distances]).astype(grid.dtype)
            for a in grid.axes
        )
        self._sizes = [_cell_sizes(grid, c) for c in range(3)]

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
        _divergence(*force, -1.0, pressure, *self._spacings)
        self._poisson.solve(pressure, 0.0)
        fill_ghosts(pressure, self.pressure_boundary)
        gradient = np.zeros(3)
        _subtract_gradient(*force, pressure, *velocity, *self._spacings)
        shift, factor = resistance / self.viscosity, 1.0 / self.viscosity
        for c, u in enumerate(velocity):
            held = mean is not None and self.grid.axes[c].periodic
            if held:
                # The gradient of p has no mean along a periodic axis.
                total = self.mean(u, c)
                gradient[c] = total - resistance * mean[c]
                u -= total
            self._solvers[c].solve(u, shift, factor)
            if held and mean[c]:
                u += mean[c]
            fill_ghosts(u, self.boundaries[c])
        return gradient

    def mean(self, field: np.ndarray, component: int) -> float:
        """Volume mean of a field that lies where velocity `component` does."""
        return float(_weighted(field, *self._sizes[component]).sum()) / self.grid.volume

    def largest_divergence(self, velocity: Vector, scratch: np.ndarray) -> float:
        """max |∇·u| of a velocity with filled ghosts; overwrites `scratch`."""
        _divergence(*velocity, 1.0, scratch, *self._spacings)
        return float(np.abs(scratch[1:-1, 1:-1, 1:-1]).max())


def _cell_sizes(grid: Grid, component: int) -> list[np.ndarray]:
    """Along each axis the sizes (n+2,) of the cells around the points of that component."""
    return [
        axis.padded_distances if d == component else axis.padded_widths
        for d, axis in enumerate(grid.axes)
    ]


@njit(parallel=True, cache=True)
def _divergence(u, v, w, factor, out, sx, sy, sz):
    rz = sz[0]
    for i in prange(1, u.shape[0] - 1):
        for j in range(1, u.shape[1] - 1):
            row, u0, ue, v0, vn, w0 = out[i, j], u[i, j], u[i + 1, j], v[i, j], v[i, j + 1], w[i, j]
            rx, ry = sx[0, i], sy[0, j]
            for k in range(1, u.shape[2] - 1):
                row[k] = factor * (
                    rx * (ue[k] - u0[k]) + ry * (vn[k] - v0[k]) + rz[k] * (w0[k + 1] - w0[k])
                )


@njit(parallel=True, cache=True)
def _subtract_gradient(fx, fy, fz, p, u, v, w, sx, sy, sz):
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


@njit(parallel=True, cache=True)
def _weighted(f, dx, dy, dz):
    """∫f over each plane."""
    sums = np.zeros(f.shape[0])
    for i in prange(1, f.shape[0] - 1):
        for j in range(1, f.shape[1] - 1):
            row = 0.0
            for k in range(1, f.shape[2] - 1):
                row += f[i, j, k] * dz[k]
            sums[i] += row * dx[i] * dy[j]
    return sums
