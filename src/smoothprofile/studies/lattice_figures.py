"""The figures of the lattice study, drawn from its curves alone."""

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

Columns = Mapping[str, np.ndarray]

WIDE = {"height": 3.7, "width": 9.4}
LEVELS = 42
CELLS = {"4": ("0.05", "4.15", "4.16"), "8": ("0.1", "4.17", "4.18")}
OUTCOMES = (
    (0, "(4.27), converged", "o", PALETTE[0]),
    (1, "(4.27), seen to diverge", "X", PALETTE[1]),
    (2, "(4.27), neither within 400", "s", PALETTE[4]),
)
HISTORIES = ("2", "10", "30", "60", "100", "0.01")


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """Every figure, in the order of the thesis; those it does not have come last."""
    with drawing():
        made = []
        for length in CELLS:
            plane, line = curves[f"lattice_{length}_plane"], curves[f"lattice_{length}_line"]
            made += [_potential(length, plane, line), _slopes(length, plane)]
        return [
            *made,
            _convergence(curves["iterations_against_ratio"], curves["errors_of_iterations"]),
            _smoothings(curves["smoothings"]),
        ]


def _potential(length: str, plane: Columns, line: Columns) -> Picture:
    thickness, number, _ = CELLS[length]
    figure, (left, right) = new_panels(2, **WIDE)
    _map(figure, left, plane, "potential", "ψ (E∞a)")
    left.set_title(f"ψ at x₃ = 0, L = {length}a")
    right.plot(line["x1"], line["potential"])
    for edge in (-1.0, 1.0):
        right.axvline(edge, **GUIDE, label="surface" if edge < 0 else None)
    right.set(title="ψ at x₂ = x₃ = 0", xlabel="x₁/a (–)", ylabel="ψ (E∞a)")
    right.legend()
    return Picture(
        f"potential-{length}",
        f"Potential ψ of the lattice's disturbance, L = {length}a, ξ = {thickness}a, R = 2, "
        f"N = 256, iteration 5. Thesis, figure {number}"
        + (", whose caption says ξ = 0.05a where its text says 0.1a." if length == "8" else "."),
        *(figure, True),
    )


def _slopes(length: str, plane: Columns) -> Picture:
    thickness, _, number = CELLS[length]
    figure, panels = new_panels(2, **WIDE)
    for axes, d, symbol in zip(panels, (1, 2), "₁₂", strict=True):
        _map(figure, axes, plane, f"slope{d}", f"∂ψ/∂x{symbol} (E∞)")
        axes.set_title(f"∂ψ/∂x{symbol} at x₃ = 0, L = {length}a")
    return Picture(
        f"slopes-{length}",
        f"∇ψ along the field and across it, L = {length}a, ξ = {thickness}a, R = 2, N = 256, "
        "iteration 5: in the sphere the first is near +¼ everywhere and the second near zero. "
        f"Thesis, figure {number}.",
        *(figure, True),
    )


def _map(figure, axes, plane: Columns, name: str, label: str) -> None:
    """Filled contours, white at zero, and the sphere."""
    count = round(np.sqrt(plane["x1"].size))
    x, y, values = (plane[key].reshape(count, count) for key in ("x1", "x2", name))
    largest = float(np.abs(values).max())
    levels = np.linspace(-largest, largest, LEVELS)
    filled = axes.contourf(x, y, values, levels, cmap="RdBu_r")
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(np.cos(angle), np.sin(angle), color="black", linewidth=0.8)
    axes.set(xlabel="x₁/a (–)", ylabel="x₂/a (–)", aspect="equal")
    axes.grid(False)
    bar = figure.colorbar(filled, ax=axes, label=label)
    ticks = np.linspace(-largest, largest, 5)
    bar.set_ticks(ticks, labels=[f"{tick:.3f}".replace("-", "−") for tick in ticks])


def _convergence(scan: Columns, histories: Columns) -> Picture:
    figure, (left, right) = new_panels(2, height=3.9, width=9.4)
    left.plot(scan["ratio"], scan["gradients"], "-^", color=PALETTE[2], label="conjugate gradients")
    for outcome, label, marker, colour in OUTCOMES:
        chosen = scan["status"] == outcome
        style = {"marker": marker, "color": colour, "linestyle": "none", "label": label}
        left.plot(scan["ratio"][chosen], scan["fixed_point"][chosen], **style)
    left.set(title="Iterations until the end", xlabel="R = ε₁/ε₂ (–)", ylabel="iterations (–)")
    left.set(xscale="log", yscale="log", ylim=(4, 3000))
    left.legend(ncols=2, loc="upper center", fontsize=8)
    for colour, ratio in zip(PALETTE, HISTORIES, strict=False):
        dash = "--" if ratio == "0.01" else "-"
        style = {"color": colour, "linestyle": dash, "label": f"R = {ratio}"}
        right.semilogy(histories["iteration"], histories[f"R{ratio}"], **style)
    right.axvline(5, **GUIDE, label="iteration 5")
    right.set(title="Errors of (4.27)", xlabel="iteration (–)", xlim=(0, 130), ylim=(1e-9, 1e4))
    right.set_ylabel("error over the first (–)")
    right.legend(ncols=3, loc="upper right", fontsize=8)
    return Picture(
        "convergence",
        "The thesis' iteration against conjugate gradients, to 1e-8, L = 4a, ξ = 0.1a, N = 32; and "
        "its errors, which fall at first even where they grow without end. Not in the thesis.",
        *(figure, True),
    )


def _smoothings(columns: Columns) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    names = {"permittivity": ("ε_eff", "ε_eff/ε₂ (–)"), "mean": ("In the sphere", "⟨−∇ψ⟩₁ (E∞)")}
    for axes, (name, (title, label)) in zip(panels, names.items(), strict=True):
        axes.plot(columns["thickness"], columns[f"{name}_arithmetic"], label="ε interpolated")
        axes.plot(columns["thickness"], columns[f"{name}_tensor"], label="tensor")
        axes.axhline(columns[f"{name}_sharp"][0], **LEVEL, label="sharp spheres")
        point = columns["staggered_thickness"][:1], columns[f"{name}_staggered"][:1]
        axes.plot(*point, "o", color=PALETTE[1], label="staggered grid, ξ = 0.75Δx, N = 128")
        axes.set(title=f"{title}, L = 4a, R = 2", xlabel="ξ/a (–)", ylabel=label, xlim=(0, None))
    legend_below(panels[0], 4)
    return Picture(
        "smoothings",
        "Effective permittivity, and mean of (−∇ψ)₁ in a box of side a, against the thickness of "
        "the layer, by multipole series: interpolating ε errs in the first order of ξ, the tensor "
        "in the second. Not in the thesis.",
        *(figure, True),
    )
