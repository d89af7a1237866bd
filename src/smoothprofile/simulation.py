"""The loop: steps, stop rules, history, and what a run looks like from Python.

import smoothprofile as sp
simulation = sp.Simulation.from_file("duct")
simulation.run()
simulation.particles[0]["force"]
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from smoothprofile import sampling
from smoothprofile.assembly import (
    build_action,
    build_flow,
    build_grid,
    build_particles,
    initial_state,
)
from smoothprofile.blowup import watch_flow
from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.budget import Budget, take_with_budget
from smoothprofile.config import Case, build_shape, is_stokes
from smoothprofile.coupling import coupling_named, set_out
from smoothprofile.errors import CaseError
from smoothprofile.field_checks import flow_checks
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import interior
from smoothprofile.needs import check_memory
from smoothprofile.pairing import expected_speed, pair
from smoothprofile.particles.motion import Course
from smoothprofile.particles.watch import BodyWatch
from smoothprofile.preflight import refuse
from smoothprofile.preliminary import PreliminaryRuns
from smoothprofile.tables import result_table
from smoothprofile.threads import ThreadTrial
from smoothprofile.views import FlowViews, Observer


class Simulation(FlowViews):
    """One run of a case. Bad cases raise CaseError here, before any step is taken."""

    has_inertia = True

    def __init__(self, case: Case, courses: Mapping[str, Course] | None = None):
        """courses: for some bodies by name, a function t -> (position, quaternion, V, Ω)."""
        if case.fluid is None:
            raise CaseError("this case has no [fluid]: it is a field alone, for Electrostatics.")
        if is_stokes(case):
            raise CaseError('fluid.flow is "stokes"; such a case is one for StokesSimulation.')
        check_memory(case)
        self.case = case
        self.grid = build_grid(case.domain)
        reaches = [build_shape(particle).reach for particle in case.particles]
        self.pairing = pair(case, self.grid, expected_speed(case, reaches))
        self._checks = flow_checks(case, self.grid, self.pairing)
        refuse(self._checks)
        self._courses = dict(courses or {})
        self.bodies_move = bool(courses) or any(p.motion != "held" for p in case.particles)
        self.flow = build_flow(case, self.grid)
        self.state = initial_state(case, self.flow)
        speed, self.action = max(self.pairing.speed), build_action(case, self.grid)
        self.bodies = build_particles(
            case, self.flow, self.pairing.step, speed, self._by_number(), self.action
        )
        set_out(self.flow, self.bodies, self.state)
        names = [particle.name for particle in case.particles]
        extents = self.bodies.painter.forms.extents
        self._watch_bodies = BodyWatch(self.grid, self.bodies.free.rows, extents, names)
        self._couple = coupling_named(case.time.coupling)
        self.status, self.wall_seconds, self._first_seconds = "running", 0.0, 0.0
        self._threads = ThreadTrial()
        self.history: dict[str, list] = {}
        self.retries: list[dict[str, Any]] = []
        self.budget: Budget | None = None
        self._stages = PreliminaryRuns(
            case.stages()[:-1], lambda stage: Simulation(stage, self._courses)
        )

    @property
    def moment(self) -> str:
        """Where the run is, in words."""
        where = f"step {self.under_way.steps}"
        if self.under_way is self:
            return where
        return f"{where} of preliminary run {len(self.preliminary) + 1}"

    @property
    def under_way(self) -> "Simulation":
        """The preliminary run that is being made, or this one."""
        return self._stages.current or self

    @property
    def preliminary(self) -> list[dict[str, Any]]:
        """What each of the runs before this one took."""
        return self._stages.rows

    @property
    def time_step(self) -> float:
        return self.pairing.step

    def run(self, observer: Observer | None = None) -> dict[str, Any]:
        """Run the preliminary stages and then the case to its end; returns the summary."""
        if self.steps == 0 and self.case.start:
            self.continue_from(self._stages.run(observer))
        return self.march(observer)

    def step_once(self) -> None:
        """One step, its watch, its row of history, and the decision whether to go on."""
        with self.timed():
            parts = self.flow, self.bodies, self.state, self.time_step
            self.budget = take_with_budget(self, lambda: self._couple(*parts))
            watch_flow(self)
            self._watch_bodies(self.bodies.state.position, self.time, self.time_step)
            self.status = self._decide()
            if self.steps % self.case.output.every == 0 or self.status != "running":
                self._record()

    def saved(self) -> dict[str, Any]:
        """Everything that a run goes on from between two steps, and what it has to tell."""
        if self._stages.current is not None:
            return {"stages": self._stages.saved()}
        return {
            "flow_state": self.state.saved(),
            "flow": self.flow.saved(),
            "bodies": self.bodies.saved(),
            "action": self.action.saved(),
            "status": self.status,
            "time_step": self.time_step,
            "retries": self.retries,
            "budget": self.budget and self.budget.saved(),
            "wall_seconds": self.wall_seconds,
            "history": {name: np.array(values) for name, values in self.history.items()},
            "preliminary": self.preliminary,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Take back what `saved` gave: the steps that follow are those that would have followed."""
        if "stages" in saved:
            self._stages.restore(saved["stages"])
            return
        if saved["time_step"] != self.time_step:
            self.take_step(saved["time_step"])
        self.state.restore(saved["flow_state"])
        self.flow.restore(saved["flow"])
        self.bodies.restore(saved["bodies"])
        self.action.restore(saved["action"])
        self.status, self.wall_seconds = saved["status"], saved["wall_seconds"]
        self.history = {name: list(values) for name, values in saved["history"].items()}
        self._stages.rows, self.retries = saved["preliminary"], list(saved["retries"])
        self.budget = saved["budget"] and Budget(**saved["budget"])

    def take_step(self, step: float) -> None:
        """Begin again at time 0, with another Δt; CaseError if the case cannot be run with it."""
        time = self.case.time.model_copy(update={"step": step})
        self.__init__(self.case.model_copy(update={"time": time}), self._courses)

    def continue_from(self, other: "Simulation") -> None:
        """Start from the fields of another run over the same box, at this run's own time 0."""
        for c in range(3):
            values = sampling.onto(self.grid, other.grid, other.state.velocity[c], c)
            interior(self.state.velocity[c])[...] = values
        pressure = sampling.onto(self.grid, other.grid, other.state.pressure, sampling.CENTRED)
        interior(self.state.pressure)[...] = pressure
        fill_ghosts(self.state.pressure, pressure_boundary(self.grid))
        self.flow.fill(self.state.velocity, 0.0)
        # What interpolation left of divergence must not become pressure in the first step.
        self.flow.projection.make_divergence_free(self.state.velocity)
        self.flow.fill(self.state.velocity, 0.0)
        set_out(self.flow, self.bodies, self.state)

    @property
    def pressure(self) -> np.ndarray:
        """(nx,ny,nz), in the case's own units of pressure, with zero mean."""
        return self.case.fluid.density * interior(self.state.pressure)

    @property
    def driving_force(self) -> np.ndarray:
        """(3,) body force per unit volume, with what holds the mean velocity."""
        held = self.case.fluid.density * self.flow.mean_flow.force
        return np.asarray(self.case.fluid.body_force) + held

    @property
    def mean_velocity(self) -> list[float]:
        """⟨u⟩ (3,) of fluid and bodies together."""
        mean = self.flow.mean_flow.plain_mean
        return [mean(field, c) for c, field in enumerate(self.state.velocity)]

    @property
    def largest_divergence(self) -> float:
        return self.flow.projection.largest_divergence(self.state.velocity)

    @property
    def walls(self) -> Walls:
        return self.flow.parameters.walls

    def table(self) -> list[tuple[str, str, str]]:
        """The result as rows quantity, value, note, for people."""
        return result_table(self)
