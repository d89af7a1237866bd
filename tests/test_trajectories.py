"""trajectory.gsd, read back by the library that other programs read it with."""

import subprocess
import sys
from types import SimpleNamespace

import gsd.hoomd
import numpy as np
import pytest

import smoothprofile as sp
from smoothprofile import rotations, shapes
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.output import RunDirectory
from smoothprofile.particles.bodies import bodies_at
from smoothprofile.trajectories import Trajectory, cut_back, type_shape

LOW, LENGTHS = np.array([-1.0, 0.0, 2.0]), np.array([6.0, 4.0, 5.0])
SINGLE = 1e-6  # single precision keeps seven digits of numbers below ten


def grid():
    """Periodic along x and y, walled along z; not centred anywhere near the origin."""
    return Grid(
        tuple(
            uniform_axis(name, low, length, 8, name != "z")
            for name, low, length in zip("xyz", LOW, LENGTHS, strict=True)
        )
    )


def moment(step, state):
    """What a simulation shows of itself at one moment."""
    return SimpleNamespace(steps=step, time=0.5 * step, bodies=SimpleNamespace(state=state))


def write(path, forms, states, mass=None):
    mass = [np.nan] * len(forms) if mass is None else mass
    names = [f"{form.name} {n}" for n, form in enumerate(forms)]
    trajectory = Trajectory(path, grid(), forms, mass, names)
    for step, state in states:
        trajectory.append(moment(step, state))
    trajectory.close()
    with gsd.hoomd.open(str(path)) as frames:
        return list(frames)


def at_rest(*places, quaternion=(1.0, 0.0, 0.0, 0.0)):
    return bodies_at(places, [quaternion] * len(places))


def test_a_place_is_wrapped_and_its_image_counted(tmp_path):
    places = np.array([[-1.5, 9.0, 3.0], [4.9, 0.1, 6.5], [17.3, -4.2, 2.4]])
    balls = [shapes.sphere(0.3)] * 3
    (frame,) = write(tmp_path / "t.gsd", balls, [(0, at_rest(*places))])
    box, particles = frame.configuration.box, frame.particles
    assert np.allclose(box, [*LENGTHS, 0, 0, 0])
    assert frame.configuration.dimensions == 3
    assert np.all(np.abs(particles.position) <= 0.5 * LENGTHS + SINGLE)
    # −1.5 lies .5 below the box of [−1, 5]: image −1; 9 in [0, 4] image 2; z is walled.
    assert particles.image.tolist() == [[-1, 2, 0], [0, 0, 0], [3, -2, 0]]
    whole = particles.position + particles.image * box[:3] + LOW + 0.5 * LENGTHS
    assert np.allclose(whole, places, atol=10 * SINGLE)


def test_a_quaternion_has_its_scalar_first(tmp_path):
    turn = rotations.from_axis_angle((0, 0, 1), np.pi / 2)
    state = at_rest((0, 1, 4), quaternion=turn)
    (frame,) = write(tmp_path / "t.gsd", [shapes.box((1, 2, 3))], [(0, state)])
    w, x, y, z = frame.particles.orientation[0]
    assert np.allclose([w, x, y, z], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=SINGLE)
    # By the rule of HOOMD, q v q* with q = (w, v): a quarter turn about z brings x to y.
    first = [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)]
    assert np.allclose(first, [0, 1, 0], atol=SINGLE)


def test_motion_loads_and_time_stand_in_each_frame(tmp_path):
    state = at_rest((0, 1, 4), (2, 1, 4))
    state.velocity[:] = [[1, 2, 3], [4, 5, 6]]
    state.angular_velocity[:] = [[0.1, 0.2, 0.3], [0, 0, 1]]
    state.force[:] = [[7, 8, 9], [1, 0, 0]]
    state.torque[:] = [[0, 1, 0], [0, 0, 2]]
    forms = [shapes.sphere(0.3), shapes.ellipsoid((1, 0.5, 0.5))]
    mass = [2.0, np.nan]
    _, frame = write(tmp_path / "t.gsd", forms, [(0, state), (7, state)], mass)
    assert frame.configuration.step == 7
    assert frame.log["time"] == [3.5]
    for name, values in (("force", state.force), ("torque", state.torque)):
        assert np.array_equal(frame.log[f"particles/{name}"], values)
    assert np.allclose(frame.log["particles/angular_velocity"], state.angular_velocity)
    assert np.array_equal(frame.particles.velocity, state.velocity)
    assert frame.particles.mass.tolist() == [2.0, 0.0]
    assert np.allclose(frame.particles.moment_inertia, [[0.4 * 2 * 0.09] * 3, [0] * 3])


def test_each_body_has_the_type_of_its_form(tmp_path):
    rod = shapes.capsule(0.2, 1.0)
    forms = [shapes.sphere(0.3), rod, shapes.sphere(0.4), shapes.box((1, 1, 1)), rod]
    forms.insert(1, shapes.plane())  # has no end, and is left out
    state = at_rest(*np.arange(18.0).reshape(6, 3))
    (frame,) = write(tmp_path / "t.gsd", forms, [(0, state)])
    particles = frame.particles
    assert particles.N == 5
    assert particles.types == ["sphere", "capsule 2", "box 4"]
    assert particles.typeid.tolist() == [0, 1, 0, 2, 1]
    # Spheres of two sizes are told apart by their diameters.
    assert particles.type_shapes[0] == {}
    assert np.allclose(particles.diameter[[0, 2]], [0.6, 0.8])
    assert [form["type"] for form in particles.type_shapes[1:]] == ["ConvexPolyhedron"] * 2


