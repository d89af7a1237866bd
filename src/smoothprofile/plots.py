"""Figures of a run, drawn from its run directory alone.

Units are the case's own: whatever length, time and mass its numbers were given in. `pictures`
names them where the case says what they are.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from smoothprofile.figures import (
    DASHES,
    LEVEL,
    PALETTE,
    Picture,
    drawing,
    name_units,
    new_figure,
    power_of_ten,
)
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.labels import (
    LOADS,
    line_label,
    load_label,
    reference_label,
)
from smoothprofile.motion_plots import (
    drift_picture,
    motion_picture,
    pair_picture,
    spin_picture,
)
from smoothprofile.plane_plots import plane_pictures
from smoothprofile.runrecord import RunRecord
from smoothprofile.structure_plots import structure_pictures

# A force this small beside the torque, both in the case's own units, is none.
ROUND_OFF = 1e-9
MOST_NAMED_PARTICLES = len(PALETTE)


def pictures(record: RunRecord, reference: Mapping[str, Any] | None = None) -> list[Picture]:
    """Every figure the run directory has the data for, in the order of the report."""
    reference = reference or {}
    output = record.case.get("output", {})
    tolerance = record.case.get("time", {}).get("steady_tolerance")
    with drawing():
        drawn = [
            *structure_pictures(record),
            *plane_pictures(record),
            motion_picture(_travelling(record), reference),
            pair_picture(record.particles, reference),
            drift_picture(record.particles, reference),
            spin_picture(record.particles, reference),
            load_picture(record.particles, reference),
            *profile_pictures(record.lines, output.get("lines", ()), reference),
            wall_shear_picture(record.wall_shear, output.get("wall_line", {}), reference),
            convergence_picture(record.history, tolerance),
        ]
    found = [picture for picture in drawn if picture is not None]
    for picture in found:
        name_units(picture.figure, record.case.get("units", {}))
    return found


def _travelling(record: RunRecord) -> dict[str, Mapping[str, np.ndarray]]:
    """Bodies whose speed is more than round-off beside that of the fluid."""
    fluid = ROUND_OFF * _largest(record.history.get("max_speed", np.empty(0)))
    return {
        name: columns
        for name, columns in record.particles.items()
        if any(
            _largest(columns.get(f"velocity_{axis}", np.empty(0))) > fluid for axis in AXIS_NAMES
        )
    }


def _largest(values: np.ndarray) -> float:
    """The largest size of what is finite."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def load_picture(
    particles: Mapping[str, Mapping[str, np.ndarray]], reference: Mapping[str, Any]
) -> Picture | None:
    """F(t) on each particle, or its torque T(t) where the force is round-off beside that.

    Of the components only those above a hundredth of the largest are drawn.
    """
    if not any(len(columns["time"]) > 1 for columns in particles.values()):
        return None
    largest = {load: max(_last_size(particles, load).values()) for load in LOADS}
    load = "torque" if largest["force"] < ROUND_OFF * largest["torque"] else "force"
    figure, axes = new_figure(height=3.3)
    shown = _components_shown(particles, load)
    many = len(particles) > MOST_NAMED_PARTICLES
    for number, (name, columns) in enumerate(particles.items()):
        owner = f"each of {len(particles)} particles" if many else name
        for component, dashes in zip(shown, DASHES, strict=False):
            axes.plot(
                columns["time"],
                columns[f"{load}_{component}"],
                dashes,
                color="#9aa5b1" if many else PALETTE[number],
                linewidth=0.6 if many else 1.5,
                label=None if many and number else load_label(owner, load, component),
            )
    levels = [reference[load]] if load in reference and len(particles) == 1 else []
    _look_past_the_start(axes, levels)
    for level in levels:
        axes.axhline(level, label=reference_label(reference), **LEVEL)
    axes.set(
        title=f"{load.capitalize()} on each particle",
        xlabel="t (time)",
        ylabel=LOADS[load][1],
    )
    figure.legend(loc="outside lower center", ncols=2 if many else 4)
    return Picture(load, f"{load.capitalize()} of the fluid on each particle against time.", figure)


def profile_pictures(
    lines: Mapping[str, tuple[np.ndarray, np.ndarray]],
    settings: Sequence[Mapping[str, Any]],
    reference: Mapping[str, Any],
) -> list[Picture]:
    """Velocity along each line; lines of one direction and component share a figure."""
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for line in settings:
        if line["name"] in lines:
            groups.setdefault((line["axis"], line["component"]), []).append(line)
    drawn = []
    for (axis, component), members in groups.items():
        figure, axes = new_figure(height=3.5)
        for number, line in enumerate(members):
            colour = PALETTE[number % len(PALETTE)]
            dashes = DASHES[number % len(DASHES)]
            axes.plot(*lines[line["name"]], dashes, color=colour, label=line_label(line))
            _draw_reference(axes, reference, reference.get("lines", {}).get(line["name"]), colour)
        velocity, direction = f"u{component}", axis
        axes.set(
            title=f"Velocity {velocity} along {direction}",
            xlabel=f"{direction} (length)",
            ylabel=f"{velocity} (length/time)",
        )
        figure.legend(loc="outside lower center", ncols=2)
        caption = f"Velocity {velocity} along {direction} at the end."
        drawn.append(Picture(f"velocity-{component}-along-{axis}", caption, figure))
    return drawn


