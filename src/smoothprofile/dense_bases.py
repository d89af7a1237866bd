"""Eigenbases of a one-dimensional second difference on unequal points: products with full matrices.

    f̂ = Qᵀ√w f,   f = Q f̂/√w,   (√w(−D)/√w) Q = Q Λ

Where the points are their own mirror image, even and odd modes are apart, and each half of Q is
applied to f_i ± f_j alone: half of the work. All sums are written out, four by four, so that no
thread count of a library changes a bit.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numba import njit, prange

Transform = Callable[[np.ndarray, int], None]

# Of the largest entry: how far −D may be from its mirror image and still be taken for symmetric.
MIRRORED = 1e-10


def dense_basis(
    matrix: np.ndarray, weights: np.ndarray, periodic: bool, dtype: type
) -> tuple[np.ndarray, Transform, Transform]:
    """Λ (n,), even modes first, and the transforms of a view along an axis, in place.

    matrix: −D (n,n), for which w·(−D) is symmetric; weights: w (n,).
    """
    root = np.sqrt(weights)
    symmetric = matrix * root[:, None] / root[None, :]
    symmetric = 0.5 * (symmetric + symmetric.T)
    mirror = _mirror(symmetric, periodic)
    parts = [_half(symmetric, root, mirror.folding(sign)) for sign in (1, -1)]
    eigenvalues = np.concatenate([values for values, _, _ in parts])
    # Round-off leaves the constant mode of a zero-flux or periodic axis near, not at, zero.
    eigenvalues[np.abs(eigenvalues) < 1e-12 * np.abs(eigenvalues).max()] = 0.0
    forward = _transform(_to_modes, _to_modes_last, mirror, [part[1] for part in parts], dtype)
    backward = _transform(_to_values, _to_values_last, mirror, [part[2] for part in parts], dtype)
    return eigenvalues, forward, backward


def _transform(across: Callable, last: Callable, mirror: "Mirror", halves, dtype) -> Transform:
    """The transform of (i, j, k) along any axis: rows of k are combined, or along k made anew."""
    rows = [np.ascontiguousarray(half.astype(dtype)) for half in halves]
    columns = [np.ascontiguousarray(half.T.astype(dtype)) for half in halves]

    def transform(view: np.ndarray, axis: int) -> None:
        if axis == 2:
            last(view, mirror.low, mirror.high, mirror.alone, *columns)
        else:
            across(np.moveaxis(view, axis, 1), mirror.low, mirror.high, mirror.alone, *rows)

    return transform


class Mirror(NamedTuple):
    """Points low + l and high − l are each other's image, l < count; those of `alone` their own."""

    low: int
    high: int
    count: int
    alone: np.ndarray

    @property
    def image(self) -> np.ndarray:
        """The image of each point."""
        image = np.empty(2 * self.count + self.alone.size, dtype=np.int64)
        image[self.alone] = self.alone
        pairs = np.arange(self.count)
        image[self.low + pairs], image[self.high - pairs] = self.high - pairs, self.low + pairs
        return image

    def folding(self, sign: int) -> np.ndarray:
        """(n,m) of orthonormal columns: (f_i ± f_j)/√2 of each pair; if even, points alone too."""
        pairs, size = np.arange(self.count), 2 * self.count + self.alone.size
        folding = np.zeros((size, self.count + (self.alone.size if sign > 0 else 0)))
        folding[self.low + pairs, pairs] = np.sqrt(0.5)
        folding[self.high - pairs, pairs] = sign * np.sqrt(0.5)
        if sign > 0:
            folding[self.alone, self.count + np.arange(self.alone.size)] = 1.0
        return folding


