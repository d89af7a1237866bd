"""Stresslets, effective viscosity, settling: against exact values and exact balances."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from coupled import simulation, sphere, steps
from smoothprofile import rotations, shapes
from smoothprofile.errors import CaseError
from smoothprofile.output import RunDirectory
from smoothprofile.particles.bodies import bodies_at
from smoothprofile.particles.inertia import DisplacedFluid
from smoothprofile.particles.stress import components, displaced_moments, stresslets
from smoothprofile.runrecord import read_run
from smoothprofile.studies.viscosity import lattice
from smoothprofile.suspension import effective_viscosity

PERMUTATION = np.zeros((3, 3, 3))
for i in range(3):
    PERMUTATION[i, i - 2, i - 1], PERMUTATION[i, i - 1, i - 2] = 1.0, -1.0


def moving_body(shape, seed=3):
    """A body of that shape, turned and spinning, with some acceleration."""
    random = np.random.default_rng(seed)
    state = bodies_at([random.normal(size=3)], [rotations.normalise(random.normal(size=4))])
    state.angular_velocity[:] = random.normal(size=3)
    displaced = DisplacedFluid(
        np.array([shape.volume]), shape.centroid[None], np.asarray(shape.inertia)[None]
    )
    return state, displaced, random.normal(size=(1, 3)), random.normal(size=(1, 3))


def lopsided():
    still = (1.0, 0.0, 0.0, 0.0)
    parts = [(shapes.box((1, 0.6, 0.4)), (0.5, 0, 0.2), still)]
    return shapes.union([*parts, (shapes.sphere(0.3), (-0.6, 0.3, 0), still)])


def test_moments_of_the_displaced_fluid_are_those_of_its_points():
    shape = shapes.union([(shapes.box((1.0, 0.6, 0.4)), (0.3, 0.1, -0.2), (1.0, 0.0, 0.0, 0.0))])
    state, displaced, push, turn = moving_body(shape)
    found = displaced_moments(displaced, state, push, turn)[0]
    # Three Gauss points a side integrate the cubic integrand exactly.
    points, weights = np.polynomial.legendre.leggauss(3)
    grids = np.meshgrid(points * 0.5, points * 0.3, points * 0.2, indexing="ij")
    local = np.stack(grids, axis=-1).reshape(-1, 3) + np.array([0.3, 0.1, -0.2])
    share = np.einsum("i,j,k->ijk", weights, weights, weights).ravel() / 8 * shape.volume
    r = local @ state.rotation[0].T
    spin = state.angular_velocity[0]
    a = push[0] + np.cross(turn[0], r) + np.cross(spin, np.cross(spin, r))
    assert np.allclose(found, np.einsum("m,mi,mj->ij", share, r, a), atol=1e-14)


def test_their_antisymmetric_part_is_the_torque():
    state, displaced, push, turn = moving_body(lopsided())
    moments = displaced_moments(displaced, state, push, turn)
    _, torque = displaced.loads(state, push, turn)
    assert np.allclose(np.einsum("ijk,njk->ni", PERMUTATION, moments), torque, atol=1e-14)


def test_a_stresslet_is_symmetric_without_trace_and_opposes_the_impulse():
    gained = np.arange(9.0).reshape(1, 3, 3)
    (found,) = stresslets(gained, np.zeros((1, 3, 3)), rate=2.0, density=3.0)
    assert found[0, 1] == -3.0 * 2.0 * 0.5 * (1 + 3)
    assert np.array_equal(found, found.T)
    assert abs(np.trace(found)) < 1e-13
    assert components(found).tolist() == [
        *np.diag(found),
        *(found[1, 2], found[0, 2], found[0, 1]),
    ]


def test_shear_of_a_cubic_lattice_is_as_viscous_as_it_should_be():
    found = effective_viscosity(lattice(0.03, 0.3, 32))
    # A multipole series gives 1.073594. Smoothing over ξ = .3a and cells of a/6 leave .1 % of
    # the increment; painting for the drag would cost .2, painting at the surface 11 %.
    assert abs((found.ratio - 1.0) / 0.073594 - 1.0) < 0.003
    assert found.volume_fraction == pytest.approx(0.03)
    assert found.residual < 1e-4
    # The lone sphere's is (20/3)πμa³E, and E_xy/√(2E:E) = ½.
    lone = 10.0 / 3.0 * math.pi
    off = found.stresslets[0].copy()
    assert off[0, 1] == pytest.approx(lone * 0.073594 / 0.075, rel=0.003)
    off[0, 1] = off[1, 0] = 0.0
    assert np.abs(off).max() < 1e-6 * lone


def test_stretch_of_a_cubic_lattice_is_as_viscous_as_it_should_be():
    found = effective_viscosity(lattice(0.01, 0.3, 32), np.diag([1.0, 1.0, -2.0]))
    # Series of Zuzovsky, Adler and Brenner: 1.0259427; a/4.3 cells leave about .5 %.
    assert abs((found.ratio - 1.0) / 0.0259427 - 1.0) < 0.008


def test_the_viscosity_is_that_of_the_strain_alone():
    """Neither the place of the cell, nor the axes, nor the fluid's own numbers count."""
    case = lattice(0.05, 0.3, 16)
    first = effective_viscosity(case).ratio
    side = case["domain"]["lengths"][0]
    moved = lattice(0.05, 0.3, 16)
    # By whole cells, so that the sphere straddles the seams.
    moved["particles"][0]["position"] = [0.5 * side, side / 16, side]
    moved["fluid"] |= {"density": 7.0, "viscosity": 0.01, "body_force": [1.0, 0.0, 0.0]}
    for strain in ("xy", "yx", "yz", "xz", 30.0 * np.array([[0, 1, 0], [1, 0, 0], [0, 0, 0]])):
        # Round-off alone is left: sums of some 10³ numbers, and steps that agree.
        assert effective_viscosity(moved, strain).ratio == pytest.approx(first, rel=1e-9)


