"""The figures of the study of smoothed viscosity, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import LEVEL, PALETTE, Picture, drawing, legend_below, new_panels

Columns = Mapping[str, np.ndarray]

SMOOTHINGS = ("arithmetic", "harmonic", "tensor")
WIDE = {"height": 4.2, "width": 9.4}


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """The drag on the grid, lone spheres by theory, and suspensions."""
    with drawing():
        return [_drag(curves), _lone(curves), _dilute(curves)]


def _drag(curves: Mapping[str, Columns]) -> Picture:
    figure, (left, right) = new_panels(2, **WIDE)
    lattice, contrast = curves["lattice"], curves["contrast"]
    xi = lattice["thickness"]
    for colour, name in zip(PALETTE, SMOOTHINGS, strict=False):
        mark = _mark(name, colour)
        words = f"{name}, retracted"
        left.loglog(xi, 100 * np.abs(lattice[f"{name}_retracted"]), **mark, label=words)
        words = f"{name}, as painted"
        left.loglog(
            xi, 100 * np.abs(lattice[f"{name}_painted"]), **mark, linestyle="--", label=words
        )
        right.loglog(contrast["ratio"], contrast[f"{name}_iterations"], **mark)
    rigid = {"marker": "s", "color": "black", "linewidth": 1.0, "label": "rigid motion imposed"}
    left.loglog(xi, 100 * np.abs(lattice["constrained"]), **rigid)
    left.set(title="Drag, R = 1000", xlabel="ξ/a (–)", ylabel="|F/exact − 1| (%)")
    right.set(
        title="Iterations, ξ = 0.14a", xlabel="R, sphere over fluid (–)", ylabel="iterations (–)"
    )
    _plain(left, "x", xi)
    _plain(left, "y", (0.1, 1.0, 10.0, 100.0))
    _plain(right, "y", (5, 10, 20, 50, 100, 200))
    legend_below(left, 4)
    return Picture(
        "drag",
        "Simple cubic lattice of spheres, c = 0.064, tanh, Δx = 0.84ξ. Left: error of the drag "
        "against ξ; the solver that imposes rigid motion has a layer of its own, and the same "
        "cells. Right: iterations to a residual of 10⁻³, retracted.",
        *(figure, True),
    )


def _lone(curves: Mapping[str, Columns]) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    for axes, ratio in zip(panels, ("10", "1000"), strict=True):
        columns = curves[f"lone_sphere_R{ratio}"]
        for colour, name in zip(PALETTE, SMOOTHINGS, strict=False):
            mark = _mark(name, colour)
            for suffix, dash, words in (
                ("stresslet_retracted", "-", "painted for the drag"),
                ("stresslet", "--", "as painted"),
            ):
                values = 100 * np.abs(columns[f"{name}_{suffix}"])
                label = f"{name}, {words}"
                axes.loglog(columns["thickness"], values, **mark, linestyle=dash, label=label)
        axes.set(title=f"Stresslet of a lone sphere, R = {ratio}", xlabel="ξ/a (–)")
        axes.set(ylabel="|S/exact − 1| (%)", ylim=(0.01, 1000.0))
        _plain(axes, "x", columns["thickness"])
        _plain(axes, "y", (0.01, 0.1, 1.0, 10.0, 100.0, 1000.0))
    legend_below(panels[0], 3)
    return Picture(
        "lone-sphere",
        "Error of the stresslet of a sphere alone in a straining flow, by the radial problem, "
        "tanh, painted with its own radius and with the one that gives its exact drag. At R = 10 "
        "the tensor's changes sign near ξ = 0.05a.",
        *(figure, True),
    )


def _dilute(curves: Mapping[str, Columns]) -> Picture:
    figure, (axes,) = new_panels(1, height=3.8, width=5.6)
    columns = curves["dilute"]
    for colour, name in zip(PALETTE, SMOOTHINGS, strict=False):
        mark = _mark(name, colour)
        for motion, dash in (("stresslet", "-"), ("drag", "--")):
            label = f"{name}, painted for the {motion}"
            axes.semilogx(
                columns["ratio"], 100 * columns[f"{name}_{motion}"], **mark, linestyle=dash,
                label=label,
            )  # fmt: skip
    axes.axhline(0.0, **LEVEL)
    axes.set(
        title="Error of μ_eff/μ − 1, c = 0.01",
        xlabel="R, sphere over fluid (–)",
        ylabel="error (%)",
    )
    legend_below(axes, 2)
    return Picture(
        "effective-viscosity",
        "Error of the increment of viscosity by drops on a simple cubic lattice in shear, "
        "ξ = 0.2a, 40 cells to the lattice constant. Arithmetic smoothing has no painted radius at "
        "R = 10⁴.",
        figure,
    )


def _mark(name: str, colour: str) -> dict:
    """Arithmetic and harmonic, retracted, lie on each other: crosses in front of dots."""
    if name == "arithmetic":
        return {"marker": "x", "markersize": 8, "zorder": 3, "color": colour, "linewidth": 0.8}
    return {"marker": "o", "color": colour}


def _plain(axes, along: str, values) -> None:
    """Ticks at those values, written out."""
    axis = axes.xaxis if along == "x" else axes.yaxis
    axis.set_ticks(list(values), [f"{value:g}" for value in values])
    axis.set_ticks((), minor=True)
