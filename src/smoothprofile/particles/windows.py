"""Local windows: which points of the grid each body touches, and tables to loop over them.

A window is a box of velocity points around one body, for one velocity component. A task is one
x-plane of one window, a run some painted points of it side by side along z; rows that cross the
end of a periodic axis are two runs. The points of all runs stand in one flat array, run after run.
Tasks of one plane of the grid form a group, which one thread works through in order, so that
results do not depend on the number of threads.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary
from smoothprofile.grid import Grid


class Windows(NamedTuple):
    """Boxes of padded indices, (bodies, component, axis), and the runs of points in them.

    first is wrapped into the box, image counts the periods between it and the true place. arm,
    width and lever hold the coordinates r along one axis, counted from the body's position, the
    sizes h of the cells around the points, and hr, from `axis` (bodies, component, axis) on. task
    (t,3) is body, component and plane of the window; group the tasks of one plane, part (4,) the
    groups of one component. Task t has the runs from run[t] on, and its points stand from start[t]
    on. A run is its place in the flat padded plane, its length, and where arm, width and lever
    hold its y and its first z. cells: of the grid. points, most: of all tasks and of the largest.
    """

    first: np.ndarray
    count: np.ndarray
    image: np.ndarray
    axis: np.ndarray
    arm: np.ndarray
    width: np.ndarray
    lever: np.ndarray
    task: np.ndarray
    group: np.ndarray
    part: np.ndarray
    run: np.ndarray
    start: np.ndarray
    place: np.ndarray
    length: np.ndarray
    y: np.ndarray
    z: np.ndarray
    cells: np.ndarray
    points: int
    most: int


class Memory:
    """Room for large arrays that are made anew at each step: fresh pages cost as much as the work.

    What was taken under a name is lost when the name is taken again.
    """

    def __init__(self):
        self._held: dict[str, np.ndarray] = {}

    def take(self, name: str, shape: tuple[int, ...], dtype: type) -> np.ndarray:
        """An array of that shape, with anything in it."""
        size = math.prod(shape)
        if name not in self._held or self._held[name].size < size:
            self._held[name] = np.empty(size + size // 8, dtype)
        return self._held[name][:size].reshape(shape)


def windows_around(
    grid: Grid,
    boundaries: tuple[FieldBoundary, ...],
    position: np.ndarray,
    half: np.ndarray,
    ball: np.ndarray,
    memory: Memory | None = None,
) -> Windows:
    """Windows of half sides half (n,3), possibly infinite, around bodies at position (n,3).

    Of a ball, only what lies less than its radius from its centre is painted: (n,4), the centre
    counted from the position, and the radius, infinite for what is none. Windows live in `memory`,
    if given, until the next ones do.
    """
    memory = memory or Memory()
    n = position.shape[0]
    first = np.empty((n, 3, 3), dtype=np.int64)
    count, image = np.empty_like(first), np.zeros_like(first)
    for c in range(3):
        points = grid.face_coordinates(c)
        for d in range(3):
            first[:, c, d], count[:, c, d], image[:, c, d] = _ranges(
                grid, boundaries[c], d, points[d], position[:, d], half[:, d]
            )
    ends = _ends(count.ravel())
    axis = ends[:-1].reshape(n, 3, 3)
    arm, width = np.empty(ends[-1]), np.empty(ends[-1])
    points = tuple(np.stack([a.padded_centres, a.padded_faces]) for a in grid.axes)
    sizes = tuple(np.stack([a.padded_widths, a.padded_distances]) for a in grid.axes)
    _measure(arm, width, first, count, image, axis, position, points, sizes, grid.lengths)
    task, group, part = _tasks(first, count, grid.shape[0])
    rows = _ends(count[task[:, 0], task[:, 1], 1])
    spans = memory.take("spans", (int(rows[-1]), 2), np.int32)
    sizes = np.empty((2, task.shape[0]), np.int64)
    cells = np.array(grid.shape, dtype=np.int64)
    along_z = grid.axes[2]
    step = along_z.length / along_z.cells if along_z.uniform else 0.0
    _spans(spans, sizes, task, rows, axis, first, count, arm, ball, cells, step)
    run, start = (_ends(size).astype(np.uint64) for size in sizes)
    place, length, y, z = memory.take("runs", (4, int(run[-1])), np.uint32)
    _runs(place, length, y, z, run, spans, task, rows, axis, first, cells)
    return Windows(
        first=first,
        count=count,
        image=image,
        axis=axis,
        arm=arm,
        width=width,
        lever=width * arm,
        task=task,
        group=group,
        part=part,
        run=run,
        start=start,
        place=place,
        length=length,
        y=y,
        z=z,
        cells=cells,
        points=int(start[-1]),
        most=int(sizes[1].max(initial=0)),
    )


def _ends(sizes: np.ndarray) -> np.ndarray:
    """0 and the running sums."""
    ends = np.zeros(sizes.size + 1, np.int64)
    np.cumsum(sizes, out=ends[1:])
    return ends


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


@njit(inline="always")
def coordinate(points, on_face, index, image, length):
    """Coordinate of padded index `index`, which may run on through the periods of the axis."""
    n = points.shape[1] - 2
    while index > n:
        index -= n
        image += 1
    return points[1 if on_face else 0, index] + image * length


@njit(inline="always")
def wrap(index, n):
    """The padded index within the box."""
    while index > n:
        index -= n
    return index


@njit(inline="always")
def plane_of(w, t):
    """The padded index of the plane that a task lies on."""
    return wrap(w.first[w.task[t, 0], w.task[t, 1], 0] + w.task[t, 2], w.cells[0])


@njit(cache=True)
def _measure(arm, width, first, count, image, axis, position, points, sizes, lengths):
    for b in range(first.shape[0]):
        for c in range(3):
            for d in range(3):
                on_face, n = c == d, points[d].shape[1] - 2
                at, begin, periods = axis[b, c, d], first[b, c, d], image[b, c, d]
                for m in range(count[b, c, d]):
                    x = coordinate(points[d], on_face, begin + m, periods, lengths[d])
                    arm[at + m] = x - position[b, d]
                    width[at + m] = sizes[d][int(on_face), wrap(begin + m, n)]


@njit(cache=True)
def _tasks(first, count, planes):
    """Every (body, component, plane of its window), plane of the grid after plane."""
    filled = np.zeros(3 * planes + 1, np.int64)
    for b in range(first.shape[0]):
        for c in range(3):
            for i in range(count[b, c, 0]):
                filled[c * planes + (first[b, c, 0] + i - 1) % planes + 1] += 1
    ends = np.cumsum(filled)
    group, part = np.zeros(3 * planes + 1, np.int64), np.zeros(4, np.int64)
    groups = 0
    for g in range(3 * planes):
        if ends[g + 1] > ends[g]:
            groups += 1
            group[groups] = ends[g + 1]
        part[g // planes + 1] = groups
    task = np.empty((ends[-1], 3), np.int64)
    for b in range(first.shape[0]):
        for c in range(3):
            for i in range(count[b, c, 0]):
                g = c * planes + (first[b, c, 0] + i - 1) % planes
                t = ends[g]
                task[t, 0], task[t, 1], task[t, 2] = b, c, i
                ends[g] += 1
    return task, group[: groups + 1].copy(), part


@njit(parallel=True, cache=True, error_model="numpy")
def _spans(spans, sizes, task, rows, axis, first, count, arm, ball, cells, step):
    """Begin and end of what is painted in each row; the runs and the points of each task.

    step: between the points along z, 0 where that varies.
    """
    for t in prange(task.shape[0]):
        b, c, i = task[t]
        nz = count[b, c, 2]
        z = arm[axis[b, c, 2] : axis[b, c, 2] + nz]
        square = ball[b, 3] ** 2 - (arm[axis[b, c, 0] + i] - ball[b, 0]) ** 2
        runs, points = 0, 0
        for j in range(count[b, c, 1]):
            begin, end = 0, nz
            if ball[b, 3] < np.inf:
                left = square - (arm[axis[b, c, 1] + j] - ball[b, 1]) ** 2
                begin, end = _chord(z, ball[b, 2], left, step)
            spans[rows[t] + j, 0], spans[rows[t] + j, 1] = begin, end
            if end > begin:
                points += end - begin
                beyond = wrap(first[b, c, 2] + begin, cells[2]) + end - begin - 2
                runs += 1 if beyond < cells[2] else beyond // cells[2] + 1
        sizes[0, t], sizes[1, t] = runs, points


@njit(error_model="numpy")
def _chord(z, centre, square, step):
    """Begin and end of the points whose squared distance from the centre is less than `square`."""
    if square <= 0.0 or z.size == 0:
        return 0, 0
    half = math.sqrt(square)
    if step == 0.0:
        return np.searchsorted(z, centre - half), np.searchsorted(z, centre + half)
    begin = max(0, math.ceil((centre - half - z[0]) * (1.0 / step)))
    return begin, max(begin, min(z.size, math.ceil((centre + half - z[0]) * (1.0 / step))))


@njit(parallel=True, cache=True)
def _runs(place, length, y, z, run, spans, task, rows, axis, first, cells):
    for t in prange(task.shape[0]):
        b, c, _ = task[t]
        r = run[t]
        for j in range(rows[t + 1] - rows[t]):
            begin, end = spans[rows[t] + j]
            line = wrap(first[b, c, 1] + j, cells[1]) * (cells[2] + 2)
            while begin < end:
                at = wrap(first[b, c, 2] + begin, cells[2])
                n = min(end - begin, cells[2] + 1 - at)
                place[r], length[r] = line + at, n
                y[r], z[r] = axis[b, c, 1] + j, axis[b, c, 2] + begin
                begin += n
                r += np.uint64(1)
