"""Preconditioners of the potential: their parts against A itself, and what they save."""

import numpy as np
import pytest

from dielectrics import UPRIGHT, Box, cube, lattice_radius
from smoothprofile.boundaries import fill_ghosts
from smoothprofile.electric.conductors import Conductors
from smoothprofile.electric.operator import apply
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.electric.preconditioner import Preconditioning
from smoothprofile.electric.stencil import LayerStencil
from smoothprofile.grid import Grid, stretched_axis, uniform_axis
from smoothprofile.particles.bodies import bodies_at
from smoothprofile.shapes import sphere
from smoothprofile.threads import available_threads, set_thread_count

CORE = (slice(1, -1),) * 3


def scene(permittivity, **options):
    """Two bodies, one across the low x side; walls on z."""
    shapes, places = [sphere(0.3), sphere(0.22)], [[0.1, 0.5, 0.52], [0.62, 0.5, 0.5]]
    case = Box((12, 11, 13), (1.0, 0.9, 1.1), shapes, permittivity, walled=(2,), **options)
    return case.at(places, (1.0, 0.4, 0.0))


@pytest.mark.parametrize("smoothing", ["tensor", "arithmetic"])
def test_stencil_is_the_operator_on_its_cells(smoothing):
    case = scene([500.0, 20.0], smoothing=smoothing)
    layer = LayerStencil.of(case.medium, case.solver.geometry, 5.0)
    psi, image, rest = (case.grid.zeros() for _ in range(3))
    psi[CORE] = np.random.default_rng(1).normal(size=case.grid.shape)
    fill_ghosts(psi, case.solver.boundary)
    apply(psi, (0, 0, 0), 1.0, case.medium, case.solver.geometry, image)
    counts = []
    for cells in (layer.inside, layer.around):
        rest[:] = np.nan
        layer.residual(np.zeros_like(psi), psi, cells, rest)
        found = np.isfinite(rest)
        counts.append(found.sum())
        # Coefficients of single precision.
        assert np.abs(rest + image)[found].max() < 1e-6 * np.abs(image).max()
    assert 0 < counts[0] < counts[1] < case.grid.cell_count


@pytest.mark.parametrize("kind", ["scaled", "smoothed"])
def test_preconditioner_is_symmetric_and_positive_definite(kind):
    case = scene([900.0, 0.002])
    inverse = Preconditioning(case.grid, case.solver.boundary, case.solver.geometry, kind)
    inverse.prepare(case.medium)
    rng, fields, images = np.random.default_rng(2), [], []
    for _ in range(6):
        residual, image = case.grid.zeros(), case.grid.zeros()
        residual[CORE] = rng.normal(size=case.grid.shape)
        residual[CORE] -= residual[CORE].mean()
        inverse(residual, image)
        fields.append(residual[CORE].ravel())
        images.append(image[CORE].ravel())
    products = np.array(fields) @ np.array(images).T
    # Of the stencil's single precision.
    assert np.abs(products - products.T).max() < 1e-5 * np.abs(products).max()
    assert np.linalg.eigvalsh(products).min() > 0.0


def test_a_constant_is_corrected_in_one_go():
    """C A w = w for bodies apart, one of them across two sides of the box."""
    case = cube(20, 1.0, [sphere(0.15)] * 2, [900.0, 40.0], ratio=0.5)
    case.at([[0.02, 0.5, 0.97], [0.55, 0.5, 0.5]])
    conductors = Conductors.of(case.medium, case.solver.boundary, case.solver.geometry, 30.0)
    for body in (0, 1):
        one, image, out = (case.grid.zeros() for _ in range(3))
        conductors._spread((conductors.body == body).astype(float), one)
        # A sphere of radius .15 + 1.5ξ, 4π/3 a³(1 + π²ξ²/4a²), sampled on 3.7 cells to a.
        assert one[CORE].mean() == pytest.approx(0.02882, rel=5e-3)
        fill_ghosts(one, case.solver.boundary)
        apply(one, (0, 0, 0), 1.0, case.medium, case.solver.geometry, image)
        conductors.correct(image, out)
        # Cells of the tail left out of w, and w in single precision.
        assert np.abs(out - one)[CORE].max() < 1e-4
    assert Conductors.of(case.medium, case.solver.boundary, case.solver.geometry, 1e3) is None


@pytest.mark.parametrize("ratio", [1000.0, 0.001])
@pytest.mark.parametrize(
    ("cells", "most"), [(32, 45), pytest.param(64, 45, marks=pytest.mark.slow)]
)
def test_high_contrast_iterations(ratio, cells, most):
    """28 to 37 at 64 cells; with the scaled direct solve alone 83 to 96."""
    case = cube(cells, 1.0, [sphere(lattice_radius(0.3))], [ratio], tolerance=1e-8)
    report = case.at([[0.508, 0.5, 0.5]]).report
    assert report.status == "converged" and report.iterations < most


def test_many_conductors_cost_few_iterations():
    """27 spheres, each with a constant of its own: without C two to three times as many."""
    rng = np.random.default_rng(4)
    knots = (np.indices((3, 3, 3)).reshape(3, -1).T + 0.5) / 3
    places = knots + rng.uniform(-0.03, 0.03, knots.shape)
    for kind, most in (("scaled", 120), ("smoothed", 80)):
        case = cube(36, 1.0, [sphere(0.12)] * 27, [1000.0] * 27, preconditioner=kind)
        report = case.at(places, (0.3, -0.2, 1.0)).report
        assert report.status == "converged" and report.iterations < most


@pytest.mark.parametrize("ratio", [1000.0, 0.001])
def test_stretched_cells_between_electrodes(ratio):
    """Cells up to five times wider one way: the bound on the eigenvalues must hold there too."""
    y = stretched_axis("y", 0.0, 1.0, 28, False, 0.1, 5.0)
    grid = Grid((uniform_axis("x", 0.0, 1.0, 24, True), y, uniform_axis("z", 0.0, 1.0, 24, True)))
    energies = []
    for kind in ("scaled", "smoothed"):
        case = cube(4, 1.0, [sphere(0.25)], [ratio])
        case.grid, case.solver = grid, PotentialSolver(grid, 1, kind)
        case.medium = type(case.medium)(
            grid, case.medium.forms, [ratio], 1.0, case.medium.profile, 0.04
        )
        case.at([[0.5, 0.45, 0.5]], (0.0, 1.0, 0.0), [UPRIGHT])
        assert case.report.status == "converged" and case.report.iterations < 150
        energies.append(case.energy)
    # Second order in a residual of 1e-8.
    assert energies[0] == pytest.approx(energies[1], rel=1e-11)


def test_smoothed_has_the_same_bits_for_any_number_of_threads():
    found = []
    for threads in (1, min(3, available_threads())):
        set_thread_count(threads)
        case = cube(18, 1.0, [sphere(0.3), sphere(0.2)], [900.0, 500.0])
        case.at([[0.4, 0.5, 0.5], [0.9, 0.45, 0.5]])
        found.append(case.solver.potential.copy())
    set_thread_count(available_threads())
    assert np.array_equal(*found)


def test_positions_do_not_follow_the_caller():
    """The medium keeps where it was painted, not an array that moves on."""
    case = cube(12, 1.0, [sphere(0.3)], [900.0])
    state = bodies_at([[0.4, 0.5, 0.5]], [UPRIGHT])
    case.medium.paint(state, case.solver.scratch)
    state.position[:] = 0.0
    assert case.medium.position[0] == pytest.approx([0.4, 0.5, 0.5])
