"""Small flows that the tests share."""

import numpy as np

from smoothprofile.flow.advance import Flow, FlowParameters
from smoothprofile.flow.state import fluid_at_rest
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.schemes import scheme_named


def box(cells, lengths, periodic, dtype=np.float64):
    axes = tuple(
        uniform_axis(name, 0.0, length, n, p)
        for name, length, n, p in zip("xyz", lengths, cells, periodic, strict=True)
    )
    return Grid(axes, dtype)


def points(grid, component):
    """Padded coordinates of a velocity component (−1: cell centres), ready to broadcast."""
    x, y, z = grid.face_coordinates(component)
    return x[:, None, None], y[None, :, None], z[None, None, :]


def make_flow(grid, scheme="backward-euler", walls=None, **parameters):
    return Flow(
        grid, FlowParameters(walls=walls or Walls(), scheme=scheme_named(scheme), **parameters)
    )


def start(flow, functions, time=0.0):
    """A state whose velocity is functions[c](x, y, z), made divergence-free on the grid."""
    state = fluid_at_rest(flow.grid)
    for c, function in enumerate(functions):
        if function is not None:
            state.velocity[c][...] = function(*points(flow.grid, c))
    flow.fill(state.velocity, time)
    return state


def slope(sizes, errors):
    """Order of convergence: the slope of log |error| against log size."""
    return np.polyfit(np.log(sizes), np.log(np.abs(errors)), 1)[0]
