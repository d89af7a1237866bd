"""φ where bodies overlap, moments that stand in for sums, bodies held in a mean gradient."""

import math

import numpy as np
import pytest

from coupled import (
    body_coordinates,
    cell_volumes,
    momentum,
    random_velocity,
    simulation,
    sphere,
    steps,
)
from smoothprofile.distances import curvature, signed_distance
from smoothprofile.grid import interior
from smoothprofile.particles.loads import Impulse
from smoothprofile.particles.painting import logistic
from smoothprofile.schemes import SCHEMES

STRETCHED = {
    "boundaries": ["periodic", "wall", "wall"],
    "stretching": ["uniform", {"focus": 1.0, "ratio": 2.5}, {"focus": 2.5, "ratio": 2.0}],
}
TURN = {"axis": [1.0, 2.0, -1.5], "angle": 40.0}
OBLONG = {
    "shape": "ellipsoid",
    "radii": [0.9, 0.7, 0.5],
    "position": [3.8, 1.8, 2.1],
    "orientation": TURN,
}
GRADIENT = np.array([[0.3, -0.7, 0.2], [0.5, 0.1, -0.4], [-0.6, 0.8, -0.4]])
TOUCHING = (
    sphere([1.2, 2, 2], velocity=[0.5, 0.2, 0.1], angular_velocity=[0.3, 0, 1.0]),
    sphere([2.8, 2, 2], velocity=[-0.4, 0.1, 0.3]),
)


# √(νΔt) = ξ or more: painted outside their true surfaces, by .1 to .3.
FAR_OUT = {"cells": [20] * 3, "retract": "planar", "viscosity": 8.0}


def painted(run, component):
    return interior(run.bodies.painter.dense(component))


def rigid(run, component, body=0, gradient=0.0):
    """u_p of one body at the points of a component."""
    state, r = run.bodies.state, body_coordinates(run, component, body)
    spin = np.cross(state.angular_velocity[body], r, axisb=0, axisc=0)[component]
    strain = np.einsum("j,j...->...", (gradient * np.ones((3, 3)))[component], r)
    return state.velocity[body, component] + spin + strain


# --- overlapping layers -----------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["tanh", "quartic-centred", "sine"])
def test_touching_bodies_share_what_is_solid(kind):
    """φᵢ/max(1, Σφ) of each, and u ← (1−Σφ)u + Σφᵢu_p, from bodies that are painted alone."""
    # tanh thin, so that no layer of 8ξ meets its own image, whose u_p is another.
    settings = {"kind": kind, **FAR_OUT, "thickness": 0.1 if kind == "tanh" else 0.3}
    settings["viscosity"] = 1.0 if kind == "tanh" else 8.0
    pair = simulation(*TOUCHING, **settings)
    alone = [simulation(body, **settings) for body in TOUCHING]
    fields = random_velocity(pair)
    before = [interior(f).copy() for f in fields]
    pair.bodies.impose(fields, SCHEMES["bdf2"], 0.02)
    for c in range(3):
        each = [painted(run, c) for run in alone]
        total = sum(each)
        assert total.max() > 1.01  # what must not be
        shares = [phi / np.maximum(1.0, total) for phi in each]
        assert painted(pair, c).max() <= 1.0 + 1e-15
        assert np.abs(painted(pair, c) - sum(shares)).max() < 1e-14
        gained = sum(
            phi * (rigid(run, c) - before[c]) for phi, run in zip(shares, alone, strict=True)
        )
        assert np.abs(interior(fields[c]) - before[c] - gained).max() < 1e-13
    assert pair.indicator.max() <= 1.0


def test_touching_bodies_take_what_the_fluid_loses():
    run = simulation(*TOUCHING, **FAR_OUT)
    fields = random_velocity(run)
    before = [interior(f).copy() for f in fields]
    gained, _ = run.bodies.impulse.impose(run.bodies.painter, run.bodies.state, fields)
    for c, (field, old) in enumerate(zip(fields, before, strict=True)):
        change = (interior(field) - old) * cell_volumes(run.grid, c)
        # Some thousand terms: round-off of their sum.
        assert gained[:, c].sum() == pytest.approx(change.sum(), abs=1e-14 * np.abs(change).sum())


