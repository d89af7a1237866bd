"""The thesis' own dielectric solver: spectral derivatives at the cell centres of a periodic box.

    ∇·(ε(E∞ − ∇ψ)) = 0,    ε = ε₂ + (ε₁ − ε₂)φ,    ψ periodic with zero mean

fixed-point          ∇²ψⁿ⁺¹ = (E∞ − ∇ψⁿ)·∇ln ε,   ψ⁰ = 0                      the thesis' (4.27)
conjugate-gradients  on −∇·(ε∇ψ) = −∇·(εE∞), preconditioned by k⁻²

The first converges for moderate contrasts only. Its error, √Σ(ψⁿ⁺¹−ψⁿ)² over the points, is the
thesis', and grows with their number as N^{3/2}. All states live in Fourier space.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numba import njit, prange

from smoothprofile.electric.spectral import FourierBox
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid
from smoothprofile.profiles import Profile
from smoothprofile.solvers.krylov import PATIENCE, Status
from smoothprofile.transforms import to_modes, to_values

Method = Literal["fixed-point", "conjugate-gradients"]
METHODS = ("fixed-point", "conjugate-gradients")

GROWN = 10.0
"""Error of an iteration over that of the first that counts as divergence; where the iteration
converges the first is the largest."""
ROUND_OFF = 1e-10
"""Smallest error over the first, below which no progress is round-off and not divergence."""


@dataclass(frozen=True)
class FourierReport:
    """How a solve ended: status by name, and an error for each iteration.

    fixed-point: √Σ(ψⁿ⁺¹−ψⁿ)². conjugate-gradients: √(r·k⁻²r) over that of ψ = 0, the size of the
    gradient that the residual would raise in a uniform medium; it means the same on every grid.
    """

    status: Status
    errors: tuple[float, ...]

    @property
    def iterations(self) -> int:
        return len(self.errors)

    @property
    def converged(self) -> bool:
        return self.status == "converged"


def indicator_at_centres(
    grid: Grid,
    distance: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray],
    profile: Profile,
    thickness: float,
) -> np.ndarray:
    """φ(d/ξ) at the cell centres, (nx,ny,nz), by evaluation there and nowhere else.

    distance: signed distance d of points, from arrays x, y, z that broadcast.
    """
    x, y, z = (axis.padded_centres[1:-1] for axis in grid.axes)
    phi = np.empty(grid.shape)
    for plane, position in zip(phi, x, strict=True):
        plane[:] = profile.value(distance(position, y[:, None], z[None, :]) / thickness)
    return phi


class FourierSolver:
    """Solves for ψ with ε given at the cell centres; `modes` of ψ are kept as the next start.

    permittivity: (nx,ny,nz), positive; kept, not copied. CaseError unless it is positive and the
    grid periodic and uniform.
    """

    def __init__(self, grid: Grid, permittivity: np.ndarray):
        self.box = FourierBox(grid)
        smallest, largest = float(permittivity.min()), float(permittivity.max())
        if not (smallest > 0.0 and largest < math.inf):
            raise CaseError(
                f"the permittivity reaches from {smallest:g} to {largest:g}; it must be positive "
                "and finite everywhere."
            )
        self.permittivity = permittivity
        self.modes = self.box.new_modes()
        self._work, self._values = self.box.new_modes(), self.box.new_values()

    def solve(
        self,
        field: tuple[float, float, float],
        method: Method = "conjugate-gradients",
        tolerance: float = 1e-8,
        limit: int = 1000,
    ) -> FourierReport:
        """ψ for E∞ = field, until the method's error is at most `tolerance`.

        The fixed-point iteration starts from ψ = 0, conjugate gradients from the last ψ. After
        "diverged", ψ is not a number anywhere; after "iteration limit" or "stagnated" it is what
        has been reached, which need not be near the solution.
        """
        if method not in METHODS:
            raise CaseError(
                f"electric.method is {method!r}; it must be one of {', '.join(METHODS)}."
            )
        act = self._fixed_point if method == "fixed-point" else self._conjugate_gradients
        report = act(tuple(float(part) for part in field), tolerance, limit)
        if report.status == "diverged":
            self.modes[:] = math.nan
        return report

    def potential(self) -> np.ndarray:
        """ψ at the cell centres."""
        values = self.box.new_values()
        self._work[:] = self.modes
        to_values(self._work, values)
        return values

    def disturbance(self, d: int, out: np.ndarray | None = None) -> np.ndarray:
        """(−∇ψ)_d at the cell centres."""
        out = self.box.new_values() if out is None else out
        self.box.derivative(self.modes, d, self._work, out)
        return np.negative(out, out=out)

    def mean_displacement(self, field: tuple[float, float, float]) -> np.ndarray:
        """⟨ε(E∞ − ∇ψ)⟩, (3,); for a unit field along an axis, its part there is ε_eff."""
        mean = np.empty(3)
        for d in range(3):
            part = self.disturbance(d, self._values)
            mean[d] = _mean_product(self.permittivity, part, float(field[d]))
        return mean

    def _fixed_point(self, field, tolerance: float, limit: int) -> FourierReport:
        box, work, values = self.box, self._work, self._values
        old, new, right = self.modes, box.new_modes(), box.new_values()
        slopes = self._slopes_of_log(new)
        old[:] = 0.0
        errors: list[float] = []
        status: Status | None = None
        while status is None and len(errors) < limit:
            for d in range(3):
                box.derivative(old, d, work, values)
                _add_product(slopes[d], field[d], values, d == 0, right)
            to_modes(right, new)
            box.over_square(new, -1.0, new)
            errors.append(box.distance(new, old))
            old, new = new, old
            status = _judged(errors, tolerance)
        self.modes = old
        return FourierReport(status or "iteration limit", tuple(errors))

    def _slopes_of_log(self, modes: np.ndarray) -> list[np.ndarray]:
        """∇ln ε, by spectral derivatives; `modes` is scratch."""
        to_modes(np.log(self.permittivity, out=self._values), modes)
        slopes = []
        for d in range(3):
            slopes.append(self.box.new_values())
            self.box.derivative(modes, d, self._work, slopes[d])
        return slopes

    def _conjugate_gradients(self, field, tolerance: float, limit: int) -> FourierReport:
        box, solution = self.box, self.modes
        residual, direction, image = (box.new_modes() for _ in range(3))
        self._subtract_source(field, residual)
        box.over_square(residual, 1.0, image)
        reference, start = box.dot(residual, image), box.norm(solution)
        if reference == 0.0 or not math.isfinite(start):
            solution[:] = 0.0
        elif start > 0.0:
            self._add_flux(solution, 1.0, residual)
            box.over_square(residual, 1.0, image)
        product, beta, best, since = box.dot(residual, image), 0.0, math.inf, 0
        errors: list[float] = []
        while product > tolerance**2 * reference:
            if len(errors) == limit:
                return FourierReport("iteration limit", tuple(errors))
            _combine(direction, image, beta)
            image[:] = 0.0
            self._add_flux(direction, -1.0, image)
            curvature = box.dot(direction, image)
            # Not above zero: a number is not finite.
            if not curvature > 0.0:
                return FourierReport("diverged", tuple(errors))
            _add_scaled(solution, direction, product / curvature)
            _add_scaled(residual, image, -product / curvature)
            box.over_square(residual, 1.0, image)
            before, product = product, box.dot(residual, image)
            beta = product / before
            errors.append(math.sqrt(product / reference))
            best, since = (product, 0) if product < best else (best, since + 1)
            if since >= PATIENCE:
                return FourierReport("stagnated", tuple(errors))
        return FourierReport("converged", tuple(errors))

    def _subtract_source(self, field, out: np.ndarray) -> None:
        """out ← out − (modes of ∇·(εE∞))."""
        for d in range(3):
            if field[d] != 0.0:
                np.multiply(self.permittivity, -field[d], out=self._values)
                self.box.add_derivative(self._values, d, self._work, out)

    def _add_flux(self, modes: np.ndarray, sign: float, out: np.ndarray) -> None:
        """out ← out + sign·(modes of ∇·(ε∇f))."""
        for d in range(3):
            self.box.derivative(modes, d, self._work, self._values)
            _scale(self._values, self.permittivity, sign)
            self.box.add_derivative(self._values, d, self._work, out)


def _judged(errors: list[float], tolerance: float) -> Status | None:
    """How the fixed-point iteration ends with these errors, if it does."""
    error, first = errors[-1], errors[0]
    if error <= tolerance:
        return "converged"
    if not error <= GROWN * first:
        return "diverged"
    best = int(np.argmin(errors))
    if len(errors) - 1 - best < PATIENCE:
        return None
    # The errors of a growing oscillation have a least one too, but far above round-off.
    return "stagnated" if errors[best] <= ROUND_OFF * first else "diverged"


def _mean_product(permittivity: np.ndarray, disturbance: np.ndarray, mean: float) -> float:
    """⟨ε(E_d + (−∇ψ)_d)⟩, the same bits for any number of threads."""
    planes = np.zeros(permittivity.shape[0])
    _sum_products(permittivity, disturbance, mean, planes)
    return float(planes.sum()) / permittivity.size


@njit(parallel=True, cache=True)
def _sum_products(eps, disturbance, mean, planes):
    for i in prange(eps.shape[0]):
        sums = np.zeros(eps.shape[2])
        for j in range(eps.shape[1]):
            for k in range(eps.shape[2]):
                sums[k] += eps[i, j, k] * (mean + disturbance[i, j, k])
        planes[i] = sums.sum()


@njit(parallel=True, cache=True)
def _add_product(slope, mean, gradient, first, right):
    """right += (E_d − ∂_dψ)·∂_d ln ε, from nothing if first."""
    for i in prange(right.shape[0]):
        for j in range(right.shape[1]):
            for k in range(right.shape[2]):
                value = (mean - gradient[i, j, k]) * slope[i, j, k]
                right[i, j, k] = value if first else right[i, j, k] + value


@njit(parallel=True, cache=True)
def _scale(values, eps, sign):
    for i in prange(values.shape[0]):
        for j in range(values.shape[1]):
            for k in range(values.shape[2]):
                values[i, j, k] *= sign * eps[i, j, k]


@njit(parallel=True, cache=True)
def _combine(direction, image, beta):
    """p = z + βp."""
    for i in prange(direction.shape[0]):
        for j in range(direction.shape[1]):
            for m in range(direction.shape[2]):
                direction[i, j, m] = image[i, j, m] + beta * direction[i, j, m]


@njit(parallel=True, cache=True)
def _add_scaled(total, modes, factor):
    for i in prange(total.shape[0]):
        for j in range(total.shape[1]):
            for m in range(total.shape[2]):
                total[i, j, m] += factor * modes[i, j, m]
