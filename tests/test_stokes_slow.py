"""Steady Stokes flow at the resolutions that accuracy takes; minutes, run by hand."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest

from smoothprofile.grid import Grid, stretched_axis
from smoothprofile.shapes import ellipsoid, sphere
from smoothprofile.theory.two_spheres import pair_mobility
from smoothprofile.threads import available_threads, set_thread_count
from smoothprofile.viscous.around import stokes_around
from stokes_scenes import CUBIC, DUCT, array_drag, at, box, duct, images

pytestmark = pytest.mark.slow
PULL = 6.0 * math.pi


@pytest.fixture(autouse=True)
def more_threads(one_thread):
    set_thread_count(min(2, available_threads()))


@pytest.mark.parametrize("share", list(CUBIC))
def test_cubic_arrays_to_one_percent_and_their_order(share):
    cells = np.array([24, 48, 96])
    # The mean over places of the grid, which ripples by .1 % on the coarsest.
    places = [(0.5, 0.5, 0.5), (0.51, 0.505, 0.515), (0.505, 0.51, 0.502)]
    drags = np.array([np.mean([array_drag(share, n, p) for p in places]) for n in cells])
    errors = np.abs(drags / CUBIC[share] - 1.0)
    assert errors[-1] < 0.01
    # Below 3e-4 the place of the grid and the digits of the reference count as much.
    if errors[-1] > 3e-4:
        order = -np.polyfit(np.log(cells), np.log(errors), 1)[0]
        assert order >= 1.6


def test_a_dilute_array_is_of_second_order_in_the_thickness_of_layers_well_below_a_radius():
    """c = .064, where ξ above is .14a on the finest grid: cells clustered about the sphere.

    On one grid, so that its own error, .07 %, falls out of the differences between thicknesses.
    """
    side = (4.0 * math.pi / 3.0 / 0.064) ** (1.0 / 3.0)
    axes = (stretched_axis(name, 0.0, side, 96, True, 0.5 * side, 4.0, 1.2) for name in "xyz")
    grid = Grid(tuple(axes))
    places = 0.5 * side + np.array([[0.0, 0.0, 0.0], [0.3, 0.15, 0.4], [0.1, 0.45, 0.25]]) / 29.4
    drags = []
    for thickness in (0.28, 0.2, 0.14, 0.1):
        stokes = stokes_around(grid, [sphere(1.0)], 1.0, thickness=thickness)
        found = [
            stokes.resistance(at(place), 0.0, 0.0, mean_velocity=(1.0, 0.0, 0.0)).force[0, 0]
            for place in places
        ]
        drags.append(np.mean(found))
    thick, thin = drags[2] - drags[0], drags[3] - drags[1]
    # 1.73 measured; 1.3 from ξ = .56a to .4a.
    assert math.log(thick / thin) / math.log(1.4) > 1.6


@pytest.mark.parametrize("distance", [2.5, 3.0, 4.0])
@pytest.mark.parametrize("direction", ["along", "across"])
def test_two_spheres_near_each_other(direction, distance):
    """Opposite forces, gaps from half a radius, 12 cells to the radius: within 2 %."""
    side, cells = 10.0, 120
    stokes = stokes_around(box([side] * 3, [cells] * 3), [sphere(1.0)] * 2, 1.0)
    arm = 0.5 * distance * np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    axis = 0 if direction == "along" else 1
    pull = np.zeros((2, 3))
    pull[:, axis] = PULL, -PULL
    found = stokes.mobility(at(0.5 * side + arm), pull, 0.0, tolerance=1e-5)
    # The images are those of the pair's stresslet: that of the forces and what the spheres add.
    points = arm.T @ pull
    both = [_stresslet(points + found.first_moment.sum(axis=0)), _stresslet(points)]
    share = (both[0] ** 2).sum() / (both[1] ** 2).sum()
    seen = 0.75 * (images([0, 0, 0], side) - images([distance, 0, 0], side))[axis, axis]
    exact = pair_mobility(distance, direction, opposite=True)
    assert found.velocity[0, axis] - share * seen == pytest.approx(exact, rel=0.02)


def _stresslet(moment: np.ndarray) -> np.ndarray:
    return 0.5 * (moment + moment.T) - np.trace(moment) / 3.0 * np.eye(3)


def test_duct_to_a_thousandth():
    grid = box([20.0, 7.0, 7.0], [128, 45, 45], (True, False, False))
    stokes, walls = duct(grid)
    options = {"mean_velocity": (None, 0.0, 0.0), "wall_velocity": walls}
    found = stokes.resistance(at([10.0, 3.5, 3.5]), 0.0, 0.0, **options)
    assert found.force[0, 0] == pytest.approx(DUCT, rel=2e-3)


def test_prolate_spheroid():
    """Long axis 2, along and across: X^A and Y^A of Kim & Karrila, table 3.4, with the box."""
    side, e = 16.0, math.sqrt(3.0) / 2.0
    log = math.log((1.0 + e) / (1.0 - e))
    along = 8.0 / 3.0 * e**3 / (-2.0 * e + (1.0 + e * e) * log)
    across = 16.0 / 3.0 * e**3 / (2.0 * e + (3.0 * e * e - 1.0) * log)
    stokes = stokes_around(box([side] * 3, [96] * 3), [ellipsoid((2.0, 1.0, 1.0))], 1.0)
    for axis, factor in ((0, along), (1, across)):
        pull = np.zeros((1, 3))
        pull[0, axis] = PULL
        found = stokes.mobility(at([0.5 * side] * 3), pull, 0.0)
        lone = found.velocity[0, axis] - 0.75 * images([0, 0, 0], side)[0, 0]
        # .4 % measured: local curvature is an approximation.
        assert lone == pytest.approx(0.5 / factor, rel=0.01)


def test_iterations_hardly_grow_with_the_number_of_spheres(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "benchmarks")
    benchmark = runpy.run_path(str(Path(__file__).parents[1] / "benchmarks" / "stokes.py"))
    iterations = {}
    for count, cells in benchmark["COUNTS"].items():
        run = benchmark["build"]("quartic-centred", cells, count, benchmark["SHARE"])
        stokes = stokes_around(run.flow.grid, [sphere(1.0)] * count, 1.0)
        force, torque = np.random.default_rng(0).standard_normal((2, count, 3))
        found = stokes.mobility(run.bodies.state, force, torque, tolerance=1e-4)
        assert found.report.converged
        iterations[count] = found.report.iterations
    assert iterations[1000] < iterations[27] * (1000 / 27) ** 0.2
    assert iterations[1000] < iterations[1] * 1000**0.2
