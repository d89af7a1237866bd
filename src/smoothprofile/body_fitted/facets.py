"""A curved triangle as points in rows, to be drawn without any finite elements.

With n steps to an edge the points are (i/n, j/n), j = 0 … n, i = 0 … n − j, row after row.
"""

from itertools import pairwise

import numpy as np


def places(steps: int) -> np.ndarray:
    """((n+1)(n+2)/2, 2): the points in the triangle (0, 0), (1, 0), (0, 1)."""
    return np.array([(i, j) for j in range(steps + 1) for i in range(steps + 1 - j)]) / steps


def small_triangles(steps: int) -> np.ndarray:
    """(n², 3): which points are the corners of each small triangle."""
    rows = _rows(steps)
    found = []
    for low, high in pairwise(rows):
        found += [(low[i], low[i + 1], high[i]) for i in range(len(high))]
        found += [(low[i + 1], high[i + 1], high[i]) for i in range(len(high) - 1)]
    return np.array(found)


def outline(steps: int) -> np.ndarray:
    """(3n + 1,): the points along the edges, once round and back to the first."""
    rows = _rows(steps)
    bottom, right = list(rows[0]), [row[-1] for row in rows[1:]]
    return np.array([*bottom, *right, *(row[0] for row in rows[-2::-1])])


def _rows(steps: int) -> list[np.ndarray]:
    lengths = np.arange(steps + 1, 0, -1)
    return np.split(np.arange(lengths.sum()), np.cumsum(lengths)[:-1])
