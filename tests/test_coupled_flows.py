"""Flows with bodies against closed forms: the quick ones; more in test_slow_physics.py."""

import numpy as np
import pytest

from coupled import SCHEMES, settle, simulation, sphere, steps
from known_flows import (
    WIDTH,
    Sphere,
    couette,
    stokes_layer,
    stokes_layer_theory,
    wiggle,
)
from smoothprofile.calibration import interface_shift


@pytest.mark.parametrize("k", [0.5, 2.0])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_flat_wall_acts_where_the_closed_form_says(scheme, k):
    """τ = Vν/(h + ξs₀(k)) with the surface painted where it is."""
    run, stress = couette(k, scheme, retract=False)
    expected = 1.0 / (6.0 + interface_shift("tanh", k, scheme))
    # Four cells to ξ: 3e-4 of discretisation at h = 6ξ, falling as Δy².
    assert stress == pytest.approx(expected, rel=1e-3)
    assert stress != pytest.approx(1 / 6, rel=0.05)
    # The plane slides along z: nothing pushes it along x, nor lifts it.
    assert np.abs(run.bodies.state.force[0, :2]).max() < 1e-13 * stress
    # The plane, the wall before it and the one behind it: nothing else takes momentum.
    total = run.bodies.state.force[0] + run.wall_force["total"]
    assert np.abs(total).max() / WIDTH**2 < 1e-4 * stress  # as steady as it was run


@pytest.mark.parametrize("k", [0.5, 2.0])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_flat_wall_moved_for_the_step_acts_where_it_is(scheme, k):
    _, stress = couette(k, scheme, retract=True)
    assert stress == pytest.approx(1 / 6, rel=1e-3)


def test_flat_walls_are_alike_along_all_axes():
    stresses = [couette(1.0, retract=False, axis=axis)[1] for axis in range(3)]
    # Other transforms for each axis; what differs is when the run counts as steady.
    assert np.ptp(stresses) < 1e-8


def test_oscillating_plane_is_that_of_its_equations():
    for k, xi in ((0.8718, 0.2), (1.2, 0.3)):
        found = stokes_layer(k, xi, periods=2.5, retract=False)
        # The start is not quite periodic: e^{−ω·…} of it is left after 1.5 periods, ~1e-6.
        assert found == pytest.approx(stokes_layer_theory(k, xi), abs=1e-5)


def test_oscillating_plane_has_its_published_errors():
    """Crank–Nicolson, ξ = .05: the equations on a mesh fine enough not to matter."""
    amplitude, phase = stokes_layer_theory(0.8718, 0.05, 32)
    assert amplitude == pytest.approx(-0.00314, abs=5e-6)
    assert phase == pytest.approx(-0.00628, abs=5e-6)
    # k = .807 and .756 are given to three digits; the errors change by .05 a unit of k.
    assert abs(stokes_layer_theory(0.807, 0.05, 32)[0]) < 0.0005 * 0.06
    assert abs(stokes_layer_theory(0.756, 0.05, 32)[1]) < 0.0005 * 0.06


def test_oscillating_plane_moved_for_the_step_has_the_right_amplitude():
    """With the surface moved only ωξ²/ν is left, whatever the step."""
    for k in (0.6, 1.4):
        amplitude, _ = stokes_layer(k, 0.1, periods=1.0, retract=True)
        assert abs(amplitude) < 2e-3


def test_translating_sphere_does_not_feel_the_grid():
    """Peak to peak of the force over two cells of travel, eight steps to the cell."""
    case = Sphere(20)
    direction = np.array([1.0, 0.5, 0.25])
    velocity = case.width / 8 / case.dt * direction
    found, force = wiggle(case.translate(velocity), direction, 8, cells=8)
    # Aliases of tanh on a grid go as e^{−π²ξ/Δx} = 3.7e-7; 1.1 to 2 times that at ξ/Δx = .6 to 1.5.
    assert found < 3 * np.exp(-(np.pi**2) * 1.5)
    assert force < 0
    # A layer thinner than a cell does feel it.
    coarse = Sphere(16, thickness=0.3, cells_per_layer=0.6)
    velocity = coarse.width / 8 / coarse.dt * direction
    rough, _ = wiggle(coarse.translate(velocity), direction, 8, cells=8)
    assert 1 < rough / np.exp(-(np.pi**2) * 0.6) < 3


def test_force_is_the_same_in_a_frame_that_moves():
    """A sphere held in a stream, and one that moves through fluid at rest: Galileo."""
    case = Sphere(20)
    velocity = np.array([0.5, 0.2, -0.1])
    held = steps(case.translate(velocity, held=True), 160)
    moving = steps(case.translate(velocity), 160)
    force = held.bodies.state.force[0]
    # Explicit advection and backward Euler see the motion of order VΔt/ξ·VΔt ~ 1e-3.
    assert moving.bodies.state.force[0] == pytest.approx(force, abs=1e-3 * np.linalg.norm(force))
    assert np.linalg.norm(force) > 10 * np.linalg.norm(velocity)


