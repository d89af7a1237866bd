"""Bodies by themselves: what is painted, what the impulse takes, and how bodies move."""

import itertools
import math

import numpy as np
import pytest

import smoothprofile as sp
from coupled import body_coordinates, cell_volumes, random_velocity, simulation, sphere, steps
from smoothprofile import rotations
from smoothprofile.config import build_shape
from smoothprofile.distances import curvature
from smoothprofile.grid import interior
from smoothprofile.profiles import profile_named
from smoothprofile.schemes import SCHEMES
from smoothprofile.signals import Signal

TURN = {"axis": [1.0, 2.0, -1.5], "angle": 40.0}
MIXED = {"boundaries": ["periodic", "wall", ["slip", "wall"]]}
STRETCHED = {"stretching": ["uniform", {"focus": 1.0, "ratio": 2.5}, "uniform"]}
FINE = {"lengths": [6.0] * 3, "cells": [64] * 3, "thickness": 0.15}


def exact_indicator(run, component):
    """φ of every body and periodic image, straight from the shapes' signed distances."""
    profile, xi = profile_named(run.case.profile.kind), run.case.profile.thickness
    offsets = run.bodies.painter.forms.offset
    x = np.stack(np.meshgrid(*run.grid.face_coordinates(component), indexing="ij"), axis=-1)
    total = np.zeros(x.shape[:3])
    for b, particle in enumerate(run.case.particles):
        state = run.bodies.state
        # What has no end along an axis has no image there either.
        repeats = run.grid.periodic & np.isfinite(run.bodies.painter.half_sides(state.rotation)[b])
        counts = [(-1, 0, 1) if again else (0,) for again in repeats]
        for image in itertools.product(*counts):
            r = x - state.position[b] - np.multiply(image, run.grid.lengths)
            r = rotations.rotate(rotations.conjugate(state.quaternion[b]), r)
            z = (build_shape(particle).distance(r) - offsets[b, 0]) / xi
            phi = np.where(np.abs(z) > profile.half_width, z < 0, profile.value(z))
            total += phi
    first = run.flow.boundaries[component].first_unknown(component)
    along = [slice(first if d == component else 1, n + 1) for d, n in enumerate(run.grid.shape)]
    inside = np.zeros_like(total)
    inside[tuple(along)] = total[tuple(along)]
    # Where bodies overlap they share what is solid.
    return interior(np.minimum(inside, 1.0))


BODIES = {
    "sphere across a periodic end": [sphere([3.9, 2.0, 2.0])],
    "sphere touching a wall": [sphere([1.0, 0.8, 2.0])],
    "turned box": [
        {"shape": "box", "sides": [1.4, 1.0, 0.8], "position": [0.1, 2, 2], "orientation": TURN}
    ],
    "turned ellipsoid, planar offset": [
        {
            "shape": "ellipsoid",
            "radii": [0.9, 0.6, 0.5],
            "position": [2, 2, 2],
            "orientation": TURN,
        }
    ],
    "cylinder through the box": [
        {"shape": "cylinder", "radius": 0.7, "position": [0, 2, 2], "axis": [1, 0, 0]}
    ],
    "tilted capsule": [
        {"shape": "capsule", "radius": 0.5, "length": 1, "position": [3.5, 2, 2], "axis": [1, 1, 1]}
    ],
    "plane": [{"shape": "plane", "position": [2, 1, 2], "normal": [0, 1, 0]}],
    "two bodies whose layers overlap": [sphere([1.0, 2, 2]), sphere([2.7, 2, 2])],
}


@pytest.mark.parametrize("name", BODIES)
@pytest.mark.parametrize("kind", ["tanh", "sine"])
def test_windows_miss_nothing_of_the_indicator(name, kind):
    # ξ = .1, so that no layer of 8ξ meets its own image.
    run = simulation(
        *BODIES[name], kind=kind, cells=[24, 11, 12], **MIXED, thickness=0.1, retract="planar"
    )
    for c in range(3):
        painted = interior(run.bodies.painter.dense(c))
        # Two ways to the same distance: round-off of d over ξ = .1.
        assert np.abs(painted - exact_indicator(run, c)).max() < 1e-12


