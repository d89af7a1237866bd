"""What a suspension is as a whole: its volume fraction, how it settles, the stress that it bears.

    c = ΣV_b/V,   Σ_p = ΣS_b/V,   settling velocity = ĝ·(⟨V_b⟩ − ⟨u⟩),   μ_app = τ/γ̇

S_b are the stresslets (`particles/stress.py`), V the volume of the box, ⟨V_b⟩ the mean of the free
bodies, ⟨u⟩ that of fluid and bodies together; ĝ points along gravity. Bodies without an end do
not count. The stress of inertia, −ρ⟨u'u'⟩, is no part of Σ_p.
"""

import math
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np

from smoothprofile import calibration, wall_stress
from smoothprofile.assembly import build_flow, build_grid, starting_state
from smoothprofile.config import Case, body_shape, load_case
from smoothprofile.config.refusals import Refusal
from smoothprofile.distances import SPHERE
from smoothprofile.errors import CaseError
from smoothprofile.flow.state import fluid_at_rest
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.pairing import surface_offsets
from smoothprofile.particles.bodies import Forms
from smoothprofile.particles.loads import Impulse
from smoothprofile.particles.paint import Painter
from smoothprofile.particles.stress import components, stresslets
from smoothprofile.profiles import profile_named
from smoothprofile.shapes import Shape

MOST_STEPS = 20_000
MEASUREMENTS = 4
"""Measurements of the stresslets in the time that viscosity takes across the box, over 2π."""


def volume_fraction(simulation: Any) -> float:
    """c = ΣV_b/V of the bodies that have an end, by their true volumes."""
    volume = simulation.bodies.painter.forms.volume
    return float(volume[np.isfinite(volume)].sum()) / simulation.grid.volume


def particle_stress(simulation: Any) -> np.ndarray:
    """Σ_p = ΣS_b/V (6,): xx, yy, zz, yz, xz, xy."""
    bounded = np.isfinite(simulation.bodies.painter.forms.volume)
    total = simulation.bodies.stresslets()[bounded].sum(axis=0)
    return components(total) / simulation.grid.volume


def settling(simulation: Any) -> dict[str, Any]:
    """⟨V_b⟩ (3,) of the free bodies in the box's frame, and ĝ·(⟨V_b⟩ − ⟨u⟩) if there is gravity."""
    rows = simulation.bodies.free.rows
    if not rows.size:
        return {}
    mean = simulation.bodies.state.velocity[rows].mean(axis=0)
    gravity = np.array(simulation.case.fluid.gravity)
    strength = np.linalg.norm(gravity)
    if not strength:
        return {"mean_particle_velocity": mean}
    speed = gravity @ (mean - np.array(simulation.mean_velocity))
    return {"mean_particle_velocity": mean, "settling_velocity": float(speed / strength)}


def history_row(simulation: Any) -> dict[str, Any]:
    """The columns that bodies with an end add to the history."""
    if not np.isfinite(simulation.bodies.painter.forms.volume).any():
        return {}
    return settling(simulation) | {"particle_stress": particle_stress(simulation)}


def totals(simulation: Any) -> dict[str, Any]:
    """What a summary says of the suspension, and of the shear between walls that slide."""
    found = history_row(simulation)
    if found:
        found = {"volume_fraction": volume_fraction(simulation)} | found
    apparent = wall_stress.apparent_viscosity(simulation)
    return found if apparent is None else found | {"apparent_viscosity": apparent}


@dataclass(frozen=True, eq=False)
class EffectiveViscosity:
    """μ_eff/μ of a periodic cell in one strain, and what it comes from.

    ratio            μ_eff/μ
    volume_fraction  c
    stresslets       (n,3,3), over μ and the rate of strain √(2E:E)
    steps, residual  steps taken, and how far (relative to ratio − 1) the end is still away
    """

    ratio: float
    volume_fraction: float
    stresslets: np.ndarray
    steps: int
    residual: float


def effective_viscosity(
    case: str | PathLike | dict | Case, strain: Any = "xy", tolerance: float = 1e-4
) -> EffectiveViscosity:
    """μ_eff/μ = 1 + ΣS:E/(2μE:E V): free bodies in a periodic cell under a mean strain, Re → 0.

    The velocity is E·x + u', u' periodic and without mean; in the frame of u' the bodies move as
    V + Ω×r − E·r, with the V and Ω that leave them free of force and torque. Marches to the steady
    state with backward Euler. Of the case it takes box, grid, viscosity, profile and bodies, where
    they are; spheres are painted for their stresslet.

    strain: two axes, "xy", for E_xy = E_yx = ½; or E (3,3), symmetric and without trace.
    tolerance: of ratio − 1, how far the march may stop from its end. CaseError if the box is not
    periodic, if there are no bodies or one has no end, if E is none, or if the march does not end.
    """
    case = load_case(case, {})
    rate = _strain(strain)
    _check(case)
    cell = _Cell(case, rate)
    longest = max(cell.grid.lengths) / (2.0 * math.pi * cell.viscous_length)
    between = max(1, round(longest**2 / MEASUREMENTS))
    found, residual = [], math.inf
    while not residual < tolerance:
        if cell.state.steps + between > MOST_STEPS:
            raise CaseError(
                f"the effective viscosity is not settled to {tolerance:g} after "
                f"{cell.state.steps} steps; take a thicker profile.thickness or a smaller box."
            )
        cell.march(between)
        found.append(cell.increment())
        residual = _distance_left(found[-3:])
    shapes = [body_shape(particle) for particle in case.particles]
    fraction = sum(shape.volume for shape in shapes) / cell.grid.volume
    return EffectiveViscosity(
        1.0 + found[-1], fraction, cell.stresslets(), cell.state.steps, residual
    )


