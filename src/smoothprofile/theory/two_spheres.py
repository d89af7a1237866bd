"""Two equal spheres: the electric force between dielectric ones, the mobility of those in a fluid.

    ∇²V = 0, ε∂V/∂n continuous,   F = ½ ∂(P·E₀)/∂d        P the dipole moment of both
    μ∇²u = ∇p, ∇·u = 0, u = V + Ω×r,   6πμaV = b F         no torque

Both by multipoles about the two centres. Potentials have closed formulas of translation; flows,
Lamb's solution, are matched to rigid motion at points of the surface. A mirror between the
spheres halves the unknowns. Lengths are in radii, the line of centres is z, and x is across it.

Lamb, *Hydrodynamics*, art. 335; Kim & Karrila, *Microhydrodynamics* (1991), ch. 4 and 12.
"""

import math
from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.integrate import solve_ivp
from scipy.special import gammaln

Direction = Literal["along", "across"]
DIRECTIONS = ("along", "across")
CLOSEST = 0.01
"""Least gap between the surfaces, in radii, at which the series are still affordable."""
DIGITS = 16.0
"""Of the multipoles that are left out."""


def pair_dipole(
    distance: float, ratio: float, direction: Direction = "along"
) -> tuple[float, float]:
    """p/(4πεa³E₀) of each of two spheres, and its derivative by distance/a.

        A_l = β_l (δ_l1 ± Σ_n T_ln A_n),   β_l = l(R−1)/(l(R+1)+1)
        T_ln = (n+l)!/((n−m)!(l+m)!) d^−(n+l+1)

    + and m = 0 with the field along the line of centres, − and m = 1 across it. distance: d, of
    the centres in radii; ratio: R, of the spheres' permittivity to the fluid's, may be infinite.
    ValueError for spheres closer than `CLOSEST`, and for a ratio that is not above 0.
    """
    d, count = _distance(distance), _terms(distance)
    if not ratio > 0.0:
        raise ValueError(f"the ratio of permittivities is {ratio:g}; it must be above 0.")
    m = _order(direction)
    l = np.arange(1, count + 1, dtype=np.float64)
    beta = np.ones(count) if math.isinf(ratio) else l * (ratio - 1) / (l * (ratio + 1) + 1)
    n = l[None, :]
    rows = l[:, None]
    # Both sides are scaled by √((l+m)!/(l−m)!), which makes T symmetric and keeps it in range.
    logs = gammaln(n + rows + 1) - 0.5 * sum(gammaln(k + s + 1) for k in (n, rows) for s in (m, -m))
    translation = np.exp(logs - (n + rows + 1) * math.log(d))
    sign = 1.0 if m == 0 else -1.0
    system = np.eye(count) - sign * beta[:, None] * translation
    first = np.zeros(count)
    first[0] = beta[0]
    moments = np.linalg.solve(system, first)
    change = -(n + rows + 1) / d * translation
    slope = np.linalg.solve(system, sign * beta * (change @ moments))
    return float(moments[0]), float(slope[0])


def pair_force(distance: float, ratio: float, angle: float = 0.0) -> tuple[float, float]:
    """Radial and angular force on one of two spheres, over εa²E₀²; radially + is repulsion.

        F_d = 4π(A_∥′ cos²θ + A_⊥′ sin²θ),   F_θ = −(4π/d)(A_∥ − A_⊥) sin 2θ

    A: dipole moments of `pair_dipole`, which the rest of the arguments are as in; angle: θ in
    radians from the field to the line of centres. F_θ < 0 turns the line into the field.
    """
    along, across = (pair_dipole(distance, ratio, direction) for direction in DIRECTIONS)
    c, s = math.cos(angle), math.sin(angle)
    radial = 4.0 * math.pi * (along[1] * c**2 + across[1] * s**2)
    return radial, -4.0 * math.pi / distance * (along[0] - across[0]) * 2.0 * s * c


