"""Planar Couette flow with a painted wall: the best time step, and what is wrong without it."""

import math

from smoothprofile.calibration import best_ratio, interface_shift
from smoothprofile.figures import power_of_ten
from smoothprofile.profiles import PROFILES
from smoothprofile.schemes import SCHEMES
from smoothprofile.studies.couette_curves import (
    CHANNEL,
    EULER,
    NICOLSON,
    SHOWN,
    THESIS_RATIO,
    all_curves,
    best_stress_ratio,
    best_velocity_ratio,
    flow_at,
    smoothed_viscosity_at,
    solved_shift,
)
from smoothprofile.studies.couette_figures import pictures
from smoothprofile.studies.study import Row, Study
from smoothprofile.theory import couette

VISCOSITY_RATIOS = (1e2, 1e3, 1e4, 1e6)

INTRODUCTION = (
    "Fluid between a plate at rest, y = 0, and a wall of speed V = 1 that fills h ≤ y ≤ 2h, h = 3, "
    "ν = 1. The wall is a smoothed profile: at steady state ν[θu* + (1−θ)uⁿ]'' = −f with the "
    "force f = γφ(V − u*)/Δt and uⁿ = u* + φ(V − u*), where γ and θ belong to the time scheme. "
    "With lengths in ξ everything depends on k = √(νΔt)/ξ, up to the depth of the channel. The "
    "boundary value problems are solved by collocation to a relative 1e-12. The wall stress is "
    "τ = ∫f dy; the sharp wall's is τ₀ = νV/h = 1/3. L2 error: √∫(uⁿ − u)²dy over 0 ≤ y ≤ 2h."
)

FINDINGS = (
    "The painted wall acts at h + ξs₀(k), and its stress is τ = Vν/(h + ξs₀). Both best k of the "
    "thesis, 0.75 and 0.81, are zeros of s₀: they depend on the profile and the scheme, and on "
    "nothing else.",
    "A wall painted at h − ξs₀ has the exact stress at any Δt whose √(νΔt) is small beside h.",
    "That the error is a function of k alone holds at one ξ only: the stress error is in "
    "proportion to ξ. At s₀ = 0 the L2 error is of order ξ^{3/2}, the rounded corner; anywhere "
    "else it tends to order 1.",
    "The force is centred where the wall acts, ⟨y⟩ = h + ξs₀, and its spread and skewness have "
    "closed forms too: σ = ξ√(π²/12 + k²). The thesis' ⟨y³⟩ − ⟨y⟩³ is not a skewness; the "
    "skewness is 0.246.",
    "With backward Euler and for the same width σ of the force, tanh leaves the least L2 error of "
    "the four profiles.",
    "Option 1 has the exact stress, but 1.95 times the L2 error of the method at its best k.",
    "Option 2 acts ½ξ ln(ν₁/ν₀) in front of its wall. Painted as much deeper, only the shear of "
    "the wall itself is left, −1/(1 + ν₁/ν₀): then the stiffer the better.",
)


def run() -> Study:
    """The thesis' section 3.1, solved to round-off."""
    curves = all_curves()
    rows = [
        *_best_ratio_rows(),
        *_velocity_rows(),
        *_force_rows(),
        *_shift_rows(),
        *_option_rows(),
        *_order_rows(),
    ]
    return Study(
        title="Planar Couette flow with a painted wall",
        source="thesis, section 3.1",
        introduction=INTRODUCTION,
        findings=FINDINGS,
        rows=rows,
        curves=curves,
        pictures=pictures(curves),
    )


def _best_ratio_rows() -> list[Row]:
    confirmed = dict(zip(SCHEMES, (0.755222, 0.806794, 0.924955, 1.022576), strict=True))
    thesis = {EULER: 0.75, NICOLSON: 0.81}
    rows = []
    for profile in PROFILES:
        for scheme in SCHEMES:
            tanh = profile == "tanh"
            quantity = f"best k of the wall stress, {profile}, {scheme}"
            printed = thesis.get(scheme) if tanh else None
            exact = confirmed[scheme] if tanh else best_ratio(profile, scheme)
            if printed:
                remark = "The thesis found it by trial; it is where s₀(k) = 0, for any ξ."
            elif tanh:
                remark = "Backward Euler's times √γ, γ = 3/2 or 11/6."
            else:
                remark = "Exact: the zero of s₀(k) of a flat layer; ours: the whole channel's."
            ours = best_stress_ratio(0.05, profile, scheme)
            rows.append(Row(quantity, printed, exact, ours, 5e-7, remark))
    return rows


