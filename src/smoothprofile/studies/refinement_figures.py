"""The figures of the study of refinement, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import GUIDE, PALETTE, Picture, drawing, new_figure, new_panels

Columns = Mapping[str, np.ndarray]

FAMILIES = {"refined": "refined", "core": "refined beyond a core", "uniform": "equal cells"}
PAINTINGS = {"radial": "surface moved by the radial problem", "planar": "by the planar shift alone"}
SHOWN = 5.0
"""Of the duct either side of the sphere."""


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """Errors against cells, seconds and ξ, and the mesh."""
    with drawing():
        return [_errors(curves), _layers(curves), _mesh(curves)]


def _errors(curves: Mapping[str, Columns]) -> Picture:
    figure, (left, right) = new_panels(2, height=3.8, width=9.4)
    for colour, (name, label) in zip(PALETTE, FAMILIES.items(), strict=False):
        found = curves[f"{name}_meshes"]
        left.semilogx(found["cells"], found["error"], "-o", color=colour, label=label)
        right.semilogx(1e3 * found["seconds_per_step"], found["error"], "-o", color=colour)
        if name == "core":
            continue
        for cells, error, *count in zip(
            *(found[key] for key in ("cells", "error", "cells_along", "cells_across")), strict=True
        ):
            above = name == "refined"
            left.annotate(
                "×".join(f"{n}" for n in (*count, count[-1])),
                (cells, error),
                (-6, 4) if above else (6, -12),
                textcoords="offset points",
                ha="right" if above else "left",
                fontsize=7,
                color=colour,
            )
    left.set(title="Error of the force, ξ = 0.15", xlabel="cells (–)", ylabel="F/F₀ − 1 (%)")
    right.set(title="The same against time", xlabel="a step (ms)", ylabel="F/F₀ − 1 (%)")
    left.margins(0.3, 0.12)
    left.legend(loc="lower right")
    return Picture(
        "error",
        "Error of the force on the sphere, one layer and one step on every mesh, against cells and "
        "the time of a step. F₀: body-fitted finite elements. What is left on the right is the "
        "layer's.",
        *(figure, True),
    )


def _layers(curves: Mapping[str, Columns]) -> Picture:
    figure, axes = new_figure(3.8)
    for colour, (name, label) in zip(PALETTE, PAINTINGS.items(), strict=False):
        found = curves[f"{name}_painting"]
        axes.loglog(found["thickness"], np.abs(found["error"]), "-o", color=colour, label=label)
    ends = np.array([found["thickness"].min(), found["thickness"].max()])
    low = 1.25 * np.abs(found["error"]).max() * (ends / ends[1]) ** 2
    axes.loglog(ends, low, **GUIDE, label="ξ²")
    axes.set(title="ξ as thin as the cells", xlabel="ξ/a (–)", ylabel="|F/F₀ − 1| (%)")
    ticks = [float(f"{value:.2g}") for value in found["thickness"]]
    axes.set_xticks(ticks, [f"{value:g}" for value in ticks])
    axes.minorticks_off()
    axes.legend(loc="center right")
    return Picture(
        "layers",
        "Error of the force with ξ = 1.6 cells of the core and √(νΔt) = 0.755ξ, refined beyond.",
        figure,
    )


def _mesh(curves: Mapping[str, Columns]) -> Picture:
    figure, axes = new_figure(4.2, 9.0)
    faces = []
    for name in "xy":
        found = curves[f"widths_{name}"]
        edges = found["centre"] - 0.5 * found["width"]
        faces.append(np.append(edges, found["centre"][-1] + 0.5 * found["width"][-1]))
    plane = curves["plane"]
    speed = plane["speed"].reshape(faces[0].size - 1, faces[1].size - 1)
    mesh = axes.pcolormesh(*faces, speed.T, edgecolor="white", linewidth=0.15)
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    axes.plot(np.cos(angle), np.sin(angle), color="white", linewidth=1.2)
    figure.colorbar(mesh, ax=axes, label="|u| (length/time)", pad=0.01, aspect=25)
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set(xlim=(-SHOWN, SHOWN), xlabel="x (length)", ylabel="y (length)")
    count = f"{faces[0].size - 1}×{faces[1].size - 1}×{faces[1].size - 1}"
    axes.set_title(f"{count} cells, in the plane z = 0")
    caption = (
        "Speed in the cells of the plane z = 0 of a refined mesh, the middle half of the duct; "
        "white: the sphere."
    )
    return Picture("mesh", caption, figure, wide=True)
