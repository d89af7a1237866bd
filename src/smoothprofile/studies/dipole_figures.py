"""The figures of the dipole study, drawn from its curves alone."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.figures import (
    EXACT,
    GUIDE,
    LEVEL,
    PALETTE,
    Picture,
    drawing,
    legend_below,
    new_figure,
    new_panels,
)

Columns = Mapping[str, np.ndarray]

WIDE = {"height": 3.7, "width": 9.4}
RATIO, THICKNESS = "R = ε₁/ε₂ (–)", "ξ/a (–)"
ERROR, RADIUS = "error of B, (B − B₀)/B₀ (%)", "a_eff/a (–)"
RATIOS, THICKNESSES, RETRACTED = ("0.1", "2", "10", "100"), ("0.05", "0.1", "0.2"), (2, 20, 40)
SMOOTHINGS = {"arithmetic": "ε (arithmetic)", "harmonic": "1/ε (harmonic)", "tensor": "tensor"}
PROFILES = {
    "tanh": ("tanh", "-"),
    "quartic": ("quartic, printed", "--"),
    "quartic-centred": ("quartic, centred", "-."),
    "sine": ("sine", ":"),
}


def pictures(curves: Mapping[str, Columns]) -> list[Picture]:
    """Every figure, in the order of the thesis; those it does not have come last."""
    with drawing():
        return [
            _field(curves["field"]),
            _against_thickness("tanh", curves["tanh_against_thickness"], "4.3"),
            _against_ratio("tanh", curves["tanh_against_ratio"], "4.4"),
            _collapse("tanh", curves["tanh_against_ratio"], "4.5"),
            _indicators(curves["indicators"]),
            _against_thickness("quartic", curves["quartic_against_thickness"], "4.7, against ξ"),
            _against_ratio("quartic", curves["quartic_against_ratio"], "4.7, against ε₁"),
            _collapse("quartic", curves["quartic_against_ratio"], "4.8"),
            _permittivity(curves["permittivity"]),
            _smoothings("tanh", curves["smoothings_against_ratio"], "Thesis, figure 4.10"),
            _retraction(curves["retraction"]),
            _smoothings("sine", curves["smoothings_against_ratio"], "Not in the thesis"),
            _tensor(curves["tensor_against_thickness"]),
        ]


def _field(columns: Columns) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    names = {"potential": "F, aimed at E∞ = 1 (–)", "displacement": "D = εF′, aimed at E∞ = 1 (–)"}
    for axes, (name, label) in zip(panels, names.items(), strict=True):
        axes.plot(columns["r"], columns[name], label="smoothed, ξ = 0.1a")
        axes.plot(columns["r"], columns[f"exact_{name}"], **EXACT, label="sharp sphere")
        axes.axvline(1.0, **GUIDE, label="painted surface")
        axes.set(title=f"{name.capitalize()}, R = 10", xlabel="r/a (–)", ylabel=label)
    legend_below(panels[0], 3)
    return Picture(
        "field",
        "Potential and displacement of the dipole along the radius, tanh, ε interpolated, started "
        "from the sharp sphere's field at r = a/2. Thesis, figure 4.2.",
        *(figure, True),
    )


def _against_thickness(profile: str, columns: Columns, number: str) -> Picture:
    cases = {f"R{ratio}": f"R = {ratio}" for ratio in RATIOS}
    style = {"xlabel": THICKNESS, "xlim": (0, None)}
    caption = (
        f"Error of the dipole's B and effective radius against the thickness of the interface, "
        f"{profile}: first order for every R. Thesis, figure {number}."
    )
    return _error_and_radius(profile, "thickness", columns, cases, style, caption)


def _against_ratio(profile: str, columns: Columns, number: str) -> Picture:
    cases = {thickness: f"ξ = {thickness}a" for thickness in THICKNESSES}
    style = {"xlabel": RATIO, "xscale": "log"}
    caption = (
        f"Error of the dipole's B and effective radius against the ratio of permittivities, "
        f"{profile}. Thesis, figure {number}."
    )
    return _error_and_radius(profile, "ratio", columns, cases, style, caption)


def _error_and_radius(
    profile: str,
    against: str,
    columns: Columns,
    cases: Mapping[str, str],
    style: Mapping,
    caption: str,
) -> Picture:
    """Error of B, and a_eff, against a column; cases: ends of the columns' names -> labels."""
    figure, panels = new_panels(2, **WIDE)
    for axes, name, label, factor, exact in zip(
        *(panels, ("error", "radius"), (ERROR, RADIUS), (100.0, 1.0), (0.0, 1.0)), strict=True
    ):
        for colour, (case, shown) in zip(PALETTE, cases.items(), strict=False):
            values = factor * columns[f"{name}_{case}"]
            axes.plot(columns[against], values, color=colour, label=shown)
        axes.axhline(exact, **EXACT, label="exact")
        axes.set(title=f"{profile}, ε interpolated", ylabel=label, **style)
    legend_below(panels[0], len(cases) + 1)
    return Picture(f"{profile}-against-{against}", caption, figure, wide=True)


