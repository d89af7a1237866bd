"""A ball of smoothed viscosity in creeping flow: the radial problem of one harmonic.

    u = A(r) Y n + B(r) r∇Y,    ∇·u = 0,    ∇·σ + f(r)(Y n + r∇Y) = 0

for Y = n·F (l = 1, driven by a force density f) or n·E·n (l = 2, in a straining flow), n = r/|r|.
Across a layer the tractions are continuous, and along it the velocity's gradients are, so that one
viscosity, μ_n, resists the shear of neighbouring shells and another, μ_t, all other strains:

    S = μ_n (B' − (B − A)/r),    N = −p + 2μ_t A',    A' = (λB − 2A)/r,    λ = l(l+1)
    N' = λS/r − 6μ_t A'/r − f,    S' = −3S/r − [N − 3μ_t A' + (2−λ)μ_t B/r]/r − f

with tractions N Y n + S r∇Y on spheres. Viscosities are in units of the fluid's, R = μ_s/μ_f.
"""

import math
from collections.abc import Callable

import numpy as np

from smoothprofile.theory.collocation import gauss_stages, solve_linear
from smoothprofile.theory.dielectric import SMOOTHINGS as SMOOTHINGS
from smoothprofile.theory.dielectric import interface_edges as interface_edges
from smoothprofile.theory.dielectric import permittivities

Function = Callable[[np.ndarray], np.ndarray]


def sharp_mobility(ratio: float) -> float:
    """U/F = (1 + R)/(2π(2 + 3R)) of a sharp ball, a = 1; 1/6π when rigid.

    Source: Hadamard and Rybczynski (1911), as in Happel & Brenner, §4-21.
    """
    return (1.0 + ratio) / (2.0 * math.pi * (2.0 + 3.0 * ratio))


def sharp_stresslet(ratio: float) -> float:
    """S/E = (40π/3)(R − 1)/(2R + 3) of a sharp ball, a = 1; 20π/3 when rigid.

    The strain inside is uniform, 5E/(2R + 3), and S = (4π/3)·2(R − 1) times it. Taylor's drop,
    (20π/3)(R + 2/5)/(R + 1), is another: surface tension keeps it round by a jump of pressure.
    Source: Eshelby, Proc. R. Soc. A 241 (1957), for incompressible media.
    """
    return 40.0 * math.pi / 3.0 * (ratio - 1.0) / (2.0 * ratio + 3.0)


def sharp_spin(ratio: float) -> float:
    """Ω/T = (1 + 3/(7R))/(8π) of a sharp ball under a torque spread as r, a = 1."""
    return (1.0 + 3.0 / (7.0 * ratio)) / (8.0 * math.pi)


def spin(ratio: float, indicator: Function, smoothing: str, edges: np.ndarray) -> float:
    """Ω/T = ∫ 3L²/(8πμ_n r⁴) dr of a ball turned by f = w α×r, Ω = ∫f·u dV/T.

    L(r) is the part of the torque within r, ∝ ∫w r⁴ dr, w `loaded`; spheres slide on one another
    and nothing else is strained. indicator, edges: as for `mobility`.
    """
    normal, _ = viscosities(indicator, ratio, smoothing)
    share = loaded(indicator, ratio, smoothing)
    nodes, stages, weights = gauss_stages(12)
    width = np.diff(edges)[:, None]
    r = edges[:-1, None] + width * nodes
    torque = share(r.ravel()).reshape(r.shape) * r**4
    # Within the first edge all is uniform.
    core = float(share(edges[:1])[0]) * edges[0] ** 5 / 5.0
    panels = core + np.concatenate([[0.0], np.cumsum(width[:, 0] * (torque @ weights))])
    within = (panels[:-1, None] + width * (torque @ stages.T)) / panels[-1]
    density = within**2 / (normal(r.ravel()).reshape(r.shape) * r**4)
    total = float((width[:, 0] * (density @ weights)).sum())
    total += float((core / panels[-1]) ** 2 / (7.0 * normal(edges[:1])[0] * edges[0] ** 3))
    return 3.0 / (8.0 * math.pi) * (total + 1.0 / (3.0 * edges[-1] ** 3))


