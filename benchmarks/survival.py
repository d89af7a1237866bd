"""What surviving costs: checkpoints every five minutes, and the watches of each step.

    python benchmarks/survival.py [CASE] [KEY=VALUE ...]

Both are measured in one process: the time of a checkpoint over 300 s, of all watches over a step.
"""

import sys
import tempfile
import time
from pathlib import Path

from smoothprofile.config import load_case
from smoothprofile.flow.monitor import watch
from smoothprofile.output import RunDirectory
from smoothprofile.simulation import Simulation

BETWEEN = 300.0
ROUNDS = 7


def best(action, repeats: int = 1) -> float:
    """The least seconds that one of `repeats` actions takes."""
    times = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        for _ in range(repeats):
            action()
        times.append((time.perf_counter() - began) / repeats)
    return min(times)


def watches(simulation: Simulation) -> None:
    """What `step_once` asks after each step."""
    advection = simulation.case.fluid.advection
    watch(simulation.grid, simulation.state, simulation.extremes, simulation.time_step, advection)
    simulation._watch_bodies(
        simulation.bodies.state.position, simulation.time, simulation.time_step
    )


def main(case: str, overrides: list[str]) -> None:
    simulation = Simulation(load_case(case, ["start=[]", *overrides]))
    for _ in range(4):
        simulation.step_once()
    step = best(simulation.step_once)
    asked = best(lambda: watches(simulation), 100)
    with tempfile.TemporaryDirectory() as folder:
        directory = RunDirectory(Path(folder) / "run", simulation.case.to_toml())
        with directory:
            directory.record(simulation)
            written = best(lambda: directory.checkpoint(simulation))
            size = (directory.path / "checkpoint.h5").stat().st_size
    print(f"{case}: {simulation.grid.cell_count} cells, {simulation.bodies.state.count} bodies")
    print(f"a checkpoint of {size / 2**20:.1f} MiB is {written / step:.2f} steps")
    print(f"every five minutes: {100 * written / BETWEEN:.3f} % of a run")
    print(f"watches: {100 * asked / step:.4f} % of a step")


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "duct", sys.argv[2:])