def test_a_body_that_moved_is_painted_where_it_is():
    run = simulation(
        {
            "shape": "box",
            "sides": [1.4, 1.0, 0.8],
            "position": [0.4, 2.0, 2.0],
            "velocity": [-30.0, 0.0, 0.0],
            "angular_velocity": [0.0, 7.0, 3.0],
        },
        cells=[24, 11, 12],
        thickness=0.1,
        viscosity=100.0,
        retract=False,
        **MIXED,
    )
    steps(run, 17)
    assert run.bodies.state.position[0, 0] < -2 * run.grid.lengths[0]
    run.bodies.state.position[0, 0] += 3 * run.grid.lengths[0]
    for c in range(3):
        painted = interior(run.bodies.painter.dense(c))
        # Round-off of a position three periods away, over ξ.
        assert np.abs(painted - exact_indicator(run, c)).max() < 1e-12


def mean_over_layers(volume, xi, offset):
    """∫φ dV = ∫V(δ) p(δ) dδ of tanh: V(δ) encloses {d < δ}, p = sech²((δ−o)/ξ)/2ξ."""
    delta, step = np.linspace(-9 * xi, 9 * xi, 4001, retstep=True)
    weights = 0.5 * step / (xi * np.cosh(delta / xi) ** 2)
    return float(sum(w * volume(d + offset) for d, w in zip(delta, weights, strict=True)))


def steiner(volume, surface, bend, inner):
    """Volumes of parallel bodies: Steiner's V + Sδ + Mδ² + 4πδ³/3 outside, `inner` inside."""

    def enclosed(d):
        return volume + surface * d + bend * d**2 + 4 / 3 * math.pi * d**3 if d > 0 else inner(d)

    return enclosed


def cylinder_volume(a, length):
    return steiner(
        math.pi * a**2 * length,
        2 * math.pi * a * (a + length),
        math.pi * length + math.pi**2 * a,
        lambda d: math.pi * (a + d) ** 2 * (length + 2 * d),
    )


def box_volume(x, y, z):
    return steiner(
        x * y * z,
        2 * (x * y + y * z + z * x),
        math.pi * (x + y + z),
        lambda d: (x + 2 * d) * (y + 2 * d) * (z + 2 * d),
    )


def ball(a):
    return lambda d: 4 / 3 * math.pi * (a + d) ** 3


VOLUMES = {
    "sphere": ({"radius": 1.2}, ball(1.2)),
    "capsule": (
        {"radius": 1.0, "length": 1.5, "axis": [1, 1, 0.5]},
        lambda d: ball(1.0)(d) + math.pi * (1.0 + d) ** 2 * 1.5,
    ),
    "cylinder": ({"radius": 1.1, "length": 2.4, "axis": [1, 1, 0.5]}, cylinder_volume(1.1, 2.4)),
    "box": ({"sides": [2.2, 2.4, 2.6], "orientation": TURN}, box_volume(2.2, 2.4, 2.6)),
    "union": (
        {
            "parts": [
                {"shape": "sphere", "radius": 0.9, "position": [-1.2, 0, 0]},
                {"shape": "sphere", "radius": 0.8, "position": [1.2, 0, 0]},
            ]
        },
        lambda d: ball(0.9)(d) + ball(0.8)(d),
    ),
}


