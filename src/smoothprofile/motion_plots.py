"""Figures of bodies that move freely: how fast, along which way, and how they turn."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from smoothprofile.figures import DASHES, LEVEL, PALETTE, Picture, new_panels
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.labels import literal
from smoothprofile.motion_numbers import distance, first_axis, vectors

Columns = Mapping[str, np.ndarray]

WIDTH, HEIGHT = 9.0, 3.5
SMALL = 0.02
SPEEDS = ("peak_speed", "final_speed", "mean_speed")
CIRCLES = {"marker": "o", "linestyle": "none", "markerfacecolor": "none", "color": "black"}


def motion_picture(
    particles: Mapping[str, Columns], reference: Mapping[str, Any]
) -> Picture | None:
    """Velocity of each body against time, and its height: its place along the main direction.

    Components smaller than a fiftieth of the largest are left out; of many bodies, the mean of the
    largest and its standard deviation are drawn. The reference's `peak_speed`, `final_speed` or
    `mean_speed` and those of the computations and measurements beside it are levels, its `speed` a
    curve.
    """
    bodies = {name: c for name, c in particles.items() if len(c["time"]) > 1 and _travels(c)}
    if not bodies:
        return None
    figure, (speeds, places) = new_panels(2, HEIGHT, WIDTH)
    sizes = {a: max(np.abs(c[f"velocity_{a}"]).max() for c in bodies.values()) for a in AXIS_NAMES}
    main = max(sizes, key=sizes.get)
    shown = [axis for axis in AXIS_NAMES if sizes[axis] > SMALL * sizes[main]]
    if len(bodies) > len(PALETTE):
        _draw_spread(speeds, places, list(bodies.values()), main)
    else:
        _draw_each(speeds, places, bodies, shown, main)
    _draw_levels(speeds, reference, bodies, main)
    speeds.set(title="Velocity", xlabel="t (time)", ylabel="velocity (length/time)")
    places.set(title="Path", xlabel="t (time)")
    figure.legend(loc="outside lower center", ncols=4)
    caption = "Velocity of the bodies that travel, and their place along the way, against time."
    return Picture("motion", caption, figure, wide=True)


def spin_picture(particles: Mapping[str, Columns], reference: Mapping[str, Any]) -> Picture | None:
    """Angular velocity of each body that turns, and the direction of its first axis."""
    bodies = {name: c for name, c in particles.items() if len(c["time"]) > 1 and _turns(c)}
    if not bodies or len(bodies) > len(PALETTE):
        return None
    figure, (rates, axes) = new_panels(2, HEIGHT, WIDTH)
    sizes = {
        a: max(np.abs(c[f"angular_velocity_{a}"]).max() for c in bodies.values())
        for a in AXIS_NAMES
    }
    shown = [axis for axis in AXIS_NAMES if sizes[axis] > SMALL * max(sizes.values())]
    for number, (name, columns) in enumerate(bodies.items()):
        for axis, dashes in zip(shown, DASHES, strict=False):
            rates.plot(
                columns["time"],
                columns[f"angular_velocity_{axis}"],
                dashes,
                color=PALETTE[number],
                label=f"Ω{axis}, {literal(name)}",
            )
        for axis, component, dashes in zip(AXIS_NAMES, first_axis(columns), DASHES, strict=True):
            label = f"n{axis}, {literal(name)}"
            axes.plot(columns["time"], component, dashes, color=PALETTE[number], label=label)
    for axis, curve in reference.get("first_axis", {}).items():
        label = None if axis != next(iter(reference["first_axis"])) else _label(reference)
        axes.plot(curve["coordinate"], curve["value"], label=label, markersize=3.5, **CIRCLES)
    if "angular_velocity" in reference:
        rates.axhline(reference["angular_velocity"], label=_label(reference), **LEVEL)
    rates.set(title="Angular velocity", xlabel="t (time)", ylabel="Ω (1/time)")
    axes.set(title="Direction of the body's first axis", xlabel="t (time)", ylabel="n (–)")
    figure.legend(loc="outside lower center", ncols=4)
    return Picture("spin", "How each body turns, against time.", figure, wide=True)


def _travels(columns: Columns) -> bool:
    return any(np.ptp(columns[f"position_{axis}"]) > 0 for axis in AXIS_NAMES)


def _turns(columns: Columns) -> bool:
    return any(np.abs(columns[f"angular_velocity_{axis}"]).max() > 1e-9 for axis in AXIS_NAMES)


def pair_picture(particles: Mapping[str, Columns], reference: Mapping[str, Any]) -> Picture | None:
    """Distance of two free bodies' centres, and the angle of their line to its first direction.

    The reference's `distance`, and those of the computations beside it, are curves.
    """
    bodies = [c for c in particles.values() if len(c["time"]) > 1 and _travels(c)]
    if len(bodies) != 2 or "contact_distance" not in reference:
        return None
    figure, (gaps, turns) = new_panels(2, HEIGHT, WIDTH)
    time, apart = bodies[0]["time"], distance(*bodies)
    line = vectors(bodies[1], "position") - vectors(bodies[0], "position")
    cosine = line[:, 0] @ line / (apart * apart[0])
    gaps.plot(time, apart, label="this run")
    groups = [reference, *(v for v in reference.values() if isinstance(v, Mapping))]
    for group, marker in zip((g for g in groups if "distance" in g), "ox+", strict=False):
        curve = group["distance"]
        style = {**CIRCLES, "marker": marker, "markersize": 3.5}
        gaps.plot(curve["coordinate"], curve["value"], label=_label(group), **style)
    gaps.axhline(reference["contact_distance"], label="touch", **LEVEL)
    angle = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    turns.plot(time, angle)
    gaps.set(title="Distance of the centres", xlabel="t (time)", ylabel="distance (length)")
    turns.set(
        title="Turn of their line", xlabel="t (time)", ylabel="angle (degrees)",
        ylim=(0, max(1.0, 1.05 * angle.max())),
    )  # fmt: skip
    figure.legend(loc="outside lower center", ncols=4)
    return Picture("pair", "The pair: how far apart, and how turned.", figure, wide=True)


def drift_picture(particles: Mapping[str, Columns], reference: Mapping[str, Any]) -> Picture | None:
    """Where bodies are along the axis of the reference's `places`, beside those places."""
    known = reference.get("places", {})
    bodies = {name: c for name, c in particles.items() if len(c["time"]) > 1 and _travels(c)}
    if not known or not bodies or len(bodies) > len(PALETTE):
        return None
    figure, panels = new_panels(len(known), HEIGHT, WIDTH)
    for panel, (axis, levels) in zip(panels, known.items(), strict=True):
        for number, (name, columns) in enumerate(bodies.items()):
            panel.plot(columns["time"], columns[f"position_{axis}"], color=PALETTE[number],
                       label=literal(name))  # fmt: skip
        for number, level in enumerate(levels):
            panel.axhline(level, label=None if number else _label(reference), **LEVEL)
        panel.set(title="Drift", xlabel="t (time)", ylabel=f"{axis} (length)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return Picture("drift", "Where bodies drift, across the flow.", figure, wide=True)


def _draw_each(speeds, places, bodies: Mapping[str, Columns], shown, main: str) -> None:
    for number, (name, columns) in enumerate(bodies.items()):
        colour = PALETTE[number]
        for axis, dashes in zip(shown, DASHES, strict=False):
            label = f"V{axis}, {literal(name)}"
            values = columns[f"velocity_{axis}"]
            speeds.plot(columns["time"], values, dashes, label=label, color=colour)
        places.plot(columns["time"], columns[f"position_{main}"], color=colour)
    places.set_ylabel(f"{main} (length)")


def _draw_spread(speeds, places, bodies: list[Columns], main: str) -> None:
    """Mean and standard deviation over the bodies; of places, counted from where each started."""
    time, colour = bodies[0]["time"], PALETTE[0]
    values = np.stack([c[f"velocity_{main}"] for c in bodies])
    way = np.stack([c[f"position_{main}"] - c[f"position_{main}"][0] for c in bodies])
    label = f"V{main}, mean of {len(bodies)} bodies"
    _draw_band(speeds, time, values, colour, label, "± standard deviation")
    _draw_band(places, time, way, colour, None, None)
    places.set_ylabel(f"{main} from the start (length)")


def _draw_band(panel, time, values: np.ndarray, colour: str, label, band) -> None:
    mean, spread = values.mean(axis=0), values.std(axis=0)
    panel.plot(time, mean, color=colour, label=label)
    panel.fill_between(
        time, mean - spread, mean + spread, color=colour, alpha=0.2, linewidth=0, label=band
    )


def _draw_levels(panel, reference: Mapping[str, Any], bodies, main: str) -> None:
    """Speeds to compare with, signed as the bodies move."""
    first = next(iter(bodies.values()))[f"velocity_{main}"]
    sign = np.sign(first[np.abs(first).argmax()])
    if "speed" in reference:
        curve = reference["speed"]
        values = sign * np.asarray(curve["value"])
        panel.plot(curve["coordinate"], values, label=_label(reference), **CIRCLES)
        return
    groups = [reference, *(v for v in reference.values() if isinstance(v, Mapping))]
    known = [(group, key) for group in groups for key in SPEEDS if key in group]
    for (group, key), dashes in zip(known, (LEVEL["linestyle"], ":", "-."), strict=False):
        style = {**LEVEL, "linestyle": dashes}
        panel.axhline(sign * group[key], label=_label(group), **style)


def _label(group: Mapping[str, Any]) -> str:
    return literal(group.get("label", "reference"))
