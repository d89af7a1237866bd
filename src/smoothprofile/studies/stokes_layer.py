"""The oscillating flat wall: errors of the wall stress in amplitude and phase (thesis 3.2)."""

import numpy as np

from smoothprofile.calibration import best_ratio
from smoothprofile.profiles import PROFILES
from smoothprofile.schemes import SCHEMES
from smoothprofile.studies import stokes_layer_curves as layer
from smoothprofile.studies.stokes_layer_curves import ERRORS, SCHEME, THESIS_RATIO
from smoothprofile.studies.stokes_layer_figures import pictures
from smoothprofile.studies.study import Row, Study
from smoothprofile.theory.stokes_layer import fourier_coefficients, relative_errors

# Deep enough for the far boundary not to be felt: e^{−2·15/√2} = 6e-10.
DEEP = 15.0
HALVINGS = (0.1, 0.05, 0.025, 0.0125)
# Orders of what is left of the best k − its limit in a deep fluid, halving by halving.
ORDERS = {"amplitude": (2, 3, 4), "phase": (1, 2, 3)}

INTRODUCTION = (
    "A slab 0 < y < h moves as cos ωt under a fluid, h = 3, ω = ν = 1. The exact flow is "
    "u = Re exp(Y + i(Y + ωt)), Y = √(ω/2ν)(h − y), and the wall pushes the fluid with "
    "τ₀ = −sin(ωt − π/4). The steps are (γuˢ − Σα_q uⁿ⁻q)/Δt = ν∂²[θuˢ + (1−θ)uⁿ]/∂y², "
    "uⁿ⁺¹ = uˢ + φ(V − uˢ), and τ = ∫γφ(V − uˢ)/Δt dy − h(γVⁿ⁺¹ − Σα_q Vⁿ⁻q)/Δt: the impulse less "
    "what the slab itself needs to speed up. The floor y = 0 is free of stress, and the far "
    "boundary y = 2h moves as the exact solution. The periodic state is solved for in the "
    "frequency domain with Δt as given; time marching has a whole number of steps to the period "
    "(3306, Δt = .0019005, for the thesis' .0019). k = √(νΔt)/ξ; ξ = .05 and a tanh layer where "
    "nothing else is said. A positive phase leads τ₀."
)


def run() -> Study:
    """The study: CSV curves, a table, findings and figures."""
    best = {
        name: {(p, s): layer.best_k(name, s, p) for p in PROFILES for s in SCHEMES}
        for name in ERRORS
    }
    limits = {
        name: {s: [layer.best_k(name, s, "tanh", xi, DEEP) for xi in HALVINGS] for s in SCHEMES}
        for name in ERRORS
    }
    marches = {s: layer.Marched.of(THESIS_RATIO, s, 2.5) for s in SCHEMES}
    curves = {
        "sketch": layer.sketch_curves(),
        "velocity": layer.velocity_curves(),
        "wall-stress": layer.stress_curves(marches[SCHEME]),
        "errors": layer.error_curves(),
        "errors-marched": layer.marched_curves(),
        "errors-by-scheme": layer.scheme_curves(),
        "best-ratios": _best_columns(best),
        "limits": _limit_columns(limits),
    }
    rows = (
        *_thesis_rows(best),
        *_march_rows(marches),
        *_other_rows(best),
        *_limit_rows(limits),
    )
    return Study(
        "Oscillating Stokes layer",
        "X. Liu, Smoothed Profile Method, Brown University, 2017, section 3.2 and appendix A",
        INTRODUCTION,
        _findings(best),
        rows,
        curves,
        pictures(curves),
    )


def extrapolated(values: list[float], orders: tuple[int, ...]) -> float:
    """The limit of values at ξ, ξ/2, ξ/4, …, whose differences from it start with these orders."""
    values = np.array(values)
    for order in orders:
        values = (2**order * values[1:] - values[:-1]) / (2**order - 1)
    return float(values[0])


