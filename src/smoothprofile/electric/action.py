"""What a field does to moving bodies: their loads, solved anew every so many steps."""

from collections.abc import Callable
from dataclasses import asdict, fields
from typing import Any

import numpy as np

from smoothprofile.electric.field import Drive, ResolvedField
from smoothprofile.electric.forces import BodyLoads
from smoothprofile.errors import BlowUpError
from smoothprofile.grid import Grid
from smoothprofile.particles.bodies import BodyState
from smoothprofile.solvers.krylov import SolveReport


class ElectricAction:
    """Force and torque on bodies, (n,6), wherever they are; the last ψ starts the next solve.

    `lag` is how far the force had moved, over the largest, when it was last found anew: with
    every = 1 what a step changes, with every = m the most that holding it has left out.

    To go on as if never stopped, a checkpoint holds ψ, the loads, `lag`, and how many steps ago
    they were found; the last report, drive and painted bodies are what a run tells of between two
    solves. ε and all else follow from where bodies are.
    """

    def __init__(self, field: ResolvedField, drive: Callable[[float], Drive], every: int = 1):
        """drive: time -> what drives the field."""
        self.field, self._drive, self._every = field, drive, every
        self.loads: BodyLoads | None = None
        self.report: SolveReport | None = None
        self.lag = 0.0
        self._since = 0

    def __call__(self, state: BodyState, time: float) -> np.ndarray:
        """The loads at that time; BlowUpError if the potential does not converge."""
        self._since += 1
        if self.loads is None or self._since >= self._every:
            self._since = 0
            self._find(state, time)
        return np.concatenate([self.loads.force, self.loads.torque], axis=1)

    def _find(self, state: BodyState, time: float) -> None:
        field = self.field
        field.drive = self._drive(time)
        self.report = field.solve(state)
        if not self.report.converged:
            raise BlowUpError(
                f"the potential did not converge at t = {time:.6g}: {self.report.status} after "
                f"{self.report.iterations} iterations, at a residual of {self.report.residual:.3g} "
                f"against electric.tolerance = {field.tolerance:g}."
            )
        loads = field.loads(state)
        size = float(np.abs(loads.force).max(initial=0.0))
        if self.loads is not None and size > 0.0:
            self.lag = float(np.abs(loads.force - self.loads.force).max()) / size
        self.loads = loads

    def saved(self) -> dict:
        """ψ, which starts the next solve, the loads that may be held, and when to solve again."""
        loads = self.loads and {
            item.name: getattr(self.loads, item.name) for item in fields(self.loads)
        }
        return {
            "potential": self.field.solver.potential,
            "painted": self.field.painted and self.field.painted.saved(),
            "loads": loads,
            "report": self.report and asdict(self.report),
            "drive": asdict(self.field.drive),
            "lag": self.lag,
            "since": self._since,
        }

    def restore(self, saved: dict) -> None:
        """Take back what `saved` gave."""
        if saved["painted"] is None:
            return
        self.field.solver.potential[...] = saved["potential"]
        self.loads = saved["loads"] and BodyLoads(**saved["loads"])
        self.report = saved["report"] and SolveReport(**saved["report"])
        self.field.drive = Drive(tuple(saved["drive"]["field"]), saved["drive"]["potential"])
        self.field.paint(BodyState(**saved["painted"]))
        self.lag, self._since = saved["lag"], saved["since"]

    def history(self) -> dict[str, Any]:
        """Numbers of the last solve for a run's history."""
        if self.report is None:
            none = {"potential_iterations": 0, "electric_energy": 0.0, "permittivity_along": 1.0}
            return none | {"electric_lag": 0.0}
        e = np.array(self.field.drive.field)
        square = float(e @ e)
        along = float(self.field.mean_displacement() @ e) / square if square > 0.0 else float("nan")
        return {
            "potential_iterations": self.report.iterations,
            "electric_energy": self.field.energy(),
            "permittivity_along": along,
            "electric_lag": self.lag,
        }

    def potential(self, grid: Grid) -> np.ndarray:
        """V at the cell centres, as it was solved last."""
        return self.field.potential

    def vectors(self, grid: Grid) -> np.ndarray:
        """E at the cell centres, as it was solved last."""
        return self.field.vectors

    def body_rows(self, count: int) -> list[dict[str, Any]]:
        """Loads and dipole moment of each body, for its row."""
        if self.loads is None:
            zero = np.zeros((count, 3))
            return [
                dict.fromkeys(("electric_force", "electric_torque", "dipole"), row) for row in zero
            ]
        return [
            {"electric_force": force, "electric_torque": torque, "dipole": dipole}
            for force, torque, dipole in zip(
                self.loads.force, self.loads.torque, self.loads.dipole, strict=True
            )
        ]


class NoField:
    """That of a case without a field."""

    def __call__(self, state: BodyState, time: float) -> np.ndarray:
        """Zeros (n,6)."""
        return np.zeros((state.count, 6))

    def saved(self) -> dict:
        """Nothing."""
        return {}

    def restore(self, saved: dict) -> None:
        """Nothing."""

    def history(self) -> dict[str, Any]:
        """Nothing."""
        return {}

    def potential(self, grid: Grid) -> np.ndarray:
        """Zero."""
        return np.zeros(grid.shape)

    def vectors(self, grid: Grid) -> np.ndarray:
        """Zero."""
        return np.zeros((3, *grid.shape))

    def body_rows(self, count: int) -> list[dict[str, Any]]:
        """Nothing of any body."""
        return [{} for _ in range(count)]