def mobility_slope(ratio: float, normal: float, tangential: float, load: float) -> float:
    """lim (U/U_sharp − 1)a/ξ = −(R−1)(3R s_n + 2s_t)/((3R+2)(R+1)) − 2s_f/(R+1) as ξ → 0.

    s_n, s_t: where a flat layer acts in shear and in the other strains, in ξ out of the surface
    (`dielectric.flat_offsets`); s_f: by how much the load reaches out. The layer's dissipation of
    shear is that of a surface s_nξ further out, of the rest that of one at s_tξ; inside the sharp
    ball they count as 3R to 2. tanh: arithmetic s_n = ½ ln R, harmonic s_t = s_f = −½ ln R, tensor
    nothing.
    """
    shear = (ratio - 1.0) * (3.0 * ratio * normal + 2.0 * tangential)
    return -shear / ((3.0 * ratio + 2.0) * (ratio + 1.0)) - 2.0 * load / (ratio + 1.0)


def stresslet_slope(ratio: float, normal: float, tangential: float) -> float:
    """lim (S/S_sharp − 1)a/ξ = 3(2R s_n + 3s_t)/(2R + 3) as ξ → 0; as `mobility_slope`."""
    return 3.0 * (2.0 * ratio * normal + 3.0 * tangential) / (2.0 * ratio + 3.0)


def viscosities(indicator: Function, ratio: float, smoothing: str) -> tuple[Function, Function]:
    """μ_n and μ_t over μ_f, as functions of what the indicator is a function of.

    arithmetic: both 1 + (R−1)φ. harmonic: both 1/(1 + (1/R−1)φ). tensor: μ_n is harmonic and μ_t
    arithmetic. ValueError for another name.
    """
    return permittivities(indicator, ratio, smoothing)


def loaded(indicator: Function, ratio: float, smoothing: str) -> Function:
    """Where a force on the ball acts: φ, or with harmonic smoothing (μ_h − μ_f)/(μ_s − μ_f), R > 1.

    Half of a harmonic layer is as soft as the fluid, and a force there would drag it ahead of the
    solid.
    """
    stiff = ratio if smoothing == "harmonic" and ratio > 1.0 else 1.0

    def share(r: np.ndarray) -> np.ndarray:
        phi = indicator(r)
        return phi / (phi + stiff * (1.0 - phi))

    return share


def mobility(ratio: float, indicator: Function, smoothing: str, edges: np.ndarray) -> float:
    """U/F of a ball driven by a force density f, U = ∫f·u dV/F, so that FU dissipates.

    f is `loaded`, normalised. At the first edge A, B, S, N are regular, at the last those of a
    point force and its Laplacian. indicator: φ(r). edges: as `interface_edges` gives them.
    """
    normal, tangential = viscosities(indicator, ratio, smoothing)
    share = loaded(indicator, ratio, smoothing)
    density = _volume(share, edges)

    def matrix(r: np.ndarray) -> np.ndarray:
        force = share(r) / density
        rows = np.zeros((r.size, 6, 6))
        rows[:, :4, :4] = _harmonic(1, normal(r), tangential(r)) / r[:, None, None]
        rows[:, 2, 5] = rows[:, 3, 5] = -r * force
        # The fifth unknown is ∫f·u dV within r, the sixth is one.
        rows[:, 4, 0], rows[:, 4, 1] = (math.pi / 3.0) * r**2 * np.array([[4.0], [8.0]]) * force
        return rows

    first = edges[:1]
    force = float(share(first)[0]) / density
    left = np.zeros((3, 6))
    left[:2, :4] = _amplitudes(1, float(normal(first)[0]), float(tangential(first)[0]), False)
    # Inside, the force is borne by a pressure, N = −fr.
    left[:2, 5] = left[:2, 3] * force * first**2
    # The mean of u along F over a ball is A on its surface.
    left[2, 0], left[2, 4] = -4.0 * math.pi / 3.0 * first[0] ** 3 * force, 1.0
    right = np.zeros((3, 6))
    right[:2, :4] = _amplitudes(1, 1.0, 1.0, True)
    right[2, 5] = 1.0
    return float(solve_linear(matrix, edges, left, right, np.array([0.0, 0.0, 1.0]))[-1, 4])


