"""Direct solution of Poisson and Helmholtz problems by separation of variables.

    (σ − ∇²) f = r,   f̂ = r̂/(σ + λ_x + λ_y + λ_z)

Every axis is taken into its eigenbasis, except that a walled y axis is not transformed: there the
problem is tridiagonal for each (x,z) mode, and one elimination sweep costs a fraction of two
transforms, for uniform and stretched spacing alike.
"""

from itertools import pairwise

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.grid import Grid
from smoothprofile.threads import thread_count
from smoothprofile.transforms import basis_for, lines_at_once, second_difference

SWEPT = 1
CACHE_BYTES = 1024 * 1024


class SeparableSolver:
    """Solves (σ − ∇²) f = r for one field of a grid with homogeneous boundary conditions."""

    def __init__(self, grid: Grid, boundary: FieldBoundary):
        self.unknowns = boundary.unknowns(grid)
        self.starts = tuple(s.start for s in self.unknowns)
        self.shape = tuple(s.stop - s.start for s in self.unknowns)
        self.solvable = all(n > 0 for n in self.shape)
        if not self.solvable:
            return
        self.sweeps = not boundary.periodic(SWEPT)
        self.transformed = (0, 2) if self.sweeps else (0, 1, 2)
        self.bases = {d: basis_for(grid, boundary, d) for d in self.transformed}
        self.eigenvalues = {d: b.eigenvalues.astype(grid.dtype) for d, b in self.bases.items()}
        self.normalisation = 1.0 / np.prod([b.norm for b in self.bases.values()])
        if self.sweeps:
            d = second_difference(grid.axes[SWEPT], boundary, SWEPT)
            self.rows = tuple(a.astype(grid.dtype) for a in (d.lower, d.diagonal, d.upper))
            self.weights = d.weights.astype(grid.dtype)
            alike = np.diff(self.eigenvalues[0]) == 0
            groups = np.flatnonzero(np.concatenate([[True], ~alike, [True]]))
            plane = self.shape[1] * self.shape[2] * np.dtype(grid.dtype).itemsize
            # Whole multiples of what a transform takes at once, so that blocks change no bit.
            together = lines_at_once(grid.dtype)
            size = together * max(1, CACHE_BYTES // (plane * together))
            edges = [*range(0, self.shape[0], size), self.shape[0]]
            self.whole = [groups]
            self.blocks = [
                np.union1d(groups[(groups > a) & (groups < b)], (a, b)) for a, b in pairwise(edges)
            ]
            self.ends_free = boundary.conditions[SWEPT] == ("flux", "flux")

    def solve(self, field: np.ndarray, shift: float, factor: float = 1.0) -> None:
        """field ← (shift − ∇²)⁻¹ (factor·field), in place, on the unknowns of a padded field.

        With shift 0 and no fixed value at any boundary the problem has a free constant: the
        mean of the right-hand side is discarded and the solution has zero mean.
        """
        if not self.solvable:
            return
        view = field[self.unknowns]
        shift, scale = field.dtype.type(shift), field.dtype.type(factor * self.normalisation)
        self.bases[0].forward(view, 0)
        if self.sweeps:
            # One thread goes through blocks that its cache holds; several share whole passes.
            for groups in self.blocks if thread_count() == 1 else self.whole:
                self._solve_planes(field, groups, shift, scale)
        else:
            self._solve_modes(field, shift, scale)
        self.bases[0].backward(view, 0)

    def _solve_modes(self, field: np.ndarray, shift: float, scale: float) -> None:
        """Divide by the eigenvalues in the bases of y and z."""
        view = field[self.unknowns]
        for d in (1, 2):
            self.bases[d].forward(view, d)
        _divide(field, self.starts, *self.eigenvalues.values(), shift, scale)
        for d in (2, 1):
            self.bases[d].backward(view, d)

    def _solve_planes(
        self, field: np.ndarray, groups: np.ndarray, shift: float, scale: float
    ) -> None:
        """Transform z, sweep y, transform back, for the x modes groups[0] … groups[−1]."""
        view = field[self.unknowns][groups[0] : groups[-1]]
        x, z = self.eigenvalues[0], self.eigenvalues[2]
        singular = shift == 0 and self.ends_free
        self.bases[2].forward(view, 2)
        _sweep(field, self.starts, groups, x, z, *self.rows, self.weights, shift, scale, singular)
        self.bases[2].backward(view, 2)


@njit(parallel=True, cache=True, error_model="numpy")
def _divide(f, starts, lx, ly, lz, shift, scale):
    for i in prange(lx.size):
        for j in range(ly.size):
            row = f[starts[0] + i, starts[1] + j]
            partial = shift + lx[i] + ly[j]
            for k in range(lz.size):
                total = partial + lz[k]
                row[starts[2] + k] *= scale / total if total > 0 else 0 * scale


@njit(parallel=True, cache=True, error_model="numpy")
def _sweep(f, starts, groups, lx, lz, lower, diagonal, upper, weights, shift, scale, singular):
    n, m = diagonal.size, lz.size
    i0, j0, k0 = starts
    for g in prange(groups.size - 1):
        # Planes with one eigenvalue (a cosine and its sine) have the same pivots.
        first = groups[g]
        inverse = np.empty((n, m), f.dtype)
        base = lz + (shift + lx[first])
        for k in range(m):
            inverse[0, k] = 1 / (diagonal[0] + base[k])
        for j in range(1, n):
            d, product = diagonal[j], lower[j] * upper[j - 1]
            row, above = inverse[j], inverse[j - 1]
            for k in range(m):
                row[k] = 1 / (d + base[k] - product * above[k])
        for i in range(i0 + first, i0 + groups[g + 1]):
            _eliminate(f, i, j0, k0, inverse, lower, scale)
            if singular and lx[first] == 0:
                _free_constant(f[i, j0 : j0 + n], k0, lz)
            _substitute(f, i, j0, k0, inverse, upper)
            if singular and lx[first] == 0:
                _remove_mean(f[i, j0 : j0 + n], k0, lz, weights)


# Rows are one-dimensional slices, indexed from zero: the compiler vectorises loops over those.


@njit(inline="always")
def _eliminate(f, i, j0, k0, inverse, lower, scale):
    n, m = inverse.shape
    row, pivot = f[i, j0, k0 : k0 + m], inverse[0]
    for k in range(m):
        row[k] = scale * row[k] * pivot[k]
    for j in range(1, n):
        above, row, pivot = row, f[i, j0 + j, k0 : k0 + m], inverse[j]
        b = lower[j]
        for k in range(m):
            row[k] = (scale * row[k] - b * above[k]) * pivot[k]


@njit(inline="always")
def _substitute(f, i, j0, k0, inverse, upper):
    n, m = inverse.shape
    row = f[i, j0 + n - 1, k0 : k0 + m]
    for j in range(n - 2, -1, -1):
        below, row, pivot = row, f[i, j0 + j, k0 : k0 + m], inverse[j]
        e = upper[j]
        for k in range(m):
            row[k] -= e * pivot[k] * below[k]


@njit
def _free_constant(rows, k0, lz):
    """The constant mode's last pivot is round-off, and its last value free: zero."""
    for k in range(lz.size):
        if lz[k] == 0:
            rows[-1, k0 + k] = 0


@njit
def _remove_mean(rows, k0, lz, weights):
    for k in range(lz.size):
        if lz[k] == 0:
            rows[:, k0 + k] -= (weights * rows[:, k0 + k]).sum() / weights.sum()
