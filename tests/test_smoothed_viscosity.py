"""Flow of smoothed viscosity: the operator, closed forms, lattices, and what the solver reports."""

import math

import numpy as np
import pytest

from smoothprofile.boundaries import fill_ghosts
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.rotations import from_axis_angle
from smoothprofile.shapes import box, ellipsoid, sphere
from smoothprofile.solvers.krylov import dot
from smoothprofile.threads import set_thread_count, thread_count
from smoothprofile.viscous.direct import DirectStokes
from smoothprofile.viscous.smoothed_viscosity import effective_viscosity
from smoothprofile.viscous.smoothed_viscosity_bodies import mobility
from smoothprofile.viscous.smoothed_viscosity_medium import viscous_medium
from viscous_boxes import Drops, lattice, shear

SMOOTHINGS = ("arithmetic", "harmonic", "tensor")
CUBIC = {0.027: 2.00775, 0.064: 2.81020}
"""F/(6πμaU) of a simple cubic lattice of rigid spheres: Zick and Homsy (1982)."""
SHEARED = {0.01: 1.024813}
"""μ_eff/μ of that lattice in shear along its axes: multipole series."""


@pytest.fixture(autouse=True)
def one_thread():
    """In boxes as small as these, waking threads costs more than they work off."""
    before = thread_count()
    set_thread_count(1)
    yield
    set_thread_count(before)


def act(drops, values):
    """−∇·σ of face values (3,nx,ny,nz), as such."""
    field, out = (tuple(drops.grid.zeros() for _ in range(3)) for _ in range(2))
    for component, given in zip(field, values, strict=True):
        component[1:-1, 1:-1, 1:-1] = given
        fill_ghosts(component, drops.medium.boundary)
    drops.solver.stress.divergence(field, drops.medium, None, out)
    return np.array([component[1:-1, 1:-1, 1:-1] for component in out])


def drag(drops, fraction, tolerance=1e-3):
    """F/(6πμaU) over that of rigid spheres, less 1."""
    moved = mobility(drops.solver, drops.medium, drops.state, [[1.0, 0, 0]], None, tolerance)
    assert moved.report.converged
    return 1.0 / (6 * math.pi * moved.velocity[0, 0]) / CUBIC[fraction] - 1.0


@pytest.mark.parametrize("ratio", [1000.0, 0.001])
def test_operator_is_symmetric_and_positive(ratio):
    cells = (4, 5, 3)
    drops = Drops(
        cells, (1.0, 1.1, 0.9), [ellipsoid([0.36, 0.3, 0.25])], [[0.46, 0.5, 0.48]], ratio, 0.15,
        smoothing="tensor", retract=False, quaternions=[from_axis_angle([1, 2, 3], 0.7)],
    )  # fmt: skip
    n = 3 * math.prod(cells)
    matrix = np.array([act(drops, row.reshape(3, *cells)).ravel() for row in np.eye(n)])
    # Round-off of entries as large as the contrast.
    assert np.abs(matrix - matrix.T).max() < 1e-13 * np.abs(matrix).max()
    values = np.linalg.eigvalsh(matrix)
    # Three translations, and nothing softer than the softest fluid would be.
    drops.medium.cells[:] = 1.0
    for field in drops.medium.edges:
        field[:] = 1.0
    drops.medium.excess, drops.medium.place = np.zeros(0), np.zeros((0, 3), dtype=np.int64)
    plain = np.array([act(drops, row.reshape(3, *cells)).ravel() for row in np.eye(n)])
    least = np.linalg.eigvalsh(plain)[3]
    assert np.abs(values[:3]).max() < 1e-11 * values[-1]
    assert values[3] >= min(1.0, ratio) * least * (1 - 1e-9)


