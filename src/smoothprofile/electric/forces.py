"""Forces, torques and dipole moments of the bodies, from the discrete energy itself.

    F = +∂W/∂X|_ψ,   T = +∂W/∂θ|_ψ,   p = ∫(D − ε_fluid E) dV

W = ½∫E·εE dV is least with respect to ψ, so that only ε depends on where a body is. Whoever holds
the mean field, or the electrodes' potentials, does twice the work that W gains: what falls is
Ω = −W, so that F = −dΩ/dX, for both drives alike, and for a scalar ε F = −½∫E²∇ε dV. A body's ε
moves and turns with it: δφ = −δX·∇φ − (δθ×r)·∇φ, and likewise for ∇φ, which also turns.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit, prange

from smoothprofile.electric.crowded_spheres import MOST_RIVALS, OF_RIVAL, rivals
from smoothprofile.electric.layers import (
    SHARP,
    STEP,
    VANISHING,
    WORK,
    bent,
    distance,
    normal,
    stack,
)
from smoothprofile.electric.layers import slope as profile_slope
from smoothprofile.electric.lone_spheres import margin, sphere_loads
from smoothprofile.electric.operator import Geometry, corner_field
from smoothprofile.electric.permittivity import ARITHMETIC, TENSOR, Permittivity, place
from smoothprofile.particles.bodies import BodyState
from smoothprofile.particles.paint import wrap
from smoothprofile.particles.painting import STEEPEST


@dataclass(frozen=True, eq=False)
class BodyLoads:
    """force (n,3), torque (n,3) about each body's position, dipole (n,3); along the box's axes.

    weight (n,) is ∫|force density| dV, the size of what cancels in the force.
    """

    force: np.ndarray
    torque: np.ndarray
    dipole: np.ndarray
    weight: np.ndarray

    def balanced(self, periodic: tuple[bool, bool, bool]) -> "BodyLoads":
        """The same with no net force along periodic axes, where an exact field exerts none.

        The grid exerts a small one, the derivative of W by a common shift of all bodies; it is
        shared out by weight. Forces are then the derivative of W to discretisation error only.
        """
        total = np.where(periodic, self.force.sum(axis=0), 0.0)
        share = self.weight / self.weight.sum() if self.weight.sum() > 0 else self.weight
        return BodyLoads(self.force - share[:, None] * total, self.torque, self.dipole, self.weight)


def body_loads(
    medium: Permittivity, state: BodyState, potential: np.ndarray, field, geometry: Geometry
) -> BodyLoads:
    """Loads in the field E = field − ∇ψ; ψ with filled ghosts, of the painted state.

    Not exact for bodies whose layer reaches a wall: there the mixture is mirrored.
    """
    boxes = medium.boxes
    sums = np.zeros((boxes.task.shape[0], 10))
    where = (
        boxes.task, boxes.first, boxes.count, boxes.image, boxes.meets, medium.points,
        np.array(medium.grid.lengths), np.array(medium.grid.periodic), state.position,
        medium.permittivity, medium.fluid, medium.layer,
    )  # fmt: skip
    what = (
        medium.mode, medium.faces, medium.layers, potential, np.asarray(field, dtype=np.float64),
        geometry.widths, geometry.distances, geometry.share, sums,
    )  # fmt: skip
    ball, outer = medium.form_arrays[9:]
    sphere_loads(*where, ball, outer, *what)
    _loads(*where, medium.form_arrays, *what)
    total = np.zeros((state.count, 10))
    np.add.at(total, boxes.task[:, 0], sums)
    return BodyLoads(total[:, 0:3], total[:, 3:6], total[:, 6:9], total[:, 9])


@njit(parallel=True, cache=True, error_model="numpy")
def _loads(
    task, first, count, image, meets, points, lengths, periodic, position, permittivity, fluid,
    layer, forms, mode, faces, layers, psi, e0, w, d, share, sums,
):  # fmt: skip
    px, py, pz = points
    nx, ny, nz = psi.shape[0] - 2, psi.shape[1] - 2, psi.shape[2] - 2
    pad = margin(points)
    for t in prange(task.shape[0]):
        b, plane = task[t]
        now, spot, total = np.empty(WORK), np.empty(3), sums[t]
        found = np.empty((MOST_RIVALS, OF_RIVAL))
        ball = forms[9][b] > 0.0 and forms[10][b] < np.inf
        mixture = (meets, position, permittivity, fluid, layer, forms)
        i, p = first[b, 0] + plane, np.empty((2, 3))
        gi = wrap(i, nx) if periodic[0] else i
        for f in range(2):
            p[f, 0] = place(px, f, i, image[b, 0], lengths[0], periodic[0]) - position[b, 0]
        for j in range(first[b, 1], first[b, 1] + count[b, 1]):
            gj = wrap(j, ny) if periodic[1] else j
            for f in range(2):
                p[f, 1] = place(py, f, j, image[b, 1], lengths[1], periodic[1]) - position[b, 1]
            reach = (p[1, 0], p[1, 1], pad, meets, position, permittivity, forms[9], forms[10])
            if ball and rivals(b, *reach, found) >= 0:
                continue
            for k in range(first[b, 2], first[b, 2] + count[b, 2]):
                gk = wrap(k, nz) if periodic[2] else k
                for f in range(2):
                    p[f, 2] = place(pz, f, k, image[b, 2], lengths[2], periodic[2])
                    p[f, 2] -= position[b, 2]
                at = (gi, gj, gk)
                wide = STEEPEST * (abs(d[0][gi]) + abs(d[1][gj]) + abs(d[2][gk]))
                near = distance(b, p[1, 0], p[1, 1], p[1, 2], forms)
                if near > layer[2] * layer[1] + wide:
                    continue
                for c in range(3):
                    outside = (gi > nx and c != 0) or (gj > ny and c != 1) or (gk > nz and c != 2)
                    if outside:
                        continue
                    for a in range(3):
                        spot[a] = p[int(a == c), a]
                    _face_loads(c, at, b, spot, mixture, mode, faces[c], psi, e0, w, d, share,
                                now, total)  # fmt: skip
                if mode == TENSOR:
                    spot[:] = p[1]
                    _corner_loads(at, b, spot, mixture, layers, psi, e0, d, share, now, total)


@njit
def _face_loads(c, at, b, spot, mixture, mode, face, psi, e0, w, d, share, now, total):
    meets, position, permittivity, fluid, layer, forms = mixture
    i, j, k = at
    x, y, z = spot[0], spot[1], spot[2]
    if c == 0:
        field = e0[0] - (psi[i, j, k] - psi[i - 1, j, k]) / d[0][i]
        volume = share[0][i] * w[1][j] * w[2][k]
    elif c == 1:
        field = e0[1] - (psi[i, j, k] - psi[i, j - 1, k]) / d[1][j]
        volume = w[0][i] * share[1][j] * w[2][k]
    else:
        field = e0[2] - (psi[i, j, k] - psi[i, j, k - 1]) / d[2][k]
        volume = w[0][i] * w[1][j] * share[2][k]
    s = distance(b, x, y, z, forms) / layer[1]
    if s > layer[2]:
        return
    stack(b, x, y, z, meets, position, permittivity, fluid, layer, forms, now)
    total[6 + c] += volume * now[11] * (face[i, j, k] - fluid) * field
    if s < -layer[2]:
        return
    rate = now[5] if mode == ARITHMETIC else -now[6] / (now[1] * now[1])
    strength = -0.5 * volume * field * field * rate * profile_slope(layer[0], s) / layer[1]
    gx, gy, gz = normal(b, x, y, z, STEP * layer[1], forms)
    _push(total, x, y, z, strength * gx, strength * gy, strength * gz)


@njit
def _corner_loads(at, b, spot, mixture, layers, psi, e0, d, share, now, total):
    meets, position, permittivity, fluid, layer, forms = mixture
    code, xi, half_width = layer
    i, j, k = at
    x, y, z = spot[0], spot[1], spot[2]
    u, v, q = layers[0][i, j, k], layers[1][i, j, k], layers[2][i, j, k]
    if u == 0.0 and v == 0.0 and q == 0.0:
        return
    s = distance(b, x, y, z, forms) / xi
    if s > half_width:
        return
    ex, ey, ez = corner_field(psi, e0, d, i, j, k)
    volume = share[0][i] * share[1][j] * share[2][k]
    stack(b, x, y, z, meets, position, permittivity, fluid, layer, forms, now)
    size, along = u * u + v * v + q * q, u * ex + v * ey + q * ez
    total[6] += volume * now[11] * (size * ex - along * u)
    total[7] += volume * now[11] * (size * ey - along * v)
    total[8] += volume * now[11] * (size * ez - along * q)
    steep = np.sqrt(now[2] * now[2] + now[3] * now[3] + now[4] * now[4])
    first = profile_slope(code, s) / xi
    if s < -half_width or steep <= VANISHING * abs(now[10] * first):
        return
    # ½V δ(|Ē|² − (n·Ē)²) by δ = ε_a − ε_h, and by n = ∇ε_a/|∇ε_a|.
    nx, ny, nz = now[2] / steep, now[3] / steep, now[4] / steep
    ne = nx * ex + ny * ey + nz * ez
    tx, ty, tz = ex - ne * nx, ey - ne * ny, ez - ne * nz
    rate = now[5] + now[6] / (now[1] * now[1])
    alpha = 0.5 * volume * (tx * tx + ty * ty + tz * tz) * rate
    turn = -volume * max(now[0] - 1.0 / now[1], 0.0) * ne / steep
    alpha += turn * (tx * now[7] + ty * now[8] + tz * now[9])
    bx, by, bz = turn * now[10] * tx, turn * now[10] * ty, turn * now[10] * tz
    # δφ and δ∇φ of a moving body: −∇φ and −∇∇φ, ∇∇φ = φ″nn + φ′∇∇d.
    mx, my, mz = normal(b, x, y, z, STEP * xi, forms)
    second = (profile_slope(code, s + STEP) - profile_slope(code, s - STEP)) / (2.0 * STEP * xi**2)
    hx, hy, hz = bent(b, x, y, z, bx, by, bz, STEP * xi, forms)
    if np.sqrt(hx * hx + hy * hy + hz * hz) * xi > SHARP * np.sqrt(bx * bx + by * by + bz * bz):
        hx, hy, hz = 0.0, 0.0, 0.0
    both = second * (mx * bx + my * by + mz * bz) + alpha * first
    fx, fy, fz = both * mx + first * hx, both * my + first * hy, both * mz + first * hz
    _push(total, x, y, z, -fx, -fy, -fz)
    total[3] += first * (my * bz - mz * by)
    total[4] += first * (mz * bx - mx * bz)
    total[5] += first * (mx * by - my * bx)


@njit(inline="always")
def _push(total, x, y, z, fx, fy, fz):
    """A force at a point, its torque, and its size."""
    total[0] += fx
    total[1] += fy
    total[2] += fz
    total[3] += y * fz - z * fy
    total[4] += z * fx - x * fz
    total[5] += x * fy - y * fx
    total[9] += np.sqrt(fx * fx + fy * fy + fz * fz)
