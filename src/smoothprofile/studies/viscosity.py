"""The effective viscosity of dilute suspensions: spheres on a simple cubic lattice in a strain."""

import math

import numpy as np

from smoothprofile import calibration
from smoothprofile.studies.study import Row, Study
from smoothprofile.studies.viscosity_figures import pictures
from smoothprofile.suspension import EffectiveViscosity, effective_viscosity

THICKNESS, CELLS = 0.25, 64
"""ξ/a, and cells along each side of the box around one sphere."""
FRACTIONS = (0.01, 0.03, 0.05)
EXACT = {0.01: 1.024813, 0.03: 1.073594}
STRAINS = {"xy": "xy", "xx": np.diag([1.0, -1.0, 0.0])}
LAYERS, LAYER_CELLS, LAYER_FRACTION = (0.15, 0.2, 0.25, 0.3, 0.4), 48, 0.03
PAINTINGS = {"stresslet": True, "drag": "radial", "as given": False}
REACH = 0.01
"""Of μ_eff/μ − 1: what the layer, the grid and the end of the march may leave together."""
EINSTEIN = 0.05

INTRODUCTION = (
    "Free spheres on a simple cubic lattice in a mean strain E, Re → 0. The velocity is E·x + u', "
    "u' periodic, and in its frame each sphere moves as V + Ω×r − E·r with neither force nor "
    "torque. The impulse that keeps it rigid has the moment S = −(ργ/Δt)∫r⊗f dV, the stresslet, "
    "and μ_eff/μ = 1 + S:E/(2μE:E V). Backward Euler, tanh, to the steady state; shear along the "
    "axes of the lattice (E_xy) and stretch along them (E_xx = −E_yy). Exact: multipole series to "
    "six digits for c = 0.01 and 0.03 in shear; else 1 + 2.5c/(1 − αc + βc^{5/3}), which agrees "
    "with them (Zuzovsky, Adler and Brenner, Phys. Fluids 26, 1983)."
)


def run() -> Study:
    """Not in the thesis: 20 to 40 seconds on two cores."""
    found = {
        (name, c): effective_viscosity(lattice(c, THICKNESS, CELLS), strain)
        for name, strain in STRAINS.items()
        for c in FRACTIONS
    }
    curves = {
        "cubic_lattice": _lattice_curve(found),
        "cubic_series": _series_curve(),
        "layers": _layers(),
        "painted": _painted(),
    }
    return Study(
        title="Effective viscosity of a dilute suspension",
        source="Not in the thesis",
        introduction=INTRODUCTION,
        findings=_findings(found, curves),
        rows=[*_viscosities(found), *_einstein(found), *_lone()],
        curves=curves,
        pictures=pictures(curves),
    )


