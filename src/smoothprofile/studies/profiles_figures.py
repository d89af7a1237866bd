"""The figures of the study of profiles, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import (
    GUIDE,
    LEVEL,
    PALETTE,
    Picture,
    drawing,
    legend_below,
    new_panels,
)
from smoothprofile.studies.profiles_curves import CHOSEN_WIDTH

Columns = Mapping[str, np.ndarray]

RATIO, ACROSS = "R = ε₁/ε₂ (–)", "cells across the layer, 10–90 % (–)"
SMOOTHINGS = ("arithmetic", "harmonic", "tensor")
DASHES = {"tanh": "-", "sine": "--", "quartic-centred": ":", "quartic": "-."}
PROFILES = ("tanh", "sine", "quartic-centred")
NAMES = {name: name for name in PROFILES} | {"quartic": "quartic, printed"}
RATIOS = ("0.01", "0.1", "2", "10", "100")
CHOSEN_LABEL = "recommended: tanh, ξ = 0.75Δx"


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """The figure that answers, and the two it rests on."""
    with drawing():
        return [_answer(curves), _every_ratio(curves), _theory(curves)]


def _answer(curves: Mapping[str, Columns]) -> Picture:
    figure, panels = new_panels(2, height=4.3, width=9.4)
    titles = ("Largest error of ε_eff, R = 0.01 … 100", "Largest force of the grid, R = 0.01 … 100")
    labels = ("|ε_eff/exact − 1| (%)", "force/attraction at a gap of a (–)")
    for axes, name, factor, title, label in zip(
        panels, ("", "hold_"), (100.0, 1.0), titles, labels, strict=True
    ):
        for colour, profile in zip(PALETTE, PROFILES, strict=False):
            columns = curves[f"cylinders_{profile}"]
            across = columns["cells_across"]
            style = {"color": colour, "marker": "o", "markersize": 3}
            for kind, dash in (("retracted", "-"), ("painted", "--")):
                words = f"{profile}, {kind if kind == 'retracted' else 'as painted'}"
                values = factor * columns[f"{kind}_{name}worst"]
                axes.semilogy(across, values, **style, linestyle=dash, label=words)
        columns = curves["cylinders_tanh"]
        at = int(np.argmin(np.abs(columns["cells_across"] - CHOSEN_WIDTH)))
        best = factor * columns[f"retracted_{name}worst"][at]
        star = {"marker": "*", "markersize": 15, "color": "black", "linestyle": "none"}
        axes.plot(columns["cells_across"][at], best, **star, label=CHOSEN_LABEL)
        axes.set(title=title, xlabel=ACROSS, ylabel=label)
    shown = (0.2, 0.3, 0.5, 1.0, 2.0, 4.0)
    panels[0].set_yticks(shown, [f"{value:g}" for value in shown])
    panels[0].set_yticks((), minor=True)
    legend_below(panels[0], 4)
    return Picture(
        "recommendation",
        "Square array of cylinders, a = 8Δx, tensor smoothing, the worst of R = 0.01, 0.1, 2, 10, "
        "100. Left: error of the effective permittivity. Right: force with which the grid holds a "
        "cylinder, over the attraction of a neighbour. Retracted tanh at 1.65 cells is accurate "
        "and lets go. Not in the thesis.",
        *(figure, True),
    )


def _every_ratio(curves: Mapping[str, Columns]) -> Picture:
    figure, panels = new_panels(len(RATIOS), height=4.1, width=12.5)
    for axes, ratio in zip(panels, RATIOS, strict=True):
        for colour, profile in zip(PALETTE, PROFILES, strict=False):
            columns = curves[f"cylinders_{profile}"]
            for kind, dash in (("retracted", "-"), ("painted", "--")):
                words = f"{profile}, {kind if kind == 'retracted' else 'as painted'}"
                style = {"color": colour, "linestyle": dash, "label": words}
                axes.plot(columns["cells_across"], 100 * columns[f"{kind}_R{ratio}"], **style)
        axes.axhline(0.0, **LEVEL, label="exact")
        axes.axvline(CHOSEN_WIDTH, **GUIDE, label="1.65 cells")
        axes.set(title=f"R = {ratio}", xlabel="cells across (–)", ylabel="error of ε_eff (%)")
    legend_below(panels[0], 4)
    return Picture(
        "every-ratio",
        "Error of the effective permittivity of a square array of cylinders, a = 8Δx, tensor "
        "smoothing, against the cells across the layer from 10 to 90 % of φ. Not in the thesis.",
        *(figure, True),
    )


def _theory(curves: Mapping[str, Columns]) -> Picture:
    figure, panels = new_panels(3, height=4.3, width=12.5)
    painted, retracted = curves["dipole_as_painted"], curves["multipoles_retracted"]
    cases = (
        (painted, "", "Dipole, as painted", DASHES),
        (retracted, "quadrupole_", "Quadrupole, dipole retracted", PROFILES),
        (retracted, "octupole_", "Octupole, dipole retracted", PROFILES),
    )
    for axes, (columns, prefix, title, profiles) in zip(panels, cases, strict=True):
        for colour, smoothing in zip(PALETTE, SMOOTHINGS, strict=False):
            for profile in profiles:
                values = 100 * np.abs(columns[f"{prefix}{smoothing}_{profile}"])
                style = {"color": colour, "linestyle": DASHES[profile]}
                axes.loglog(
                    columns["ratio"], values, **style, label=f"{smoothing}, {NAMES[profile]}"
                )
        axes.set(title=title, xlabel=RATIO, ylabel="|a_eff − a|/a (%)", ylim=(0.01, 60.0))
    legend_below(panels[0], 6)
    return Picture(
        "theory",
        "Effective radius of a sphere whose layer is a quarter of its radius wide from 10 to 90 % "
        "of φ: two cells of eight. Retracted, the dipole has no error; with tanh, arithmetic and "
        "harmonic smoothing then coincide. Not in the thesis.",
        *(figure, True),
    )
