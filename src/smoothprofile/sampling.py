"""Values of staggered fields between their points: interpolation, cuts, and moves to a new grid."""

import numpy as np

from smoothprofile.boundaries import SIDES
from smoothprofile.grid import AXIS_NAMES, Grid

CENTRED = -1


def interpolate(grid: Grid, field: np.ndarray, component: int, points: np.ndarray) -> np.ndarray:
    """Trilinear values (m,) of a padded field with filled ghosts at points (m,3) in the box.

    component says which velocity the field is; CENTRED for one that lies at cell centres.
    """
    lower, weight = [], []
    for d, coordinates in enumerate(grid.face_coordinates(component)):
        axis = grid.axes[d]
        x = points[:, d]
        if axis.periodic:
            x = axis.low + np.mod(x - axis.low, axis.length)
        i = np.clip(np.searchsorted(coordinates, x, side="right") - 1, 0, axis.cells)
        lower.append(i)
        weight.append((x - coordinates[i]) / (coordinates[i + 1] - coordinates[i]))
    total = np.zeros(points.shape[0])
    for corner in np.ndindex(2, 2, 2):
        share = np.ones(points.shape[0])
        for d in range(3):
            share = share * (weight[d] if corner[d] else 1.0 - weight[d])
        index = tuple(lower[d] + corner[d] for d in range(3))
        total += share * field[index]
    return total


def in_box(grid: Grid, points: np.ndarray) -> np.ndarray:
    """Points (m,3) moved by whole periods into the box."""
    low = np.array([axis.low for axis in grid.axes])
    lengths = np.array(grid.lengths)
    periods = np.where(grid.periodic, np.floor((points - low) / lengths), 0.0)
    return points - periods * lengths


def centred_velocity(velocity: tuple) -> np.ndarray:
    """(3,nx,ny,nz) at cell centres, the mean of the two faces."""
    parts = []
    for c, field in enumerate(velocity):
        f = np.moveaxis(field, c, 0)
        parts.append(np.moveaxis(0.5 * (f[1:-1] + f[2:]), 0, c))
    inner = slice(1, -1)
    trimmed = [
        part[tuple(slice(None) if d == c else inner for d in range(3))]
        for c, part in enumerate(parts)
    ]
    return np.stack(trimmed)


def native_points(grid: Grid, axis: int, component: int) -> np.ndarray:
    """Coordinates along an axis at which a component is known, walls included."""
    a = grid.axes[axis]
    if axis == component:
        return a.faces
    return a.centres if a.periodic else np.concatenate([[a.low], a.centres, [a.high]])


def along_line(
    grid: Grid, velocity: tuple, axis: int, through: tuple[float, float], component: int
) -> tuple[np.ndarray, np.ndarray]:
    """A velocity component along `axis` through the two other coordinates, in order x, y, z."""
    coordinates = native_points(grid, axis, component)
    points = np.empty((coordinates.size, 3))
    points[:, axis] = coordinates
    points[:, [d for d in range(3) if d != axis]] = through
    return coordinates, interpolate(grid, velocity[component], component, points)


def on_plane(grid: Grid, field: np.ndarray, component: int, axis: int, at: float) -> np.ndarray:
    """Values at the cell centres of the plane `axis` = at, (first other axis, second)."""
    first, second = (d for d in range(3) if d != axis)
    a, b = np.meshgrid(grid.axes[first].centres, grid.axes[second].centres, indexing="ij")
    points = np.empty((a.size, 3))
    points[:, axis], points[:, first], points[:, second] = at, a.ravel(), b.ravel()
    return interpolate(grid, field, component, points).reshape(a.shape)


def wall_slope(
    grid: Grid, velocity: tuple, wall: str, component: int, along: int, at: float, speed: float
) -> tuple[np.ndarray, np.ndarray]:
    """∂u_component/∂x_normal on a wall, along one of its axes at the other's coordinate `at`.

    (u − U)/d from the nearest layer, d from a wall moving at U: the slope that the viscous term
    itself takes. The scheme's first layer carries an error that this slope cancels, so that it is
    of second order, where a parabola through two layers is of first.
    """
    axis, side = AXIS_NAMES.index(wall[0]), SIDES.index(wall[2:])
    a = grid.axes[axis]
    layer, edge = (a.centres[0], a.low) if side == 0 else (a.centres[-1], a.high)
    coordinates = native_points(grid, along, component)
    (other,) = {0, 1, 2} - {axis, along}
    points = np.empty((coordinates.size, 3))
    points[:, axis], points[:, along], points[:, other] = layer, coordinates, at
    values = interpolate(grid, velocity[component], component, points)
    return coordinates, (values - speed) / (layer - edge)


def onto(grid: Grid, source_grid: Grid, field: np.ndarray, component: int) -> np.ndarray:
    """The interior of a field of another grid over the same box, at this grid's points."""
    axes = [
        (a.padded_faces if d == component else a.padded_centres)[1:-1]
        for d, a in enumerate(grid.axes)
    ]
    mesh = np.meshgrid(*axes, indexing="ij")
    points = np.stack([m.ravel() for m in mesh], axis=1)
    return interpolate(source_grid, field, component, points).reshape(grid.shape)