def test_eight_cells_are_as_viscous_as_one():
    # Thin enough that no layer reaches half way to the next sphere.
    one = lattice(0.02, 0.2, 12)
    side = one["domain"]["lengths"][0]
    eight = {**one, "domain": {**one["domain"], "lengths": [2 * side] * 3, "cells": [24] * 3}}
    places = side * (np.stack(np.meshgrid(*([0, 1],) * 3), axis=-1).reshape(-1, 3) + 0.5)
    ball = one["particles"][0]
    eight["particles"] = [{**ball, "position": place.tolist()} for place in places]
    # Both marches stop within the tolerance of the same end.
    tight = {"tolerance": 1e-7}
    found = effective_viscosity(eight, **tight)
    assert found.ratio == pytest.approx(effective_viscosity(one, **tight).ratio, rel=1e-7)
    assert np.ptp(found.stresslets[:, 0, 1]) < 1e-9


@pytest.mark.parametrize(
    ("change", "strain", "words"),
    [
        ({}, "xx", "strain is 'xx'; it must be two different axes, such as 'xy'"),
        ({}, "ab", "strain is 'ab'"),
        ({}, np.eye(3), "it must be symmetric and without a trace"),
        ({}, np.zeros((3, 3)), "it must be nine finite numbers, not all zero"),
        ({}, [1.0, 2.0], "it must be nine finite numbers, not all zero"),
        ({"particles": []}, "xy", "particles is empty"),
        ({"domain.boundaries": ["periodic", "wall", "periodic"]}, "xy", "needs a periodic box"),
        (
            {"particles": [{"shape": "cylinder", "radius": 1.0, "position": [2.0] * 3}]},
            "xy",
            "particles.0 is a cylinder without an end",
        ),
    ],
)
def test_what_has_no_effective_viscosity_is_refused(change, strain, words):
    case = lattice(0.03, 0.3, 16)
    for key, value in change.items():
        table, _, entry = key.partition(".")
        if entry:
            case[table] = {**case[table], entry: value}
        else:
            case[table] = value
    with pytest.raises(CaseError, match=words) as caught:
        effective_viscosity(case, strain)
    assert str(caught.value).count("\n") == 0


def sheared(*bodies, **changes):
    """A cell sheared at γ̇ = ½ between walls across y, μ = ½, brought to its steady state."""
    tables = {
        "cells": [12] * 3,
        "boundaries": ["periodic", "wall", "periodic"],
        "viscosity": 0.5,
        "wall_velocity": {"y_high": [1.0, 0.0, 0.0], "y_low": [-1.0, 0.0, 0.0]},
        "advection": False,
        "step": "auto",
        "steady_tolerance": 1e-7,
        "end": 300.0,
    }
    run = simulation(*bodies, **{**tables, **changes})
    run.run()
    return run


