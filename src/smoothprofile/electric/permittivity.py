"""The smoothed permittivity of many bodies on the staggered grid.

    arithmetic  ε_a = ε_fluid + Σ w_b (ε_b − ε_fluid)              on the faces
    harmonic    1/ε_h = 1/ε_fluid + Σ w_b (1/ε_b − 1/ε_fluid)      on the faces
    tensor      ε_h nnᵀ + ε_a (1 − nnᵀ),  n = ∇ε_a/|∇ε_a|:  ε_h on the faces, and
                q = √(ε_a − ε_h) n at the cell corners (see `operator`)

w_b = φ_b Π_{c later}(1 − φ_c): a later body lies over an earlier one. Across a layer the normal
component of D is continuous and along it the tangential ones of E, so that the tensor alone leaves
neither a spurious sheet of charge nor of current: its error is of second order in ξ.
Painting costs in proportion to the painted volume. At walls q loses the smaller of its parts along
and across the wall, as if the body were mirrored there.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np
from numba import njit, prange

from smoothprofile.boundaries import pressure_boundary
from smoothprofile.distances import MESH
from smoothprofile.electric.layers import STEP, distance, form_arrays, lay, level, normal
from smoothprofile.electric.layers import slope as profile_slope
from smoothprofile.electric.runs import corners_with_layer, no_runs, runs_of
from smoothprofile.electric.sphere_painting import ARITHMETIC as ARITHMETIC
from smoothprofile.electric.sphere_painting import TENSOR, cover, paint_sphere
from smoothprofile.electric.sphere_painting import place as place
from smoothprofile.electric.windows import Boxes, boxes_around
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState, Forms
from smoothprofile.particles.paint import Painter, wrap
from smoothprofile.particles.painting import STEEPEST
from smoothprofile.profiles import TANH, Profile

Smoothing = Literal["arithmetic", "harmonic", "tensor"]
SMOOTHINGS = ("arithmetic", "harmonic", "tensor")

TAIL = 1e-4
"""Relative jump of ε or 1/ε at which the tails of tanh are cut: it moves a force by 5e-5."""
GAP = 8
"""Corners without a layer between two runs that are worth two loops."""


class Permittivity:
    """ε on one grid: faces (3 padded fields), layers q (3 padded fields) and runs of its corners.

    version counts the paintings.
    """

    def __init__(
        self,
        grid: Grid,
        forms: Forms,
        permittivity: Sequence[float],
        fluid: float,
        profile: Profile,
        thickness: float,
        smoothing: Smoothing = "tensor",
    ):
        """permittivity[b] of each body, in the order of painting; CaseError unless all are > 0."""
        if smoothing not in SMOOTHINGS:
            raise CaseError(
                f"electric.smoothing is {smoothing!r}; it must be one of {', '.join(SMOOTHINGS)}."
            )
        if np.any(forms.kind >= MESH):
            raise CaseError("a triangulated surface cannot have a permittivity.")
        self.permittivity = np.array(permittivity, dtype=np.float64)
        self.fluid, self.smoothing = float(fluid), smoothing
        for value in (*self.permittivity, self.fluid):
            checked_permittivity(value)
        if self.permittivity.shape != (forms.part_start.size - 1,):
            raise CaseError("there must be one permittivity for each body.")
        self.grid, self.forms, self.thickness = grid, forms, thickness
        self.profile = _cut(profile, self.contrast)
        self.painter = Painter(grid, (pressure_boundary(grid),) * 3, forms, self.profile, thickness)
        self.points = tuple(np.stack([a.padded_centres, a.padded_faces]) for a in grid.axes)
        shape = grid.padded_shape
        self.faces = tuple(np.full(shape, self.fluid) for _ in range(3))
        self.layers = tuple(np.zeros(shape) for _ in range(3))
        self.runs = no_runs(shape)
        self.boxes: Boxes | None = None
        self.position = np.zeros((0, 3))
        self.form_arrays: tuple = ()
        self.version = 0

    @property
    def layer(self) -> tuple[int, float, float]:
        """Code of the profile, thickness ξ and half width in ξ, as the kernels take them."""
        return self.profile.code, self.thickness, self.profile.half_width

    @property
    def contrast(self) -> float:
        """Largest over smallest permittivity."""
        every = np.append(self.permittivity, self.fluid)
        return float(every.max() / every.min())

    @property
    def mode(self) -> int:
        return SMOOTHINGS.index(self.smoothing)

    def paint(self, state: BodyState, scratch: tuple[np.ndarray, np.ndarray]) -> None:
        """Bring ε to where the bodies are. scratch: two padded fields, overwritten."""
        rotation, self.position = state.rotation, state.position.copy()
        half = self.painter.half_sides(rotation)
        self.boxes = boxes_around(self.grid, state.position, half)
        self.form_arrays = form_arrays(self.forms, rotation, self.boxes, half, self.grid.lengths)
        above, below = scratch
        for field in self.faces:
            field[:] = self.fluid
        for field in self.layers:
            field[:] = 0.0
        above[:], below[:] = self.fluid, 1.0 / self.fluid
        boxes, periodic = self.boxes, np.array(self.grid.periodic)
        _paint(
            boxes.task, boxes.order, boxes.group, boxes.first, boxes.count, boxes.image,
            self.points, np.array(self.grid.lengths), periodic, state.position, self.permittivity,
            self.layer, self.form_arrays, self.mode, self.faces, self.layers, above, below,
        )  # fmt: skip
        if self.mode == TENSOR:
            _finish(self.layers, above, below, periodic)
        for field in (*self.faces, *self.layers):
            _repeat(field, periodic)
        self.version += 1
        self.runs = (
            runs_of(corners_with_layer(self.layers), GAP)
            if self.mode == TENSOR
            else no_runs(self.grid.padded_shape)
        )


def _cut(profile: Profile, contrast: float) -> Profile:
    """tanh without the tails in which neither ε nor 1/ε differs by more than TAIL."""
    if profile.code != TANH:
        return profile
    return replace(profile, half_width=min(profile.half_width, 0.5 * math.log(contrast / TAIL)))


def checked_permittivity(value: float) -> float:
    """The same; CaseError unless it is finite and above 0."""
    if not (value > 0.0 and math.isfinite(value)):
        raise CaseError(f"a permittivity is {value:g}; it must be a finite number above 0.")
    return value


@njit(parallel=True, cache=True, error_model="numpy")
def _paint(
    task, order, group, first, count, image, points, lengths, periodic, position, permittivity,
    layer, forms, mode, faces, layers, above, below,
):  # fmt: skip
    code, xi, half_width = layer
    px, py, pz = points
    nx, ny, nz = px.shape[1] - 2, py.shape[1] - 2, pz.shape[1] - 2
    # Across half the diagonal of the widest cell, d cannot change by more than this.
    wide = 0.0
    for axis in (px, py, pz):
        for m in range(1, axis.shape[1] - 1):
            wide = max(wide, 0.5 * STEEPEST * 1.7321 * (axis[1, m + 1] - axis[1, m]))
    for g in prange(group.size - 1):
        now = np.empty(5)
        for m in range(group[g], group[g + 1]):
            b, plane = task[order[m]]
            if forms[9][b] > 0.0 and forms[10][b] < math.inf:
                law = (code, xi, half_width, forms[9][b], permittivity[b], mode)
                paint_sphere(
                    b, plane, (first, count, image), points, lengths, periodic, position[b], law,
                    wide, faces, layers, above, below, now,
                )  # fmt: skip
                continue
            i0, j0, k0 = first[b, 0] + plane, first[b, 1], first[b, 2]
            gi = wrap(i0, nx) if periodic[0] else i0
            xf = place(px, 1, i0, image[b, 0], lengths[0], periodic[0]) - position[b, 0]
            xc = place(px, 0, i0, image[b, 0], lengths[0], periodic[0]) - position[b, 0]
            for j in range(j0, j0 + count[b, 1]):
                gj = wrap(j, ny) if periodic[1] else j
                yf = place(py, 1, j, image[b, 1], lengths[1], periodic[1]) - position[b, 1]
                yc = place(py, 0, j, image[b, 1], lengths[1], periodic[1]) - position[b, 1]
                for k in range(k0, k0 + count[b, 2]):
                    gk = wrap(k, nz) if periodic[2] else k
                    zf = place(pz, 1, k, image[b, 2], lengths[2], periodic[2]) - position[b, 2]
                    zc = place(pz, 0, k, image[b, 2], lengths[2], periodic[2]) - position[b, 2]
                    d = distance(b, xf, yf, zf, forms)
                    if d > half_width * xi + wide:
                        continue
                    at = (gi, gj, gk)
                    if d < -(half_width * xi + wide):
                        cover(faces, layers, above, below, at, permittivity[b])
                        continue
                    _face(faces[0], at, b, xf, yc, zc, permittivity[b], mode, layer, forms)
                    _face(faces[1], at, b, xc, yf, zc, permittivity[b], mode, layer, forms)
                    _face(faces[2], at, b, xc, yc, zf, permittivity[b], mode, layer, forms)
                    if mode == TENSOR:
                        s = d / xi
                        phi = level(code, s, half_width)
                        gx, gy, gz = 0.0, 0.0, 0.0
                        if abs(s) <= half_width:
                            steep = profile_slope(code, s) / xi
                            gx, gy, gz = normal(b, xf, yf, zf, STEP * xi, forms)
                            gx, gy, gz = steep * gx, steep * gy, steep * gz
                        now[0], now[1] = above[at], below[at]
                        now[2], now[3], now[4] = layers[0][at], layers[1][at], layers[2][at]
                        more = permittivity[b] - now[0]
                        lay(now, phi, gx, gy, gz, more, 1.0 / permittivity[b] - now[1])
                        above[at], below[at] = now[0], now[1]
                        layers[0][at], layers[1][at], layers[2][at] = now[2], now[3], now[4]


@njit(inline="always")
def _face(face, at, b, x, y, z, value, mode, layer, forms):
    code, xi, half_width = layer
    phi = level(code, distance(b, x, y, z, forms) / xi, half_width)
    if mode == ARITHMETIC:
        face[at] += phi * (value - face[at])
    else:
        face[at] = 1.0 / ((1.0 - phi) / face[at] + phi / value)


@njit(parallel=True, cache=True, error_model="numpy")
def _finish(layers, above, below, periodic):
    """∇ε_a becomes q = √(ε_a − ε_h) ∇ε_a/|∇ε_a|."""
    qx, qy, qz = layers
    nx, ny, nz = qx.shape
    for i in prange(1, nx):
        for j in range(1, ny):
            for k in range(1, nz):
                x, y, z = qx[i, j, k], qy[i, j, k], qz[i, j, k]
                if x == 0.0 and y == 0.0 and z == 0.0:
                    continue
                if not periodic[0] and (i == 1 or i == nx - 1):
                    x, y, z = _split(x, y, z)
                if not periodic[1] and (j == 1 or j == ny - 1):
                    y, z, x = _split(y, z, x)
                if not periodic[2] and (k == 1 or k == nz - 1):
                    z, x, y = _split(z, x, y)
                excess = max(above[i, j, k] - 1.0 / below[i, j, k], 0.0)
                size = math.sqrt(x * x + y * y + z * z)
                scale = math.sqrt(excess) / size if size > 0.0 else 0.0
                qx[i, j, k], qy[i, j, k], qz[i, j, k] = scale * x, scale * y, scale * z


@njit(inline="always")
def _split(across, u, v):
    """Keep the part across the wall, or that along it."""
    if across * across > u * u + v * v:
        return across, 0.0, 0.0
    return 0.0, u, v


@njit(cache=True)
def _repeat(f, periodic):
    """The last face or corner of a periodic axis is its first."""
    if periodic[2]:
        f[:, :, -1] = f[:, :, 1]
    if periodic[1]:
        f[:, -1] = f[:, 1]
    if periodic[0]:
        f[-1] = f[1]
