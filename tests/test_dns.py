"""Body-fitted finite elements: against closed forms, what breaks them, and the study."""

import math

import numpy as np
import pytest

from smoothprofile import body_fitted, studies
from smoothprofile.body_fitted.facets import outline, places, small_triangles
from smoothprofile.body_fitted.ladder import limit_of
from smoothprofile.errors import BlowUpError, CaseError

SENTENCE = "finite elements need ngsolve: pip install 'smoothprofile[dns]'."


@pytest.fixture(scope="module")
def elements():
    """The files that need ngsolve."""
    pytest.importorskip("ngsolve")
    from smoothprofile.body_fitted import flow, meshes, problems

    return flow, meshes, problems


@pytest.fixture(scope="module")
def shell(elements):
    """An eighth of the fluid between a sphere at rest and one of twice its radius, 45 cells."""
    flow, meshes, _ = elements
    import netgen.occ as occ
    import ngsolve

    outer = occ.Sphere((0, 0, 0), 2.0)
    outer.faces.name = "wall"
    box = occ.Box((0, 0, 0), (4, 4, 4))
    for axis, name in ((occ.X, "end"), (occ.Y, "y"), (occ.Z, "z")):
        box.faces.Min(axis).name = name
    inner = occ.Sphere((0, 0, 0), 1.0)
    inner.faces.name = "sphere"
    mesh = ngsolve.Mesh(occ.OCCGeometry(outer * box - inner).GenerateMesh(maxh=1.0, grading=0.4))
    mesh.Curve(meshes.CURVED)
    return lambda order, **other: flow.FiniteElements(mesh, order, **other)


def in_a_shell(ratio):
    """Drag over 6πμaU on a sphere in a concentric one, λ = `ratio` of their radii."""
    l = ratio
    return (1 - l**5) / (1 - 9 * l / 4 + 5 * l**3 / 2 - 9 * l**5 / 4 + l**6)


def test_a_geometric_sequence_is_extrapolated_exactly():
    value, error = limit_of([9.0, 1 + 2.0, 1 + 0.2, 1 + 0.02])
    assert value == pytest.approx(1.0, abs=1e-14)
    assert error == pytest.approx(0.02, abs=1e-14)


@pytest.mark.parametrize("values", [[1.0, 2.0, 3.0], [1.0, 2.0, 1.5], [1.0, 1.1, 2.0]])
def test_what_does_not_close_in_is_not_extrapolated(values):
    found = limit_of(values)
    assert found.value == values[-1]
    assert found.error >= abs(values[-1] - values[-2])


def test_two_values_have_no_limit():
    with pytest.raises(ValueError, match="three are needed"):
        limit_of([1.0, 2.0])


@pytest.mark.parametrize("steps", [1, 2, 5])
def test_a_facet_is_covered_once(steps):
    x, y = places(steps).T
    corners = np.stack([x, y], axis=-1)[small_triangles(steps)]
    a, b = (corners[:, i] - corners[:, 0] for i in (1, 2))
    areas = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    assert len(areas) == steps**2 and areas.sum() == pytest.approx(0.5)
    assert np.all(areas > 0)
    around = outline(steps)
    assert around[0] == around[-1] and len(set(around)) == 3 * steps
    x, y = x[around], y[around]
    assert 0.5 * (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() == pytest.approx(0.5)


def test_without_ngsolve_the_study_says_how_to_install_it(spm, monkeypatch):
    monkeypatch.setattr(body_fitted, "find_spec", lambda name: None)
    with pytest.raises(CaseError, match="pip install"):
        body_fitted.require()
    code, out, err = spm("study", "dns")
    assert (code, out, err) == (2, "", f"Running dns …\n{SENTENCE}\n")
    code, out, _ = spm("study", "dns", "--json")
    assert code == 2 and '"exit_code": 2' in out and "pip install" in out


def test_the_study_is_listed(spm):
    assert "dns" in studies.STUDIES
    assert "body-fitted" in spm("study", "list", "--json")[1]


def test_drag_in_a_concentric_sphere_is_the_closed_forms(shell):
    exact = 6.0 * math.pi * in_a_shell(0.5)
    off = [8.0 * shell(k).solve(wall_speed=1.0).reaction / exact - 1.0 for k in (2, 3, 4)]
    # Two cells across the gap; each order gains a factor of five or more, as smooth flow should.
    assert abs(off[2]) < 2e-3
    assert abs(off[0]) > 5 * abs(off[1]) > 25 * abs(off[2])


def test_drag_is_as_the_viscosity_and_the_speed(shell):
    one = shell(2).solve(wall_speed=1.0)
    other = shell(2, viscosity=3.0).solve(wall_speed=-2.0)
    # To the residual that the iterations leave.
    assert other.reaction == pytest.approx(-6.0 * one.reaction, rel=1e-7)


def test_inertia_adds_to_the_drag_as_its_square(elements):
    """F is odd in U, so that ρ adds c·ρ² at first; (∇u)ᵀu, a gradient, would add nothing."""
    flow, meshes, _ = elements
    coarse = flow.FiniteElements(meshes.duct_mesh(3.0, 1.2).mesh, 2)
    none, half, whole = (coarse.solve(rho, 1.0).reaction for rho in (0.0, 0.5, 1.0))
    assert whole > 1.005 * none
    # The next power of ρ, and the mesh, which is not its own mirror image.
    assert (whole - none) / (half - none) == pytest.approx(4.0, rel=0.05)


def test_a_reynolds_number_without_a_solution_is_told(shell):
    with pytest.raises(BlowUpError, match="Reynolds number is too high"):
        shell(2).solve(density=1e5, wall_speed=1.0)


@pytest.mark.parametrize("fraction", [0.0, -0.1, 0.53])
def test_spheres_must_not_touch(elements, fraction):
    with pytest.raises(ValueError, match="between 0 and π/6"):
        elements[2].cubic_array(fraction)


def test_an_array_agrees_with_the_multipoles(elements):
    ladder = elements[2].cubic_array(0.216, orders=(2, 3, 4))
    assert np.all(np.diff(ladder.unknowns) > 0)
    # Multipole series: 7.44195. What is left by such low orders is estimated, 2e-4 of K.
    assert abs(ladder.limit.value - 7.44195) < ladder.limit.error < 3e-4 * 7.44195


def test_the_drag_in_an_array_is_its_pressure_gradient(elements):
    """The sphere bears the fluid's share of gL³ as reaction, and the rest as buoyancy."""
    flow, meshes, _ = elements
    part = meshes.array_mesh(0.1, 1.0, 0.6)
    found = flow.FiniteElements(part.mesh, 3).solve(body_force=1.0)
    ball = 4.0 * math.pi / 3.0
    # The geometry is of degree six: its volume is right to 1e-6.
    assert 8.0 * found.reaction + ball == pytest.approx(part.volume, rel=1e-6)


@pytest.mark.slow
def test_every_number_of_the_study_agrees(elements):
    study = studies.study_named("dns")()
    assert study.agrees
    assert [picture.name for picture in study.pictures] == ["convergence", "plane", "axis"]
    assert all(picture.png for picture in study.pictures)
    force, creeping = (study.curves[f"duct_{name}"]["limit"][-1] for name in ("force", "creeping"))
    # What the two meshes differ by at most, 6e-6, and the last digit.
    assert force == pytest.approx(164.138, abs=0.002)
    assert creeping == pytest.approx(30.1814, abs=5e-4)
