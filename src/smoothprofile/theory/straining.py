"""A straining flow about one penalised sphere inside a concentric wall: its stresslet.

Steady state, ν = ρ = 1, Y = n·E·n for n = x/r and a symmetric E without trace:

    ∇²W − ∇p − χ(r)W = 0,    ∇·(g W) = 0,    W = E·x on the wall r = R.

W is the velocity that viscosity acts on, χW the impulse, gW the velocity that is projected.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.special import ive

from smoothprofile.theory.collocation import solve_linear

Function = Callable[[np.ndarray], np.ndarray]


def penalised_stresslet(
    resistance: Function, weight_slope: Function, edges: np.ndarray, core: bool = False
) -> float:
    """s in ∫x(χW) dV = s E, per viscosity: how strongly the sphere resists the strain.

    With W = A Y e_r + B r∇Y, p = P Y, ℓ = g'/g and Q = P + ℓA, which is free of ℓ':

        A' = (6B − 2A)/r − ℓA,    B' = D/r,    D = rB',    T = rQ
        D' = (6B − 2A − D + T)/r − ℓA + rχB
        T' = (T + 6D + 6(B−A))/r − rχA

    At R, A = R and B = R/2. The moment of the impulse is that of the traction on r = R less what
    the strain has without a sphere, s = (8π/15)R²(3D − T − 3R/2). Near the centre the solution is
    the strain (2, 1, 1, 0)r plus the flow (6, 5, 15, 42)r³ of p = 42r²Y.

    resistance: χ(r); weight_slope: ℓ(r); edges: of the elements, from a radius that is small
    beside everything else, to R. core: g = 0 and χ is uniform inside the first edge.
    """

    def matrix(r: np.ndarray) -> np.ndarray:
        slope, drag = weight_slope(r), r * resistance(r)
        rows = np.zeros((r.size, 4, 4))
        rows[:, 0, 0], rows[:, 0, 1] = -2 / r - slope, 6 / r
        rows[:, 1, 2] = 1 / r
        rows[:, 2, 0], rows[:, 2, 1] = -2 / r - slope, 6 / r + drag
        rows[:, 2, 2], rows[:, 2, 3] = -1 / r, 1 / r
        rows[:, 3, 0], rows[:, 3, 1] = -6 / r - drag, 6 / r
        rows[:, 3, 2], rows[:, 3, 3] = 6 / r, 1 / r
        return rows

    if core:
        left = core_conditions(edges[0], float(resistance(edges[:1])[0]))
    else:
        left = np.array([[5.0, -12.0, 2.0, 0.0], [21.0, -42.0, 0.0, 2.0]])
    right = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0]])
    wall = edges[-1]
    y = solve_linear(matrix, edges, left, right, np.array([wall, 0.5 * wall]))
    return float(8 * math.pi / 15 * wall**2 * (3 * y[-1, 2] - y[-1, 3] - 1.5 * wall))


def core_conditions(radius: float, resistance: float) -> np.ndarray:
    """The two linear conditions on (A, B, D, T) at the rim of a core where g = 0.

    As `radial.core_conditions`, for the second harmonic: inside, W is a sum of ∇(r²Y) with
    p = −χr²Y, of ∇(fY), and of the solenoidal A = f/r, B = (f/r + f')/6, with f = r^{−1/2}
    I_{5/2}(√χ r). A = 0 at the rim; B, B' and A' − P are continuous.
    """
    r, root = radius, math.sqrt(resistance)
    # f'/f and f''/f; the exponentially scaled Bessel functions keep their ratio.
    first = root * ive(1.5, root * r) / ive(2.5, root * r) - 3 / r
    second = -2 * first / r + resistance + 6 / r**2
    # Columns A, B, rB', r(A' − P).
    modes = np.array(
        [
            [2.0, 1.0, 1.0, 2.0 + resistance * r * r],
            [first, 1 / r, first - 1 / r, r * second],
            [1 / r, (1 / r + first) / 6, (first - 1 / r + r * second) / 6, first - 1 / r],
        ]
    )
    # Outside, with A = 0: T = r(P + ℓA) = 6B − r(A' − P).
    states = np.column_stack((modes[:, 1], modes[:, 2], 6 * modes[:, 1] - modes[:, 3]))
    pairs = [states[i] * modes[0, 0] - states[0] * modes[i, 0] for i in (1, 2)]
    normal = np.cross(*pairs)
    return np.array([[1.0, 0, 0, 0], [0, *(normal / np.abs(normal).max())]])
