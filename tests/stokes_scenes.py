"""Scenes of steady Stokes flow that several tests share, and what periodic images add to them."""

import math

import numpy as np
from scipy.special import erfc

import flows
from smoothprofile.grid import Axis, Grid
from smoothprofile.particles.bodies import BodyState, bodies_at
from smoothprofile.shapes import Shape, sphere
from smoothprofile.viscous.around import stokes_around
from smoothprofile.viscous.stokes import RigidStokes

DUCT = 30.1815
"""Force over μaU on a sphere at the centre of a duct 20×7×7 whose walls move with U."""
CUBIC = {0.027: 2.00775, 0.064: 2.81020, 0.1: 3.64245, 0.216: 7.44195, 0.3: 12.0643, 0.45: 28.0864}
"""F/(6πμaU) of simple cubic arrays by volume fraction (Zick & Homsy 1982)."""


def box(lengths, cells, periodic=(True, True, True)) -> Grid:
    """Uniform axes that begin at zero."""
    return flows.box(cells, lengths, periodic)


def wavy(axis: Axis, depth: float) -> Axis:
    """The axis with cells that grow and shrink by that share, twice along it."""
    s = np.linspace(0.0, 1.0, axis.cells + 1)
    moved = s + depth * np.sin(4.0 * math.pi * s) / (4.0 * math.pi)
    return Axis(axis.name, axis.low + axis.length * moved, axis.periodic)


def at(positions) -> BodyState:
    """Bodies at those places, not turned."""
    positions = np.atleast_2d(positions)
    return bodies_at(positions, np.tile([1.0, 0.0, 0.0, 0.0], (len(positions), 1)))


def cubic_array(share: float, cells: int, place=(0.5, 0.5, 0.5), **options) -> tuple:
    """One sphere of radius 1 in a periodic cube, at `place` in lengths: (solver, state)."""
    side = (4.0 * math.pi / 3.0 / share) ** (1.0 / 3.0)
    stokes = stokes_around(box([side] * 3, [cells] * 3), [sphere(1.0)], 1.0, **options)
    return stokes, at(np.array(place) * side)


def array_drag(share: float, cells: int, place=(0.5, 0.5, 0.5), **options) -> float:
    """F/(6πμaU) of a simple cubic array."""
    stokes, state = cubic_array(share, cells, place, **options)
    found = stokes.resistance(state, 0.0, 0.0, mean_velocity=(1.0, 0.0, 0.0))
    assert found.report.converged
    return float(found.force[0, 0] / (6.0 * math.pi))


def duct(grid: Grid, shape: Shape | None = None, **options) -> tuple[RigidStokes, np.ndarray]:
    """A sphere at the centre of a duct whose walls move with one along x: solver and velocities."""
    walls = np.zeros((3, 2, 3))
    walls[:, :, 0] = 1.0
    return stokes_around(grid, [shape or sphere(1.0)], 1.0, **options), walls


def images(r, side: float) -> np.ndarray:
    """8πμ(G_periodic − G_free)(r), (3,3), of a point force in a cube without mean flow.

    Hasimoto's sums split as by af Klinteberg & Tornberg, Adv. Comput. Math. 40 (2014).
    """
    split = 3.6 / side
    n = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 3, indexing="ij"), -1).reshape(-1, 3)
    d = np.asarray(r, float) + n * side
    q = np.linalg.norm(d, axis=1)
    d, q = d[q > 1e-9], q[q > 1e-9]
    bell = 2.0 * split / math.sqrt(math.pi) * np.exp(-((split * q) ** 2))
    radial = bell / q**2 + erfc(split * q) / q**3
    total = (radial * q**2 - 2.0 * bell).sum() * np.eye(3)
    total += np.einsum("n,ni,nj->ij", radial, d, d)
    k = np.stack(np.meshgrid(*[np.arange(-8, 9)] * 3, indexing="ij"), -1).reshape(-1, 3)
    k = 2.0 * math.pi / side * k[np.any(k != 0, axis=1)]
    square = (k**2).sum(axis=1)
    weight = (1.0 + square / (4.0 * split**2)) / square**2 * np.exp(-square / (4.0 * split**2))
    weight *= 8.0 * math.pi / side**3 * np.cos(k @ np.asarray(r, float))
    total += (weight * square).sum() * np.eye(3) - np.einsum("n,ni,nj->ij", weight, k, k)
    distance = float(np.linalg.norm(r))
    if distance < 1e-9:
        return total - 4.0 * split / math.sqrt(math.pi) * np.eye(3)
    return total - np.eye(3) / distance - np.outer(r, r) / distance**3