def _best_columns(best: dict) -> dict[str, np.ndarray]:
    keys = list(best["amplitude"])
    return {
        "profile": np.array([p for p, _ in keys]),
        "scheme": np.array([s for _, s in keys]),
        "flat wall": np.array([best_ratio(*key) for key in keys]),
        **{name: np.array([best[name][key] for key in keys]) for name in ERRORS},
    }


def _limit_columns(limits: dict) -> dict[str, np.ndarray]:
    columns = {"thickness": np.array(HALVINGS)}
    for name in ERRORS:
        for scheme, values in limits[name].items():
            columns[f"{name}, {scheme}"] = np.array(values) - best_ratio("tanh", scheme)
    return columns


def _thesis_rows(best: dict) -> list[Row]:
    errors = layer.stress_errors(THESIS_RATIO)
    late, thesis_floor = (
        layer.root_near(lambda k, floor=floor: layer.end_rate_amplitude(k, floor), 0.8)
        for floor in ("free", "driven")
    )
    driven = layer.periodic(THESIS_RATIO, floor="driven")[1]
    free = layer.periodic(THESIS_RATIO)[1]
    pair = ("tanh", SCHEME)
    return [
        Row(
            "k of no amplitude error, crank-nicolson",
            *(0.85, 0.807, best["amplitude"][pair], 5e-4),
            "The thesis' value fits another inertia of the slab: next row.",
        ),
        Row(
            "the same, with the inertia h dV/dt at tₙ₊₁",
            *(0.85, 0.846, late, 5e-4),
            "Likely the thesis' reading. It is off by hω²Δt/2, for what ∫f dy contains is the "
            "step's own difference h(Vⁿ⁺¹ − Vⁿ)/Δt.",
        ),
        Row(
            "the same, and u = V at y = 0",
            *(0.85, None, thesis_floor, 5e-7),
            "The thesis' floor as printed: its Stokes layer moves the zero far from .85.",
        ),
        Row(
            "k of no phase error, crank-nicolson",
            *("smaller than .85", 0.756, best["phase"][pair], 5e-4),
        ),
        Row(
            "amplitude error at Δt = .0019, %",
            *("figure", -0.314, 100.0 * errors["amplitude"], 5e-4),
        ),
        Row("phase error at Δt = .0019, rad", "figure", -0.00628, errors["phase"], 5e-6),
        Row(
            "amplitude of ∫f dy alone, u = V at y = 0",
            *(None, 3.74, abs(driven.push), 5e-3),
            "The thesis' floor and its integral. It contains the inertia of the slab, hω = 3; a "
            "layer √(νΔt) thick at y = 0 is missing from it.",
        ),
        Row(
            "the same, floor free of stress",
            *(None, None, abs(free.push), 5e-3),
            "|e^{iπ/4} + 3i| = 3.774 for a sharp wall.",
        ),
        Row(
            "phase error at the k of no amplitude error, rad",
            *(None, None, layer.stress_errors(best["amplitude"][pair])["phase"], 5e-7),
            "What is left once the amplitude is right: of order ωξ²/ν.",
        ),
    ]


def _march_rows(marches: dict) -> list[Row]:
    run = marches[SCHEME]
    solved = relative_errors(run.wall, run.solved)
    fitted = relative_errors(run.wall, run.fitted(1.5))
    steps = run.period(1.5)
    a, b = fourier_coefficients(
        run.found.times[steps], run.found.stress[steps], run.wall.angular_frequency, 6
    )
    others = np.abs(np.concatenate(([0.5 * a[0]], a[2:], b[2:]))).max()
    start = "Exact: the frequency domain at the same Δt. The start still counts 2e-5 here."
    rows = [
        Row(
            "appendix A's fit over [T/2, 3T/2]: amplitude error, %",
            *("figure", 100.0 * solved[0], 100.0 * fitted[0], 5e-3),
            start,
        ),
        Row(
            "appendix A's fit over [T/2, 3T/2]: phase error, rad",
            *("figure", solved[1], fitted[1], 5e-5),
            start,
        ),
        Row(
            "largest other Fourier coefficient, n ≤ 6, [T/2, 3T/2]",
            *(0.0, 0.0, float(others), 5e-5),
            "Zero but for what is left of the start.",
        ),
    ]
    for scheme, run in marches.items():
        apart = abs(run.fitted(2.5) / run.solved - 1.0)
        rows.append(
            Row(
                f"marched stress against the frequency domain, {scheme}",
                *(None, 0.0, float(apart), 1e-7),
                "Over [3T/2, 5T/2], relative. The start dies as e^{−ν(π/h)²t}: 1e-3 e^{−10}.",
            )
        )
    return rows