def test_momentum_of_touching_bodies_that_move_freely():
    bodies = [{**body, "motion": "free", "density": 2.0} for body in TOUCHING]
    run = simulation(*bodies, **FAR_OUT)
    excess = (run.bodies.displaced.volume * (2.0 - 1.0))[:, None]

    def total():
        return momentum(run) + (excess * run.bodies.state.velocity).sum(axis=0)

    start, scale = total(), np.abs(excess * run.bodies.state.velocity).max()
    steps(run, 20)
    assert painted(run, 0).max() <= 1.0 + 1e-15
    # Sums over 8000 cells, 20 times.
    assert np.abs(total() - start).max() < 1e-12 * scale


def test_a_body_shares_with_its_own_image():
    run = simulation(sphere([2, 2, 2], radius=1.95), retract=False)
    total = painted(run, 1)
    assert total.max() <= 1.0 + 1e-15
    # Next to the image, by half a cell off the line of centres: two layers side by side, tanh each.
    step = 4.0 / 12
    near, far = (math.hypot(2 + s * step / 2, step / 2) - 1.95 for s in (-1, 1))
    expected = sum(0.5 * (1 - math.tanh(d / 0.3)) for d in (near, far))
    assert 0.8 < expected < 1.0
    assert total[0, 6, 5] == pytest.approx(expected, abs=1e-6)


# --- every point ------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", ["ellipsoid", "capsule"])
def test_points_passed_over_are_beyond_the_layer(shape):
    """φ of a body that is moved by its curvature, at each point from its own distance."""
    sizes = {"radii": [1.4, 0.6, 0.45]} if shape == "ellipsoid" else {"radius": 0.5, "length": 1.0}
    body = {"shape": shape, **sizes, "position": [2.0, 1.9, 2.1], "orientation": TURN}
    run = simulation(body, cells=[20] * 3, thickness=0.1, viscosity=1.0)
    painter = run.bodies.painter
    forms, profile = painter.forms, painter.profile
    assert forms.offset[0, 1] > 1e-3  # times κ₁+κ₂, up to 14
    turn = run.bodies.state.rotation[0] @ forms.turn[0]
    r = np.moveaxis(body_coordinates(run, 1), 0, -1).reshape(-1, 3) @ turn
    kind, size = int(forms.kind[0]), forms.size[0]
    d = np.array([signed_distance(kind, *size, *x) for x in r])
    d -= forms.offset[0, 0] + forms.offset[0, 1] * np.array([curvature(kind, *size, *x) for x in r])
    phi = profile.value(d / 0.1).reshape(run.grid.shape)
    assert np.abs(painted(run, 1) - phi).max() < 2e-7  # where tanh is cut off


# --- moments ----------------------------------------------------------------------------------


def test_tanh_without_the_library():
    s = np.linspace(-8.0, 8.0, 4001)
    found = np.array([logistic.py_func(x) for x in s])
    # The series leaves 64 units of round-off of e²ˢ, which is at most ¼ of them in φ.
    assert np.abs(found - 0.5 * (1 - np.tanh(s))).max() < 4e-15


