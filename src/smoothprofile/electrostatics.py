"""The field of a case that has [electric] alone: what a run of it looks like from Python.

import smoothprofile as sp
run = sp.Electrostatics.from_file("dielectric-pair")
run.run()
run.particles[0]["force"], run.effective_permittivity
"""

import time as clock
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from smoothprofile import cuts
from smoothprofile.assembly import build_field, build_grid, starting_state
from smoothprofile.config import AXES, Case, build_shape, load_case
from smoothprofile.electric.enclosing import enclosing_loads
from smoothprofile.electric.field import ResolvedField, at_points
from smoothprofile.errors import BlowUpError, CaseError
from smoothprofile.field_checks import check_field_memory, field_checks
from smoothprofile.numbers import numbers_of
from smoothprofile.preflight import Check, refuse
from smoothprofile.solvers.krylov import SolveReport
from smoothprofile.tables import field_table
from smoothprofile.threads import thread_count

LAYERS_CLEAR = 4.0
"""ξ between a body and the surface that its Maxwell stress is taken on."""


class Electrostatics:
    """The field around the bodies of one case. Bad cases raise CaseError here."""

    time, time_step, steps, bodies_move = 0.0, 0.0, 0, False

    def __init__(self, case: Case):
        if case.electric is None or case.fluid is not None:
            raise CaseError("this case has a [fluid], and Simulation runs it.")
        check_field_memory(case)
        self.case, self.grid = case, build_grid(case.domain)
        self._checks = field_checks(case, self.grid)
        refuse(self._checks)
        self.bodies = starting_state(case)
        self.field = build_field(case, self.grid)
        self.status, self.wall_seconds = "running", 0.0
        self.report: SolveReport | None = None
        self.effective_permittivity: np.ndarray | None = None
        self.effective_reports: list[SolveReport] = []
        self.history: dict[str, list] = {}

    @classmethod
    def from_file(
        cls, case: str | Path | dict, overrides: Mapping | list | None = None
    ) -> "Electrostatics":
        """From a TOML file, a built-in case's name or a dict; {"electric.tolerance": 1e-8}."""
        return cls(load_case(case, overrides or {}))

    def run(self, observer: Callable[["Electrostatics"], None] | None = None) -> dict[str, Any]:
        """Solve; returns the summary. BlowUpError for a solver that does not converge."""
        began = clock.perf_counter()
        self.report = self.field.solve(self.bodies)
        self._check(self.report)
        if self.case.electric.effective and all(self.grid.periodic):
            tensor, self.effective_reports = self.field.effective()
            for report in self.effective_reports:
                self._check(report)
            self.effective_permittivity = tensor
        self._take_loads()
        self.history = {
            "step": [0],
            "time": [0.0],
            "iterations": [self.report.iterations],
            "residual": [self.report.residual],
            "energy": [self.energy],
        }
        self.status, self.wall_seconds = "finished", clock.perf_counter() - began
        if observer:
            observer(self)
        return self.summary()

    def _check(self, report: SolveReport) -> None:
        if report.converged:
            return
        electric = self.case.electric
        raise BlowUpError(
            f"the potential did not converge: {electric.method} ended by {report.status} after "
            f"{report.iterations} iterations, at a residual of {report.residual:.3g} against "
            f"electric.tolerance = {electric.tolerance:g}."
        )

    def _take_loads(self) -> None:
        self._centre = at_points(self.grid, self.electric_field, self.bodies.position)
        self._loads = self._maxwell = None
        if not isinstance(self.field, ResolvedField):
            return
        self._loads = self.field.loads(self.bodies)
        shapes = [build_shape(particle) for particle in self.case.particles]
        self._maxwell = enclosing_loads(
            self.grid,
            self.field.faces,
            self.case.electric.permittivity,
            shapes,
            self.bodies,
            LAYERS_CLEAR * self.field.medium.thickness,
        )

    @property
    def energy(self) -> float:
        """½∫E·εE dV."""
        return self.field.energy()

    @property
    def potential(self) -> np.ndarray:
        """V at the cell centres, (nx,ny,nz)."""
        return self.field.potential

    @property
    def electric_field(self) -> np.ndarray:
        """E at the cell centres, (3,nx,ny,nz)."""
        return self.field.vectors

    @property
    def indicator(self) -> np.ndarray:
        """(nx,ny,nz): φ of all bodies at the cell centres, as painted."""
        return self.field.indicator

    @property
    def particles(self) -> list[dict[str, Any]]:
        """One dict a body: place, permittivity, E at its centre, loads and dipole moment."""
        bodies, found = self.bodies, []
        for b, particle in enumerate(self.case.particles):
            row = {
                "name": particle.name,
                "shape": particle.shape,
                "position": bodies.position[b].copy(),
                "orientation": bodies.quaternion[b].copy(),
                "permittivity": particle.permittivity,
                "centre_field": self._centre[b],
            }
            if self._loads is not None:
                row |= {
                    "dipole": self._loads.dipole[b],
                    "force": self._loads.force[b],
                    "torque": self._loads.torque[b],
                    "maxwell_force": self._maxwell[0][b],
                    "maxwell_torque": self._maxwell[1][b],
                }
            found.append(row)
        return found

    def sample_plane(self, axis: str, at: float) -> dict[str, Any]:
        """|E|, in-plane E, V and φ on the cell centres of a plane, and the forces on its bodies."""
        reach = np.array([build_shape(particle).reach for particle in self.case.particles])
        forces = {}
        if self._loads is not None and self.case.particles:
            state, force = self.bodies, self._loads.force
            forces = cuts.forces_in_cut(self.grid, state, reach, force, axis, at)
            forces["permittivity"] = self.case.electric.permittivity
        return {
            **cuts.frame(self.grid, axis, at, self.indicator),
            **cuts.field_cut(self.grid, self.electric_field, self.potential, axis, at),
            **forces,
        }

    def preflight(self) -> list[Check]:
        """The checks made before the run; see `field_checks.py`."""
        return list(self._checks)

    def summary(self) -> dict[str, Any]:
        """The result in one dict."""
        return {
            "status": self.status,
            "wall_seconds": self.wall_seconds,
            "cells": self.grid.cell_count,
            "threads": thread_count(),
            "iterations": self.report.iterations,
            "residual": self.report.residual,
            "effective_iterations": [report.iterations for report in self.effective_reports],
            "effective_permittivity": self.effective_permittivity,
            "permittivity_along": self.permittivity_along,
            "mean_displacement": self.field.mean_displacement(),
            "mean_field": self.case_field,
            "energy": self.energy,
            "bodies": self.particles,
            "numbers": numbers_of(self.case),
            "resolution": {check["name"]: check["value"] for check in self._checks},
        }

    @property
    def case_field(self) -> np.ndarray:
        """E₀: the mean field, that of the electrodes included."""
        return np.array(self.field.drive.field)

    @property
    def permittivity_along(self) -> float | None:
        """⟨D⟩/E₀ across electrodes, their charge over that without bodies at ε = 1; else None."""
        electrodes = self.case.electric.electrodes
        if electrodes is None or electrodes.low == electrodes.high:
            return None
        axis = AXES.index(electrodes.axis)
        return float(self.field.mean_displacement()[axis] / self.case_field[axis])

    def table(self) -> list[tuple[str, str, str]]:
        """The result as rows quantity, value, note, for people."""
        return field_table(self)
