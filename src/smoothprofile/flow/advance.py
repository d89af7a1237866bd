"""One step of incompressible flow: predict, project.

(γuˢ − Σα_q uⁿ⁻q)/Δt + Σβ_q N(uⁿ⁻q) = ν∇²[θuˢ + (1−θ)uⁿ] − ∇pⁿ + g
∇²δp = (γ/Δt)∇·uˢ,   uⁿ⁺¹ = uˢ − (Δt/γ)∇δp,   pⁿ⁺¹ = pⁿ + δp
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from smoothprofile.boundaries import fill_ghosts, velocity_boundary
from smoothprofile.flow.advection import advect
from smoothprofile.flow.explicit import ExplicitTerms, accumulate
from smoothprofile.flow.mean_flow import Mean, MeanFlow
from smoothprofile.flow.monitor import Extremes
from smoothprofile.flow.projection import Projection
from smoothprofile.flow.state import FlowState, Velocity, zero_velocity
from smoothprofile.flow.viscosity import Viscosity
from smoothprofile.flow.walls import Walls, carried_forces, pressure_forces, viscous_forces
from smoothprofile.grid import Grid
from smoothprofile.schemes import SCHEMES, Scheme


@dataclass(frozen=True)
class FlowParameters:
    """Density ρ, dynamic viscosity μ, body force per unit volume, walls, and the time scheme.

    mean_velocity[axis] is held by an extra body force; None leaves that component free.
    forcing(t) gives three padded fields of acceleration that act besides; None for none.
    """

    density: float = 1.0
    viscosity: float = 1.0
    body_force: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mean_velocity: tuple[float | None, float | None, float | None] = (None, None, None)
    walls: Walls = field(default_factory=Walls)
    scheme: Scheme = SCHEMES["backward-euler"]
    advection: bool = True
    forcing: Callable[[float], Velocity] | None = None

    @property
    def kinematic_viscosity(self) -> float:
        return self.viscosity / self.density


@dataclass
class Step:
    """What one step carries from the predictor to its end: uˢ, then u**, then uⁿ⁺¹."""

    scheme: Scheme
    dt: float
    time: float
    velocity: Velocity
    advection: Velocity | None

    @property
    def rate(self) -> float:
        """γ/Δt: what a change of velocity is multiplied by to be an acceleration."""
        return self.scheme.gamma / self.dt


class Flow:
    """The operators of one flow, and scratch for one step."""

    def __init__(self, grid: Grid, parameters: FlowParameters):
        self.grid, self.parameters = grid, parameters
        kinds = parameters.walls.kinds
        self.boundaries = tuple(velocity_boundary(grid, kinds, c) for c in range(3))
        self._explicit = ExplicitTerms(grid)
        self._viscosity = tuple(Viscosity(grid, boundary) for boundary in self.boundaries)
        self.projection = Projection(grid)
        self.mean_flow = MeanFlow(grid, parameters.mean_velocity, self._viscosity)
        self._spare: list[Velocity] = []
        self.extremes = Extremes()
        self._wall_load: dict[str, np.ndarray] = {}
        self._carried: dict[str, np.ndarray] = {}
        self._nothing = np.broadcast_to(np.zeros((), grid.dtype), grid.padded_shape)

    def scheme(self, state: FlowState) -> Scheme:
        """The scheme of the step that `state` takes next."""
        return self.parameters.scheme.with_levels(state.known_levels)

    def step(self, state: FlowState, dt: float) -> None:
        """Advance `state` by dt."""
        step = self.predict(state, dt)
        self.hold_mean(step)
        self.project(state, step)
        self.finish(state, step)

    def predict(self, state: FlowState, dt: float, pressure_weight: float = 1.0) -> Step:
        """Solve for uˢ; its shear is kept, for that is what the walls take from the fluid.

        pressure_weight = 0 leaves the old pressure out, as the thesis' (2.6) does.
        """
        scheme, deep = self.scheme(state), self.parameters.scheme.levels > 1
        advection = self._take_spare() if deep and self.parameters.advection else None
        step = Step(scheme, dt, state.time + dt, self._take_spare(), advection)
        self._solve(state, step, pressure_weight)
        self._carry(state, scheme)
        if scheme.corrected and self.parameters.advection:
            self._correct_advection(state, step, pressure_weight)
        self.measure_walls(state, step)
        return step

    def hold_mean(self, step: Step, mean: Mean | None = None) -> None:
        """Add the body force that holds the mean velocity; the walls take their share of it."""
        self.mean_flow.hold(step.velocity, mean)
        for axis, response in self.mean_flow.added():
            alone = tuple(response if c == axis else self._nothing for c in range(3))
            mu = step.scheme.implicit * self.parameters.viscosity * self.mean_flow.force[axis]
            still = Walls(self.parameters.walls.kinds)
            for name, force in viscous_forces(self.grid, still, alone, mu, step.time).items():
                self._wall_load[name] = self._wall_load[name] + force

    def project(self, state: FlowState, step: Step) -> None:
        """Make the step's velocity divergence-free and add what it took to the pressure."""
        self.fill(step.velocity, step.time)
        self.projection.solve(step.velocity, step.rate)
        self.extremes = self.projection.correct(
            step.velocity, step.rate, state.velocity, state.pressure
        )

    def finish(self, state: FlowState, step: Step) -> None:
        """Take the step's velocity as the new one and keep the old levels that are still read."""
        self.fill(step.velocity, step.time)
        depth = self.parameters.scheme.levels - 1
        state.past_velocity.insert(0, state.velocity)
        if step.advection is not None:
            state.past_advection.insert(0, step.advection)
        for past in (state.past_velocity, state.past_advection):
            while len(past) > depth:
                self._spare.append(past.pop())
        state.velocity = step.velocity
        state.time, state.steps = step.time, state.steps + 1

    def fill(self, velocity: Velocity, time: float) -> None:
        """Ghosts and wall faces of a velocity at that time."""
        for c in range(3):
            fill_ghosts(velocity[c], self.boundaries[c], self.parameters.walls.values(c, time))

    def wall_force(self, state: FlowState) -> dict[str, np.ndarray]:
        """Force on each wall over the last step: its shear, what it is given, and the pressure."""
        density, drive = self.parameters.density, self.parameters.body_force
        pressures = pressure_forces(self.grid, state.pressure, density, drive)
        return {name: self._wall_load.get(name, 0.0) + f for name, f in pressures.items()}

    def saved(self) -> dict:
        """What the last step left besides the state: for reports and stop rules, not for steps."""
        return {
            "speed": self.extremes.speed,
            "change": self.extremes.change,
            "mean_force": self.mean_flow.force,
            "wall_load": self._wall_load,
        }

    def restore(self, saved: dict) -> None:
        """Take back what `saved` gave."""
        self.extremes = Extremes(tuple(saved["speed"]), tuple(saved["change"]))
        self.mean_flow.force[:] = saved["mean_force"]
        self._wall_load = saved["wall_load"]

    def _solve(
        self,
        state: FlowState,
        step: Step,
        pressure_weight: float,
        advection: Velocity | None = None,
    ) -> None:
        """The step's velocity; `advection` stands in for N(uⁿ) when given."""
        parameters, scheme, rate = self.parameters, step.scheme, step.rate
        implicit = scheme.implicit * parameters.kinematic_viscosity / rate
        weights = [b / rate if parameters.advection else 0.0 for b in scheme.advection]
        self._explicit.newest(
            state.velocity,
            state.pressure,
            step.velocity,
            step.advection if advection is None else None,
            scheme.past[0] / scheme.gamma,
            weights[0] if advection is None else 0.0,
            pressure_weight / rate,
            tuple(f / (parameters.density * rate) for f in parameters.body_force),
        )
        forcing = parameters.forcing and parameters.forcing(state.time + scheme.implicit * step.dt)
        for c, out in enumerate(step.velocity):
            if forcing:
                accumulate(out, 1.0 / rate, forcing[c])
            if advection is not None:
                accumulate(out, -weights[0], advection[c])
            for weight, old in zip(scheme.past[1:], state.past_velocity, strict=False):
                accumulate(out, weight / scheme.gamma, old[c])
            for weight, old in zip(weights[1:], state.past_advection, strict=False):
                accumulate(out, -weight, old[c])
            if scheme.implicit < 1.0:
                explicit = (1.0 - scheme.implicit) * parameters.kinematic_viscosity / rate
                self._viscosity[c].add_explicit(state.velocity[c], explicit, out)
            self._viscosity[c].solve(out, implicit, parameters.walls.values(c, step.time))
        self.mean_flow.prepare(implicit, 1.0 / rate)

    def _correct_advection(self, state: FlowState, step: Step, pressure_weight: float) -> None:
        """Solve again with the mean of N(uⁿ) and N of the trial step, made divergence-free."""
        self.mean_flow.hold(step.velocity)
        self.fill(step.velocity, step.time)
        self.projection.make_divergence_free(step.velocity)
        self.fill(step.velocity, step.time)
        mean = self._take_spare()
        advect(step.velocity, mean, self._explicit.spacings)
        trial = carried_forces(self.grid, step.velocity, self.parameters.density)
        self._carried = {name: 0.5 * (self._carried[name] + trial[name]) for name in trial}
        for total, old in zip(mean, step.advection, strict=True):
            total += old
            total *= 0.5
        self._solve(state, step, pressure_weight, mean)
        self._spare.append(mean)

    def _take_spare(self) -> Velocity:
        return self._spare.pop() if self._spare else zero_velocity(self.grid)

    def measure_walls(self, state: FlowState, step: Step) -> None:
        """Keep what walls bear beside the pressure; again if a load is added to the velocity."""
        walls, mu = self.parameters.walls, self.parameters.viscosity
        theta = step.scheme.implicit
        new = viscous_forces(self.grid, walls, step.velocity, theta * mu, step.time)
        if theta < 1.0:
            old = viscous_forces(self.grid, walls, state.velocity, (1 - theta) * mu, state.time)
            new = {name: new[name] + old[name] for name in new}
        self._wall_load = {name: new[name] + self._carried.get(name, 0.0) for name in new}

    def _carry(self, state: FlowState, scheme: Scheme) -> None:
        """What the step's advection carries to the walls."""
        self._carried = {}
        if not self.parameters.advection:
            return
        levels = (state.velocity, *state.past_velocity)
        for weight, velocity in zip(scheme.advection, levels, strict=False):
            for name, force in carried_forces(self.grid, velocity, self.parameters.density).items():
                self._carried[name] = self._carried.get(name, 0.0) + weight * force
