"""A smoothed dielectric ball in an applied field: the radial problem of one multipole.

    (r²ε_n F')' = l(l+1) ε_t F,    D = ε_n F',    ψ = −F(r) P_l(cosθ)

ε_n is the permittivity along the radius, ε_t that across it, both in units of the fluid's, ε₂.
Beyond the interface F = E rˡ − B r^{−(l+1)}. A sharp ball of radius a has B = E K_l a^{2l+1},
K_l = l(R−1)/(lR+l+1), R = ε₁/ε₂; whatever its smoothing, a ball's effective radius is the a
for which this holds. l = 1 is the dipole, the thesis' (4.4–4.12); l = 2 its (4.17–4.18, 4.24).
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import quad

from smoothprofile.theory.collocation import solve_linear

Function = Callable[[np.ndarray], np.ndarray]

SMOOTHINGS = ("arithmetic", "harmonic", "tensor")
"""arithmetic: ε is interpolated, (4.3). harmonic: 1/ε is, (4.15). tensor: 1/ε_n and ε_t are."""

# Width of elements in ξ. Half of it is a quarter of the way to the poles of tanh: 1e-14.
WIDTH = 0.8
SMALLEST = 1e-3


def weights(indicator: Function, ratio: float, smoothing: str) -> tuple[Function, Function]:
    """φ_n and φ_t in 1/ε_n = 1 + (1/R − 1)φ_n and ε_t = 1 + (R − 1)φ_t, with R = `ratio`.

    tensor: both are φ. ε = 1 + (R−1)φ is 1/ε = 1 + (1/R−1)φ_n with φ_n = Rφ/(Rφ + 1 − φ), and
    1/ε = 1 + (1/R−1)φ is ε = 1 + (R−1)φ_t with φ_t = φ/(φ + R(1−φ)).
    """
    if smoothing not in SMOOTHINGS:
        raise ValueError(f"smoothing is {smoothing!r}; it must be one of {', '.join(SMOOTHINGS)}")

    def moved_out(x: np.ndarray) -> np.ndarray:
        phi = indicator(x)
        return ratio * phi / (ratio * phi + (1.0 - phi))

    def moved_in(x: np.ndarray) -> np.ndarray:
        phi = indicator(x)
        return phi / (phi + ratio * (1.0 - phi))

    normal = moved_out if smoothing == "arithmetic" else indicator
    return normal, moved_in if smoothing == "harmonic" else indicator


def permittivities(indicator: Function, ratio: float, smoothing: str) -> tuple[Function, Function]:
    """ε_n and ε_t over ε₂, as functions of what the indicator is a function of."""
    normal, tangential = weights(indicator, ratio, smoothing)
    return (
        lambda r: 1.0 / (1.0 + (1.0 / ratio - 1.0) * normal(r)),
        lambda r: 1.0 + (ratio - 1.0) * tangential(r),
    )


@dataclass(frozen=True, eq=False)
class RadialField:
    """F(r) and D(r) of one multipole, with ε₂ = 1.

    radius, potential, slope, displacement: r, F, F' and D = ε_n F' at the elements' edges
    external, induced: E and B that fit F and D at the outermost edge
    effective_radius: (B/(E K_l))^{1/(2l+1)}
    """

    degree: int
    radius: np.ndarray
    potential: np.ndarray
    slope: np.ndarray
    displacement: np.ndarray
    external: float
    induced: float
    effective_radius: float

    def at(self, radius: float) -> tuple[float, float]:
        """F and F' at an edge; ValueError at any other radius."""
        (found,) = np.flatnonzero(self.radius == radius)
        return float(self.potential[found]), float(self.slope[found])


