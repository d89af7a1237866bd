"""The potential: symmetry and sign of the operator, closed forms, lattices, solver reports."""

import numpy as np
import pytest

from dielectrics import LATTICES, Box, cube, lattice_radius
from flows import slope
from smoothprofile.boundaries import fill_ghosts
from smoothprofile.electric.operator import apply
from smoothprofile.electric.potential import PotentialSolver, electrode_field, potential_boundary
from smoothprofile.electric.response import effective_permittivity
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.rotations import from_axis_angle
from smoothprofile.shapes import box, cylinder, ellipsoid, sphere
from smoothprofile.threads import set_thread_count


def act(case, values):
    field, out = case.grid.zeros(), case.grid.zeros()
    field[1:-1, 1:-1, 1:-1] = values
    fill_ghosts(field, case.solver.boundary)
    apply(field, (0, 0, 0), 1.0, case.medium, case.solver.geometry, out)
    return out[1:-1, 1:-1, 1:-1]


def dense(case):
    n = case.grid.cell_count
    columns = np.eye(n).reshape(n, *case.grid.shape)
    return np.array([act(case, column).ravel() for column in columns])


@pytest.mark.parametrize("ratio", [0.3, 0.75])
@pytest.mark.parametrize("permittivity", [1000.0, 0.001])
@pytest.mark.parametrize("electrodes", [None, 0])
def test_operator_is_symmetric_and_positive_definite(permittivity, ratio, electrodes):
    case = Box(
        (6, 6, 6), (1.0, 1.1, 0.9), [ellipsoid([0.36, 0.3, 0.25])], [permittivity], ratio=ratio,
        electrodes=electrodes, walled=() if electrodes is None else (0, 1),
    )  # fmt: skip
    case.at([[0.46, 0.5, 0.48]], (0, 0, 0), [from_axis_angle([1, 2, 3], 0.7)])
    matrix = dense(case)
    # Round-off of entries as large as the contrast.
    assert np.abs(matrix - matrix.T).max() < 1e-13 * np.abs(matrix).max()
    values = np.linalg.eigvalsh(matrix)
    if electrodes is None:
        # One constant mode; the next is that of the least permittivity anywhere, less nothing.
        assert abs(values[0]) < 1e-12 * values[-1]
        values = values[1:]
    empty = Box((6, 6, 6), (1.0, 1.1, 0.9), [], [], electrodes=electrodes,
                walled=() if electrodes is None else (0, 1))  # fmt: skip
    empty.at(np.zeros((0, 3)), (0, 0, 0))
    least = np.linalg.eigvalsh(dense(empty))[0 if electrodes is not None else 1]
    # ε ≥ min(1, ε₁) in every direction, in each term of the energy.
    assert values[0] >= min(1.0, permittivity) * least * (1 - 1e-9)


def test_residual_is_minus_the_gradient_of_the_energy():
    case = cube(8, 1.0, [sphere(0.3)], [20.0]).at([[0.47, 0.52, 0.5]], (0.3, -1.0, 0.4))
    rng = np.random.default_rng(1)
    psi = case.solver.potential
    psi[1:-1, 1:-1, 1:-1] = rng.normal(size=case.grid.shape)
    fill_ghosts(psi, case.solver.boundary)
    out = case.grid.zeros()
    apply(psi, case.field, -1.0, case.medium, case.solver.geometry, out)
    way = rng.normal(size=case.grid.shape)
    start, step, energies = psi[1:-1, 1:-1, 1:-1].copy(), 1e-3, []
    for side in (1, -1):
        psi[1:-1, 1:-1, 1:-1] = start + side * step * way
        fill_ghosts(psi, case.solver.boundary)
        energies.append(case.energy)
    slope = (energies[0] - energies[1]) / (2 * step)
    # W is quadratic: the difference is exact to round-off over the step.
    assert slope == pytest.approx(-(out[1:-1, 1:-1, 1:-1] * way).sum(), rel=1e-10)


