"""Cells that cluster around a sphere in a duct, beside equal ones: force, error, cells, seconds."""

from collections.abc import Mapping, Sequence

import numpy as np

from smoothprofile.simulation import Simulation
from smoothprofile.studies.refinement_figures import FAMILIES, pictures
from smoothprofile.studies.refinement_runs import (
    CORE,
    FORCE,
    RATIOS,
    Found,
    cored,
    from_rest,
    ladder,
    order,
    paired,
    refined,
    seconds_per_step,
    steady,
    uniform,
)
from smoothprofile.studies.study import Row, Study

THICKNESS, STEP = 0.15, 0.05
THIN, THIN_STEP = 0.1, 0.02
UNIFORM = ((128, 46), (192, 68), (256, 90))
REFINED = ((32, 34), (48, 50), (64, 66), (80, 82))
SAME_AS_FINEST = 1
THIN_REFINED = (60, 62)
PAIRED = ((24, 26), (32, 34), (48, 50), (64, 66))
LAYER_CELLS = 1.6
REACH = 0.01
"""Of the force: what a layer of 0.15 radii and a step of 0.05 leave."""
ORDER_REACH = 0.5
"""Meshes of 0.5 to 1 cells to ξ are not yet in the range where the order is a whole number."""
SAME = 0.1
"""Of the fine mesh's own error: how far two errors may differ and be called the same."""
LIMITS = 5e-4
"""Of the force: what the fits of an order to three meshes leave of their limits."""
THESIS = (
    "The impulse there acts on a retracted surface and leaks through it (docs/theory.md); "
    "ξ = 0.1, Δt = 0.015"
)

INTRODUCTION = (
    "A sphere of radius one held in the duct 20×7×7 whose walls slide at 5, Re = 10, as in the "
    "case duct; exact: body-fitted finite elements. Along each axis the width of cells grows with "
    "the distance d from the centre as √(1 + (d/c)²), to "
    f"{RATIOS[0]:g} times the narrowest along the duct and {RATIOS[1]:g} times across; or it does "
    f"so from a core on, equal cells up to {CORE} from the centre. First one "
    f"layer, ξ = {THICKNESS}, and one step, Δt = {STEP}, so that only the mesh differs; then "
    f"ξ = {LAYER_CELLS} cells at the sphere with the step that suits it. Tanh, backward Euler, "
    "each to its steady state from the flow of the mesh before. Not in the thesis, but its fine "
    "mesh is among them."
)


def run() -> Study:
    """Not in the thesis: a minute or two on two cores, 1 GB."""
    coarse = from_rest(uniform(48, 18))
    begun = steady(refined(48, 50), THICKNESS, STEP, 12.0, coarse).simulation
    families = {
        "refined": ladder([refined(*n) for n in REFINED], THICKNESS, STEP, 4.0, begun),
        "core": ladder([cored(*n) for n in REFINED], THICKNESS, STEP, 4.0, begun),
        "uniform": ladder([uniform(*n) for n in UNIFORM], THICKNESS, STEP, 4.0, begun),
    }
    thin = _thin(families)
    meshes = [cored(*n) for n in PAIRED]
    layers = {
        name: paired(meshes, LAYER_CELLS, 3.0, coarse, retract)
        for name, retract in (("radial", True), ("planar", "planar"))
    }
    return study_of(families, thin, layers)


def study_of(
    families: Mapping[str, Sequence[Found]],
    thin: Mapping[str, Found],
    layers: Mapping[str, Sequence[Found]],
) -> Study:
    """The study of those runs: of one layer, of a thin one, of layers as thin as the cells."""
    curves = {f"{name}_meshes": _curve(rows) for name, rows in families.items()}
    for name, seconds in zip(families, _seconds(families), strict=True):
        curves[f"{name}_meshes"]["seconds_per_step"] = np.array(seconds)
    curves |= {f"{name}_painting": _curve(rows) for name, rows in layers.items()}
    curves |= {f"widths_{axis}": _widths(families["refined"][1], axis) for axis in "xy"}
    curves["plane"] = _plane(families["refined"][1])
    pair = _pair(families)
    ratios = {"same": _ratios(pair), "thin": _ratios(thin)}
    rows = [
        *_mesh_rows(families),
        *_pair_rows(f"ξ = {THICKNESS}", pair, ratios["same"]),
        *_pair_rows(f"ξ = {THIN}", thin, ratios["thin"]),
        *_order_rows(curves),
        *_layer_rows(layers, curves),
    ]
    return Study(
        title="Local refinement: a sphere in a duct",
        source="Not in the thesis",
        introduction=INTRODUCTION,
        findings=_findings(pair, ratios, thin, curves),
        rows=rows,
        curves=curves,
        pictures=pictures(curves),
    )


