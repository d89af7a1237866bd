"""How beads stand to each other: chains, their length and direction, pairs by distance.

    bond: h < ηa,   h = |r| − a_i − a_j,   a = (a_i + a_j)/2
    chain: beads that bonds connect, a lone bead being a chain of one
    ⟨s⟩ = Σs/Σ1,   ⟨s⟩_m = Σs²/Σs over chains of s beads
    P₂ = ⟨(3cos²θ − 1)/2⟩ over bonds, θ from the field: 1 along it, −½ across it, 0 at random
    g(r) = pairs found at r over those of beads anywhere

Chains that close on themselves through a periodic side count their beads once. Pairs are those of
the nearest images.
"""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from smoothprofile.distances import SPHERE

NEAR = 0.3
"""η: gaps below this share of the radius are bonds; the cell or so that contact keeps is less."""
CONE = math.radians(30.0)
"""Pairs within this angle of the field are along it, within it of the plane across it, across."""
FARTHEST, BIN = 10.0, 0.1
"""Of g(r): largest distance and width of a bin, over the mean radius."""
DIRECTIONS = 4000
TABLE = "structure.csv"


@dataclass(frozen=True, eq=False)
class Beads:
    """Spheres in a box: position (n,3), radius (n,); low, lengths (3,) and periodic (3,) of it."""

    position: np.ndarray
    radius: np.ndarray
    low: np.ndarray
    lengths: np.ndarray
    periodic: np.ndarray

    @property
    def period(self) -> np.ndarray:
        """(3,): 0 along walled axes."""
        return np.where(self.periodic, self.lengths, 0.0)

    @property
    def wrapped(self) -> np.ndarray:
        """Positions from `low`, inside the box along periodic axes."""
        inside = self.position - self.low
        wrapped = np.where(self.periodic, np.mod(inside, self.lengths), inside)
        # x mod L may round to L itself, which a periodic tree refuses.
        return np.where(self.periodic & (wrapped >= self.lengths), 0.0, wrapped)

    def pairs(self, distance: float) -> tuple[np.ndarray, np.ndarray]:
        """Rows (m,2) of centres nearer than that, and r (m,3) from the first to the second."""
        places = self.wrapped
        rows = cKDTree(places, boxsize=self.period).query_pairs(distance, output_type="ndarray")
        apart = places[rows[:, 1]] - places[rows[:, 0]]
        turns = np.round(apart / np.where(self.periodic, self.lengths, np.inf))
        return rows, apart - self.period * turns


def bonds(beads: Beads, share: float = NEAR) -> tuple[np.ndarray, np.ndarray]:
    """Rows (m,2) of the pairs with h < share·(a_i + a_j)/2, and r (m,3) between their centres."""
    radius = beads.radius
    rows, apart = beads.pairs((2.0 + share) * radius.max(initial=0.0))
    mean = 0.5 * radius[rows].sum(axis=1)
    near = np.linalg.norm(apart, axis=1) < (2.0 + share) * mean
    return rows[near], apart[near]


