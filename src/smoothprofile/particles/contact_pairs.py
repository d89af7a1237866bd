"""Which parts may come to touch: candidates from a periodic k-d tree, by classes of size.

A candidate is a row (part, other, feature). `other` is a part of another body, or
−1 − 2·axis − side for a wall; `feature` counts the points that stand for the part against a plane
(a wall, or a part that is one), and is 0 between two solids. Rows are sorted, so that sums over
those in contact have the same order whichever other candidates stand between them.
"""

import math

import numpy as np
from scipy.spatial import cKDTree

from smoothprofile.distances import BOX, CAPSULE, CYLINDER, PLANE, SPHERE
from smoothprofile.particles.contact_gap import feature_count


def bounding_radii(kind: np.ndarray, size: np.ndarray) -> np.ndarray:
    """(m,): radius of a ball about the part's centre that holds it; inf if it has no end."""
    found = size.max(axis=1, initial=0.0)
    found = np.where(kind == CAPSULE, size[:, 0] + size[:, 1], found)
    found = np.where(np.isin(kind, (BOX, CYLINDER)), np.linalg.norm(size, axis=1), found)
    found = np.where(kind == SPHERE, size[:, 0], found)
    return np.where(kind == PLANE, np.inf, found)


class Neighbours:
    """Candidates among parts, of which `body` (m,) tells the owner and `mobile` (m,) whether it
    can be pushed; `low`, `high` and `period` (3,) of the box, the period 0 on walled axes."""

    def __init__(self, body, kind, radius, mobile, low, high, period):
        self.body, self.radius, self.mobile = body, radius, mobile
        self.low, self.high, self.period = low, high, period
        self.features = np.array([0 if k == PLANE else feature_count(int(k)) for k in kind])
        self.plane = kind == PLANE
        bounded = np.flatnonzero(np.isfinite(radius))
        self.endless = np.flatnonzero(~np.isfinite(radius))
        least = radius[bounded].min(initial=math.inf)
        size_class = np.floor(np.log2(radius[bounded] / least)).astype(int)
        self.classes = [bounded[size_class == c] for c in np.unique(size_class)]

    def within(self, centre: np.ndarray, distance: float) -> np.ndarray:
        """(rows, 3): all candidates whose enclosing balls are nearer than `distance`."""
        inside = centre - self.low
        wrapped = np.where(
            self.period > 0.0, inside % np.where(self.period > 0.0, self.period, 1.0), inside
        )
        # x % L may round to L itself, which the tree refuses.
        wrapped = np.where((self.period > 0.0) & (wrapped >= self.period), 0.0, wrapped)
        pairs = np.concatenate([self._bounded_pairs(wrapped, distance), self._endless_pairs()])
        rows = [self._pair_rows(pairs), *self._wall_rows(centre, distance)]
        found = np.concatenate(rows)
        return found[np.lexsort((found[:, 2], found[:, 1], found[:, 0]))]

    def _bounded_pairs(self, wrapped: np.ndarray, distance: float) -> np.ndarray:
        trees = [cKDTree(wrapped[group], boxsize=self.period) for group in self.classes]
        largest = [self.radius[group].max() for group in self.classes]
        found = [np.zeros((0, 2), np.int64)]
        for a, group in enumerate(self.classes):
            own = trees[a].query_pairs(2.0 * largest[a] + distance, output_type="ndarray")
            found.append(group[own])
            for b in range(a):
                reach = largest[a] + largest[b] + distance
                near = trees[a].sparse_distance_matrix(trees[b], reach, output_type="ndarray")
                found.append(np.stack([group[near["i"]], self.classes[b][near["j"]]], axis=1))
        pairs = np.concatenate(found)
        pairs = pairs[self._can_meet(pairs)]
        apart = wrapped[pairs[:, 0]] - wrapped[pairs[:, 1]]
        period = np.where(self.period > 0.0, self.period, np.inf)
        apart -= np.where(self.period > 0.0, self.period, 0.0) * np.round(apart / period)
        reach = self.radius[pairs].sum(axis=1) + distance
        return pairs[np.einsum("ij,ij->i", apart, apart) < reach**2]

    def _endless_pairs(self) -> np.ndarray:
        if not self.endless.size:
            return np.zeros((0, 2), np.int64)
        bounded = np.concatenate(self.classes) if self.classes else np.zeros(0, np.int64)
        first, second = np.meshgrid(bounded, self.endless, indexing="ij")
        pairs = np.stack([first.ravel(), second.ravel()], axis=1)
        return pairs[self._can_meet(pairs)]

    def _can_meet(self, pairs: np.ndarray) -> np.ndarray:
        apart = self.body[pairs[:, 0]] != self.body[pairs[:, 1]]
        return apart & (self.mobile[pairs[:, 0]] | self.mobile[pairs[:, 1]])

    def _pair_rows(self, pairs: np.ndarray) -> np.ndarray:
        """The lower part first, but a part without end second."""
        swap = (pairs[:, 0] > pairs[:, 1]) & np.isfinite(self.radius[pairs[:, 1]])
        pairs = np.where(swap[:, None], pairs[:, ::-1], pairs)
        count = np.where(self.plane[pairs[:, 1]], self.features[pairs[:, 0]], 1)
        return _repeated(pairs, count)

    def _wall_rows(self, centre: np.ndarray, distance: float) -> list[np.ndarray]:
        rows = []
        for axis in np.flatnonzero(self.period == 0.0):
            x = centre[:, axis]
            for side, gap in enumerate((x - self.low[axis], self.high[axis] - x)):
                near = np.flatnonzero(
                    self.mobile & np.isfinite(self.radius) & (gap - self.radius < distance)
                )
                pairs = np.stack([near, np.full(near.size, -1 - 2 * axis - side)], axis=1)
                rows.append(_repeated(pairs, self.features[near]))
        return rows


def _repeated(pairs: np.ndarray, count: np.ndarray) -> np.ndarray:
    """Each pair `count` times, numbered in a third column."""
    first = np.repeat(np.cumsum(count) - count, count)
    number = np.arange(first.size) - first
    return np.concatenate([np.repeat(pairs, count, axis=0), number[:, None]], axis=1).astype(
        np.int64
    )
