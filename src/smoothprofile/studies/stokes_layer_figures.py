"""The figures of the Stokes layer study, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import LEVEL, PALETTE, Picture, drawing, new_figure, new_panels

Columns = Mapping[str, np.ndarray]

LABELS = {
    "backward-euler": "backward Euler",
    "crank-nicolson": "Crank–Nicolson",
    "bdf2": "BDF2",
    "bdf3": "BDF3",
}
WIDE = 9.0
K = "k = √(νΔt)/ξ (–)"
MARKED = {"marker": "o", "linestyle": "none", "markerfacecolor": "none"}


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """Every figure, in the order of the thesis."""
    with drawing():
        return [
            _sketch(curves["sketch"]),
            _velocity(curves["velocity"]),
            _stress(curves["wall-stress"]),
            _errors(curves["errors"], curves["errors-marched"]),
            _schemes(curves["errors-by-scheme"], curves["best-ratios"]),
            _limits(curves["limits"]),
        ]


def _sketch(columns: Columns) -> Picture:
    figure, axes = new_figure(height=3.6)
    y, velocities = columns["y"], [name for name in columns if name.startswith("u at")]
    axes.axhspan(0.0, 3.0, color="#e4e4e4", label="slab, 0 < y < h")
    for name, colour in zip(velocities, PALETTE, strict=False):
        axes.plot(columns[name], y, color=colour, label=name)
    axes.plot(columns["indicator at thickness 0.2"], y, "--", color="black", label="φ, ξ = 0.2")
    arrow = {"arrowstyle": "<->", "linewidth": 1.5, "color": "black"}
    axes.annotate("", xy=(-0.9, 1.5), xytext=(-0.1, 1.5), arrowprops=arrow)
    axes.text(-0.5, 1.65, "V = cos ωt", ha="center")
    axes.text(-0.5, 0.15, "no stress at y = 0", ha="center")
    axes.text(0.3, 5.45, "exact flow at y = 2h")
    axes.set(
        title="The oscillating wall",
        xlabel="u over the wall's largest velocity (–), φ (–)",
        ylabel="y (length), h = 3",
        ylim=(0.0, 6.0),
        xlim=(-1.15, 1.15),
    )
    figure.legend(loc="outside lower center", ncols=3)
    caption = (
        "The problem (thesis, figure 3.10): a slab that moves in its plane under a fluid, with the "
        "exact velocity at four times and a painted layer four times as thick as in the run."
    )
    return Picture("sketch", caption, figure)


def _velocity(columns: Columns) -> Picture:
    figure, (whole, near) = new_panels(2, 3.6, WIDE)
    y = columns["y"]
    close = np.abs(y - 3.0) < 0.35
    for axes, part in ((whole, np.full(y.size, True)), (near, close)):
        named = axes is whole
        for name, style, label in (
            ("exact", {"color": "black", "linewidth": 3.5, "alpha": 0.3}, "exact"),
            ("predicted", {"color": PALETTE[1], "linestyle": "--"}, "uˢ, before the impulse"),
            ("corrected", {"color": PALETTE[0]}, "uⁿ, after it"),
        ):
            axes.plot(y[part], columns[name][part], label=label if named else None, **style)
        axes.axvline(3.0, label="surface, y = h" if named else None, **LEVEL)
        axes.set(xlabel="y (length)", ylabel="u over the wall's largest velocity (–)")
    whole.set(title="Velocity at t = 3T/2")
    near.set(title="The same near the surface")
    figure.legend(loc="outside lower center", ncols=4)
    caption = (
        "Velocity across slab and fluid at t = 3T/2 (thesis, figure 3.11): Crank–Nicolson, "
        "ξ = .05, Δt = .0019."
    )
    return Picture("velocity", caption, figure, wide=True)


def _stress(columns: Columns) -> Picture:
    figure, (total, parts) = new_panels(2, 3.6, WIDE)
    turns = columns["time"] / (2.0 * np.pi)
    exact, ours, push, inertia = PALETTE[6], PALETTE[0], PALETTE[1], PALETTE[2]
    total.plot(turns, columns["exact"], color=exact, linewidth=3.5, alpha=0.3, label="exact, τ₀")
    total.plot(turns, columns["stress"], color=ours, label="τ = ∫f dy − inertia of the slab")
    total.set(title="Wall stress", ylabel="τ/(ρV₀√(ων)) (–)")
    parts.plot(turns, columns["push"], color=push, label="∫f dy")
    parts.plot(turns, columns["inertia"], "--", color=inertia, label="inertia of the slab")
    parts.plot(turns, columns["stress"], color=ours)
    parts.set(title="Impulse and inertia", ylabel="stress/(ρV₀√(ων)) (–)")
    for axes in (total, parts):
        axes.set(xlabel="t/T (–)", xlim=(0.5, 1.5))
    figure.legend(loc="outside lower center", ncols=4)
    caption = (
        "Stress of the wall on the fluid over [T/2, 3T/2] (thesis, figure 3.12): time marching, "
        "Crank–Nicolson, ξ = .05, Δt = .0019; V₀ is the wall's largest velocity. The integral of f "
        "alone is nearly all inertia."
    )
    return Picture("wall-stress", caption, figure, wide=True)


def _errors(columns: Columns, marched: Columns) -> Picture:
    figure, panels = new_panels(2, 3.7, WIDE)
    k, scales = columns["k"], (100.0, 1.0)
    late = columns["amplitude, h dV/dt at the end"]
    for axes, name, scale in zip(panels, ("amplitude", "phase"), scales, strict=True):
        first = name == "amplitude"
        axes.plot(k, scale * columns[name], color=PALETTE[0], label=_once("periodic state", first))
        label = _once("time marching, fitted over [T/2, 3T/2]", first)
        axes.plot(marched["k"], scale * marched[name], color=PALETTE[0], label=label, **MARKED)
        label = _once("flat wall displaced by s₀ξ, steady: −s₀ξ√(ω/2ν)", first)
        axes.plot(k, scale * columns["first order"], ":", color=PALETTE[2], label=label)
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set(xlabel=K)
    label = "inertia as h dV/dt at tₙ₊₁"
    panels[0].plot(k, 100.0 * late, "--", color=PALETTE[1], label=label)
    panels[0].axvline(0.85, label="thesis, about .85", **LEVEL)
    panels[0].set(title="Amplitude error, Crank–Nicolson", ylabel="error of the amplitude (%)")
    panels[1].set(title="Phase error, Crank–Nicolson", ylabel="lead over the exact stress (rad)")
    figure.legend(loc="outside lower center", ncols=2)
    caption = (
        "Errors of the wall stress against k (thesis, figure 3.13): Crank–Nicolson, tanh, ξ = .05."
    )
    return Picture("errors", caption, figure, wide=True)


def _schemes(columns: Columns, best: Columns) -> Picture:
    figure, panels = new_panels(2, 3.7, WIDE)
    tanh = best["profile"] == "tanh"
    flat = dict(zip(best["scheme"][tanh], best["flat wall"][tanh], strict=True))
    for axes, name, scale in zip(panels, ("amplitude", "phase"), (100.0, 1.0), strict=True):
        first = name == "amplitude"
        for colour, (scheme, label) in zip(PALETTE, LABELS.items(), strict=False):
            values = scale * columns[f"{name}, {scheme}"]
            axes.plot(columns["k"], values, color=colour, label=_once(label, first))
            axes.plot(flat[scheme], 0.0, "o", color=colour)
        axes.plot([], [], "o", color="#555555", label=_once("best k of a flat wall, steady", first))
        axes.axhline(0.0, color="black", linewidth=0.8)
        axes.set(xlabel=K)
    panels[0].set(title="Amplitude error, all schemes", ylabel="error of the amplitude (%)")
    panels[1].set(title="Phase error, all schemes", ylabel="lead over the exact stress (rad)")
    figure.legend(loc="outside lower center", ncols=5)
    caption = (
        "Errors of the wall stress against k for every scheme, tanh, ξ = .05. The dots are the k "
        "at which a flat wall in steady shear acts where it is painted."
    )
    return Picture("errors-by-scheme", caption, figure, wide=True)


def _limits(columns: Columns) -> Picture:
    figure, axes = new_figure(height=4.0)
    thickness = columns["thickness"]
    for colour, (scheme, label) in zip(PALETTE, LABELS.items(), strict=False):
        amplitude, phase = (np.abs(columns[f"{name}, {scheme}"]) for name in ("amplitude", "phase"))
        axes.loglog(thickness, amplitude, "o-", color=colour, label=label)
        axes.loglog(thickness, phase, "s--", color=colour)
    axes.plot([], [], "o-", color="#555555", label="amplitude")
    axes.plot([], [], "s--", color="#555555", label="phase")
    guide = {"color": "#888888", "linewidth": 1.0}
    axes.loglog(thickness, 0.07 * thickness**2, "-.", label="slope 2", **guide)
    axes.loglog(thickness, 3.0 * thickness, ":", label="slope 1", **guide)
    axes.set(
        title="The best k nears the flat wall's",
        xlabel="ξ over √(ν/ω) (–)",
        ylabel="|best k − best k of a flat wall| (–)",
    )
    axes.set_xticks(thickness, [f"{xi:g}" for xi in thickness])
    axes.set_xticks([], minor=True)
    figure.legend(loc="outside lower center", ncols=4)
    caption = (
        "How the k of no amplitude error (full lines) and of no phase error (dashed) near the best "
        "k of a flat wall in steady shear as the layer gets thinner; tanh, fluid 15√(ν/ω) deep."
    )
    return Picture("limits", caption, figure)


def _once(label: str, named: bool) -> str | None:
    """The label in the first panel, none in the second: one legend serves both."""
    return label if named else None
