"""Refined meshes: the law of their widths, even and odd modes, the study of a sphere in a duct."""

import numpy as np
import pytest

from flows import slope
from smoothprofile.boundaries import FieldBoundary
from smoothprofile.config import load_case
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid, stretched_axis, uniform_axis
from smoothprofile.preflight import checks
from smoothprofile.simulation import Simulation
from smoothprofile.solvers.separable import SeparableSolver
from smoothprofile.studies import study_named
from smoothprofile.studies.refinement_runs import order, refined, seconds_per_step, uniform
from smoothprofile.transforms import basis_for, second_difference

PERIODIC, VALUE, FLUX = (("periodic",) * 2, ("value",) * 2, ("flux",) * 2)


def axis(cells=60, focus=0.0, ratio=8.0, core=0.7, periodic=True, name="x"):
    return stretched_axis(name, -2.0, 5.0, cells, periodic, focus, ratio, core)


@pytest.mark.parametrize("focus", [-2.0, 0.0, 0.5, 3.0])
@pytest.mark.parametrize("core", [0.0, 0.7])
def test_cells_are_equal_in_the_core_and_grow_to_the_ratio(focus, core):
    made = axis(2000, focus, core=core)
    inside = np.abs(made.centres - focus) < core - made.widths.max()
    # Round-off of coordinates of order one.
    assert core == 0.0 or np.ptp(made.widths[inside]) < 1e-12
    far = -1 if 3.0 - focus > focus + 2.0 else 0
    # The last cell is half a cell short of the end: 2000 of them leave 1 %.
    assert made.widths[far] / made.widths.min() == pytest.approx(8.0, rel=0.01)
    assert (made.low, made.high) == (-2.0, 3.0)
    # No step: a cell is wider than its neighbour by dt/c, and the axis is at most 11.7 c long.
    assert np.abs(np.diff(np.log(made.widths))).max() < 12.0 / made.cells


def test_a_core_as_wide_as_the_axis_leaves_equal_cells():
    assert axis(core=5.0).uniform and axis(ratio=1.0).uniform
    with pytest.raises(CaseError, match="lies outside"):
        axis(focus=4.0)


@pytest.mark.parametrize("core", [0.0, 0.7])
@pytest.mark.parametrize("periodic", [True, False])
def test_poisson_on_refined_cells_is_of_second_order(core, periodic):
    """Although the slope of the width jumps at a periodic end, and its curvature at the core's."""
    errors, sizes, k = [], (48, 96, 192), 2.0 * np.pi / 5.0
    for n in sizes:
        x = axis(n, 0.5, 4.0, core, periodic)
        grid = Grid((x, *(uniform_axis(name, 0.0, 1.0, 2, True) for name in "yz")))
        boundary = FieldBoundary((PERIODIC if periodic else FLUX, PERIODIC, PERIODIC))
        field = grid.zeros()
        exact = np.cos(k * (x.centres + 2.0))
        exact -= (exact * x.widths).sum() / 5.0
        field[1:-1, 1:-1, 1:-1] = (k * k * exact)[:, None, None]
        SeparableSolver(grid, boundary).solve(field, 0.0)
        errors.append(np.abs(field[1:-1, 1, 1] - exact).max())
    # Two in the limit, from which cells of .25 in waves of length 5 are not far; first order has 1.
    assert slope([1.0 / n for n in sizes], errors) > 1.85


@pytest.mark.parametrize("core", ["-1", "nan", '"wide"'])
def test_a_core_that_is_no_length_is_refused(core):
    law = f"domain.stretching=['uniform', 'uniform', {{focus = 0.0, ratio = 2.0, core = {core}}}]"
    with pytest.raises(CaseError, match=r"domain\.stretching\.2\.core.*zero or a positive number"):
        load_case("duct", [law, "start=[]"])


def grid_of(focus, sizes=(12, 13, 14)):
    names = zip("xyz", sizes, (True, False, False), strict=True)
    return Grid(tuple(axis(n, focus, periodic=p, name=name) for name, n, p in names))


