"""The effective permittivity of a square array of cylinders, by Rayleigh's multipoles.

    ψ = Re Σ (A_n zⁿ + B_n z⁻ⁿ),    B_n = −β a²ⁿ A_n,    β = (R−1)/(R+1)
    A_n = −δ_n1 − Σ_m C(m+n−1, n) S_{m+n} B_m,    ε_eff = 1 + 2πB₁

in the cell around one cylinder, z = x + iy, for unit spacing and a unit mean field along x; n and
m are odd. The second line expands the others' B_m(z−p)⁻ᵐ about the first.
"""

import math

import numpy as np
from scipy.special import comb, zeta

TERMS = 12
"""Terms of the series in e^{−2π}."""


def square_sums(count: int) -> np.ndarray:
    """S_2, S_4, …, S_{2·count}: the sums of p⁻²ᵏ over a square lattice of unit spacing but for 0.

        S_2k = 2ζ(2k) + 2(2π)²ᵏ/(2k−1)! Σ n²ᵏ⁻¹qⁿ/(1−qⁿ),  q = e^{−2π},  k even

    and 0 for odd k > 1, by the quarter turn. S_2 depends on the shape that the lattice is summed
    in: it is π in a strip along the field, whose ends are far, so that E is the mean field.
    """
    sums = np.zeros(count)
    sums[0] = math.pi
    n = np.arange(1.0, TERMS + 1)
    decay = np.exp(-2.0 * math.pi * n)
    for k in range(2, count + 1, 2):
        # n²ᵏ⁻¹(2π)²ᵏ/(2k−1)! as one exponential, for neither factor need be a float.
        size = 2 * k * math.log(2 * math.pi) - math.lgamma(2 * k) + (2 * k - 1) * np.log(n)
        sums[k - 1] = 2.0 * (zeta(2 * k) + (np.exp(size) * decay / (1.0 - decay)).sum())
    return sums


def square_array(ratio: float, fraction: float, multipoles: int = 20) -> float:
    """ε_eff/ε₂ across cylinders of permittivity ratio R = `ratio` that fill `fraction` of space.

    Of R and 1/R the product is one (Keller). multipoles: odd n kept, of which 20 give round-off
    up to fractions of 0.4 at any R. ValueError unless 0 < fraction < π/4, where they touch.
    Source: Rayleigh, Phil. Mag. 34 (1892); Perrins, McKenzie and McPhedran, Proc. R. Soc. A 369
    (1979).
    """
    if not 0.0 < fraction < math.pi / 4.0:
        raise ValueError(f"fraction is {fraction}; it must lie between 0 and π/4")
    if not ratio > 0.0:
        raise ValueError(f"ratio is {ratio}; it must be a positive number")
    n = np.arange(1, 2 * multipoles, 2)
    m = n[:, None]
    radius = math.sqrt(fraction / math.pi)
    # With B_n = aⁿb_n the coefficients stay of one size.
    sums = square_sums(2 * multipoles)[(m + n) // 2 - 1]
    coupling = comb(m + n - 1, m) * sums * radius ** (m + n)
    contrast = (ratio - 1.0) / (ratio + 1.0)
    right = np.zeros(multipoles)
    right[0] = contrast * radius
    found = np.linalg.solve(np.eye(multipoles) - contrast * coupling, right)
    return float(1.0 + 2.0 * math.pi * radius * found[0])
