"""What the study of refinement runs: the duct on meshes of equal and of unequal cells."""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from smoothprofile import calibration
from smoothprofile.assembly import build_grid
from smoothprofile.config import load_case
from smoothprofile.simulation import Simulation
from smoothprofile.studies.dns import DUCT

FORCE = DUCT["force"]
"""On the sphere at Re = 10, by body-fitted finite elements."""
RATIOS = (24.0, 1.6, 1.6)
"""Widest over narrowest cell along and across the duct."""
CORE = 1.3
"""Half width of the equal cells around the sphere, in radii, where there are any."""
LONG_STEP = 0.09
SECONDS = 5
"""Steps of each mesh that are timed, in turn."""


@dataclass(frozen=True)
class Mesh:
    """Cells along x, y and z, the ratios of their widths, 1 is uniform, and equal ones' extent."""

    cells: tuple[int, int, int]
    ratios: tuple[float, float, float] = (1.0, 1.0, 1.0)
    core: float = 0.0

    @property
    def count(self) -> int:
        return int(np.prod(self.cells))

    @property
    def name(self) -> str:
        return "×".join(str(n) for n in self.cells)

    def changes(self) -> dict[str, object]:
        """What makes this the mesh of the case duct."""
        laws = [
            {"focus": 0.0, "ratio": ratio, "core": self.core} if ratio > 1.0 else "uniform"
            for ratio in self.ratios
        ]
        return {"domain.cells": list(self.cells), "domain.stretching": laws, "start": []}


def uniform(along: int, across: int) -> Mesh:
    """Equal cells."""
    return Mesh((along, across, across))


def refined(along: int, across: int) -> Mesh:
    """Cells that widen from the sphere's centre on."""
    return Mesh((along, across, across), RATIOS)


def cored(along: int, across: int) -> Mesh:
    """Equal cells as far as the sphere and its layer reach, that widen beyond."""
    return Mesh((along, across, across), RATIOS, CORE)


@dataclass(frozen=True, eq=False)
class Found:
    """The force of a mesh with a layer and a step; width: of the narrowest cells along x."""

    mesh: Mesh
    thickness: float
    step: float
    force: float
    width: float
    seconds: float
    simulation: Simulation

    @property
    def error(self) -> float:
        """Of the force, in %."""
        return 100.0 * (self.force / FORCE - 1.0)


def steady(
    mesh: Mesh,
    thickness: float,
    step: float,
    end: float,
    before: Simulation | None = None,
    retract: bool | str = True,
    tolerance: float = 1e-5,
) -> Found:
    """The duct at Re = 10 up to time `end` or rest, from the flow of a run before if there is one.

    seconds: of the whole run, without those before it.
    """
    numbers = {"profile.thickness": thickness, "profile.retract": retract}
    times = {"time.step": step, "time.end": end, "time.steady_tolerance": tolerance}
    run = Simulation.from_file("duct", mesh.changes() | numbers | times)
    if before is not None:
        run.continue_from(before)
    run.run()
    force = float(run.particles[0]["force"][0])
    width = float(run.grid.axes[0].widths.min())
    return Found(mesh, thickness, run.time_step, force, width, run.wall_seconds, run)


def from_rest(mesh: Mesh) -> Simulation:
    """A coarse flow near its steady state, of long steps."""
    return steady(mesh, 0.4, LONG_STEP, 15.0, tolerance=1e-3).simulation


def ladder(
    meshes: Sequence[Mesh], thickness: float, step: float, end: float, before: Simulation
) -> list[Found]:
    """One layer on one mesh after the other, each from the flow of the one before."""
    rows: list[Found] = []
    for mesh in meshes:
        rows.append(steady(mesh, thickness, step, end, before))
        before = rows[-1].simulation
    return rows


def paired(
    meshes: Sequence[Mesh], cells: float, end: float, before: Simulation, retract: bool | str
) -> list[Found]:
    """ξ of so many of the narrowest cells, √(νΔt) = kξ with the best k, mesh after mesh."""
    rows: list[Found] = []
    for mesh in meshes:
        thickness = cells * width_along(mesh)
        step = calibration.best_time_step(thickness, 1.0)
        rows.append(steady(mesh, thickness, step, end, before, retract))
        before = rows[-1].simulation
    return rows


def width_along(mesh: Mesh) -> float:
    """The narrowest cell along the duct."""
    domain = load_case("duct", mesh.changes()).domain
    return float(build_grid(domain).axes[0].widths.min())


def seconds_per_step(runs: Sequence[Simulation]) -> list[float]:
    """The least of a few steps of each, one after the other in turn."""
    seconds = np.empty((SECONDS, len(runs)))
    for row in seconds:
        for number, run in enumerate(runs):
            begin = time.perf_counter()
            run.step_once()
            row[number] = time.perf_counter() - begin
    return seconds.min(axis=0).tolist()


def order(widths: Sequence[float], values: Sequence[float]) -> tuple[float, float]:
    """p and v∞ of v = v∞ + C hᵖ through the last three values."""
    (h1, h2, h3), (v1, v2, v3) = widths[-3:], values[-3:]

    def mismatch(p: float) -> float:
        return (v1 - v2) * (h2**p - h3**p) - (v2 - v3) * (h1**p - h2**p)

    p = brentq(mismatch, 0.2, 6.0)
    return float(p), float(v3 - (v2 - v3) * h3**p / (h2**p - h3**p))
