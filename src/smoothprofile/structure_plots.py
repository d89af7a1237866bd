"""Figures of beads that form chains, and of the stress on walls that slide past them."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import to_rgb

from smoothprofile.config.fluid import STOKES
from smoothprofile.csvtables import number_columns, read_table
from smoothprofile.figures import DASHES, LEVEL, PALETTE, Picture, legend_below, new_panels
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.runrecord import RunRecord
from smoothprofile.structure import TABLE, Beads, bonds, chain_of

WIDTH, HEIGHT = 9.0, 3.3
LONE = "#b9c1cb"
FADED = 0.65
"""How far towards white the farthest beads are shaded."""
ALTERNATES = 1e-3
"""A field whose square varies by more than this share; one that is held or turns keeps its own."""

History = Mapping[str, np.ndarray]


def structure_pictures(record: RunRecord) -> list[Picture]:
    """What a run directory can show of chains and of the stress on sliding walls."""
    table = number_columns(read_table(record.path / TABLE))
    drawn = [
        beads_picture(record),
        chains_picture(record.history),
        energy_picture(record.history),
        pairs_picture(table),
        stress_picture(record.history, record.case.get("fluid", {}).get("flow") != STOKES),
    ]
    return [picture for picture in drawn if picture is not None]


def beads_picture(record: RunRecord) -> Picture | None:
    """Beads at the start and at the end, across the field and along it."""
    if "mean_chain_length" not in record.history or not record.particles:
        return None
    f = field_axis(record.case)
    frames = {"Start": _starting(record), "End": _ending(record)}
    figure, panels = new_panels(4, 2.9, 10.0)
    for number, (axes, (what, view)) in enumerate(
        zip(panels, ((w, v) for v in (0, 1) for w in frames), strict=True)
    ):
        beads = frames[what]
        draw_beads(axes, beads, chain_of(beads.radius.size, bonds(beads)[0]), *views(f)[view])
        axes.set_title(f"{what}, {'along' if view else 'across'} the field")
        if number % 2:
            axes.set_ylabel("")
    caption = (
        "Beads at the start and at the end, seen across the field and along it: each chain in a "
        "colour, lone beads grey, farther ones paler."
    )
    return Picture("beads", caption, figure, wide=True)


def chains_picture(history: History) -> Picture | None:
    """⟨s⟩ and ⟨s⟩_m and the longest chain against time; P₂ of the bonds, and the smallest gap."""
    if len(history.get("mean_chain_length", ())) < 2:
        return None
    time = history["time"]
    figure, (lengths, order, gaps) = new_panels(3, HEIGHT, WIDTH)
    curves = {
        "mean_chain_length": "mean over chains",
        "mass_mean_chain_length": "mean over beads",
        "longest_chain": "longest",
    }
    for (name, label), dashes in zip(curves.items(), DASHES, strict=True):
        lengths.plot(time, history[name], dashes, label=label)
    if np.isfinite(history["alignment"]).any():
        order.plot(time, history["alignment"])
    else:
        order.set(xlim=lengths.get_xlim(), yticks=[])
        order.text(0.5, 0.5, "no bonds", ha="center", transform=order.transAxes)
    gaps.plot(time, history["smallest_gap"])
    gaps.axhline(0.0, **LEVEL)
    legend_below(lengths, 3)
    lengths.set(title="Length of chains", xlabel="t (time)", ylabel="beads", ylim=(0, None))
    order.set(title="Bonds along the field", xlabel="t (time)", ylabel="⟨(3cos²θ − 1)/2⟩ (–)")
    gaps.set(title="Smallest gap", xlabel="t (time)", ylabel="h (length)")
    caption = (
        "Length of chains, how far bonds lie along the field (1 along, 0 at random), and the "
        "smallest gap between two beads, against time."
    )
    return Picture("chains", caption, figure, wide=True)


def energy_picture(history: History) -> Picture | None:
    """Ω − Ω₀, Ω = −½∫E·εE dV, and the effective permittivity along the field, against time.

    Of a field that alternates, Ω in the mean square of E₀: ∫E·εE dV = V⟨D⟩·E₀ goes with it.
    """
    energy = history.get("electric_energy", np.empty(0))
    if energy.size < 2 or "mean_chain_length" not in history:
        return None
    figure, (falls, permittivity) = new_panels(2, HEIGHT, WIDTH)
    along = history["permittivity_along"]
    square, what = energy / along, ""
    if np.ptp(square) > ALTERNATES * square.max():
        energy, what = along * square.mean(), " Ω is that in the mean square of the field."
    falls.plot(history["time"], -(energy - energy[0]))
    permittivity.plot(history["time"], along)
    falls.set(title="Energy that falls", xlabel="t (time)", ylabel="Ω − Ω₀ (force·length)")
    permittivity.set(title="Effective permittivity", xlabel="t (time)", ylabel="⟨D⟩·E₀/E₀² (–)")
    caption = (
        "What falls while the mean field is held is Ω = −½∫E·εE dV: the source of the field "
        "does twice the work that ½∫E·εE dV gains. On the right ⟨D⟩ along the field over it."
    )
    return Picture("field-energy", caption + what, figure, wide=True)


def pairs_picture(table: Mapping[str, np.ndarray]) -> Picture | None:
    """g(r) of all pairs, of those along the field and of those across it."""
    if not table or not table["g"].any():
        return None
    figure, (axes,) = new_panels(1, HEIGHT, 5.4)
    labels = {"g_along": "along the field", "g_across": "across it", "g": "all pairs"}
    for number, (name, label) in enumerate(labels.items()):
        axes.plot(table["r"], table[name], DASHES[number], label=label, drawstyle="steps-mid")
    axes.axhline(1.0, **LEVEL)
    axes.set(title="Pairs at a distance", xlabel="r (length)", ylabel="g (–), logarithmic above 1")
    axes.set_yscale("symlog", linthresh=1.0)
    near = float(table["r"][np.flatnonzero(table["g"])[:1]].sum())
    axes.set(xlim=(0.8 * near, float(table["r"][-1])), ylim=(0.0, None))
    axes.yaxis.set_major_formatter("{x:g}")
    legend_below(axes, 3)
    caption = (
        "Pairs of beads at a distance at the end, over those of beads anywhere; along and across "
        "the field means within 30°."
    )
    return Picture("pairs", caption, figure)


def stress_picture(history: History, inertia: bool = True) -> Picture | None:
    """τ on sliding walls and its parts against time; the parts are all of it without inertia."""
    if len(history.get("wall_stress", ())) < 2:
        return None
    figure, (axes,) = new_panels(1, HEIGHT, 5.4)
    labels = {
        "wall_stress": "on the walls",
        "viscous_stress": "viscous",
        "contact_stress": "contact",
        "electric_stress": "electric",
    }
    for number, (name, label) in enumerate(labels.items()):
        if not history[name].any():
            continue
        axes.plot(
            history["time"], history[name], label=label, color=PALETTE[(number + 3) % 4],
            linewidth=1.5 if number else 2.5,
        )  # fmt: skip
    _leave_start_out(axes, history, list(labels))
    axes.set(title="Shear stress", xlabel="t (time)", ylabel="τ (force/length²)")
    axes.figure.legend(loc="outside lower center", ncols=4)
    caption = "Shear stress on the sliding walls, and what bears it"
    caption += "; the rest is inertia." if inertia else "."
    return Picture("wall-stress", caption, figure)


def draw_beads(
    axes: Axes, beads: Beads, chains: np.ndarray, across: int, up: int, depth: int
) -> None:
    """Beads as discs, nearer ones over farther ones, which are paler; images where cut by a side.

    A chain's colour is that of its first bead, so that it lasts as chains grow.
    """
    colours = _colours(chains)
    places = beads.wrapped
    far = places[:, depth] / beads.lengths[depth]
    shade = FADED * np.clip(far, 0.0, 1.0)[:, None]
    colours = colours * (1.0 - shade) + shade
    rows, points = [], []
    for a in (-1, 0, 1) if beads.periodic[across] else (0,):
        for b in (-1, 0, 1) if beads.periodic[up] else (0,):
            moved = places[:, [across, up]] + [a * beads.lengths[across], b * beads.lengths[up]]
            over = moved + beads.radius[:, None]
            under = moved - beads.radius[:, None] - beads.lengths[[across, up]]
            seen = np.flatnonzero((over > 0).all(axis=1) & (under < 0).all(axis=1))
            rows.append(seen)
            points.append(moved[seen])
    rows, points = np.concatenate(rows), np.concatenate(points)
    order = np.argsort(-far[rows], kind="stable")
    rows, points = rows[order], points[order] + beads.low[[across, up]]
    size = 2.0 * beads.radius[rows]
    discs = EllipseCollection(
        size, size, np.zeros(len(rows)), units="x", offsets=points, offset_transform=axes.transData,
        facecolors=colours[rows], edgecolors="#333a42", linewidths=0.4,
    )  # fmt: skip
    axes.add_collection(discs)
    low, high = beads.low, beads.low + beads.lengths
    names = AXIS_NAMES
    axes.set(
        xlim=(low[across], high[across]), ylim=(low[up], high[up]), aspect="equal",
        xlabel=f"{names[across]} (length)", ylabel=f"{names[up]} (length)",
    )  # fmt: skip
    axes.grid(visible=False)


def views(axis: int) -> tuple[tuple[int, int, int], tuple[int, int, int]]:
    """Axes across, up and into the picture: with that axis upward, and with it into the picture."""
    second, third = (axis + 1) % 3, (axis + 2) % 3
    return (second, axis, third), (second, third, axis)


def field_axis(case: Mapping) -> int:
    """The axis nearest to the field of a case, z without one."""
    electric = case.get("electric", {})
    if "electrodes" in electric:
        return AXIS_NAMES.index(electric["electrodes"]["axis"])
    given = np.abs(electric.get("field", [0.0, 0.0, 1.0]))
    return int(np.argmax(given if given.any() else np.abs(electric["quadrature"])))


def box_of(case: Mapping) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Low corner, lengths and what is periodic of a case's domain."""
    domain = case["domain"]
    periodic = np.array([kind == "periodic" for kind in domain["boundaries"]])
    return np.array(domain.get("origin", [0.0] * 3)), np.array(domain["lengths"]), periodic


