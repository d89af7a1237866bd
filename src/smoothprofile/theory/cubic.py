"""A simple cubic lattice of balls in a mean field, by Rayleigh's multipoles.

    V = Σ (A_lm R_lm + B_lm I_lm)
    R_lm = rˡ P_lᵐ e^{imφ}/(l+m)!,   I_lm = (l−m)! P_lᵐ e^{imφ}/rˡ⁺¹
    B_lm = −s_l A_lm/((l−m)!(l+m)!)
    A_lm = −δ_l1 δ_m0 (1 + (4π/3)B_10) + Σ_l'm' (−1)^{l'} S_{l+l',m'−m} B_l'm'

for the whole potential V about one ball, for unit spacing and a unit mean field along z; l is odd
and m a multiple of 4. The balls need not be sharp: s_l is B over E of one in an applied potential
−E rˡP_l, with whatever permittivity its radius has. The last line expands the others' fields;
S_lm = Σ' I_lm over the lattice but for 0, and S_2m stands in its first term, for mean field one.
Source: Rayleigh, Phil. Mag. 34 (1892); McPhedran and McKenzie, Proc. R. Soc. A 359 (1978).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gamma, gammaincc, gammaln, lpmv

REACH = 7
"""Lattice points along each axis either way: e^{−πn²}, and Γ(l+½,πn²) up to l = 40, are left out
below 1e-16 of the sum."""
POINTS = 24


@dataclass(frozen=True, eq=False)
class LatticeField:
    """degrees l (n,), orders m (n,), and the coefficient A_lm/(l+m)! of −E rˡP_lᵐe^{imφ} (n,)."""

    degrees: np.ndarray
    orders: np.ndarray
    applied: np.ndarray
    effective_permittivity: float

    def box_mean(self, side: float, radial: Callable[[int, np.ndarray], np.ndarray]) -> float:
        """Mean of E_z over a cube of that side about a ball's centre: −∮V n_z dA/side³.

        radial(l, r) is F of one ball in the applied potential −rˡP_l, so that V is −F P_l; it is
        asked for the radii of `face_points`.
        """
        x, y, weights = _face(side)
        r = face_points(side)
        cosine, angle = 0.5 * side / r, np.arctan2(y, x)
        potential = np.zeros_like(r)
        for l, m, applied in zip(self.degrees, self.orders, self.applied, strict=True):
            legendre = lpmv(abs(m), l, cosine) * _reflected(l, m)
            potential += applied * radial(int(l), r) * legendre * np.cos(m * angle)
        # V is odd in z and even in x and y: two faces of four quarters each.
        return float(-8.0 * (weights * potential).sum() / side**3)


def face_points(side: float) -> np.ndarray:
    """Radii of the points on a cube's face at which `LatticeField.box_mean` needs F."""
    x, y, _ = _face(side)
    return np.sqrt(x**2 + y**2 + 0.25 * side**2)


def cubic_lattice(strengths: Sequence[float]) -> LatticeField:
    """The field for s_1, s_3, s_5, … of the balls, in units of the spacing.

    A sharp ball of radius a has s_l = l(R−1)a²ˡ⁺¹/(lR+l+1). Ten strengths give round-off up to
    volume fractions of 0.2; what is left decays as (2a)²ˡ.
    """
    strengths = np.asarray(strengths, dtype=np.float64)
    pairs = [
        (l, m) for l in range(1, 2 * strengths.size, 2) for m in range(-l, l + 1) if m % 4 == 0
    ]
    l, m = np.array(pairs).T
    # A = n u/aˡ and B = aˡ⁺¹v/n, n² = (l−m)!(l+m)!, keep all numbers of one size, a being ½.
    scale = 0.5 * (gammaln(l - m + 1) + gammaln(l + m + 1))
    sums = {}
    for degree in range(4, 2 * int(l.max()) + 1, 2):
        for order in range(0, degree + 1, 4):
            sums[degree, order] = lattice_sum(degree, order)
    coupling = np.zeros((l.size, l.size))
    for i in range(l.size):
        for j in range(l.size):
            degree, order = int(l[i] + l[j]), int(m[j] - m[i])
            if degree > 2 and abs(order) <= degree:
                shrunk = math.exp(-scale[i] - scale[j]) * 0.5 ** (degree + 1)
                coupling[i, j] = -sums[degree, abs(order)] * shrunk
    first = pairs.index((1, 0))
    coupling[first, first] -= 4.0 * math.pi / 3.0 * 0.5**3
    response = -strengths[(l - 1) // 2] * 2.0 ** (2 * l + 1)
    right = np.zeros(l.size)
    right[first] = -0.5
    u = np.linalg.solve(np.eye(l.size) - coupling * response, right)
    applied = u * np.exp(scale - gammaln(l + m + 1)) * 2.0**l
    dipole = response[first] * u[first] * 0.5**2
    return LatticeField(l, m, applied, 1.0 + 4.0 * math.pi * dipole)


def lattice_sum(degree: int, order: int) -> float:
    """S_lm = Σ' I_lm over the cubic lattice of unit spacing, for even l ≥ 4 and m a multiple of 4.

        Γ(l+½) S = Σ' Γ(l+½, πn²) H(n)/n²ˡ⁺¹ + π^{3/2} (−i)ˡ 2^{2−l} Σ' H(G)/G² e^{−G²/4π}

    H = r²ˡ⁺¹I_lm, G = 2πn: Ewald's splitting at t = π of n^{−2l−1} = ∫t^{l−½}e^{−tn²}dt/Γ(l+½).
    """
    n = np.stack(np.meshgrid(*(np.arange(-REACH, REACH + 1.0),) * 3, indexing="ij"), -1)
    n = n.reshape(-1, 3)
    n = n[(n**2).sum(axis=1) > 0]
    size = np.sqrt((n**2).sum(axis=1))
    angle = np.arctan2(n[:, 1], n[:, 0])
    surface = lpmv(order, degree, n[:, 2] / size) * np.cos(order * angle)
    half = degree + 0.5
    direct = gammaincc(half, math.pi * size**2) * surface * size ** -(degree + 1.0)
    power = (degree - 2) * np.log(2.0 * math.pi * size) - math.pi * size**2
    sign = (-1.0) ** (degree // 2)
    constant = 1.5 * math.log(math.pi) + (2 - degree) * math.log(2.0) - gammaln(half)
    inverse = sign * surface * np.exp(constant + power)
    return float(gamma(degree - order + 1.0) * (direct + inverse).sum())


def _face(side: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss points and weights on a quarter of the face z = side/2."""
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    points, weights = 0.25 * side * (points + 1.0), 0.25 * side * weights
    x, y = np.meshgrid(points, points, indexing="ij")
    return x.ravel(), y.ravel(), np.outer(weights, weights).ravel()


def _reflected(l: int, m: int) -> float:
    """P_l^{−m} over P_lᵐ: (−1)ᵐ(l−m)!/(l+m)! for m < 0, whose sign is plus."""
    return 1.0 if m >= 0 else math.exp(gammaln(l + m + 1) - gammaln(l - m + 1))
