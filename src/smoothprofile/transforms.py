"""Eigenbases of the one-dimensional second difference, axis by axis.

    −D q_m = λ_m q_m,   (Df)_i = [(f_{i+1}−f_i)/d_{i+1} − (f_i−f_{i−1})/d_i]/w_i

On a uniform axis the basis is a fast transform: real Fourier (half-complex layout) when periodic,
and the cosine or sine transform that fits the two ends when walled. On a stretched axis it is
dense. All are real and work in place. This is the only file that calls an FFT library.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import ducc0
import numpy as np

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.dense_bases import Transform, dense_basis
from smoothprofile.grid import Axis, Grid
from smoothprofile.threads import thread_count


@dataclass(frozen=True, eq=False)
class Basis:
    """λ_m (m,), and transforms of a view along an axis, in place; backward∘forward = norm."""

    eigenvalues: np.ndarray
    forward: Transform
    backward: Transform
    norm: float


@dataclass(frozen=True, eq=False)
class SecondDifference:
    """Rows of −D: lower f_{i−1} + diagonal f_i + upper f_{i+1}; w·(−D) is symmetric."""

    lower: np.ndarray
    diagonal: np.ndarray
    upper: np.ndarray
    weights: np.ndarray
    periodic: bool

    def dense(self) -> np.ndarray:
        n = self.diagonal.size
        matrix = np.diag(self.diagonal)
        rows = np.arange(n)
        np.add.at(matrix, (rows, (rows - 1) % n), self.lower)
        np.add.at(matrix, (rows, (rows + 1) % n), self.upper)
        return matrix


def second_difference(axis: Axis, boundary: FieldBoundary, index: int) -> SecondDifference:
    """−D of a field along axis number `index`, its homogeneous end conditions eliminated."""
    n = axis.cells
    if index == boundary.staggered:
        first = boundary.first_unknown(index)
        widths = axis.padded_distances[first : n + 1]
        below = axis.padded_widths[first - 1 : n]
        above = axis.padded_widths[first : n + 1]
    else:
        widths = axis.padded_widths[1 : n + 1]
        below = axis.padded_distances[1 : n + 1]
        above = axis.padded_distances[2 : n + 2]
    lower, upper = -1.0 / (widths * below), -1.0 / (widths * above)
    diagonal = -(lower + upper)
    if not boundary.periodic(index):
        low, high = boundary.conditions[index]
        if index != boundary.staggered:
            diagonal[0] += lower[0] if low == "flux" else -lower[0]
            diagonal[-1] += upper[-1] if high == "flux" else -upper[-1]
        lower[0] = upper[-1] = 0.0
    return SecondDifference(lower, diagonal, upper, widths, boundary.periodic(index))


def basis_for(grid: Grid, boundary: FieldBoundary, index: int) -> Basis:
    """The fast basis of axis number `index` if it is uniform, the dense one if not."""
    axis = grid.axes[index]
    difference = second_difference(axis, boundary, index)
    if not axis.uniform or difference.diagonal.size < 2:
        return _dense(difference, grid.dtype)
    n = axis.cells
    scale = (2.0 / (axis.length / n)) ** 2
    if boundary.periodic(index):
        m = (np.arange(n) + 1) // 2
        return _fourier(scale * np.sin(np.pi * m / n) ** 2, n)
    if index == boundary.staggered:
        return _trigonometric("dst", 1, scale * np.sin(np.pi * np.arange(1, n) / (2 * n)) ** 2, n)
    kind, transform_type, shift = {
        ("flux", "flux"): ("dct", 2, 0.0),
        ("value", "value"): ("dst", 2, 1.0),
        ("flux", "value"): ("dct", 4, 0.5),
        ("value", "flux"): ("dst", 4, 0.5),
    }[boundary.conditions[index]]
    eigenvalues = scale * np.sin(np.pi * (np.arange(n) + shift) / (2 * n)) ** 2
    return _trigonometric(kind, transform_type, eigenvalues, n)


def fourier_round_trip(shape: tuple[int, int, int], dtype: type) -> Callable[[], None]:
    """A forward and an inverse real FFT of that shape, ready to be timed."""
    values = np.zeros(shape, dtype)
    modes = ducc0.fft.r2c(values)

    def round_trip() -> None:
        ducc0.fft.r2c(values, out=modes, nthreads=thread_count())
        ducc0.fft.c2r(modes, lastsize=shape[2], out=values, inorm=2, nthreads=thread_count())

    return round_trip


# ducc0 transforms as many lines at once as a vector register of this size has numbers, and what is
# left over singly, to other last bits.
VECTOR_BYTES = 64


def lines_at_once(dtype: type) -> int:
    """How many lines of that number type are transformed together."""
    return VECTOR_BYTES // np.dtype(dtype).itemsize


def _by_whole_lines(view: np.ndarray, axis: int, call: Callable[[np.ndarray, int], None]) -> None:
    """call(part, threads) on parts of a view such that no bit depends on the number of threads.

    Each thread gets a multiple of `lines_at_once` planes, so that the lines that are left over are
    the same for any number of threads: those of the last planes, on one thread.
    """
    across = 1 if axis == 0 else 0
    planes, first, threads = view.shape[across], 0, thread_count()
    together = lines_at_once(view.dtype)
    while first < planes:
        left = planes - first
        share = min(threads, left // together)
        size = left - left % (together * share) if share else left
        part = [slice(None)] * 3
        part[across] = slice(first, first + size)
        call(view[tuple(part)], max(share, 1))
        first += size


def _fourier(eigenvalues: np.ndarray, n: int) -> Basis:
    def transform(view: np.ndarray, axis: int, forward: bool) -> None:
        def call(part: np.ndarray, threads: int) -> None:
            ducc0.fft.r2r_fftpack(
                part,
                axes=(axis,),
                real2hermitian=forward,
                forward=forward,
                out=part,
                nthreads=threads,
            )

        _by_whole_lines(view, axis, call)

    return Basis(
        eigenvalues, partial(transform, forward=True), partial(transform, forward=False), float(n)
    )


def _trigonometric(kind: str, forward_type: int, eigenvalues: np.ndarray, n: int) -> Basis:
    function = getattr(ducc0.fft, kind)
    backward_type = {1: 1, 2: 3, 4: 4}[forward_type]

    def transform(view: np.ndarray, axis: int, number: int) -> None:
        def call(part: np.ndarray, threads: int) -> None:
            function(part, number, axes=(axis,), out=part, nthreads=threads)

        _by_whole_lines(view, axis, call)

    return Basis(
        eigenvalues,
        partial(transform, number=forward_type),
        partial(transform, number=backward_type),
        2.0 * n,
    )


def _dense(difference: SecondDifference, dtype: type) -> Basis:
    found = dense_basis(difference.dense(), difference.weights, difference.periodic, dtype)
    return Basis(*found, 1.0)


def mode_shape(shape: tuple[int, int, int]) -> tuple[int, int, int]:
    """The shape of the modes of real values: those of negative wave number along z are known."""
    return (*shape[:2], shape[2] // 2 + 1)


def to_modes(values: np.ndarray, modes: np.ndarray) -> None:
    """f̂(k) = Σ f(x) e^{−ik·x} of real values without ghosts, stored in complex `modes`."""
    ducc0.fft.r2c(values, out=modes, nthreads=thread_count())


def to_values(modes: np.ndarray, values: np.ndarray) -> None:
    """f(x) = Σ f̂(k) e^{ik·x}/N, the inverse of `to_modes`; what was in `modes` is lost."""
    backward = {"forward": False, "inorm": 2, "nthreads": thread_count()}
    ducc0.fft.c2c(modes, axes=(0, 1), out=modes, **backward)
    ducc0.fft.c2r(modes, axes=(2,), lastsize=values.shape[2], out=values, **backward)