def wall_shear_picture(
    shear: tuple[np.ndarray, np.ndarray] | None,
    setting: Mapping[str, Any],
    reference: Mapping[str, Any],
) -> Picture | None:
    """∂u/∂n on a wall, n the coordinate along the wall's axis, along a line on it."""
    if shear is None:
        return None
    figure, axes = new_figure(height=3.3)
    axes.plot(*shear, color=PALETTE[0], label="this run")
    _draw_reference(axes, reference, reference.get("wall_line"), PALETTE[0])
    normal = str(setting["wall"])[0]
    gradient = f"∂u{setting['component']}/∂{normal}"
    along = setting["along"]
    axes.set(
        title=f"Shear {gradient} on the wall {setting['wall']}",
        xlabel=f"{along} (length)",
        ylabel=f"{gradient} (1/time)",
    )
    figure.legend(loc="outside lower center", ncols=2)
    caption = f"Shear {gradient} on the wall {setting['wall']} along {along} at the end."
    return Picture("wall-shear", caption, figure)


def convergence_picture(
    history: Mapping[str, np.ndarray], tolerance: float | None
) -> Picture | None:
    """max|∂u/∂t| / max|u| against time, on a logarithmic scale."""
    rate = history.get("change_rate", np.empty(0))
    positive = np.isfinite(rate) & (rate > 0)
    if positive.sum() < 2:
        return None
    figure, axes = new_figure(height=3.3)
    axes.semilogy(history["time"][positive], rate[positive], label="rate of change")
    axes.yaxis.set_major_formatter(power_of_ten)
    if tolerance:
        axes.axhline(tolerance, label="tolerance (stop below)", **LEVEL)
    axes.set(
        title="Convergence to a steady state" if tolerance else "Rate of change",
        xlabel="t (time)",
        ylabel="max|∂u/∂t| / max|u| (1/time)",
    )
    figure.legend(loc="outside lower center", ncols=2)
    return Picture("convergence", "How fast the velocity still changes.", figure)


def _last_size(particles: Mapping[str, Mapping[str, np.ndarray]], load: str) -> dict[str, float]:
    """The largest |component| over the particles at the end of the run, by axis."""
    return {
        axis: max(
            abs(np.nan_to_num(columns[f"{load}_{axis}"][-1])) for columns in particles.values()
        )
        for axis in AXIS_NAMES
    }


def _components_shown(particles: Mapping[str, Mapping[str, np.ndarray]], load: str) -> list[str]:
    """The components that a reader would see, judged at the end of the run."""
    size = _last_size(particles, load)
    return [axis for axis in AXIS_NAMES if size[axis] >= 0.01 * max(size.values())]


def _draw_reference(
    axes: Axes, reference: Mapping[str, Any], curve: Mapping[str, list[float]] | None, colour: str
) -> None:
    """The points of a reference's curve as open circles, named once in the legend."""
    if not curve:
        return
    style = {"marker": "o", "linestyle": "none", "markerfacecolor": "none"}
    axes.plot(curve["coordinate"], curve["value"], color=colour, **style)
    label = reference_label(reference)
    if label not in axes.get_legend_handles_labels()[1]:
        axes.plot([], [], color="black", label=label, **style)


def _look_past_the_start(axes: Axes, keep: list[float]) -> None:
    """Scale the axis to the last 90 % of the time when what was before dwarfs it, and say so.

    An impulsive start makes the first forces as large as the time step is small; so does an early
    impact.
    """
    everything = np.concatenate([line.get_xydata() for line in axes.lines])
    everything = everything[np.isfinite(everything).all(axis=1)]
    if not everything.size:
        return
    start, end = everything[:, 0].min(), everything[:, 0].max()
    late = everything[everything[:, 0] >= start + 0.1 * (end - start), 1]
    values = np.concatenate([late, keep])
    low, high = values.min(), values.max()
    margin = 0.1 * max(high - low, 0.1 * abs(high), 0.1 * abs(low))
    if np.ptp(everything[:, 1]) <= 3 * (high - low + 2 * margin):
        return
    axes.set_ylim(low - margin, high + margin)
    extreme = everything[np.abs(everything[:, 1]).argmax()]
    note = f"beyond the frame: {extreme[1]:.4g} at t = {extreme[0]:.3g}".replace("-", "−")
    # Above the axes, where no curve can lie behind it.
    axes.set_title(note, loc="right", fontsize=8, fontweight="normal", color="#555555")