def _starting(record: RunRecord) -> Beads:
    balls = _balls(record)
    places = np.array([balls[name]["position"] for name in balls], dtype=float)
    return Beads(places, np.array([b["radius"] for b in balls.values()]), *box_of(record.case))


def _ending(record: RunRecord) -> Beads:
    balls = _balls(record)
    columns = [record.particles[name] for name in balls]
    places = np.array([[c[f"position_{axis}"][-1] for axis in AXIS_NAMES] for c in columns])
    return Beads(places, np.array([b["radius"] for b in balls.values()]), *box_of(record.case))


def _balls(record: RunRecord) -> dict[str, Mapping]:
    return {
        p["name"]: p
        for p in record.case["particles"]
        if p["shape"] == "sphere" and p["name"] in record.particles
    }


def _colours(chains: np.ndarray) -> np.ndarray:
    """(n,3) of each bead: grey if alone, else by the first bead of its chain."""
    _, first, inverse, size = np.unique(
        chains, return_index=True, return_inverse=True, return_counts=True
    )
    palette = np.array([to_rgb(colour) for colour in PALETTE[:6]])
    found = palette[first[inverse] % len(palette)]
    found[size[inverse] == 1] = to_rgb(LONE)
    return found


def _leave_start_out(axes: Axes, history: History, names: list[str]) -> None:
    """Scale to what comes after the first tenth: an impulsive start dwarfs the rest."""
    late = history["time"] >= 0.1 * history["time"][-1]
    values = np.concatenate([history[name][late] for name in names])
    margin = 0.05 * max(float(np.ptp(values)), 1e-300)
    axes.set_ylim(min(float(values.min()) - margin, 0.0), float(values.max()) + margin)
