"""Flows with bodies whose answers are known, as small runs: slabs, and a sphere in a box."""

import numpy as np
import scipy.linalg

from coupled import simulation, sphere
from smoothprofile import calibration
from smoothprofile.profiles import profile_named

WIDTH = 0.1


def couette(k, scheme="backward-euler", gap=6.0, cells_per_layer=4, axis=1, **changes):
    """A plane body that slides at 1 over a wall at rest; lengths in ξ, ν = 1, Δt = k².

    Returns the run, at steady state, and the stress on the wall.
    """
    across, along = axis, (axis + 1) % 3
    solid = 2.0 + 5.0 * max(k, 0.4)
    lengths, cells, boundaries = [WIDTH] * 3, [2] * 3, ["periodic"] * 3
    lengths[across], boundaries[across] = gap + solid, "wall"
    cells[across] = round((gap + solid) * cells_per_layer)
    slide, normal, position = np.zeros(3), np.zeros(3), np.full(3, 0.5 * WIDTH)
    slide[along], normal[across], position[across] = 1.0, -1.0, gap
    name = "xyz"[across]
    body = {
        "shape": "plane",
        "position": position.tolist(),
        "normal": normal.tolist(),
        "velocity": slide.tolist(),
    }
    run = simulation(
        body,
        lengths=lengths,
        cells=cells,
        boundaries=boundaries,
        wall_velocity={f"{name}_high": slide.tolist()},
        viscosity=1.0,
        thickness=1.0,
        step=float(k**2),
        scheme=scheme,
        **changes,
    )
    # From the flow under a wall that is not moved: the shift has to be found by the steps.
    start = np.clip(run.grid.axes[across].padded_centres / gap, 0.0, 1.0)
    shape = [1, 1, 1]
    shape[across] = -1
    run.state.velocity[along][...] = start.reshape(shape)
    run.flow.fill(run.state.velocity, 0.0)
    for _ in range(20000):
        run.step_once()
        if run.extremes.rate(run.time_step) < 1e-5 / gap**2 and run.steps > 4:
            force = run.wall_force[f"{name}_low"] / WIDTH**2
            return run, force[along]
    raise AssertionError("the flow does not settle")


FLUID, SOLID = 3.0, 0.75


def stokes_layer(k, thickness, scheme="crank-nicolson", cells_per_layer=4, periods=1.5, **changes):
    """A plane body, 0 < y < SOLID, that moves as cos t; ν = 1. No Stokes layer at y = 0.

    Returns amplitude and phase error of the stress on its face against the exact sin(t − π/4),
    from the last period, a force counting for the end of its step.
    """
    per_period = round(2 * np.pi / (k * thickness) ** 2)
    dt, height = 2 * np.pi / per_period, FLUID + SOLID
    depth = np.sqrt(0.5) * FLUID
    body = {
        "shape": "plane",
        "position": [0.5 * WIDTH, SOLID, 0.5 * WIDTH],
        "normal": [0, 1, 0],
        "velocity": {"amplitude": [1, 0, 0], "angular_frequency": 1.0},
    }
    far = {"amplitude": [float(np.exp(-depth)), 0, 0], "angular_frequency": 1.0}
    run = simulation(
        body,
        lengths=[WIDTH, height, WIDTH],
        cells=[2, round(height / thickness * cells_per_layer), 2],
        boundaries=["periodic", ["slip", "wall"], "periodic"],
        wall_velocity={"y_high": {**far, "phase": -float(depth)}},
        viscosity=1.0,
        thickness=thickness,
        step=dt,
        scheme=scheme,
        **changes,
    )
    y = np.minimum(0.0, np.sqrt(0.5) * (SOLID - run.grid.axes[1].padded_centres))
    run.state.velocity[0][...] = (np.exp(y) * np.cos(y))[None, :, None]
    run.flow.fill(run.state.velocity, 0.0)
    force = np.zeros(round(periods * per_period))
    for n in range(force.size):
        run.step_once()
        force[n] = run.bodies.state.force[0, 0] / WIDTH**2
    last = np.arange(force.size - per_period, force.size)
    ratio = response(force[last], dt * (last + 1)) / (-1j * np.exp(-0.25j * np.pi))
    return abs(ratio) - 1.0, float(np.angle(ratio))


def response(signal, times):
    """c of Re(c e^{it}), over whole periods."""
    return 2.0 / signal.size * (signal * np.exp(-1j * times)).sum()


