"""What every run of a fluid has, whichever way it moves: its loop, fields, cuts, history."""

import time as clock
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

import numpy as np

from smoothprofile import cuts, sampling
from smoothprofile.config import Case, load_case
from smoothprofile.errors import CaseError
from smoothprofile.flow.monitor import Extremes
from smoothprofile.flow.state import FlowState
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import AXIS_NAMES, Grid
from smoothprofile.particles.motion import Course
from smoothprofile.preflight import Check
from smoothprofile.rows import body_rows, history_row, totals
from smoothprofile.threads import thread_count

Observer = Callable[["FlowViews"], None]
"""Called after each step."""


class FlowViews:
    """Of a run that has what is named here, and forms of its own for what else it shows."""

    case: Case
    grid: Grid
    state: FlowState
    walls: Walls
    status: str
    time_step: float
    history: dict[str, list]
    retries: list[dict[str, Any]]
    preliminary: list[dict[str, Any]]
    driving_force: np.ndarray
    mean_velocity: list[float]
    largest_divergence: float

    @classmethod
    def from_file(cls, case: str | Path | dict, overrides: Mapping | list | None = None) -> Self:
        """From a TOML file, a built-in case's name or a dict; {"time.end": 2} changes it."""
        return cls(load_case(case, overrides or {}))

    @property
    def time(self) -> float:
        return self.state.time

    @property
    def steps(self) -> int:
        return self.state.steps

    @property
    def moment(self) -> str:
        """Where the run is, in words."""
        return f"step {self.steps}"

    @property
    def under_way(self) -> "FlowViews":
        """This run, if no other goes before it."""
        return self

    @property
    def extremes(self) -> Extremes:
        """Largest speed and change of the last step."""
        return self.flow.extremes

    @property
    def seconds_per_step(self) -> float:
        """Mean over all steps but the first, which may have to compile."""
        if self.steps < 2:
            return self.wall_seconds
        return (self.wall_seconds - self._first_seconds) / (self.steps - 1)

    def march(self, observer: Observer | None) -> dict[str, Any]:
        """Step to the end, and tell the observer of each; returns the summary."""
        while self.status == "running":
            self.step_once()
            if observer:
                observer(self)
        return self.summary()

    @contextmanager
    def timed(self) -> Iterator[None]:
        """A step, whose time counts, and tells how many threads are the fastest."""
        self._threads.begin()
        began = clock.perf_counter()
        yield
        took = clock.perf_counter() - began
        self.wall_seconds += took
        self._first_seconds = self._first_seconds or took
        self._threads.end(took)

    @property
    def velocity(self) -> np.ndarray:
        """(3,nx,ny,nz) at the cell centres."""
        return sampling.centred_velocity(self.state.velocity)

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
        return cuts.of_run(self, axis, at)

    def wall_shear(self, wall: str, component: str, along: str, at: float):
        """Coordinates along a wall and ∂u_component/∂x_normal there."""
        c = AXIS_NAMES.index(component)
        axis, side = AXIS_NAMES.index(wall[0]), int(wall.endswith("high"))
        speed = self.walls.velocity_at(axis, side, self.time)[c]
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
            "mean_velocity": self.mean_velocity,
            "max_divergence": self.largest_divergence,
            "change_rate": self.extremes.rate(self.time_step),
            "resolution": {check["name"]: check["value"] for check in self._checks},
            "start": self.preliminary,
            "retries": self.retries,
        }

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

    def _solved(self) -> dict[str, float]:
        """What a step's solver adds to the history."""
        return {}

    def _record(self) -> None:
        row = history_row(self) | self._solved()
        for name, value in row.items():
            self.history.setdefault(name, []).append(value)
