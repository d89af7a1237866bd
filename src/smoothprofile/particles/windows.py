"""Local windows: which points of the grid each body touches, and tables to loop over them.

A window is a box of velocity points around one body, for one velocity component. Its points are
stored in one flat array, window after window. A task is one x-plane of one window: the unit of
parallel work. Tasks that write to the same plane of the grid form a group, which one thread works
through in order, so that results do not depend on the number of threads.
"""

from dataclasses import dataclass

import numpy as np

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.grid import Grid


@dataclass(frozen=True, eq=False)
class Windows:
    """Boxes of padded indices, (bodies, component, axis); `task` rows: body, component, plane.

    first is wrapped into the box, image counts the periods between it and the true place.
    """

    first: np.ndarray
    count: np.ndarray
    image: np.ndarray
    start: np.ndarray
    points: int
    task: np.ndarray
    order: np.ndarray
    group: np.ndarray


def windows_around(
    grid: Grid, boundaries: tuple[FieldBoundary, ...], position: np.ndarray, half: np.ndarray
) -> Windows:
    """Windows of half sides half (n,3), possibly infinite, around bodies at position (n,3)."""
    n = position.shape[0]
    first = np.empty((n, 3, 3), dtype=np.int64)
    count, image = np.empty_like(first), np.zeros_like(first)
    for c in range(3):
        points = grid.face_coordinates(c)
        for d in range(3):
            first[:, c, d], count[:, c, d], image[:, c, d] = _ranges(
                grid, boundaries[c], d, points[d], position[:, d], half[:, d]
            )
    sizes = count.prod(axis=2)
    ends = np.cumsum(sizes.ravel()).reshape(n, 3)
    task = _tasks(count[:, :, 0])
    plane = (first[task[:, 0], task[:, 1], 0] + task[:, 2] - 1) % grid.shape[0]
    key = task[:, 1] * grid.shape[0] + plane
    order = np.argsort(key, kind="stable")
    breaks = np.flatnonzero(np.diff(key[order])) + 1
    group = np.concatenate([[0], breaks, [order.size]]) if order.size else np.zeros(1, np.int64)
    return Windows(
        first, count, image, ends - sizes, int(sizes.sum()), task, order, group.astype(np.int64)
    )


def _ranges(grid, boundary, d, points, centre, half):
    """First padded index, number of points and image of the windows along one axis."""
    axis, n = grid.axes[d], grid.shape[d]
    if not axis.periodic:
        known = boundary.first_unknown(d)
        inside = points[known : n + 1]
        low = np.searchsorted(inside, centre - half, side="left")
        high = np.searchsorted(inside, centre + half, side="right")
        return low + known, np.maximum(high - low, 0), 0
    # Padded indices count on through the periods: index m + qn lies q lengths further on.
    inside = points[1 : n + 1]

    def index(coordinate):
        periods = np.floor((coordinate - inside[0]) / axis.length)
        within = np.clip(coordinate - periods * axis.length, inside[0], None)
        return np.searchsorted(inside, within, side="right") + (n * periods).astype(np.int64)

    # What has no end along the axis is painted once; a body longer than a period meets its images.
    endless = np.isinf(half)
    reach = np.where(endless, 0.5 * axis.length, half)
    low, high = index(centre - reach) + 1, index(centre + reach) + 1
    count = np.where(endless, n, high - low)
    wrapped = (low - 1) % n + 1
    return wrapped, count, (low - wrapped) // n


def _tasks(planes: np.ndarray) -> np.ndarray:
    """(tasks, 3): every (body, component, plane of its window)."""
    flat = planes.ravel()
    owner = np.repeat(np.arange(flat.size), flat)
    within = np.arange(flat.sum()) - np.repeat(np.cumsum(flat) - flat, flat)
    return np.stack([owner // 3, owner % 3, within], axis=1).astype(np.int64)
