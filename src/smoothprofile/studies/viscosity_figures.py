"""The figures of the study of effective viscosity, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import LEVEL, PALETTE, Picture, drawing, new_panels

Columns = Mapping[str, np.ndarray]

WIDE = {"height": 3.7, "width": 9.4}
STRAINS = {"xy": "shear E_xy", "xx": "stretch E_xx = −E_yy"}
PAINTINGS = {
    "stresslet": "painted for its stresslet",
    "drag": "painted for its drag",
    "as_given": "painted where it is",
}
MOTIONS = {"translation": "drag", "rotation": "torque", "straining": "stresslet"}


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """The viscosities, and what the layer does to them."""
    with drawing():
        return [_viscosity(curves), _layer(curves)]


def _viscosity(curves: Mapping[str, Columns]) -> Picture:
    figure, (left, right) = new_panels(2, **WIDE)
    exact, ours = curves["cubic_series"], curves["cubic_lattice"]
    for colour, (name, label) in zip(PALETTE, STRAINS.items(), strict=False):
        dots = {"marker": "o", "linestyle": "none", "color": colour, "label": f"ours, {label}"}
        left.plot(exact["c"], exact[name], color=colour, label=f"series, {label}")
        left.plot(ours["c"], ours[name], **dots)
        right.plot(exact["c"], (exact[name] - 1) / exact["c"], color=colour)
        right.plot(ours["c"], (ours[name] - 1) / ours["c"], **dots)
    left.plot(exact["c"], 1 + 2.5 * exact["c"], **LEVEL, label="Einstein, 1 + 2.5c")
    right.axhline(2.5, **LEVEL)
    left.set(title="Effective viscosity", xlabel="c (–)", ylabel="μ_eff/μ (–)", xlim=(0, None))
    right.set(title="Its increment over c", xlabel="c (–)", ylabel="(μ_eff/μ − 1)/c (–)")
    right.set(xlim=(0, None))
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return Picture(
        "effective-viscosity",
        "Effective viscosity of free spheres on a simple cubic lattice, Re → 0, tanh, ξ = 0.25a, "
        "64 cells to the lattice constant. Not in the thesis.",
        *(figure, True),
    )


def _layer(curves: Mapping[str, Columns]) -> Picture:
    figure, (left, right) = new_panels(2, **WIDE)
    layers, painted = curves["layers"], curves["painted"]
    for name, label in PAINTINGS.items():
        left.plot(layers["thickness"], 100 * layers[name], "-o", label=label)
    left.axhline(0.0, **LEVEL)
    left.set(title="Error of μ_eff/μ − 1, c = 0.03", xlabel="ξ/a (–)", ylabel="error (%)")
    for name, label in MOTIONS.items():
        right.plot(painted["thickness"], painted[name] - 1, label=f"for its {label}")
    right.axhline(0.0, **LEVEL)
    right.set(title="Where a lone sphere is painted", xlabel="ξ/a (–)", ylabel="a*/a − 1 (–)")
    for axes in (left, right):
        axes.legend()
        axes.set_xlim(0, None)
    return Picture(
        "layer",
        "Left: error of the increment in shear against ξ, 48 cells to the lattice constant. Right: "
        "painted radius at which a lone sphere has the exact drag, torque or stresslet, "
        "√(νΔt) = 0.755ξ, tanh. Not in the thesis.",
        *(figure, True),
    )