def stresslet(ratio: float, indicator: Function, smoothing: str, edges: np.ndarray) -> float:
    """S/E of a ball in the straining flow u → E·r, by the far field −3S/(8πr²) Y n.

    indicator, edges: as for `mobility`.
    """
    normal, tangential = viscosities(indicator, ratio, smoothing)

    def matrix(r: np.ndarray) -> np.ndarray:
        return _harmonic(2, normal(r), tangential(r)) / r[:, None, None]

    first, last = edges[:1], float(edges[-1])
    left = _amplitudes(2, float(normal(first)[0]), float(tangential(first)[0]), False)
    right = _amplitudes(2, 1.0, 1.0, True)
    # The linear flow A = r, B = r/2 with its stresses, rS = r and rN = 2r.
    values = right @ np.array([1.0, 0.5, 1.0, 2.0]) * last
    y = solve_linear(matrix, edges, left, right, values)[-1]
    disturbance = y - np.array([1.0, 0.5, 1.0, 2.0]) * last
    # A = c r⁻² + d r⁻⁴ has B = −(d/3) r⁻⁴, for 6B = rA' + 2A.
    return float(-8.0 * math.pi / 3.0 * last**2 * (disturbance[0] + 3.0 * disturbance[1]))


def _harmonic(l: int, normal, tangential) -> np.ndarray:
    """r d/dr of (A, B, rS, rN), for viscosities (n,) at n radii: (n,4,4)."""
    normal, tangential = np.atleast_1d(normal), np.atleast_1d(tangential)
    degree = l * (l + 1)
    rows = np.zeros((normal.size, 4, 4))
    rows[:, 0, 0], rows[:, 0, 1] = -2.0, degree
    rows[:, 1, 0], rows[:, 1, 1], rows[:, 1, 2] = -1.0, 1.0, 1.0 / normal
    rows[:, 2, 0], rows[:, 2, 1] = -6.0 * tangential, (4 * degree - 2) * tangential
    rows[:, 2, 2], rows[:, 2, 3] = -2.0, -1.0
    rows[:, 3, 0], rows[:, 3, 1] = 12.0 * tangential, -6.0 * degree * tangential
    rows[:, 3, 2], rows[:, 3, 3] = degree, 1.0
    return rows


def _amplitudes(l: int, normal: float, tangential: float, growing: bool) -> np.ndarray:
    """(2,4): rows that give the amplitudes of both solutions r^s that grow, or that decay.

    In a uniform fluid A ~ r^s: s = l ± 1 are regular at the centre, −l and −l − 2 decay. Where
    μ_n and μ_t differ the exponents are others, two above and two below −1/2.
    """
    found, vectors = np.linalg.eig(_harmonic(l, normal, tangential)[0].T)
    order = np.argsort(found.real)
    chosen = order[2:] if growing else order[:2]
    rows = vectors[:, chosen].real.T
    return rows / np.abs(rows).max(axis=1)[:, None]


def _volume(indicator: Function, edges: np.ndarray) -> float:
    """∫φ dV, φ being uniform within the first edge."""
    points, weights = np.polynomial.legendre.leggauss(12)
    width = np.diff(edges)[:, None]
    r = edges[:-1, None] + 0.5 * width * (points + 1.0)
    layer = (0.5 * width * weights * indicator(r.ravel()).reshape(r.shape) * r**2).sum()
    return 4.0 * math.pi * (float(layer) + edges[0] ** 3 * float(indicator(edges[:1])[0]) / 3.0)
