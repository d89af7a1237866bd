"""Staggered (MAC) Cartesian grids: axes, spacings, coordinates.

Every field of a grid has the padded shape, one ghost layer on each side. Cell (i,j,k) of the
domain has padded indices 1…n. u[i,j,k] lies on the low-x face of cell (i,j,k), v on its low-y
face, w on its low-z face, pressure at its centre. On a walled axis the faces 1 and n+1 are the
walls; on a periodic axis face n+1 is face 1.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from smoothprofile.errors import CaseError

AXIS_NAMES = ("x", "y", "z")


@dataclass(frozen=True, eq=False)
class Axis:
    """One axis: the coordinates of its n+1 cell faces, and whether it is periodic."""

    name: str
    faces: np.ndarray
    periodic: bool

    def __post_init__(self):
        faces = np.asarray(self.faces, dtype=np.float64)
        if faces.ndim != 1 or faces.size < 2 or not np.all(np.diff(faces) > 0):
            raise CaseError(f"the cell faces along {self.name} must be two or more rising numbers.")
        object.__setattr__(self, "faces", faces)

    @property
    def cells(self) -> int:
        return self.faces.size - 1

    @property
    def low(self) -> float:
        return float(self.faces[0])

    @property
    def high(self) -> float:
        return float(self.faces[-1])

    @property
    def length(self) -> float:
        return self.high - self.low

    @cached_property
    def uniform(self) -> bool:
        """Equal widths, to the round-off of coordinates that were computed."""
        return bool(np.ptp(np.diff(self.faces)) <= 1e-9 * self.length / self.cells)

    @cached_property
    def centres(self) -> np.ndarray:
        return 0.5 * (self.faces[1:] + self.faces[:-1])

    @cached_property
    def widths(self) -> np.ndarray:
        if self.uniform:
            return np.full(self.cells, self.length / self.cells)
        return np.diff(self.faces)

    @cached_property
    def padded_widths(self) -> np.ndarray:
        """(n+2,) widths of padded cells; a ghost mirrors the cell at its wall, or wraps."""
        low, high = (-1, 0) if self.periodic else (0, -1)
        return np.concatenate([self.widths[[low]], self.widths, self.widths[[high]]])

    @cached_property
    def padded_distances(self) -> np.ndarray:
        """(n+2,) distance between the centres of padded cells i−1 and i, held at face i."""
        widths = self.padded_widths
        inner = 0.5 * (widths[1:] + widths[:-1])
        return np.concatenate([inner[[-2 if self.periodic else 0]], inner])

    @cached_property
    def padded_faces(self) -> np.ndarray:
        """(n+2,) coordinate of the low face of each padded cell."""
        return np.concatenate([[self.low - self.padded_widths[0]], self.faces])

    @cached_property
    def padded_centres(self) -> np.ndarray:
        """(n+2,) coordinate of the centre of each padded cell."""
        return self.padded_faces + 0.5 * self.padded_widths


@dataclass(frozen=True, eq=False)
class Grid:
    """Three axes and the number type of the fields on them."""

    axes: tuple[Axis, Axis, Axis]
    dtype: type = np.float64
    shape: tuple[int, int, int] = field(init=False)

    def __post_init__(self):
        object.__setattr__(self, "shape", tuple(axis.cells for axis in self.axes))

    @property
    def padded_shape(self) -> tuple[int, int, int]:
        return tuple(n + 2 for n in self.shape)

    @property
    def lengths(self) -> tuple[float, float, float]:
        return tuple(axis.length for axis in self.axes)

    @property
    def periodic(self) -> tuple[bool, bool, bool]:
        return tuple(axis.periodic for axis in self.axes)

    @property
    def cell_count(self) -> int:
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def volume(self) -> float:
        return float(np.prod(self.lengths))

    @property
    def smallest_widths(self) -> tuple[float, float, float]:
        return tuple(float(axis.widths.min()) for axis in self.axes)

    def zeros(self) -> np.ndarray:
        """A padded field of zeros."""
        return np.zeros(self.padded_shape, dtype=self.dtype)

    def face_coordinates(self, component: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Padded coordinates along each axis of the points where velocity `component` lies."""
        return tuple(
            axis.padded_faces if d == component else axis.padded_centres
            for d, axis in enumerate(self.axes)
        )


def interior(field: np.ndarray) -> np.ndarray:
    """The view of a padded field without its ghost layer."""
    return field[1:-1, 1:-1, 1:-1]


def uniform_axis(name: str, low: float, length: float, cells: int, periodic: bool) -> Axis:
    """An axis of equal cells."""
    return Axis(name, low + length * (np.arange(cells + 1) / cells), periodic)


def stretched_axis(
    name: str,
    low: float,
    length: float,
    cells: int,
    periodic: bool,
    focus: float,
    ratio: float,
    core: float = 0.0,
) -> Axis:
    """d = t for t ≤ core, d = core + c·sinh((t − core)/c) beyond,  d = |x − focus|, t ∝ |s − s₀|

    s = i/n at face i. Cells are equal up to `core` from the focus; beyond, their width grows as
    √(1 + ((d − core)/c)²), c such that the farther end has `ratio` times the narrowest. The width
    and its slope are continuous within the axis, which keeps the scheme's second order.
    """
    high = low + length
    if not low <= focus <= high:
        raise CaseError(
            f"domain.stretching: focus {focus:g} lies outside the {name} axis, {low:g} to {high:g}."
        )
    below, above = focus - low, high - focus
    beyond = max(below, above) - core
    if ratio <= 1.0 or beyond <= 0.0:
        return uniform_axis(name, low, length, cells, periodic)
    growth = beyond / np.sqrt(ratio * ratio - 1.0)

    def measure(distance: float) -> float:
        """t of a distance d."""
        outer = max(distance - core, 0.0)
        return min(distance, core) + growth * np.arcsinh(outer / growth)

    t = np.linspace(-measure(below), measure(above), cells + 1)
    outer = np.maximum(np.abs(t) - core, 0.0)
    distance = np.minimum(np.abs(t), core) + growth * np.sinh(outer / growth)
    faces = focus + np.copysign(distance, t)
    faces[0], faces[-1] = low, high
    return Axis(name, faces, periodic)
