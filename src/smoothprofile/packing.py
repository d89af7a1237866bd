"""Places for spheres: points of lattices, and random packings without overlap.

    E = ½ Σ max(0, b_i + b_j − |x_i − x_j|)²,   b = radius + gap/2

Random packings start from points anywhere, slide down E until no two spheres overlap, and are then
stirred by hard-sphere Monte Carlo, which forgets how they came about. The result is a function of
its arguments and of the generator's seed alone.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from scipy.spatial import cKDTree

MOST_STEPS = 3000
PATIENCE, PROGRESS = 100, 0.8
"""Sliding is given up when so many steps leave more than this part of the energy."""
# Slightly larger spheres slide, so that those asked for come clear in finitely many steps.
INFLATED = 1.0005
DENSEST = math.pi / math.sqrt(18.0)
"""Volume fraction of the densest packing of equal spheres."""
BLOCKS, SWEEPS = 10, 10
"""Times that neighbours are found anew while stirring, and tries for each sphere in between."""

BASES = {
    "cubic": ((0.0, 0.0, 0.0),),
    "bcc": ((0.0, 0.0, 0.0), (0.5, 0.5, 0.5)),
    "fcc": ((0.0, 0.0, 0.0), (0.5, 0.5, 0.0), (0.5, 0.0, 0.5), (0.0, 0.5, 0.5)),
}


def lattice(kind: str, counts: Sequence[int], spacing: Sequence[float], origin) -> np.ndarray:
    """x = origin + spacing·(i + basis): (n, 3), the last axis fastest, cell by cell.

    `kind` a name of BASES, `counts` unit cells and `spacing` sides of the unit cell along x, y, z.
    """
    cells = np.indices(tuple(counts)).reshape(3, -1).T
    sites = cells[:, None, :] + np.array(BASES[kind])
    return np.asarray(origin) + sites.reshape(-1, 3) * np.asarray(spacing)


@dataclass(frozen=True, eq=False)
class Room:
    """Where centres may be: low and high (n, 3) for each sphere, except along axes (3,) that are
    `endless`. Coordinates count from the low corner of the periodic box; periods (3,) are 0 where
    there is none.

    Spheres that stand: `fixed` (m, 3) and their radii `fixed_radii` (m,). Other solids: `solids`,
    functions from points (k, 3) to signed distances (k,).
    """

    low: np.ndarray
    high: np.ndarray
    periods: np.ndarray
    endless: np.ndarray
    fixed: np.ndarray
    fixed_radii: np.ndarray
    solids: Sequence[Callable[[np.ndarray], np.ndarray]] = ()


def pack(
    radii: np.ndarray, gap: float, room: Room, generator: np.random.Generator
) -> np.ndarray | None:
    """Centres (n, 3) of spheres at least `gap` apart, of each other and of what stands.

    None if none were found; a packing may exist all the same, if only just.
    """
    if np.any(room.low > room.high):
        return None
    x = generator.uniform(room.low, room.high)
    low, high = np.where(room.endless, -np.inf, room.low), np.where(room.endless, np.inf, room.high)
    room = replace(room, low=low, high=high)
    sizes = np.concatenate([radii, room.fixed_radii]) + 0.5 * gap
    if not _relax(x, sizes, radii + gap, room):
        return None
    _stir(x, sizes, radii + gap, room, generator)
    return _wrapped(x, room)


def _wrapped(x: np.ndarray, room: Room) -> np.ndarray:
    """x within the periodic box; round-off at its end counts as its beginning."""
    periods = np.where(room.periods > 0.0, room.periods, 1.0)
    inside = x - periods * np.floor(x / periods)
    inside = np.where(inside >= periods, 0.0, inside)
    return np.where(room.periods > 0.0, inside, x)


def _relax(x: np.ndarray, sizes: np.ndarray, clearance: np.ndarray, room: Room) -> bool:
    """Slide x (n, 3) downhill until nothing overlaps; whether it got there.

    By FIRE (Bitzek et al., Phys. Rev. Lett. 97, 2006): motion with unit mass, turned towards the
    force, faster while it goes downhill and stopped where it would climb.
    """
    n, v = len(x), np.zeros_like(x)
    grown, skin = INFLATED * sizes, 0.4 * float(sizes.mean())
    dt, turn, downhill = 0.1, 0.1, 0
    pairs = found_at = None
    energy_then = math.inf
    for step in range(MOST_STEPS):
        if found_at is None or np.max(np.sum((x - found_at) ** 2, axis=1)) > (0.5 * skin) ** 2:
            pairs, found_at = _pairs(x, grown, skin, room), x.copy()
        force, overlap, energy = _push(x, n, grown, pairs, room)
        deepest, more = _push_off_solids(x, INFLATED * clearance, force, room)
        if max(overlap, deepest) <= (INFLATED - 1.0) * sizes.min():
            return True
        if step % PATIENCE == PATIENCE - 1:
            if energy + more > PROGRESS * energy_then:
                return False
            energy_then = energy + more
        power = float(np.vdot(force, v))
        downhill = downhill + 1 if power > 0.0 else 0
        if power > 0.0:
            pull = math.sqrt(float(np.vdot(v, v)) / max(float(np.vdot(force, force)), 1e-300))
            v += turn * (pull * force - v)
            if downhill > 5:
                dt, turn = min(1.1 * dt, 0.5), 0.99 * turn
        else:
            v[:] = 0.0
            dt, turn = 0.5 * dt, 0.1
        v += dt * force
        x += dt * v
        np.clip(x, room.low, room.high, out=x)
    return False


def _pairs(x: np.ndarray, sizes: np.ndarray, skin: float, room: Room) -> np.ndarray:
    """(p, 2): spheres i < j nearer than their sizes and `skin`; the first is always a mover."""
    places = np.concatenate([_wrapped(x, room), room.fixed])
    shift = np.where(room.periods > 0.0, 0.0, places.min(axis=0))
    tree = cKDTree(places - shift, boxsize=room.periods)
    pairs = tree.query_pairs(2.0 * sizes.max() + skin, output_type="ndarray")
    pairs = pairs[pairs[:, 0] < len(x)]
    apart = _apart(places[pairs[:, 0]] - places[pairs[:, 1]], room)
    near = np.linalg.norm(apart, axis=1) < sizes[pairs].sum(axis=1) + skin
    pairs = pairs[near]
    # The tree's order is its own business; sums are to have the same round-off everywhere.
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def _apart(difference: np.ndarray, room: Room) -> np.ndarray:
    """The difference to the nearest periodic image."""
    periods = np.where(room.periods > 0.0, room.periods, np.inf)
    return difference - room.periods * np.round(difference / periods)


def _push(x, n, sizes, pairs, room) -> tuple[np.ndarray, float, float]:
    """Force (n, 3) from overlaps of spheres, the largest overlap, and E."""
    i, j = pairs.T
    places = np.concatenate([x, room.fixed])
    apart = _apart(places[i] - places[j], room)
    away = np.linalg.norm(apart, axis=1)
    overlap = sizes[i] + sizes[j] - away
    met = overlap > 0.0
    i, j, overlap = i[met], j[met], overlap[met]
    push = apart[met] * (overlap / np.maximum(away[met], 1e-12))[:, None]
    force = np.empty((n, 3))
    for d in range(3):
        total = np.bincount(i, push[:, d], n) - np.bincount(j, push[:, d], len(places))[:n]
        force[:, d] = total
    return force, float(overlap.max(initial=0.0)), 0.5 * float(np.sum(overlap**2))


def _push_off_solids(x, clearance, force, room) -> tuple[float, float]:
    """Add to the force that of solids nearer than `clearance` (n,); the largest overlap, and E."""
    worst, energy = 0.0, 0.0
    for solid in room.solids:
        depth = clearance - solid(x)
        met = np.flatnonzero(depth > 0.0)
        if not met.size:
            continue
        worst = max(worst, float(depth[met].max()))
        energy += 0.5 * float(np.sum(depth[met] ** 2))
        step = 1e-4 * float(clearance.mean())
        ways = step * np.eye(3)
        slope = np.stack([solid(x[met] + way) - solid(x[met] - way) for way in ways], axis=1) / (
            2.0 * step
        )
        force[met] += depth[met, None] * slope
    return worst, energy


def _stir(x, sizes, clearance, room, generator) -> None:
    """Hard-sphere Monte Carlo on x: spheres try random steps and keep those that overlap nothing.

    Within a block no sphere leaves a ball in which it meets only the neighbours found before.
    """
    n, skin = len(x), 0.8 * float(sizes.mean())
    for _ in range(BLOCKS):
        pairs = _pairs(x, sizes, skin, room)
        # Each mover with all its neighbours, those that stand included.
        both = np.concatenate([pairs, pairs[pairs[:, 1] < n][:, ::-1]])
        both = both[np.lexsort((both[:, 1], both[:, 0]))]
        start = np.searchsorted(both[:, 0], np.arange(n + 1))
        leash = np.full(n, 0.5 * skin)
        for solid in room.solids:
            # |d| changes by no more than the way.
            leash = np.minimum(leash, np.maximum(solid(x) - clearance, 0.0))
        steps = generator.uniform(-0.3 * skin, 0.3 * skin, (SWEEPS, n, 3))
        places = np.concatenate([x, room.fixed])
        _sweep(places, sizes, start, both[:, 1], leash, room.low, room.high, room.periods, steps)
        x[:] = places[:n]


@njit(cache=True)
def _sweep(places, sizes, start, neighbours, leash, low, high, periods, steps):
    n = leash.size
    at_first = places[:n].copy()
    for sweep in range(steps.shape[0]):
        for i in range(n):
            x = places[i, 0] + steps[sweep, i, 0]
            y = places[i, 1] + steps[sweep, i, 1]
            z = places[i, 2] + steps[sweep, i, 2]
            way = (x - at_first[i, 0]) ** 2 + (y - at_first[i, 1]) ** 2
            way += (z - at_first[i, 2]) ** 2
            clear = way <= leash[i] * leash[i]
            clear &= low[i, 0] <= x <= high[i, 0]
            clear &= low[i, 1] <= y <= high[i, 1]
            clear &= low[i, 2] <= z <= high[i, 2]
            for m in range(start[i], start[i + 1]):
                if not clear:
                    break
                j = neighbours[m]
                away = 0.0
                for d in range(3):
                    u = (x, y, z)[d] - places[j, d]
                    if periods[d] > 0.0:
                        u -= periods[d] * np.round(u / periods[d])
                    away += u * u
                clear = away >= (sizes[i] + sizes[j]) ** 2
            if clear:
                places[i, 0], places[i, 1], places[i, 2] = x, y, z
