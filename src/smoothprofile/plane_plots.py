"""Figures of one plane: the speed of the fluid, the electric field, the potential.

Units are the case's own: whatever length, time and mass its numbers were given in.
"""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from scipy.interpolate import RegularGridInterpolator

from smoothprofile.figures import Picture, new_figure
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.labels import position
from smoothprofile.runrecord import RunRecord

PLANE_WIDTH = 9.0
FORCE = "#D55E00"
LONGEST_ARROW = 0.12
"""Of the largest force, over the longer side of the plane."""
# A force this small beside the largest is not drawn; one this small beside ½εE²·area is round-off.
FAINT, NO_FORCE = 0.02, 1e-5

Plane = Mapping[str, np.ndarray]


def plane_pictures(record: RunRecord) -> list[Picture]:
    """What the data of a plane can show."""
    discs = discs_cut(record)
    plane = record.plane if discs is None else {**record.plane, "discs": discs}
    pictures = [speed_picture(plane), strength_picture(plane), potential_picture(plane)]
    return [picture for picture in pictures if picture is not None]


def discs_cut(record: RunRecord) -> np.ndarray | None:
    """(n,3): centres and radii √(a² − d²) of the discs that a plane cuts out of spheres at the end.

    None unless all bodies are spheres. With their images across periodic sides. A thick layer is
    painted so far out that neighbours would seem to touch where only their layers meet.
    """
    bodies = record.case.get("particles", ())
    if "axis" not in record.plane or not bodies or any(b["shape"] != "sphere" for b in bodies):
        return None
    names, domain = AXIS_NAMES, record.case["domain"]
    a, *across = (names.index(str(n)) for n in (record.plane["axis"], *record.plane["labels"]))
    low, lengths = np.array(domain.get("origin", [0.0] * 3)), np.array(domain["lengths"])
    periodic = np.array([kind == "periodic" for kind in domain["boundaries"]])
    places = np.array([_last_place(record, body) for body in bodies], dtype=float)
    places = np.where(periodic, low + np.mod(places - low, lengths), places)
    radius = np.array([body["radius"] for body in bodies], dtype=float)
    found = []
    for image in np.ndindex(3, 3, 3):
        moved = places + (np.array(image) - 1) * lengths * periodic
        square = radius**2 - (moved[:, a] - float(record.plane["at"])) ** 2
        cut = square > 0
        found.append(np.column_stack([moved[cut][:, across], np.sqrt(square[cut])]))
    return np.unique(np.concatenate(found), axis=0)


def _last_place(record: RunRecord, body: Mapping) -> list[float]:
    columns = record.particles.get(body["name"])
    if columns is None:
        return body["position"]
    return [columns[f"position_{name}"][-1] for name in AXIS_NAMES]


def speed_picture(plane: Plane) -> Picture | None:
    """|u| in a plane as filled contours, streamlines over it, particles outlined at φ = ½."""
    if not _can_show(plane, "speed"):
        return None
    figure, axes = _filled(plane, "speed", "speed |u| (length/time)", 0.0)
    _draw_streamlines(axes, plane, "velocity", outside=True)
    where = _finish(figure, axes, plane, "Speed")
    caption = f"Speed of the fluid in the plane {where} at the end, with streamlines in white."
    return Picture("plane", caption, figure, wide=True)


def strength_picture(plane: Plane) -> Picture | None:
    """|E| in a plane, bodies outlined, and the forces on those that the plane cuts as arrows."""
    if not _can_show(plane, "strength"):
        return None
    figure, axes = _filled(plane, "strength", "field strength |E| (√force/length)", 0.0)
    largest = _draw_forces(axes, plane)
    where = _finish(figure, axes, plane, "Strength of the electric field", largest)
    caption = f"Strength of the electric field in the plane {where}."
    if largest:
        caption += f" The longest arrow is a force of {largest:.3g} within the plane."
    return Picture("electric-field", caption, figure, wide=True)


def potential_picture(plane: Plane) -> Picture | None:
    """V in a plane, lines of force over it."""
    if not _can_show(plane, "potential"):
        return None
    figure, axes = _filled(plane, "potential", "potential V (√force)", None)
    _draw_streamlines(axes, plane, "electric_field", outside=False)
    where = _finish(figure, axes, plane, "Electric potential")
    caption = f"Electric potential in the plane {where}, with lines of the field in white."
    return Picture("potential", caption, figure, wide=True)


def _can_show(plane: Plane, name: str) -> bool:
    return name in plane and min(plane[name].shape) > 1 and bool(np.isfinite(plane[name]).all())


