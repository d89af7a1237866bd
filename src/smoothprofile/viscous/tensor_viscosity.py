"""The smoothed viscosity of many bodies on the staggered grid.

    arithmetic  μ_a = μ_fluid + Σ w_b (μ_b − μ_fluid)
    harmonic    1/μ_h = 1/μ_fluid + Σ w_b (1/μ_b − 1/μ_fluid)
    tensor      μ_h for the shear of neighbouring layers, e_nt, and μ_a for all other strains,
                n = ∇μ_a/|∇μ_a|:  μ_h everywhere, and μ_a − μ_h with n in the cells of layers

w_b = φ_b Π_{c later}(1 − φ_c): a later body lies over an earlier one. Across a layer the tractions
are continuous and along it the gradients of velocity (and e_nn, which ∇·u = 0 ties to them), so
that the tensor alone moves a surface for no strain: its error is of second order in ξ, once
R(ξ/a)³ ≪ 1. Before, for stiff bodies, harmonic smoothing is better: the tensor's layer resists
strains along itself out to where Rφ ~ 1, in a fluid that a rigid surface does not hold.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.distances import MESH
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState, Forms
from smoothprofile.particles.paint import Painter, body_distance
from smoothprofile.particles.painting import STEEPEST, level
from smoothprofile.profiles import TANH, Profile

Smoothing = Literal["arithmetic", "harmonic", "tensor"]
SMOOTHINGS = ("arithmetic", "harmonic", "tensor")
ARITHMETIC, HARMONIC, TENSOR = range(3)

TAIL = 1e-4
"""Relative jump of μ or 1/μ at which the tails of tanh are cut."""
STEP = 1e-3
"""Of the central differences of d over ξ: truncation (STEP·ξ/a)² and round-off stay below 1e-9."""
NEGLIGIBLE = 1e-9
"""Of the fluid's viscosity: μ_a − μ_h below which a cell belongs to no layer."""


class SmoothedViscosity:
    """μ on one periodic grid: in cells, on edges, and the excess μ_a − μ_h of layers.

    cells: padded field at the centres, for e_xx, e_yy, e_zz. edges: three padded fields, edges[d]
    on the edges along axis d, for the shear of the other two. excess (m,), normal (m,3) and
    place (m,3): μ_a − μ_h, n and padded indices of the cells of layers; none but for the tensor.
    """

    def __init__(
        self,
        grid: Grid,
        forms: Forms,
        viscosity: Sequence[float],
        fluid: float,
        profile: Profile,
        thickness: float,
        smoothing: Smoothing = "tensor",
    ):
        """viscosity[b] of each body, in the order of painting; CaseError unless all are > 0."""
        checked_smoothing(smoothing)
        if not all(axis.periodic and axis.uniform for axis in grid.axes):
            raise CaseError("smoothed viscosity needs a periodic box of uniform axes.")
        if np.any(forms.kind >= MESH):
            raise CaseError("a triangulated surface cannot have a viscosity.")
        self.viscosity, self.fluid = np.array(viscosity, dtype=np.float64), float(fluid)
        for value in (*self.viscosity, self.fluid):
            checked_viscosity(value)
        if self.viscosity.shape != (forms.part_start.size - 1,):
            raise CaseError("there must be one viscosity for each body.")
        self.grid, self.forms, self.thickness, self.smoothing = grid, forms, thickness, smoothing
        self.profile = profile
        if profile.code == TANH:
            reach = 0.5 * math.log(self.contrast / TAIL)
            self.profile = replace(profile, half_width=min(profile.half_width, reach))
        self.boundary = pressure_boundary(grid)
        self._painter = Painter(grid, (self.boundary,) * 3, forms, self.profile, thickness)
        self.points = tuple(np.stack([a.padded_centres, a.padded_faces]) for a in grid.axes)
        self.cells = np.full(grid.padded_shape, self.fluid)
        self.edges = tuple(np.full(grid.padded_shape, self.fluid) for _ in range(3))
        self.excess, self.normal = np.zeros(0), np.zeros((0, 3))
        self.place = np.zeros((0, 3), dtype=np.int64)

    @property
    def contrast(self) -> float:
        """Largest over smallest viscosity."""
        every = np.append(self.viscosity, self.fluid)
        return float(every.max() / every.min())

    def bodies(self, state: BodyState) -> tuple:
        """Positions (n,3), half sides (n,3) of what is painted, and forms, as the kernels take."""
        f, rotation = self.forms, state.rotation
        half = self._painter.half_sides(rotation)
        parts = (f.part_start, f.kind, f.size, f.place, f.turn, f.offset)
        return state.position.copy(), half, np.ascontiguousarray(rotation), parts

    @property
    def layer(self) -> tuple[int, float, float]:
        """Code of the profile, ξ and half width in ξ, as the kernels take them."""
        return self.profile.code, self.thickness, self.profile.half_width

    def paint(self, state: BodyState) -> None:
        """Bring μ to where the bodies are."""
        mode, shape = SMOOTHINGS.index(self.smoothing), self.grid.padded_shape
        self.cells[:] = self.fluid
        for field in self.edges:
            field[:] = self.fluid
        # μ_a, 1/μ_h and ∇μ_a at the centres.
        mixture = np.zeros((5, *shape) if mode == TENSOR else (5, 1, 1, 1))
        mixture[0], mixture[1] = self.fluid, 1.0 / self.fluid
        _paint(
            *self.bodies(state), self.viscosity, self.points, np.array(self.grid.lengths),
            self.layer, mode, self.cells, self.edges, mixture,
        )  # fmt: skip
        for field in (self.cells, *self.edges):
            fill_ghosts(field, self.boundary)
        if mode != TENSOR:
            return
        above, below, slope = mixture[0], mixture[1], mixture[2:]
        excess = above - 1.0 / below
        self.place = np.argwhere(excess[1:-1, 1:-1, 1:-1] > NEGLIGIBLE * self.fluid) + 1
        at = tuple(self.place.T)
        self.excess, normal = excess[at], np.stack([s[at] for s in slope], axis=1)
        size = np.linalg.norm(normal, axis=1, keepdims=True)
        # Half way between two bodies there may be no normal, and μ_a resists all strains.
        self.normal = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0.0)


