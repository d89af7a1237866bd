"""Direct solvers against the stencil they invert, for every mix of ends, sizes and spacings."""

import itertools

import numpy as np
import pytest

from smoothprofile.boundaries import FieldBoundary, fill_ghosts
from smoothprofile.grid import Grid, stretched_axis, uniform_axis
from smoothprofile.solvers.separable import SeparableSolver

ENDS = [
    ("periodic", "periodic"),
    ("value", "value"),
    ("flux", "flux"),
    ("flux", "value"),
    ("value", "flux"),
]


def make_axis(name, cells, periodic, stretched):
    if stretched:
        return stretched_axis(name, -1.0, 2.5, cells, periodic, focus=0.2, ratio=3.0)
    return uniform_axis(name, -1.0, 2.5, cells, periodic)


def laplacian(grid, boundary, padded):
    """∇² of a padded field whose ghosts are filled, straight from its definition."""
    total = np.zeros(grid.shape)
    core = padded[1:-1, 1:-1, 1:-1]
    for d, axis in enumerate(grid.axes):
        f = np.moveaxis(padded, d, 0)[(slice(None), *([slice(1, -1)] * 2))]
        n = axis.cells
        if d == boundary.staggered:
            w, gap = axis.padded_distances[1 : n + 1], axis.padded_widths
            below, above = gap[0:n], gap[1 : n + 1]
        else:
            w, gap = axis.padded_widths[1 : n + 1], axis.padded_distances
            below, above = gap[1 : n + 1], gap[2 : n + 2]
        shape = (-1, 1, 1)
        second = (
            (f[2:] - f[1:-1]) / above.reshape(shape) - (f[1:-1] - f[:-2]) / below.reshape(shape)
        ) / w.reshape(shape)
        total += np.moveaxis(second, 0, d)
    assert core.shape == total.shape
    return total


def residual(grid, boundary, shift, seed=0):
    """Largest |(σ−∇²)f − r| over the largest |r|, for a random right-hand side."""
    solver = SeparableSolver(grid, boundary)
    rng = np.random.default_rng(seed)
    field = grid.zeros()
    inside = boundary.unknowns(grid)
    r = rng.standard_normal(field[inside].shape)
    if shift == 0 and not any("value" in c for c in boundary.conditions):
        volume = grid.zeros()[1:-1, 1:-1, 1:-1] + np.einsum(
            "i,j,k->ijk", *[axis.widths for axis in grid.axes]
        )
        r -= (r * volume).sum() / volume.sum()
    field[inside] = r.astype(grid.dtype)
    solver.solve(field, shift)
    fill_ghosts(field, boundary)
    field = field.astype(np.float64)
    back = grid.zeros().astype(np.float64)
    back[1:-1, 1:-1, 1:-1] = shift * field[1:-1, 1:-1, 1:-1] - laplacian(grid, boundary, field)
    return np.abs(back[inside] - r).max() / np.abs(r).max()


@pytest.mark.parametrize("ends", list(itertools.product(ENDS, repeat=3)))
def test_every_mix_of_ends(ends):
    grid = Grid(
        tuple(
            make_axis(name, n, e[0] == "periodic", False)
            for name, n, e in zip("xyz", (6, 7, 8), ends, strict=True)
        )
    )
    boundary = FieldBoundary(ends)
    for shift in (0.0, 2.5):
        assert residual(grid, boundary, shift) < 1e-12  # round-off times the condition, ~1e2


@pytest.mark.parametrize("component", [0, 1, 2])
@pytest.mark.parametrize("sizes", [(5, 4, 9), (2, 3, 4), (13, 11, 7), (1, 8, 6), (16, 12, 17)])
@pytest.mark.parametrize("stretched", list(itertools.product([False, True], repeat=3)))
@pytest.mark.parametrize(
    "periodic", [(True, False, False), (False, False, False), (False, True, True)]
)
def test_staggered_sizes_and_stretching(component, sizes, stretched, periodic):
    axes = tuple(
        make_axis(name, n, p, s and n > 1)
        for name, n, p, s in zip("xyz", sizes, periodic, stretched, strict=True)
    )
    ends = tuple(("periodic",) * 2 if p else ("value",) * 2 for p in periodic)
    grid, boundary = Grid(axes), FieldBoundary(ends, staggered=component)
    if grid.zeros()[boundary.unknowns(grid)].size:
        assert residual(grid, boundary, 1.5) < 1e-11  # round-off times 1/(h²σ), at most 1e3


def test_wrong_eigenvalue_would_be_seen():
    grid = Grid(tuple(make_axis(name, 8, True, False) for name in "xyz"))
    boundary = FieldBoundary((("periodic",) * 2,) * 3)
    assert residual(grid, boundary, 1.0) < 1e-12
    solver = SeparableSolver(grid, boundary)
    field = grid.zeros()
    field[1:-1, 1:-1, 1:-1] = 1.0
    solver.solve(field, 2.0)
    np.testing.assert_allclose(field[1:-1, 1:-1, 1:-1], 0.5, rtol=1e-14)


def test_single_precision():
    axes = tuple(
        make_axis(name, n, name == "x", False) for name, n in zip("xyz", (8, 9, 10), strict=True)
    )
    boundary = FieldBoundary((("periodic",) * 2, ("value",) * 2, ("flux",) * 2))
    assert residual(Grid(axes, dtype=np.float32), boundary, 1.0) < 2e-4  # 6e-8 times 1/(h²σ)


@pytest.mark.parametrize(
    "periodic", [(True, True, True), (True, False, False), (False, True, False)]
)
def test_free_constant_gives_zero_mean(periodic):
    axes = tuple(make_axis(name, 6, p, not p) for name, p in zip("xyz", periodic, strict=True))
    grid = Grid(axes)
    boundary = FieldBoundary(tuple(("periodic",) * 2 if p else ("flux",) * 2 for p in periodic))
    field = grid.zeros()
    inside = boundary.unknowns(grid)
    field[inside] = np.random.default_rng(1).standard_normal(grid.shape)
    SeparableSolver(grid, boundary).solve(field, 0.0)
    volume = np.einsum("i,j,k->ijk", *[axis.widths for axis in axes])
    assert abs((field[inside] * volume).sum()) < 1e-12 * np.abs(field).max() * volume.sum()