def _collapse(profile: str, columns: Columns, number: str) -> Picture:
    figure, axes = new_figure(height=3.7)
    for colour, thickness in zip(PALETTE, THICKNESSES, strict=False):
        scaled = columns[f"scaled_{thickness}"]
        axes.plot(columns["ratio"], scaled, color=colour, label=f"ξ = {thickness}a")
    axes.plot(columns["ratio"], columns["scaled_limit"], **LEVEL, label="ξ → 0")
    axes.set(title=f"Similarity, {profile}", xlabel=RATIO, xscale="log")
    axes.set_ylabel("(a_eff − a)/ξ (–)")
    axes.legend()
    law = "R ln R/(2(R+2))" if profile == "tanh" else "R s_n/(R+2) + 2 s_t/(R+2)"
    return Picture(
        f"{profile}-similarity",
        f"(a_eff − a)/ξ against the ratio of permittivities, {profile}: nearly one curve, the "
        f"closed form {law} at ξ → 0. Thesis, figure {number}.",
        figure,
    )


def _indicators(columns: Columns) -> Picture:
    figure, axes = new_figure(height=3.7)
    for name, (label, dash) in PROFILES.items():
        axes.plot(columns["z"], columns[name], linestyle=dash, label=label)
    axes.set(title="Indicators", xlabel="(r − a)/ξ (–)", ylabel="φ (–)")
    axes.legend()
    return Picture(
        "indicators",
        "The indicators φ across the interface; the quartic is the thesis' polynomial. "
        "Thesis, figure 4.6.",
        figure,
    )


def _permittivity(columns: Columns) -> Picture:
    figure, axes = new_figure(height=3.7)
    for name in ("arithmetic", "harmonic"):
        axes.plot(columns["r"], columns[name], label=f"interpolating {SMOOTHINGS[name]}")
    axes.axvline(1.0, **GUIDE, label="painted surface")
    axes.set(title="Permittivity, R = 100, ξ = 0.1a", xlabel="r/a (–)", ylabel="ε/ε₂ (–)")
    axes.legend()
    return Picture(
        "permittivity",
        "Permittivity along the radius, tanh: interpolating 1/ε moves its mean into the sphere. "
        "Thesis, figure 4.9.",
        figure,
    )


def _smoothings(profile: str, columns: Columns, origin: str) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    for axes, thickness in zip(panels, ("0.1", "0.2"), strict=True):
        for name, label in SMOOTHINGS.items():
            error = 100 * columns[f"{profile}_{name}_{thickness}"]
            axes.plot(columns["ratio"], error, label=label)
        axes.axhline(0.0, **EXACT, label="exact")
        axes.set(title=f"{profile}, ξ = {thickness}a", xlabel=RATIO, ylabel=ERROR, xscale="log")
    legend_below(panels[0], 4)
    return Picture(
        f"{profile}-smoothings",
        f"Error of the dipole's B against the ratio of permittivities, {profile}, for three ways "
        f"to smooth the permittivity. {origin}"
        + (" (without the tensor)." if profile == "tanh" else "."),
        *(figure, True),
    )


def _retraction(columns: Columns) -> Picture:
    figure, panels = new_panels(2, **WIDE)
    thickness = columns["thickness"]
    for axes, name in zip(panels, ("dipole", "quadrupole"), strict=True):
        for colour, ratio in zip(PALETTE, RETRACTED, strict=False):
            style = {"color": colour, "marker": "o", "markersize": 3}
            plain, cured = f"{name}_R{ratio}", f"{name}_R{ratio}_retracted"
            axes.loglog(thickness, np.abs(columns[plain]), **style, label=f"R = {ratio}")
            dashed = {**style, "linestyle": "--", "label": f"R = {ratio}, retracted"}
            axes.loglog(thickness, np.abs(columns[cured]), **dashed)
        axes.loglog(thickness, 5 * thickness, **GUIDE, label="orders 1 and 2")
        axes.loglog(thickness, 0.005 * thickness**2, **GUIDE)
        axes.set(title=f"{name.capitalize()}, quartic", xlabel=THICKNESS)
        axes.set_ylabel("|error of B| (–)")
    legend_below(panels[0], 4)
    return Picture(
        "retraction",
        "Error of B of dipole and quadrupole with the sphere painted at its radius, and at "
        "a²/a_eff: from first order to second. Thesis, figure 4.13 (dipole).",
        *(figure, True),
    )


def _tensor(columns: Columns) -> Picture:
    figure, panels = new_panels(3, height=3.7, width=9.4)
    thickness = columns["thickness"]
    for axes, name in zip(panels, ("dipole", "quadrupole", "octupole"), strict=True):
        for profile, (label, dash) in PROFILES.items():
            error = np.abs(columns[f"{name}_{profile}"])
            axes.loglog(thickness, error, linestyle=dash, label=label)
        axes.loglog(thickness, 5 * thickness, **GUIDE, label="orders 1 and 2")
        axes.loglog(thickness, 0.03 * thickness**2, **GUIDE)
        axes.set(title=f"{name.capitalize()}, tensor, R = 10", xlabel=THICKNESS)
        axes.set_ylabel("|error of B| (–)")
    legend_below(panels[0], 5)
    return Picture(
        "tensor",
        "Error of B with tensor smoothing: second order for every profile but the quartic as "
        "printed, which is not centred. Not in the thesis.",
        *(figure, True),
    )