def checked_viscosity(value: float) -> float:
    """The same; CaseError unless it is finite and above 0."""
    if not (math.isfinite(value) and value > 0.0):
        raise CaseError(f"a viscosity is {value:g}; it must be a finite number above 0.")
    return value


def checked_smoothing(smoothing: str) -> str:
    """The same; CaseError for a name that is none."""
    if smoothing not in SMOOTHINGS:
        known = ", ".join(SMOOTHINGS)
        raise CaseError(f"smoothing is {smoothing!r}; it must be one of {known}.")
    return smoothing


@njit(inline="always")
def nearest(x, length):
    """x in the image that is nearest to 0."""
    return x - length * np.rint(x / length)


@njit
def distance(b, x, y, z, rotation, parts):
    """Painted signed distance of body b at (x, y, z) from its position, along the box's axes."""
    r = rotation[b]
    start, kind, size, place, turn, offset = parts
    return body_distance(
        r[0, 0] * x + r[1, 0] * y + r[2, 0] * z,
        r[0, 1] * x + r[1, 1] * y + r[2, 1] * z,
        r[0, 2] * x + r[1, 2] * y + r[2, 2] * z,
        start[b], start[b + 1], kind, size, place, turn, offset,
    )  # fmt: skip


@njit(parallel=True, cache=True, error_model="numpy")
def _paint(
    position, half, rotation, parts, value, points, lengths, layer, mode, cells, edges, mixture
):
    code, xi, half_width = layer
    px, py, pz = points
    wide = 0.0
    for p in points:
        wide += (p[0, 2] - p[0, 1]) ** 2
    wide = 0.5 * STEEPEST * math.sqrt(wide)
    for i in prange(1, px.shape[1] - 1):
        for b in range(position.shape[0]):
            xc = nearest(px[0, i] - position[b, 0], lengths[0])
            xf = nearest(px[1, i] - position[b, 0], lengths[0])
            if abs(xc) > half[b, 0] + wide:
                continue
            for j in range(1, py.shape[1] - 1):
                yc = nearest(py[0, j] - position[b, 1], lengths[1])
                yf = nearest(py[1, j] - position[b, 1], lengths[1])
                if abs(yc) > half[b, 1] + wide:
                    continue
                for k in range(1, pz.shape[1] - 1):
                    zc = nearest(pz[0, k] - position[b, 2], lengths[2])
                    zf = nearest(pz[1, k] - position[b, 2], lengths[2])
                    if abs(zc) > half[b, 2] + wide:
                        continue
                    d = distance(b, xc, yc, zc, rotation, parts)
                    if d > half_width * xi + wide:
                        continue
                    at = (i, j, k)
                    for e in range(3):
                        x, y, z = xc if e == 0 else xf, yc if e == 1 else yf, zc if e == 2 else zf
                        phi = level(code, distance(b, x, y, z, rotation, parts) / xi, half_width)
                        _mix(edges[e], at, phi, value[b], mode)
                    phi = level(code, d / xi, half_width)
                    _mix(cells, at, phi, value[b], mode)
                    if mode == TENSOR:
                        slope = _slopes(b, xc, yc, zc, d / xi, rotation, parts, layer)
                        _lay(mixture, at, phi, slope, value[b])


@njit(inline="always")
def _mix(field, at, phi, value, mode):
    if mode == ARITHMETIC:
        field[at] += phi * (value - field[at])
    else:
        field[at] = 1.0 / ((1.0 - phi) / field[at] + phi / value)


@njit
def _slopes(b, x, y, z, s, rotation, parts, layer):
    """∇φ up to the round-off of differences; 0 where φ is 0 or 1. s: the distance there, in ξ."""
    code, xi, half_width = layer
    if abs(s) > half_width:
        return 0.0, 0.0, 0.0
    h = STEP * xi
    gx = distance(b, x + h, y, z, rotation, parts) - distance(b, x - h, y, z, rotation, parts)
    gy = distance(b, x, y + h, z, rotation, parts) - distance(b, x, y - h, z, rotation, parts)
    gz = distance(b, x, y, z + h, rotation, parts) - distance(b, x, y, z - h, rotation, parts)
    # Within the layer only the direction counts where one body stands alone; where two meet, the
    # steeper one prevails.
    steep = (level(code, s + STEP, half_width) - level(code, s - STEP, half_width)) / (2.0 * h)
    scale = 0.5 * steep / h
    return scale * gx, scale * gy, scale * gz


@njit(inline="always")
def _lay(mixture, at, phi, slope, value):
    """∇μ_a ← (1 − φ)∇μ_a + (μ_b − μ_a)∇φ, and so μ_a and 1/μ_h."""
    i, j, k = at
    more = value - mixture[0, i, j, k]
    for c in range(3):
        mixture[2 + c, i, j, k] = (1.0 - phi) * mixture[2 + c, i, j, k] + more * slope[c]
    mixture[0, i, j, k] += phi * more
    mixture[1, i, j, k] += phi * (1.0 / value - mixture[1, i, j, k])