def _mirror(matrix: np.ndarray, periodic: bool) -> Mirror:
    """In the middle of the points, or on point 0 of a periodic axis; all alone if there is none."""
    n = matrix.shape[0]
    middle = [n // 2] if n % 2 else []
    mirrors = [Mirror(0, n - 1, n // 2, np.array(middle, dtype=np.int64))]
    if periodic:
        alone = np.array([0, *([] if n % 2 else [n // 2])], dtype=np.int64)
        mirrors.append(Mirror(1, n - 1, (n - 1) // 2, alone))
    for mirror in mirrors:
        mirrored = matrix[np.ix_(mirror.image, mirror.image)]
        if np.abs(mirrored - matrix).max() <= MIRRORED * np.abs(matrix).max():
            return mirror
    return Mirror(0, 0, 0, np.arange(n))


def _half(symmetric: np.ndarray, root: np.ndarray, folding: np.ndarray) -> tuple:
    """Eigenvalues in the folded space, and the matrices from f_i ± f_j to modes, and to f back."""
    if not folding.size:
        return np.empty(0), np.empty((0, 0)), np.empty((0, 0))
    eigenvalues, vectors = scipy.linalg.eigh(folding.T @ symmetric @ folding)
    share, first = folding.max(axis=0), root[folding.argmax(axis=0)]
    return eigenvalues, vectors.T * (share * first), vectors * (share / first)[:, None]


@njit(parallel=True, cache=True)
def _to_modes(f, low, high, alone, even, odd):
    """f[i, :, k] ← even·(f_a + f_b), odd·(f_a − f_b) of f[i, :, k]."""
    columns, whole, half = f.shape[2], even.shape[0], odd.shape[0]
    for i in prange(f.shape[0]):
        sums, out = np.empty((whole, columns), f.dtype), np.empty((whole, columns), f.dtype)
        differences = np.empty((half, columns), f.dtype)
        for l in range(half):
            a, b = f[i, low + l], f[i, high - l]
            for k in range(columns):
                sums[l, k] = a[k] + b[k]
                differences[l, k] = a[k] - b[k]
        for l in range(half, whole):
            sums[l] = f[i, alone[l - half]]
        _product(even, sums, out)
        f[i, :whole] = out
        _product(odd, differences, out)
        f[i, whole:] = out[:half]


@njit(parallel=True, cache=True)
def _to_values(f, low, high, alone, even, odd):
    """f_a, f_b ← even·f̂₊ ± odd·f̂₋ with f̂₊ the first modes f[i, :, k], f̂₋ the others."""
    planes, n, columns = f.shape
    whole, half = even.shape[0], odd.shape[0]
    for i in prange(planes):
        modes = np.empty((n, columns), f.dtype)
        sums, differences = np.empty((whole, columns), f.dtype), np.empty((half, columns), f.dtype)
        modes[:, :] = f[i]
        _product(even, modes[:whole], sums)
        _product(odd, modes[whole:], differences)
        for l in range(half):
            a, b = f[i, low + l], f[i, high - l]
            for k in range(columns):
                a[k] = sums[l, k] + differences[l, k]
                b[k] = sums[l, k] - differences[l, k]
        for l in range(half, whole):
            f[i, alone[l - half]] = sums[l]


@njit(parallel=True, cache=True)
def _to_modes_last(f, low, high, alone, even, odd):
    """As `_to_modes` along k of f[i, j, k]; even and odd are transposed."""
    rows, whole, half = f.shape[1], even.shape[0], odd.shape[0]
    for i in prange(f.shape[0]):
        sums, out = np.empty((rows, whole), f.dtype), np.empty((rows, whole), f.dtype)
        differences, rest = np.empty((rows, half), f.dtype), np.empty((rows, half), f.dtype)
        for j in range(rows):
            row, sum_, difference = f[i, j], sums[j], differences[j]
            for l in range(half):
                a, b = row[low + l], row[high - l]
                sum_[l], difference[l] = a + b, a - b
            for l in range(half, whole):
                sum_[l] = row[alone[l - half]]
        _product(sums, even, out)
        _product(differences, odd, rest)
        f[i, :, :whole] = out
        f[i, :, whole:] = rest


@njit(parallel=True, cache=True)
def _to_values_last(f, low, high, alone, even, odd):
    """As `_to_values` along k of f[i, j, k]; even and odd are transposed."""
    planes, rows, _ = f.shape
    whole, half = even.shape[0], odd.shape[0]
    for i in prange(planes):
        plus, minus = np.empty((rows, whole), f.dtype), np.empty((rows, half), f.dtype)
        sums, differences = np.empty((rows, whole), f.dtype), np.empty((rows, half), f.dtype)
        plus[:, :], minus[:, :] = f[i, :, :whole], f[i, :, whole:]
        _product(plus, even, sums)
        _product(minus, odd, differences)
        for j in range(rows):
            row, sum_, difference = f[i, j], sums[j], differences[j]
            for l in range(half):
                row[low + l] = sum_[l] + difference[l]
            for l in range(half):
                row[high - l] = sum_[l] - difference[l]
            for l in range(half, whole):
                row[alone[l - half]] = sum_[l]


@njit
def _product(left, right, out):
    """out ← left·right for the rows of left: four rows by four products, twice as fast as one."""
    rows, n = left.shape
    whole, fours = rows - rows % 4, n - n % 4
    out[:rows] = 0
    for m in range(0, whole, 4):
        for l in range(0, fours, 4):
            _add_four_by_four(left[m : m + 4, l : l + 4], right[l : l + 4], out[m : m + 4])
    for m in range(rows):
        row = out[m]
        for l in range(fours if m < whole else 0, n):
            a, b = left[m, l], right[l]
            for k in range(b.size):
                row[k] += a * b[k]


@njit(inline="always")
def _add_four_by_four(w, rows, out):
    """out += w·rows, four rows of each."""
    a0, b0, c0, d0 = w[0, 0], w[0, 1], w[0, 2], w[0, 3]
    a1, b1, c1, d1 = w[1, 0], w[1, 1], w[1, 2], w[1, 3]
    a2, b2, c2, d2 = w[2, 0], w[2, 1], w[2, 2], w[2, 3]
    a3, b3, c3, d3 = w[3, 0], w[3, 1], w[3, 2], w[3, 3]
    x, y, z, t = rows[0], rows[1], rows[2], rows[3]
    p, q, r, s = out[0], out[1], out[2], out[3]
    for k in range(x.size):
        xk, yk, zk, tk = x[k], y[k], z[k], t[k]
        p[k] += (a0 * xk + b0 * yk) + (c0 * zk + d0 * tk)
        q[k] += (a1 * xk + b1 * yk) + (c1 * zk + d1 * tk)
        r[k] += (a2 * xk + b2 * yk) + (c2 * zk + d2 * tk)
        s[k] += (a3 * xk + b3 * yk) + (c3 * zk + d3 * tk)
