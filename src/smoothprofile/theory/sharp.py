"""Exact resistances of sharp bodies in creeping flow inside a concentric wall, per viscosity.

λ = a/R, the body's radius over the wall's. Divide by a length for the two cylinders.
"""

import math


def sphere_drag(radius: float, wall: float) -> float:
    """6πa(1−λ⁵)/(1 − 9λ/4 + 5λ³/2 − 9λ⁵/4 + λ⁶), for unit relative speed.

    Source: Happel & Brenner, Low Reynolds Number Hydrodynamics, §4-22.
    """
    ratio = radius / wall
    denominator = 1 - 2.25 * ratio + 2.5 * ratio**3 - 2.25 * ratio**5 + ratio**6
    return 6 * math.pi * radius * (1 - ratio**5) / denominator


def cylinder_drag(radius: float, wall: float) -> float:
    """4π/(ln(R/a) − (R²−a²)/(R²+a²)), for unit relative speed across the axis, per length."""
    ratio = radius / wall
    return 4 * math.pi / (-math.log(ratio) - (1 - ratio**2) / (1 + ratio**2))


def sphere_torque(radius: float, wall: float) -> float:
    """8πa³/(1−λ³), for unit relative rate of rotation about a diameter."""
    return 8 * math.pi * radius**3 / (1 - (radius / wall) ** 3)


def sphere_stresslet(radius: float, wall: float) -> float:
    """(20/3)πa³·4(1−λ⁷)/(4 − 25λ³ + 42λ⁵ − 25λ⁷ + 4λ¹⁰), over the rate of strain at the wall.

    Source: Simha's cell, as in Happel & Brenner, §9-4; at λ = 0 Einstein's (20/3)πa³.
    """
    ratio = radius / wall
    denominator = 4 - 25 * ratio**3 + 42 * ratio**5 - 25 * ratio**7 + 4 * ratio**10
    return 80 / 3 * math.pi * radius**3 * (1 - ratio**7) / denominator


def cylinder_torque(radius: float, wall: float) -> float:
    """4πa²/(1−λ²), for unit relative rate of rotation about the axis, per length."""
    return 4 * math.pi * radius**2 / (1 - (radius / wall) ** 2)
