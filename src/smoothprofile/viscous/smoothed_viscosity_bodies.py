"""Forces on bodies of smoothed viscosity, and the motion that answers.

    f = w Σ_m c_m m,   c = G⁻¹(F, T),   (V, Ω) = G⁻¹ ∫w m·u dV,   G_mn = ∫w m·n dV

w is φ, or with harmonic smoothing, where half of a layer is as soft as the fluid, the part
φ/(φ + R(1−φ)) of what makes the body stiff. m are the six rigid motions of a body about its
position. The total force and torque of f are F and T to round-off, its power ∫f·u dV F·V + T·Ω.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.painting import level
from smoothprofile.solvers.krylov import SolveReport
from smoothprofile.viscous.direct import Vector
from smoothprofile.viscous.smoothed_viscosity import SmoothedStokes
from smoothprofile.viscous.tensor_viscosity import SmoothedViscosity, distance, nearest

GRAM, GATHER, SPREAD = range(3)


@dataclass(frozen=True, eq=False)
class Motion:
    """V (n,3) and Ω (n,3), in a frame where the volume mean of velocity is 0."""

    velocity: np.ndarray
    angular_velocity: np.ndarray
    report: SolveReport


def mobility(
    solver: SmoothedStokes,
    medium: SmoothedViscosity,
    state: BodyState,
    force: np.ndarray,
    torque: np.ndarray | None = None,
    tolerance: float = 1e-4,
    limit: int = 5000,
) -> Motion:
    """What bodies do under given forces (n,3) and torques (n,3) in a fluid that is not sheared.

    `medium` must be painted with that state. Minus the sum of the forces is borne by a mean
    pressure gradient.
    """
    loads = np.zeros((state.count, 6))
    loads[:, :3] = force
    if torque is not None:
        loads[:, 3:] = torque
    density = tuple(solver.grid.zeros() for _ in range(3))
    gram = _sums(medium, state, solver.velocity, GRAM)
    weights = np.linalg.solve(gram, loads[:, :, None])[:, :, 0]
    _spread(*_arguments(medium, state), weights, density)
    report = solver.solve(medium, density, None, tolerance, limit)
    means = _sums(medium, state, solver.velocity, GATHER)[:, 0]
    motion = np.linalg.solve(gram, means[:, :, None])[:, :, 0]
    return Motion(motion[:, :3], motion[:, 3:], report)


def _arguments(medium: SmoothedViscosity, state: BodyState) -> tuple:
    grid = medium.grid
    low = np.array([axis.low for axis in grid.axes])
    widths = np.array([float(axis.widths[0]) for axis in grid.axes])
    stiff = np.ones(state.count)
    if medium.smoothing == "harmonic":
        stiff = np.maximum(medium.viscosity / medium.fluid, 1.0)
    return *medium.bodies(state), stiff, medium.layer, low, widths, np.array(grid.shape)


def _sums(medium: SmoothedViscosity, state: BodyState, velocity: Vector, mode: int) -> np.ndarray:
    """GRAM: ∫w m·n dV (n,6,6). GATHER: ∫w m·u dV in the first row of each."""
    out = np.zeros((state.count, 6, 6))
    _integrate(*_arguments(medium, state), mode, velocity, out)
    return out * np.prod([float(axis.widths[0]) for axis in medium.grid.axes])


@njit(inline="always")
def _modes(c, x, y, z, out):
    """Component c of the six rigid motions at (x, y, z)."""
    out[:] = 0.0
    out[c] = 1.0
    if c == 0:
        out[4], out[5] = z, -y
    elif c == 1:
        out[3], out[5] = -z, x
    else:
        out[3], out[4] = y, -x


@njit(inline="always")
def _range(centre, half, low, width, cells):
    """First index, counted from 0, and number of cells along an axis that may be painted."""
    first = int(np.floor((centre - half - low) / width)) - 1 if half < 1e300 else 0
    count = int(min(2.0 * half / width + 4.0, cells))
    return first, count


@njit(parallel=True, cache=True)
def _integrate(
    position, half, rotation, parts, stiff, layer, low, widths, cells, mode, velocity, out
):
    code, xi, half_width = layer
    for b in prange(position.shape[0]):
        m, sums = np.zeros(6), np.zeros((6, 6))
        i0, ni = _range(position[b, 0], half[b, 0], low[0], widths[0], cells[0])
        j0, nj = _range(position[b, 1], half[b, 1], low[1], widths[1], cells[1])
        k0, nk = _range(position[b, 2], half[b, 2], low[2], widths[2], cells[2])
        for c in range(3):
            u = velocity[c]
            for i in range(i0, i0 + ni):
                x = _from(i, 0, c, low, widths, cells, position[b])
                for j in range(j0, j0 + nj):
                    y = _from(j, 1, c, low, widths, cells, position[b])
                    for k in range(k0, k0 + nk):
                        z = _from(k, 2, c, low, widths, cells, position[b])
                        phi = level(code, distance(b, x, y, z, rotation, parts) / xi, half_width)
                        if phi == 0.0:
                            continue
                        weight = phi / (phi + stiff[b] * (1.0 - phi))
                        _modes(c, x, y, z, m)
                        if mode == GRAM:
                            for p in range(6):
                                for q in range(6):
                                    sums[p, q] += weight * m[p] * m[q]
                        else:
                            here = u[i % cells[0] + 1, j % cells[1] + 1, k % cells[2] + 1]
                            for p in range(6):
                                sums[0, p] += weight * m[p] * here
        out[b] = sums


@njit(inline="always")
def _from(index, axis, component, low, widths, cells, centre):
    """Coordinate of a point of velocity `component`, from the image of the body next to it."""
    shift = 0.0 if axis == component else 0.5
    x = low[axis] + (index + shift) * widths[axis] - centre[axis]
    return nearest(x, widths[axis] * cells[axis])


@njit(parallel=True, cache=True)
def _spread(position, half, rotation, parts, stiff, layer, low, widths, cells, weights, out):
    """Σ_b w_b Σ_m c_m m, body after body on each plane."""
    code, xi, half_width = layer
    for i in prange(cells[0]):
        m = np.zeros(6)
        for b in range(position.shape[0]):
            i0, ni = _range(position[b, 0], half[b, 0], low[0], widths[0], cells[0])
            if (i - i0) % cells[0] >= ni:
                continue
            j0, nj = _range(position[b, 1], half[b, 1], low[1], widths[1], cells[1])
            k0, nk = _range(position[b, 2], half[b, 2], low[2], widths[2], cells[2])
            for c in range(3):
                x = _from(i, 0, c, low, widths, cells, position[b])
                for j in range(j0, j0 + nj):
                    y = _from(j, 1, c, low, widths, cells, position[b])
                    for k in range(k0, k0 + nk):
                        z = _from(k, 2, c, low, widths, cells, position[b])
                        phi = level(code, distance(b, x, y, z, rotation, parts) / xi, half_width)
                        if phi == 0.0:
                            continue
                        weight = phi / (phi + stiff[b] * (1.0 - phi))
                        _modes(c, x, y, z, m)
                        total = 0.0
                        for p in range(6):
                            total += weights[b, p] * m[p]
                        out[c][i + 1, j % cells[1] + 1, k % cells[2] + 1] += weight * total
