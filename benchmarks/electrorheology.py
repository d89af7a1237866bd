"""What a field costs a step of many free beads, and its phases, over the step without it.

python benchmarks/electrorheology.py [cells] [rounds] [threads]

200 beads of ten times the fluid's permittivity fill .1 of a periodic cube and draw each other into
chains; the potential starts from that of the step before and is solved to 1e-4. The step without
is what is left of each step when its field is taken out.
"""

import math
import sys
import time

from smoothprofile.config import load_case
from smoothprofile.coupling import coupling_named
from smoothprofile.simulation import Simulation
from smoothprofile.threads import available_threads, set_thread_count

COUNT, SHARE, RATIO = 200, 0.1, 10.0
CELLS_TO_XI, REYNOLDS = 1.6, 0.1
BEST = 0.92
"""√(νΔt)/ξ of tanh."""
PHASES = ("paint", "solve", "loads")


def build(cells: int) -> Simulation:
    """Beads of radius 1 and the fluid's density; ε = μ = 1, and E such that Re is about .1."""
    side = (COUNT * 4 / 3 * math.pi / SHARE) ** (1 / 3)
    xi = CELLS_TO_XI * side / cells
    beads = {
        "shape": "sphere",
        "radius": 1.0,
        "density": 1.0,
        "motion": "free",
        "permittivity": RATIO,
        "random": {"count": COUNT, "seed": 1},
    }
    case = {
        "domain": {"lengths": [side] * 3, "cells": [cells] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {
            "density": 1.0,
            "viscosity": 1.0,
            "mean_velocity": {"x": 0.0, "y": 0.0, "z": 0.0},
        },
        "electric": {"field": [0.0, 0.0, 1.0], "tolerance": 1e-4},
        "profile": {"kind": "tanh", "thickness": xi},
        "time": {"step": (BEST * xi) ** 2, "end": 1e6},
        "output": {"every": 10**6},
        "particles": [beads],
    }
    return Simulation(load_case(case))


def measure(run: Simulation, rounds: int) -> dict[str, float]:
    """Least times of a step and of the field's phases over the rest of the step; iterations."""
    field, spent = run.action.field, {}
    watched = {
        "field": (run.bodies, "pull"),
        "paint": (field.medium, "paint"),
        "solve": (field.solver, "solve"),
        "loads": (field, "loads"),
    }
    plain = {name: getattr(owner, verb) for name, (owner, verb) in watched.items()}
    for name, (owner, verb) in watched.items():
        setattr(owner, verb, _watched(name, plain[name], spent))
    couple = coupling_named(run.case.time.coupling)
    found = {name: [] for name in ("step", "rest", *PHASES)}
    iterations = []
    for _ in range(rounds):
        spent.clear()
        began = time.perf_counter()
        couple(run.flow, run.bodies, run.state, run.time_step)
        spent["step"] = time.perf_counter() - began
        spent["rest"] = spent["step"] - spent["field"]
        iterations.append(run.action.report.iterations)
        for name, values in found.items():
            values.append(spent[name])
    for name, (owner, verb) in watched.items():
        setattr(owner, verb, plain[name])
    least = {name: min(values) for name, values in found.items()}
    rest = least.pop("rest")
    return {name: v / rest for name, v in least.items()} | {"iterations": max(iterations)}


def _watched(phase: str, verb, spent: dict[str, float]):
    def call(*arguments):
        began = time.perf_counter()
        result = verb(*arguments)
        spent[phase] = spent.get(phase, 0.0) + time.perf_counter() - began
        return result

    return call


def main(cells: int = 128, rounds: int = 7, threads: int = 0) -> None:
    """One line for each number of threads: one, and all."""
    print(f"{'threads':>7} {'step/without':>13} {'iterations':>11}", *(f"{p:>8}" for p in PHASES))
    run = build(cells)
    for count in sorted({1, threads or available_threads()}):
        set_thread_count(count)
        for _ in range(3):
            run.step_once()
        set_thread_count(count)
        found = measure(run, rounds)
        parts = (f"{found[phase]:8.2f}" for phase in PHASES)
        print(f"{count:7} {found['step']:13.2f} {found['iterations']:11.0f}", *parts, flush=True)


if __name__ == "__main__":
    main(*(int(value) for value in sys.argv[1:]))