@pytest.mark.parametrize("motion", ["free", "held", "prescribed"])
def test_walls_feel_the_stresslet(motion):
    """τ = μγ̇ + (S_xy − T_z/2)/V: momentum is in balance plane by plane, to round-off."""
    keys = {"free": {"density": 1.0}, "prescribed": {"angular_velocity": [0.0, 0.0, 0.3]}}
    body = sphere((2, 2, 2), 0.7, motion=motion, **keys.get(motion, {}))
    run = sheared(body)
    rate, viscosity, volume = 0.5, 0.5, 64.0
    stresslet, torque = run.bodies.stresslets()[0], run.bodies.state.torque[0]
    expected = viscosity + (stresslet[0, 1] - 0.5 * torque[2]) / (rate * volume)
    found = run.summary()["apparent_viscosity"]
    # What is left is what still changes, 1e-7 of the speeds per time.
    assert found == pytest.approx(expected, abs=1e-6)
    assert found > viscosity + 0.02
    assert (abs(torque[2]) < 1e-6) == (motion == "free")


def test_without_bodies_the_apparent_viscosity_is_the_fluids():
    run = sheared(cells=[4, 8, 4])
    summary = run.summary()
    # Couette flow is exact on the grid; the march stops at 1e-7.
    assert summary["apparent_viscosity"] == pytest.approx(0.5, abs=1e-6)
    assert "volume_fraction" not in summary
    still = steps(simulation(sphere((2, 2, 2))), 1)
    assert "apparent_viscosity" not in still.summary()


def test_settling_is_measured_along_gravity_and_against_the_mixture():
    bodies = [
        sphere((1, 1, z), 0.8, motion="free", density=2.0, velocity=[0.1, 0.0, -0.2])
        for z in (1.0, 3.0)
    ]
    held = sphere((3, 3, 2), 0.9)
    flow = {"gravity": [0.0, 0.0, -2.0], "initial_velocity": [0.0, 0.0, 0.5], "every": 1}
    run = steps(simulation(*bodies, held, **flow), 3)
    summary = run.summary()
    free = run.bodies.state.velocity[:2].mean(axis=0)
    assert np.allclose(summary["mean_particle_velocity"], free)
    mixture = summary["mean_velocity"][2]
    assert summary["settling_velocity"] == pytest.approx(-(free[2] - mixture))
    volume = 4 / 3 * np.pi * (2 * 0.8**3 + 0.9**3)
    assert summary["volume_fraction"] == pytest.approx(volume / 64.0)
    assert run.history["settling_velocity"][-1] == summary["settling_velocity"]
    total = components(run.bodies.stresslets().sum(axis=0)) / 64.0
    assert np.allclose(run.history["particle_stress"][-1], total)
    assert np.allclose(run.particles[0]["stresslet"], components(run.bodies.stresslets()[0]))


def test_the_columns_stand_in_the_tables(tmp_path):
    body = sphere((2, 2, 2), 0.7, motion="free", density=2.0)
    run = simulation(body, gravity=[0.0, 0.0, -1.0], every=1, max_steps=2)
    with RunDirectory(tmp_path / "run", run.case.to_toml()) as directory:
        run.run(observer=directory.record)
        directory.finish(run)
    record = read_run(tmp_path / "run")
    assert record.history["settling_velocity"][-1] > 0.0
    assert record.history["mean_particle_velocity_z"][-1] < 0.0
    row = record.particles["sphere"]
    for part in ("xx", "yy", "zz", "yz", "xz", "xy"):
        mean = row[f"stresslet_{part}"] / 64.0
        assert np.allclose(record.history[f"particle_stress_{part}"], mean, atol=1e-18)
    assert record.summary["volume_fraction"] == pytest.approx(4 / 3 * np.pi * 0.7**3 / 64.0)


def test_a_run_without_bodies_has_no_such_columns():
    run = steps(simulation(every=1, max_steps=1), 1)
    names = {"particle_stress", "settling_velocity", "mean_particle_velocity"}
    assert not names & set(run.history)
    assert not names & set(run.summary())
    assert SimpleNamespace(**run.summary()).status == "max_steps"
