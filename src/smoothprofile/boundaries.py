"""Boundary conditions, and the only code that fills ghost cells.

periodic            f₀ = f_n,  f_{n+1} = f₁
value (centred)     ½(f₀ + f₁) = value      no-slip wall for a tangential velocity, electrode
value (staggered)   f₁ = value              no penetration for the normal velocity
flux                f₀ = f₁                 zero flux: pressure at a wall, free slip
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numba import njit

from smoothprofile.grid import Grid

Condition = Literal["periodic", "value", "flux"]
SIDES = ("low", "high")
PERIODIC, VALUE, FLUX, FACE = range(4)


@dataclass(frozen=True)
class FieldBoundary:
    """Conditions of one field: a (low, high) pair per axis, and the axis it is staggered on."""

    conditions: tuple[tuple[Condition, Condition], ...]
    staggered: int = -1

    @cached_property
    def codes(self) -> np.ndarray:
        """(3,2) of PERIODIC, VALUE, FLUX, or FACE for the walls of a normal velocity."""
        numbers = {"periodic": PERIODIC, "value": VALUE, "flux": FLUX}
        codes = np.array([[numbers[c] for c in pair] for pair in self.conditions])
        if self.staggered >= 0 and not self.periodic(self.staggered):
            codes[self.staggered] = FACE
        return codes

    def periodic(self, axis: int) -> bool:
        return self.conditions[axis][0] == "periodic"

    def first_unknown(self, axis: int) -> int:
        """Padded index of the first unknown: the low wall face is known, not solved for."""
        return 2 if axis == self.staggered and not self.periodic(axis) else 1

    def unknowns(self, grid: Grid) -> tuple[slice, slice, slice]:
        """Padded slices that hold what has to be solved for."""
        return tuple(slice(self.first_unknown(d), grid.shape[d] + 1) for d in range(3))


def pressure_boundary(grid: Grid) -> FieldBoundary:
    """Zero flux at every wall."""
    return FieldBoundary(
        tuple(("periodic",) * 2 if axis.periodic else ("flux",) * 2 for axis in grid.axes)
    )


def velocity_boundary(grid: Grid, walls: tuple, component: int) -> FieldBoundary:
    """Of velocity `component`; walls[axis] = (low, high) of "wall" or "slip" where not periodic."""

    def condition(axis: int, kind: str) -> Condition:
        return "value" if axis == component or kind == "wall" else "flux"

    return FieldBoundary(
        tuple(
            ("periodic",) * 2
            if grid.axes[d].periodic
            else (condition(d, walls[d][0]), condition(d, walls[d][1]))
            for d in range(3)
        ),
        staggered=component,
    )


def fill_ghosts(field: np.ndarray, boundary: FieldBoundary, values=None) -> None:
    """Fill the ghost layer, edges and corners included, and the wall faces of a normal velocity.

    values[axis][side] is the number that a "value" side holds; zero everywhere when left out.
    """
    values = np.zeros((3, 2)) if values is None else np.asarray(values, dtype=np.float64)
    _fill_planes(field, boundary.codes, values)
    _fill_ends(field, boundary.codes[0], values[0])


@njit(inline="always")
def _ghost(code, inner, value):
    return inner if code == FLUX else 2.0 * value - inner


@njit(cache=True)
def _fill_ends(f, codes, values):
    """Ghost planes of the first axis."""
    n = f.shape[0] - 2
    if codes[0] == PERIODIC:
        f[0], f[n + 1] = f[n], f[1]
    elif codes[0] == FACE:
        f[0], f[1], f[n + 1] = values[0], values[0], values[1]
    else:
        for j in range(f.shape[1]):
            for k in range(f.shape[2]):
                f[0, j, k] = _ghost(codes[0], f[1, j, k], values[0])
                f[n + 1, j, k] = _ghost(codes[1], f[n, j, k], values[1])


@njit(cache=True)
def _fill_planes(f, codes, values):
    """Ghost rows and columns of every plane; then those of the edges are right too.

    On one thread: it touches so little that waking others takes longer.
    """
    ny, nz = f.shape[1] - 2, f.shape[2] - 2
    for i in range(1, f.shape[0] - 1):
        g = f[i]
        for j in range(1, ny + 1):
            if codes[2, 0] == PERIODIC:
                g[j, 0], g[j, nz + 1] = g[j, nz], g[j, 1]
            elif codes[2, 0] == FACE:
                g[j, 0] = g[j, 1] = values[2, 0]
                g[j, nz + 1] = values[2, 1]
            else:
                g[j, 0] = _ghost(codes[2, 0], g[j, 1], values[2, 0])
                g[j, nz + 1] = _ghost(codes[2, 1], g[j, nz], values[2, 1])
        for k in range(nz + 2):
            if codes[1, 0] == PERIODIC:
                g[0, k], g[ny + 1, k] = g[ny, k], g[1, k]
            elif codes[1, 0] == FACE:
                g[0, k] = g[1, k] = values[1, 0]
                g[ny + 1, k] = values[1, 1]
            else:
                g[0, k] = _ghost(codes[1, 0], g[1, k], values[1, 0])
                g[ny + 1, k] = _ghost(codes[1, 1], g[ny, k], values[1, 1])
