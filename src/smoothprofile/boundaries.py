"""Boundary conditions, and the only code that fills ghost cells.

periodic            f₀ = f_n,  f_{n+1} = f₁
value (centred)     ½(f₀ + f₁) = value      no-slip wall for a tangential velocity, electrode
value (staggered)   f₁ = value              no penetration for the normal velocity
flux                f₀ = f₁                 zero flux: pressure at a wall, free slip
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from smoothprofile.grid import Grid

Condition = Literal["periodic", "value", "flux"]
SIDES = ("low", "high")


@dataclass(frozen=True)
class FieldBoundary:
    """Conditions of one field: a (low, high) pair per axis, and the axis it is staggered on."""

    conditions: tuple[tuple[Condition, Condition], ...]
    staggered: int = -1

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
    for axis in (2, 1, 0):
        f = np.moveaxis(field, axis, 0)
        n = f.shape[0] - 2
        low, high = boundary.conditions[axis]
        if low == "periodic":
            f[0], f[n + 1] = f[n], f[1]
            continue
        at_low, at_high = (0.0, 0.0) if values is None else values[axis]
        if axis == boundary.staggered:
            f[1] = at_low
            f[n + 1] = at_high
            f[0] = at_low
            continue
        f[0] = f[1] if low == "flux" else 2.0 * at_low - f[1]
        f[n + 1] = f[n] if high == "flux" else 2.0 * at_high - f[n]
