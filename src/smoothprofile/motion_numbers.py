"""Numbers of how bodies moved, from their histories: what a report sets beside a reference."""

from collections.abc import Mapping

import numpy as np

from smoothprofile.grid import AXIS_NAMES

Columns = Mapping[str, np.ndarray]


def motion_numbers(particles: Mapping[str, Columns]) -> dict[str, float]:
    """peak_speed and final_speed of the first body, its final spin (the largest component),
    mean_speed of all over the last half, and of two bodies the least distance of their centres.
    """
    histories = list(particles.values())
    if not histories or "velocity_x" not in histories[0]:
        return {}
    speed = np.linalg.norm(vectors(histories[0], "velocity"), axis=0)
    spin = vectors(histories[0], "angular_velocity")[:, -1]
    found = {
        "peak_speed": float(speed.max()),
        "final_speed": float(speed[-1]),
        "angular_velocity": float(max(spin, key=abs)),
        "mean_speed": _late_speed(histories),
    }
    if turns := half_turns(histories[0]):
        found["half_period"] = turns[-1]
    if len(histories) == 2:
        found["least_distance"] = float(distance(*histories).min())
    return found


def vectors(columns: Columns, quantity: str) -> np.ndarray:
    """(3, times) of a vector in a body's history."""
    return np.stack([columns[f"{quantity}_{axis}"] for axis in AXIS_NAMES])


def distance(first: Columns, second: Columns) -> np.ndarray:
    """|R₁ − R₂| at each time; no periodic images."""
    return np.linalg.norm(vectors(first, "position") - vectors(second, "position"), axis=0)


def first_axis(columns: Columns) -> np.ndarray:
    """R(q)e₁, (3, times)."""
    w, x, y, z = (columns[f"orientation_{part}"] for part in "wxyz")
    return np.stack([1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)])


def half_turns(columns: Columns) -> list[float]:
    """Times between successive alignments of the first axis with where it pointed at the start."""
    if "orientation_w" not in columns or len(columns["time"]) < 3:
        return []
    axis, time = first_axis(columns), columns["time"]
    across = axis - np.outer(axis[:, 0], axis[:, 0] @ axis)
    side = across[np.abs(across).max(axis=1).argmax()]
    # Where the part across changes its sign while that along is large.
    at = np.flatnonzero((side[1:] * side[:-1] < 0) & (np.abs(axis[:, 0] @ axis)[1:] > 0.5))
    found = time[at] + np.diff(time)[at] * side[at] / (side[at] - side[at + 1])
    return [float(step) for step in np.diff(found)]


def _late_speed(histories: list[Columns]) -> float:
    """|mean V| over all bodies and the last half of the time."""
    mean = np.mean([vectors(columns, "velocity") for columns in histories], axis=0)
    time = histories[0]["time"]
    late = mean[:, time >= 0.5 * (time[0] + time[-1])]
    return float(np.linalg.norm(late.mean(axis=1)))
