"""Which time steps are stable: von Neumann's analysis of the scheme, with frozen speeds.

    (γ + θλΔt) zᴶ − Σ_q (α_q − iωΔt β_q − [q=0](1−θ)λΔt) zᴶ⁻¹⁻q = 0

ω = ΣU_d sin(k_d h_d)/h_d from central advection, λ = νΣ(2 sin(k_d h_d/2)/h_d)² from viscosity.
Walls bound the wave numbers from below: between no-slip walls nothing is longer than k = π/L, and
the viscous damping that this leaves allows larger steps than U²Δt ≤ 2ν.
"""

import numpy as np

from smoothprofile.grid import Grid
from smoothprofile.schemes import Scheme

SAMPLES = 14
# Growth by this factor a step is round-off of the neutral modes, not an instability.
TOLERANCE = 1e-6


def growth(
    grid: Grid, walled: tuple[bool, ...], nu: float, speed: tuple, scheme: Scheme, dt: float
) -> float:
    """Largest |z| over the waves of the grid; speed = largest |u| along each axis.

    walled[d] says that both ends of axis d are no-slip walls.
    """
    omega, damping = np.zeros(1), np.zeros(1)
    for d in range(3):
        angle = _angles(grid.shape[d], grid.lengths[d], grid.smallest_widths[d], walled[d])
        h = grid.smallest_widths[d]
        omega = np.add.outer(omega, speed[d] * np.sin(angle) / h).ravel()
        damping = np.add.outer(damping, nu * (2 * np.sin(angle / 2) / h) ** 2).ravel()
    return float(np.abs(_roots(scheme, omega * dt, damping * dt)).max())


def largest_stable_step(
    grid: Grid, walled: tuple[bool, ...], nu: float, speed: tuple, scheme: Scheme
) -> float:
    """The largest Δt up to which no wave grows; infinite for a fluid at rest."""
    if not any(speed):
        return float("inf")

    def stable(dt: float) -> bool:
        return growth(grid, walled, nu, speed, scheme, dt) <= 1.0 + TOLERANCE

    courant = 1.0 / sum(s / h for s, h in zip(speed, grid.smallest_widths, strict=True))
    low, high = 0.0, max(courant, 4.0 * nu / sum(s * s for s in speed))
    while stable(high):
        low, high = high, 2.0 * high
        if high > 1e6 * courant:
            return float("inf")
    if low == 0.0:
        low = high
        while not stable(low) and low > 1e-6 * courant:
            low, high = 0.5 * low, low
    for _ in range(12):
        middle = np.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return float(low)


def _angles(cells: int, length: float, width: float, walled: bool) -> np.ndarray:
    """Phase angles kh from the longest wave to the shortest, both signs of propagation alike."""
    longest = (np.pi if walled else 2 * np.pi) * width / length
    positive = np.geomspace(min(longest, np.pi), np.pi, min(SAMPLES, cells))
    return positive if walled else np.concatenate([[0.0], positive])


def _roots(scheme: Scheme, advection: np.ndarray, damping: np.ndarray) -> np.ndarray:
    levels = scheme.levels
    lead = scheme.gamma + scheme.implicit * damping
    matrix = np.zeros((advection.size, levels, levels), dtype=complex)
    for q in range(levels):
        past = scheme.past[q] if q < len(scheme.past) else 0.0
        weight = scheme.advection[q] if q < len(scheme.advection) else 0.0
        matrix[:, 0, q] = past - 1j * weight * advection
    matrix[:, 0, 0] -= (1.0 - scheme.implicit) * damping
    matrix[:, 0, :] /= lead[:, None]
    for q in range(1, levels):
        matrix[:, q, q - 1] = 1.0
    return np.linalg.eigvals(matrix) if levels > 1 else matrix[:, 0, 0]
