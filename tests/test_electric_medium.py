"""The permittivity as it is painted by default: the recommendation of the study `profiles`."""

import numpy as np
import pytest
import trimesh

from dielectrics import UPRIGHT, lattice_radius
from smoothprofile import calibration, shapes
from smoothprofile.electric.medium import CELLS, dielectric_medium, surface_offset
from smoothprofile.electric.potential import PotentialSolver
from smoothprofile.electric.response import effective_permittivity
from smoothprofile.errors import CaseError
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.particles.bodies import bodies_at
from smoothprofile.triangles import load_surface


def unit_cube(cells):
    return Grid(tuple(uniform_axis(name, 0.0, 1.0, cells, True) for name in "xyz"))


def lattice(fraction, ratio, **options):
    """ε_eff of a simple cubic lattice on 32³ cells, its sphere between grid points."""
    grid = unit_cube(32)
    medium = dielectric_medium(grid, [shapes.sphere(lattice_radius(fraction))], [ratio], **options)
    solver = PotentialSolver(grid)
    medium.paint(bodies_at([[0.508, 0.508, 0.508]], [UPRIGHT]), solver.scratch)
    tensor, reports = effective_permittivity(solver, medium, 1e-6, 200)
    assert all(report.status == "converged" for report in reports)
    return np.diag(tensor).mean()


@pytest.mark.parametrize(
    ("fraction", "ratio", "exact", "error"),
    [(0.2, 2.0, 1.1579717, 2e-4), (0.2, 10.0, 1.5317239, 1e-3), (0.3, 100.0, 2.2745674, 9e-3)],
)
def test_lattices_by_default(fraction, ratio, exact, error):
    """Multipole series; errors as `spm study profiles` measures them, .002, .06 and .74 %."""
    assert lattice(fraction, ratio) == pytest.approx(exact, rel=error)


def test_retraction_and_the_tensor_earn_their_place():
    errors = [
        abs(lattice(0.2, 10.0, **options) / 1.5317239 - 1)
        for options in ({}, {"retract": False}, {"retract": False, "smoothing": "arithmetic"})
    ]
    assert 5 * errors[0] < errors[1]
    assert 5 * errors[1] < errors[2]


def test_the_default_layer_is_as_recommended():
    medium = dielectric_medium(unit_cube(16), [shapes.sphere(0.3)], [4.0])
    assert (medium.profile.name, medium.smoothing) == ("tanh", "tensor")
    assert medium.thickness == pytest.approx(CELLS / 16)
    offset = calibration.dielectric_radius(0.3, CELLS / 16, 4.0) - 0.3
    assert medium.forms.offset[0] == pytest.approx([offset, 0.0])


def test_offsets_of_other_shapes_follow_their_curvature():
    """A cylinder's is its own, 1/a; a box's is zero for the tensor and a centred profile."""
    flat, curved = calibration.dielectric_offset(0.5, 0.05, 10.0)
    (cylinder,) = shapes.cylinder(0.5, 2.0).parts
    assert surface_offset(cylinder, 0.05, 10.0, "tanh", "tensor") == pytest.approx(
        (flat + 2.0 * curved, 0.0)
    )
    (ellipsoid,) = shapes.ellipsoid([0.5, 0.5, 0.5]).parts
    assert surface_offset(ellipsoid, 0.05, 10.0, "tanh", "tensor") == pytest.approx((flat, curved))
    (box,) = shapes.box([1.0, 1.0, 1.0]).parts
    assert surface_offset(box, 0.05, 10.0, "tanh", "tensor") == pytest.approx((0.0, 0.0), abs=1e-12)


def test_bad_permittivities_are_refused():
    ball = [shapes.sphere(0.3)]
    for value in (0.0, -1.0, np.nan, np.inf):
        with pytest.raises(CaseError, match="a permittivity is"):
            dielectric_medium(unit_cube(8), ball, [value])
        with pytest.raises(CaseError, match="a permittivity is"):
            dielectric_medium(unit_cube(8), ball, [2.0], fluid=value)
    for value in (0.0, -1.0, np.nan):
        with pytest.raises(CaseError, match=r"electric\.thickness is"):
            dielectric_medium(unit_cube(8), ball, [2.0], thickness=value)
    with pytest.raises(CaseError, match="1 bodies have 2 permittivities"):
        dielectric_medium(unit_cube(8), ball, [2.0, 3.0])


def test_a_field_that_is_no_number_is_refused():
    grid = unit_cube(8)
    solver, medium = PotentialSolver(grid), dielectric_medium(grid, [shapes.sphere(0.3)], [2.0])
    with pytest.raises(CaseError, match="mean field along y is nan"):
        solver.solve(medium, (1.0, np.nan, 0.0))


def test_a_mesh_has_no_permittivity(tmp_path):
    """Its distance is sampled where it is painted for the flow; here it would be no number."""
    trimesh.creation.box((0.5, 0.5, 0.5)).export(tmp_path / "box.stl")
    block = shapes.mesh(load_surface(tmp_path / "box.stl"))
    with pytest.raises(CaseError, match="triangulated surface"):
        dielectric_medium(unit_cube(8), [block], [4.0])


@pytest.mark.parametrize("smoothing", ["tensor", "harmonic"])
def test_a_core_is_painted_for_what_is_around_it(smoothing):
    """ε = 10 in a shell of 3 in a fluid of 1: the core's contrast is 10/3."""
    spheres = [shapes.sphere(0.4), shapes.sphere(0.3)]
    plain, told = (
        dielectric_medium(unit_cube(16), spheres, [3.0, 10.0], smoothing=smoothing, around=around)
        for around in (None, [1.0, 3.0])
    )
    xi = CELLS / 16
    for medium, contrast in ((plain, 10.0), (told, 10.0 / 3.0)):
        core = surface_offset(spheres[1].parts[0], xi, contrast, "tanh", smoothing)
        assert medium.forms.offset[1] == pytest.approx(core, abs=1e-12)
        shell = surface_offset(spheres[0].parts[0], xi, 3.0, "tanh", smoothing)
        assert medium.forms.offset[0] == pytest.approx(shell, abs=1e-12)
