"""Creeping flow about one penalised round body inside a concentric wall: its drag and torque.

Steady state in the frame of the body, ν = ρ = 1, r from its centre, wall at r = R:

    ∇²W − ∇p − χ(r)W = 0,    ∇·(g W) = 0,    W the wall's motion at R.

W is the velocity that viscosity acts on, χW the impulse, gW the velocity that is projected.
A sphere is n = 3 dimensions, a cylinder n = 2; m = n − 1 below.
"""

import math
from collections.abc import Callable

import numpy as np
from scipy.special import ive

from smoothprofile.theory.collocation import solve_linear

Function = Callable[[np.ndarray], np.ndarray]


def penalised_drag(
    dimension: int,
    resistance: Function,
    weight_slope: Function,
    edges: np.ndarray,
    core: bool = False,
) -> float:
    """∫χW dV for unit relative speed, per viscosity (a cylinder's: per length).

    With W = A cosθ e_r − B sinθ e_θ, p = P cosθ, ℓ = g'/g and Q = P + ℓA, which is free of ℓ':

        A' = m(B−A)/r − ℓA,    B' = D/r,    D = rB',    T = rQ
        D' = ((1−m)D + 2(B−A) + T)/r − ℓA + rχB
        T' = (T + mD + m(B−A))/r − rχA

    At R, A = B = 1. The force is the momentum that crosses r = R, (S/n)Rᵐ(mB' − Q), S = 4π or
    2π. Near the centre the solution is the uniform stream plus the parabolic one of p = r cosθ:
    D = (m+2)(B−A) and T = m(m+3)(B−A).

    resistance: χ(r); weight_slope: ℓ(r); edges: of the elements, from a radius that is small
    beside everything else, to R. core: g = 0 and χ is uniform inside the first edge, where ℓ is
    infinite; see `core_conditions`.
    """
    m = dimension - 1

    def matrix(r: np.ndarray) -> np.ndarray:
        slope, drag = weight_slope(r), r * resistance(r)
        rows = np.zeros((r.size, 4, 4))
        rows[:, 0, 0], rows[:, 0, 1] = -m / r - slope, m / r
        rows[:, 1, 2] = 1 / r
        rows[:, 2, 0], rows[:, 2, 1] = -2 / r - slope, 2 / r + drag
        rows[:, 2, 2], rows[:, 2, 3] = (1 - m) / r, 1 / r
        rows[:, 3, 0], rows[:, 3, 1] = -m / r - drag, m / r
        rows[:, 3, 2], rows[:, 3, 3] = m / r, 1 / r
        return rows

    if core:
        left = core_conditions(dimension, edges[0], float(resistance(edges[:1])[0]))
    else:
        left = np.array([[m + 2, -m - 2, 1, 0], [m * (m + 3), -m * (m + 3), 0, 1]], dtype=float)
    right = np.array([[1.0, 0, 0, 0], [0, 1.0, 0, 0]])
    y = solve_linear(matrix, edges, left, right, np.ones(2))
    area = 2 * math.pi * m / dimension * edges[-1] ** (m - 1)
    return float(area * (m * y[-1, 2] - y[-1, 3]))


def core_conditions(dimension: int, radius: float, resistance: float) -> np.ndarray:
    """The two linear conditions on (A, B, D, T) at the rim of a core where g = 0.

    There ∇·(gW) = 0 says nothing. Time-marching does: u** is rigid in the core at every step,
    so every pressure increment is harmonic there, and so is their sum, P = cr. Then
    ∇²W − χW = ∇p leaves W three regular solutions of amplitudes to be found:

        the uniform −c/χ,    ∇(f cosθ),    the solenoidal A = f/r, B = A + rA'/m

    with f = r^{1−n/2} I_{n/2}(√χ r). At the rim ℓ ~ 2/(r − radius), and gW stays finite only if
    A = 0; B and B' are continuous, and so is the normal traction A' − P (P itself is not: the
    weight g that carries it vanishes). The two combinations of the three with A = 0 span the
    (B, D, T) allowed outside; the second condition is normal to both.
    """
    m, r = dimension - 1, radius
    root = math.sqrt(resistance)
    order = dimension / 2
    # f'/f and f''/f; the exponentially scaled Bessel functions keep their ratio.
    ratio = ive(order - 1, root * r) / ive(order, root * r)
    first = root * ratio + (1 - dimension) / r
    second = -m * first / r + resistance + m / r**2
    spread = first - 1 / r
    # Columns A, B, rB', r(A' − P).
    modes = np.array(
        [
            [1.0, 1.0, 0.0, resistance * r * r],
            [first, 1 / r, spread, r * second],
            [
                1 / r,
                1 / r + spread / m,
                spread + (r * second - spread) / m,
                spread,
            ],
        ]
    )
    # Outside, with A = 0: T = r(P + ℓA) = mB − r(A' − P).
    states = np.column_stack((modes[:, 1], modes[:, 2], m * modes[:, 1] - modes[:, 3]))
    modes_a = modes[:, 0]
    pairs = [states[i] * modes_a[0] - states[0] * modes_a[i] for i in (1, 2)]
    normal = np.cross(pairs[0], pairs[1])
    return np.array([[1.0, 0, 0, 0], [0, *(normal / np.abs(normal).max())]])


def penalised_torque(dimension: int, resistance: Function, edges: np.ndarray) -> float:
    """∫r sinθ χW dV for unit relative rate of rotation, per viscosity (cylinder: per length).

    W = A sinθ e_φ (cylinder: A e_θ) has no divergence and makes no pressure:

        A'' + mA'/r − mA/r² − χA = 0,    A = R at the wall,    A ~ r at the centre;

    the torque is the angular momentum that crosses it, 8πR³(A' − A/R)/3 or 2πR²(A' − A/R).
    """
    m = dimension - 1

    def matrix(r: np.ndarray) -> np.ndarray:
        rows = np.zeros((r.size, 2, 2))
        rows[:, 0, 1] = 1 / r
        rows[:, 1, 0] = m / r + r * resistance(r)
        rows[:, 1, 1] = (1 - m) / r
        return rows

    wall = edges[-1]
    y = solve_linear(matrix, edges, np.array([[1.0, -1]]), np.array([[1.0, 0]]), np.array([wall]))
    area = 2 * math.pi if dimension == 2 else 8 * math.pi / 3
    return float(area * wall**m * (y[-1, 1] - wall))