def test_turning_sphere():
    """T = −8πμa³Ω/(1 − c) in a simple cubic array of spheres that turn in step, c small."""
    case = Sphere(30)
    spin = np.array([0.3, -0.5, 0.8])
    run = settle(case.turn(spin), 1e-4)
    torque = run.bodies.state.torque[0]
    exact = -8 * np.pi * spin / (1 - case.fraction)
    # .4 % of Δx² at ξ/Δx = 1.5; 1/(1−c) is within 2e-5 of the published value at c = .03.
    assert torque == pytest.approx(exact, abs=0.01 * np.linalg.norm(exact))
    assert np.abs(run.bodies.state.force[0]).max() < 1e-5
    # Painted where it is, it is 7 % off.
    assert run.particles[0]["painted_offset"] < -0.02


def test_ellipsoid_in_a_stream_turns_across_it():
    """Drag along the stream, drift towards the long axis, torque that turns it broadside."""
    loads = {}
    for angle, advection in ((30.0, True), (-30.0, True), (30.0, False)):
        run = simulation(
            {
                "shape": "ellipsoid",
                "radii": [1.2, 0.6, 0.6],
                "position": [3.0, 3.0, 2.0],
                "orientation": {"axis": [0, 0, 1], "angle": angle},
            },
            lengths=[6.0, 6.0, 4.0],
            cells=[24, 24, 16],
            viscosity=1.0,
            mean_velocity={"x": 4.0, "y": 0.0},
            step=0.03,
            advection=advection,
        )
        settle(run, 1e-4)
        loads[angle, advection] = run.bodies.state.force[0], run.bodies.state.torque[0]
    (force, torque), (mirrored, other), (creeping, none) = loads.values()
    # Alone in creeping flow F_y/F_x = (X − Y)sc/(Xc² + Ys²), of the resistances of a spheroid 2:1;
    # −.0588 in a box twice as wide. The neighbours here lift it to −.078, inertia to −.086.
    resistance, (c, s) = (0.60197, 0.68945), (np.sqrt(0.75), 0.5)
    alone = -np.diff(resistance)[0] * s * c / (resistance[0] * c**2 + resistance[1] * s**2)
    assert force[0] > creeping[0] > 0
    assert force[1] / force[0] < creeping[1] / creeping[0] < alone < -0.06
    # Cells of two thirds the width change the drift by 2 % of itself, and the torque by 2.4 %.
    assert force[1] / force[0] == pytest.approx(-0.086, rel=0.03)
    assert torque[2] / force[0] == pytest.approx(0.0297, rel=0.04)
    # Turned about its centre a creeping flow is the same but for its sign, a torque is the same.
    assert np.abs(none).max() < 1e-11 * creeping[0]
    # A mirror in y: round-off of some hundred steps.
    assert mirrored == pytest.approx(force * [1, -1, 1], abs=1e-9 * force[0])
    assert other == pytest.approx(-torque, abs=1e-9 * force[0])


def test_ellipsoid_in_shear_is_turned_by_the_vorticity():
    """Held across the flow it takes more torque than along it, and both act as −z."""
    torques = []
    for angle in (0.0, 90.0):
        run = simulation(
            {
                "shape": "ellipsoid",
                "radii": [1.2, 0.6, 0.6],
                "position": [3.0, 3.0, 2.0],
                "orientation": {"axis": [0, 0, 1], "angle": angle},
            },
            lengths=[6.0, 6.0, 4.0],
            cells=[20, 20, 14],
            boundaries=["periodic", "wall", "periodic"],
            wall_velocity={"y_low": [-3.0, 0, 0], "y_high": [3.0, 0, 0]},
            viscosity=1.0,
            advection=False,
            step=0.05,
        )
        torques.append(settle(run, 1e-4).bodies.state.torque[0, 2])
    # Jeffery, alone: −13.07 across, and in the ratio b²/a² = ¼. A layer of b/2, painted for drag,
    # takes more fluid along: the ratio is .328, .291, .273 for ξ = .3, .2, .15, and .334 in a box
    # of side 10; −16.0, −14.3, −13.8 across. Cells of two thirds the width change both by .4 %.
    assert torques[0] / torques[1] == pytest.approx(0.3285, rel=0.01)
    assert torques[1] == pytest.approx(-16.02, rel=0.01)


def test_sphere_of_either_name():
    """A sphere, and an ellipsoid of equal radii, a capsule of almost no length."""
    stream = {"mean_velocity": {"x": 1.0}, "viscosity": 1.0, "retract": "planar", "step": 0.05}
    same = [
        {"shape": "sphere", "radius": 0.8},
        {"shape": "ellipsoid", "radii": [0.8, 0.8, 0.8]},
        {"shape": "capsule", "radius": 0.8, "length": 1e-9},
        {"shape": "union", "parts": [sphere([0, 0, 0])]},
    ]
    forces = [
        steps(simulation({**body, "position": [2.1, 1.9, 2.0]}, **stream), 10).bodies.state.force[0]
        for body in same
    ]
    for force in forces[1:]:
        assert force == pytest.approx(forces[0], rel=1e-6, abs=1e-6)