def _pair(families: Mapping[str, Sequence[Found]]) -> dict[str, Found]:
    """The finest uniform mesh, and the refined one that errs as it does."""
    return {"refined": families["refined"][SAME_AS_FINEST], "uniform": families["uniform"][-1]}


def _thin(families: Mapping[str, Sequence[Found]]) -> dict[str, Found]:
    """A layer of two thirds, for which the uniform mesh just suffices."""
    before = families["refined"][-1].simulation
    refined_one = steady(refined(*THIN_REFINED), THIN, THIN_STEP, 2.5, before)
    fine = uniform(*UNIFORM[-1])
    uniform_one = steady(fine, THIN, THIN_STEP, 1.5, refined_one.simulation)
    return {"refined": refined_one, "uniform": uniform_one}


def _ratios(pair: Mapping[str, Found]) -> tuple[float, float]:
    """Uniform over refined: cells, and seconds of a step, both measured in turn."""
    runs: list[Simulation] = [pair[name].simulation for name in ("uniform", "refined")]
    slow, fast = seconds_per_step(runs)
    return pair["uniform"].mesh.count / pair["refined"].mesh.count, slow / fast


def _seconds(families: Mapping[str, Sequence[Found]]) -> list[list[float]]:
    found = seconds_per_step([one.simulation for rows in families.values() for one in rows])
    ends = np.cumsum([len(rows) for rows in families.values()])[:-1]
    return [part.tolist() for part in np.split(np.array(found), ends)]


def _curve(rows: Sequence[Found]) -> dict[str, np.ndarray]:
    return {
        "cells_along": np.array([one.mesh.cells[0] for one in rows]),
        "cells_across": np.array([one.mesh.cells[1] for one in rows]),
        "cells": np.array([one.mesh.count for one in rows]),
        "width": np.array([one.width for one in rows]),
        "thickness": np.array([one.thickness for one in rows]),
        "step": np.array([one.step for one in rows]),
        "force": np.array([one.force for one in rows]),
        "error": np.array([one.error for one in rows]),
        "seconds_of_run": np.array([one.seconds for one in rows]),
    }


def _widths(one: Found, name: str) -> dict[str, np.ndarray]:
    axis = one.simulation.grid.axes["xyz".index(name)]
    return {"centre": axis.centres, "width": axis.widths}


def _plane(one: Found) -> dict[str, np.ndarray]:
    """Speed at the cells of the plane z = 0, as columns."""
    found = one.simulation.sample_plane("z", 0.0)
    axes = one.simulation.grid.axes
    x, y = np.meshgrid(axes[0].centres, axes[1].centres, indexing="ij")
    speed = np.asarray(found["speed"])
    return {"x": x.ravel(), "y": y.ravel(), "speed": speed.ravel()}


def _mesh_rows(families: Mapping[str, Sequence[Found]]) -> list[Row]:
    rows = []
    for name, family in families.items():
        for one in family:
            thesis = 145.46 if one.mesh == uniform(256, 90) else None
            remark = f"{_percent(one.error)}, {one.mesh.count} cells"
            title = f"Force, ξ = {one.thickness:g}, {FAMILIES[name]}, {one.mesh.name}"
            remark += f". {THESIS}" if thesis else ""
            rows.append(Row(title, thesis, FORCE, one.force, REACH * FORCE, remark))
    return rows