@pytest.mark.parametrize("smoothing", ["tensor", "arithmetic", "harmonic"])
def test_slabs_in_series_and_parallel(smoothing):
    """ε_eff of a slab of half the box: 1/⟨1/ε⟩ across it and ⟨ε⟩ along it."""
    case = Box((32, 4, 4), (1.0, 0.125, 0.125), [box([0.5, 9.0, 9.0])], [10.0],
               ratio=1.0, smoothing=smoothing, tolerance=1e-12)  # fmt: skip
    case.at([[0.5, 0.0625, 0.0625]])
    tensor, _ = effective_permittivity(case.solver, case.medium, 1e-12)
    series, parallel = 2 / (1 + 0.1), 0.5 * (1 + 10)
    # φ sums to its integral to e^(−π²ξ/Δx) ≈ 5e-5 of a cell (trapezoidal rule on tanh) or better;
    # the fluid's side is 16 cells wide.
    exact = {"arithmetic": (False, True), "harmonic": (True, False), "tensor": (True, True)}
    for d, value, holds in zip((0, 1, 2), (series, parallel, parallel),
                               (*exact[smoothing], exact[smoothing][1]), strict=True):  # fmt: skip
        error = abs(tensor[d, d] / value - 1)
        assert error < 1e-4 if holds else error > 0.02


@pytest.mark.parametrize(("permittivity", "fraction"), LATTICES)
def test_cubic_lattices(permittivity, fraction):
    case = cube(32, 1.0, [sphere(lattice_radius(fraction))], [permittivity], profile="sine",
                ratio=2.0, tolerance=1e-6)  # fmt: skip
    found = 2 * case.at([[0.5, 0.5, 0.5]]).energy
    # Second order in ξ ∝ Δx: .1 % at 64 cells, .43 % here; the arithmetic mean is off by 15 %.
    assert found == pytest.approx(LATTICES[permittivity, fraction], rel=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize(("permittivity", "fraction"), LATTICES)
@pytest.mark.parametrize(("cells", "allowed"), [(64, 4e-3), (128, 1e-3)])
def test_fine_cubic_lattices(permittivity, fraction, cells, allowed):
    case = cube(cells, 1.0, [sphere(lattice_radius(fraction))], [permittivity], tolerance=1e-6)
    found = 2 * case.at([[0.5, 0.5, 0.5]]).energy
    assert found == pytest.approx(LATTICES[permittivity, fraction], rel=allowed)


def test_order_in_the_thickness():
    """ξ ∝ Δx: the tensor's error falls as ξ², the arithmetic mean's as ξ."""
    orders = {}
    for smoothing in ("tensor", "arithmetic"):
        errors = []
        for cells in (16, 32, 64):
            case = cube(cells, 1.0, [sphere(lattice_radius(0.2))], [10.0], smoothing=smoothing,
                        tolerance=1e-7)  # fmt: skip
            errors.append(2 * case.at([[0.5, 0.5, 0.5]]).energy / LATTICES[10, 0.2] - 1)
        orders[smoothing] = slope([1.0, 0.5, 0.25], errors)
    assert orders["tensor"] >= 1.8
    assert 0.8 < orders["arithmetic"] < 1.4


def test_square_array_of_cylinders():
    case = Box((64, 64, 3), (1.0, 1.0, 0.05), [cylinder(np.sqrt(0.3 / np.pi))], [10.0])
    tensor, _ = effective_permittivity(case.at([[0.51, 0.5, 0.0]]).solver, case.medium, 1e-7)
    # Second order, .2 % here; along the axis the mean is exact to that of the painted area.
    assert tensor[0, 0] == pytest.approx(1.6520360, rel=5e-3)
    assert tensor[1, 1] == pytest.approx(tensor[0, 0], rel=1e-3)
    assert tensor[2, 2] == pytest.approx(1 + 9 * 0.3, rel=2e-3)


def test_coated_sphere_acts_as_its_equivalent():
    """A core laid over the solid of its shell; the same dipole as ε = 5.597938."""
    length, middle = 4.0, [2.0, 2.0, 2.0]
    coated = cube(48, length, [sphere(1.0), sphere(0.8)], [3.0, 10.0], profile="sine", ratio=2.0)
    plain = cube(48, length, [sphere(1.0)], [5.597938], profile="sine", ratio=2.0)
    first, second = coated.at([middle, middle]).loads.dipole, plain.at([middle]).loads.dipole
    # The shell is 2.4 cells thick, and a sine layer of two cells lies on both its faces.
    assert first.sum(axis=0)[0] == pytest.approx(second[0, 0], rel=0.02)


@pytest.mark.parametrize("sides", ["periodic", "flux"])
def test_electrodes_with_a_slab_between(sides):
    walled = (0,) if sides == "periodic" else (0, 1, 2)
    case = Box((32, 4, 4), (1.0, 0.2, 0.3), [box([0.5, 9.0, 9.0])], [4.0], ratio=1.0,
               electrodes=0, walled=walled, tolerance=1e-12)  # fmt: skip
    field = electrode_field(case.grid, 0, 3.0, 1.0)
    assert field == (2.0, 0.0, 0.0)
    case.at([[0.5, 0.1, 0.15]], field)
    mean = case.solver.mean_displacement(case.medium, field)
    # 1/⟨1/ε⟩ = 1.6, exact to the sum of φ over the cells.
    assert mean == pytest.approx([2.0 * 1.6, 0.0, 0.0], rel=1e-5, abs=1e-9)


def test_a_lattice_between_electrodes_is_a_periodic_one():
    """One sphere between mirrors: electrodes and zero flux continue the lattice."""
    options = {"profile": "sine", "ratio": 2.0, "tolerance": 1e-9}
    shapes = [sphere(0.3)]
    walls = cube(16, 1.0, shapes, [10.0], electrodes=0, walled=(0, 1, 2), **options)
    box_ = cube(16, 1.0, shapes, [10.0], **options)
    energies = [case.at([[0.5, 0.5, 0.5]]).energy for case in (walls, box_)]
    # The same discrete problem: only the residual differs, which enters squared.
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)


