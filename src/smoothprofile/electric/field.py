"""The field around given bodies, behind three verbs: solve, loads, effective.

    V = −E₀·(x − x_m) + V_m + ψ,   E = −∇V

x_m is the middle of the box and V_m the mean of the electrodes' potentials, 0 without them. What
is asked for at cell centres is the mean over the two faces of each cell.
"""

from dataclasses import dataclass

import numpy as np

from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.electric.forces import BodyLoads, body_loads
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.electric.response import effective_permittivity
from smoothprofile.grid import Grid, interior
from smoothprofile.particles.bodies import BodyState, bodies_at
from smoothprofile.sampling import CENTRED, centred_velocity, interpolate
from smoothprofile.solvers.krylov import SolveReport


@dataclass(frozen=True)
class Drive:
    """E₀ (3,) along the box's axes, and V_m, the potential in the middle."""

    field: tuple[float, float, float]
    potential: float = 0.0

    def outer_potential(self, grid: Grid) -> np.ndarray:
        """V_m − E₀·(x − x_m) at the cell centres."""
        total = np.full(grid.shape, self.potential)
        for d, axis in enumerate(grid.axes):
            shape = [1, 1, 1]
            shape[d] = -1
            middle = axis.low + 0.5 * axis.length
            total -= self.field[d] * (axis.centres - middle).reshape(shape)
        return total


class ResolvedField:
    """The field of a painted medium on the staggered grid; the last ψ starts the next solve.

    painted: the bodies as they were when ε was painted last.
    """

    def __init__(
        self,
        medium: Permittivity,
        drive: Drive,
        electrodes: int | None = None,
        tolerance: float = 1e-6,
        limit: int = 1000,
    ):
        self.grid, self.medium, self.drive = medium.grid, medium, drive
        self.solver = PotentialSolver(medium.grid, electrodes)
        self.tolerance, self.limit = tolerance, limit
        self.painted: BodyState | None = None

    def solve(self, state: BodyState) -> SolveReport:
        """Paint ε where the bodies are and find ψ."""
        self.paint(state)
        return self.solver.solve(self.medium, self.drive.field, self.tolerance, self.limit)

    def paint(self, state: BodyState) -> None:
        """ε where the bodies are."""
        self.medium.paint(state, self.solver.scratch)
        self.painted = bodies_at(state.position, state.quaternion)

    def loads(self, state: BodyState) -> BodyLoads:
        """Force, torque and dipole moment of each body, no net force along periodic axes."""
        solver = self.solver
        loads = body_loads(self.medium, state, solver.potential, self.drive.field, solver.geometry)
        return loads.balanced(self.grid.periodic)

    def effective(self) -> tuple[np.ndarray, list[SolveReport]]:
        """ε_eff (3,3) of a box with three periodic axes, and the reports of its solves."""
        return effective_permittivity(self.solver, self.medium, self.tolerance, self.limit)

    def mean_displacement(self) -> np.ndarray:
        """⟨D⟩, (3,)."""
        return self.solver.mean_displacement(self.medium, self.drive.field)

    def energy(self) -> float:
        """½∫E·εE dV."""
        return self.solver.energy(self.medium, self.drive.field)

    @property
    def indicator(self) -> np.ndarray:
        """φ of all bodies at the cell centres, (nx,ny,nz)."""
        self.medium.painter.paint(self.painted)
        return self.medium.painter.centred()

    @property
    def faces(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """E on the faces, padded fields."""
        return self.solver.field(self.drive.field)

    @property
    def potential(self) -> np.ndarray:
        """V at the cell centres, (nx,ny,nz)."""
        return self.drive.outer_potential(self.grid) + interior(self.solver.potential)

    @property
    def vectors(self) -> np.ndarray:
        """E at the cell centres, (3,nx,ny,nz)."""
        return centred_velocity(self.faces)


def at_points(grid: Grid, vectors: np.ndarray, points: np.ndarray) -> np.ndarray:
    """E (m,3) at points (m,3), linear between the cell centres."""
    values = np.empty((points.shape[0], 3))
    for c, part in enumerate(vectors):
        values[:, c] = interpolate(grid, padded(grid, part), CENTRED, points)
    return values


def padded(grid: Grid, values: np.ndarray) -> np.ndarray:
    """Values at cell centres with their ghosts: those next to a wall are repeated."""
    field = grid.zeros()
    interior(field)[...] = values
    fill_ghosts(field, pressure_boundary(grid))
    return field
