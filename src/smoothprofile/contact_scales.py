"""What presses free bodies against each other, and how fast a field makes them meet.

    F₀ = max(6mU²/s, 4W, 8Fᵉ, 8Fˢ),   U = max(U₀, Uᵉ),  or ν/Δx if both are 0
    Fᵉ = (3π/2)β² ε a² E²/(1/(.65 max(R, 1)) + 2.7h/a),   h = s/2,   β = (R−1)/(R+2)
    Fˢ = 6πμ γ̇ a²,   Uᵉ = min(Fᵉ/(6πμa), √(2aFᵉ/(3m)))

F₀ is the force of a body's contact at touch, s its range, m the mass with that of the fluid that
goes along, W the weight in the fluid and other given forces, U₀ the speed that the case announces.
The stiffness of a pair is half of that of its equal bodies, so that Fᵉ or Fˢ leaves it s/2 of gap.

Fᵉ: two touching dipoles along the field attract by (3π/2)β²εa²E², and two spheres at a gap h by the
rest, which is fitted to the exact force: within 15 % for R from .1 to 10⁴ and h from .05a to .3a.
Fˢ bounds what presses two touching spheres of a sheared fluid together, 3π to 6π times μγ̇a². Uᵉ is
the speed of a lone sphere under Fᵉ, or all of the work of two dipoles as motion if that is less.
"""

import math

import numpy as np

from smoothprofile.config import AXES, Case, build_shape
from smoothprofile.numbers import shear_rate

LEFT_OPEN = 0.5
"""Of the range: the gap at which Fᵉ is taken."""


def pressing_force(case: Case, contact_range: float) -> np.ndarray:
    """2·max(Fᵉ, Fˢ) (n,) of each body: what a weight W would be that asks for the same F₀."""
    shear = 6.0 * math.pi * case.fluid.viscosity * shear_rate(case) * _sizes(case) ** 2
    return 2.0 * np.maximum(field_force(case, contact_range), shear)


def field_force(case: Case, contact_range: float) -> np.ndarray:
    """Fᵉ (n,): how hard a field presses each body against its like; 0 without a field."""
    electric, size = case.electric, _sizes(case)
    if electric is None or not size.any():
        return np.zeros(size.size)
    strongest = np.linalg.norm(np.maximum(np.abs(electric.field), np.abs(electric.quadrature)))
    if electric.electrodes is not None:
        ends = electric.electrodes
        length = case.domain.lengths[AXES.index(ends.axis)]
        strongest = math.hypot(strongest, (ends.high - ends.low) / length)
    ratio = np.array([p.permittivity for p in case.particles]) / electric.permittivity
    gap = LEFT_OPEN * contact_range / np.where(size > 0.0, size, np.inf)
    return electric.permittivity * (size * strongest) ** 2 * near_force(ratio, gap)


def near_force(ratio: np.ndarray, gap: np.ndarray) -> np.ndarray:
    """Fᵉ/(εa²E²) of two spheres along the field at a gap of h/a."""
    beta = (ratio - 1.0) / (ratio + 2.0)
    return 1.5 * math.pi * beta**2 / (1.0 / (0.65 * np.maximum(ratio, 1.0)) + 2.7 * gap)


def field_speed(case: Case, contact_range: float) -> np.ndarray:
    """Uᵉ (n,): how fast bodies meet that the field draws together; only of use for free ones."""
    force, size, fluid = field_force(case, contact_range), _sizes(case), case.fluid
    shown = np.where(force > 0.0, size, 1.0)
    density = np.array([p.density or fluid.density for p in case.particles]) + 0.5 * fluid.density
    creeping = force / (6.0 * math.pi * fluid.viscosity * shown)
    return np.minimum(creeping, np.sqrt(force / (2.0 * math.pi * density * shown**2)))


def _sizes(case: Case) -> np.ndarray:
    """(n,) radius of the ball around each body, 0 of one without end."""
    reach = np.array([build_shape(particle).reach for particle in case.particles])
    return np.where(np.isfinite(reach), reach, 0.0)