def test_a_turned_sphere_of_the_fluid_is_no_sphere():
    # The tensor of one viscosity is the usual stencil: the direct solve answers in one step.
    drops = lattice(sphere(1.0), 0.064, 12, 1.0, 0.3)
    rng = np.random.default_rng(1)
    force = tuple(drops.grid.zeros() for _ in range(3))
    for field in force:
        field[1:-1, 1:-1, 1:-1] = rng.standard_normal(drops.grid.shape)
    report = drops.solver.solve(drops.medium, force, None, 1e-10)
    assert report.iterations == 1 and report.converged
    velocity, pressure = tuple(drops.grid.zeros() for _ in range(3)), drops.grid.zeros()
    gradient = DirectStokes(drops.grid, 1.0).solve(force, velocity, pressure)
    inner = (slice(1, -1),) * 3
    # Round-off; numbers are of order one.
    for ours, exact in zip(drops.solver.velocity, velocity, strict=True):
        np.testing.assert_allclose(ours[inner], exact[inner], atol=1e-10)
    np.testing.assert_allclose(drops.solver.pressure[inner], pressure[inner], atol=1e-9)
    np.testing.assert_allclose(drops.solver.mean_gradient, gradient, atol=1e-13)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_layers_resist_as_in_series_and_side_by_side(axis):
    # A slab across the box: in shear across it stresses are the same, 1/μ_eff = ⟨1/μ⟩; in every
    # other strain the strain is, μ_eff = ⟨μ⟩. The tensor is exact in both, but for the tails of
    # tanh and the tolerance of the residual, which enters squared.
    ratio, share = 50.0, 0.4
    sides, centre = [10.0] * 3, [0.5] * 3
    sides[axis] = share
    n, b, c = "xyz"[axis], "xyz"[(axis + 1) % 3], "xyz"[(axis + 2) % 3]
    series = 1.0 / (1.0 - share * (1.0 - 1.0 / ratio))
    beside = 1.0 + share * (ratio - 1.0)
    exact = {n + b: series, c + n: series, b + c: beside, b + b: beside, n + n: beside}
    cells = [4, 4, 4]
    cells[axis] = 40
    found = {}
    for smoothing in SMOOTHINGS:
        drops = Drops(
            cells, (1.0, 1.0, 1.0), [box(sides)], [centre], ratio, 0.025,
            smoothing=smoothing, retract=False,
        )  # fmt: skip
        for pair in exact:
            value, report = effective_viscosity(drops.solver, drops.medium, shear(pair), 1e-6)
            assert report.converged
            found[smoothing, pair] = value / exact[pair] - 1.0
    assert all(abs(found["tensor", pair]) < 2e-4 for pair in exact)
    # Neither mean is right in both; ½ξ ln R on either side of .4 is 10 to 25 %.
    assert all(abs(found["harmonic", pair]) < 2e-4 for pair in (n + b, c + n))
    assert all(found["harmonic", pair] < -0.1 for pair in (b + c, b + b, n + n))
    assert all(abs(found["arithmetic", pair]) < 2e-4 for pair in (b + c, b + b, n + n))
    assert all(found["arithmetic", pair] > 0.1 for pair in (n + b, c + n))


@pytest.mark.parametrize("smoothing", SMOOTHINGS)
def test_power_is_dissipation(smoothing):
    drops = Drops(
        (16, 14, 12), (4.0, 3.5, 3.0), [sphere(0.8), ellipsoid([0.5, 0.4, 0.3])],
        [[1.0, 1.1, 0.9], [3.1, 2.3, 2.2]], 20.0, 0.25, smoothing=smoothing, retract=False,
        quaternions=[(1.0, 0, 0, 0), from_axis_angle([1, 0, 2], 0.5)],
    )  # fmt: skip
    loads = np.array([[[1.0, 0.5, 0], [0, 0.3, -1]], [[0.2, 0, 0.1], [0.05, -0.1, 0.2]]])
    moved = mobility(drops.solver, drops.medium, drops.state, *loads, 1e-8)
    power = (moved.velocity * loads[0]).sum() + (moved.angular_velocity * loads[1]).sum()
    out = tuple(drops.grid.zeros() for _ in range(3))
    drops.solver.stress.divergence(drops.solver.velocity, drops.medium, None, out)
    cell = drops.grid.volume / drops.grid.cell_count
    # The residual enters squared.
    assert dot(drops.solver.velocity, out) * cell == pytest.approx(power, rel=1e-9)
    assert power > 0.0
    # All forces together are the mean gradient, to round-off.
    total = drops.solver.mean_gradient * drops.grid.volume
    np.testing.assert_allclose(total, loads[0].sum(axis=0), atol=1e-12)
    for u, factor in zip(drops.solver.velocity, np.ones(3), strict=True):
        assert abs(u[1:-1, 1:-1, 1:-1].mean()) < 1e-13 * factor