def _velocity_rows() -> list[Row]:
    rows = []
    for thickness, exact in ((0.2, 0.7526), (0.1, 0.7541), (0.05, 0.7547)):
        rows.append(
            Row(
                f"best k of the L2 error of uⁿ, ξ = {thickness:g}",
                THESIS_RATIO,
                exact,
                best_velocity_ratio(thickness),
                5e-5,
                "Depends on ξ, unlike the stress's: it tends to 0.755222 as ξ → 0.",
            )
        )
    least = flow_at(best_velocity_ratio(0.05), 0.05).error
    at_thesis = flow_at(THESIS_RATIO, 0.05)
    return [
        *rows,
        Row("least L2 error of uⁿ, ξ = 0.05", "figure 3.5a", 5.241e-4, least, 5e-8),
        Row("L2 error of uⁿ, k = 0.75, ξ = 0.05", "figure 3.5a", 5.402e-4, at_thesis.error, 5e-8),
        Row(
            "(τ − τ₀)/τ₀, k = 0.75, ξ = 0.05",
            "about 0",
            1.497e-4,
            at_thesis.stress_error,
            5e-8,
            "h/(h + ξs₀) − 1, s₀(0.75) = −0.00898.",
        ),
        Row(
            "(τ − τ₀)/τ₀, k = 0.75, ξ = 0.1",
            "about 0",
            2.995e-4,
            flow_at(THESIS_RATIO, 0.1).stress_error,
            5e-8,
            "Twice that at half the ξ: the error is a function of k at one ξ only.",
        ),
    ]


def _force_rows() -> list[Row]:
    moments = flow_at(THESIS_RATIO, SHOWN).moments
    closed = couette.tanh_moments(CHANNEL, SHOWN, THESIS_RATIO)
    return [
        Row("⟨y⟩ of f, ξ = 0.1, Δt = 0.005625", 2.9991, 2.99910, moments.mean, 5e-6),
        Row("σ of f", 0.1177, 0.117685, moments.deviation, 5e-7),
        Row(
            "⟨y³⟩ − ⟨y⟩³ of f",
            0.1251,
            0.12501,
            moments.cubes,
            5e-6,
            "Not a skewness, though the thesis takes it for one: it is 3⟨y⟩σ² + m₃, positive for "
            "every f on positive y, and 0.12461 of it is 3⟨y⟩σ². The thesis' last digit is one "
            "off.",
        ),
        Row("m₃ of f", None, 4.0e-4, moments.third, 5e-6, "The third central moment."),
        Row("skewness m₃/σ³ of f", None, 0.246, moments.skewness, 5e-4),
        Row(
            "⟨y⟩, solved and h + ξs₀",
            None,
            closed.mean,
            moments.mean,
            1e-10,
            "The force is centred where the wall acts.",
        ),
        Row("σ, solved and ξ√(π²/12 + k²)", None, closed.deviation, moments.deviation, 1e-10),
        Row(
            "skewness, solved and −(ζ(3)/2 + ψ₂(1/2k)/4 + 2k³)/(π²/12 + k²)^{3/2}",
            None,
            closed.skewness,
            moments.skewness,
            1e-8,
            "A function of k alone.",
        ),
    ]


