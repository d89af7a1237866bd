"""What the study of profiles measures: radial theory, and arrays of bodies on the grid."""

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache

import numpy as np
from scipy.optimize import brentq

from smoothprofile.calibration import dielectric_offset, dielectric_radius, effective_radius
from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import Forms, bodies_at
from smoothprofile.profiles import PROFILES, profile_named
from smoothprofile.shapes import Shape, cylinder, ellipsoid, sphere
from smoothprofile.theory.arrays import square_array
from smoothprofile.theory.dielectric import SMOOTHINGS
from smoothprofile.threads import set_thread_count, thread_count

UPRIGHT = (1.0, 0.0, 0.0, 0.0)
CELLS, RADIUS = 32, 0.25
"""Of the array of cylinders, a = 8Δx, and of the lattices of spheres."""
RATIOS = (0.01, 0.1, 2.0, 10.0, 100.0)
CENTRED = ("tanh", "sine", "quartic-centred")
CHOSEN = ("tanh", 0.75)
"""The recommended profile and its ξ/Δx."""
THEORY_WIDTH = 2.0 / 8.0
"""10–90 % width over the radius: two cells of a sphere of eight."""
DEGREES = {1: "dipole", 2: "quadrupole", 3: "octupole"}
TOLERANCE = 1e-5
"""Of the residual, which enters the energy squared; the least holding forces are 1e-5 of that."""
LONG, SHORT, ROOM = 10, 5, 48
"""Half axes of a spheroid and the side of its box, in cells."""


@cache
def layer_width(profile: str) -> float:
    """z(φ = 0.1) − z(φ = 0.9), the 10–90 % width in ξ: tanh 2.197, quartic .600, sine .590."""
    known = PROFILES[profile]
    low, high = max(known.core, -5.0), min(known.edge, 5.0)
    inner, outer = (
        brentq(lambda z, v=level: float(known.value(z)) - v, low, high) for level in (0.9, 0.1)
    )
    return outer - inner


CHOSEN_WIDTH = CHOSEN[1] * layer_width(CHOSEN[0])
WIDTHS = (0.8, 1.1, 1.4, CHOSEN_WIDTH, layer_width("tanh"), 2.6)
"""Cells across the layer, from 10 to 90 % of φ."""


def all_curves() -> dict[str, dict[str, np.ndarray]]:
    """Name of the CSV file -> its columns."""
    curves = {"dipole_as_painted": _as_painted(), "multipoles_retracted": _retracted()}
    with one_thread():
        for profile in CENTRED:
            curves[f"cylinders_{profile}"] = _cylinders(profile)
    return curves


def theory_error(degree: int, ratio: float, profile: str, smoothing: str, retracted: bool) -> float:
    """(a_eff − a)/a of one multipole, `THEORY_WIDTH` across the layer; nan if none can be painted.

    retracted: painted with the radius at which the dipole's a_eff is a.
    """
    thickness = THEORY_WIDTH / layer_width(profile)
    arguments = (thickness, ratio, profile, smoothing)
    try:
        painted = dielectric_radius(1.0, *arguments) if retracted else 1.0
        return effective_radius(painted, *arguments, degree) - 1.0
    except CaseError:
        return math.nan


def _as_painted() -> dict[str, np.ndarray]:
    ratio = np.geomspace(1e-3, 1e3, 31)
    columns = {"ratio": ratio}
    for smoothing in SMOOTHINGS:
        for profile in PROFILES:
            columns[f"{smoothing}_{profile}"] = np.array(
                [theory_error(1, float(r), profile, smoothing, False) for r in ratio]
            )
    return columns


def _retracted() -> dict[str, np.ndarray]:
    # The quartic as printed, retracted, is the centred one.
    ratio = np.geomspace(1e-3, 1e3, 13)
    columns = {"ratio": ratio}
    for degree in (2, 3):
        for smoothing in SMOOTHINGS:
            for profile in CENTRED:
                columns[f"{DEGREES[degree]}_{smoothing}_{profile}"] = np.array(
                    [theory_error(degree, float(r), profile, smoothing, True) for r in ratio]
                )
    return columns


def energies(
    shape: Shape,
    offset: tuple[float, float],
    cells: Sequence[int],
    medium: tuple[float, str, float, str],
    positions: np.ndarray,
    field: tuple[float, float, float] = (1.0, 0.0, 0.0),
) -> np.ndarray:
    """ε_eff along a unit `field` of one body in a periodic box of unit length along x, (n,).

    offset: by how much the painted surface is moved out, and that times its κ₁ + κ₂. cells: of
    cubic shape. medium: R, profile, ξ/Δx, smoothing. positions (n,3): from the middle of the
    box, in cells. ε_eff = 2W/V, so that the error of the iteration enters squared.
    """
    ratio, profile, thickness, smoothing = medium
    step = 1.0 / cells[0]
    grid = Grid(
        tuple(uniform_axis(n, 0.0, c * step, c, True) for n, c in zip("xyz", cells, strict=True))
    )
    permittivity = Permittivity(
        *(grid, Forms.of([shape], [np.array([offset])]), [ratio], 1.0),
        *(profile_named(profile), thickness * step, smoothing),
    )
    solver, found = PotentialSolver(grid), []
    for position in positions:
        middle = [(0.5 * c + x) * step for c, x in zip(cells, position, strict=True)]
        permittivity.paint(bodies_at([middle], [UPRIGHT]), solver.scratch)
        solver.solve(permittivity, field, TOLERANCE)
        found.append(2.0 * solver.energy(permittivity, field) / grid.volume)
    return np.array(found)


