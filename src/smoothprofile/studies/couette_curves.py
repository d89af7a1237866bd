"""The flows of the Couette study, and the data of its figures."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from smoothprofile.calibration import best_ratio, best_time_step, interface_shift
from smoothprofile.profiles import PROFILES, profile_named
from smoothprofile.schemes import SCHEMES, scheme_named
from smoothprofile.theory import couette
from smoothprofile.theory.couette import Channel, Flow, Wall

Curves = dict[str, dict[str, np.ndarray]]

CHANNEL = Channel(height=3.0, speed=1.0, viscosity=1.0)
EULER, NICOLSON = "backward-euler", "crank-nicolson"
THESIS_RATIO = 0.75
# The thesis shows its profiles at this thickness, and at k = 0.75: Δt = 0.005625.
SHOWN = 0.1
THICKNESSES = (0.2, 0.1, 0.05)
VISCOSITIES = (0.5, 1.0, 2.0)
SHOWN_VISCOSITY_RATIOS = (1e2, 1e3)


def wall_of(profile: str, thickness: float, position: float = CHANNEL.height) -> Wall:
    """The upper wall, painted with a profile at y = position."""
    known = profile_named(profile)
    return Wall(known.value, thickness, position, known.core, known.edge)


def flow_at(
    ratio: float,
    thickness: float,
    profile: str = "tanh",
    scheme: str = EULER,
    position: float = CHANNEL.height,
) -> Flow:
    """The steady flow at k = √(νΔt)/ξ. ratio: k; thickness: ξ; position: where it is painted."""
    known, wall = scheme_named(scheme), wall_of(profile, thickness, position)
    time_step = (ratio * thickness) ** 2 / CHANNEL.viscosity
    return couette.penalised(CHANNEL, wall, time_step, known.gamma, known.implicit)


def smoothed_viscosity_at(
    thickness: float, viscosity_ratio: float, position: float = CHANNEL.height
) -> Flow:
    """Option 2 with a tanh wall. thickness: ξ; viscosity_ratio: ν₁/ν₀; position: as `flow_at`."""
    slope = profile_named("tanh").slope
    wall = wall_of("tanh", thickness, position)
    return couette.smoothed_viscosity(CHANNEL, wall, slope, viscosity_ratio)


def best_stress_ratio(thickness: float, profile: str = "tanh", scheme: str = EULER) -> float:
    """The k at which τ = τ₀, of the channel itself and not of its flat layer."""
    return brentq(
        lambda k: flow_at(k, thickness, profile, scheme).stress_error, 0.05, 3.0, xtol=1e-11
    )


def best_velocity_ratio(thickness: float) -> float:
    """The k of the least L2 error of uⁿ; tanh, backward Euler."""
    found = minimize_scalar(
        lambda k: flow_at(k, thickness).error, bounds=(0.7, 0.8), options={"xatol": 1e-7}
    )
    return float(found.x)


def solved_shift(flow: Flow, thickness: float) -> float:
    """s₀ = (Vν/τ − h)/ξ."""
    return (CHANNEL.speed * CHANNEL.viscosity / flow.stress - CHANNEL.height) / thickness


def all_curves() -> Curves:
    """Name of the CSV file -> columns."""
    return {
        **_profiles(),
        "error_against_step": _against_step(),
        "error_against_ratio": _against_ratio(),
        "error_against_thickness": _against_thickness(),
        "option_2_against_thickness": _option_2_against_thickness(),
        "option_2_against_viscosity": _option_2_against_viscosity(),
        "shift": _shifts(),
    }


def _profiles() -> Curves:
    """Velocities and forces across the channel, each method on its own mesh."""
    standard = flow_at(THESIS_RATIO, SHOWN)
    option_1 = couette.smoothed_force(CHANNEL, SHOWN)
    curves = {
        "standard": _columns(standard) | {"predicted_velocity": standard.predicted},
        "option_1": _columns(option_1),
    }
    for ratio in SHOWN_VISCOSITY_RATIOS:
        curves[f"option_2_{ratio:.0f}"] = _columns(smoothed_viscosity_at(SHOWN, ratio))
    return curves


def _columns(flow: Flow) -> dict[str, np.ndarray]:
    return {
        "y": flow.mesh.y,
        "exact_velocity": CHANNEL.velocity(flow.mesh.y),
        "velocity": flow.velocity,
        "force_density": flow.force,
    }


def _against_step() -> dict[str, np.ndarray]:
    """L2 error against Δt: one ξ and three ν, one ν and three ξ."""
    cases = [(0.05, viscosity) for viscosity in VISCOSITIES]
    cases += [(thickness, 1.0) for thickness in THICKNESSES if thickness != 0.05]
    # The minima are sharp: five points at each.
    best = [best_time_step(thickness, viscosity) for thickness, viscosity in cases]
    steps = np.outer(best, (0.85, 0.93, 1.0, 1.07, 1.15)).ravel()
    steps = np.union1d(np.geomspace(1e-4, 0.1, 31), steps)
    columns = {"time_step": steps}
    for thickness, viscosity in cases:
        channel = Channel(CHANNEL.height, CHANNEL.speed, viscosity)
        wall = wall_of("tanh", thickness)
        columns[f"l2_error_thickness_{thickness:g}_viscosity_{viscosity:g}"] = np.array(
            [couette.penalised(channel, wall, step).error for step in steps]
        )
    return columns


def _against_ratio() -> dict[str, np.ndarray]:
    """L2 and stress error against k."""
    ratios = np.union1d(np.linspace(0.2, 2.0, 46), np.linspace(0.68, 0.84, 17))
    columns = {"ratio": ratios}
    for thickness in THICKNESSES:
        columns |= _errors(f"{thickness:g}", [flow_at(ratio, thickness) for ratio in ratios])
    return columns


def _errors(name: str, flows: Sequence[Flow]) -> dict[str, np.ndarray]:
    """L2 and stress error of some flows, as columns."""
    return {
        f"l2_error_{name}": np.array([flow.error for flow in flows]),
        f"stress_error_{name}": np.array([flow.stress_error for flow in flows]),
    }


def _against_thickness() -> dict[str, np.ndarray]:
    """L2 error against ξ, of the method at two k and of option 1; stress error at k = 0.75."""
    thicknesses = np.geomspace(0.01, 0.3, 25)
    at_thesis = [flow_at(THESIS_RATIO, thickness) for thickness in thicknesses]
    best = best_ratio("tanh", EULER)
    return {
        "thickness": thicknesses,
        "l2_error_at_0.75": np.array([flow.error for flow in at_thesis]),
        "l2_error_at_best": np.array([flow_at(best, xi).error for xi in thicknesses]),
        "l2_error_option_1": np.array(
            [couette.smoothed_force(CHANNEL, xi).error for xi in thicknesses]
        ),
        "stress_error_at_0.75": np.array([flow.stress_error for flow in at_thesis]),
    }


def _option_2_against_thickness() -> dict[str, np.ndarray]:
    thicknesses = np.linspace(0.01, 0.3, 30)
    columns = {"thickness": thicknesses}
    for ratio in SHOWN_VISCOSITY_RATIOS:
        flows = [smoothed_viscosity_at(thickness, ratio) for thickness in thicknesses]
        columns |= _errors(f"{ratio:.0f}", flows)
    return columns


def _option_2_against_viscosity() -> dict[str, np.ndarray]:
    ratios = np.geomspace(10.0, 1e6, 26)
    columns = {"viscosity_ratio": ratios}
    for thickness in THICKNESSES:
        flows = [smoothed_viscosity_at(thickness, ratio) for ratio in ratios]
        columns |= _errors(f"{thickness:g}", flows)
    return columns


def _shifts() -> dict[str, np.ndarray]:
    """s₀(k), solved for in the channel and by `interface_shift`."""
    ratios = np.geomspace(0.05, 2.0, 19)
    cases = {f"tanh_{scheme}": ("tanh", scheme) for scheme in SCHEMES}
    cases |= {f"{profile}_{EULER}": (profile, EULER) for profile in PROFILES}
    columns = {"ratio": ratios}
    for name, (profile, scheme) in cases.items():
        columns[f"solved_{name}"] = np.array(
            [solved_shift(flow_at(k, 0.05, profile, scheme), 0.05) for k in ratios]
        )
        columns[f"flat_layer_{name}"] = np.array(
            [interface_shift(profile, k, scheme) for k in ratios]
        )
    return columns
