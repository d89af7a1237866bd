"""Runs of a field alone, from the case to the run directory."""

import json

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

import smoothprofile as sp
from smoothprofile.cli import app
from smoothprofile.electric.forces import body_loads
from smoothprofile.grid import interior
from smoothprofile.plane_plots import strength_picture
from test_config_electric import ELECTRODES, WALLED, field_case

COARSE = {"domain.cells": [24, 24, 24], "domain.lengths": [6, 6, 6], "domain.origin": [-3, -3, -3]}


def run(overrides=(), **changes):
    case = sp.Electrostatics.from_file(field_case(**changes), overrides)
    case.run()
    return case


def test_a_sphere_alone_has_its_dipole_and_inner_field():
    done = run({**COARSE, "domain.cells": [36, 36, 36]})
    body = done.particles[0]
    # The error, of second order, is .07 % at sixteen cells to the radius: .5 % at six.
    assert body["dipole"][2] == pytest.approx(9.563894, rel=0.01)
    # Painted 3 % larger so that its dipole is right, it has an inner field 9 % too low at six cells
    # to the radius; of second order too, it is 1.4 % at sixteen.
    assert body["centre_field"][2] == pytest.approx(0.2536902, rel=0.12)
    assert np.abs(body["dipole"][:2]).max() < 1e-6 * body["dipole"][2]
    tensor = done.effective_permittivity
    # ⟨D⟩ = ε_fluid E₀ + p/V.
    assert tensor[2, 2] == pytest.approx(1 + body["dipole"][2] / 216, rel=1e-9)
    assert np.allclose(tensor, tensor[2, 2] * np.eye(3), atol=1e-6)


def test_force_is_nothing_on_a_lone_sphere_and_opposite_on_two():
    pair = [
        {"shape": "sphere", "radius": 1.0, "position": [0, 0, z], "permittivity": 10.0}
        for z in (-1.5, 1.5)
    ]
    done = run({"electric.effective": False, "domain.cells": [64, 64, 64]}, particles=pair)
    below, above = (body["force"] for body in done.particles)
    # The error falls as Δx²: 1.6 % at eight cells to the radius, .35 % at sixteen.
    assert below[2] == pytest.approx(0.563357, rel=0.025)
    assert np.abs(below + above).max() < 1e-9
    # A surface three cells off the bodies, in a gap of four, has no room.
    assert np.isnan(done.particles[0]["maxwell_force"]).all()


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_field_along_a_cylinder_is_not_disturbed(axis):
    cells, lengths, field = [24, 24, 24], [6.0, 6.0, 6.0], [0.0, 0.0, 0.0]
    cells[axis], lengths[axis], field[axis] = 4, 1.0, 1.0
    changes = {"domain.cells": cells, "domain.lengths": lengths, "electric.field": field}
    middle = {"domain.origin": [-0.5 * length for length in lengths]}
    body = {"shape": "cylinder", "radius": 1.5, "position": [0, 0, 0], "permittivity": 10.0}
    done = run({**changes, **middle}, particles=[{**body, "axis": field}])
    # Nothing is solved for along the axis: what it leaves of a residual is round-off.
    assert done.report.iterations == 0
    assert np.array_equal(done.electric_field[axis], np.ones(cells))
    # Permittivities in parallel, 1 + 9c. Of the painted c: its sum over faces and corners is not
    # that over cells, by 2e-4. Of c = π/16: retraction with ξ = .19 makes it .4 % less.
    found = done.effective_permittivity[axis, axis]
    assert found == pytest.approx(1 + 9 * done.indicator.mean(), rel=5e-4)
    assert found == pytest.approx(1 + 9 * np.pi / 16, rel=0.01)


def test_one_cell_is_refused_in_one_sentence():
    with pytest.raises(sp.CaseError, match="take smaller cells"):
        run({"domain.cells": [1, 1, 1]})


CENTRED = [
    {"shape": "sphere", "radius": 0.7},
    {"shape": "ellipsoid", "radii": [0.9, 0.9, 1.4]},
    {"shape": "capsule", "radius": 0.9, "length": 1.5},
    {"shape": "box", "sides": [1.8, 1.8, 1.8]},
]


