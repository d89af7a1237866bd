"""What many bodies cost: a coupled step and its phases, over a step of the flow alone.

python benchmarks/particles.py [cells] [rounds]

1000 spheres fill .15 of a periodic cube and settle, the mean velocity held at zero. Phases are
fractions of the flow's step in the same process, its turns taken with the coupled ones.
"""

import math
import sys
import time

from smoothprofile.config import load_case
from smoothprofile.coupling import coupling_named
from smoothprofile.simulation import Simulation
from smoothprofile.threads import available_threads, set_thread_count

COUNT, SHARE, STEP = 1000, 0.15, 0.07
CELLS_TO_XI = {"quartic-centred": 2.5, "tanh": 1.3}
PHASES = ("move", "paint", "settle", "settle_with", "added_mean", "impose")


def build(kind: str, cells: int, count: int = COUNT, share: float = SHARE) -> Simulation:
    """Spheres of radius 1 that Stokes' drag lets fall at about 1; √(νΔt) = .45 or .86 ξ."""
    side = (count * 4 / 3 * math.pi / share) ** (1 / 3)
    spheres = {
        "shape": "sphere",
        "radius": 1.0,
        "density": 2.5,
        "motion": "free",
        "random": {"count": count, "seed": 1},
    }
    case = {
        "domain": {"lengths": [side] * 3, "cells": [cells] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {
            "density": 1.0,
            "viscosity": 1.0,
            "gravity": [0.0, 0.0, -3.0],
            "mean_velocity": {"x": 0.0, "y": 0.0, "z": 0.0},
        },
        "profile": {"kind": kind, "thickness": CELLS_TO_XI[kind] * side / cells},
        "time": {"step": STEP, "end": 1e6},
        "output": {"every": 10**6},
        "particles": [spheres],
    }
    return Simulation(load_case(case))


def measure(run: Simulation, threads: int, rounds: int) -> dict[str, float]:
    """Least times of each phase and of the whole step over the flow's, flow and step in turn."""
    set_thread_count(threads)
    spent: dict[str, float] = {}
    for phase in PHASES:
        setattr(run.bodies, phase, _watched(getattr(type(run.bodies), phase), run.bodies, spent))
    best = dict.fromkeys(("step", "flow", *PHASES), math.inf)
    couple = coupling_named(run.case.time.coupling)
    for _ in range(rounds):
        spent.clear()
        began = time.perf_counter()
        couple(run.flow, run.bodies, run.state, run.time_step)
        spent["step"] = time.perf_counter() - began
        began = time.perf_counter()
        run.flow.step(run.state, run.time_step)
        spent["flow"] = time.perf_counter() - began
        best = {name: min(least, spent[name]) for name, least in best.items()}
    return {name: value / best["flow"] for name, value in best.items()}


def _watched(verb, bodies, spent: dict[str, float]):
    def call(*arguments):
        began = time.perf_counter()
        result = verb(bodies, *arguments)
        spent[verb.__name__] = spent.get(verb.__name__, 0.0) + time.perf_counter() - began
        return result

    return call


def main(cells: int = 128, rounds: int = 7) -> None:
    """One line for each profile and number of threads."""
    print(f"{'profile':16} {'threads':>7} {'step/flow':>10}", *(f"{p:>11}" for p in PHASES))
    for kind in CELLS_TO_XI:
        run = build(kind, cells)
        for threads in sorted({1, available_threads()}):
            set_thread_count(threads)
            run.step_once()
            found = measure(run, threads, rounds)
            parts = (f"{found[phase]:11.3f}" for phase in PHASES)
            print(f"{kind:16} {threads:7} {found['step']:10.2f}", *parts, flush=True)


if __name__ == "__main__":
    main(*(int(value) for value in sys.argv[1:]))