def chain_of(count: int, rows: np.ndarray) -> np.ndarray:
    """(n,): the number of the chain of each bead, from the bonds' rows (m,2)."""
    ones = np.ones(len(rows), dtype=np.int8)
    graph = coo_array((ones, (rows[:, 0], rows[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def smallest_gap(beads: Beads) -> float:
    """min h over all pairs; infinite for a single bead."""
    radius, places = beads.radius, beads.wrapped
    if radius.size < 2:
        return math.inf
    apart, other = cKDTree(places, boxsize=beads.period).query(places, k=2)
    upper = float((apart[:, 1] - radius - radius[other[:, 1]]).min())
    if np.ptp(radius) == 0.0:
        return upper
    # Of unequal beads the nearest surfaces need not be those of the nearest centres.
    rows, between = beads.pairs((1.0 + 1e-12) * (max(upper, 0.0) + 2.0 * radius.max()))
    gaps = np.linalg.norm(between, axis=1) - radius[rows].sum(axis=1)
    return float(gaps.min(initial=upper))


def alignment(apart: np.ndarray, direction) -> float:
    """⟨(3cos²θ − 1)/2⟩ over bonds r (m,3), θ from `direction` (3,); NaN without bonds."""
    if not len(apart):
        return math.nan
    cosine = apart @ np.asarray(direction) / np.linalg.norm(apart, axis=1)
    return float(np.mean(1.5 * cosine**2 - 0.5))


def measures(beads: Beads, direction) -> dict[str, float]:
    """⟨s⟩, ⟨s⟩_m, the longest chain, P₂ of the bonds, and the smallest gap."""
    rows, apart = bonds(beads)
    count = beads.radius.size
    sizes = np.bincount(chain_of(count, rows))
    return {
        "mean_chain_length": float(count / sizes.size),
        "mass_mean_chain_length": float((sizes**2).sum() / count),
        "longest_chain": int(sizes.max()),
        "alignment": alignment(apart, direction),
        "smallest_gap": smallest_gap(beads),
    }


def pair_distribution(beads: Beads, direction) -> dict[str, np.ndarray]:
    """g at the middles r of bins: of all pairs, of those along `direction`, of those across it.

    Beads anywhere means centres anywhere in the box, a mean radius from its walls.
    """
    radius, count = float(beads.radius.mean()), beads.radius.size
    room = np.where(beads.periodic, beads.lengths, beads.lengths - 2.0 * radius)
    room = np.maximum(room, 1e-3 * radius)
    farthest = min(FARTHEST * radius, 0.5 * float(beads.lengths.min()))
    edges = BIN * radius * np.arange(max(math.floor(farthest / (BIN * radius)), 1) + 1)
    _, apart = beads.pairs(float(edges[-1]))
    length = np.linalg.norm(apart, axis=1)
    middle, cells = 0.5 * (edges[1:] + edges[:-1]), np.diff(edges**3) * 4.0 / 3.0 * math.pi
    points = _directions()
    # A pair of that direction has room for its first bead where the second is in the box too.
    walled = np.where(beads.periodic, 0.0, np.abs(points) / room)
    free = np.prod(np.maximum(1.0 - middle[:, None, None] * walled, 0.0), axis=2)
    found = {"r": middle}
    for name, chosen in (("g", _all), ("g_along", _along), ("g_across", _across)):
        share = (free * chosen(points, direction)).mean(axis=1)
        expected = 0.5 * count * (count - 1) * cells * share / room.prod()
        inside = chosen(apart / np.maximum(length, 1e-300)[:, None], direction)
        counts = np.histogram(length[inside], edges)[0]
        found[name] = counts / np.where(expected > 0.0, expected, math.inf)
    return found


def beads_of(simulation: Any) -> Beads:
    """The balls among the bodies of a run."""
    forms, state, grid = simulation.bodies.painter.forms, simulation.bodies.state, simulation.grid
    rows = _ball_rows(forms)
    return Beads(
        state.position[rows],
        forms.size[forms.part_start[rows], 0],
        np.array([axis.low for axis in grid.axes]),
        np.array(grid.lengths),
        np.array(grid.periodic),
    )


def field_direction(simulation: Any) -> np.ndarray:
    """(3,): of the electrodes' axis, or else of the field, or of its quadrature if that is 0."""
    electric = simulation.case.electric
    if electric.electrodes is not None:
        return np.eye(3)["xyz".index(electric.electrodes.axis)]
    given = np.array(electric.field if any(electric.field) else electric.quadrature)
    return given / np.linalg.norm(given)


def has_structure(simulation: Any) -> bool:
    """Whether a field acts on beads, more than one of which moves."""
    if simulation.case.electric is None or not simulation.bodies_move:
        return False
    rows = _ball_rows(simulation.bodies.painter.forms)
    held = [simulation.case.particles[b].motion == "held" for b in rows]
    return len(held) - sum(held) > 1


def history_row(simulation: Any) -> dict[str, float]:
    """`measures` of a run, for its history; nothing where no field moves beads."""
    if not has_structure(simulation):
        return {}
    return measures(beads_of(simulation), field_direction(simulation))


def write_pairs(path: Path, simulation: Any) -> None:
    """The `pair_distribution` of a run as a CSV table; no file where no field moves beads."""
    if not has_structure(simulation):
        return
    table = pair_distribution(beads_of(simulation), field_direction(simulation))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table)
        writer.writerows(zip(*(column.tolist() for column in table.values()), strict=True))


def _ball_rows(forms: Any) -> np.ndarray:
    first = forms.part_start[:-1]
    alone = np.diff(forms.part_start) == 1
    return np.flatnonzero(
        alone & (forms.kind[first] == SPHERE) & ~np.any(forms.place[first], axis=1)
    )


def _all(points: np.ndarray, direction) -> np.ndarray:
    return np.ones(len(points), dtype=bool)


def _along(points: np.ndarray, direction) -> np.ndarray:
    return np.abs(points @ np.asarray(direction)) > math.cos(CONE)


def _across(points: np.ndarray, direction) -> np.ndarray:
    return np.abs(points @ np.asarray(direction)) < math.sin(CONE)


def _directions() -> np.ndarray:
    """Points (k,3) spread evenly over the unit sphere, on a spiral of equal areas."""
    number = np.arange(DIRECTIONS) + 0.5
    z = 1.0 - 2.0 * number / DIRECTIONS
    turn = math.pi * (1.0 + math.sqrt(5.0)) * number
    flat = np.sqrt(1.0 - z**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