def solve_multipole(
    degree: int,
    ratio: float,
    indicator: Function,
    smoothing: str,
    edges: np.ndarray,
    inner_amplitude: float | None = None,
    inner_permittivity: float | None = None,
) -> RadialField:
    """The solution with E = 1, or with F = `inner_amplitude`·rˡ at the first edge.

    F = rˡ(α − b) and rD = rˡ(lα + (l+1)b) turn the problem into one for what E and B r^{−(2l+1)}
    would be if the fluid began at r. With b = (R−1)c nothing is lost, or singular, at R = 1:

        α' = (R−1)((l+1)p + q)/((2l+1)r),    c' = ((q − lp)/(2l+1) − (2l+1)c)/r
        p = −φ_n(lα + (l+1)(R−1)c)/R,    q = l(l+1)φ_t(α − (R−1)c)

    At the first edge the solution is the regular one of the permittivities there, r^s with
    s(s+1)ε_n = l(l+1)ε_t. inner_permittivity: the ε of D = lεF/r there instead; R is the thesis'
    start from the sharp sphere's field at r = a/2. It needs R ≠ 1.

    degree: l ≥ 1. ratio: R > 0. indicator: φ(r). edges: from a radius small beside the others, or
    inside which φ = 1, to one beyond which φ = 0.
    """
    l, contrast = degree, ratio - 1.0
    normal, tangential = weights(indicator, ratio, smoothing)

    def matrix(r: np.ndarray) -> np.ndarray:
        phi_n, phi_t = normal(r) / ratio, l * (l + 1) * tangential(r)
        p = -l * phi_n, -(l + 1) * contrast * phi_n
        q = phi_t, -contrast * phi_t
        rows = np.empty((r.size, 2, 2))
        for column in (0, 1):
            rows[:, 0, column] = contrast * ((l + 1) * p[column] + q[column])
            rows[:, 1, column] = q[column] - l * p[column]
        rows[:, 1, 1] -= (2 * l + 1) ** 2
        return rows / ((2 * l + 1) * r)[:, None, None]

    if inner_permittivity is None:
        steepness, excess = _regular(l, ratio, float(normal(edges[0])), float(tangential(edges[0])))
    else:
        steepness, excess = l * inner_permittivity, l * (inner_permittivity - 1.0) / contrast
    left = np.array([[excess, -(l + 1) - steepness]])
    alpha, scaled = solve_linear(matrix, edges, left, np.array([[1.0, 0.0]]), np.ones(1)).T
    power = 2 * l + 1
    effective = (scaled[-1] * (l * ratio + l + 1) / l) ** (1 / power) * edges[-1]
    scale = 1.0
    if inner_amplitude is not None:
        scale = inner_amplitude / (alpha[0] - contrast * scaled[0])
    alpha, b = scale * alpha, scale * contrast * scaled
    displacement = edges ** (l - 1) * (l * alpha + (l + 1) * b)
    return RadialField(
        degree=l,
        radius=edges,
        potential=edges**l * (alpha - b),
        slope=displacement * (1.0 + (1.0 / ratio - 1.0) * normal(edges)),
        displacement=displacement,
        external=float(alpha[-1]),
        induced=float(b[-1] * edges[-1] ** power),
        effective_radius=float(effective),
    )


def _regular(l: int, ratio: float, phi_n: float, phi_t: float) -> tuple[float, float]:
    """ε_n s and (ε_n s − l)/(R−1), s the positive root of s(s+1)ε_n = l(l+1)ε_t."""
    eps_n, eps_t = 1.0 / (1.0 + (1.0 / ratio - 1.0) * phi_n), 1.0 + (ratio - 1.0) * phi_t
    root = math.sqrt(eps_n**2 / 4 + l * (l + 1) * eps_t * eps_n)
    excess = l * eps_n * ((l + 1) * phi_t + l * phi_n / ratio) / (root + l + eps_n / 2)
    return root - eps_n / 2, excess


def interface_edges(
    surface: float,
    thickness: float,
    core: float,
    edge: float,
    ratio: float,
    start: float | None = None,
    stop: float | None = None,
) -> np.ndarray:
    """Edges across an interface: from where φ = 1, or near the centre, to where φ = 0.

    core, edge: the z = (r − surface)/ξ where φ = 1 and 0 exactly, infinite for tanh, whose tail
    is followed down to 1e-16 in ε. A compact profile φ leaves 1 and 0 as a square, so that ε
    and 1/ε have poles within ½R^{∓½}ξ of its ends: the elements are graded towards them.
    start, stop: the first and last edge, if not these.
    """
    if math.isinf(core):
        reach = 19.0 + 0.5 * abs(math.log(ratio))
        first = start or max(surface - reach * thickness, SMALLEST * surface)
        last = stop or surface + reach * thickness
        return _even(surface, first, last, WIDTH * thickness)
    half, width = 0.5 * (edge - core), 0.25 * min(ratio, 1.0 / ratio) ** 0.5
    grown = [0.0]
    while grown[-1] + width < half:
        grown.append(grown[-1] + width)
        width = min(1.6 * width, 0.25 * half)
    grown = np.array(grown)
    z = np.concatenate((core + grown, edge - grown[::-1]))
    inside = [start] if start is not None else []
    outside = [stop] if stop is not None else []
    return np.concatenate((inside, surface + thickness * z, outside))


