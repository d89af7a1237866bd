"""The figures of the study of methods, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import PALETTE, Picture, drawing, new_panels, power_of_ten

Columns = Mapping[str, np.ndarray]

METHODS = {
    "forcing": "direct forcing",
    "stokes": "Stokes solver",
    "viscosity": "smoothed viscosity",
    "coupling": "force coupling",
    "elements": "finite elements",
}
PROBLEMS = {
    "array_027": "Array, c = 0.027",
    "array_1": "Array, c = 0.1",
    "array_216": "Array, c = 0.216",
    "spin": "Rotating array, c = 0.03",
    "creeping": "Duct, Re → 0",
    "inertia": "Duct, Re = 10",
}
MARKERS = ("o", "s", "^", "D", "v")
LOWEST = 1e-3
"""% of error below which points are drawn at the edge: the exact values have six digits."""


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """Error against seconds, arrays and the rest."""
    groups = (("arrays", list(PROBLEMS)[:3]), ("turning-and-duct", list(PROBLEMS)[3:]))
    with drawing():
        return [
            _against_seconds(name, {key: curves[key] for key in keys if key in curves})
            for name, keys in groups
            if any(key in curves for key in keys)
        ]


def _against_seconds(name: str, curves: Mapping[str, Columns]) -> Picture:
    figure, panels = new_panels(len(curves), height=3.9, width=9.4)
    handles = {}
    for axes, (problem, found) in zip(panels, curves.items(), strict=True):
        for colour, marker, (method, label) in zip(PALETTE, MARKERS, METHODS.items(), strict=False):
            rows = found["method"] == method
            if not rows.any():
                continue
            error = np.maximum(np.abs(found["error"][rows]), LOWEST)
            style = {"color": colour, "marker": marker, "label": label}
            (handles[label],) = axes.loglog(found["seconds"][rows], error, "-", **style)
        axes.set(title=PROBLEMS[problem], xlabel="seconds (s)", ylim=(0.7 * LOWEST, 50.0))
        axes.xaxis.set_major_formatter(power_of_ten)
        axes.yaxis.set_major_formatter(power_of_ten)
        axes.minorticks_off()
    panels[0].set_ylabel("|error| (%)")
    figure.legend(handles.values(), handles, loc="outside lower center", ncols=len(METHODS))
    return Picture(
        name,
        "Error of the force or torque against the seconds of a solve, each point a mesh or an "
        "order of the elements, from coarse to fine. Errors below 0.001 % are drawn there.",
        figure,
        wide=True,
    )