def _shift_rows() -> list[Row]:
    rows = []
    for scheme in (EULER, NICOLSON):
        for ratio in (0.3, 0.75, 1.2):
            rows.append(
                Row(
                    f"s₀, solved and closed form, tanh, {scheme}, k = {ratio:g}",
                    None,
                    interface_shift("tanh", ratio, scheme),
                    solved_shift(flow_at(ratio, 0.05, scheme=scheme), 0.05),
                    1e-8,
                )
            )
    for profile, ratio in (("tanh", 0.377), ("tanh", 1.118), ("quartic", 0.5), ("sine", 0.5)):
        position = CHANNEL.height - SHOWN * interface_shift(profile, ratio)
        as_painted = flow_at(ratio, SHOWN, profile).stress_error
        rows.append(
            Row(
                f"(τ − τ₀)/τ₀ with the wall painted at h − ξs₀, {profile}, k = {ratio:g}, ξ = 0.1",
                None,
                0.0,
                flow_at(ratio, SHOWN, profile, position=position).stress_error,
                1e-9,
                f"{100.0 * as_painted:+.3f} % when painted at h; any Δt will do.".replace("-", "−"),
            )
        )
    return rows


def _option_rows() -> list[Row]:
    smoothed = couette.smoothed_force(CHANNEL, SHOWN)
    rows = [
        Row(
            "option 1: L2 error of u over ξ^{3/2}, ξ = 0.1",
            "figure 3.7",
            0.091365,
            smoothed.error / SHOWN**1.5,
            5e-7,
            "√ζ(3)V/(4h) exactly; the wall stress is exact by construction.",
        )
    ]
    confirmed = (0.35688, 0.37623, 0.39373, 0.43305)
    apart = []
    for ratio, exact in zip(VISCOSITY_RATIOS, confirmed, strict=True):
        stress = smoothed_viscosity_at(SHOWN, ratio).stress
        closed = couette.smoothed_viscosity_stress(CHANNEL, SHOWN, ratio)
        apart.append(abs(stress - closed))
        rows.append(
            Row(
                f"option 2: τ, ξ = 0.1, ν₁/ν₀ = {power_of_ten(ratio, 0)}",
                "0.35 to 0.45",
                exact,
                stress,
                5e-6,
                f"Closed form {closed:.8f}; the sharp wall's is 1/3.",
            )
        )
    for ratio in VISCOSITY_RATIOS:
        position = CHANNEL.height + 0.5 * SHOWN * math.log(ratio)
        rows.append(
            Row(
                "option 2: (τ − τ₀)/τ₀ with the wall painted at h + ½ξ ln(ν₁/ν₀), "
                f"ν₁/ν₀ = {power_of_ten(ratio, 0)}",
                None,
                -1.0 / (1.0 + ratio),
                smoothed_viscosity_at(SHOWN, ratio, position).stress_error,
                1e-9,
                "What is left is the wall's own shear, −1/(1 + ν₁/ν₀).",
            )
        )
    return [
        *rows,
        Row(
            "option 2: largest difference between solved and closed form",
            None,
            0.0,
            max(apart),
            1e-10,
            "Vν₀/[2h/R + (1 − 1/R)(h − ½ξ ln R)], R = ν₁/ν₀.",
        ),
    ]


def _order_rows() -> list[Row]:
    best = best_ratio("tanh", EULER)

    def order(measure) -> float:
        return math.log2(measure(0.05) / measure(0.025))

    rows = [
        Row(
            "order in ξ of the L2 error at k = 0.75, ξ = 0.05 and 0.025",
            "figure 3.7",
            None,
            order(lambda xi: flow_at(THESIS_RATIO, xi).error),
            0.0,
            "Between 3/2 (the rounded corner) and 1 (a wall that acts elsewhere).",
        ),
        Row(
            "order in ξ of the L2 error at s₀ = 0",
            None,
            1.5,
            order(lambda xi: flow_at(best, xi).error),
            1e-6,
            "Only the corner is left, at every ξ.",
        ),
        Row(
            "order in ξ of the L2 error, option 1",
            "figure 3.7",
            1.5,
            order(lambda xi: couette.smoothed_force(CHANNEL, xi).error),
            1e-6,
        ),
    ]
    for profile in PROFILES:
        flow = flow_at(best_ratio(profile, EULER), SHOWN, profile)
        rows.append(
            Row(
                f"L2 error of uⁿ over σ^{{3/2}} at s₀ = 0, {profile}",
                None,
                None,
                flow.error / flow.moments.deviation**1.5,
                0.0,
                f"For the same width of the force; σ = {flow.moments.deviation / SHOWN:.4g}ξ.",
            )
        )
    return rows