@pytest.mark.parametrize("shape", CENTRED, ids=lambda shape: shape["shape"])
def test_a_body_centred_on_a_grid_point_has_the_loads_of_one_beside_it(shape):
    """Its axis, where the normal of its layer is not defined, then passes through grid points."""
    loads = []
    for place in ([0.0, 0.0, 0.0], [0.01, 0.007, -0.004]):
        body = {**shape, "position": place, "permittivity": 5.0}
        oblique = {"electric.field": [0.3, -0.5, 1.0], "electric.effective": False}
        done = run({**COARSE, **oblique}, particles=[body])
        run_loads = body_loads(
            done.field.medium,
            done.bodies,
            done.field.solver.potential,
            done.case_field,
            done.field.solver.geometry,
        )
        loads.append((run_loads.force[0], done.particles[0]["torque"]))
    # ε a² E² is of the order of 1. Symmetry leaves no force but round-off over a thousandth of ξ.
    assert np.abs(loads[0][0]).max() < 1e-3
    # The energy of a box's edges is rough on the scale of a cell, and so is, by 3 %, that of the
    # seams of a capsule, where the correction by curvature jumps.
    allowed = {"box": 0.5, "capsule": 0.1}.get(shape["shape"], 0.02)
    assert loads[0][1] == pytest.approx(loads[1][1], abs=allowed)


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-6])
def test_a_pair_placed_evenly_about_a_grid_point_has_a_force_of_its_size(offset):
    """Half way between the spheres the slopes of their layers cancel."""
    pair = [
        {"shape": "sphere", "radius": 1.0, "position": [offset, 0, z], "permittivity": 5.0}
        for z in (-1.375, 1.375)
    ]
    oblique = {"electric.field": [0.3, -0.5, 1.0], "electric.effective": False}
    done = run({**COARSE, **oblique}, particles=pair)
    below, above = (body["force"] for body in done.particles)
    # Two dipoles in the field's own plane: along x and y as the field's own parts are.
    assert below[0] / below[1] == pytest.approx(-0.6, rel=0.02)
    # Point dipoles p = 4πa³bE at a distance d, b = 4/7: 3(2p_z² − p_x² − p_y²)/4πd⁴ = .357; nearer
    # spheres, coarse layers and images make it up to twice as large.
    assert 0.3 < below[2] < 0.9
    assert np.abs(below + above).max() < 1e-9


def test_arrows_do_not_depend_on_the_units():
    plane = {"axis": "y", "at": 0.0, "x": np.array([0.0, 1.0]), "y": np.array([0.0, 1.0])}
    plane |= {"labels": ("x", "z"), "indicator": np.zeros((2, 2)), "strength": np.eye(2)}
    plane |= {"places": np.array([[0.5, 0.5]]), "forces": np.array([[0.0, 1e-13]])}
    # The smallest force that is shown is 1e-5 of ε E²·area.
    assert "longest arrow" in strength_picture({**plane, "permittivity": 8.854e-12}).caption
    assert "longest arrow" not in strength_picture(plane).caption


def test_without_contrast_there_is_no_force_and_no_dipole():
    done = run({**COARSE, "particles.0.permittivity": 1.0})
    body = done.particles[0]
    assert np.abs(body["force"]).max() == 0.0
    assert np.abs(body["dipole"]).max() < 1e-12
    assert np.abs(done.electric_field[2] - 1.0).max() == 0.0


def test_electrodes_give_their_potentials_and_their_field():
    done = run([WALLED, "electric.field=[0,0,0]", ELECTRODES, "particles.0.permittivity=1"])
    # Between empty electrodes V is linear, from half a cell inside the walls.
    levels = (np.arange(32) + 0.5) / 32
    assert np.allclose(done.potential, levels[None, None, :], atol=1e-12)
    assert np.allclose(done.electric_field[2], -1 / 8, atol=1e-12)


def test_a_bead_between_electrodes_raises_their_charge():
    done = run([WALLED, "electric.field=[0,0,0]", ELECTRODES])
    assert done.effective_permittivity is None
    empty, with_bead = -1 / 8, done.summary()["mean_displacement"][2]
    # c = 4π/(3·512); Maxwell Garnett, whose error here is of the order of c².
    c = 4 * np.pi / (3 * 512)
    assert with_bead / empty == pytest.approx(1 + 3 * c * 0.75 / (1 - 0.75 * c), rel=2e-3)
    assert done.permittivity_along == with_bead / empty
    assert "effective permittivity" in [name for name, _, _ in done.table()]


