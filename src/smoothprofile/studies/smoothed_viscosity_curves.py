"""What the study of smoothed viscosity measures: lattices on the grid, and radial theory."""

import math
import time
from dataclasses import dataclass

import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import BodyState, bodies_at
from smoothprofile.shapes import sphere
from smoothprofile.viscous.around import stokes_around
from smoothprofile.viscous.smoothed_viscosity import SmoothedStokes, effective_viscosity
from smoothprofile.viscous.smoothed_viscosity_bodies import mobility
from smoothprofile.viscous.smoothed_viscosity_medium import viscous_medium
from smoothprofile.viscous.smoothed_viscosity_radius import (
    MOTIONS,
    error_of,
    painted_radius,
)
from smoothprofile.viscous.tensor_viscosity import SMOOTHINGS

FRACTION, EXACT = 0.064, 2.81020
"""A simple cubic lattice of rigid spheres, F/(6πμaU): Zick and Homsy, J. Fluid Mech. 115 (1982)."""
STIFF = 1000.0
LAYERS = {0.2: 24, 0.14: 36, 0.1: 48}
"""ξ/a, and cells along the box: Δx = .84ξ."""
RATIOS = (10.0, 100.0, 1000.0, 10000.0)
DILUTE, DILUTE_LAYER, DILUTE_CELLS = 0.01, 0.2, 40
TOLERANCE = 1e-3
"""Of the residual: drag and viscosity err by less than a tenth of it."""
LONE = (0.025, 0.05, 0.1, 0.2, 0.3)
LONE_RATIOS = (10.0, 1000.0)
KINDS = {"painted": False, "retracted": "drag"}


@dataclass(frozen=True)
class Solved:
    """A number with what it took: iterations, and seconds of a solve that was compiled before."""

    value: float
    iterations: int
    seconds: float


def cell(fraction: float, cells: int) -> tuple[Grid, BodyState]:
    """The cube that a sphere of radius one fills to that fraction, near its middle."""
    side = (4.0 * math.pi / (3.0 * fraction)) ** (1.0 / 3.0)
    grid = Grid(tuple(uniform_axis(name, 0.0, side, cells, True) for name in "xyz"))
    return grid, bodies_at([[0.5 * side + 0.25 * side / cells] * 3], [(1.0, 0.0, 0.0, 0.0)])


def lattice_drag(
    ratio: float, thickness: float, cells: int, smoothing: str, retract: str | bool
) -> Solved:
    """F/(6πμaU) of the lattice of c = 0.064."""
    grid, state = cell(FRACTION, cells)
    medium = viscous_medium(
        grid, [sphere(1.0)], [ratio], thickness=thickness, smoothing=smoothing, retract=retract
    )
    solver = SmoothedStokes(grid)
    begin = time.perf_counter()
    medium.paint(state)
    moved = mobility(solver, medium, state, np.array([[1.0, 0.0, 0.0]]), None, TOLERANCE)
    seconds = time.perf_counter() - begin
    drag = 1.0 / (6.0 * math.pi * float(moved.velocity[0, 0]))
    return Solved(drag, moved.report.iterations, seconds)


def constrained_drag(cells: int) -> Solved:
    """The same of a rigid sphere by a force that holds it to a rigid motion, its own layer."""
    grid, state = cell(FRACTION, cells)
    solver = stokes_around(grid, [sphere(1.0)], 1.0)
    begin = time.perf_counter()
    moved = solver.mobility(state, [[1.0, 0.0, 0.0]], 0.0, tolerance=TOLERANCE)
    seconds = time.perf_counter() - begin
    drag = 1.0 / (6.0 * math.pi * float(moved.velocity[0, 0]))
    return Solved(drag, moved.report.iterations, seconds)


def dilute_exact(ratio: float) -> float:
    """1 + sc/(1 + 0.862 sc/2.5 − 2.29 (s/2.5) c^{5/3}), s = 5(R−1)/(2R+3): drops on a simple cubic
    lattice in shear along its axes.

    For s = 2.5 the series of Zuzovsky, Adler and Brenner, Phys. Fluids 26 (1983), for rigid
    spheres; what it says of the lattice multiplies the stresslet of one drop.
    """
    share = 5.0 * (ratio - 1.0) / (2.0 * ratio + 3.0)
    rigid = share / 2.5
    lattice = 0.862 * rigid * DILUTE - 8.0 * 0.2857 * rigid * DILUTE ** (5.0 / 3.0)
    return 1.0 + share * DILUTE / (1.0 + lattice)


