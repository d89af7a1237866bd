"""Linear two-point boundary value problems by Gauss collocation."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from scipy.linalg import solve_banded

ORDER = 8


@lru_cache(maxsize=4)
def gauss_stages(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes c, matrix a and weights b of the Gauss–Runge–Kutta method on [0, 1].

    a_ij = ∫₀^{c_i} ℓ_j, b_j = ∫₀¹ ℓ_j, ℓ_j the Lagrange polynomials of the nodes.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    legendre = np.polynomial.legendre.legvander(nodes, count)
    degree = np.arange(count)
    # ∫_{-1}^{x} P_n = (P_{n+1} − P_{n−1})/(2n+1), and 1 + x for n = 0.
    integrals = np.empty((count, count))
    integrals[:, 0] = 1.0 + nodes
    integrals[:, 1:] = (legendre[:, 2:] - legendre[:, :-2]) / (2.0 * degree[1:] + 1.0)
    coefficients = (degree[:, None] + 0.5) * legendre[:, :count].T * weights
    return 0.5 * (1.0 + nodes), 0.5 * integrals @ coefficients, 0.5 * weights


def solve_linear(
    matrix: Callable[[np.ndarray], np.ndarray],
    edges: np.ndarray,
    left: np.ndarray,
    right: np.ndarray,
    values: np.ndarray,
) -> np.ndarray:
    """y at the edges, where y' = M(x) y, left·y(first) = 0, right·y(last) = values.

    Each element carries the polynomial of degree 8 that satisfies the equation at eight Gauss
    points (order 16 at the edges for smooth M). Its inner values are eliminated, and what
    remains is one band matrix.

    matrix: x (n,) -> M (n, m, m), finite inside the elements, and at most of the first kind
    singular (1/distance) at the two ends. edges: (e+1,) rising. left: (p, m);
    right: (m−p, m); values: (m−p,). Returns (e+1, m).
    """
    transfer = _transfers(matrix, edges)
    elements, size = transfer.shape[:2]
    rows = len(left) + elements * size + len(right)
    # Row i meets columns from i−below to i+above: a block spans two neighbouring edges.
    below, above = len(left) + size - 1, 2 * size - 1 - len(left)
    band = np.zeros((below + above + 1, rows))

    def place(row, column, block):
        i = row + np.arange(block.shape[0])[:, None]
        j = column + np.arange(block.shape[1])[None, :]
        band[above + i - j, np.broadcast_to(j, block.shape)] = block

    place(0, 0, np.asarray(left))
    for element in range(elements):
        block = np.hstack((-transfer[element], np.eye(size)))
        place(len(left) + element * size, element * size, block)
    place(rows - len(right), rows - size, np.asarray(right))
    known = np.zeros(rows)
    known[rows - len(right) :] = values
    return solve_banded((below, above), band, known).reshape(elements + 1, size)


def _transfers(matrix: Callable[[np.ndarray], np.ndarray], edges: np.ndarray) -> np.ndarray:
    """(e, m, m) with y(right edge) = transfer · y(left edge), by the eight-stage Gauss method."""
    nodes, a, b = gauss_stages(ORDER)
    width = np.diff(edges)
    x = edges[:-1, None] + width[:, None] * nodes
    m = matrix(x.ravel())
    m = m.reshape(*x.shape, *m.shape[1:])
    elements, stages, size = m.shape[:3]
    # Stage slopes K_i = M_i (y + h Σ_j a_ij K_j).
    coupled = -np.einsum("e,ij,eipq->eipjq", width, a, m)
    system = coupled.reshape(elements, stages * size, stages * size)
    system += np.eye(stages * size)
    slopes = np.linalg.solve(system, m.reshape(elements, stages * size, size))
    slopes = slopes.reshape(elements, stages, size, size)
    return np.eye(size) + np.einsum("e,j,ejpq->epq", width, b, slopes)
