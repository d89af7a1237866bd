"""The study of methods: what each solves, on meshes as coarse as they go, and all of it by hand."""

import pytest

from smoothprofile.studies import study_named
from smoothprofile.studies.methods import EXACT, STORED, solves, study_of
from smoothprofile.studies.methods_runs import (
    coupled_array,
    coupled_duct,
    duct_grid,
    forced_array,
    forced_duct,
    stokes_array,
    stokes_duct,
    timed,
    viscous_array,
)

C, SPUN = 0.027, 0.03


@pytest.mark.parametrize(
    ("make", "cells", "reach"),
    [
        # Direct forcing has a layer of .75 radii, smoothed viscosity one of a cell.
        (forced_array, 4, 0.03),
        (stokes_array, 4, 0.01),
        (viscous_array, 4, 0.03),
        (coupled_array, 3, 0.01),
    ],
)
@pytest.mark.parametrize("turns", [False, True])
def test_arrays_are_near_the_multipoles(make, cells, reach, turns):
    value, _ = make(SPUN if turns else C, cells, turns)()
    assert value == pytest.approx(EXACT["spin" if turns else "array_027"], rel=reach)


def test_creeping_flow_in_the_duct():
    """Within 1 % of body-fitted elements by the Stokes solver, refined or not (4 cells to a)."""
    for refined in (False, True):
        value, cells = stokes_duct(4, refined)()
        assert value == pytest.approx(EXACT["creeping"], rel=0.01)
        assert cells < 63000
    # Force coupling on two cells to a radius.
    assert coupled_duct(2, False)()[0] == pytest.approx(EXACT["creeping"], rel=0.015)


def test_inertia_adds_to_the_force():
    """F/U rises by 9 % from Re = 0 to 10."""
    slow, fast = (forced_duct(3, advection, False)()[0] for advection in (False, True))
    # A layer of .43 radii; most of what it errs by cancels in the ratio.
    assert slow == pytest.approx(EXACT["creeping"], rel=0.03)
    assert fast / slow == pytest.approx(EXACT["inertia"] / EXACT["creeping"], rel=0.01)


def test_refined_meshes_are_as_fine_at_the_sphere():
    for per_radius in (4, 6, 9):
        for axis in duct_grid(per_radius, True).axes:
            assert axis.widths.min() == pytest.approx(1.0 / per_radius, rel=0.1)


def test_the_least_of_short_solves_is_taken():
    calls = []
    found = timed(lambda: (calls.append(1) or 2.0, 3))
    assert (found.value, found.cells, len(calls)) == (2.0, 3, 3)
    assert 0.0 <= found.seconds < 0.1


def test_a_study_without_finite_elements_shows_the_stored_ones():
    wanted = {"array_216": {"coupling": solves()["array_216"]["coupling"][:2]}}
    study = study_of(wanted, with_elements=False)
    elements = [row for row in study.rows if "finite elements" in row.quantity]
    assert [row.ours for row in elements] == [STORED["array_216"][4][0]]
    assert study.agrees and "stored" in study.findings[-1]
    assert [picture.name for picture in study.pictures] == ["arrays"]
    assert all(picture.png for picture in study.pictures)


def test_stored_elements_are_near_the_multipoles():
    for problem, rows in STORED.items():
        errors = [abs(value / EXACT[problem] - 1.0) for value, *_ in rows.values()]
        # Each order gains a factor of five or more.
        assert errors[-1] < 2e-3 and errors[0] > 5.0 * errors[1]


@pytest.mark.slow
def test_every_number_agrees():
    study = study_named("methods")()
    assert study.agrees
    assert {picture.name for picture in study.pictures} == {"arrays", "turning-and-duct"}
    assert all(picture.png for picture in study.pictures)
