"""Boxes of cells around bodies: who meets whom, against a search that tries every period."""

import itertools

import numpy as np
import pytest

from smoothprofile.electric.windows import boxes_around
from smoothprofile.grid import Grid, uniform_axis


def searched(grid, boxes, endless):
    """Rows (body, other, shift) in order, by trying up to four periods each way."""
    cells = np.where(grid.periodic, grid.shape, 0)
    low = boxes.first + boxes.image * cells
    high = low + boxes.count
    rows = []
    for b, o in itertools.product(range(len(low)), repeat=2):
        if not boxes.count[o, 0]:
            continue
        spans = []
        for d in range(3):
            if grid.periodic[d] and endless[o, d]:
                spans.append([0])
                continue
            tried = range(-4, 5) if grid.periodic[d] else [0]
            shift = np.array(tried) * cells[d]
            meets = (low[o, d] + shift < high[b, d]) & (high[o, d] + shift > low[b, d])
            spans.append([p for p, met in zip(tried, meets, strict=True) if met])
        rows += [(b, o, *p) for p in itertools.product(*spans)]
    return np.array(rows).reshape(-1, 5)


@pytest.mark.parametrize("periodic", [(True,) * 3, (True, True, False), (False,) * 3])
def test_bodies_that_share_points(periodic):
    random = np.random.default_rng(4)
    sides = (6.0, 7.0, 5.0)
    grid = Grid(
        tuple(
            uniform_axis(name, -1.0, side, 20 + int(side), wraps)
            for name, side, wraps in zip("xyz", sides, periodic, strict=True)
        )
    )
    # Some are beyond the box by whole periods, some long, some without an end.
    position = random.uniform(-8.0, 12.0, (24, 3))
    position = np.where(periodic, position, random.uniform(-1.0, 5.0, (24, 3)))
    half = random.uniform(0.2, 1.6, (24, 3))
    half[3], half[7, 1], half[11, 0] = 4.0, np.inf, np.inf
    boxes = boxes_around(grid, position, half)
    endless = np.isinf(half) | (boxes.reaches >= 0)
    rows = searched(grid, boxes, endless)
    start, others, shift = boxes.meets
    owner = np.repeat(np.arange(24), np.diff(start))
    assert np.array_equal(np.stack([owner, others], axis=1), rows[:, :2])
    assert np.array_equal(shift, rows[:, 2:] * np.array(sides))
    # Each meets itself.
    here = (owner == others) & ~shift.any(axis=1)
    assert np.array_equal(owner[here], np.flatnonzero(boxes.count[:, 0]))


def test_no_bodies_meet_nobody():
    grid = Grid(tuple(uniform_axis(name, 0.0, 1.0, 8, True) for name in "xyz"))
    start, others, shift = boxes_around(grid, np.zeros((0, 3)), np.zeros((0, 3))).meets
    assert (start.size, others.size, shift.shape) == (1, 0, (0, 3))