def stokes_layer_theory(k, thickness, cells_per_layer=4, kind="tanh"):
    """The same errors of Crank–Nicolson from its equations in the frequency domain.

        (zS − U)/Δt = ½ν(zS + U)″,   U = S + φ(1 − S),   z = e^{iωΔt}
        F/Δt⁻¹ = h(1 − 1/z) − ∫φ(1 − S)dy   of a body h thick, at the end of the step

    uˢ = Re S zⁿ⁺¹, uⁿ = Re U zⁿ, on the cells of `stokes_layer`: one banded solve.
    """
    per_period = round(2 * np.pi / (k * thickness) ** 2)
    dt, height = 2 * np.pi / per_period, FLUID + SOLID
    n = round(height / thickness * cells_per_layer)
    h = height / n
    y = h * (np.arange(n) + 0.5)
    phi = profile_named(kind).value((y - SOLID) / thickness)
    z, far = np.exp(1j * dt), np.exp(-(1 + 1j) * np.sqrt(0.5) * FLUID)
    # U = φ + (1−φ)S; the ghost above the far wall is 2·wall − value, wall = far·(z + 1) for zS + U.
    c = 0.5 * dt / h**2
    weight, source = z + 1 - phi, phi.astype(complex)
    matrix = np.zeros((3, n), complex)
    matrix[0, 1:] = -c * weight[1:]
    matrix[2, :-1] = -c * weight[:-1]
    diagonal = np.full(n, 2.0)
    diagonal[0], diagonal[-1] = 1.0, 3.0
    matrix[1] = z - (1 - phi) + c * diagonal * weight
    right = source - c * diagonal * source
    right[1:] += c * source[:-1]
    right[:-1] += c * source[1:]
    right[-1] += 2 * c * far * (z + 1)
    s = scipy.linalg.solve_banded((1, 1), matrix, right)
    force = (SOLID * (1 - 1 / z) - (phi * (1 - s)).sum() * h) / dt
    ratio = force / (-1j * np.exp(-0.25j * np.pi))
    return abs(ratio) - 1.0, float(np.angle(ratio))


class Sphere:
    """A sphere of radius 1 in a periodic cube of n³ cells, ν = ρ = 1, and its motion."""

    def __init__(self, n, thickness=0.3, cells_per_layer=1.5, k=None, kind="tanh", **changes):
        scheme = changes.get("scheme", "backward-euler")
        self.width = thickness / cells_per_layer
        self.length = n * self.width
        self.dt = (
            calibration.best_time_step(thickness, 1.0, kind, scheme)
            if k is None
            else (k * thickness) ** 2
        )
        self.settings = {
            "lengths": [self.length] * 3,
            "cells": [n] * 3,
            "viscosity": 1.0,
            "thickness": thickness,
            "kind": kind,
            "step": self.dt,
            **changes,
        }
        # Off the symmetry planes of the cells.
        self.centre = 0.5 * self.length + self.width * np.array([0.07, -0.21, 0.33])

    @property
    def fraction(self):
        """Volume fraction of the sphere."""
        return 4 / 3 * np.pi / self.length**3

    def translate(self, velocity, held=False):
        """Moving through fluid of no mean velocity; `held` puts it to rest in the opposite flow."""
        mean = -np.array(velocity) if held else np.zeros(3)
        body = sphere(self.centre, 1.0, **({} if held else {"velocity": list(velocity)}))
        means = dict(zip("xyz", mean.tolist(), strict=True))
        return simulation(body, mean_velocity=means, **self.settings)

    def turn(self, spin):
        """Turning about its centre in fluid that is otherwise at rest, creeping flow."""
        body = sphere(self.centre, 1.0, angular_velocity=list(spin))
        return simulation(body, advection=False, **self.settings)


def wiggle(run, direction, steps_per_cell, cells=2, settle=6.0):
    """Peak-to-peak of the force along `direction` over some cells of travel, over its mean.

    Taken once `settle` units of time have passed; a straight line, what is left of the start, is
    taken out.
    """
    for _ in range(round(settle / run.time_step)):
        run.step_once()
    forces = []
    for _ in range(cells * steps_per_cell):
        run.step_once()
        forces.append(run.bodies.state.force[0] @ direction / (direction @ direction))
    forces, n = np.array(forces), np.arange(cells * steps_per_cell)
    left = forces - np.polyval(np.polyfit(n, forces, 1), n)
    return np.ptp(left) / abs(forces.mean()), forces.mean()
