"""How far a flat penalised wall seems to stand from its painted place.

In the frame of the solid and at steady state, viscosity acts on W, which obeys

    W'' = χ(z) W,    W ~ e^{κz} deep in the solid,    W → slope·(z + s₀) far out in the fluid.

z is the distance to the wall over ξ, negative in the solid; s₀ξ is how far the wall retreats
into the solid.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.special import digamma

from smoothprofile.theory.collocation import solve_linear

# Enough for 1e-10 in s₀ down to k = 0.003.
ELEMENTS = 32


def tanh_shift(ratio: float, implicit: float = 1.0) -> float:
    """s₀ = −½ ln θ − Γ − ψ(1/(2κ)) − κ, κ = k√θ, for φ = ½(1 − tanh z).

    ratio: k = √(νΔt/γ₀)/ξ; implicit: θ. Γ is Euler's constant, ψ the digamma function.

    Derivation. With θ = 1, χ = φ/k² = 1/(k²(1+e^{2z})). In the variable −e^{2z} the solution
    that decays into the solid is e^{z/k}₂F₁(1/(2k), 1/(2k); 1+1/k; −e^{2z}); its connection
    formula, with equal parameters, has a logarithm whose constant is s₀. With θ < 1 the weight
    φ/(1−(1−θ)φ) = φ(z − ½ln θ)/θ is a tanh again: moved in by ½ln(1/θ), k multiplied by √θ.
    """
    k = ratio * math.sqrt(implicit)
    return -0.5 * math.log(implicit) - np.euler_gamma - float(digamma(0.5 / k)) - k


def planar_shift(
    resistance: Callable[[np.ndarray], np.ndarray], inner: float, outer: float
) -> float:
    """s₀ = W/W' at `outer`, less `outer`; W' = √χ W at `inner`.

    resistance: χ(z), constant below `inner` and zero above `outer`.
    """
    root = math.sqrt(float(resistance(np.array([inner]))[0]))

    def matrix(z: np.ndarray) -> np.ndarray:
        rows = np.zeros((z.size, 2, 2))
        rows[:, 0, 1] = 1.0
        rows[:, 1, 0] = resistance(z)
        return rows

    edges = np.linspace(inner, outer, ELEMENTS + 1)
    left, right = np.array([[-root, 1.0]]), np.array([[0.0, 1.0]])
    return float(solve_linear(matrix, edges, left, right, np.ones(1))[-1, 0]) - outer