def cylinder_errors(
    ratio: float, profile: str, width: float, retracted: bool, radius: float = RADIUS
) -> tuple[float, float]:
    """Error of ε_eff of a square array of cylinders, and how hard the grid holds them; tensor.

    The error is that of the mean over positions on and between grid points. Between them the
    energy per length, W = ½ε_eff, differs by ΔW, as if by ½ΔW cos(2πx/Δx): the force is at most
    πΔW/Δx. It is given over the attraction of two cylinders a radius apart, their dipoles'
    4πβ²a⁴/r³ at r = 3a, β = (R−1)/(R+1), in the same field.
    """
    thickness = width / layer_width(profile)
    moved = 0.0
    if retracted:
        flat, bent = dielectric_offset(radius, thickness / CELLS, ratio, profile, "tensor")
        moved = flat + bent / radius
    found = energies(
        *(cylinder(radius), (moved, 0.0), (CELLS, CELLS, 1)),
        (ratio, profile, thickness, "tensor"),
        np.array([(x, y, 0.0) for x in (0.0, 0.5) for y in (0.0, 0.5)]),
    )
    beta = (ratio - 1.0) / (ratio + 1.0)
    holding = math.pi * 0.5 * np.ptp(found) * CELLS
    attraction = 4.0 * math.pi * beta**2 * radius / 27.0
    exact = square_array(ratio, math.pi * radius**2)
    return float(found.mean() / exact - 1.0), float(holding / attraction)


def _cylinders(profile: str) -> dict[str, np.ndarray]:
    columns = {
        "cells_across": np.array(WIDTHS),
        "thickness_over_step": np.array(WIDTHS) / layer_width(profile),
    }
    for kind, retracted in (("painted", False), ("retracted", True)):
        for ratio in RATIOS:
            found = [cylinder_errors(ratio, profile, width, retracted) for width in WIDTHS]
            errors, holds = np.array(found).T
            columns |= {f"{kind}_R{ratio:g}": errors, f"{kind}_hold_R{ratio:g}": holds}
        for name in ("", "hold_"):
            every = [np.abs(columns[f"{kind}_{name}R{ratio:g}"]) for ratio in RATIOS]
            columns[f"{kind}_{name}worst"] = np.max(every, axis=0)
    return columns


def lattice_permittivity(
    ratio: float, fraction: float, layer: tuple[str, float], smoothing: str, retracted: bool
) -> float:
    """ε_eff of a simple cubic lattice of spheres, `CELLS` to its spacing; layer: profile, ξ/Δx.

    A quarter of a cell from a grid point along each axis, where the first harmonic of what the
    grid does to the energy is zero.
    """
    profile, thickness = layer
    radius = (3.0 * fraction / (4.0 * math.pi)) ** (1.0 / 3.0)
    moved = 0.0
    if retracted:
        moved = dielectric_radius(radius, thickness / CELLS, ratio, profile, smoothing) - radius
    (found,) = energies(
        *(sphere(radius), (moved, 0.0), (CELLS,) * 3),
        (ratio, profile, thickness, smoothing),
        np.full((1, 3), 0.25),
    )
    return float(found)


def spheroid_errors(ratio: float, smoothing: str) -> tuple[float, float]:
    """Errors of the moments of a retracted 2:1 prolate spheroid along its axis and across it.

        ε_eff = 1 + cα/(1 − cα/3),    α = (R−1)/(1 + n(R−1))

    for a cubic lattice whose spheroids are small: what other multipoles add is (a/L)⁵ of it,
    2e-3 here. The chosen layer; c is the fraction and n the depolarisation factor.
    """
    profile, thickness = CHOSEN
    axes = np.array([LONG, SHORT, SHORT]) / ROOM
    mean = float(np.prod(axes) ** (1.0 / 3.0))
    offset = dielectric_offset(mean, thickness / ROOM, ratio, profile, smoothing)
    fraction = 4.0 * math.pi / 3.0 * mean**3
    errors = []
    for factor, field in zip(depolarisation(LONG / SHORT), np.eye(3)[:2], strict=True):
        (found,) = energies(
            *(ellipsoid(axes), offset, (ROOM,) * 3),
            (ratio, profile, thickness, smoothing),
            *(np.full((1, 3), 0.25), tuple(field)),
        )
        polarised = fraction * (ratio - 1.0) / (1.0 + factor * (ratio - 1.0))
        # (ε_eff − 1)/(ε_eff + 2) = cα/3, the moment of one spheroid.
        errors.append(3.0 * (found - 1.0) / (found + 2.0) / polarised - 1.0)
    return errors[0], errors[1]


def depolarisation(aspect: float) -> tuple[float, float]:
    """n along the axis of a prolate spheroid and across it, e² = 1 − 1/aspect².

    n = (1−e²)(artanh e − e)/e³,  (1−n)/2.
    """
    e = math.sqrt(1.0 - aspect**-2)
    along = (1.0 - e * e) * (math.atanh(e) - e) / e**3
    return along, 0.5 * (1.0 - along)


@contextmanager
def one_thread() -> Iterator[None]:
    """On a sheet of 32×32 cells, waking threads costs more than they work off."""
    before = thread_count()
    set_thread_count(1)
    try:
        yield
    finally:
        set_thread_count(before)