@pytest.mark.parametrize("gradient", [0.0, GRADIENT], ids=["rigid", "gradient"])
def test_impulse_and_its_first_moments_are_sums_over_the_points(gradient):
    """∫f, ∫r×f and ∫r⊗f of f = φ(V + Ω×r + Gr − u), on a stretched grid between walls."""
    motion = {"velocity": [0.5, -0.3, 0.2], "angular_velocity": [0.2, 0.5, -1.0]}
    run = simulation({**OBLONG, **motion}, cells=[14, 13, 12], thickness=0.1, **STRETCHED)
    bodies = run.bodies
    impulse = Impulse(run.grid, gradient * np.ones((3, 3)))
    fields = random_velocity(run)
    before = [interior(f).copy() for f in fields]
    force, torque = impulse.impose(bodies.painter, bodies.state, fields)
    moments = np.zeros((3, 3))
    for c in range(3):
        f = painted(run, c) * (rigid(run, c, gradient=gradient) - before[c])
        assert np.abs(interior(fields[c]) - before[c] - f).max() < 1e-13
        f *= cell_volumes(run.grid, c)
        assert force[0, c] == pytest.approx(f.sum(), abs=1e-13)
        moments[:, c] = (body_coordinates(run, c) * f).sum(axis=(1, 2, 3))
    found = impulse.first_moments(bodies.painter, bodies.state)[0]
    # Sums of a few hundred terms of size .01.
    assert found == pytest.approx(moments, abs=1e-13)
    assert np.abs(found - moments.T).max() > 0.01  # the order of r and f matters
    antisymmetric = [moments[1, 2] - moments[2, 1], moments[2, 0] - moments[0, 2],
                     moments[0, 1] - moments[1, 0]]  # fmt: skip
    assert torque[0] == pytest.approx(antisymmetric, abs=1e-13)


def test_no_gradient_changes_no_bit():
    found = []
    for impulse in (Impulse, lambda grid: Impulse(grid, np.zeros((3, 3)))):
        run = simulation({**OBLONG, "angular_velocity": [0.2, 0.5, -1.0]}, thickness=0.1)
        fields = random_velocity(run)
        impulse(run.grid).impose(run.bodies.painter, run.bodies.state, fields)
        found.append(np.array(fields))
    assert np.array_equal(*found)


def test_a_body_that_nothing_holds_takes_no_impulse():
    """V and Ω that solve M(V, Ω) = momentum leave ∫f = ∫r×f = 0, in a gradient and near a wall."""
    run = simulation(OBLONG, cells=[14, 13, 12], thickness=0.1, **STRETCHED)
    painter, state = run.bodies.painter, run.bodies.state
    impulse, fields = Impulse(run.grid, GRADIENT), random_velocity(run)
    matrix, known = impulse.momenta(painter, state, fields)
    assert matrix[0] == pytest.approx(matrix[0].T, abs=1e-14)
    motion = np.linalg.solve(matrix, known[..., None])[0, :, 0]
    state.velocity[0], state.angular_velocity[0] = motion[:3], motion[3:]
    force, torque = impulse.impose(painter, state, fields)
    assert np.abs([force, torque]).max() < 1e-14
    symmetric = impulse.first_moments(painter, state)[0]
    assert np.abs(symmetric - symmetric.T).max() < 1e-14
    assert np.abs(symmetric).max() > 0.01


@pytest.mark.parametrize("kind", ["tanh", "quartic-centred"])
def test_moments_of_the_indicator_on_a_stretched_grid(kind):
    """∫φ and ∫φrr that the painter keeps against sums of the field that it gives."""
    run = simulation(
        sphere([3.8, 1.7, 2.1]), cells=[14, 13, 12], thickness=0.15, kind=kind, **STRETCHED
    )
    kept = run.bodies.painter.sums[0]
    for c in range(3):
        mass = painted(run, c) * cell_volumes(run.grid, c)
        x, y, z = r = body_coordinates(run, c)
        expected = [mass.sum(), *(mass * r).sum(axis=(1, 2, 3))]
        expected += [(mass * s).sum() for s in (x * x, x * y, x * z, y * y, y * z, z * z)]
        assert kept[c] == pytest.approx(np.array(expected), abs=1e-13)
        # φ of the sphere itself: round-off of the distance over ξ.
        profile, radius = run.bodies.painter.profile, run.bodies.painter.forms.offset[0, 0] + 0.8
        phi = profile.value((np.sqrt((r**2).sum(axis=0)) - radius) / 0.15)
        # Wall faces carry no unknown; tanh is cut off at 1e-7.
        unknown = interior(np.ones(run.grid.padded_shape))
        unknown[(slice(None),) * c + (slice(0, 1),)] = float(run.grid.periodic[c])
        assert np.abs(painted(run, c) - phi * unknown).max() < (2e-7 if kind == "tanh" else 1e-12)