def test_the_thesis_discretisation_agrees_and_gives_no_forces():
    ours = run({**COARSE, "electric.smoothing": "arithmetic", "electric.retract": False})
    theirs = run({**COARSE, "electric.discretisation": "fourier"})
    # Both of one smoothed ε at three cells to its layer.
    assert theirs.effective_permittivity[2, 2] == pytest.approx(
        ours.effective_permittivity[2, 2], rel=2e-3
    )
    assert "force" not in theirs.particles[0]


def test_the_fixed_point_method_agrees_with_conjugate_gradients():
    # With a layer of two cells both forms of the equation are resolved, to 1e-6 here; with one of
    # three quarters of a cell they differ by 6e-4.
    spectral = {
        **COARSE,
        "electric.discretisation": "fourier",
        "electric.thickness": 0.5,
        "particles.0.permittivity": 2.0,
    }
    one = run({**spectral, "electric.method": "fixed-point", "electric.tolerance": 1e-9})
    other = run({**spectral, "electric.tolerance": 1e-9})
    assert np.abs(one.potential - other.potential).max() < 1e-5


def test_divergence_ends_the_run_by_name():
    spectral = {**COARSE, "electric.discretisation": "fourier", "electric.method": "fixed-point"}
    with pytest.raises(sp.BlowUpError, match="fixed-point ended by diverged after"):
        run({**spectral, "particles.0.permittivity": 200.0})


def test_too_few_iterations_end_the_run_by_name():
    with pytest.raises(sp.BlowUpError, match="iteration limit after 2 iterations"):
        run({**COARSE, "electric.max_iterations": 2})


def test_the_potential_is_that_of_the_field():
    done = run(COARSE)
    # E at centres is the mean of both faces: the central difference of V.
    inner = done.potential[:, :, 2:] - done.potential[:, :, :-2]
    assert np.allclose(-inner / (2 * 0.25), done.electric_field[2][:, :, 1:-1], atol=1e-12)


def test_a_bead_near_an_electrode_is_warned_of():
    case = sp.Electrostatics.from_file(
        field_case(),
        [WALLED, "electric.field=[0,0,0]", ELECTRODES, "particles.0.position=[0,0,-2.99]"],
    )
    check = {row["name"]: row for row in case.preflight()}["electrode gap"]
    assert check["verdict"] == "warn"
    assert check["value"] == pytest.approx(0.01)


def test_each_run_class_names_the_other():
    with pytest.raises(sp.CaseError, match="Electrostatics"):
        sp.Simulation.from_file(field_case())
    with pytest.raises(sp.CaseError, match="Simulation"):
        sp.Electrostatics.from_file("couette")
    assert isinstance(sp.from_file(field_case()), sp.Electrostatics)


def test_the_run_directory_holds_fields_figures_and_report(tmp_path):
    case = sp.load_case(field_case(), {**COARSE, "output.plane": {"axis": "y", "at": 0.0}})
    path = tmp_path / "bead.toml"
    path.write_text(case.to_toml(), encoding="utf-8")
    out = tmp_path / "run"
    done = CliRunner().invoke(app, ["run", str(path), "--out", str(out), "--json"])
    assert done.exit_code == 0, done.output
    summary = json.loads((out / "summary.json").read_text())
    assert summary["status"] == "finished"
    with h5py.File(out / "fields.h5") as file:
        assert file["electric_field"].shape == (1, 24, 24, 24, 3)
        assert file["potential"].shape == (1, 24, 24, 24)
    names = {picture.name for picture in (out / "figures").iterdir()}
    assert {"electric-field.png", "potential.png"} <= names
    page = (out / "report.html").read_text()
    assert "dipole" in page
    assert "effective permittivity" in page


def test_a_run_that_does_not_converge_leaves_with_three(tmp_path):
    path = tmp_path / "bead.toml"
    path.write_text(sp.load_case(field_case(), COARSE).to_toml(), encoding="utf-8")
    arguments = ["run", str(path), "--out", str(tmp_path / "run")]
    done = CliRunner().invoke(app, [*arguments, "--set", "electric.max_iterations=1"])
    assert done.exit_code == 3
    assert json.loads((tmp_path / "run" / "run.json").read_text())["status"] == "blew_up"


def test_the_painted_indicator_is_the_volume():
    done = run(COARSE)
    volume = done.indicator.mean() * 216
    # Painted inside by the retraction, less what tanh over .19 adds: 5 % less.
    assert volume == pytest.approx(4 * np.pi / 3, rel=0.07)
    assert interior(done.field.solver.potential).shape == done.indicator.shape
