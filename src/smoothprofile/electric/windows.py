"""Boxes of cells around bodies, and which bodies share points.

A box holds every cell whose faces or corners the body's paint reaches. A task is one plane of one
box; tasks on the same plane of the grid form a group, worked through in the order of the bodies.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from smoothprofile.grid import Axis, Grid


@dataclass(frozen=True, eq=False)
class Boxes:
    """first (n,3) padded and wrapped into the domain, count (n,3), image (n,3) periods away.

    `task` rows are (body, plane of its box). Body b shares points with meets[0][b] to
    meets[0][b+1] of the rows of meets[1] (body) and meets[2] (shift, a length), itself included, in
    the order of painting. reaches (n,3) is −1, or for a body whose box would fill a periodic axis,
    which is then cut to one period, how many images on each side its distance is the least of.
    """

    first: np.ndarray
    count: np.ndarray
    image: np.ndarray
    task: np.ndarray
    order: np.ndarray
    group: np.ndarray
    meets: tuple[np.ndarray, np.ndarray, np.ndarray]
    reaches: np.ndarray


MOST_IMAGES = 3
"""Images on each side that count for a body longer than its box."""


def boxes_around(grid: Grid, position: np.ndarray, half: np.ndarray) -> Boxes:
    """Boxes of half sides half (n,3), possibly infinite, around bodies at position (n,3)."""
    n = position.shape[0]
    first = np.zeros((n, 3), dtype=np.int64)
    count, image = np.zeros_like(first), np.zeros_like(first)
    reaches = np.full((n, 3), -1)
    for d, axis in enumerate(grid.axes):
        wide = half[:, d]
        if axis.periodic:
            # One cell more than the layer needs may be in a box, on each side.
            cut = np.isfinite(wide) & (2.0 * wide + 2.0 * axis.widths.max() >= axis.length)
            images = np.floor(np.where(cut, wide, 0.0) / axis.length + 0.5)
            reaches[cut, d] = np.minimum(images[cut], MOST_IMAGES)
            wide = np.where(cut, np.inf, wide)
        first[:, d], count[:, d], image[:, d] = _ranges(axis, position[:, d], wide)
    count[np.any(count <= 0, axis=1)] = 0
    owner = np.repeat(np.arange(n), count[:, 0])
    within = np.arange(owner.size) - np.repeat(np.cumsum(count[:, 0]) - count[:, 0], count[:, 0])
    task = np.stack([owner, within], axis=1).astype(np.int64)
    plane = first[owner, 0] + within
    if grid.axes[0].periodic:
        plane = (plane - 1) % grid.shape[0] + 1
    order = np.argsort(plane, kind="stable")
    breaks = np.flatnonzero(np.diff(plane[order])) + 1
    group = np.concatenate([[0], breaks, [order.size]]) if order.size else np.zeros(1, np.int64)
    meets = _meetings(grid, first, count, image, np.isinf(half) | (reaches >= 0))
    return Boxes(first, count, image, task, order, group.astype(np.int64), meets, reaches)


def _ranges(axis: Axis, centre: np.ndarray, half: np.ndarray):
    """First padded cell, number of cells, and image of the boxes along one axis."""
    n = axis.cells
    if not axis.periodic:
        # Cell n + 1 stands for the wall's own faces and corners.
        low = np.searchsorted(axis.faces, centre - half, side="right")
        high = np.searchsorted(axis.faces, centre + half, side="right")
        low = np.maximum(low, 1)
        return low, np.minimum(high, n + 1) - low + 1, 0
    endless = np.isinf(half)
    reach = np.where(endless, 0.5 * axis.length, half)

    def index(coordinate):
        periods = np.floor((coordinate - axis.low) / axis.length)
        within = coordinate - periods * axis.length
        cell = np.clip(np.searchsorted(axis.faces, within, side="right"), 1, n)
        return cell + (n * periods).astype(np.int64)

    low, high = index(centre - reach), index(centre + reach)
    wrapped = (low - 1) % n + 1
    return wrapped, np.where(endless, n, high - low + 1), (low - wrapped) // n


def _meetings(grid: Grid, first, count, image, endless):
    """Of every body, those whose boxes, moved by whole periods, meet its own box."""
    n, periodic = first.shape[0], np.array(grid.periodic)
    cells = np.where(periodic, grid.shape, 0)
    known = (first, first + count, image, count[:, 0] > 0, endless & periodic, cells)
    starts, lengths = np.zeros(n + 1, dtype=np.int64), np.array(grid.lengths)
    none = np.zeros(0, dtype=np.int64), np.zeros((0, 3))
    _meet(*known, lengths, starts, *none, False)
    np.cumsum(starts, out=starts)
    bodies, shifts = np.zeros(starts[-1], dtype=np.int64), np.zeros((starts[-1], 3))
    _meet(*known, lengths, starts, bodies, shifts, True)
    return starts, bodies, shifts


@njit(cache=True)
def _meet(low, high, image, there, endless, cells, lengths, starts, bodies, shifts, store):
    """How many meet body b, to starts[b + 1]; or, with `store`, who they are, from starts[b] on."""
    least, most = np.zeros(3, dtype=np.int64), np.zeros(3, dtype=np.int64)
    for b in range(low.shape[0]):
        found = 0
        for o in range(low.shape[0]):
            near = there[o]
            for d in range(3):
                if not near:
                    break
                if endless[o, d]:
                    # One that fills the axis is painted once: its distance knows its images.
                    least[d], most[d] = 0, 0
                    continue
                least[d], most[d] = _periods(low[b, d], high[b, d], low[o, d], high[o, d], cells[d])
                near = least[d] <= most[d]
                least[d] += image[b, d] - image[o, d]
                most[d] += image[b, d] - image[o, d]
            if not near:
                continue
            for i in range(least[0], most[0] + 1):
                for j in range(least[1], most[1] + 1):
                    for k in range(least[2], most[2] + 1):
                        if store:
                            m = starts[b] + found
                            bodies[m] = o
                            shifts[m, 0] = i * lengths[0]
                            shifts[m, 1] = j * lengths[1]
                            shifts[m, 2] = k * lengths[2]
                        found += 1
        if not store:
            starts[b + 1] = found


@njit(inline="always")
def _periods(low, high, other_low, other_high, cells):
    """By how many periods, from and to, the other must be moved to overlap; cells 0: no period.

    Both begin within the domain and are no longer than it.
    """
    least, most = 2, -2
    for s in range(-1, 2):
        if (cells or s == 0) and other_low + s * cells < high and other_high + s * cells > low:
            least, most = min(least, s), max(most, s)
    return least, most
