"""Force of a field on a dielectric ball, by the Maxwell stress on a sphere about it.

    ψ = F₁(r) cosθ + F₂(r) P₂(cosθ),    P₂ = ½(3cos²θ − 1)                        thesis (4.25)

An axisymmetric field that is uniform and changes linearly, E∞ and E_A2, with a dipole and a
quadrupole. Every other multipole would add nothing to the force of these two.
"""

import math

import numpy as np


def exact_force(
    external: float, gradient: float, factor: float, radius: float = 1.0, permittivity: float = 1.0
) -> float:
    """8π ε₂ E∞ E_A2 K a³, along the axis: p ∂E/∂x of the dipole p = 4πε₂a³K E∞.

    external: E∞; gradient: E_A2; factor: K = (ε₁−ε₂)/(ε₁+2ε₂). Source: thesis (4.19).
    """
    return 8 * math.pi * permittivity * external * gradient * factor * radius**3


def gauss_force(
    radius: float,
    dipole: tuple[float, float],
    quadrupole: tuple[float, float],
    permittivity: float = 1.0,
) -> float:
    """(8π/15) ε (rF₁' − F₁)(rF₂' + 3F₂): the stress on the sphere r = `radius`, integrated.

    Of (4.22–4.23), τ_rr = ½ε(E_r² − E_θ²) and τ_rθ = εE_rE_θ, only products of F₁ with F₂ leave
    a resultant; with μ = cosθ, ∫μ²P₂dμ = −∫P₂(1−μ²)dμ = 4/15 and ∫3μ²(1−μ²)dμ = 4/5, so that

        force = 2πεr² [4F₁'F₂'/15 − 4F₁F₂/(5r²) + 4F₁'F₂/(5r) − 4F₁F₂'/(15r)]

    In the fluid, F₁ = E∞r − B₁/r² and F₂ = E_A2 r² − B₂/r³ make the brackets 3B₁/r² and
    5E_A2 r²: the force is 8πεB₁E_A2, whatever r and whatever the quadrupole. Its relative error
    is therefore that of the dipole, 1 − a_eff³.

    dipole, quadrupole: (F, F') at r. permittivity: ε in the stress; the thesis takes ε₂ = 1
    everywhere, so that inside the interface this is no force on anything.
    """
    r, (f1, slope1), (f2, slope2) = radius, dipole, quadrupole
    return 8 * math.pi / 15 * permittivity * (r * slope1 - f1) * (r * slope2 + 3 * f2)


def stress_integral(
    radius: float,
    dipole: tuple[float, float],
    quadrupole: tuple[float, float],
    intervals: int,
    permittivity: float = 1.0,
) -> float:
    """2π∫₀^π r² sinθ (τ_rr cosθ − τ_rθ sinθ) dθ by the trapezoidal rule, as (4.23) stands.

    intervals: of θ. The others as in `gauss_force`, which it tends to as intervals⁻².
    """
    r, (f1, slope1), (f2, slope2) = radius, dipole, quadrupole
    angle = np.linspace(0.0, math.pi, intervals + 1)
    cosine, sine = np.cos(angle), np.sin(angle)
    normal = -(slope1 * cosine + slope2 * (1.5 * cosine**2 - 0.5))
    along = (f1 * sine + 3 * f2 * cosine * sine) / r
    radial = 0.5 * permittivity * (normal**2 - along**2)
    traction = radial * cosine - permittivity * normal * along * sine
    return float(2 * math.pi * r * r * np.trapezoid(sine * traction, angle))
