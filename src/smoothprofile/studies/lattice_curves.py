"""The solves and curves of the lattice study: by Fourier series, by multipoles, on the staggered
grid."""

import math
from dataclasses import dataclass
from functools import cache

import numpy as np

from smoothprofile.electric.fourier import FourierReport, FourierSolver, indicator_at_centres
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import Forms, bodies_at
from smoothprofile.profiles import PROFILES
from smoothprofile.shapes import sphere
from smoothprofile.theory import dielectric
from smoothprofile.theory.cubic import cubic_lattice, face_points

FIELD = (1.0, 0.0, 0.0)
RADIUS, RATIO = 1.0, 2.0
STEPS = 5
MULTIPOLES = 8
SHOWN_POINTS = 128
TOLERANCE = 1e-9
"""Of conjugate gradients; ε_eff is off by its square, the field in the box by about it."""
SCAN = {"cells": 32, "length": 4.0, "thickness": 0.1}
SCANNED = (0.001, 0.01, 0.02, 0.03, 0.1, 0.5, 2.0, 5.0, 10.0, 20.0, 30.0, 50.0, 60.0, 100.0, 1000.0)
HISTORIES = (2.0, 10.0, 30.0, 60.0, 100.0, 0.01)
LONGEST = 400


def lattice_grid(cells: int, length: float) -> Grid:
    """A cubic cell with one of its points, the cells' centres, at the origin, as in the thesis."""
    low = -0.5 * length - 0.5 * length / cells
    return Grid(tuple(uniform_axis(name, low, length, cells, True) for name in "xyz"))


def fourier_solver(cells: int, length: float, thickness: float, ratio: float) -> FourierSolver:
    """One sphere, a = 1, at the origin; tanh, arithmetic."""
    grid = lattice_grid(cells, length)
    phi = indicator_at_centres(grid, _distance, PROFILES["tanh"], thickness)
    phi *= ratio - 1.0
    phi += 1.0
    return FourierSolver(grid, phi)


def _distance(x, y, z):
    return np.sqrt(x * x + y * y + z * z) - RADIUS


@dataclass(frozen=True, eq=False)
class Lattice:
    """One cell, solved: five iterations as in the thesis, then to the end.

    errors         of the iterations
    first, last    mean of (−∇ψ)₁ over the points in the box, after iteration 5 and converged
    integral       the same over the box itself, converged
    permittivity   ε_eff, converged
    plane, line    columns after iteration 5 at x₃ = 0 and at x₂ = x₃ = 0
    """

    errors: tuple[float, ...]
    first: float
    last: float
    integral: float
    permittivity: float
    plane: dict[str, np.ndarray]
    line: dict[str, np.ndarray]


def solved_lattice(cells: int, length: float, thickness: float) -> Lattice:
    """The thesis' problem at R = 2."""
    solver = fourier_solver(cells, length, thickness, RATIO)
    errors = solver.solve(FIELD, "fixed-point", limit=STEPS).errors
    x = length * (np.arange(cells) / cells - 0.5)
    plane, line, first = _fields(solver, x)
    report = solver.solve(FIELD, "conjugate-gradients", tolerance=TOLERANCE)
    if not report.converged:
        raise ArithmeticError(f"conjugate gradients: {report.status} at {report.errors[-1]:.1e}")
    return Lattice(
        *(errors, first, _points_mean(solver.disturbance(0), x), box_integral(solver, length)),
        *(float(solver.mean_displacement(FIELD)[0]), plane, line),
    )


def _fields(solver: FourierSolver, x: np.ndarray) -> tuple[dict, dict, float]:
    """Columns of ψ and ∇ψ in the plane and on the line, and the mean over the box."""
    middle, every = x.size // 2, max(1, x.size // SHOWN_POINTS)
    some = x[::every]
    grid = np.meshgrid(some, some, indexing="ij")
    plane = {"x1": grid[0].ravel(), "x2": grid[1].ravel()}
    values = solver.potential()
    line = {"x1": x, "potential": values[:, middle, middle].copy()}
    plane["potential"] = values[::every, ::every, middle].ravel()
    mean = 0.0
    for d in (0, 1):
        values = solver.disturbance(d, values)
        plane[f"slope{d + 1}"] = -values[::every, ::every, middle].ravel()
        if d == 0:
            mean = _points_mean(values, x)
    return plane, line, mean


def _points_mean(values: np.ndarray, x: np.ndarray) -> float:
    """The mean over the points with |x_i| ≤ a/2."""
    within = np.abs(x) <= 0.5 * RADIUS * (1.0 + 1e-12)
    return float(values[np.ix_(within, within, within)].mean())


def box_integral(solver: FourierSolver, length: float, side: float = RADIUS) -> float:
    """Mean of (−∇ψ)₁ over the box |x_i| ≤ side/2: −Σ ik₁ψ̂ Π e^{ik·L/2} sin(k·side/2)/(k·side/2).

    The Fourier series itself, integrated; no rule of quadrature enters.
    """
    box = solver.box
    x, y, z = (
        np.exp(0.5j * k * length) * np.sinc(0.5 * k * side / math.pi) for k in box.wave_numbers
    )
    across = (solver.modes @ (z * box.weights)) @ y
    return -float((1j * box.wave_numbers[0] * x * across).sum().real) / box.count