@pytest.mark.parametrize("name", VOLUMES)
@pytest.mark.parametrize("retract", [False, "planar"])
def test_painted_volume(name, retract):
    sizes, enclosed = VOLUMES[name]
    body = {"shape": name, "position": [3.01, 2.97, 3.04], **sizes}
    run = simulation(body, retract=retract, **FINE)
    painter, xi = run.bodies.painter, run.case.profile.thickness
    offset = float(painter.forms.offset[0, 0])
    assert (offset == 0.0) == (retract is False)
    expected = mean_over_layers(enclosed, xi, offset)
    # Sharp edges and the seam between two parts are not smooth on the grid: to (Δx/a)².
    tolerance = 1e-6 if name in ("sphere", "capsule") else 1e-3
    for c in range(3):
        volume = (interior(painter.dense(c)) * cell_volumes(run.grid, c)).sum()
        assert volume == pytest.approx(expected, rel=tolerance)
    # The check can fail: the offset alone is worth far more than the tolerance.
    if offset:
        assert mean_over_layers(enclosed, xi, 0.0) != pytest.approx(expected, rel=10 * tolerance)


def test_ellipsoid_is_painted_by_its_curvature():
    radii = [1.4, 1.0, 0.8]
    body = {"shape": "ellipsoid", "radii": radii, "position": [3, 3, 3], "orientation": TURN}
    run = simulation(body, step=0.2, **FINE)
    planar, bend = run.bodies.painter.forms.offset[0]
    assert bend > 0.0  # translation: rounder places are painted farther out
    n = np.random.default_rng(1).standard_normal((20, 3))
    surface = n / np.sqrt((n**2 / np.square(radii)).sum(axis=1))[:, None]
    normal = surface / np.square(radii)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    # φ = ½ where the distance is what the offsets say: kept along the normal at each point.
    moved = [planar + bend * curvature(1, *radii, *x) for x in surface]
    outward = surface + np.array(moved)[:, None] * normal
    places = rotations.rotate(run.bodies.state.quaternion[0], outward) + 3.0
    values = sp.simulation.sampling.interpolate(run.grid, run.bodies.painter.dense(0), 0, places)
    # Trilinear interpolation: (Δx/ξ)²/8·max φ'' ~ .03.
    assert np.abs(values - 0.5).max() < 0.05
    without = rotations.rotate(run.bodies.state.quaternion[0], surface) + 3.0
    wrong = sp.simulation.sampling.interpolate(run.grid, run.bodies.painter.dense(0), 0, without)
    assert np.abs(wrong - 0.5).max() > 0.1


OBLONG = {
    "shape": "ellipsoid",
    "radii": [0.9, 0.7, 0.5],
    "position": [3.8, 1.8, 2.1],
    "orientation": TURN,
}


def test_loads_are_what_the_fluid_loses():
    """F and T of a body of constant velocity against their integrals, on a stretched grid."""
    body = {**OBLONG, "velocity": [0.5, -0.3, 0.2]}
    run = simulation(body, cells=[12, 13, 11], thickness=0.1, density=1.7, **MIXED, **STRETCHED)
    bodies, state, scheme = run.bodies, run.bodies.state, SCHEMES["bdf2"]
    for n in range(4):
        bodies.move(0.02 * n, 0.02 * max(n - 1, 0), scheme.levels)
    bodies.paint()
    fields = random_velocity(run)
    before = [interior(f).copy() for f in fields]
    bodies.impose(fields, scheme, 0.02)
    force, torque = np.zeros(3), np.zeros(3)
    for c in range(3):
        r, phi = body_coordinates(run, c), interior(bodies.painter.dense(c))
        gained = interior(fields[c]) - before[c]
        # The velocity becomes (1−φ)u + φu_p, to its own round-off.
        assert np.abs(gained - phi * (state.velocity[0, c] - before[c])).max() < 1e-13
        unit = np.zeros((3, 1, 1, 1))
        unit[c] = 1.0
        load = -1.7 * scheme.gamma / 0.02 * gained * cell_volumes(run.grid, c)
        force[c] = load.sum()
        torque += (np.cross(r, unit, axis=0) * load).sum(axis=(1, 2, 3))
    # Sums of some thousand terms of size 1/Δt = 50.
    assert state.force[0] == pytest.approx(force, abs=1e-10 * np.abs(force).max())
    assert state.torque[0] == pytest.approx(torque, abs=1e-10 * np.abs(torque).max())


