"""A sphere released from rest in slow flow: unbounded, or one in each cell of a periodic cube.

    (M − ρV_b) sV̂ + R(s)V̂ = W/s,   R = (1 1) G⁻¹ (1 1)ᵀ
    unbounded:   R = 6πμa(1 + λa + λ²a²/9) + ρV_b s,   λ² = s/ν
    periodic:    G_ij = (2/3L³) Σ_{k≠0} w_i w_j/(ρ(s + νk²)),   w = 3j₁(ka)/ka, sin(ka)/ka

Fluid fills the sphere too. What holds it rigid is a uniform force on its volume and one on its
surface, whose sizes follow from the means of the velocity over both: exact for a lone sphere, and
but for higher multipoles of its images, (a/L)⁵, in a lattice. Leaving k = 0 out holds the mean
velocity at zero. R(0) is Hasimoto's drag (J. Fluid Mech. 5, 1959); the unbounded R is Basset's.
"""

from collections.abc import Callable

import numpy as np
from scipy.special import spherical_jn

Resistance = Callable[[np.ndarray], np.ndarray]
_SHELLS = 100
_NODES = 24


def unbounded_resistance(radius: float, viscosity: float, density: float) -> Resistance:
    """s -> R(s), for a lone sphere; s complex (n,)."""
    inertia = density * 4.0 / 3.0 * np.pi * radius**3

    def resistance(s: np.ndarray) -> np.ndarray:
        x = radius * np.sqrt(s * density / viscosity)
        return 6.0 * np.pi * viscosity * radius * (1.0 + x + x**2 / 9.0) + inertia * s

    return resistance


def periodic_resistance(
    radius: float, viscosity: float, density: float, length: float
) -> Resistance:
    """s -> R(s), for a simple cubic lattice of spheres `length` apart; s complex (n,)."""
    n = np.arange(-_SHELLS, _SHELLS + 1) ** 2
    square = (n[:, None, None] + n[:, None] + n).ravel()
    count = np.bincount(square[square <= _SHELLS**2])
    shell = np.flatnonzero(count)[1:]
    k, count = 2.0 * np.pi / length * np.sqrt(shell), count[shell]
    x = k * radius
    volume, surface = 3.0 * spherical_jn(1, x) / x, np.sin(x) / x
    # Beyond the last shell sin² is ½ in the mean, and s is small beside νk².
    last = 2.0 * np.pi / length * (_SHELLS + 0.5)
    rest = 1.0 / (6.0 * np.pi**2 * radius**2 * viscosity * last)

    def resistance(s: np.ndarray) -> np.ndarray:
        green = 2.0 / (3.0 * length**3) * count / (density * s[:, None] + viscosity * k**2)
        vv, vs, ss = (green @ w for w in (volume**2, volume * surface, surface**2))
        ss = ss + rest
        return (vv + ss - 2.0 * vs) / (vv * ss - vs**2)

    return resistance


def speed_after_release(
    time: np.ndarray, pull: float, mass: float, displaced: float, resistance: Resistance
) -> np.ndarray:
    """V(t) (n,) of a body of that mass, at rest before t = 0, under a constant pull in the fluid.

    displaced: mass of the fluid that it displaces. By Talbot's inversion of Laplace's transform, on
    the contour of Weideman & Trefethen, Math. Comp. 76 (2007); eight digits.
    """
    time = np.asarray(time, dtype=float)
    angle = (2.0 * np.arange(_NODES) + 1.0) * np.pi / _NODES - np.pi
    cotangent = angle / np.tan(0.6407 * angle)
    contour = _NODES * (0.5017 * cotangent - 0.6122 + 0.2645j * angle)
    slope = 0.5017 / np.tan(0.6407 * angle)
    slope = slope - 0.5017 * 0.6407 * angle / np.sin(0.6407 * angle) ** 2
    slope = _NODES * (slope + 0.2645j)
    found = np.zeros(time.shape)
    for i, t in enumerate(time):
        s = contour / t
        image = pull / s / ((mass - displaced) * s + resistance(s))
        found[i] = np.sum(np.exp(contour) * image * slope / t).imag / _NODES
    return found
