"""Warnings of narrow gaps and of lattices that do not fill their box; Stokes flow as advice."""

import json

import numpy as np
import pytest

import smoothprofile as sp
from case_makers import small_case, sphere
from smoothprofile.config import load_case, smallest_gap
from smoothprofile.config.tomltext import document
from smoothprofile.errors import CaseError
from smoothprofile.gap_checks import gap_rows, lattice_rows

PERIODIC = ("periodic",) * 3
# Gaps are differences of coordinates of about 5: round-off is 1e-15.
NEAR = 1e-12


def gap(*particles, below=9.0, boundaries=PERIODIC):
    case = load_case(small_case(*particles, boundaries=boundaries))
    return smallest_gap(case.particles, case.domain, below)


def test_gaps_of_spheres_count_images_and_sizes():
    # In the box 10 × 8 × 8 about 0: 8.9 apart along x, or 1.1 through the side.
    pair = sphere(position=[-4.5, 0, 0], radius=0.3), sphere(position=[4.4, 0, 0], radius=0.5)
    found, *names = gap(*pair)
    assert found == pytest.approx(0.3, abs=NEAR) and set(names) == {"sphere 0", "sphere 1"}
    assert gap(*pair, below=0.3 - 1e-9) is None
    # Between walls along x they are 8.1 apart, and their images along y nearer: 8 − 2·.5.
    walled = gap(*pair, boundaries=("wall", "periodic", "periodic"))
    assert walled == (pytest.approx(7.0, abs=NEAR), "sphere 1", "sphere 1")
    alone = gap(sphere(radius=2.0))
    assert alone == (pytest.approx(4.0, abs=NEAR), "sphere", "sphere")


def test_gaps_are_those_of_all_pairs():
    particles = [{"shape": "sphere", "radius": [0.3, 0.5, 0.9], "random": {"count": 40, "seed": 3}}]
    case = load_case(small_case(*particles, boundaries=PERIODIC))
    places = np.array([p.position for p in case.particles])
    radii = np.array([p.radius for p in case.particles])
    apart = places[:, None] - places
    apart -= case.domain.lengths * np.round(apart / case.domain.lengths)
    every = np.linalg.norm(apart, axis=2) - radii - radii[:, None] + 100.0 * np.eye(40)
    found = smallest_gap(case.particles, case.domain, 3.0)[0]
    assert found == pytest.approx(every.min(), abs=NEAR)


def test_gaps_of_other_shapes():
    box = {"shape": "box", "sides": [2, 2, 2], "position": [0, 0, 0]}
    # The corner of the cube at (1,1,1), a sphere on its diagonal: √3·(2.5 − 1) − 1.
    found = gap(box, sphere(position=[2.5, 2.5, 2.5]))[0]
    assert found == pytest.approx(1.5 * 3**0.5 - 1.0, abs=NEAR)
    plane = {"shape": "plane", "normal": [0, 0, 1], "position": [0, 0, -3.5]}
    sides = ("periodic", "periodic", "wall")
    found = gap(plane, sphere(position=[0, 0, -2]), boundaries=sides)[0]
    assert found == pytest.approx(0.5, abs=NEAR)


def test_a_narrow_gap_is_one_warning():
    row = [sphere(position=[x, 0, 0]) for x in (-3.5, -0.5, 2.5)]
    case = small_case(*row, boundaries=PERIODIC)
    # Gaps of 1, 1 and 2 against 5ξ = 1.5; to their images along y it is 6.
    (check,) = gap_rows(load_case(case))
    assert check["verdict"] == "warn" and check["value"] == pytest.approx(1.0, abs=NEAR)
    assert check["limit"] == 1.5
    thin = case | {"profile": {"thickness": 0.2}}
    assert gap_rows(load_case(thin)) == []
    free = [{**body, "motion": "free", "density": 1.0} for body in row]
    helped = case | {"particles": free, "contact": {"lubrication": True}}
    assert gap_rows(load_case(helped)) == []
    assert "smallest gap" in [c["name"] for c in sp.Simulation(load_case(case)).preflight()]


@pytest.mark.parametrize(
    ("lattice", "warned"),
    [
        ({"counts": [2, 2, 2]}, {}),
        ({"spacing": [5.0, 4.0, 4.0]}, {}),
        ({"spacing": 3.0}, {"x": 9.0, "y": 6.0, "z": 6.0}),
        ({"spacing": [5.0, 4.0, 3.0]}, {"z": 6.0}),
        ({"counts": [2, 2, 2], "spacing": [5.0, 4.0, 3.0]}, {"z": 6.0}),
        ({"counts": [2, 2, 1], "spacing": [5.0, 4.0, 3.0]}, {}),
    ],
)
def test_a_lattice_that_does_not_fill_its_period_is_told(lattice, warned):
    case = small_case({"shape": "sphere", "radius": 0.5, "lattice": lattice}, boundaries=PERIODIC)
    rows = lattice_rows(case)
    assert {row["name"][-1]: row["value"] for row in rows} == warned
    walled = {**case, "domain": {**case["domain"], "boundaries": ["wall"] * 3}}
    assert lattice_rows(walled) == []


def test_check_tells_of_lattices(spm, tmp_path):
    beads = {"shape": "sphere", "radius": 0.5, "lattice": {"spacing": 3.0}}
    text = document(small_case(beads, boundaries=PERIODIC))
    (tmp_path / "case.toml").write_text(text, encoding="utf-8")
    code, out, _ = spm("check", "case.toml", "--json")
    names = [row["name"] for row in json.loads(out)["checks"] if row["verdict"] == "warn"]
    assert code == 0 and {"lattice along x", "lattice along y", "lattice along z"} <= set(names)


def refused(viscosity, **time):
    particles = [sphere(velocity=[1.0, 0, 0], motion="prescribed")]
    case = small_case(*particles, boundaries=PERIODIC) | {"time": {"end": 100.0, **time}}
    case["fluid"] = {"density": 1.0, "viscosity": viscosity}
    with pytest.raises(CaseError) as caught:
        sp.Simulation(load_case(case))
    return str(caught.value)


def test_a_refused_step_without_inertia_points_to_stokes_flow():
    # ρ = a = U = 1, so that Re = 1/μ: .02 here, and 1 where nothing is said.
    for step in (20.0, 0.9):
        text = refused(50.0, step=step)
        assert text.endswith('; at Re = 0.02 fluid.flow = "stokes" needs no such step.')
        assert text.count(". ") == 0
    assert "stokes" not in refused(1.0, step=20.0)