def test_mobility_is_symmetric():
    drops = Drops(
        (16,) * 3, (4.0,) * 3, [sphere(0.8)] * 2, [[1.1, 1.0, 0.9], [2.9, 2.2, 2.5]], 100.0, 0.25
    )
    columns = []
    for body, kind, axis in ((0, 0, 0), (1, 0, 1), (0, 1, 2), (1, 1, 0)):
        loads = np.zeros((2, 2, 3))
        loads[kind, body, axis] = 1.0
        moved = mobility(drops.solver, drops.medium, drops.state, *loads, 1e-7)
        rows = np.array([moved.velocity, moved.angular_velocity])
        columns.append([rows[k, b, a] for b, k, a in ((0, 0, 0), (1, 0, 1), (0, 1, 2), (1, 1, 0))])
    matrix = np.array(columns)
    # The tolerance of the residual, to first order off the diagonal.
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-6)
    assert np.linalg.eigvalsh(0.5 * (matrix + matrix.T)).min() > 0.0


@pytest.mark.parametrize(("smoothing", "most"), [("tensor", 0.01), ("harmonic", 0.02)])
def test_drag_of_a_lattice_of_stiff_spheres(smoothing, most):
    # ξ = .2a and cells of .17a; measured .76 and −1.7 %, mostly the layers' (6 % beside, ξ = .1a).
    drops = lattice(sphere(1.0), 0.064, 24, 1000.0, 0.2, smoothing=smoothing)
    assert abs(drag(drops, 0.064)) < most


@pytest.mark.parametrize("smoothing", ["tensor", "harmonic"])
def test_torque_of_a_lattice_of_stiff_spheres(smoothing):
    options = {"smoothing": smoothing, "retract": "torque"}
    drops = lattice(sphere(1.0), 0.03, 28, 1000.0, 0.2, **options)
    torque = [[0.0, 0.0, 1.0]]
    moved = mobility(drops.solver, drops.medium, drops.state, [[0.0] * 3], torque, 1e-3)
    # T/(8πμa³Ω) of rigid spheres that turn in step, by multipoles. Measured under .3 %.
    found = 1.0 / (8 * math.pi * moved.angular_velocity[0, 2])
    assert found == pytest.approx(1.030945, rel=0.01)
    # They turn, and go nowhere; as painted the harmonic one is 13 % off.
    assert np.abs(moved.velocity).max() < 1e-4 * moved.angular_velocity[0, 2]


def test_without_retraction_the_drag_is_far_off():
    # The layer is stiff from R φ ~ 1 on: as painted ½ξ ln R larger, or a little softer.
    for smoothing, low, high in (("tensor", 1.5, 2.2), ("harmonic", -0.25, -0.1)):
        options = {"smoothing": smoothing, "retract": False}
        drops = lattice(sphere(1.0), 0.064, 20, 1000.0, 0.2, **options)
        assert low < drag(drops, 0.064) < high


@pytest.mark.slow
def test_drag_of_a_lattice_at_a_tenth_of_the_radius():
    # R = 1000, ξ = .1a: within 3 %, and of order 1.6 as painted. Measured .70 %, 1.9 and 1.7.
    painted = []
    for xi, cells in ((0.2, 24), (0.1, 48), (0.05, 88)):
        options = {"smoothing": "tensor", "retract": False}
        painted.append(drag(lattice(sphere(1.0), 0.064, cells, 1000.0, xi, **options), 0.064))
    orders = np.log2(np.array(painted[:-1]) / painted[1:])
    assert np.all(orders > 1.6)
    for smoothing in ("tensor", "harmonic", "arithmetic"):
        drops = lattice(sphere(1.0), 0.064, 48, 1000.0, 0.1, smoothing=smoothing)
        assert abs(drag(drops, 0.064)) < 0.01