def _other_rows(best: dict) -> list[Row]:
    pairs = [("tanh", s) for s in SCHEMES if s != SCHEME]
    pairs += [(p, SCHEME) for p in PROFILES if p != "tanh"]
    return [
        Row(
            f"k of no {name} error, {profile}, {scheme}",
            *(None, None, best[name][profile, scheme], 5e-7),
            f"Flat wall at steady state: {best_ratio(profile, scheme):.6f}.",
        )
        for profile, scheme in pairs
        for name in ERRORS
    ]


def _limit_rows(limits: dict) -> list[Row]:
    rows = []
    for name, tolerance in (("amplitude", 5e-7), ("phase", 5e-5)):
        for scheme, values in limits[name].items():
            rows.append(
                Row(
                    f"k of no {name} error as ξ → 0, {scheme}",
                    *(None, best_ratio("tanh", scheme)),
                    *(extrapolated(values, ORDERS[name]), tolerance),
                    f"Exact: best k of the flat wall. Extrapolated from ξ = {HALVINGS[0]} to "
                    f"{HALVINGS[-1]} under fluid {DEEP:g} deep.",
                )
            )
    for name, order in (("amplitude", 2.0), ("phase", 1.0)):
        off = np.abs(np.array(limits[name][SCHEME]) - best_ratio("tanh", SCHEME))
        rows.append(
            Row(
                f"order in ξ of its approach, {name}, crank-nicolson",
                *(None, order, float(np.log2(off[-2] / off[-1])), 0.05),
                "By the last halving.",
            )
        )
    return rows


def _findings(best: dict) -> list[str]:
    pair = ("tanh", SCHEME)
    amplitude, phase = best["amplitude"][pair], best["phase"][pair]
    return [
        f"The amplitude is exact at k = {amplitude:.4f}, a hair from the best k of the flat wall "
        f"at steady state, {best_ratio(*pair):.4f}; the phase at k = {phase:.4f}.",
        "A wall that stands s = s₀ξ too deep makes the stress e^{iπ/4}(1 − s√(iω/ν)): both errors "
        "are −s√(ω/2ν). The next term has (√(iω/ν)ξ)² = iωξ²/ν in it and turns the phase alone. So "
        "the best k of the amplitude nears the flat wall's with ξ², that of the phase with ξ; a "
        "far boundary 3 away adds to the first a hundredth or two of the second's term in ξ.",
        "The thesis integrates f and does not say how the inertia of the slab was taken out. Its "
        ".85 is what h dV/dt at tₙ₊₁ gives; with the step's own difference of V, which is what "
        "the impulse contains, it is .807.",
        "With u = e^{iωt} at y = 0, as the thesis has it, the slab has a Stokes layer of its own "
        "there, for the predicted velocity lags: it takes 2 % off the stress at Δt = .0019.",
        "In appendix A as printed θ = arctan(b₁/a₁) is −π/4 for the exact stress: the phase shift "
        "is −arctan(b₁/a₁) − π/4. With it the projection is the amplitude √(a₁² + b₁²).",
        "The inertia is that of the true slab, h. A quartic as printed paints h + ξ/30; with that "
        "its best k would not tend to the flat wall's.",
    ]
