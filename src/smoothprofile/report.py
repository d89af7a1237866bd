"""The report of a run: one HTML file that needs nothing else, rebuilt from the run directory."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from smoothprofile import cases, webpage
from smoothprofile.figures import Picture
from smoothprofile.grid import AXIS_NAMES
from smoothprofile.motion_numbers import motion_numbers
from smoothprofile.plots import pictures
from smoothprofile.runrecord import RunRecord, read_run

MOST_BODIES = 20
DRAWN = "drawn.txt"
BODY_QUANTITIES = (
    "position",
    "velocity",
    "force",
    "torque",
    "interior_velocity",
    "centre_field",
    "dipole",
    "maxwell_force",
)


def write_report(directory: Path | str, out: Path | None = None) -> Path:
    """Draw the figures of a run directory and write its report.html, or `out`; returns that path.

    Both are made anew from the other files each time. CaseError if the directory is not one.
    """
    record = read_run(directory)
    name = record.case.get("reference")
    reference = cases.reference(name) if name else {}
    drawn = pictures(record, reference)
    _write_figures(record.path / "figures", drawn)
    report = out or record.path / "report.html"
    report.write_text(page(record, drawn, reference), encoding="utf-8")
    return report


def _write_figures(folder: Path, drawn: Sequence[Picture]) -> None:
    """One PNG a figure; those that were drawn here before and are not any more go.

    `drawn.txt` lists what is drawn here, so that no other picture is ever taken away.
    """
    folder.mkdir(exist_ok=True)
    listed, names = folder / DRAWN, [f"{picture.name}.png" for picture in drawn]
    before = listed.read_text(encoding="utf-8").split("\n") if listed.is_file() else []
    for name in set(before) - set(names):
        if Path(name).name == name and name.endswith(".png"):
            (folder / name).unlink(missing_ok=True)
    for name, picture in zip(names, drawn, strict=True):
        (folder / name).write_bytes(picture.png)
    listed.write_text("\n".join(names), encoding="utf-8")


def page(record: RunRecord, drawn: Sequence[Picture], reference: Mapping[str, Any]) -> str:
    """The report as HTML text."""
    sections = [
        webpage.section("Result", _result(record)),
        webpage.section("Beside the reference", _beside(record, reference)),
        webpage.section("Figures", webpage.figures(drawn)),
        webpage.section("Error card", _error_card(record)),
        webpage.section("Resolution", _resolution(record)),
        webpage.section("Preliminary runs", _preliminary(record)),
        webpage.section("Particles", _bodies(record)),
        webpage.section("Force on the walls", _walls(record)),
        webpage.details("Case as it was run", f"<pre>{escape(record.case_toml)}</pre>"),
        webpage.details("Versions and machine", _versions(record)),
    ]
    title = record.case.get("title", record.path.name)
    return webpage.page(title, _status(record), sections)


def comparison(
    record: RunRecord, reference: Mapping[str, Any]
) -> list[tuple[str, float, float, list[float | None]]]:
    """(quantity, this run, reference, other computations) for what run and reference share.

    Of vectors, the component that is largest; of bodies, the first. The centre velocity is |u − V|
    at its centre, which is zero for a rigid body; the peak speed is over its history. The wall
    stress is the largest shear force on a wall over the wall's area.
    """
    measured = {}
    for body in record.summary.get("bodies", ())[:1]:
        for key in ("force", "torque", "dipole", "centre_field"):
            if key in body:
                measured[key] = max(body[key], key=abs)
        if "interior_velocity" in body:
            slip = np.subtract(body["interior_velocity"], body["velocity"])
            measured["centre_velocity"] = float(np.linalg.norm(slip))
    if tensor := record.summary.get("effective_permittivity"):
        measured["effective_permittivity"] = float(np.diag(tensor).max())
    measured |= motion_numbers(record.particles)
    for key in ("permittivity_along", "apparent_viscosity"):
        if key in record.summary:
            measured[key] = record.summary[key]
    if mean := record.summary.get("mean_velocity"):
        measured["mean_velocity"] = max(mean, key=abs)
    if stresses := _wall_stresses(record):
        measured["wall_stress"] = max(stresses)
    others = other_computations(record, reference)
    return [
        (webpage.words(key), value, reference[key], [values.get(key) for values in others.values()])
        for key, value in measured.items()
        if key in reference
    ]


def _wall_stresses(record: RunRecord) -> list[float]:
    """|shear force|/area of each wall."""
    stresses = []
    for side, force in (record.summary.get("wall_force") or {}).items():
        if side == "total":
            continue
        along = [d for d in range(3) if AXIS_NAMES[d] != side[0]]
        area = np.prod([record.case["domain"]["lengths"][d] for d in along])
        stresses.append(float(np.linalg.norm([force[d] for d in along]) / area))
    return stresses


def other_computations(
    record: RunRecord, reference: Mapping[str, Any]
) -> dict[str, Mapping[str, Any]]:
    """Label to numbers of the other computations that a reference quotes, such as the thesis'.

    Of several runs the one with this run's cells, thickness and time step, else the last.
    """
    case = record.case
    ours = [*case["domain"]["cells"], case.get("profile", {}).get("thickness")]
    ours.append(record.summary.get("time_step"))
    found = {}
    for group in reference.values():
        if not isinstance(group, Mapping) or not isinstance(group.get("label"), str):
            continue
        runs = group.get("runs", [])
        same = [run for run in runs if [*run["cells"], run["thickness"], run["step"]] == ours]
        found[group["label"]] = same[0] if same else {**group, **(runs[-1] if runs else {})}
    return found


def curve_difference(
    curve: tuple[np.ndarray, np.ndarray] | None, reference: Mapping[str, Sequence[float]]
) -> tuple[int, float, float]:
    """(points, max|y − yᵣ|, max|y − yᵣ|/max|yᵣ|) at the reference's points inside the curve.

    Points before the first sample or past the last are not compared; there may be none left.
    """
    if curve is None:
        return 0, 0.0, 0.0
    at, value = (np.asarray(reference[key], dtype=float) for key in ("coordinate", "value"))
    inside = (at >= curve[0][0]) & (at <= curve[0][-1])
    if not inside.any():
        return 0, 0.0, 0.0
    largest = float(np.abs(PchipInterpolator(*curve)(at[inside]) - value[inside]).max())
    return int(inside.sum()), largest, largest / float(np.abs(value).max())


def _status(record: RunRecord) -> str:
    status = record.run.get("status", "unknown")
    badge = webpage.badge(status, webpage.words(status))
    summary, parts = record.summary, [record.run.get("message")]
    if "steps" in summary:
        parts.append(
            f"{webpage.number(summary['steps'])} steps to t = {webpage.number(summary['time'])}"
        )
    if "wall_seconds" in summary:
        threads = summary.get("threads")
        parts.append(
            f"{webpage.number(summary['wall_seconds'])} s on {threads} thread"
            + ("s" if threads != 1 else "")
        )
    if "cells" in summary:
        parts.append(f"{webpage.number(summary['cells'])} cells")
    parts.append(record.run.get("started", "").replace("T", " ").replace("+00:00", " UTC"))
    lines = [" · ".join(filter(None, parts)), _units(record)]
    return badge + "<br>".join(f'<span class="faint">{escape(t)}</span>' for t in lines if t)


def _units(record: RunRecord) -> str:
    """What 1 means in the case, if it says so."""
    units = record.case.get("units")
    if not units:
        return ""
    mass = units.get("density") or units.get("mass") or "1 kg"
    field = "; the field is √ε₀ E or √μ₀ H" if "electric" in record.case else ""
    return f"1 means {units['length']}, {units['time']}, {mass}{field}"


def _result(record: RunRecord) -> str:
    table = record.summary.get("table", ())
    rows = [(name, webpage.number(value), note or "") for name, value, note in table]
    return webpage.table(("quantity", "value", ""), rows, numbers={1})


def _beside(record: RunRecord, reference: Mapping[str, Any]) -> str:
    if not reference:
        return ""
    others = other_computations(record, reference)
    rows = [
        (name, webpage.number(ours), webpage.number(exact), webpage.percent(ours, exact),
         *(webpage.with_percent(value, exact) for value in values))
        for name, ours, exact, values in comparison(record, reference)
    ]  # fmt: skip
    heads = ("quantity", "this run", reference.get("label", "reference"), "difference", *others)
    known = reference.get("lines", {})
    curves = [(f"velocity, {n}", curve, known.get(n)) for n, curve in record.lines.items()]
    curves.append(("wall shear", record.wall_shear, reference.get("wall_line")))
    found = [(name, curve_difference(curve, exact)) for name, curve, exact in curves if exact]
    lines = [
        (name, webpage.number(points), webpage.number(largest), f"{100 * share:.2f} %")
        for name, (points, largest, share) in found
        if points
    ]
    line_heads = ("curve", "points", "largest difference", "of its largest value")
    notes = [f"{reference.get('label', 'reference')}: {reference.get('source', '')}"]
    notes += [
        f"{label}: {'×'.join(map(str, run['cells']))} cells, thickness {run['thickness']:g}, "
        f"time step {run['step']:g}"
        for label, run in others.items()
        if "cells" in run
    ]
    note = "".join(f'<p class="note">{escape(text)}</p>' for text in notes)
    numbers = set(range(1, len(heads)))
    return webpage.table(heads, rows, numbers) + webpage.table(line_heads, lines, {1, 2, 3}) + note


def _resolution(record: RunRecord) -> str:
    checks = [
        (
            check["name"],
            *(webpage.number(check[key]) for key in ("value", "limit")),
            check["verdict"],
            check.get("note") or "",
        )
        for check in record.run.get("preflight", ())
    ]
    heads = ("check", "value", "limit or best", "verdict", "")
    return webpage.table(heads, checks, numbers={1, 2})


def _error_card(record: RunRecord) -> str:
    rows = [
        (line["name"], _short(line["value"]), line["verdict"], line["note"])
        for line in record.summary.get("error_card", ())
    ]
    return webpage.table(("what", "value", "verdict", ""), rows, numbers={1})


def _short(value: float | None) -> str:
    """Three digits, which are enough for an error."""
    return webpage.number(value if value is None else float(f"{value:.3g}"))


def _preliminary(record: RunRecord) -> str:
    heads = ("cells", "steps", "time", "status", "wall_seconds")
    rows = [
        [webpage.number(stage.get(head)) for head in heads]
        for stage in record.summary.get("start", ())
    ]
    return webpage.table([webpage.words(head) for head in heads], rows, numbers={1, 2, 4})


def _bodies(record: RunRecord) -> str:
    bodies = record.summary.get("bodies", ())
    quantities = [name for name in BODY_QUANTITIES if bodies and name in bodies[0]]
    largest = {name: _largest(body.get(name) for body in bodies) for name in quantities}
    if {"force", "torque"} <= largest.keys():
        turning = largest["force"] * max(record.case["domain"]["lengths"])
        largest["torque"] = max(largest["torque"], turning)
    rows = [
        (body["name"], *(webpage.number(body.get(name), largest[name]) for name in quantities))
        for body in bodies
    ]
    table = webpage.table(
        ("name", *map(webpage.words, quantities)),
        rows[:MOST_BODIES],
        set(range(1, len(quantities) + 1)),
    )
    left, notes = len(rows) - MOST_BODIES, []
    if left > 0:
        notes.append(f"{left} more in particles.csv.")
    if any(_is_outside(record, body.get("position")) for body in bodies):
        notes.append("Positions go on past periodic sides: they are not put back into the box.")
    return table + (f'<p class="note">{" ".join(notes)}</p>' if notes else "")


def _is_outside(record: RunRecord, place: Sequence[float | None] | None) -> bool:
    domain = record.case["domain"]
    box = zip(place or (), domain.get("origin", [0.0] * 3), domain["lengths"], strict=False)
    return any(at is not None and not low <= at <= low + length for at, low, length in box)


def _walls(record: RunRecord) -> str:
    forces = record.summary.get("wall_force") or {}
    largest = _largest(forces.values())
    rows = [(webpage.words(side), webpage.number(f, largest)) for side, f in forces.items()]
    return webpage.table(("wall", "force"), rows, numbers={1})


def _largest(vectors: Iterable[Sequence | None]) -> float:
    """The largest size of a component, None counting as nothing."""
    return max((abs(part or 0.0) for vector in vectors for part in vector or ()), default=0.0)


def _versions(record: RunRecord) -> str:
    run = record.run
    facts = {**run.get("versions", {}), **run.get("machine", {}), "command": run.get("command")}
    return webpage.table(
        ("", ""), [(name, str(value)) for name, value in facts.items()], numbers=set()
    )
