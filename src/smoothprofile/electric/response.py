"""The effective permittivity of a periodic box of bodies.

ε_eff E₀ = ⟨D⟩,   E₀ = e_x, e_y, e_z in turn
"""

import numpy as np

from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.errors import CaseError
from smoothprofile.solvers.krylov import SolveReport


def effective_permittivity(
    solver: PotentialSolver, medium: Permittivity, tolerance: float = 1e-6, limit: int = 1000
) -> tuple[np.ndarray, list[SolveReport]]:
    """ε_eff (3,3) and the reports of its three solves; CaseError unless all axes are periodic.

    Symmetric up to the residuals, which enter its diagonal squared. ψ is left as it was.
    """
    if not all(medium.grid.periodic):
        raise CaseError("an effective permittivity tensor needs a box with three periodic axes.")
    before, tensor, reports = solver.potential.copy(), np.empty((3, 3)), []
    for d in range(3):
        field = tuple(float(c == d) for c in range(3))
        solver.potential[:] = 0.0
        reports.append(solver.solve(medium, field, tolerance, limit))
        tensor[:, d] = solver.mean_displacement(medium, field)
    solver.potential[:] = before
    return tensor, reports
