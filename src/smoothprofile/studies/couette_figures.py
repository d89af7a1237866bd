"""The figures of the Couette study, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import (
    EXACT,
    LEVEL,
    PALETTE,
    Picture,
    drawing,
    legend_below,
    new_figure,
    new_panels,
    power_of_ten,
)

Columns = Mapping[str, np.ndarray]

HEIGHT, WALL = 3.3, 3.0
PANELS = {"height": 3.6, "width": 9.4}
SCHEMES = ("backward-euler", "crank-nicolson", "bdf2", "bdf3")
PROFILES = ("tanh", "quartic", "quartic-centred", "sine")
THICKNESSES, VISCOSITIES = ("0.2", "0.1", "0.05"), ("0.5", "1", "2")
RATIO = "k = √(νΔt)/ξ (–)"
L2 = "L2 error √∫(uⁿ − u)²dy (–)"


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """Every figure, in the order of the thesis; those it does not have come last."""
    with drawing():
        return [
            _sketch(curves["standard"]),
            _velocity(curves["standard"]),
            _force(curves["standard"], curves["option_1"]),
            _against_step(curves["error_against_step"]),
            _against_ratio(curves["error_against_ratio"]),
            _option_1(curves["standard"], curves["option_1"]),
            _against_thickness(curves["error_against_thickness"]),
            _option_2(curves["option_2_100"], curves["option_2_1000"]),
            _option_2_errors(
                curves["option_2_against_thickness"], curves["option_2_against_viscosity"]
            ),
            _shift(curves["shift"]),
        ]


def _sketch(standard: Columns) -> Picture:
    figure, axes = new_figure(height=3.6)
    axes.axhspan(WALL, 2 * WALL, color="#e4e4e4", label="wall, moving at V = 1")
    axes.plot(standard["exact_velocity"], standard["y"], **EXACT, label="velocity u")
    for y in np.linspace(0.5, 5.5, 11):
        speed = min(y / WALL, 1.0)
        style = {"color": PALETTE[0], "head_width": 0.12, "head_length": 0.03}
        axes.arrow(0, y, speed, 0, length_includes_head=True, linewidth=0.8, **style)
    axes.axhline(0, color="black", linewidth=3, label="plate at rest")
    axes.set(title="The flow", xlabel="u (–)", ylabel="y (–)", xlim=(-0.05, 1.15), ylim=(-0.1, 6))
    axes.set_yticks([0, 3, 6], ["0", "h = 3", "2h = 6"])
    legend_below(axes, 3)
    caption = "Planar Couette flow: fluid below y = h, a moving wall above. (Figure 3.1)"
    return Picture("sketch", caption, figure)


def _velocity(standard: Columns) -> Picture:
    lines = {
        "u*, before the impulse": (standard, "predicted_velocity"),
        "uⁿ, after the impulse": (standard, "velocity"),
    }
    caption = (
        "Velocity near the wall at y = 3: backward Euler, tanh, ξ = 0.1, Δt = 0.005625 "
        "(k = 0.75). (Figure 3.2)"
    )
    return _near_wall("velocity", "Velocity near the wall", standard, lines, 3.6, caption)


def _near_wall(
    name: str,
    title: str,
    standard: Columns,
    lines: Mapping[str, tuple[Columns, str]],
    highest: float,
    caption: str,
) -> Picture:
    """Velocities beside that at a sharp wall; lines: label -> where they are, and their column."""
    figure, axes = new_figure(HEIGHT)
    axes.plot(standard["y"], standard["exact_velocity"], **EXACT, label="u, sharp wall")
    for label, (columns, velocity) in lines.items():
        axes.plot(columns["y"], columns[velocity], label=label)
    axes.set(title=title, xlabel="y (–)", ylabel="u (–)", xlim=(2.6, highest), ylim=(0.85, 1.02))
    legend_below(axes, 3)
    return Picture(name, caption, figure)


def _force(standard: Columns, option_1: Columns) -> Picture:
    figure, axes = new_figure(HEIGHT)
    axes.plot(standard["y"], standard["force_density"], label="f = φ(V − u*)/Δt")
    axes.plot(option_1["y"], option_1["force_density"], "--", label="option 1, f = τ₀ dφ/dy")
    axes.axvline(WALL, **LEVEL, label="wall, y = h")
    axes.set(title="Force density", xlabel="y (–)", ylabel="f (–)", xlim=(2.4, 3.6))
    legend_below(axes, 3)
    caption = (
        "Force density f of the force on the fluid, ξ = 0.1, Δt = 0.005625: skewed towards the "
        "inside of the wall, beside the symmetrical one of option 1. (Figure 3.3)"
    )
    return Picture("force-density", caption, figure)


def _against_step(curves: Columns) -> Picture:
    figure, (left, right) = new_panels(2, **PANELS)
    for number, viscosity in enumerate(VISCOSITIES):
        error = curves[f"l2_error_thickness_0.05_viscosity_{viscosity}"]
        left.loglog(curves["time_step"], error, color=PALETTE[number], label=f"ν = {viscosity}")
    for number, thickness in enumerate(THICKNESSES):
        error = curves[f"l2_error_thickness_{thickness}_viscosity_1"]
        right.loglog(
            curves["time_step"], error, color=PALETTE[number + 3], label=f"ξ = {thickness}"
        )
    left.set(title="Velocity error, ξ = 0.05")
    right.set(title="Velocity error, ν = 1")
    for axes in (left, right):
        _powers(axes, "x", "y")
        axes.set(xlabel="Δt (–)", ylabel=L2, ylim=(3e-4, 0.5))
        axes.legend(loc="lower right")
    caption = (
        "L2 error of uⁿ against Δt, backward Euler, tanh: the best Δt is (0.755ξ)²/ν. (Figure 3.4)"
    )
    return Picture("error-against-step", caption, figure, wide=True)


def _against_ratio(curves: Columns) -> Picture:
    figure, (left, right) = new_panels(2, **PANELS)
    for number, thickness in enumerate(THICKNESSES):
        style = {"color": PALETTE[number], "label": f"ξ = {thickness}"}
        left.semilogy(curves["ratio"], curves[f"l2_error_{thickness}"], **style)
        right.plot(curves["ratio"], 100 * curves[f"stress_error_{thickness}"], **style)
    left.set(title="a. Velocity error", xlabel=RATIO, ylabel=L2)
    _powers(left, "y")
    right.set(title="b. Error of the wall stress", xlabel=RATIO, ylabel="(τ − τ₀)/τ₀ (%)")
    right.axhline(0, color="black", linewidth=0.8)
    for axes in (left, right):
        axes.axvline(0.755222, label="k = 0.7552", **LEVEL)
        axes.legend(loc="lower right" if axes is left else "upper right")
    caption = (
        "Errors against k = √(νΔt)/ξ, backward Euler, tanh. The best k is common to every ξ, the "
        "error is not: it is in proportion to ξ. (Figure 3.5; the thesis has ξ = 0.05)"
    )
    return Picture("error-against-ratio", caption, figure, wide=True)


def _option_1(standard: Columns, option_1: Columns) -> Picture:
    lines = {"u, option 1": (option_1, "velocity"), "uⁿ, k = 0.75": (standard, "velocity")}
    caption = (
        "Option 1, the closed form for the force τ₀ dφ/dy, beside the smoothed profile method; "
        "ξ = 0.1. (Figure 3.6)"
    )
    title = "Velocity near the wall, option 1"
    return _near_wall("option-1-velocity", title, standard, lines, 3.8, caption)


def _against_thickness(curves: Columns) -> Picture:
    figure, axes = new_figure(height=3.9)
    thickness = curves["thickness"]
    for name, label in (
        ("l2_error_option_1", "L2, option 1"),
        ("l2_error_at_0.75", "L2, k = 0.75"),
        ("l2_error_at_best", "L2, k = 0.755222"),
        ("stress_error_at_0.75", "(τ − τ₀)/τ₀, k = 0.75"),
    ):
        style = "--" if name.startswith("stress") else "-"
        axes.loglog(thickness, curves[name], style, label=label)
    axes.set(title="Errors against the thickness", xlabel="ξ (–)", ylabel="error (–)")
    _powers(axes, "x", "y")
    legend_below(axes, 2)
    caption = (
        "Errors against ξ, tanh: option 1 and k = 0.755222 have order 3/2 exactly; k = 0.75 "
        "falls from 3/2 to 1 as the misplaced wall takes over. (Figure 3.7)"
    )
    return Picture("error-against-thickness", caption, figure)


def _option_2(softer: Columns, stiffer: Columns) -> Picture:
    figure, (left, right) = new_panels(2, **PANELS)
    left.plot(softer["y"], softer["exact_velocity"], **EXACT, label="sharp wall")
    for columns, label in ((softer, "ν₁/ν₀ = 100"), (stiffer, "ν₁/ν₀ = 1000")):
        left.plot(columns["y"], columns["velocity"], label=label)
        right.plot(columns["y"], columns["force_density"], label=label)
    left.set(
        title="Option 2: velocity", xlabel="y (–)", ylabel="u (–)", xlim=(2, 4), ylim=(0.65, 1.02)
    )
    right.set(title="Option 2: force density", xlabel="y (–)", ylabel="f = −ν₀u'' (–)", xlim=(2, 4))
    right.axvline(WALL, **LEVEL, label="wall, y = h")
    left.legend(loc="lower right")
    right.legend(loc="upper right")
    caption = (
        "Option 2, a wall of smoothed viscosity, ξ = 0.1: it acts ½ξ ln(ν₁/ν₀) in front of where "
        "it is painted. (Figure 3.8; the thesis has ν₁/ν₀ = 100)"
    )
    return Picture("option-2", caption, figure, wide=True)


def _option_2_errors(thickness: Columns, viscosity: Columns) -> Picture:
    figure, (left, right) = new_panels(2, **PANELS)
    for number, ratio in enumerate(("100", "1000")):
        style = {"color": PALETTE[number], "label": f"L2, ν₁/ν₀ = {ratio}"}
        left.plot(thickness["thickness"], thickness[f"l2_error_{ratio}"], **style)
        style["label"] = f"(τ − τ₀)/τ₀, ν₁/ν₀ = {ratio}"
        left.plot(thickness["thickness"], thickness[f"stress_error_{ratio}"], "--", **style)
    for number, name in enumerate(THICKNESSES):
        style = {"color": PALETTE[number + 2], "label": f"L2, ξ = {name}"}
        right.semilogx(viscosity["viscosity_ratio"], viscosity[f"l2_error_{name}"], **style)
        style["label"] = f"(τ − τ₀)/τ₀, ξ = {name}"
        right.semilogx(
            viscosity["viscosity_ratio"], viscosity[f"stress_error_{name}"], "--", **style
        )
    left.set(title="Option 2: errors against ξ", xlabel="ξ (–)", ylabel="error (–)")
    right.set(title="Option 2: errors against ν₁/ν₀", xlabel="ν₁/ν₀ (–)", ylabel="error (–)")
    _powers(right, "x")
    for axes in (left, right):
        axes.axhline(0, color="black", linewidth=0.8)
        axes.legend(loc="upper left")
    caption = (
        "Errors of option 2: that of the velocity is nearly linear in ξ and in ln(ν₁/ν₀), that of "
        "the stress while it is small; the wall's own shear is left at ξ = 0. (Figure 3.9, whose "
        "own caption says option 1)"
    )
    return Picture("option-2-errors", caption, figure, wide=True)


def _shift(curves: Columns) -> Picture:
    figure, (left, right) = new_panels(2, **PANELS)
    schemes = [f"tanh_{scheme}" for scheme in SCHEMES]
    profiles = [f"{profile}_backward-euler" for profile in PROFILES]
    for axes, names, labels in ((left, schemes, SCHEMES), (right, profiles, PROFILES)):
        for number, (name, label) in enumerate(zip(names, labels, strict=True)):
            colour = PALETTE[number]
            axes.semilogx(curves["ratio"], curves[f"flat_layer_{name}"], color=colour, label=label)
            solved = curves[f"solved_{name}"]
            axes.semilogx(curves["ratio"], solved, "o", color=colour, markersize=3)
        axes.plot([], [], "o", color="black", markersize=3, label="solved in the channel")
        axes.axhline(0, color="black", linewidth=0.8)
        axes.set(xlabel=RATIO, ylabel="s₀ (–)")
        axes.set_xticks([0.05, 0.1, 0.2, 0.5, 1, 2], ["0.05", "0.1", "0.2", "0.5", "1", "2"])
        axes.legend(loc="lower right" if axes is left else "upper left")
    left.set(title="Shift of the wall: schemes, tanh", ylim=(-3, 2))
    right.set(title="Shift of the wall: profiles, backward Euler")
    right.set(xlim=(0.045, 1.1), ylim=(-0.4, 0.6))
    caption = (
        "Where the wall acts: at h + ξs₀. Lines: closed form (tanh) and flat layer; points: "
        "s₀ = (Vν/τ − h)/ξ of the channel, ξ = 0.05. The best k is where s₀ = 0. (No figure in "
        "the thesis)"
    )
    return Picture("shift", caption, figure, wide=True)


def _powers(axes, *which: str) -> None:
    for name in which:
        getattr(axes, f"{name}axis").set_major_formatter(power_of_ten)