def lattice(
    fraction: float, thickness: float, cells: int, retract: bool | str = True
) -> dict[str, object]:
    """A case: one sphere of radius one in the periodic cube that it fills to that fraction."""
    side = (4.0 * math.pi / (3.0 * fraction)) ** (1.0 / 3.0)
    return {
        "domain": {"lengths": [side] * 3, "cells": [cells] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {"density": 1.0, "viscosity": 1.0},
        "profile": {"thickness": thickness, "retract": retract},
        "particles": [{"shape": "sphere", "radius": 1.0, "position": [0.5 * side] * 3}],
        "time": {"end": 1.0},
    }


def series(fraction: float, strain: str) -> float:
    """1 + 2.5c/(1 − (1 + 40b)c − 8a c^{5/3}) for "xy", 1 + 2.5c/(1 − (1 − 60b)c + 12a c^{5/3})
    for "xx", a = 0.2857 and b = −0.04655: a simple cubic lattice up to c of about 0.1.

    Source: Zuzovsky, Adler and Brenner, Phys. Fluids 26 (1983).
    """
    a, b, c = 0.2857, -0.04655, fraction
    two_thirds = a * c ** (5.0 / 3.0)
    rest = {
        "xy": -(1.0 + 40.0 * b) * c - 8.0 * two_thirds,
        "xx": -(1.0 - 60.0 * b) * c + 12.0 * two_thirds,
    }
    return 1.0 + 2.5 * c / (1.0 + rest[strain])


def _viscosities(found: dict[tuple, EffectiveViscosity]) -> list[Row]:
    rows = []
    for (name, c), one in found.items():
        known = EXACT.get(c) if name == "xy" else None
        exact = known or series(c, name)
        share = 100.0 * ((one.ratio - 1.0) / (exact - 1.0) - 1.0)
        source = "multipole series" if known else "series in c"
        remark = f"{source}; {share:+.2f} % of the increment, {one.steps} steps"
        tolerance = REACH * (exact - 1.0)
        rows.append(Row(f"μ_eff/μ, E_{name}, c = {c}", None, exact, one.ratio, tolerance, remark))
    return rows


def _einstein(found: dict[tuple, EffectiveViscosity]) -> list[Row]:
    """Shear against what spheres would do alone."""
    return [
        Row(
            f"(μ_eff/μ − 1)/c, E_xy, c = {c}",
            *(None, 2.5, (found["xy", c].ratio - 1.0) / c, EINSTEIN * 2.5),
            "Einstein's 2.5 is the limit c → 0",
        )
        for c in FRACTIONS
    ]


def _lone() -> list[Row]:
    """What painting a lone sphere for its drag costs its stresslet, by the radial problem."""
    rows = []
    for xi in (0.1, 0.2, 0.3):
        for kind in ("tanh", "quartic-centred"):
            ratio = _of_drag(xi, kind)
            remark = f"painted for its drag, the stresslet is {100 * (ratio - 1):+.2f} % off"
            name = f"S of a lone sphere painted for its drag, over the exact, {kind}, ξ = {xi}a"
            rows.append(Row(name, None, None, ratio, 0.0, remark))
    return rows


def _of_drag(xi: float, kind: str) -> float:
    length = calibration.best_ratio(kind) * xi
    painted = calibration.painted_radius(1.0, xi, length, kind)
    return calibration.resistance_ratio(1.0, painted, xi, length, kind, motion="straining")


def _lattice_curve(found: dict[tuple, EffectiveViscosity]) -> dict[str, np.ndarray]:
    columns = {"c": np.array(FRACTIONS)}
    for name in STRAINS:
        columns[name] = np.array([found[name, c].ratio for c in FRACTIONS])
    return columns


def _series_curve() -> dict[str, np.ndarray]:
    fractions = np.linspace(0.001, 0.06, 60)
    columns = {name: np.array([series(c, name) for c in fractions]) for name in STRAINS}
    return {"c": fractions} | columns


def _layers() -> dict[str, np.ndarray]:
    """Error of μ_eff/μ − 1 in shear against ξ, by what the sphere is painted for."""
    exact = EXACT[LAYER_FRACTION] - 1.0
    columns = {"thickness": np.array(LAYERS)}
    for name, retract in PAINTINGS.items():
        cases = [lattice(LAYER_FRACTION, xi, LAYER_CELLS, retract) for xi in LAYERS]
        ratios = np.array([effective_viscosity(case).ratio for case in cases])
        columns[name.replace(" ", "_")] = (ratios - 1.0) / exact - 1.0
    return columns


def _painted() -> dict[str, np.ndarray]:
    """Painted radii of a lone sphere at the best k, tanh."""
    thickness = np.linspace(0.02, 0.4, 20)
    lengths = calibration.best_ratio("tanh") * thickness
    return {"thickness": thickness} | {
        motion: np.array(
            [
                calibration.painted_radius(1.0, xi, length, motion=motion)
                for xi, length in zip(thickness, lengths, strict=True)
            ]
        )
        for motion in ("translation", "rotation", "straining")
    }


def _findings(found: dict[tuple, EffectiveViscosity], curves: dict) -> tuple[str, ...]:
    layers = curves["layers"]
    worst = {name: 100.0 * np.abs(layers[name]).max() for name in ("stresslet", "drag", "as_given")}
    tail = f"ξ = {LAYERS[0]} to {LAYERS[-1]}a and {LAYER_CELLS} cells to the box, c = 0.03"
    return (
        "Shear along the axes of the lattice meets less resistance than lone spheres would give, "
        "stretch along them more: at c = 0.05 "
        f"{(found['xy', 0.05].ratio - 1) / 0.05:.3f}c and "
        f"{(found['xx', 0.05].ratio - 1) / 0.05:.3f}c.",
        f"Painted for its stresslet, a sphere gives the increment within {worst['stresslet']:.1f} "
        f"% ({tail}); painted for its drag within {worst['drag']:.1f} %, painted where it is "
        f"within {worst['as_given']:.1f} %.",
        "A run in time paints free spheres for their drag. Up to ξ = 0.3a that costs their "
        "stresslet at most 2.3 %; beyond, it becomes too large.",
    )
