"""Two equal spheres in each cell of a periodic cube: what their images do to force and mobility.

    p = α(d)(E₀ + G(d)p),   F = ∂(p·E₀)/∂d = (α′ + α²G′)/(1 − αG)² E₀²
    b = b_∞ + 6πμa (g(0) − g(d))                              opposite forces along the line

α is the exact polarisability of each of the two alone, G the field along z that the images' dipoles
make at either centre, g the flow along z that the images of a point force make at it and at its
partner. Images are points, and what they make is taken as uniform over a sphere: at L = 8a that
leaves .1 % (R = 2) and .3 % (R = 10) of the force.
Lengths are in radii, ε = μ = 1. Sums by P. P. Ewald; H. Hasimoto, J. Fluid Mech. 5 (1959).
"""

import math

import numpy as np
from scipy.special import erf, erfc

from smoothprofile.theory.two_spheres import pair_dipole, pair_mobility

REACH = 4
"""Images and waves either way: e^{−πn²} of the next ones is 1e-34."""
STEP = 1e-3


def periodic_pair_force(distance: float, ratio: float, side: float) -> float:
    """Force on one of two spheres along the field, over εa²E₀²; + is repulsion.

    distance, side: of the centres and of the cube, in radii; ratio as in `pair_dipole`.
    """
    moment, slope = (4.0 * math.pi * part for part in pair_dipole(distance, ratio))
    ends = [image_field(distance + step, side) for step in (-STEP, STEP)]
    change = (ends[1] - ends[0]) / (2.0 * STEP)
    return (slope + moment**2 * change) / (1.0 - moment * image_field(distance, side)) ** 2


def periodic_pair_mobility(distance: float, side: float) -> float:
    """b of two spheres that opposite forces pull along the line of centres, as `pair_mobility`.

    Images act as point forces. What the pair's own stresslets answer to their strain, of order
    (a/L)³, is left out: at 3a in L = 12a that leaves b 2 % high.
    """
    change = image_flow(0.0, side) - image_flow(distance, side)
    return pair_mobility(distance, opposite=True) + 6.0 * math.pi * change


def image_field(distance: float, side: float) -> float:
    """Field along z at one of two unit dipoles along z, of the images of both; mean field zero."""
    return _dipoles(0.0, side) + _dipoles(distance, side)


def image_flow(distance: float, side: float) -> float:
    """Velocity along z, `distance` up the z axis from a unit force, of the images of that force.

    No mean velocity; what balances the force is uniform.
    """
    alpha = math.sqrt(math.pi) / side
    z, r, kz, k2 = _lattice(distance, side)
    e, slope = erfc(alpha * r), -2.0 * alpha / math.sqrt(math.pi) * np.exp(-((alpha * r) ** 2))
    square = (z / r) ** 2
    # (∇² − ∂_z²) of r erfc αr.
    near = (2.0 * slope - 2.0 * (alpha * r) ** 2 * slope) * (1.0 - square)
    near += (e / r + slope) * (1.0 + square)
    own = -8.0 * alpha / math.sqrt(math.pi)
    if distance > 0.0:
        s = -2.0 * alpha / math.sqrt(math.pi) * math.exp(-((alpha * distance) ** 2))
        own = 2.0 * (s - erf(alpha * distance) / distance)
    q = k2 / (4.0 * alpha**2)
    far = (1.0 - kz**2 / k2) * (1.0 + q + 2.0 * q**2) * np.exp(-q) / k2 * np.cos(kz * distance)
    return float((near.sum() + own) / (8.0 * math.pi) + far.sum() / side**3)


def _dipoles(distance: float, side: float) -> float:
    """∂_z² of Σ 1/(4πr) over the images of a point, `distance` up the z axis from it."""
    alpha = math.sqrt(math.pi) / side
    z, r, kz, k2 = _lattice(distance, side)
    square = (z / r) ** 2
    bell = 2.0 * alpha / math.sqrt(math.pi) * np.exp(-((alpha * r) ** 2))
    e = erfc(alpha * r) / r
    first = -(e + bell) / r
    near = (2.0 * e / r**2 + 2.0 * bell / r**2 + 2.0 * alpha**2 * bell) * square
    near += first / r * (1.0 - square)
    own = 4.0 * alpha**3 / (3.0 * math.sqrt(math.pi))
    if distance > 0.0:
        b = 2.0 * alpha / math.sqrt(math.pi) * math.exp(-((alpha * distance) ** 2))
        e = -erf(alpha * distance) / distance
        own = 2.0 * e / distance**2 + 2.0 * b / distance**2 + 2.0 * alpha**2 * b
    far = -(kz**2) / k2 * np.exp(-k2 / (4.0 * alpha**2)) * np.cos(kz * distance)
    return float((near.sum() + own) / (4.0 * math.pi) + far.sum() / side**3)


def _lattice(distance: float, side: float) -> tuple[np.ndarray, ...]:
    """z and r from every image; k_z and k² of every wave but the constant one."""
    n = np.arange(-REACH, REACH + 1)
    i, j, k = (part.ravel() for part in np.meshgrid(n, n, n, indexing="ij"))
    kept = (i != 0) | (j != 0) | (k != 0)
    across, k = (i**2 + j**2)[kept], k[kept]
    z, wave = distance - k * side, 2.0 * math.pi / side
    return z, np.sqrt(across * side**2 + z**2), wave * k, wave**2 * (across + k**2)