@pytest.mark.parametrize(("ratio", "smoothing"), [(10.0, "tensor"), (1000.0, "harmonic")])
def test_effective_viscosity(ratio, smoothing):
    drops = lattice(
        sphere(1.0), 0.01, 40, ratio, 0.2, smoothing=smoothing, retract="stresslet"
    )  # fmt: skip
    found, _ = effective_viscosity(drops.solver, drops.medium, shear("xy"), 1e-3)
    # S of a lone drop over a rigid one's scales the lattice's, to c² of it; cells of .19a and
    # the layer leave a hundredth.
    exact = (SHEARED[0.01] - 1.0) * 2 * (ratio - 1) / (2 * ratio + 3)
    assert found - 1.0 == pytest.approx(exact, rel=0.02)


def test_an_effective_viscosity_without_strain_is_refused():
    drops = lattice(sphere(1.0), 0.1, 12, 10.0, 0.3)
    with pytest.raises(CaseError, match="the mean strain is 0"):
        effective_viscosity(drops.solver, drops.medium, np.zeros((3, 3)))


def test_the_inside_of_a_stiff_sphere_is_rigid():
    # Of a sharp drop the strain inside is 5E/(2R + 3), here .0025E; the painted one is smaller and
    # strained a little more.
    drops = lattice(sphere(1.0), 0.02, 24, 1000.0, 0.2, retract="stresslet")
    drops.solver.solve(drops.medium, None, shear("xy"), 1e-4)
    u, v, _ = drops.solver.velocity
    i, rate = 12, 24 / drops.grid.lengths[0]
    inside = 1.0 + rate * (u[i, i + 1, i] - u[i, i, i] + v[i + 1, i, i] - v[i, i, i])
    assert 0.0 < inside < 0.01


def test_few_iterations_at_any_contrast():
    # Measured 6, 18, 23; without the scale 18, 151, 268.
    for ratio, most in ((10.0, 9), (1e3, 24), (1e4, 30)):
        drops = lattice(sphere(1.0), 0.064, 20, ratio, 0.2, smoothing="harmonic")
        moved = mobility(drops.solver, drops.medium, drops.state, [[1.0, 0, 0]], None, 1e-4)
        assert moved.report.converged and moved.report.iterations <= most
        again = mobility(drops.solver, drops.medium, drops.state, [[1.0, 0, 0]], None, 1e-4)
        assert again.report.iterations <= 1


def test_no_bit_depends_on_threads():
    found = []
    for threads in (1, 2):
        set_thread_count(threads)
        drops = lattice(sphere(1.0), 0.064, 12, 30.0, 0.35, smoothing="tensor")
        mobility(drops.solver, drops.medium, drops.state, [[1.0, 0, 0]], None, 1e-3)
        found.append(np.array(drops.solver.velocity))
    assert np.array_equal(*found)


def test_a_solve_that_is_cut_short_says_so():
    drops = lattice(sphere(1.0), 0.064, 12, 100.0, 0.3)
    report = drops.solver.solve(drops.medium, None, shear("xy"), 1e-8, limit=3)
    assert (report.iterations, report.status) == (3, "iteration limit")


def test_refusals():
    grid = Grid(tuple(uniform_axis(n, 0.0, 4.0, 8, True) for n in "xyz"))
    ball = sphere(2.0)
    walled = Grid((*grid.axes[:2], uniform_axis("z", 0.0, 4.0, 8, False)))
    for said, arguments in {
        "periodic box": (walled, [ball], [10.0]),
        "above 0": (grid, [ball], [-1.0]),
        "1 bodies have 2": (grid, [ball], [1.0, 2.0]),
    }.items():
        with pytest.raises(CaseError, match=said):
            viscous_medium(*arguments)
    with pytest.raises(CaseError, match="arithmetic"):
        viscous_medium(grid, [ball], [10.0], smoothing="geometric")
    drops = lattice(sphere(1.0), 0.064, 8, 10.0, 0.4)
    with pytest.raises(CaseError, match="trace"):
        drops.solver.solve(drops.medium, None, np.eye(3))
    with pytest.raises(CaseError, match="3 × 3"):
        drops.solver.solve(drops.medium, None, np.full((3, 3), np.nan))
