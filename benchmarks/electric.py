"""What a solve for the potential costs, against an FFT round trip in the same process.

python benchmarks/electric.py [cells] [permittivity] [threads]
"""

import math
import sys
import time

import numpy as np

from smoothprofile.electric.permittivity import Permittivity
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import Forms, bodies_at
from smoothprofile.profiles import profile_named
from smoothprofile.shapes import sphere
from smoothprofile.threads import available_threads, set_thread_count
from smoothprofile.transforms import fourier_round_trip

ROUNDS = 5
FIELD = (1.0, 0.0, 0.0)


def main(cells: int = 128, permittivity: float = 10.0, threads: int = 0) -> None:
    """One sphere that fills .3 of a periodic cube; cold starts to 1e-6, turns with round trips."""
    set_thread_count(threads or available_threads())
    grid = Grid(tuple(uniform_axis(name, 0.0, 1.0, cells, True) for name in "xyz"))
    forms = Forms.of([sphere((0.9 / (4 * math.pi)) ** (1 / 3))], [np.zeros((1, 2))])
    state = bodies_at([[0.5, 0.5, 0.5]], [[1.0, 0.0, 0.0, 0.0]])
    tanh = profile_named("tanh")
    medium = Permittivity(grid, forms, [permittivity], 1.0, tanh, 0.75 / cells)
    round_trip = fourier_round_trip(grid.shape, grid.dtype)
    for name in ("fourier", "scaled", "smoothed"):
        solver = PotentialSolver(grid, preconditioner=name)
        medium.paint(state, solver.scratch)
        solver.solve(medium, FIELD)
        solves, trips = [], []
        for _ in range(ROUNDS):
            solver.potential[:] = 0.0
            began = time.perf_counter()
            report = solver.solve(medium, FIELD)
            solves.append(time.perf_counter() - began)
            for _ in range(5):
                began = time.perf_counter()
                round_trip()
                trips.append(time.perf_counter() - began)
        ratio = min(solves) / report.iterations / min(trips)
        print(
            f"{name:9} {report.iterations:4} iterations, residual {report.residual:.1e}, "
            f"{min(solves):.3f} s, {ratio:.2f} round trips an iteration"
        )


if __name__ == "__main__":
    kinds = (int, float, int)
    main(*(kind(value) for kind, value in zip(kinds, sys.argv[1:], strict=False)))
