"""Contact of bodies without inertia: a push is a speed, not a change of speed.

    dR/dt = V̄ + V̇(t − Δt/2) + w,   (1/M + Z) w = Σf,   Z w = Σ_j Z_ij n n·(w_i − w_j)
    M = 3/(6πμa),   Z_ij = 6πμa_r²(1/max(h, s/2) − 1/a_r)₊,   a_r = a_i a_j/(a_i + a_j)

The mobility that the fluid gives all bodies together is known but once a step, from a Stokes
solve; contact is too stiff for that, and in sub-steps has this one in its place, of lone bodies
that squeeze out the film between them. What it is not right in is made up for in the next step:

    V̄ⁿ⁺¹ = V(F + F̄) − w̄

V is what the Stokes solve gives under all loads, the mean F̄ of contact over the last step among
them, and w̄ is what contact moved in that step. Where contact does not change bodies move with V,
whatever M and Z are; where it does, gaps are those of the law of contact at all times, and F̄ comes
to what the true mobility asks for in a few steps. That converges where the true mobility is below
1.5 times the one above: M is thrice that of a lone body, for forces along a chain of n beads move
it 1.5(ln 2n − .8) times as fast as one.

A sub-step is explicit in the repulsion, as many as have kMδt ≤ ¼ of the stiffest pair, k = 2F₀/s,
and no pair closes by more than s/4 in one; lubrication is implicit; what would still pass through
another surface is stopped.
"""

import math

import numpy as np
from numba import njit

from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import Forms
from smoothprofile.particles.contact import Contact, ContactParameters
from smoothprofile.particles.contact_hits import (
    drag_apart_all,
    keep_within_walls,
    push_all,
    stop,
    stop_all,
)
from smoothprofile.particles.contact_sweep import (
    MassTable,
    drift,
    meet,
    place_parts,
    room_for,
    set_out,
    speed_up,
)

SHARE = 3.0
"""M over the mobility of a lone sphere."""
FILM_TOLERANCE, FILM_ITERATIONS = 1e-3, 60
STOPS = 3
"""More rounds, to and fro, of stopping what would pass: what stops a pair may set off the next."""


class CreepingContact(Contact):
    """Contact among given bodies in a given box; `angular` (n,) is 3/(8πμa³), M of turning."""

    def __init__(
        self,
        forms: Forms,
        grid: Grid,
        viscosity: float,
        free: np.ndarray,
        parameters: ContactParameters,
    ):
        """free: rows of the bodies that are; the others are not pushed. a: by their volume."""
        radius = np.cbrt(0.75 * forms.volume[free] / math.pi)
        linear, self.angular = np.zeros((2, forms.volume.size))
        linear[free] = SHARE / (6.0 * math.pi * viscosity * radius)
        self.angular[free] = SHARE / (8.0 * math.pi * viscosity * radius**3)
        turning = self.angular[:, None, None] * np.eye(3)
        super().__init__(forms, grid, linear, turning, parameters)
        self._viscosity = float(viscosity)

    def _stiffness(self, rate: np.ndarray, dt: float) -> np.ndarray:
        """kMΔt of each pair."""
        return dt * rate

    def _sweep(self, *arguments) -> tuple[int, float]:
        return creep(*arguments, self._viscosity)


