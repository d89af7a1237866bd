"""Small runs with bodies that several test files share, and their books of momentum."""

import hashlib

import numpy as np

import smoothprofile as sp
from smoothprofile.grid import interior

SCHEMES = ("backward-euler", "crank-nicolson", "bdf2", "bdf3")
STILL = {"x": 0.0, "y": 0.0, "z": 0.0}


def simulation(*bodies, courses=None, **changes):
    """A run in a periodic cube of side 4 with 12³ cells, ξ = .3, ν = .3, Δt = .02.

    Changes name the keys of the case's tables, whose names do not clash: cells=..., viscosity=...
    """
    tables = {
        "domain": {"lengths": [4.0] * 3, "cells": [12] * 3, "boundaries": ["periodic"] * 3},
        "fluid": {"density": 1.0, "viscosity": 0.3},
        "profile": {"thickness": 0.3},
        "time": {"step": 0.02, "end": 1e6},
        "output": {"every": 1000000},
    }
    places = {"origin": "domain", "stretching": "domain", "precision": "domain"}
    places |= dict.fromkeys(
        (
            "body_force",
            "mean_velocity",
            "initial_velocity",
            "advection",
            "wall_velocity",
            "gravity",
        ),
        "fluid",
    )
    places |= dict.fromkeys(("kind", "retract"), "profile")
    places |= dict.fromkeys(("scheme", "coupling", "steady_tolerance", "max_steps"), "time")
    for table, keys in tables.items():
        places |= dict.fromkeys(keys, table)
    for key, value in changes.items():
        tables[places[key]][key] = value
    if not bodies:
        del tables["profile"]
    return sp.Simulation(sp.load_case({**tables, "particles": list(bodies)}), courses)


def sphere(position, radius=0.8, **keys):
    return {"shape": "sphere", "radius": radius, "position": list(position), **keys}


def free(position, density, radius=0.8, **keys):
    return sphere(position, radius, motion="free", density=density, **keys)


def random_velocity(run, seed=5):
    """Fields of white noise at the points where the velocity is unknown."""
    rng = np.random.default_rng(seed)
    fields = tuple(run.grid.zeros() for _ in range(3))
    for boundary, field in zip(run.flow.boundaries, fields, strict=True):
        inside = field[boundary.unknowns(run.grid)]
        inside[...] = rng.standard_normal(inside.shape)
    return fields


def steps(run, count):
    """The run, `count` steps later."""
    for _ in range(count):
        run.step_once()
    return run


def settle(run, tolerance=1e-7, most=20000):
    """The run once max|∂u/∂t|/max|u| has fallen below the tolerance."""
    steps(run, 2)
    while run.extremes.rate(run.time_step) > tolerance:
        run.step_once()
        assert run.steps < most, "the run does not settle"
    return run


def cell_volumes(grid, component):
    """Volumes of the cells around the points of a velocity component, interior only."""
    sizes = [
        (a.padded_distances if d == component else a.padded_widths)[1:-1]
        for d, a in enumerate(grid.axes)
    ]
    return sizes[0][:, None, None] * sizes[1][None, :, None] * sizes[2][None, None, :]


def body_coordinates(run, component, body=0):
    """r (3, nx, ny, nz): points of a component counted from a body's nearest image."""
    parts = []
    for d, points in enumerate(run.grid.face_coordinates(component)):
        r = points[1:-1] - run.bodies.state.position[body, d]
        if run.grid.axes[d].periodic:
            length = run.grid.lengths[d]
            r = r - length * np.round(r / length)
        parts.append(r)
    return np.stack(np.meshgrid(*parts, indexing="ij"))


def momentum(run):
    """ρ∫u dV, (3,)."""
    total = [
        (interior(f) * cell_volumes(run.grid, c)).sum() for c, f in enumerate(run.state.velocity)
    ]
    return run.case.fluid.density * np.array(total)


class Books:
    """What the fluid gains in one step against what it is given, along each axis."""

    def __init__(self, run):
        self.run, self.momenta = run, [momentum(run)]
        self._impose, run.bodies.impose = run.bodies.impose, self._watched

    def _watched(self, velocity, scheme, dt):
        """The impulse, and (ργ/Δt)∫(u** − uˢ)dV of it, whatever the loads make of that."""
        grid, before = self.run.grid, [interior(f).copy() for f in velocity]
        self._impose(velocity, scheme, dt)
        change = [
            ((interior(f) - old) * cell_volumes(grid, c)).sum()
            for c, (f, old) in enumerate(zip(velocity, before, strict=True))
        ]
        self.impulse = self.run.case.fluid.density * scheme.gamma / dt * np.array(change)

    def step(self):
        """One step; returns (gain, given), (3,) each, gain = γ-weighted change over Δt."""
        run = self.run
        used = run.flow.scheme(run.state)
        run.step_once()
        self.momenta.insert(0, momentum(run))
        weights = (used.gamma, *(-a for a in used.past))
        gain = sum(w * m for w, m in zip(weights, self.momenta, strict=False)) / run.time_step
        force = run.driving_force * run.grid.volume
        return gain, force - run.wall_force["total"] + self.impulse


def digest(run):
    """A fingerprint of every bit of a run's state: fields, older levels, bodies, loads, walls."""
    state, bodies = run.state, run.bodies.state
    arrays = [*state.velocity, state.pressure]
    arrays += [f for level in (*state.past_velocity, *state.past_advection) for f in level]
    arrays += [bodies.position, bodies.quaternion, bodies.velocity, bodies.angular_velocity]
    arrays += [bodies.force, bodies.torque, *run.wall_force.values(), run.driving_force]
    arrays += [run.bodies.painter.indicator[: run.bodies.painter.windows.points]]
    return hashlib.sha256(b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)).hexdigest()