def pair_mobility(distance: float, direction: Direction = "along", opposite: bool = False) -> float:
    """b = 6πμaV/F of each of two free spheres pulled by equal or by opposite forces, no torque.

        u = Σ_n ∇×(rχ_n) + ∇Φ_n − (n−2)/(2n(2n−1)) r²∇p_n + (n+1)/(n(2n−1)) r p_n    and its mirror

    p, Φ, χ = r^−(n+1) P_n^m(cos θ) cos φ or sin φ about the centre of each, μ = 1; p₁ is the
    force, 4πp₁ = F, χ₁ = 0 the torque. The rest and the motion are those of least squares at
    points of the surface, to round-off. Arguments as in `pair_dipole`.
    """
    d, count, m = _distance(distance), _terms(distance), _order(direction)
    sign = -1.0 if opposite else 1.0
    # Of forces along the line it is the equal ones that the mirror turns round.
    mirror = sign if m else -sign
    c, weights = leggauss(2 * count)
    s = np.sqrt(1.0 - c * c)
    own = _lamb(s, c, count, m)
    # The second centre lies at +d; its fields are those of the first, seen in the mirror.
    other = _lamb(s, d - c, count, m) * np.array([1.0, -1.0, 1.0])[:, None, None] * mirror
    fields = own + other
    zero, one = np.zeros_like(c), np.ones_like(c)
    motion = [(one, zero, -one), (c, -s, -c)] if m else [(zero, one, zero)]
    rigid = np.stack([np.stack(part) for part in motion], axis=2)
    # Rows: components at the points. Columns: rigid motion, then Lamb's terms but p₁ and χ₁.
    kept = np.ones(fields.shape[2], dtype=bool)
    kept[0] = False
    if m:
        kept[2 * count] = False
    columns = np.concatenate([rigid, -fields[:, :, kept]], axis=2)
    scale = np.tile(np.sqrt(weights), 3)
    matrix = scale[:, None] * columns.reshape(-1, columns.shape[2])
    right = scale * 1.5 * fields[:, :, 0].reshape(-1)
    size = np.linalg.norm(matrix, axis=0)
    found = np.linalg.lstsq(matrix / size, right, rcond=None)[0] / size
    return float(found[0])


def approach(
    start: float, end: float, force: Callable[[float], float], mobility: Callable[[float], float]
) -> tuple[np.ndarray, np.ndarray]:
    """Times and distances of two free spheres that attract each other, without inertia.

        dd/dt = 2 b(d) F(d)/(6π)

    distances in radii, 101 evenly spaced from start down to end; force: distance -> F/(εa²E₀²),
    mobility: distance -> b; times in μ/(εE₀²).
    """
    distances = np.linspace(start, end, 101)

    def pace(distance, _):
        return [3.0 * math.pi / (mobility(distance) * force(distance))]

    found = solve_ivp(pace, (start, end), [0.0], t_eval=distances, rtol=1e-8, method="DOP853")
    return found.y[0], distances


def _lamb(rho: np.ndarray, z: np.ndarray, count: int, m: int) -> np.ndarray:
    """(3, points, terms): u_ρ, u_z over cos mφ and u_φ over sin mφ of Lamb's terms p, Φ (and χ)."""
    r = np.hypot(rho, z)
    c, s = z / r, rho / r
    n = np.arange(1, count + 1)
    level, slope = _legendre(c, count)
    r, cc, ss = r[:, None], c[:, None], s[:, None]
    # y = P_n^m, its derivative by θ, and m y/sin θ.
    if m:
        y, turn, side = ss * slope, n * (n + 1) * level - cc * slope, slope
    else:
        y, turn, side = level, -ss * slope, np.zeros_like(level)
    down = r ** -(n + 1.0)
    gradient = np.stack([-(n + 1) * y, turn, -side]) * down / r
    outward = np.zeros_like(gradient)
    outward[0] = r * down * y
    pressure = (
        -(n - 2) / (2 * n * (2 * n - 1)) * r**2 * gradient + (n + 1) / (n * (2 * n - 1)) * outward
    )
    terms = [pressure, gradient]
    if m:
        terms.append(np.stack([np.zeros_like(y), side * down, -turn * down]))
    radial, polar, azimuthal = np.concatenate(terms, axis=2)
    return np.stack([ss * radial + cc * polar, cc * radial - ss * polar, azimuthal])


def _legendre(c: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """P_n(c) and P_n′(c), (points, count), n from 1."""
    level = np.ones((c.size, count + 1))
    slope = np.zeros_like(level)
    level[:, 1], slope[:, 1] = c, 1.0
    for n in range(1, count):
        level[:, n + 1] = ((2 * n + 1) * c * level[:, n] - n * level[:, n - 1]) / (n + 1)
        slope[:, n + 1] = slope[:, n - 1] + (2 * n + 1) * level[:, n]
    return level[:, 1:], slope[:, 1:]


def _terms(distance: float) -> int:
    """Multipoles fall off as e^(−nα), cosh α = d/2: the images of a centre end at that depth."""
    return max(8, math.ceil(DIGITS * math.log(10.0) / math.acosh(0.5 * distance)) + 4)


def _distance(distance: float) -> float:
    if not (math.isfinite(distance) and distance >= 2.0 + CLOSEST):
        raise ValueError(
            f"the centres are {distance:g} radii apart; it must be at least {2.0 + CLOSEST:g}."
        )
    return distance


def _order(direction: str) -> int:
    if direction not in DIRECTIONS:
        raise ValueError(f"direction is {direction!r}; it must be one of {', '.join(DIRECTIONS)}.")
    return DIRECTIONS.index(direction)
