"""Small cases without inertia."""

import numpy as np

from smoothprofile.config import load_case
from smoothprofile.stokes_simulation import StokesSimulation

CUBE = ("periodic",) * 3
STILL = {"x": 0.0, "y": 0.0, "z": 0.0}


def ball(place, motion="free", **changes):
    found = {"shape": "sphere", "radius": 1.0, "position": list(place), "motion": motion}
    return found | ({"density": 2.0} if motion == "free" else {}) | changes


def box(*bodies, side=8.0, cells=32, boundaries=CUBE, **changes):
    """A cube of `side`; the profile as thin as the grid hardly shows."""
    lengths = [side] * 3 if np.isscalar(side) else list(side)
    number = [cells] * 3 if np.isscalar(cells) else list(cells)
    case = {
        "domain": {"lengths": lengths, "cells": number, "boundaries": list(boundaries)},
        "fluid": {"flow": "stokes", "density": 1.0, "viscosity": 1.0, "tolerance": 1e-7},
        "profile": {"kind": "sine", "thickness": 2.5 * lengths[0] / number[0]},
        "particles": list(bodies),
        "time": {"end": 1.0},
    }
    if all(kind == "periodic" for kind in boundaries):
        case["fluid"]["mean_velocity"] = STILL
    for table, values in changes.items():
        case[table] = {**case.get(table, {}), **values} if isinstance(values, dict) else values
    return case


def run_of_box(*bodies, **changes) -> StokesSimulation:
    return StokesSimulation(load_case(box(*bodies, **changes)))


def marched(run: StokesSimulation) -> StokesSimulation:
    run.run()
    return run