def dilute_viscosity(ratio: float, smoothing: str, retract: str | bool) -> Solved:
    """μ_eff/μ of drops on a simple cubic lattice, c = 0.01, in shear along its axes."""
    grid, state = cell(DILUTE, DILUTE_CELLS)
    medium = viscous_medium(
        grid, [sphere(1.0)], [ratio], thickness=DILUTE_LAYER, smoothing=smoothing, retract=retract
    )
    medium.paint(state)
    strain = np.zeros((3, 3))
    strain[0, 1] = strain[1, 0] = 0.5
    begin = time.perf_counter()
    found, report = effective_viscosity(SmoothedStokes(grid), medium, strain, TOLERANCE)
    return Solved(found, report.iterations, time.perf_counter() - begin)


def all_curves() -> tuple[dict[str, dict[str, np.ndarray]], dict[tuple, Solved]]:
    """Name of the CSV file -> its columns, and the solves that the table tells of."""
    smallest = min(LAYERS.values())
    for smoothing in SMOOTHINGS:
        # Compiles, if nobody has before, so that the seconds are those of a solve.
        lattice_drag(10.0, 0.25, 12, smoothing, False)
    constrained_drag(smallest)
    solved: dict[tuple, Solved] = {}
    curves = {
        "lattice": _lattice(solved),
        "contrast": _contrast(),
        "dilute": _dilute(solved),
    }
    for ratio in LONE_RATIOS:
        curves[f"lone_sphere_R{ratio:g}"] = _lone(ratio)
    return curves, solved


def _lattice(solved: dict[tuple, Solved]) -> dict[str, np.ndarray]:
    """F/(6πμaU) over the exact, less 1, at R = 1000 against ξ."""
    columns = {"thickness": np.array(list(LAYERS)), "cells": np.array(list(LAYERS.values()))}
    for smoothing in SMOOTHINGS:
        for kind, retract in KINDS.items():
            for xi, cells in LAYERS.items():
                found = lattice_drag(STIFF, xi, cells, smoothing, retract)
                solved[smoothing, kind, xi] = found
            values = [solved[smoothing, kind, xi].value for xi in LAYERS]
            columns[f"{smoothing}_{kind}"] = np.array(values) / EXACT - 1.0
    for xi, cells in LAYERS.items():
        solved["constrained", xi] = constrained_drag(cells)
    values = [solved["constrained", xi].value for xi in LAYERS]
    return columns | {"constrained": np.array(values) / EXACT - 1.0}


def _contrast() -> dict[str, np.ndarray]:
    """Iterations of the lattice's drag against R, ξ = .14a, and the drag itself."""
    columns: dict[str, np.ndarray] = {"ratio": np.array(RATIOS)}
    for smoothing in SMOOTHINGS:
        found = [lattice_drag(ratio, 0.14, LAYERS[0.14], smoothing, "drag") for ratio in RATIOS]
        columns[f"{smoothing}_drag"] = np.array([one.value for one in found])
        columns[f"{smoothing}_iterations"] = np.array([one.iterations for one in found])
    return columns


def _dilute(solved: dict[tuple, Solved]) -> dict[str, np.ndarray]:
    """Error of μ_eff/μ − 1 against R, painted for the drag and for the stresslet."""
    columns: dict[str, np.ndarray] = {"ratio": np.array(RATIOS)}
    for smoothing in SMOOTHINGS:
        for motion in ("drag", "stresslet"):
            errors = []
            for ratio in RATIOS:
                try:
                    found = dilute_viscosity(ratio, smoothing, motion)
                except CaseError:
                    errors.append(math.nan)
                    continue
                solved["dilute", smoothing, motion, ratio] = found
                errors.append((found.value - 1.0) / (dilute_exact(ratio) - 1.0) - 1.0)
            columns[f"{smoothing}_{motion}"] = np.array(errors)
    return columns


def _lone(ratio: float) -> dict[str, np.ndarray]:
    """Errors of a lone sphere against ξ, by the radial problem: as painted, and when painted for
    its drag."""
    columns = {"thickness": np.array(LONE)}
    for smoothing in SMOOTHINGS:
        for motion in MOTIONS:
            columns[f"{smoothing}_{motion}"] = np.array(
                [error_of(motion, 1.0, xi, ratio, "tanh", smoothing) for xi in LONE]
            )
            if motion != "drag":
                columns[f"{smoothing}_{motion}_retracted"] = np.array(
                    [_left_over(motion, xi, ratio, smoothing) for xi in LONE]
                )
    return columns


def _left_over(motion: str, thickness: float, ratio: float, smoothing: str) -> float:
    try:
        painted = painted_radius(1.0, thickness, ratio, "tanh", smoothing)
    except CaseError:
        return math.nan
    return error_of(motion, painted, thickness, ratio, "tanh", smoothing)
