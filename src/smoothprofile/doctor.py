"""Is this installation sound? Versions, threads, and three problems with known answers."""

import platform
from importlib.metadata import version

import numba

from smoothprofile.provenance import LIBRARIES
from smoothprofile.simulation import Simulation
from smoothprofile.threads import available_threads, thread_count

COUETTE = {
    "title": "Self-test: a flat wall in shear",
    "domain": {
        "lengths": [1.0, 6.0, 1.0],
        "cells": [2, 96, 2],
        "boundaries": ["periodic", "wall", "periodic"],
    },
    "fluid": {"density": 1.0, "viscosity": 1.0, "wall_velocity": {"y_high": [1.0, 0.0, 0.0]}},
    "profile": {"thickness": 0.15},
    "particles": [
        {"shape": "plane", "normal": [0.0, -1.0, 0.0], "position": [0.0, 3.0, 0.0],
         "velocity": [1.0, 0.0, 0.0]}
    ],
    "time": {"end": 100.0, "steady_tolerance": 1e-9},
}  # fmt: skip
EXACT_STRESS = 1.0 / 3.0


def examine() -> dict:
    """Versions, threads and the self-tests with their verdicts."""
    simulation = Simulation.from_file(COUETTE)
    simulation.run()
    stress = float(simulation.wall_force["y_low"][0])
    on_body = float(simulation.particles[0]["force"][0])
    on_walls = float(simulation.wall_force["total"][0])
    tests = [
        _test("wall stress of Couette flow, relative error", abs(stress / EXACT_STRESS - 1), 1e-2),
        _test("body and walls balance", abs(on_body + on_walls), 1e-6),
        _test("largest divergence", simulation.summary()["max_divergence"], 1e-10),
    ]
    return {
        "python": platform.python_version(),
        **{name: version(name) for name in LIBRARIES},
        "threads": f"{thread_count()} of {available_threads()}",
        "threading_layer": numba.threading_layer(),
        "tests": tests,
    }


def _test(name: str, value: float, limit: float) -> dict:
    verdict = "ok" if value <= limit else "failed"
    return {"name": name, "measured": value, "limit": limit, "verdict": verdict}