def test_velocity_imposed_is_that_of_a_rigid_body():
    motion = {"angular_velocity": [0.2, 0.5, -1.0], "velocity": [0.1, 0, 0.3]}
    run = simulation({**OBLONG, **motion}, thickness=0.1)
    fields = random_velocity(run)
    before = [interior(f).copy() for f in fields]
    run.bodies.impose(fields, SCHEMES["backward-euler"], 0.02)
    for c in range(3):
        phi = interior(run.bodies.painter.dense(c))
        spin = np.cross([0.2, 0.5, -1.0], body_coordinates(run, c), axisb=0, axisc=0)
        target = [0.1, 0.0, 0.3][c] + spin[c]
        change = interior(fields[c]) - before[c]
        assert np.abs(change - phi * (target - before[c])).max() < 1e-13


def test_the_matrix_of_the_impulse_is_what_unit_motions_carry():
    """∫φu_p and ∫r×φu_p of each unit V and Ω, summed over the grid, of a body off its points."""
    run = simulation({**OBLONG, "motion": "free", "density": 2.0}, thickness=0.15)
    columns = []
    for n in range(6):
        motion, column = np.eye(6)[n], np.zeros(6)
        for c in range(3):
            r = body_coordinates(run, c)
            velocity = motion[c] + np.cross(motion[3:], r, axisb=0, axisc=0)[c]
            carried = interior(run.bodies.painter.dense(c)) * velocity * cell_volumes(run.grid, c)
            unit = np.eye(3)[c][:, None, None, None]
            column[c] = carried.sum()
            column[3:] += (np.cross(r, unit, axis=0) * carried).sum(axis=(1, 2, 3))
        columns.append(column)
    matrix = run.bodies.impulse.matrix(run.bodies.painter)[0]
    # Sums of some hundred terms.
    assert np.abs(matrix - np.array(columns).T).max() < 1e-13
    # Off the grid's points V and Ω are tied to each other.
    assert np.abs(matrix[:3, 3:]).max() > 1e-4


@pytest.mark.parametrize("scheme", SCHEMES)
def test_displaced_fluid_has_the_inertia_of_the_true_body(scheme):
    """F = ρV dV/dt, T = ρ(I dΩ/dt + Ω×IΩ), of the scheme, in fluid that moves along.

    The surface is painted far out for this step, which must not count.
    """
    body = {
        **OBLONG,
        "position": [2.0, 1.8, 2.1],
        "velocity": {"amplitude": [0.5, -0.3, 0.2], "angular_frequency": 3.0},
        "angular_velocity": {"amplitude": [0.0, 0.0, 0.7], "angular_frequency": 2.0},
    }
    run = simulation(body, density=1.7, cells=[40] * 3, thickness=0.1, viscosity=1.5)
    assert run.particles[0]["painted_offset"] > 0.05
    dt, table = 0.02, SCHEMES[scheme]
    bodies, state = run.bodies, run.bodies.state
    velocities = []
    for n in range(table.levels + 1):
        bodies.move(n * dt, max(n - 1, 0) * dt, table.levels)
        velocities.insert(0, (state.velocity[0].copy(), state.angular_velocity[0].copy()))
    bodies.paint()
    fields = tuple(run.grid.zeros() for _ in range(3))
    for c, field in enumerate(fields):
        spin = np.cross(state.angular_velocity[0], body_coordinates(run, c), axisb=0, axisc=0)
        interior(field)[...] = state.velocity[0, c] + spin[c]
    bodies.impose(fields, table, dt)
    weights = (table.gamma, *(-a for a in table.past))
    rates = [
        sum(w * v[kind] for w, v in zip(weights, velocities, strict=False)) / dt
        for kind in range(2)
    ]
    shape, turn = build_shape(run.case.particles[0]), state.rotation[0]
    force = 1.7 * shape.volume * rates[0]
    inertia, spin = turn @ shape.inertia @ turn.T, state.angular_velocity[0]
    torque = 1.7 * (inertia @ rates[1] + np.cross(spin, inertia @ spin))
    # No impulse was needed, so that only round-off of sums of u_p/Δt is left.
    assert state.force[0] == pytest.approx(force, abs=1e-10 * np.abs(force).max())
    assert state.torque[0] == pytest.approx(torque, abs=1e-9 * np.abs(torque).max())


