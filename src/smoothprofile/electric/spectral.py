"""Derivatives, Poisson's equation and sums of periodic fields in Fourier space.

    ∂_d f → ik_d f̂,    ∇²ψ = s → ψ̂ = −ŝ/k²,    ψ̂ = 0 where k = 0

f̂ are the modes of `transforms.to_modes`, without those of negative wave number along z. On an even
axis the highest wave number has no sign: its derivative on the points is zero, and solutions are
sought without it, for −ŝ/k² with the other axes' k alone would make much of little.
"""

import math

import numpy as np
from numba import njit, prange

from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.transforms import mode_shape, to_modes, to_values


class FourierBox:
    """Wave numbers of a uniform periodic grid, and what is done with them.

    Values are (nx,ny,nz) float64 at the cell centres, without ghosts; modes are complex128.
    CaseError unless every axis is periodic and uniform.
    """

    def __init__(self, grid: Grid):
        for axis in grid.axes:
            if not (axis.periodic and axis.uniform):
                raise CaseError(
                    f"the {axis.name} axis is not periodic with equal cells, as a Fourier "
                    "discretisation needs."
                )
        self.shape, self.count = grid.shape, grid.cell_count
        self.wave_numbers = tuple(
            _wave_numbers(axis.cells, axis.length, half=d == 2) for d, axis in enumerate(grid.axes)
        )
        self._squares = tuple(
            _squares(wave, axis.cells)
            for wave, axis in zip(self.wave_numbers, grid.axes, strict=True)
        )
        # How often each mode counts in a sum over all: with its conjugate, but for k_z = 0 and N/2.
        self.weights = np.full(mode_shape(grid.shape)[2], 2.0)
        self.weights[0] = 1.0
        if grid.shape[2] % 2 == 0:
            self.weights[-1] = 1.0

    def new_modes(self) -> np.ndarray:
        return np.zeros(mode_shape(self.shape), np.complex128)

    def new_values(self) -> np.ndarray:
        return np.zeros(self.shape)

    def derivative(self, modes: np.ndarray, d: int, work: np.ndarray, values: np.ndarray) -> None:
        """values = ∂_d f; `work` is scratch for modes."""
        _differentiate(modes, self.wave_numbers[d], d, False, work)
        to_values(work, values)

    def add_derivative(
        self, values: np.ndarray, d: int, work: np.ndarray, total: np.ndarray
    ) -> None:
        """total ← total + (modes of ∂_d f); `work` is scratch for modes."""
        to_modes(values, work)
        _differentiate(work, self.wave_numbers[d], d, True, total)

    def over_square(self, modes: np.ndarray, factor: float, out: np.ndarray) -> None:
        """out = factor·f̂/k², zero where k = 0 or without sign; `out` may be `modes`."""
        _over_square(modes, *self._squares, factor, out)

    def dot(self, first: np.ndarray, second: np.ndarray) -> float:
        """Σ f g over all points (Parseval), the same bits for any number of threads."""
        planes = np.zeros(first.shape[0])
        _dot(first, second, self.weights, planes)
        return float(planes.sum()) / self.count

    def norm(self, modes: np.ndarray) -> float:
        """√Σf² over all points."""
        return math.sqrt(self.dot(modes, modes))

    def distance(self, first: np.ndarray, second: np.ndarray) -> float:
        """√Σ(f − g)² over all points."""
        planes = np.zeros(first.shape[0])
        _distance(first, second, self.weights, planes)
        return math.sqrt(float(planes.sum()) / self.count)


def _wave_numbers(cells: int, length: float, half: bool) -> np.ndarray:
    """k = 2πm/L in the order of the modes."""
    m = np.arange(cells // 2 + 1) if half else np.rint(np.fft.fftfreq(cells, 1.0 / cells))
    return np.where(2 * np.abs(m) == cells, 0.0, 2.0 * math.pi * m / length)


def _squares(wave: np.ndarray, cells: int) -> np.ndarray:
    """k², infinite for the highest wave number of an even axis."""
    squares = wave**2
    if cells % 2 == 0:
        squares[cells // 2] = math.inf
    return squares


@njit(parallel=True, cache=True)
def _differentiate(modes, wave, d, add, out):
    nx, ny, nz = modes.shape
    for i in prange(nx):
        for j in range(ny):
            f, row = modes[i, j], out[i, j]
            plain = 0.0 if d == 2 else wave[i] if d == 0 else wave[j]
            for m in range(nz):
                k = wave[m] if d == 2 else plain
                value = complex(-k * f[m].imag, k * f[m].real)
                row[m] = row[m] + value if add else value


@njit(parallel=True, cache=True, error_model="numpy")
def _over_square(modes, x, y, z, factor, out):
    for i in prange(modes.shape[0]):
        for j in range(modes.shape[1]):
            f, row = modes[i, j], out[i, j]
            across = x[i] + y[j]
            for m in range(modes.shape[2]):
                square = across + z[m]
                row[m] = factor / square * f[m] if square > 0.0 else 0.0


@njit(parallel=True, cache=True)
def _dot(first, second, weights, planes):
    for i in prange(first.shape[0]):
        sums = np.zeros(weights.size)
        for j in range(first.shape[1]):
            a, b = first[i, j], second[i, j]
            for m in range(weights.size):
                sums[m] += a[m].real * b[m].real + a[m].imag * b[m].imag
        planes[i] = (sums * weights).sum()


@njit(parallel=True, cache=True)
def _distance(first, second, weights, planes):
    for i in prange(first.shape[0]):
        sums = np.zeros(weights.size)
        for j in range(first.shape[1]):
            a, b = first[i, j], second[i, j]
            for m in range(weights.size):
                x, y = a[m].real - b[m].real, a[m].imag - b[m].imag
                sums[m] += x * x + y * y
        planes[i] = (sums * weights).sum()
