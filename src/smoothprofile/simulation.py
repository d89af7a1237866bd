"""The loop: steps, stop rules, history, and what a run looks like from Python.

import smoothprofile as sp
simulation = sp.Simulation.from_file("duct")
simulation.run()
simulation.particles[0]["force"]
"""

import time as clock
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from smoothprofile import cuts, sampling
from smoothprofile.assembly import (
    build_action,
    build_flow,
    build_grid,
    build_particles,
    initial_state,
)
from smoothprofile.blowup import watch_flow
from smoothprofile.boundaries import fill_ghosts, pressure_boundary
from smoothprofile.config import Case, build_shape, load_case
from smoothprofile.coupling import coupling_named, set_out
from smoothprofile.errors import CaseError
from smoothprofile.flow.monitor import Extremes
from smoothprofile.grid import AXIS_NAMES, interior
from smoothprofile.pairing import expected_speed, pair
from smoothprofile.particles.motion import Course
from smoothprofile.particles.watch import BodyWatch
from smoothprofile.preflight import Check, check_memory, checks, refuse
from smoothprofile.preliminary import PreliminaryRuns
from smoothprofile.rows import body_rows, history_row, totals
from smoothprofile.tables import result_table
from smoothprofile.threads import ThreadTrial, thread_count

Observer = Callable[["Simulation"], None]