def _pair_rows(what: str, pair: Mapping[str, Found], ratios: tuple[float, float]) -> list[Row]:
    fine, few = pair["uniform"], pair["refined"]
    names = f"{few.mesh.name} refined, {fine.mesh.name} uniform"
    return [
        Row(
            f"Error of the refined mesh over the uniform's, {what}",
            *(None, 1.0, few.error / fine.error, SAME),
            f"{_percent(few.error)} and {_percent(fine.error)}: {names}",
        ),
        Row(f"Uniform cells over refined, {what}", None, None, ratios[0], 0.0, names),
        Row(
            f"Seconds of a step, uniform over refined, {what}",
            *(None, None, ratios[1], 0.0, f"the same Δt = {few.step:g}, measured in turn"),
        ),
    ]


def _order_rows(curves: Mapping[str, Mapping[str, np.ndarray]]) -> list[Row]:
    rows, limits = [], {}
    for name in FAMILIES:
        found = curves[f"{name}_meshes"]
        slope, limits[name] = order(1.0 / found["cells_across"], found["force"])
        tail = f"last three meshes; F → {limits[name]:.3f}"
        title = f"Order in Δx at ξ = {THICKNESS}, {FAMILIES[name]}"
        rows.append(Row(title, None, 2.0, slope, ORDER_REACH, tail))
    title = f"Force as Δx → 0 at ξ = {THICKNESS}: refined, uniform as the exact"
    tail = _percent(100.0 * (limits["refined"] / FORCE - 1.0)) + ", what ξ and Δt leave"
    return [*rows, Row(title, None, limits["uniform"], limits["refined"], LIMITS * FORCE, tail)]


def _layer_rows(layers: Mapping[str, Sequence[Found]], curves) -> list[Row]:
    rows = []
    for one in layers["radial"]:
        title = f"Force, ξ = {LAYER_CELLS} cells = {one.thickness:.3g}, {one.mesh.name}, core"
        tail = f"{_percent(one.error)}, Δt = {one.step:.3g}, {one.seconds:.1f} s"
        rows.append(Row(title, None, FORCE, one.force, REACH * FORCE, tail))
    slopes = {name: _slope(curves[f"{name}_painting"]) for name in layers}
    title = "Order of the force in ξ, ξ ∝ Δx, surface moved by "
    radial, planar = title + "the radial problem", title + "the planar shift alone"
    last = f"{_percent(layers['planar'][-1].error)} on the finest mesh"
    return [
        *rows,
        Row(radial, None, None, slopes["radial"], 0.0, "slope of all meshes"),
        Row(planar, None, None, slopes["planar"], 0.0, f"slope of all meshes; {last}"),
    ]


def _slope(curve: Mapping[str, np.ndarray]) -> float:
    logs = np.log(curve["thickness"]), np.log(np.abs(curve["error"]))
    return float(np.polyfit(*logs, 1)[0])


def _percent(value: float) -> str:
    return f"{value:+.3f} %".replace("-", "−")


def _findings(pair, ratios, thin, curves) -> tuple[str, ...]:
    few, fine = pair["refined"], pair["uniform"]
    finest = curves["radial_painting"]
    small = {name: f"{one.error:+.3f}".replace("-", "−") for name, one in thin.items()}
    return (
        f"With ξ = {THICKNESS}, {few.mesh.name} refined cells are off by {_percent(few.error)}, "
        f"{fine.mesh.name} equal ones by {_percent(fine.error)}: {ratios['same'][0]:.1f} times "
        f"fewer cells, and steps {ratios['same'][1]:.1f} times as fast.",
        f"With ξ = {THIN} it is {small['refined']} and {small['uniform']} %, with "
        f"{ratios['thin'][0]:.1f} times fewer cells and steps {ratios['thin'][1]:.1f} times as "
        "fast.",
        "A step costs more for each refined cell, since products with full matrices stand in for "
        "fast transforms; axes that mirror themselves halve those.",
        "Along the duct cells may widen much, and from the centre on; towards the walls, which are "
        f"near, hardly. Equal cells up to {CORE} from the centre keep ξ/Δx the same all over the "
        "layer, but for the force the cells that they take are better spent outside.",
        f"With ξ = {LAYER_CELLS} cells and the step that suits it, the error falls from "
        f"{_percent(finest['error'][0])} at {finest['cells'][0]} cells to "
        f"{_percent(finest['error'][-1])} at {finest['cells'][-1]}.",
    )
