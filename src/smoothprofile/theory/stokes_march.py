"""Time marching of the flow over an oscillating wall, on spectral elements.

The steps are those of `theory.stokes_layer`. Tested with the polynomials ψᵢ of the elements and
summed with Gauss–Lobatto quadrature, which makes the mass diagonal, a step reads

    (γ/Δt M + νθK) uˢ = (1/Δt) M Σ_q α_q uⁿ⁻q − ν(1−θ) K uⁿ,    K_ij = ∫ψᵢ'ψⱼ'dy,

one banded Cholesky factor for all steps; no flux at y = 0 comes by itself.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.sparse import coo_array, csr_array

from smoothprofile.theory.stokes_layer import OscillatingWall, Steps, exact_velocity, layer_edges

DEGREE = 8


@dataclass(frozen=True, eq=False)
class March:
    """What a march leaves behind.

    times      (n,) ends of the steps
    push       (n,) ∫f dy
    stress     (n,) τ, ∫f dy less the inertia of the slab
    y          (m,) points
    predicted  (m,) uˢ of the last step
    corrected  (m,) uⁿ⁺¹ of the last step
    """

    times: np.ndarray
    push: np.ndarray
    stress: np.ndarray
    y: np.ndarray
    predicted: np.ndarray
    corrected: np.ndarray


def march(wall: OscillatingWall, steps: Steps, count: int) -> March:
    """`count` steps from the exact flow at t = 0 and before, blended with the slab's motion.

    The past levels are u = φV + (1−φ)u_f, the thesis' (2.4), with the exact u_f continued into
    the slab, so that no kink is left at y = h for steps that damp short waves badly.
    """
    y, mass, stiffness = _elements(wall)
    phi = wall.solid(y)
    painted = mass * phi
    dt, levels = steps.step, len(steps.past)
    velocity_of = np.cos(wall.angular_frequency * dt * np.arange(-levels, count + 1))
    far = exact_velocity(wall, np.array([[wall.top]]), dt * np.arange(count + 1))[0]
    past = [_blended(wall, y, phi, -dt * q) for q in range(levels)]

    # The last point is the far boundary, whose velocity is given.
    banded = wall.viscosity * steps.implicit * stiffness
    banded[0] += steps.gamma / dt * mass
    factor = cholesky_banded(banded[:, :-1], lower=True)
    coupling = np.zeros(y.size - 1)
    coupling[-DEGREE:] = [banded[d, -1 - d] for d in range(DEGREE, 0, -1)]
    old_stress = _symmetric(wall.viscosity * (1.0 - steps.implicit) * stiffness)
    push = np.empty(count)
    predicted = np.empty_like(y)
    for n in range(count):
        known = mass / dt * sum(a * u for a, u in zip(steps.past, past, strict=True))
        if steps.implicit < 1.0:
            known -= old_stress @ past[0]
        predicted[-1] = far[n + 1]
        known = known[:-1] - coupling * far[n + 1]
        predicted[:-1] = cho_solve_banded((factor, True), known, check_finite=False)
        impulse = velocity_of[levels + n + 1] - predicted
        push[n] = steps.gamma / dt * (painted @ impulse)
        past = [predicted + phi * impulse, *past[:-1]]
    rate = steps.gamma * velocity_of[levels + 1 :]
    for q, a in enumerate(steps.past):
        rate = rate - a * velocity_of[levels - q : levels - q + count]
    times = dt * np.arange(1, count + 1)
    return March(times, push, push - wall.height / dt * rate, y, predicted, past[0])


def _blended(wall: OscillatingWall, y: np.ndarray, phi: np.ndarray, time: float) -> np.ndarray:
    """φV + (1−φ)u_f with u_f = Re exp(Y + i(Y + ωt)) on both sides of the surface."""
    turn = wall.angular_frequency * time
    height = np.sqrt(0.5 * wall.angular_frequency / wall.viscosity) * (wall.height - y)
    return phi * np.cos(turn) + (1.0 - phi) * np.exp(height) * np.cos(height + turn)


def _elements(wall: OscillatingWall) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (m,), mass (m,), and stiffness as the diagonals on and below the first, (9, m)."""
    nodes, weights, slopes = lobatto(DEGREE)
    edges = layer_edges(wall)
    half = 0.5 * np.diff(edges)
    local = slopes.T @ (weights[:, None] * slopes)
    size = half.size * DEGREE + 1
    y, mass, stiffness = np.empty(size), np.zeros(size), np.zeros((DEGREE + 1, size))
    i, j = np.tril_indices(DEGREE + 1)
    for element, h in enumerate(half):
        first = element * DEGREE
        inside = slice(first, first + DEGREE + 1)
        y[inside] = edges[element] + h * (1.0 + nodes)
        mass[inside] += h * weights
        stiffness[i - j, first + j] += local[i, j] / h
    return y, mass, stiffness


def _symmetric(lower: np.ndarray) -> csr_array:
    """The whole matrix of the diagonals on and below the first."""
    size = lower.shape[1]
    band, column = np.nonzero(lower)
    row, values = column + band, lower[band, column]
    off = band > 0
    entries = np.concatenate((values, values[off]))
    rows, columns = np.concatenate((row, column[off])), np.concatenate((column, row[off]))
    return coo_array((entries, (rows, columns)), shape=(size, size)).tocsr()


@lru_cache(maxsize=4)
def lobatto(degree: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Gauss–Lobatto points and weights on [−1, 1], and D_ij = ℓⱼ'(xᵢ).

    x are ±1 and the roots of P'_N, w = 2/(N(N+1)P_N²), D_ij = P_N(xᵢ)/(P_N(xⱼ)(xᵢ − xⱼ)), zero
    on the diagonal but for ∓N(N+1)/4 at its ends.
    """
    legendre = np.polynomial.legendre.Legendre.basis(degree)
    nodes = np.concatenate(([-1.0], np.sort(legendre.deriv().roots().real), [1.0]))
    values = legendre(nodes)
    weights = 2.0 / (degree * (degree + 1) * values**2)
    apart = nodes[:, None] - nodes
    np.fill_diagonal(apart, 1.0)
    slopes = values[:, None] / (values * apart)
    np.fill_diagonal(slopes, 0.0)
    slopes[0, 0], slopes[-1, -1] = -0.25 * degree * (degree + 1), 0.25 * degree * (degree + 1)
    return nodes, weights, slopes
