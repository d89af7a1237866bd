"""The field around given bodies by the thesis' own discretisation, as `field.ResolvedField`.

ε = ε_fluid + Σ w_b(ε_b − ε_fluid), w_b = φ_b Π_{c later}(1 − φ_c), at the cell centres; it has no
discrete energy of the bodies' places, and gives no loads.
"""

import math
from collections.abc import Sequence
from functools import partial
from itertools import product

import numpy as np

from smoothprofile.electric.field import Drive
from smoothprofile.electric.fourier import (
    FourierReport,
    FourierSolver,
    Method,
    indicator_at_centres,
)
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState
from smoothprofile.profiles import Profile
from smoothprofile.shapes import Shape
from smoothprofile.solvers.krylov import SolveReport


class SpectralField:
    """The field of bodies on a periodic uniform grid; `indicator` is φ of all at the centres."""

    def __init__(
        self,
        grid: Grid,
        shapes: Sequence[Shape],
        permittivity: Sequence[float],
        fluid: float,
        profile: Profile,
        thickness: float,
        drive: Drive,
        method: Method = "fixed-point",
        tolerance: float = 1e-6,
        limit: int = 1000,
    ):
        self.grid, self.drive = grid, drive
        self._shapes = list(shapes)
        self._permittivity, self._fluid = list(permittivity), fluid
        self._profile, self._thickness = profile, thickness
        self._method, self._tolerance, self._limit = method, tolerance, limit
        self._solver: FourierSolver | None = None
        self.indicator = np.zeros(grid.shape)

    def solve(self, state: BodyState) -> SolveReport:
        """Paint ε where the bodies are and find ψ."""
        self._solver = FourierSolver(self.grid, self._paint(state))
        return self._solve(self.drive.field)

    def effective(self) -> tuple[np.ndarray, list[SolveReport]]:
        """ε_eff (3,3), and the reports of its three solves; ψ is left as it was."""
        before, tensor, reports = self._solver.modes.copy(), np.empty((3, 3)), []
        for d in range(3):
            field = tuple(float(c == d) for c in range(3))
            self._solver.modes[:] = 0.0
            reports.append(self._solve(field))
            tensor[:, d] = self._solver.mean_displacement(field)
        self._solver.modes[:] = before
        return tensor, reports

    def mean_displacement(self) -> np.ndarray:
        """⟨D⟩, (3,)."""
        return self._solver.mean_displacement(self.drive.field)

    def energy(self) -> float:
        """½∫εE² dV."""
        square = np.einsum("cijk,cijk->ijk", self.vectors, self.vectors)
        return 0.5 * float((self._solver.permittivity * square).mean()) * self.grid.volume

    @property
    def potential(self) -> np.ndarray:
        """V at the cell centres, (nx,ny,nz)."""
        return self.drive.outer_potential(self.grid) + self._solver.potential()

    @property
    def vectors(self) -> np.ndarray:
        """E at the cell centres, (3,nx,ny,nz)."""
        return np.stack([self.drive.field[d] + self._solver.disturbance(d) for d in range(3)])

    def _solve(self, field: tuple[float, float, float]) -> SolveReport:
        report: FourierReport = self._solver.solve(
            field, self._method, self._tolerance, self._limit
        )
        error = report.errors[-1] if report.errors else 0.0
        return SolveReport(report.iterations, error, report.status)

    def _paint(self, state: BodyState) -> np.ndarray:
        total, fluid = np.full(self.grid.shape, self._fluid), np.ones(self.grid.shape)
        for shape, value, position, turn in zip(
            self._shapes, self._permittivity, state.position, state.rotation, strict=True
        ):
            distance = partial(self._distance, shape, position, turn)
            phi = indicator_at_centres(self.grid, distance, self._profile, self._thickness)
            total += phi * (value - total)
            fluid *= 1.0 - phi
        self.indicator = 1.0 - fluid
        return total

    def _distance(self, shape: Shape, position, turn, *coordinates) -> np.ndarray:
        """Signed distance of points to the nearest image of a body."""
        lengths, near = self.grid.lengths, []
        for x, centre, length in zip(coordinates, position, lengths, strict=True):
            r = x - centre
            near.append(r - length * np.rint(r / length))
        # A body longer than half a period may be nearest by an image that is not the nearest.
        long = [math.isfinite(shape.reach) and shape.reach >= 0.5 * length for length in lengths]
        nearest = np.inf
        for image in product(*((-1, 0, 1) if more else (0,) for more in long)):
            moved = [r - n * length for r, n, length in zip(near, image, lengths, strict=True)]
            points = np.stack(np.broadcast_arrays(*moved), axis=-1)
            nearest = np.minimum(nearest, shape.distance(points @ turn))
        return nearest