class Simulation:
    """One run of a case. Bad cases raise CaseError here, before any step is taken."""

    def __init__(self, case: Case, courses: Mapping[str, Course] | None = None):
        """courses: for some bodies by name, a function t -> (position, quaternion, V, Ω)."""
        if case.fluid is None:
            raise CaseError("this case has no [fluid]: it is a field alone, for Electrostatics.")
        check_memory(case)
        self.case = case
        self.grid = build_grid(case.domain)
        reaches = [build_shape(particle).reach for particle in case.particles]
        self.pairing = pair(case, self.grid, expected_speed(case, reaches))
        self._checks = checks(case, self.grid, self.pairing)
        refuse(self._checks)
        self._courses = dict(courses or {})
        self.bodies_move = bool(courses) or any(p.motion != "held" for p in case.particles)
        self.flow = build_flow(case, self.grid)
        self.state = initial_state(case, self.flow)
        speed = max(self.pairing.speed)
        self.action = build_action(case, self.grid)
        self.bodies = build_particles(
            case, self.flow, self.pairing.step, speed, self._by_number(), self.action
        )
        set_out(self.flow, self.bodies, self.state)
        names = [particle.name for particle in case.particles]
        extents = self.bodies.painter.forms.extents
        self._watch_bodies = BodyWatch(self.grid, self.bodies.free.rows, extents, names)
        self._couple = coupling_named(case.time.coupling)
        self.status = "running"
        self.wall_seconds = 0.0
        self._first_seconds = 0.0
        self._threads = ThreadTrial()
        self.history: dict[str, list] = {}
        self._stages = PreliminaryRuns(
            case.stages()[:-1], lambda stage: Simulation(stage, self._courses)
        )

    @classmethod
    def from_file(
        cls, case: str | Path | dict, overrides: Mapping | list | None = None
    ) -> "Simulation":
        """From a TOML file, a built-in case's name or a dict; {"time.end": 2} changes it."""
        return cls(load_case(case, overrides or {}))

    @property
    def time(self) -> float:
        return self.state.time

    @property
    def extremes(self) -> Extremes:
        """Largest speed and change of the last step."""
        return self.flow.extremes

    @property
    def steps(self) -> int:
        return self.state.steps

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
        while self.status == "running":
            self.step_once()
            if observer:
                observer(self)
        return self.summary()

    def step_once(self) -> None:
        """One step, its watch, its row of history, and the decision whether to go on."""
        self._threads.begin()
        began = clock.perf_counter()
        self._couple(self.flow, self.bodies, self.state, self.time_step)
        watch_flow(self)
        self._watch_bodies(self.bodies.state.position, self.time, self.time_step)
        self.status = self._decide()
        if self.steps % self.case.output.every == 0 or self.status != "running":
            self._record()
        took = clock.perf_counter() - began
        self.wall_seconds += took
        self._first_seconds = self._first_seconds or took
        self._threads.end(took)

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
            "wall_seconds": self.wall_seconds,
            "history": {name: np.array(values) for name, values in self.history.items()},
            "preliminary": self.preliminary,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Take back what `saved` gave: the steps that follow are those that would have followed."""
        if "stages" in saved:
            self._stages.restore(saved["stages"])
            return
        self.state.restore(saved["flow_state"])
        self.flow.restore(saved["flow"])
        self.bodies.restore(saved["bodies"])
        self.action.restore(saved["action"])
        self.status, self.wall_seconds = saved["status"], saved["wall_seconds"]
        self.history = {name: list(values) for name, values in saved["history"].items()}
        self._stages.rows = saved["preliminary"]

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

    def _decide(self) -> str:
        rules = self.case.time
        settled = self.extremes.rate(self.time_step) < (rules.steady_tolerance or 0.0)
        if settled and self.steps > 1:
            return "steady"
        if self.time >= rules.end * (1 - 1e-12):
            return "finished"
        if rules.max_steps and self.steps >= rules.max_steps:
            return "max_steps"
        return "running"

    def _by_number(self) -> dict[int, Course]:
        names = [particle.name for particle in self.case.particles]
        for name in self._courses:
            if name not in names:
                raise CaseError(f"courses names {name!r}; the bodies are {', '.join(names)}.")
            if self.case.particles[names.index(name)].motion == "free":
                raise CaseError(f"courses names {name!r}, which moves freely and takes no course.")
        return {names.index(name): course for name, course in self._courses.items()}

    def _record(self) -> None:
        row = history_row(self)
        for name, value in row.items():
            self.history.setdefault(name, []).append(value)

    @property
    def seconds_per_step(self) -> float:
        """Mean over all steps but the first, which may have to compile."""
        if self.steps < 2:
            return self.wall_seconds
        return (self.wall_seconds - self._first_seconds) / (self.steps - 1)

    @property
    def velocity(self) -> np.ndarray:
        """(3,nx,ny,nz) at the cell centres."""
        return sampling.centred_velocity(self.state.velocity)

    @property
    def pressure(self) -> np.ndarray:
        """(nx,ny,nz), in the case's own units of pressure, with zero mean."""
        return self.case.fluid.density * interior(self.state.pressure)

    @property
    def indicator(self) -> np.ndarray:
        """(nx,ny,nz): φ of all bodies at the cell centres, as painted."""
        return self.bodies.painter.centred()

    @property
    def potential(self) -> np.ndarray:
        """(nx,ny,nz): V at the cell centres; zero without a field."""
        return self.action.potential(self.grid)

    @property
    def electric_field(self) -> np.ndarray:
        """(3,nx,ny,nz): E at the cell centres; zero without a field."""
        return self.action.vectors(self.grid)

    @property
    def driving_force(self) -> np.ndarray:
        """(3,) body force per unit volume, with what holds the mean velocity."""
        held = self.case.fluid.density * self.flow.mean_flow.force
        return np.asarray(self.case.fluid.body_force) + held

    @property
    def wall_force(self) -> dict[str, np.ndarray]:
        """Force of the fluid on each wall over the last step, and their total."""
        forces = self.flow.wall_force(self.state)
        return forces | {"total": sum(forces.values(), np.zeros(3))}

    @property
    def particles(self) -> list[dict[str, Any]]:
        """One dict a body: place, motion, loads, and the fluid's velocity at its centre."""
        return body_rows(self)

    def sample_line(self, axis: str, through: tuple[float, float], component: str):
        """Coordinates and a velocity component along `axis` through the two other coordinates."""
        a, c = AXIS_NAMES.index(axis), AXIS_NAMES.index(component)
        return sampling.along_line(self.grid, self.state.velocity, a, through, c)

    def sample_plane(self, axis: str, at: float) -> dict[str, Any]:
        """On the cell centres of a plane: speed, in-plane velocity, φ, and the electric field."""
        return {
            **cuts.frame(self.grid, axis, at, self.indicator),
            **cuts.flow_cut(self.grid, self.state.velocity, axis, at),
            **self._field_cut(axis, at),
        }

    def _field_cut(self, axis: str, at: float) -> dict[str, Any]:
        if self.case.electric is None or self.action.loads is None:
            return {}
        reach = np.array([build_shape(particle).reach for particle in self.case.particles])
        force = self.action.loads.force
        return {
            **cuts.field_cut(self.grid, self.electric_field, self.potential, axis, at),
            **cuts.forces_in_cut(self.grid, self.bodies.state, reach, force, axis, at),
        }

    def wall_shear(self, wall: str, component: str, along: str, at: float):
        """Coordinates along a wall and ∂u_component/∂x_normal there."""
        c = AXIS_NAMES.index(component)
        axis, side = AXIS_NAMES.index(wall[0]), int(wall.endswith("high"))
        speed = self.flow.parameters.walls.velocity_at(axis, side, self.time)[c]
        a = AXIS_NAMES.index(along)
        return sampling.wall_slope(self.grid, self.state.velocity, wall, c, a, at, speed)

    def preflight(self) -> list[Check]:
        """The checks made before the run; see `preflight.py`."""
        return list(self._checks)

    def summary(self) -> dict[str, Any]:
        """The result in one dict."""
        keys = ("name", "force", "torque", "position", "velocity", "interior_velocity")
        earlier = sum(stage["wall_seconds"] for stage in self.preliminary)
        return {
            "status": self.status,
            "steps": self.steps,
            "time": self.time,
            "time_step": self.time_step,
            "wall_seconds": self.wall_seconds + earlier,
            "seconds_per_step": self.seconds_per_step,
            "cells": self.grid.cell_count,
            "threads": thread_count(),
            "bodies": [
                {key: body[key] for key in (*keys, "angular_velocity", "painted_offset")}
                for body in self.particles
            ],
            "wall_force": self.wall_force,
            "driving_force": self.driving_force,
            **totals(self),
            "mean_velocity": [
                self.flow.mean_flow.plain_mean(field, c)
                for c, field in enumerate(self.state.velocity)
            ],
            "max_divergence": self.flow.projection.largest_divergence(self.state.velocity),
            "change_rate": self.extremes.rate(self.time_step),
            "resolution": {check["name"]: check["value"] for check in self._checks},
            "start": self.preliminary,
        }

    def table(self) -> list[tuple[str, str, str]]:
        """The result as rows quantity, value, note, for people."""
        return result_table(self)
