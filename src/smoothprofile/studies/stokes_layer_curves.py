"""Periodic states, marches and curves of the oscillating flat wall."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import newton

from smoothprofile.calibration import best_ratio, interface_shift
from smoothprofile.profiles import profile_named
from smoothprofile.schemes import SCHEMES, scheme_named
from smoothprofile.theory.stokes_layer import (
    OscillatingWall,
    PeriodicFlow,
    Steps,
    exact_stress,
    exact_velocity,
    fitted_response,
    periodic_flow,
    relative_errors,
)
from smoothprofile.theory.stokes_march import March, march

# The thesis' run.
THICKNESS, STEP, SCHEME = 0.05, 0.0019, "crank-nicolson"
THESIS_RATIO = math.sqrt(STEP) / THICKNESS
ERRORS = ("amplitude", "phase")
MARCHED = (0.6, 0.75, 1.0, 1.2)


def oscillating_wall(profile: str, thickness: float, depth: float = 3.0) -> OscillatingWall:
    """The thesis' wall, painted with a profile of the package."""
    shape = profile_named(profile)
    return OscillatingWall(shape.value, shape.core, shape.edge, thickness, depth=depth)


def steps_named(scheme: str, step: float) -> Steps:
    """The table of a scheme of the package, with a step."""
    table = scheme_named(scheme)
    return Steps(step, table.gamma, table.past, table.implicit)


def periodic(
    k: float,
    scheme: str = SCHEME,
    profile: str = "tanh",
    thickness: float = THICKNESS,
    depth: float = 3.0,
    floor: str = "free",
) -> tuple[OscillatingWall, PeriodicFlow]:
    """The wall and the periodic state at Δt = (kξ)²/ν, ν = 1."""
    wall = oscillating_wall(profile, thickness, depth)
    return wall, periodic_flow(wall, steps_named(scheme, (k * thickness) ** 2), floor)


def stress_errors(k: float, *arguments) -> dict[str, float]:
    """Amplitude error and phase error of the stress; arguments as of `periodic`."""
    wall, flow = periodic(k, *arguments)
    return dict(zip(ERRORS, relative_errors(wall, flow.stress), strict=True))


def end_rate_amplitude(k: float, floor: str = "free") -> float:
    """Amplitude error if the inertia is taken as h dV/dt at tₙ₊₁, not as the step's difference."""
    wall, flow = periodic(k, floor=floor)
    return relative_errors(wall, flow.push - 1j * wall.angular_frequency * wall.height)[0]


def root_near(error: Callable[[float], float], k: float) -> float:
    """The zero of an error near k, by the secant method: errors are smooth and fall with k."""
    return float(newton(error, k, x1=0.98 * k, tol=1e-10))


def best_k(
    name: str,
    scheme: str,
    profile: str = "tanh",
    thickness: float = THICKNESS,
    depth: float = 3.0,
) -> float:
    """The k at which the error of that name is zero."""

    def error(k: float) -> float:
        return stress_errors(k, scheme, profile, thickness, depth)[name]

    return root_near(error, best_ratio(profile, scheme))


@dataclass(frozen=True, eq=False)
class Marched:
    """A march with `count` steps to the period, an even number."""

    wall: OscillatingWall
    steps: Steps
    count: int
    found: March

    @classmethod
    def of(cls, k: float, scheme: str, periods: float) -> "Marched":
        """At the k nearest to the one asked for."""
        wall = oscillating_wall("tanh", THICKNESS)
        count = 2 * round(math.pi / (k * THICKNESS) ** 2)
        steps = steps_named(scheme, 2.0 * math.pi / count)
        return cls(wall, steps, count, march(wall, steps, round(periods * count)))

    @property
    def k(self) -> float:
        return math.sqrt(self.steps.step) / THICKNESS

    @property
    def solved(self) -> complex:
        """The stress of the periodic state at the same step, from the frequency domain."""
        return periodic_flow(self.wall, self.steps).stress

    def period(self, last: float) -> slice:
        """The steps of the period that ends after `last` periods."""
        end = round(last * self.count)
        return slice(end - self.count, end)

    def fitted(self, last: float) -> complex:
        """Appendix A's fit of the stress over that period."""
        steps = self.period(last)
        return fitted_response(self.wall, self.found.times[steps], self.found.stress[steps])


def sketch_curves() -> dict[str, np.ndarray]:
    """Thesis, figure 3.10: the layer, too thick, and the exact flow at four times."""
    y = np.linspace(0.0, 6.0, 241)
    wall = oscillating_wall("tanh", 0.2)
    names = ("u at t = 0", "u at t = T/4", "u at t = T/2", "u at t = 3T/4")
    flows = (exact_velocity(wall, y, 0.5 * math.pi * n) for n in range(4))
    return {
        "y": y,
        "indicator at thickness 0.2": wall.solid(y),
        **dict(zip(names, flows, strict=True)),
    }


def velocity_curves() -> dict[str, np.ndarray]:
    """Thesis, figure 3.11: t = 3T/2."""
    run = Marched.of(THESIS_RATIO, SCHEME, 1.5)
    found = run.found
    return {
        "y": found.y,
        "predicted": found.predicted,
        "corrected": found.corrected,
        "exact": exact_velocity(run.wall, found.y, found.times[-1]),
    }


def stress_curves(run: Marched) -> dict[str, np.ndarray]:
    """Thesis, figure 3.12: T/2 < t ≤ 3T/2."""
    steps = run.period(1.5)
    times, stress, push = (
        values[steps] for values in (run.found.times, run.found.stress, run.found.push)
    )
    return {
        "time": times,
        "stress": stress,
        "exact": exact_stress(run.wall, times),
        "push": push,
        "inertia": push - stress,
    }


def error_curves() -> dict[str, np.ndarray]:
    """Thesis, figure 3.13: errors against k, with two other readings of the amplitude."""
    k = np.linspace(0.4, 1.4, 41)
    found = [stress_errors(ratio) for ratio in k]
    return {
        "k": k,
        **{name: np.array([errors[name] for errors in found]) for name in ERRORS},
        "amplitude, h dV/dt at the end": np.array([end_rate_amplitude(ratio) for ratio in k]),
        "first order": np.array([_first_order(ratio) for ratio in k]),
    }


def _first_order(k: float) -> float:
    """−s₀ξ√(ω/2ν): both errors, if the wall stands s₀ξ too deep and nothing else is wrong."""
    return -interface_shift("tanh", k, SCHEME) * THICKNESS * math.sqrt(0.5)


def marched_curves() -> dict[str, np.ndarray]:
    """The same errors from marching and appendix A's fit over [T/2, 3T/2]."""
    runs = [Marched.of(k, SCHEME, 1.5) for k in MARCHED]
    errors = [(run.k, *relative_errors(run.wall, run.fitted(1.5))) for run in runs]
    return dict(zip(("k", *ERRORS), np.array(errors).T, strict=True))


def scheme_curves() -> dict[str, np.ndarray]:
    """Errors against k for every scheme."""
    k = np.linspace(0.4, 1.6, 25)
    columns = {"k": k}
    for scheme in SCHEMES:
        found = [stress_errors(ratio, scheme) for ratio in k]
        for name in ERRORS:
            columns[f"{name}, {scheme}"] = np.array([errors[name] for errors in found])
    return columns