class _Cell:
    """The disturbance u' of a mean strain E in a periodic cell, in units of ρ = μ = 1."""

    def __init__(self, case: Case, strain: np.ndarray):
        fluid = case.fluid.model_copy(
            update={
                "density": 1.0,
                "viscosity": 1.0,
                "advection": False,
                "body_force": (0.0,) * 3,
                "mean_velocity": type(case.fluid.mean_velocity)(),
            }
        )
        time = case.time.model_copy(update={"scheme": "backward-euler"})
        case = case.model_copy(update={"fluid": fluid, "time": time})
        xi, kind = case.profile.thickness, case.profile.kind
        self.strain, self.grid = strain, build_grid(case.domain)
        self.viscous_length = calibration.best_ratio(kind) * xi
        self.step = self.viscous_length**2
        self.flow = build_flow(case, self.grid)
        self.state = fluid_at_rest(self.grid)
        self.flow.fill(self.state.velocity, 0.0)
        shapes = [body_shape(particle) for particle in case.particles]
        offsets = [self._offsets(case, shape) for shape in shapes]
        self.bodies = starting_state(case)
        profile = profile_named(kind)
        forms = Forms.of(shapes, offsets)
        self.painter = Painter(self.grid, self.flow.boundaries, forms, profile, xi)
        self.painter.paint(self.bodies)
        self.impulse = Impulse(self.grid, -strain)

    def march(self, steps: int) -> None:
        """That many steps: predict, let the bodies be free, impose, project."""
        for _ in range(steps):
            step = self.flow.predict(self.state, self.step)
            matrix, momentum = self.impulse.momenta(self.painter, self.bodies, step.velocity)
            motion = np.linalg.solve(matrix, momentum[..., None])[..., 0]
            self.bodies.velocity[:], self.bodies.angular_velocity[:] = motion[:, :3], motion[:, 3:]
            self.impulse.impose(self.painter, self.bodies, step.velocity)
            self.flow.project(self.state, step)
            self.flow.finish(self.state, step)

    def stresslets(self) -> np.ndarray:
        """(n,3,3) over μ√(2E:E); at the steady state nothing accelerates."""
        gained = self.impulse.first_moments(self.painter, self.bodies)
        size = math.sqrt(2.0 * np.sum(self.strain**2))
        return stresslets(gained, np.zeros_like(gained), 1.0 / self.step, 1.0) / size

    def increment(self) -> float:
        """ΣS:E/(2μE:E V)."""
        size = math.sqrt(2.0 * np.sum(self.strain**2))
        total = self.stresslets().sum(axis=0)
        return float(np.sum(total * self.strain) / size / self.grid.volume)

    def _offsets(self, case: Case, shape: Shape) -> np.ndarray:
        """Spheres as their stresslet wants it, others as if they moved through the fluid."""
        offsets = surface_offsets(case, shape, self.step, False)
        if case.profile.retract is True:
            arguments = (case.profile.thickness, self.viscous_length, case.profile.kind)
            for row, part in zip(offsets, shape.parts, strict=True):
                if part.kind == SPHERE:
                    radius = float(part.size[0])
                    painted = calibration.painted_radius(radius, *arguments, motion="straining")
                    row[:] = painted - radius, 0.0
        return offsets


def _strain(strain: Any) -> np.ndarray:
    if isinstance(strain, str):
        axes = [AXIS_NAMES.index(name) for name in strain if name in AXIS_NAMES]
        if len(strain) != 2 or len(set(axes)) != 2:
            raise CaseError(f"strain is {strain!r}; it must be two different axes, such as 'xy'.")
        rate = np.zeros((3, 3))
        rate[axes, axes[::-1]] = 0.5
        return rate
    rate = np.array(strain, dtype=np.float64)
    shown, size = rate.tolist(), np.abs(rate).max(initial=0.0)
    if rate.shape != (3, 3) or not 0.0 < size < math.inf:
        raise CaseError(f"strain is {shown}; it must be nine finite numbers, not all zero.")
    if np.abs(rate - rate.T).max() > 1e-12 * size or abs(np.trace(rate)) > 1e-12 * size:
        raise CaseError(f"strain is {shown}; it must be symmetric and without a trace.")
    return rate


def _check(case: Case) -> None:
    if case.fluid is None:
        raise CaseError("fluid is missing; an effective viscosity needs [fluid].")
    if not all(case.domain.periodic):
        allowed = "a mean strain needs a periodic box"
        raise Refusal("domain.boundaries", case.domain.boundaries, allowed)
    if not case.particles:
        raise CaseError(
            "particles is empty; without bodies the effective viscosity is the fluid's."
        )
    for number, particle in enumerate(case.particles):
        if not particle.bounded:
            raise CaseError(
                f"particles.{number} is a {particle.shape} without an end; only bodies with one "
                f"have a stresslet."
            )


def _distance_left(values: list[float]) -> float:
    """|limit − last|/|last| of a sequence that closes in as a geometric one; inf if unknown."""
    if len(values) < 3:
        return math.inf
    older, newer = values[1] - values[0], values[2] - values[1]
    if abs(newer) >= abs(older):
        return 0.0 if newer == 0.0 else math.inf
    ratio = newer / older
    return abs(newer * ratio / (1.0 - ratio) / values[2])
