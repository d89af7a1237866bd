"""The loop of a run without inertia, fluid.flow = "stokes": what `simulation.py` is for the others.

import smoothprofile as sp
run = sp.StokesSimulation.from_file("stokes-array")
run.run()
run.particles[0]["force"]
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from smoothprofile.assembly import build_action, build_grid
from smoothprofile.config import Case, is_stokes, nothing_moves
from smoothprofile.errors import CaseError
from smoothprofile.flow.state import fluid_at_rest
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import interior
from smoothprofile.particles.motion import Course
from smoothprofile.particles.watch import BodyWatch
from smoothprofile.preflight import refuse
from smoothprofile.quasistatic import advance, set_out
from smoothprofile.stokes_assembly import build_creeping, build_quasistatic, stokes_pairing
from smoothprofile.stokes_checks import check_stokes_memory, stokes_checks, surface_rows
from smoothprofile.tables import stokes_table
from smoothprofile.threads import ThreadTrial
from smoothprofile.views import FlowViews, Observer


class StokesSimulation(FlowViews):
    """One run of a case without inertia. Bad cases raise CaseError here.

    A case in which nothing moves ends after its first solve, at time 0.
    """

    has_inertia, budget, preliminary = False, None, ()

    def __init__(self, case: Case, courses: Mapping[str, Course] | None = None):
        """courses: for some bodies by name, a function t -> (position, quaternion, V, Ω)."""
        if not is_stokes(case):
            raise CaseError('fluid.flow is not "stokes"; such a case is one for Simulation.')
        check_stokes_memory(case)
        self.case, self.grid = case, build_grid(case.domain)
        self.pairing = stokes_pairing(case, self.grid)
        self._checks = stokes_checks(case, self.grid, self.pairing)
        refuse(self._checks)
        self._courses = dict(courses or {})
        self.bodies_move = bool(courses) or any(p.motion != "held" for p in case.particles)
        self.action, self.flow = build_action(case, self.grid), build_quasistatic(case, self.grid)
        self._checks += surface_rows(case, self.flow)
        self.state = fluid_at_rest(self.grid)
        self.bodies = build_creeping(
            case, self.flow, self.time_step, self._by_number(), self.action
        )
        names = [particle.name for particle in case.particles]
        extents = self.bodies.painter.forms.extents
        self._watch_bodies = BodyWatch(self.grid, self.bodies.free.rows, extents, names)
        self._still = nothing_moves(case) and not courses
        self.status, self.wall_seconds, self._first_seconds = "running", 0.0, 0.0
        self._threads = ThreadTrial()
        self.history: dict[str, list] = {}
        self.retries: list[dict[str, Any]] = []

    @property
    def time_step(self) -> float:
        return self.pairing.step

    def run(self, observer: Observer | None = None) -> dict[str, Any]:
        """Solve for the flow at the start, and step to the end; returns the summary."""
        return self.march(observer)

    def step_once(self) -> None:
        """The flow at the start if there is none yet, else one step; its watch, its row."""
        with self.timed():
            starting = self.flow.report is None
            if starting:
                set_out(self.flow, self.bodies, self.state)
            else:
                advance(self.flow, self.bodies, self.state, self.time_step)
            self._watch_bodies(self.bodies.state.position, self.time, self.time_step)
            self.status = "steady" if self._still else self._decide()
            if starting or self.steps % self.case.output.every == 0 or self.status != "running":
                self._record()

    def saved(self) -> dict[str, Any]:
        """Everything that a run goes on from between two steps, and what it has to tell."""
        return {
            "flow_state": self.state.saved(),
            "flow": self.flow.saved(),
            "bodies": self.bodies.saved(),
            "action": self.action.saved(),
            "status": self.status,
            "time_step": self.time_step,
            "retries": self.retries,
            "wall_seconds": self.wall_seconds,
            "history": {name: np.array(values) for name, values in self.history.items()},
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Take back what `saved` gave: the steps that follow are those that would have followed."""
        if saved["time_step"] != self.time_step:
            self.take_step(saved["time_step"])
        self.state.restore(saved["flow_state"])
        self.flow.restore(saved["flow"], self.state)
        self.bodies.restore(saved["bodies"])
        self.action.restore(saved["action"])
        self.status, self.wall_seconds = saved["status"], saved["wall_seconds"]
        self.history = {name: list(values) for name, values in saved["history"].items()}
        self.retries = list(saved["retries"])

    def take_step(self, step: float) -> None:
        """Begin again at time 0, with another Δt; CaseError if the case cannot be run with it."""
        time = self.case.time.model_copy(update={"step": step})
        self.__init__(self.case.model_copy(update={"time": time}), self._courses)

    @property
    def walls(self) -> Walls:
        return self.flow.drive.walls

    @property
    def pressure(self) -> np.ndarray:
        """(nx,ny,nz), with zero mean, without the part that drives along periodic axes."""
        return interior(self.state.pressure)

    @property
    def driving_force(self) -> np.ndarray:
        """−G (3,): what drives the fluid along periodic axes, per unit volume."""
        return -self.flow.pressure_gradient

    @property
    def mean_velocity(self) -> list[float]:
        """⟨u⟩ (3,) of fluid and bodies together."""
        return self.flow.mean_velocity(self.state)

    @property
    def largest_divergence(self) -> float:
        return self.flow.largest_divergence(self.state)

    def _solved(self) -> dict[str, float]:
        report = self.flow.report
        return {"iterations": report.iterations, "residual": report.residual}

    def table(self) -> list[tuple[str, str, str]]:
        """The result as rows quantity, value, note, for people."""
        return stokes_table(self)