def test_overlapping_layers_do_not_depend_on_the_order_of_bodies():
    pair = [sphere([1.0, 2, 2]), sphere([2.7, 2, 2], velocity=[1.0, 0, 0])]
    found = []
    for order in (pair, pair[::-1]):
        run = simulation(*order)
        fields = random_velocity(run)
        run.bodies.impose(fields, SCHEMES["bdf2"], 0.02)
        found.append((*fields, run.bodies.state.force[:: 1 if order is pair else -1]))
    for first, second in zip(*found, strict=True):
        assert np.abs(first - second).max() < 1e-11  # two terms added in another order


def test_mean_that_the_impulse_adds_is_foretold():
    run = simulation(sphere([1, 2, 2], velocity=[1.0, 0.2, 0.1], angular_velocity=[0, 1, 2]))
    fields = random_velocity(run)
    before = [run.flow.mean_flow.plain_mean(f, c) for c, f in enumerate(fields)]
    run.bodies.settle(fields, SCHEMES["backward-euler"], 0.02)
    foretold = [run.bodies.added_mean(f, c, True) for c, f in enumerate(fields)]
    run.bodies.impose(fields, SCHEMES["backward-euler"], 0.02)
    after = [run.flow.mean_flow.plain_mean(f, c) for c, f in enumerate(fields)]
    assert np.subtract(after, before) == pytest.approx(foretold, abs=1e-14)


def test_prescribed_motion_integrates_its_velocity():
    """R(t) and q(t) of sinusoids against closed forms, in steps of unequal length."""
    spin = {"amplitude": [0, 0, 2.0], "angular_frequency": 3.0, "phase": 0.5}
    speed = {"constant": [0.1, 0, 0], "amplitude": [0, 1, 0], "angular_frequency": 2.0}
    run = simulation(sphere([2, 2, 2], velocity=speed, angular_velocity=spin))
    state, motion = run.bodies.state, run.bodies.motion
    times = np.cumsum([0.0, 0.3, 0.05, 0.7])
    for since, time in itertools.pairwise(times):
        motion.place(state, time, since)
    t = times[-1]
    angle = 2.0 / 3.0 * (math.sin(3 * t + 0.5) - math.sin(0.5))
    assert state.position[0] == pytest.approx([2 + 0.1 * t, 2 + 0.5 * math.sin(2 * t), 2])
    assert state.quaternion[0] == pytest.approx(rotations.from_axis_angle([0, 0, 1], angle))
    assert state.velocity[0] == pytest.approx([0.1, math.cos(2 * t), 0])
    assert state.angular_velocity[0] == pytest.approx(Signal(**spin).at(t))


def test_a_course_in_python_overrules_the_case():
    def course(t):
        return (
            np.array([2.0, 2 + t, 2]),
            np.array([1.0, 0, 0, 0]),
            np.array([0, 1.0, 0]),
            np.zeros(3),
        )

    run = simulation(sphere([2, 2, 2], name="ball"), courses={"ball": course})
    steps(run, 3)
    assert run.particles[0]["position"] == pytest.approx([2, 2.06, 2])
    with pytest.raises(sp.CaseError, match="courses names 'bal'"):
        simulation(sphere([2, 2, 2], name="ball"), courses={"bal": course})