@njit(cache=True)
def creep(
    first, count, dt, rows, start, built, slack, cutoff, parts, masses, box, law, course, s, mu
):
    """As `contact_sweep.sweep`, M/δt in place of 1/m and contact forgotten after each sub-step."""
    n, size, h = course.origin.shape[0], rows.shape[0], dt / count
    masses = MassTable(
        masses.inverse_mass / h, masses.inverse_inertia / h, masses.touch_force, masses.reach,
        masses.ball,
    )  # fmt: skip
    hits, film, work = room_for(size), np.empty(size), np.zeros((5, n, 3))
    least = np.inf
    for k in range(first, count):
        s.gain[:] = 0.0
        s.spin_gain[:] = 0.0
        fastest = set_out(k * h, dt, n, masses, course, s)
        if place_parts(parts, s, built) > slack and k > first:
            return k, least
        met = meet(rows, start, max(cutoff, 2.0 * fastest * h), parts, masses, box, s, hits)
        speed_up(0.5 * h, n, course, s)
        for c in range(met):
            least = min(least, hits.gap[c])
        push_all(met, h, hits, masses, box, law, s)
        _squeeze(met, h, hits, masses, law, s, mu, film, work)
        if law.viscosity > 0.0:
            drag_apart_all(met, h, hits, masses, box, law, s)
        stop_all(met, h, hits, masses, box, law, s)
        for sweep in range(STOPS):
            for c in range(met):
                stop(met - 1 - c if sweep % 2 == 0 else c, h, hits, masses, box, s)
        keep_within_walls(met, h, hits, masses, box, s)
        drift(h, n, s)
    return count + 1, least


@njit
def _squeeze(met, h, hits, masses, law, s, mu, film, work):
    """From MΣf to w in gain and velocity: (1/M + Z)w = (1/M)(MΣf), by conjugate gradients."""
    pushed = False
    for c in range(met):
        film[c] = _film(hits.gap[c], hits.radius[c, 0], hits.radius[c, 1], law.range, mu)
        pushed |= hits.gap[c] < law.range
    if not pushed:
        return
    n = s.gain.shape[0]
    w, r, z, p, q = work
    scale, total, product = np.zeros(n), 0.0, 0.0
    for b in range(n):
        drag = _drag(b, h, masses)
        scale[b] = drag
        for d in range(3):
            w[b, d], r[b, d] = 0.0, drag * s.gain[b, d]
    for c in range(met):
        for e in range(2):
            if hits.pair[c, e] >= 0:
                scale[hits.pair[c, e]] += film[c]
    for k in range(FILM_ITERATIONS + 1):
        before, product = product, 0.0
        for b in range(n):
            for d in range(3):
                # Of a body that is held nothing is sought.
                z[b, d] = r[b, d] / scale[b] if masses.inverse_mass[b] > 0.0 else 0.0
                product += z[b, d] * r[b, d]
        total = product if k == 0 else total
        if k == FILM_ITERATIONS or product <= FILM_TOLERANCE**2 * total:
            break
        curvature = 0.0
        for b in range(n):
            drag = _drag(b, h, masses)
            for d in range(3):
                p[b, d] = z[b, d] + (product / before * p[b, d] if k else 0.0)
                q[b, d] = drag * p[b, d]
        for c in range(met):
            _dashpot(hits.pair[c, 0], hits.pair[c, 1], hits.normal[c], film[c], p, q)
        for b in range(n):
            for d in range(3):
                curvature += p[b, d] * q[b, d]
        for b in range(n):
            for d in range(3):
                w[b, d] += product / curvature * p[b, d]
                r[b, d] -= product / curvature * q[b, d]
    for b in range(n):
        for d in range(3):
            s.velocity[b, d] += w[b, d] - s.gain[b, d]
            s.gain[b, d] = w[b, d]


@njit
def _drag(b, h, masses):
    """1/M, 0 of a body that is held."""
    return 1.0 / (h * masses.inverse_mass[b]) if masses.inverse_mass[b] > 0.0 else 0.0


@njit
def _film(gap, a, b, reach, mu):
    """Z of two spheres, or of one and a wall; 0 of other shapes."""
    if a == 0.0:
        return 0.0
    r = a if math.isinf(b) else a * b / (a + b)
    return 6.0 * math.pi * mu * r * r * max(1.0 / max(gap, 0.5 * reach) - 1.0 / r, 0.0)


@njit
def _dashpot(i, j, normal, resistance, p, q):
    """q += Z p of one pair."""
    along = 0.0
    for d in range(3):
        along += normal[d] * (p[i, d] - (p[j, d] if j >= 0 else 0.0))
    for d in range(3):
        q[i, d] += resistance * along * normal[d]
        if j >= 0:
            q[j, d] -= resistance * along * normal[d]
