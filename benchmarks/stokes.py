"""What a mobility solve of steady Stokes flow costs, over a step of direct forcing and FFTs.

python benchmarks/stokes.py [threads] [rounds]

Spheres fill .2 of a periodic cube at random, with 12.8 cells to a cube of one; random forces and
torques pull them, cold starts to 1e-4. The step is that of the same bodies, free, at the largest
number. All are timed in turn in one process.
"""

import math
import sys
import time

import numpy as np

from particles import build
from smoothprofile.coupling import coupling_named
from smoothprofile.shapes import sphere
from smoothprofile.threads import available_threads, set_thread_count
from smoothprofile.transforms import fourier_round_trip
from smoothprofile.viscous.around import stokes_around

SHARE, TOLERANCE = 0.2, 1e-4
COUNTS = {1: 13, 27: 38, 1000: 128}
"""Cells along the cube, by the number of spheres."""


def least(call, rounds: int) -> tuple[float, object]:
    """The least seconds of several calls, and the last result."""
    best, found = math.inf, None
    for _ in range(rounds):
        began = time.perf_counter()
        found = call()
        best = min(best, time.perf_counter() - began)
    return best, found


def main(threads: int = 0, rounds: int = 3) -> None:
    """A line for each number of spheres; for the last, ratios too."""
    set_thread_count(threads or available_threads())
    rng = np.random.default_rng(0)
    for count, cells in COUNTS.items():
        run = build("quartic-centred", cells, count, SHARE)
        state = run.bodies.state
        stokes = stokes_around(run.flow.grid, [sphere(1.0)] * count, 1.0)
        force, torque = rng.standard_normal((2, count, 3))
        fine = stokes.mobility(state, force, torque, tolerance=1e-8)
        seconds, found = least(
            lambda s=stokes, b=state, f=force, t=torque: s.mobility(b, f, t, tolerance=TOLERANCE),
            rounds,
        )
        report = found.report
        error = np.linalg.norm(found.velocity - fine.velocity) / np.linalg.norm(fine.velocity)
        print(
            f"{count:5} spheres, {cells}³: {report.iterations} iterations ({report.status}), "
            f"{seconds:.3f} s, velocities to {error:.1e}; to 1e-8 {fine.report.iterations}",
            flush=True,
        )
    couple = coupling_named(run.case.time.coupling)
    run.step_once()
    step, _ = least(lambda: couple(run.flow, run.bodies, run.state, run.time_step), rounds)
    trip, _ = least(fourier_round_trip(run.flow.grid.shape, np.float64), 5 * rounds)
    each = seconds / (report.iterations + 2)
    print(f"an iteration: {each / trip:.1f} FFT round trips of time, 8 of them transforms")
    print(f"the solve: {seconds / step:.1f} steps of direct forcing ({step:.3f} s)")


if __name__ == "__main__":
    main(*(int(value) for value in sys.argv[1:]))