def test_displaced_fluid_has_centripetal_inertia():
    """Fluid that turns with an off-centre body needs no impulse, but ρV Ω×(Ω×c) of force."""
    place = np.array([0.7, 0.2, 0.0])
    part = {"shape": "sphere", "radius": 0.6, "position": place.tolist()}
    body = {"shape": "union", "parts": [part], "position": [2.0, 2.0, 2.0]}
    body["angular_velocity"] = [0.0, 0.0, 1.5]
    run = simulation(body, thickness=0.1, density=1.7, cells=[40] * 3)
    run.bodies.move(0.0, 0.0, 1)
    fields = tuple(run.grid.zeros() for _ in range(3))
    for c, field in enumerate(fields):
        spin = np.cross([0.0, 0.0, 1.5], body_coordinates(run, c), axisb=0, axisc=0)
        interior(field)[...] = spin[c]
    run.bodies.impose(fields, SCHEMES["backward-euler"], 0.02)
    expected = -(1.5**2) * place * 1.7 * 4 / 3 * math.pi * 0.6**3
    # No impulse was needed but in the tails of φ, 1e-6, beyond half the box.
    assert run.bodies.state.force[0] == pytest.approx(expected, abs=1e-5 * np.abs(expected).max())


def test_a_body_that_nearly_fills_the_box_meets_its_images():
    """One body in a box and two in a box twice as long are the same suspension."""
    painted = []
    for copies in (1, 2):
        bodies = [sphere([2.0 + 4 * i, 2.0, 2.0], radius=1.7) for i in range(copies)]
        run = simulation(*bodies, lengths=[4.0 * copies, 4, 4], cells=[12 * copies, 12, 12])
        painted.append(interior(run.bodies.painter.dense(1))[:12])
    assert np.abs(painted[0] - painted[1]).max() < 1e-6  # tanh is cut off at 1e-7


def test_a_part_far_from_its_body_is_painted_whole():
    part = {"shape": "sphere", "radius": 0.8, "position": [1.6, 0.0, 0.0]}
    body = {"shape": "union", "parts": [part], "position": [2.0, 2.0, 2.0]}
    run = simulation(body, thickness=0.1, cells=[24, 24, 24])
    painted = interior(run.bodies.painter.dense(1))
    assert np.abs(painted - exact_indicator(run, 1)).max() < 1e-6


def test_inertia_of_a_part_off_its_position_acts_at_the_part():
    """Fluid and body speed up alike along a line: T = c×F, wherever the surface is painted."""
    place = np.array([0.7, 0.2, 0.0])
    part = {"shape": "sphere", "radius": 0.6, "position": place.tolist()}
    body = {"shape": "union", "parts": [part], "position": [2.0, 2.0, 2.0]}
    body["velocity"] = {"amplitude": [0.2, -0.3, 0.5], "angular_frequency": 3.0}
    run = simulation(body, thickness=0.1, viscosity=1.5, cells=[40] * 3)
    for n in range(2):
        run.bodies.move(0.02 * n, 0.0, 1)
    run.bodies.paint()
    fields = tuple(run.grid.zeros() + speed for speed in run.bodies.state.velocity[0])
    run.bodies.impose(fields, SCHEMES["backward-euler"], 0.02)
    force, torque = run.bodies.state.force[0], run.bodies.state.torque[0]
    expected = np.cross(place, force)
    assert torque == pytest.approx(expected, abs=1e-10 * np.abs(expected).max())


def test_inertia_of_an_endless_cylinder_is_that_in_the_box():
    """ρπa²L of mass and half its a² about the axis, off the body's position as it stands."""
    body = {"shape": "cylinder", "radius": 1.0, "position": [2.0, 1.9, 2.0]}
    body["velocity"] = {"amplitude": [0.2, 0.1, 0.0], "angular_frequency": 3.0}
    run = simulation(body, thickness=0.2, cells=[64, 64, 6])
    inertia = run.bodies.displaced
    volume = math.pi * 4.0
    # Painted with ξ = .047a: π²/12·(ξ/a)² = .2 % more volume, six times that of second moment.
    assert inertia.volume[0] == pytest.approx(volume, rel=0.003)
    assert inertia.centroid[0, :2] == pytest.approx([0.0, 0.0], abs=1e-4)
    assert inertia.inertia[0, 2, 2] == pytest.approx(0.5 * volume, rel=0.015)
