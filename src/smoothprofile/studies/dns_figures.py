"""The figures of the study of body-fitted flows, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.body_fitted.facets import outline, small_triangles
from smoothprofile.figures import (
    PALETTE,
    Picture,
    drawing,
    new_figure,
    new_panels,
    power_of_ten,
)

Columns = Mapping[str, np.ndarray]

LADDERS = {
    "duct_force": "Re = 10",
    "duct_force_finer": "Re = 10, finer mesh",
    "duct_creeping": "Re → 0",
    "duct_creeping_finer": "Re → 0, finer mesh",
}
SMOOTHED = {"spm_re_10": "SPM, Re = 10", "spm_re_0": "SPM, Re → 0"}
MESH = {"color": "white", "linewidth": 0.4, "alpha": 0.8}


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """How the forces converge, the flow with its mesh, and the speed along the axis."""
    with drawing():
        return [_convergence(curves), _flow(curves["plane"]), _axis(curves)]


def _convergence(curves: Mapping[str, Columns]) -> Picture:
    figure, (left, right) = new_panels(2, height=4.3, width=9.4)
    for colour, (name, label) in zip((0, 0, 1, 1), LADDERS.items(), strict=True):
        style = {"color": PALETTE[colour], "linestyle": "--" if "finer" in label else "-"}
        left.loglog(*_errors(curves[name]), "o", label=label, **style)
    for colour, (name, label) in zip(PALETTE, SMOOTHED.items(), strict=False):
        given = curves[name]
        off = 100 * np.abs(given["force"] / given["body_fitted"] - 1)
        style = {"color": colour, "linestyle": ":", "markerfacecolor": "white"}
        left.loglog(given["unknowns"], off, "s", label=label, **style)
    arrays = [name for name in curves if name.startswith("array_")]
    for name, colour in zip(arrays, PALETTE, strict=False):
        label = f"c = 0.{name.removeprefix('array_')}"
        right.loglog(*_errors(curves[name]), "o-", color=colour, label=label)
    for axes in (left, right):
        axes.yaxis.set_major_formatter(power_of_ten)
        axes.xaxis.set_major_formatter(power_of_ten)
        axes.minorticks_off()
        axes.set_xlabel("unknowns (–)")
    right.set_xlim(1e3, 1e5)
    left.set(title="Sphere in a duct", ylabel="|F/F∞ − 1| (%)")
    right.set(title="Simple cubic arrays, Stokes flow", ylabel="|K/K∞ − 1| (%)")
    left.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=2)
    right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    caption = (
        "Error of the force against the number of unknowns, each point one order of the elements. "
        "F∞ and K∞ are extrapolated from the last three orders; for the smoothed profile method "
        "F∞ is that of the finite elements, and it has four unknowns to a cell."
    )
    return Picture("convergence", caption, figure, wide=True)


def _errors(curve: Columns) -> tuple[np.ndarray, np.ndarray]:
    """Unknowns, and how far each value is from the limit in %."""
    return curve["unknowns"], 100.0 * np.abs(curve["value"] / curve["limit"] - 1.0)


def _flow(plane: Columns) -> Picture:
    """Speed in the plane z = 0: above with the mesh, below its mirror image."""
    facets = int(plane["facet"][-1]) + 1
    x, y, speed = (plane[n].reshape(facets, -1) for n in ("x", "y", "speed"))
    points = x.shape[1]
    steps = round((np.sqrt(8 * points + 1) - 3) / 2)
    small = (small_triangles(steps)[None] + points * np.arange(facets)[:, None, None]).reshape(
        -1, 3
    )
    figure, axes = new_figure(3.7, 9.0)
    levels = np.linspace(0.0, speed.max(), 25)
    for side in (1.0, -1.0):
        filled = axes.tricontourf(x.ravel(), side * y.ravel(), small, speed.ravel(), levels=levels)
        filled.set_edgecolor("face")
    around = outline(steps)
    axes.plot(x[:, around].T, y[:, around].T, **MESH)
    figure.colorbar(filled, ax=axes, label="|u| (length/time)", pad=0.01, aspect=25, format="%.1f")
    axes.set_aspect("equal")
    axes.grid(visible=False)
    axes.set(title="Speed in the plane z = 0, Re = 10", xlabel="x (length)", ylabel="y (length)")
    figure.draw_without_rendering()
    caption = (
        "Speed in the plane z = 0 by elements of the highest order, Re = 10. Above, the edges of "
        "the elements, curved to fit the sphere; below, the mirror image without them."
    )
    return Picture("plane", caption, figure, wide=True)


def _axis(curves: Mapping[str, Columns]) -> Picture:
    figure, axes = new_figure(3.4)
    ours, known, smooth = curves["axis"], curves["axis_known"], curves["axis_spm"]
    axes.axvspan(-1.0, 1.0, color="#eeeeee", zorder=0)
    for low, high in ((-np.inf, 0.0), (0.0, np.inf)):
        part = (ours["x"] > low) & (ours["x"] < high)
        label = "finite elements" if high else None
        axes.plot(ours["x"][part], ours["u"][part], color=PALETTE[0], label=label)
    axes.plot(smooth["x"], smooth["u"], "--", color=PALETTE[1], label="SPM, 96×34×34 cells")
    axes.plot(known["x"], known["u"], "o", color="black", markersize=3.5, label="another mesh")
    axes.set(title="Along the axis, Re = 10", xlabel="x (length)", ylabel="u (length/time)")
    axes.legend(loc="lower right")
    return Picture("axis", "Velocity along the axis of the duct; grey: the sphere.", figure)
