"""Boxes of cells around bodies, and which bodies share points.

A box holds every cell whose faces or corners the body's paint reaches. A task is one plane of one
box; tasks on the same plane of the grid form a group, worked through in the order of the bodies.
"""

from dataclasses import dataclass

import numpy as np

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
    cells = np.array(grid.shape)
    low = first + image * np.where(grid.periodic, cells, 0)
    high = low + count
    bodies, shifts, starts = [], [], [0]
    for b in range(first.shape[0]):
        found = []
        spans = []
        for d in range(3):
            if grid.periodic[d]:
                # Periods by which others may have to be moved to overlap this box.
                most = np.floor((high[b, d] - 1 - low[:, d]) / cells[d]).astype(int)
                least = np.ceil((low[b, d] + 1 - high[:, d]) / cells[d]).astype(int)
            else:
                apart = (low[:, d] >= high[b, d]) | (high[:, d] <= low[b, d])
                least, most = np.where(apart, 1, 0), np.zeros(len(low), dtype=int)
            # One that fills the axis is painted once: its distance knows its images.
            if grid.periodic[d]:
                least, most = np.where(endless[:, d], 0, least), np.where(endless[:, d], 0, most)
            spans.append((least, most))
        near = np.all([least <= most for least, most in spans], axis=0)
        for other in np.flatnonzero(near & (count[:, 0] > 0)):
            ranges = [range(s[0][other], s[1][other] + 1) for s in spans]
            found += [(other, (i, j, k)) for i in ranges[0] for j in ranges[1] for k in ranges[2]]
        bodies += [other for other, _ in found]
        shifts += [np.array(periods) * np.array(grid.lengths) for _, periods in found]
        starts.append(len(bodies))
    return (
        np.array(starts, dtype=np.int64),
        np.array(bodies, dtype=np.int64),
        np.array(shifts, dtype=np.float64).reshape(-1, 3),
    )