def _even(surface: float, first: float, last: float, width: float) -> np.ndarray:
    """Edges `width` apart from the surface both ways, and none above twice the one below it."""
    outward = np.linspace(surface, last, 1 + math.ceil((last - surface) / width))
    inward = [surface]
    while inward[-1] > first:
        inward.append(max(inward[-1] - width, 0.5 * inward[-1], first))
    return np.concatenate((inward[:0:-1], outward))


def sharp_factor(degree: int, ratio: float) -> float:
    """K_l = l(R−1)/(lR + l + 1): B = E K_l a^{2l+1} of a sharp ball.

    From F and D continuous at r = a, F = A rˡ inside. l = 1: the thesis' (4.5); 2: its (4.18).
    """
    return degree * (ratio - 1.0) / (degree * ratio + degree + 1.0)


def sharp_field(
    degree: int, ratio: float, radius: float, points: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """F = (1−K_l)rˡ inside, rˡ − K_l a^{2l+1} r^{−(l+1)} outside, and D = εF', for E = 1."""
    l, factor = degree, sharp_factor(degree, ratio)
    within, induced = points < radius, factor * radius ** (2 * l + 1)
    outer = points**l - induced * points ** -(l + 1.0)
    flux = l * points ** (l - 1) + (l + 1) * induced * points ** -(l + 2.0)
    inner = (1 - factor) * points ** (l - 1)
    return np.where(within, points * inner, outer), np.where(within, ratio * l * inner, flux)


def flat_offsets(
    indicator: Function, ratio: float, smoothing: str, core: float, edge: float
) -> tuple[float, float]:
    """s_n = ∫(φ_n − H(−z))dz and s_t = ∫(φ_t − H(−z))dz: where a flat interface acts, in ξ.

    A thin interface matters only through ∫(1/ε_n)dz, by which D drops the potential, and ∫ε_t dz,
    by which F spreads the flux. Both are those of a sharp interface moved out by s_nξ in a field
    along the normal, by s_tξ in one along the surface. tensor: s_n = s_t = ∫(φ − H(−z))dz, the
    one offset that no field changes. tanh: arithmetic ½ ln R and 0, harmonic 0 and −½ ln R.

    indicator: φ(z). core, edge: as in `interface_edges`.
    """
    reach = 19.0 + 0.5 * abs(math.log(ratio))
    core, edge = max(core, -reach), min(edge, reach)
    found = []
    for weight in weights(indicator, ratio, smoothing):
        solid = quad(lambda z, w=weight: 1.0 - float(w(z)), core, 0.0, epsabs=1e-13, limit=200)
        fluid = quad(lambda z, w=weight: float(w(z)), 0.0, edge, epsabs=1e-13, limit=200)
        found.append(fluid[0] - solid[0])
    return found[0], found[1]


def first_moment(indicator: Function, offset: float, core: float, edge: float) -> float:
    """m₁ = ∫(φ − H(−z))z dz about the profile's own centre z = `offset`; tanh π²/24."""
    core, edge = max(core, -20.0) - offset, min(edge, 20.0) - offset

    def fluid(z: float) -> float:
        return float(indicator(z + offset)) * z

    def solid(z: float) -> float:
        return (float(indicator(z + offset)) - 1.0) * z

    accuracy = {"epsabs": 1e-13, "limit": 200}
    return quad(solid, core, 0.0, **accuracy)[0] + quad(fluid, 0.0, edge, **accuracy)[0]


def radius_slope(degree: int, ratio: float, normal: float, tangential: float) -> float:
    """lim (a_eff − a)/ξ = (lR s_n + (l+1) s_t)/(lR + l + 1) as ξ → 0, with `flat_offsets`.

    Moving the sharp surface out by δ changes F beyond it by (1/ε₁ − 1/ε₂)δD and r²D by
    l(l+1)(ε₁ − ε₂)δF; the layer does the same with δ = s_nξ in the one and s_tξ in the other.
    B depends on the ratio of r²D to F only, where they count as D²(1/ε₂ − 1/ε₁) to
    l(l+1)(ε₁ − ε₂)F²/a²; inside, D = lε₁F/a makes that lR to l + 1.

    tanh: arithmetic lR ln R/(2(lR+l+1)), harmonic −(l+1) ln R/(2(lR+l+1)); they are equal in
    size at R = (l+1)/l. tensor: the profile's excess, zero for tanh and centred profiles.
    """
    l = degree
    return (l * ratio * normal + (l + 1) * tangential) / (l * ratio + l + 1)
