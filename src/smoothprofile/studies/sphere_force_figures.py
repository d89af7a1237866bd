"""The figures of the study of the force on a dielectric sphere, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import (
    EXACT,
    GUIDE,
    PALETTE,
    Picture,
    drawing,
    legend_below,
    new_panels,
)

Columns = Mapping[str, np.ndarray]

WIDE = {"height": 3.8, "width": 9.4}
ERROR = "error of the force, (exact − F)/exact (%)"
LABELS = {
    "uncorrected": "as painted",
    "dipole": "a_eff of the dipole",
    "quadrupole": "a_eff of the quadrupole",
    "both": "each its own",
}


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """Every figure, in the order of the thesis; those it does not have come last."""
    with drawing():
        return [
            _gauss(curves["gauss_quartic"], curves["gauss_tanh"]),
            _uncorrected(curves["error_against_thickness"]),
            _corrected(curves["error_against_thickness"]),
            _against_ratio(curves["error_against_ratio"]),
        ]


def _gauss(quartic: Columns, tanh: Columns) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    cases = (("Quartic, ξ = 0.2a", quartic, 1.1), ("tanh, ξ = 0.05a", tanh, 1.25))
    for axes, (title, columns, outside) in zip(panels, cases, strict=True):
        (error,) = axes.plot(columns["r"], 100 * columns["error"], color=PALETTE[0])
        level = axes.axvline(outside, **GUIDE)
        other = axes.twinx()
        other.spines["right"].set_visible(True)
        other.grid(False)
        (medium,) = other.plot(columns["r"], columns["permittivity"], color=PALETTE[1])
        medium.set_linestyle(":")
        axes.set(title=f"{title}, R = 2", xlabel="radius of the Gauss sphere, r/a (–)")
        axes.set_ylabel(ERROR)
        other.set_ylabel("ε/ε₂ (–)")
    labels = ("error (left)", "ε/ε₂ (right)", "a + ξ/2, and a + 5ξ for tanh")
    handles = error, medium, level
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return Picture(
        "gauss-radius",
        "Error of the force by the stress (4.22), which has ε₂ everywhere, against the radius of "
        "the Gauss sphere: constant once the sphere lies in the fluid. Thesis, figure 4.11.",
        *(figure, True),
    )


def _uncorrected(columns: Columns) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    thickness = columns["thickness"]
    ours, thesis = columns["uncorrected"], columns["thesis_uncorrected"]
    dots = {"color": PALETTE[1], "marker": "x", "linestyle": "none", "label": "thesis"}
    panels[0].plot(thickness, 100 * ours, marker="o", label="ours")
    panels[0].plot(thickness, 100 * thesis, **dots)
    panels[0].axhline(0.0, **EXACT)
    panels[0].set(title="Quartic, R = 2", xlabel="ξ/a (–)", ylabel=ERROR)
    panels[1].loglog(thickness, np.abs(ours), marker="o")
    panels[1].loglog(thickness, np.abs(thesis), **dots)
    panels[1].loglog(thickness, 0.18 * thickness, **GUIDE)
    panels[0].plot([], [], **GUIDE, label="order 1")
    panels[1].set(
        title="Quartic, R = 2, logarithmic", xlabel="ξ/a (–)", ylabel="|error of the force| (–)"
    )
    legend_below(panels[0], 3)
    return Picture(
        "uncorrected",
        "Error of the force against the thickness of the interface, on a Gauss sphere at a + ξ/2: "
        "first order. Thesis, figure 4.12, with the numbers of its table 4.2.",
        *(figure, True),
    )


def _corrected(columns: Columns) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    thickness = columns["thickness"]
    marks = {"uncorrected": "o", "dipole": "s", "quadrupole": "^", "both": "x"}
    for axes, prefix, title in zip(
        panels,
        ("", "thesis_"),
        ("Quartic, R = 2: ours", "Quartic, R = 2: the thesis' table 4.2"),
        strict=True,
    ):
        for colour, (name, label) in zip(PALETTE, LABELS.items(), strict=False):
            style = {"color": colour, "marker": marks[name], "label": label}
            if name == "both":
                style |= {"linestyle": "--"}
            axes.loglog(thickness, np.abs(columns[f"{prefix}{name}"]), **style)
        axes.loglog(thickness, 0.1 * thickness**2, **GUIDE, label="order 2")
        axes.set(title=title, xlabel="ξ/a (–)", ylabel="|error of the force| (–)", ylim=(3e-5, 0.2))
    legend_below(panels[0], 5)
    return Picture(
        "corrected",
        "Error of the force with the sphere painted at 1/a_eff, quartic, R = 2: second order with "
        "the dipole's a_eff; the quadrupole's own radius changes nothing. Thesis, figure 4.14.",
        *(figure, True),
    )


def _against_ratio(columns: Columns) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    cases = {"quartic_arithmetic": "Quartic, ε interpolated", "sine_tensor": "Sine, tensor"}
    for axes, (name, title) in zip(panels, cases.items(), strict=True):
        for thickness in ("0.05", "0.1", "0.2"):
            error = 100 * columns[f"{name}_{thickness}"]
            axes.plot(columns["ratio"], error, label=f"ξ = {thickness}a")
        axes.axhline(0.0, **EXACT, label="exact")
        axes.set(title=title, xlabel="R = ε₁/ε₂ (–)", ylabel=ERROR, xscale="log")
    legend_below(panels[0], 4)
    return Picture(
        "against-ratio",
        "Error of the force, 1 − a_eff³, against the ratio of permittivities, as the thesis does "
        "it (left) and with the tensor (right). Not in the thesis, which describes it only.",
        *(figure, True),
    )