def test_forms_are_those_of_the_shapes():
    assert type_shape(shapes.sphere(0.5)) == {"type": "Sphere", "diameter": 1.0}
    radii = {"type": "Ellipsoid", "a": 3.0, "b": 2.0, "c": 1.0}
    assert type_shape(shapes.ellipsoid((3, 2, 1))) == radii
    still = (1.0, 0.0, 0.0, 0.0)
    pair = shapes.union([(shapes.sphere(0.5), (x, 0, 0), still) for x in (-0.4, 0.4)])
    assert type_shape(pair) == {
        "type": "SphereUnion",
        "centers": [[-0.4, 0, 0], [0.4, 0, 0]],
        "diameters": [1.0, 1.0],
    }
    corners = np.array(type_shape(shapes.box((1, 2, 3)))["vertices"])
    assert sorted(map(tuple, np.abs(corners))) == [(0.5, 1.0, 1.5)] * 8


@pytest.mark.parametrize(
    "shape", [shapes.capsule(0.3, 1.2), shapes.cylinder(0.4, 1.5), shapes.ellipsoid((1, 0.5, 0.7))]
)
def test_a_polyhedron_fits_the_shape_it_stands_for(shape):
    turn = rotations.from_axis_angle((1, 2, 3), 0.7)
    placed = shapes.union(
        [(shape, (0.2, 0.1, -0.3), turn), (shapes.box((1, 1, 1)), (3, 0, 0), turn)]
    )
    form = type_shape(placed)
    assert form["type"] == "Mesh"
    vertices, faces = np.array(form["vertices"]), np.array(form["indices"])
    assert np.abs(placed.distance(vertices)).max() < 1e-12
    # Normals outward: ∫x·n dA/3 is the volume, short of it by what 32 chords cut off a circle,
    # 1 − sin(2π/32)/(2π/32) = .6 %, for round shapes in both directions.
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert 0.985 * placed.volume < volume < placed.volume


SETTLING = {
    "domain": {"lengths": [3.0] * 3, "cells": [12] * 3, "boundaries": ["periodic"] * 3},
    "fluid": {"density": 1.0, "viscosity": 0.3, "gravity": [0.0, 0.0, -1.0]},
    "profile": {"thickness": 0.3},
    "particles": [
        {
            "shape": "sphere",
            "radius": 0.7,
            "position": [1.5, 1.5, 0.1],
            "motion": "free",
            "density": 2.0,
            "velocity": [0.0, 0.0, -1.5],
        }
    ],
    "time": {"step": 0.02, "end": 0.2},
    "output": {"every": 2, "fields": []},
}


def test_a_run_leaves_a_frame_for_each_row_of_history(tmp_path):
    simulation = sp.Simulation.from_file(SETTLING)
    path = tmp_path / "run" / "trajectory.gsd"
    with RunDirectory(tmp_path / "run", simulation.case.to_toml()) as run:
        simulation.run(observer=run.record)
        run.finish(simulation)
    with gsd.hoomd.open(str(path)) as frames:
        assert [f.configuration.step for f in frames] == simulation.history["step"]
        assert [float(f.log["time"][0]) for f in frames] == simulation.history["time"]
        last = frames[-1]
    sphere = simulation.particles[0]
    assert last.particles.image[0, 2] == -1
    whole = last.particles.position[0] + last.particles.image[0] * 3.0 + 1.5
    assert np.allclose(whole, sphere["position"], atol=10 * SINGLE)
    assert np.allclose(last.log["particles/force"][0], sphere["force"], rtol=SINGLE)
    assert np.allclose(last.particles.mass, 2.0 * 4 / 3 * np.pi * 0.7**3)
    cut_back(path, 5)
    with gsd.hoomd.open(str(path)) as frames:
        assert [f.configuration.step for f in frames] == [2, 4]


def test_bodies_that_stay_leave_no_trajectory(tmp_path):
    held = {"shape": "sphere", "radius": 0.7, "position": [1.5] * 3}
    simulation = sp.Simulation.from_file({**SETTLING, "particles": [held]})
    with RunDirectory(tmp_path / "run", simulation.case.to_toml()) as run:
        simulation.run(observer=run.record)
    assert not (tmp_path / "run" / "trajectory.gsd").exists()


def test_frames_can_be_read_after_a_kill(tmp_path):
    """All those that were followed by a flush, which comes at most every tenth of a second."""
    path = tmp_path / "t.gsd"
    script = f"""
import os, sys, time
sys.path.insert(0, {str(__file__.rpartition("/")[0])!r})
import test_trajectories as t
from smoothprofile.trajectories import BETWEEN_FLUSHES
trajectory = t.Trajectory({str(path)!r}, t.grid(), [t.shapes.sphere(0.3)], [1.0], ["ball"])
for step in range(3):
    trajectory.append(t.moment(step, t.at_rest((0, 1, 4 + 0.1 * step))))
    time.sleep(1.2 * BETWEEN_FLUSHES)
os._exit(9)
"""
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 9
    with gsd.hoomd.open(str(path)) as frames:
        assert [f.configuration.step for f in frames] == [0, 1, 2]
