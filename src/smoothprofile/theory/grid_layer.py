"""How far a flat penalised wall seems to stand from its painted place on a grid.

    W_{j+1} − 2W_j + W_{j−1} = h²χ(z_j) W_j,   W → slope·(z + s)

s is that of `planar` and a little more, of order h²: differences see W_zz + (h²/12)W_zzzz. Across
a wall with the normal n that is oblique to the grid it is (h²/12)Σnᵢ⁴ W_zzzz, and over all
directions the mean of Σnᵢ⁴ is 3/5.
"""

import math
from collections.abc import Callable

import numpy as np

OBLIQUE = math.sqrt(3.0 / 5.0)
PLACES = 16
FINE = 64
DECAYS = 40.0


def grid_shift(
    resistance: Callable[[np.ndarray], np.ndarray], spacing: float, inner: float, outer: float
) -> float:
    """s on a grid of that spacing less s on a much finer one, the mean over all directions.

    resistance: χ(z), uniform below `inner` and zero above `outer`.
    """
    if spacing <= 0.0:
        return 0.0
    coarse = _shift(resistance, OBLIQUE * spacing, inner, outer)
    return coarse - _shift(resistance, spacing / FINE, inner, outer)


def _shift(resistance, spacing: float, inner: float, outer: float) -> float:
    """s, the mean over the places of the grid; W marched out from deep in the solid."""
    deep = DECAYS / math.sqrt(float(resistance(np.array([inner]))[0]))
    first = math.floor((inner - deep) / spacing)
    count = math.ceil(outer / spacing) + 2 - first
    place = (np.arange(PLACES) + 0.5) / PLACES
    below, here = np.zeros(PLACES), np.full(PLACES, 1e-200)
    for j in range(count):
        z = (first + j + place) * spacing
        below, here = here, (2.0 + spacing**2 * resistance(z)) * here - below
    return float(np.mean(here / (here - below) * spacing - (z + spacing)))