def _filled(plane: Plane, name: str, label: str, low: float | None) -> tuple[Figure, Axes]:
    """Filled contours from `low`, or from the least value, up to the greatest."""
    x, y, values = plane["x"], plane["y"], plane[name].T
    ratio = np.ptp(y) / np.ptp(x)
    width = PLANE_WIDTH if ratio < 0.7 else max(4.5, 6.5 / max(ratio, 1.0))
    figure, axes = new_figure(float(np.clip(0.8 * width * ratio, 1.5, 8.0)) + 1.1, width)
    top, low = float(values.max()), float(values.min()) if low is None else low
    filled = axes.contourf(x, y, values, levels=np.linspace(low, top if top > low else low + 1, 25))
    filled.set_edgecolor("face")
    bar = figure.colorbar(filled, ax=axes, label=label, pad=0.01, aspect=25)
    bar.locator = MaxNLocator(6, steps=[1, 2, 2.5, 5, 10])
    axes.set_aspect("equal" if 0.1 < ratio < 10 else "auto")
    axes.grid(visible=False)
    return figure, axes


def _finish(figure: Figure, axes: Axes, plane: Plane, what: str, force: float = 0.0) -> str:
    """Outlines, title and labels; returns which plane it is, in words."""
    x, y, indicator = plane["x"], plane["y"], plane["indicator"].T
    first, second = (str(label) for label in plane["labels"])
    handles = []
    if "discs" in plane:
        handles += _draw_discs(axes, plane["discs"])
    elif indicator.min() < 0.5 < indicator.max():
        axes.contour(x, y, indicator, levels=[0.5], colors="white", linewidths=2.6)
        axes.contour(x, y, indicator, levels=[0.5], colors="black", linewidths=1.2)
        handles.append(Line2D([], [], color="black", label="edge of a particle as painted, φ = ½"))
    if force:
        style = {"color": FORCE, "marker": ">", "linestyle": "-"}
        handles.append(Line2D([], [], label=f"force; the longest is {force:.3g}", **style))
    if handles:
        figure.legend(handles=handles, loc="outside lower center", ncols=2)
    where = position(str(plane["axis"]), float(plane["at"]))
    axes.set(
        title=f"{what} in the plane {where}",
        xlabel=f"{first} (length)",
        ylabel=f"{second} (length)",
        xlim=(x[0], x[-1]),
        ylim=(y[0], y[-1]),
    )
    # The layout first learns here how high equal units make the axes.
    figure.draw_without_rendering()
    return where


def _draw_discs(axes: Axes, discs: np.ndarray) -> list[Line2D]:
    """Outlines of the surfaces that the plane cuts, and their entry in the legend."""
    size = 2.0 * discs[:, 2]
    for colour, width in (("white", 2.6), ("black", 1.2)):
        outlines = EllipseCollection(
            size, size, np.zeros(len(size)), units="x", offsets=discs[:, :2],
            offset_transform=axes.transData, facecolors="none", edgecolors=colour, linewidths=width,
        )  # fmt: skip
        axes.add_collection(outlines, autolim=False)
    return [Line2D([], [], color="black", label="surface of a particle")] if len(size) else []


def _draw_streamlines(axes: Axes, plane: Plane, name: str, outside: bool) -> None:
    """Lines along a vector field; outside the particles alone, where what moves is the fluid.

    They need equal spacing: stretched axes are interpolated to as many points.
    """
    points = tuple(np.linspace(c[0], c[-1], c.size) for c in (plane["x"], plane["y"]))
    where = np.stack(np.meshgrid(*points, indexing="ij"), axis=-1)
    solid, u, v = (
        RegularGridInterpolator((plane["x"], plane["y"]), values)(where).T
        for values in (plane["indicator"], *plane[name])
    )
    if np.hypot(u, v).max() > 0:
        u = np.ma.masked_where(outside & (solid > 0.5), u)
        axes.streamplot(*points, u, v, color="#ffffff88", linewidth=0.6, arrowsize=0.6, density=0.8)


def _draw_forces(axes: Axes, plane: Plane) -> float:
    """Arrows of the forces on the bodies that the plane cuts; the size of the longest."""
    places, forces = plane.get("places", np.zeros((0, 2))), plane.get("forces", np.zeros((0, 2)))
    size = np.hypot(*forces.T)
    scale = float(plane.get("permittivity", 1.0)) * float(np.max(plane["strength"])) ** 2
    scale *= np.ptp(plane["x"]) * np.ptp(plane["y"])
    if not size.size or size.max() < NO_FORCE * scale:
        return 0.0
    longest = LONGEST_ARROW * max(np.ptp(plane["x"]), np.ptp(plane["y"]))
    style = {"arrowstyle": "-|>", "color": FORCE, "linewidth": 1.6, "shrinkA": 0.0, "shrinkB": 0.0}
    for place, force, strength in zip(places, forces, size, strict=True):
        if strength > FAINT * size.max():
            tip = place + force * longest / size.max()
            axes.annotate("", xy=tip, xytext=place, arrowprops=style)
    return float(size.max())
