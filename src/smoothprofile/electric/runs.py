"""Runs of cells or corners along z: where a loop has something to do.

Row (i,j) has the runs low[m] … high[m] of padded indices, m from start[i,j] to start[i,j+1] − 1.
"""

import numpy as np
from numba import njit, prange

Runs = tuple[np.ndarray, np.ndarray, np.ndarray]
"""start (nx+2,ny+3), low and high (m,)."""


def no_runs(padded: tuple[int, int, int]) -> Runs:
    none = np.zeros(0, dtype=np.int64)
    return np.zeros((padded[0], padded[1] + 1), dtype=np.int64), none, none


def runs_of(marks: np.ndarray, gap: int = 1) -> Runs:
    """Runs of the marked points of a padded field of bytes; index 0 is never looked at.

    Two runs with fewer than `gap` points between them are joined.
    """
    nx, ny, _ = marks.shape
    counts, none = np.zeros((nx, ny + 1), dtype=np.int64), np.zeros(0, dtype=np.int64)
    _scan(marks, gap, counts, none, none, False)
    start = np.zeros((nx, ny + 1), dtype=np.int64)
    start[:, 1:] = np.cumsum(counts[:, :ny]).reshape(nx, ny)
    start[1:, 0] = start[:-1, -1]
    low, high = (np.zeros(int(start[-1, -1]), dtype=np.int64) for _ in range(2))
    _scan(marks, gap, start, low, high, True)
    return start, low, high


def corners_with_layer(layers: tuple[np.ndarray, np.ndarray, np.ndarray]) -> np.ndarray:
    """Marks of the corners where q is not zero."""
    marks = np.zeros(layers[0].shape, dtype=np.uint8)
    _mark_corners(*layers, marks)
    return marks


def around(marks: np.ndarray, periodic: tuple[bool, bool, bool]) -> np.ndarray:
    """Marks of the cells that share a corner with a marked cell, themselves included."""
    result = np.zeros_like(marks)
    _spread(_continued(marks, periodic), result)
    return result


def _continued(marks: np.ndarray, periodic: tuple[bool, bool, bool]) -> np.ndarray:
    """A copy whose ghosts repeat the cells of periodic axes and are not marked elsewhere."""
    core = marks[1:-1, 1:-1, 1:-1]
    for d in range(3):
        width = [(1, 1) if d == axis else (0, 0) for axis in range(3)]
        core = np.pad(core, width, mode="wrap" if periodic[d] else "constant")
    return core


@njit(parallel=True, cache=True)
def _mark_corners(qx, qy, qz, marks):
    for i in prange(1, marks.shape[0]):
        for j in range(1, marks.shape[1]):
            for k in range(1, marks.shape[2]):
                if qx[i, j, k] != 0.0 or qy[i, j, k] != 0.0 or qz[i, j, k] != 0.0:
                    marks[i, j, k] = 1


@njit(parallel=True, cache=True)
def _spread(marks, result):
    nx, ny, nz = marks.shape
    for i in prange(1, nx - 1):
        for j in range(1, ny - 1):
            row = result[i, j]
            for a in range(i - 1, i + 2):
                for b in range(j - 1, j + 2):
                    part = marks[a, b]
                    for k in range(1, nz - 1):
                        row[k] |= part[k - 1] | part[k] | part[k + 1]


@njit(parallel=True, cache=True)
def _scan(marks, gap, start, low, high, store):
    for i in prange(1, marks.shape[0]):
        for j in range(1, marks.shape[1]):
            found, end = 0, -gap - 1
            for k in range(1, marks.shape[2]):
                if marks[i, j, k] == 0:
                    continue
                if k - end > gap:
                    found += 1
                    if store:
                        low[start[i, j] + found - 1] = k
                end = k
                if store:
                    high[start[i, j] + found - 1] = k
            if not store:
                start[i, j] = found