@pytest.mark.parametrize("sizes", [(12, 13, 14), (13, 14, 11)])
@pytest.mark.parametrize("component", [-1, 0, 1, 2])
@pytest.mark.parametrize("focus", [0.5, 0.1])
def test_modes_diagonalise_with_and_without_a_mirror(component, sizes, focus):
    """Focus .5 is the middle of the axes: even and odd modes; .1 has no mirror."""
    grid = grid_of(focus, sizes)
    boundary = FieldBoundary((PERIODIC, VALUE, VALUE), staggered=component)
    unknowns = boundary.unknowns(grid)
    rng = np.random.default_rng(0)
    for d in range(3):
        basis = basis_for(grid, boundary, d)
        matrix = second_difference(grid.axes[d], boundary, d).dense()
        field = grid.zeros()
        view = field[unknowns]
        view[...] = rng.standard_normal(view.shape)
        before = view.copy()
        applied = np.moveaxis(np.tensordot(matrix, before, axes=(1, d)), 0, d)
        basis.forward(view, d)
        scaled = view * np.expand_dims(basis.eigenvalues, tuple(e for e in range(3) if e != d))
        basis.backward(view, d)
        # Round-off of sums of fourteen terms, and for −D times its largest entry.
        assert np.abs(view - before).max() < 1e-12
        view[...] = scaled
        basis.backward(view, d)
        assert np.abs(view - applied).max() < 1e-12 * np.abs(matrix).max()


def test_only_a_mirror_parts_even_from_odd_modes():
    """The lower half of the eigenvalues would be sorted if there were one kind of modes."""
    boundary = FieldBoundary((PERIODIC, VALUE, VALUE))
    for focus, parted in ((0.5, True), (0.1, False)):
        eigenvalues = basis_for(grid_of(focus), boundary, 1).eigenvalues
        assert (np.diff(eigenvalues) < 0.0).any() == parted


def test_the_same_bits_for_any_number_of_threads():
    from smoothprofile.threads import set_thread_count

    grid, found = grid_of(0.5, (20, 22, 24)), []
    boundary = FieldBoundary((PERIODIC, VALUE, VALUE))
    for threads in (1, 3):
        set_thread_count(threads)
        field = np.random.default_rng(1).standard_normal(grid.padded_shape)
        SeparableSolver(grid, boundary).solve(field, 1.0)
        found.append(field)
    assert np.array_equal(*found)


def test_the_order_of_a_sequence_is_found():
    h = np.array([0.4, 0.2, 0.15])
    p, limit = order(h, 3.0 + 2.0 * h**1.7)
    assert (p, limit) == (pytest.approx(1.7, abs=1e-9), pytest.approx(3.0, abs=1e-9))


def test_the_check_of_the_refined_duct_looks_at_the_cells_of_the_sphere():
    case = load_case("duct-refined")
    run = Simulation(case)
    rows = {row["name"]: row for row in checks(case, run.grid, run.pairing)}
    assert all(row["verdict"] == "ok" for row in rows.values())
    # 0.1 over the width within the core, 0.085; the widest cell of all is 1.8.
    assert rows["ξ/Δx"]["value"] == pytest.approx(1.177, abs=0.01)
    assert run.grid.axes[0].widths.max() > 15.0 * case.profile.thickness


def test_refined_cells_give_the_force_of_four_times_as_many():
    """A short march: early forces are as wrong on both meshes, and differ by what the mesh does."""
    changes = {"profile.thickness": 0.4, "time.step": 0.09, "time.end": 3.0}
    forces = []
    for mesh in (refined(20, 22), uniform(64, 24)):
        run = Simulation.from_file("duct", mesh.changes() | changes)
        run.run()
        forces.append(run.particles[0]["force"][0])
    # Each mesh errs by 1 to 2 % at this layer.
    assert forces[0] == pytest.approx(forces[1], rel=0.02)


@pytest.mark.slow
def test_every_number_of_the_study_agrees_and_refinement_pays():
    study = study_named("refinement")()
    assert study.agrees
    assert [picture.name for picture in study.pictures] == ["error", "layers", "mesh"]
    assert all(picture.png for picture in study.pictures)
    gains = [row.ours for row in study.rows if "uniform over refined" in row.quantity]
    fewer = [row.ours for row in study.rows if row.quantity.startswith("Uniform cells")]
    assert min(fewer) >= 4.0 and min(gains) >= 3.0


@pytest.mark.slow
def test_the_refined_duct_has_the_force_of_finite_elements():
    run = Simulation.from_file("duct-refined")
    run.run()
    # A layer of .1 at its best step leaves .1 %.
    assert run.particles[0]["force"][0] == pytest.approx(164.138, rel=2e-3)
    assert seconds_per_step([run])[0] > 0.0
