"""Bodies of high permittivity as wholes: their constant potentials, corrected all at once.

    z = Σ_b w_b (w_b·r)/E_b,   w_b = φ((d_b − δ)/ξ),   E_b = w_b·A Σ_c w_c

Inside a conductor the potential is constant, and what sets the constant is the weak field between
bodies. A preconditioner that knows surfaces only one at a time finds each constant slowly, one
after the other; this is the exact answer where no layers meet. E_b is their capacity, less what
goes to bodies whose layers overlap. w falls where the normal ε has fallen to the fluid's, δ = OUT·ξ
outside of the painted surface, or where a profile that ends does so.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import FieldBoundary, fill_ghosts
from smoothprofile.electric.layers import distance, level
from smoothprofile.electric.operator import Geometry, apply
from smoothprofile.electric.permittivity import Permittivity, place
from smoothprofile.particles.paint import wrap

OUT = 1.5
LEAST = 1e-3
"""w below which a cell is left out."""


@dataclass(frozen=True, eq=False)
class Conductors:
    """Cells (m,) as flat padded indices and w (m,) of each task, a plane of a body's box.

    Task t has those from start[t] to start[t+1] − 1; tasks order[group[g]] to order[group[g+1] − 1]
    lie on one plane of the grid. share (tasks,) is 1/E of each task's body.
    """

    start: np.ndarray
    cells: np.ndarray
    values: np.ndarray
    order: np.ndarray
    group: np.ndarray
    body: np.ndarray
    share: np.ndarray

    @classmethod
    def of(
        cls, medium: Permittivity, boundary: FieldBoundary, geometry: Geometry, ratio: float
    ) -> "Conductors | None":
        """Bodies of at least `ratio` times the fluid's permittivity; None if there is none."""
        chosen = medium.permittivity >= ratio * medium.fluid
        if not chosen.any():
            return None
        boxes, grid, none = medium.boxes, medium.grid, np.zeros(0)
        places = (
            boxes.task, boxes.first, boxes.count, boxes.image, medium.points,
            np.array(grid.lengths), np.array(grid.periodic), medium.position, medium.layer,
            medium.form_arrays, chosen, np.array(grid.padded_shape),
        )  # fmt: skip
        counts = np.zeros(boxes.task.shape[0] + 1, dtype=np.int64)
        _list(*places, counts, none.astype(np.int64), none, False)
        start = np.concatenate([[0], np.cumsum(counts[:-1])])
        cells, values = np.zeros(start[-1], dtype=np.int64), np.zeros(start[-1], dtype=np.float32)
        _list(*places, start, cells, values, True)
        body, share = boxes.task[:, 0], np.ones(boxes.task.shape[0])
        every = cls(start, cells, values, boxes.order, boxes.group, body, share)
        sum_of_all, image = grid.zeros(), grid.zeros()
        every._spread(share, sum_of_all)
        fill_ghosts(sum_of_all, boundary)
        apply(sum_of_all, (0.0, 0.0, 0.0), 1.0, medium, geometry, image)
        capacity = every._gather(image, medium.permittivity.size)
        # One that fills the box, or lies among others, has no constant of its own.
        known = capacity > 0.0
        share = np.where(known, 1.0 / np.where(known, capacity, 1.0), 0.0)[body]
        return cls(start, cells, values, boxes.order, boxes.group, body, share)

    def correct(self, residual: np.ndarray, image: np.ndarray) -> None:
        """image ← image + Σ_b w_b (w_b·residual)/E_b."""
        total = self._gather(residual, int(self.body.max()) + 1)
        self._spread(self.share * total[self.body], image)

    def _gather(self, field: np.ndarray, bodies: int) -> np.ndarray:
        sums = np.zeros(self.body.size)
        _gather(self.start, self.cells, self.values, field.reshape(-1), sums)
        return np.bincount(self.body, sums, bodies)

    def _spread(self, amounts: np.ndarray, field: np.ndarray) -> None:
        parts = (self.order, self.group, self.start, self.cells, self.values)
        _spread(*parts, amounts, field.reshape(-1))


@njit(parallel=True, cache=True)
def _gather(start, cells, values, field, sums):
    for t in prange(sums.size):
        total = 0.0
        for m in range(start[t], start[t + 1]):
            total += values[m] * field[cells[m]]
        sums[t] = total


@njit(parallel=True, cache=True)
def _spread(order, group, start, cells, values, amounts, field):
    for g in prange(group.size - 1):
        for n in range(group[g], group[g + 1]):
            t = order[n]
            for m in range(start[t], start[t + 1]):
                field[cells[m]] += amounts[t] * values[m]


@njit(parallel=True, cache=True)
def _list(
    task, first, count, image, points, lengths, periodic, position, layer, forms, chosen, shape,
    start, cells, values, store,
):  # fmt: skip
    """Count the cells of each task, or store them."""
    code, xi, half_width = layer
    out = min(OUT, half_width)
    px, py, pz = points
    nx, ny, nz = shape[0] - 2, shape[1] - 2, shape[2] - 2
    for t in prange(task.shape[0]):
        b, found = task[t, 0], 0
        i = first[b, 0] + task[t, 1]
        gi = wrap(i, nx) if periodic[0] else i
        if not chosen[b] or gi > nx:
            continue
        x = place(px, 0, i, image[b, 0], lengths[0], periodic[0]) - position[b, 0]
        for j in range(first[b, 1], first[b, 1] + count[b, 1]):
            gj = wrap(j, ny) if periodic[1] else j
            if gj > ny:
                continue
            y = place(py, 0, j, image[b, 1], lengths[1], periodic[1]) - position[b, 1]
            for k in range(first[b, 2], first[b, 2] + count[b, 2]):
                gk = wrap(k, nz) if periodic[2] else k
                if gk > nz:
                    continue
                z = place(pz, 0, k, image[b, 2], lengths[2], periodic[2]) - position[b, 2]
                phi = level(code, distance(b, x, y, z, forms) / xi - out, half_width)
                if phi < LEAST:
                    continue
                if store:
                    cells[start[t] + found] = (gi * shape[1] + gj) * shape[2] + gk
                    values[start[t] + found] = phi
                found += 1
        if not store:
            start[t] = found
