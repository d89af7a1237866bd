"""Volume, centroid and inertia of unions of parts, what they share counted once.

V = ∫dV,   c = ∫r dV / V,   I = ∫(|r − c|² 1 − (r − c)(r − c)ᵀ) dV   (density one)
"""

import math

import numpy as np

from smoothprofile.distances import BOX, CYLINDER, ELLIPSOID, SPHERE
from smoothprofile.parts import Part, distance

# What parts share is measured on about 16³ cells, those on its surface halved this many times
# unless they become too many.
_OVERLAP_CELLS, _HALVINGS, _MOST_CELLS = 4096, 4, 1_000_000


def mass_properties(parts: tuple[Part, ...]) -> tuple[float, np.ndarray, np.ndarray]:
    """V, c = ∫r dV/V and I = tr(M)1 − M, M = ∫rrᵀdV − Vccᵀ, parts not counted twice."""
    if not all(part.bounded for part in parts):
        return math.inf, np.zeros(3), np.diag(np.full(3, math.inf))
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for i, part in enumerate(parts):
        turn, at = part.matrix, part.position
        own_volume, own_first, own_second = _turned(_own_moments(part), turn)
        shared_volume, shared_first, shared_second = _shared_moments(part, parts[:i])
        volume += own_volume - shared_volume
        first += own_first + own_volume * at - shared_first
        mixed = np.outer(own_first, at)
        second += own_second + mixed + mixed.T + own_volume * np.outer(at, at) - shared_second
    centroid = first / volume
    second -= volume * np.outer(centroid, centroid)
    return volume, centroid, np.trace(second) * np.eye(3) - second


def _turned(moments: tuple, turn: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
    volume, first, second = moments
    return volume, turn @ first, turn @ second @ turn.T


def _own_moments(part: Part) -> tuple[float, np.ndarray, np.ndarray]:
    """V, ∫x dV and ∫xxᵀdV of a bounded part about its own origin, along its own axes."""
    if part.surface is not None:
        return part.surface.volume, part.surface.first, part.surface.second
    volume, squares = _symmetric_moments(part)
    return volume, np.zeros(3), np.diag(squares)


def _symmetric_moments(part: Part) -> tuple[float, np.ndarray]:
    """V and ∫xᵢ²dV, (3,), of a solid with three planes of symmetry."""
    radius, half = float(part.size[0]), float(part.size[1])
    across, along = np.array([1.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])
    if part.kind == BOX:
        volume = 8.0 * float(np.prod(part.size))
        return volume, volume * part.size**2 / 3.0
    if part.kind in (SPHERE, ELLIPSOID):
        radii = part.size if part.kind == ELLIPSOID else np.full(3, radius)
        volume = 4.0 / 3.0 * math.pi * float(np.prod(radii))
        return volume, volume * radii**2 / 5.0
    volume = 2.0 * math.pi * radius**2 * half
    second = volume * (radius**2 / 4.0 * across + half**2 / 3.0 * along)
    if part.kind == CYLINDER:
        return volume, second
    ball = 4.0 / 3.0 * math.pi * radius**3
    second += ball * (radius**2 / 5.0 + (half**2 + 0.75 * half * radius) * along)
    return volume + ball, second


def _shared_moments(part: Part, earlier: tuple[Part, ...]) -> tuple[float, np.ndarray, np.ndarray]:
    """∫dV, ∫r dV, ∫rrᵀdV where d = max(d_part, d_earlier) < 0; exactly 0 where nothing is shared.

    As |∇d| ≤ 1, a cell of half diagonal ≤ |d| at its centre is all in or all out; the others are
    halved, and the smallest count by ½ − d/h between 0 and 1, the share of a cell behind a plane.
    """
    volume, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    if not earlier:
        return volume, first, second
    low = np.min([other.position - other.half_extents for other in earlier], axis=0)
    high = np.max([other.position + other.half_extents for other in earlier], axis=0)
    low = np.maximum(low, part.position - part.half_extents)
    sides = np.minimum(high, part.position + part.half_extents) - low
    if np.any(sides <= 0.0):
        return volume, first, second
    counts = np.ceil(sides / np.cbrt(np.prod(sides) / _OVERLAP_CELLS)).clip(4, 64).astype(int)
    h = sides / counts
    points = low + h * (np.indices(counts).reshape(3, -1).T + 0.5)
    for halving in range(_HALVINGS + 1):
        d = np.maximum(distance((part,), points), distance(earlier, points))
        cut = np.abs(d) < 0.5 * np.linalg.norm(h)
        weights = np.where(cut, 0.0, d < 0.0)
        last = halving == _HALVINGS or 8 * np.count_nonzero(cut) > _MOST_CELLS
        if last:
            # Parts that only touch are not to share a volume by the round-off of d.
            shared = volume > 0.0 or np.min(d, initial=0.0) < -1e-6 * np.min(h)
            weights = np.clip(0.5 - d / np.min(h), 0.0, 1.0) * shared
        weights = weights * np.prod(h)
        volume += float(np.sum(weights))
        first += weights @ points
        second += (points.T * weights) @ points + np.diag(np.sum(weights) * h**2 / 12.0)
        if last:
            break
        h = 0.5 * h
        eighths = h * (np.indices((2, 2, 2)).reshape(3, -1).T - 0.5)
        points = (points[cut, None, :] + eighths).reshape(-1, 3)
    return volume, first, second
