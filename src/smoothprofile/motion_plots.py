"""Figures of bodies that move freely: how fast, along which way, and how they turn."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from smoothprofile.figures import DASHES, LEVEL, PALETTE, Picture, new_panels
from smoothprofile.labels import NUMBERS, SYMBOLS, literal

Columns = Mapping[str, np.ndarray]

WIDTH, HEIGHT = 9.0, 3.5
GREY = "#9aa5b1"
SMALL = 0.02


def motion_picture(
    particles: Mapping[str, Columns], reference: Mapping[str, Any]
) -> Picture | None:
    """Velocity of each body against time, and its height: its place along the main direction.

    Components smaller than a fiftieth of the largest are left out. The reference's `peak_speed`
    and those of the computations and measurements beside it are levels.
    """
    bodies = {name: c for name, c in particles.items() if len(c["time"]) > 1 and _travels(c)}
    if not bodies:
        return None
    figure, (speeds, places) = new_panels(2, HEIGHT, WIDTH)
    sizes = {a: max(np.abs(c[f"velocity_{a}"]).max() for c in bodies.values()) for a in NUMBERS}
    main = max(sizes, key=sizes.get)
    shown = [axis for axis in NUMBERS if sizes[axis] > SMALL * sizes[main]]
    many = len(bodies) > len(PALETTE)
    for number, (name, columns) in enumerate(bodies.items()):
        colour = GREY if many else PALETTE[number]
        style = {"color": colour, "linewidth": 0.6 if many else 1.5}
        owner = f"each of {len(bodies)} bodies" if many else literal(name)
        for axis, dashes in zip(shown, DASHES, strict=False):
            label = None if many and number else f"V{NUMBERS[axis]}, {owner}"
            speeds.plot(columns["time"], columns[f"velocity_{axis}"], dashes, label=label, **style)
        places.plot(columns["time"], columns[f"position_{main}"], **style)
    _draw_levels(speeds, reference, bodies, main)
    speeds.set(title="Velocity", xlabel="t (time)", ylabel="velocity (length/time)")
    places.set(title="Path", xlabel="t (time)", ylabel=f"{SYMBOLS[main]} (length)")
    figure.legend(loc="outside lower center", ncols=4)
    caption = "Velocity of each body that travels, and its place along the way, against time."
    return Picture("motion", caption, figure, wide=True)


def spin_picture(particles: Mapping[str, Columns], reference: Mapping[str, Any]) -> Picture | None:
    """Angular velocity of each body that turns, and the direction of its first axis."""
    bodies = {name: c for name, c in particles.items() if len(c["time"]) > 1 and _turns(c)}
    if not bodies or len(bodies) > len(PALETTE):
        return None
    figure, (rates, axes) = new_panels(2, HEIGHT, WIDTH)
    sizes = {
        a: max(np.abs(c[f"angular_velocity_{a}"]).max() for c in bodies.values()) for a in NUMBERS
    }
    shown = [axis for axis in NUMBERS if sizes[axis] > SMALL * max(sizes.values())]
    for number, (name, columns) in enumerate(bodies.items()):
        for axis, dashes in zip(shown, DASHES, strict=False):
            rates.plot(
                columns["time"],
                columns[f"angular_velocity_{axis}"],
                dashes,
                color=PALETTE[number],
                label=f"Ω{NUMBERS[axis]}, {literal(name)}",
            )
        for axis, component, dashes in zip(NUMBERS, _first_axis(columns), DASHES, strict=True):
            label = f"n{NUMBERS[axis]}, {literal(name)}"
            axes.plot(columns["time"], component, dashes, color=PALETTE[number], label=label)
    if "angular_velocity" in reference:
        rates.axhline(reference["angular_velocity"], label=_label(reference), **LEVEL)
    rates.set(title="Angular velocity", xlabel="t (time)", ylabel="Ω (1/time)")
    axes.set(title="Direction of the body's first axis", xlabel="t (time)", ylabel="n (–)")
    for panel in (rates, axes):
        panel.legend(fontsize=8)
    return Picture("spin", "How each body turns, against time.", figure, wide=True)


def _travels(columns: Columns) -> bool:
    return any(np.ptp(columns[f"position_{axis}"]) > 0 for axis in NUMBERS)


def _turns(columns: Columns) -> bool:
    return any(np.abs(columns[f"angular_velocity_{axis}"]).max() > 1e-9 for axis in NUMBERS)


def _first_axis(columns: Columns) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """R(q)e₁."""
    w, x, y, z = (columns[f"orientation_{part}"] for part in "wxyz")
    return 1 - 2 * (y**2 + z**2), 2 * (x * y + w * z), 2 * (x * z - w * y)


def _draw_levels(panel, reference: Mapping[str, Any], bodies, main: str) -> None:
    """Peak speeds to compare with, signed as the bodies move."""
    first = next(iter(bodies.values()))[f"velocity_{main}"]
    sign = np.sign(first[np.abs(first).argmax()])
    groups = [reference, *(v for v in reference.values() if isinstance(v, Mapping))]
    known = [group for group in groups if "peak_speed" in group]
    for group, dashes in zip(known, (LEVEL["linestyle"], ":", "-."), strict=False):
        style = {**LEVEL, "linestyle": dashes}
        panel.axhline(sign * group["peak_speed"], label=_label(group), **style)


def _label(group: Mapping[str, Any]) -> str:
    return literal(group.get("label", "reference"))