@cache
def series(length: float, thickness: float | None, smoothing: str = "") -> tuple[float, float]:
    """ε_eff and the box's mean of (−∇ψ)₁ by multipoles; of sharp spheres if thickness is None.

    Two smoothed spheres do not touch but for e^{−2(L−2a)/ξ}, so that one multipole of one of them
    is the radial problem.
    """
    degrees = range(1, 2 * MULTIPOLES, 2)
    a = RADIUS / length
    if thickness is None:
        factors = {l: dielectric.sharp_factor(l, RATIO) for l in degrees}
        found = cubic_lattice([factors[l] * a ** (2 * l + 1) for l in degrees])
        mean = found.box_mean(a, lambda l, r: (1.0 - factors[l]) * r**l)
        return found.effective_permittivity, mean - 1.0
    tanh, width = PROFILES["tanh"], thickness / length
    edges = dielectric.interface_edges(a, width, tanh.core, tanh.edge, RATIO)
    edges = np.union1d(edges, face_points(a))
    fields = {
        l: dielectric.solve_multipole(
            l, RATIO, lambda r: tanh.value((r - a) / width), smoothing, edges
        )
        for l in degrees
    }
    found = cubic_lattice([fields[l].induced / fields[l].external for l in degrees])

    def radial(l: int, r: np.ndarray) -> np.ndarray:
        return np.interp(r, fields[l].radius, fields[l].potential)

    return found.effective_permittivity, found.box_mean(a, radial) - 1.0


@cache
def staggered(cells: int, length: float, thickness: float) -> tuple[float, float]:
    """The same by the solver of the staggered grid, with its tensor."""
    grid = Grid(tuple(uniform_axis(name, -0.5 * length, length, cells, True) for name in "xyz"))
    forms = Forms.of([sphere(RADIUS)], [np.zeros((1, 2))])
    medium = Permittivity(grid, forms, [RATIO], 1.0, PROFILES["tanh"], thickness)
    solver = PotentialSolver(grid)
    medium.paint(bodies_at([[0.0, 0.0, 0.0]], [[1.0, 0.0, 0.0, 0.0]]), solver.scratch)
    report = solver.solve(medium, FIELD, tolerance=1e-8)
    if not report.converged:
        raise ArithmeticError(f"staggered grid: {report.status} at {report.residual:.1e}")
    # Faces x = −a/2 … a/2, where the rule of trapezoids is exact to second order.
    half, middle = round(0.5 * RADIUS * cells / length), 1 + cells // 2
    inside = slice(middle - half, middle + half)
    part = solver.field(FIELD)[0][middle - half : middle + half + 1, inside, inside]
    means = part.mean(axis=(1, 2)) - FIELD[0]
    mean = (means.sum() - 0.5 * (means[0] + means[-1])) / (2 * half)
    return float(solver.mean_displacement(medium, FIELD)[0]), float(mean)


@cache
def iterated(
    ratio: float, cells: int, length: float, thickness: float, tolerance: float
) -> FourierReport:
    """How the fixed-point iteration ends; the tolerance is of the error over the first one."""
    solver = fourier_solver(cells, length, thickness, ratio)
    first = solver.solve(FIELD, "fixed-point", limit=1).errors[0]
    return solver.solve(FIELD, "fixed-point", tolerance * first, LONGEST)


@cache
def gradient_steps(
    ratio: float, cells: int, length: float, thickness: float, tolerance: float
) -> int:
    """Iterations of conjugate gradients from ψ = 0."""
    solver = fourier_solver(cells, length, thickness, ratio)
    return solver.solve(FIELD, "conjugate-gradients", tolerance, 1000).iterations


def convergence_curves() -> dict[str, dict[str, np.ndarray]]:
    """Iterations of both methods over R, and errors of the fixed-point iteration."""
    reports = [iterated(ratio, **SCAN, tolerance=1e-8) for ratio in SCANNED]
    status = ("converged", "diverged", "iteration limit", "stagnated")
    steps = [gradient_steps(ratio, **SCAN, tolerance=1e-8) for ratio in SCANNED]
    scan = {
        "ratio": np.array(SCANNED),
        "fixed_point": np.array([report.iterations for report in reports]),
        "status": np.array([status.index(report.status) for report in reports]),
        "gradients": np.array(steps),
    }
    histories = {"iteration": np.arange(1, LONGEST + 1)}
    for ratio in HISTORIES:
        errors = np.array(iterated(ratio, **SCAN, tolerance=1e-8).errors)
        column = np.full(LONGEST, math.nan)
        column[: errors.size] = errors / errors[0]
        histories[f"R{ratio:g}"] = column
    return {"iterations_against_ratio": scan, "errors_of_iterations": histories}


def smoothing_curves(length: float) -> dict[str, np.ndarray]:
    """ε_eff and mean over the box against ξ, by multipoles."""
    thickness = np.linspace(0.02, 0.14, 7)
    columns = {"thickness": thickness}
    for smoothing in ("arithmetic", "tensor"):
        found = np.array([series(length, float(x), smoothing) for x in thickness])
        columns[f"permittivity_{smoothing}"] = found[:, 0]
        columns[f"mean_{smoothing}"] = found[:, 1]
    return columns