def test_solution_is_linear_and_turns_with_the_box():
    case = cube(12, 1.0, [sphere(0.3)], [30.0], tolerance=1e-11)
    one = case.at([[0.5, 0.5, 0.5]], (1.0, 0.0, 0.0)).solver.potential.copy()
    case.solver.potential[:] = 0.0
    two = case.at([[0.5, 0.5, 0.5]], (0.0, -2.0, 0.0)).solver.potential.copy()
    core = (slice(1, -1),) * 3
    scale = np.abs(one[core]).max()
    assert np.abs(two[core] + 2 * np.moveaxis(one[core], 0, 1)).max() < 1e-9 * scale


@pytest.mark.parametrize("permittivity", [1000.0, 0.001])
def test_high_contrast_converges(permittivity):
    case = cube(32, 1.0, [sphere(lattice_radius(0.3))], [permittivity], tolerance=1e-8)
    report = case.at([[0.5, 0.5, 0.5]]).report
    # Plain Fourier preconditioning takes more than 200.
    assert report.status == "converged" and report.residual <= 1e-7
    assert report.iterations < 60


def test_warm_start_and_preconditioners_agree():
    values = []
    for kind in ("fourier", "scaled", "smoothed"):
        case = cube(16, 1.0, [sphere(0.3)], [10.0], preconditioner=kind, tolerance=1e-10)
        values.append(case.at([[0.5, 0.48, 0.5]]).energy)
        assert case.at([[0.5, 0.48, 0.5]]).report.iterations <= 1
    # Energies are second order in a residual of 1e-10.
    assert np.ptp(values) < 1e-12


def test_same_bits_for_any_number_of_threads():
    found = []
    for threads in (1, 3):
        set_thread_count(threads)
        case = cube(18, 1.0, [sphere(0.3), sphere(0.2)], [50.0, 3.0])
        case.at([[0.4, 0.5, 0.5], [0.9, 0.45, 0.5]])
        found.append((case.solver.potential.copy(), case.loads.force))
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])


def test_nothing_to_solve_without_bodies():
    case = cube(6, 1.0, [], [], tolerance=1e-8).at(np.zeros((0, 3)))
    assert case.report.iterations == 0
    assert case.energy == pytest.approx(0.5, rel=1e-14)


def test_bad_input_is_refused_in_one_sentence():
    periodic = Grid(tuple(uniform_axis(n, 0.0, 1.0, 4, True) for n in "xyz"))
    walled = Grid(tuple(uniform_axis(n, 0.0, 1.0, 4, n != "x") for n in "xyz"))
    with pytest.raises(CaseError, match="electrodes stand on the y axis, which is periodic"):
        potential_boundary(periodic, 1)
    with pytest.raises(CaseError, match="preconditioner is 'magic'"):
        PotentialSolver(periodic, preconditioner="magic")
    with pytest.raises(CaseError, match="permittivity is -2"):
        cube(4, 1.0, [sphere(0.2)], [-2.0])
    with pytest.raises(CaseError, match="smoothing is 'linear'"):
        cube(4, 1.0, [sphere(0.2)], [2.0], smoothing="linear")
    with pytest.raises(CaseError, match="component along x"):
        case = Box((4, 4, 4), (1, 1, 1), [], [], walled=(0,))
        case.at(np.zeros((0, 3)), (1.0, 0.0, 0.0))
    solver = PotentialSolver(walled)
    with pytest.raises(CaseError, match="three periodic axes"):
        effective_permittivity(solver, Box((4,) * 3, (1,) * 3, [], [], walled=(0,)).medium)
