"""The result of a run as a table for people."""

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from smoothprofile.assembly import smoothing_of
from smoothprofile.field_checks import smoothing_note
from smoothprofile.numbers import number_rows
from smoothprofile.rows import fastest

if TYPE_CHECKING:
    from smoothprofile.config import Case
    from smoothprofile.electrostatics import Electrostatics
    from smoothprofile.simulation import Simulation
    from smoothprofile.stokes_simulation import StokesSimulation
    from smoothprofile.views import FlowViews

Shown = Callable[[str, np.ndarray], str]
"""(kind, vector) -> in words."""

ROUND_OFF = 1e-12
MOST_BODIES = 6
FEW_BODIES = 3
"""Up to so many stand before what is true of all together."""


def result_table(run: "Simulation") -> list[tuple[str, str, str]]:
    """The result as rows quantity, value, note, for people."""
    summary, pairing = run.summary(), run.pairing
    rows = [
        ("status", run.status, f"{run.steps} steps to t = {run.time:.6g}"),
        *_of_units(run.case),
        ("time step", f"{run.time_step:.6g}", _limit(pairing.limit)),
    ]
    if pairing.ratio is not None:
        shift = _round(pairing.shift, 4)
        side = "retreats" if shift >= 0 else "advances"
        acts = f"{side} {abs(shift):.4f} ξ" if shift else "acts where it is painted"
        note = f"best {pairing.best_ratio:.4f}; a flat wall {acts}"
        rows.append(("√(νΔt)/ξ", f"{pairing.ratio:.4f}", note))
    vector = _shown_of(run)
    rest = _of_all(run, summary, vector)
    if run.flow.mean_flow.targets:
        rest.append(("driving force", vector("drive", run.driving_force), "per unit volume"))
    rest += [
        *_numbers(number_rows(run.case, fastest(run))),
        ("largest divergence", f"{summary['max_divergence']:.2g}", "round-off"),
        ("rate of change", f"{summary['change_rate']:.2g}", "max|∂u/∂t|/max|u|"),
        _clock(run, summary),
    ]
    return _in_order(rows, _of_bodies(run, vector), rest, len(run.case.particles))


def stokes_table(run: "StokesSimulation") -> list[tuple[str, str, str]]:
    """The result of a run without inertia as rows quantity, value, note, for people."""
    summary, report = run.summary(), run.flow.report
    vector = _shown_of(run)
    went = f"{run.steps} steps to t = {run.time:.6g}" if run.steps else "nothing moves"
    solved = f"residual {report.residual:.2g}, of the last flow"
    rows = [
        ("status", run.status, went),
        *_of_units(run.case),
        ("time step", f"{run.time_step:.6g}", "no limit of stability"),
        ("iterations", str(report.iterations), solved),
    ]
    rest = [
        *_of_all(run, summary, vector),
        ("driving force", vector("drive", run.driving_force), "per unit volume"),
        *_numbers(number_rows(run.case, fastest(run))),
        ("largest divergence", f"{summary['max_divergence']:.2g}", "round-off"),
        _clock(run, summary),
    ]
    return _in_order(rows, _of_bodies(run, vector), rest, len(run.case.particles))


def _in_order(head: list, bodies: list, rest: list, count: int) -> list[tuple[str, str, str]]:
    """All rows: those of a few bodies before what is true of all together, those of many last."""
    return [*head, *rest, *bodies] if count > FEW_BODIES else [*head, *bodies, *rest]


def _of_bodies(run: "FlowViews", vector: Shown) -> list[tuple[str, str, str]]:
    """What a run of a fluid says of its first bodies."""
    bodies, each = run.particles, []
    for body, particle in zip(bodies[:MOST_BODIES], run.case.particles, strict=False):
        each += _of_body(body, particle.motion == "free", vector, run.has_inertia)
    if len(bodies) > MOST_BODIES:
        each.append(("other bodies", str(len(bodies) - MOST_BODIES), "see particles.csv"))
    return each


def _of_all(run: "FlowViews", summary: dict, vector: Shown) -> list[tuple[str, str, str]]:
    """What a run of a fluid says of its suspension and of the walls, as a whole."""
    rows, bodies = _of_permittivity(run.case), run.bodies.state
    if len(bodies.velocity) > MOST_BODIES:
        note = f"of all {len(bodies.velocity)} bodies"
        rows.append(("mean velocity", vector("velocity", bodies.velocity.mean(axis=0)), note))
    if "apparent_viscosity" in summary:
        note = "stress on the walls over the rate of shear"
        rows.append(("apparent viscosity", f"{summary['apparent_viscosity']:.6g}", note))
    if "mean_chain_length" in summary:
        note = f"beads; the longest has {summary['longest_chain']}"
        rows.append(("mean chain length", f"{summary['mean_chain_length']:.4g}", note))
    if len(summary["wall_force"]) > 1:
        total = vector("force", summary["wall_force"]["total"])
        rows.append(("force on the walls", total, "of the fluid"))
    return rows


def field_table(run: "Electrostatics") -> list[tuple[str, str, str]]:
    """The result of a field alone as rows quantity, value, note, for people."""
    summary, electric = run.summary(), run.case.electric
    solved = f"{electric.method}, {summary['iterations']} iterations"
    rows = [
        ("status", run.status, solved),
        *_of_units(run.case),
        ("residual", f"{summary['residual']:.2g}", f"tolerance {electric.tolerance:g}"),
        ("mean field", _vector(summary["mean_field"]), ""),
        ("mean displacement", _vector(summary["mean_displacement"]), ""),
        ("energy", f"{summary['energy']:.6g}", "½∫E·εE dV"),
        *_of_permittivity(run.case),
    ]
    if run.effective_permittivity is not None:
        for name, row in zip("xyz", run.effective_permittivity, strict=True):
            note = "of the whole box" if name == "x" else ""
            rows.append((f"effective permittivity, {name}", _vector(row), note))
    if run.permittivity_along is not None:
        note = "between the electrodes, mean displacement over mean field"
        rows.append(("effective permittivity", f"{run.permittivity_along:.6g}", note))
    bodies, each = run.particles, []
    for body in bodies[:MOST_BODIES]:
        each += _in_field(body)
    if len(bodies) > MOST_BODIES:
        each.append(("other bodies", str(len(bodies) - MOST_BODIES), "see particles.csv"))
    seconds = f"{summary['wall_seconds']:.3g} s"
    rest = _numbers(number_rows(run.case))
    rest.append(("wall-clock", seconds, _threads(summary["threads"])))
    return _in_order(rows, each, rest, len(bodies))


def _of_units(case: "Case") -> list[tuple[str, str, str]]:
    if case.units is None:
        return []
    units = case.units
    names = ("length", "time", "mass" if units.density is None else "density")
    note = (
        ", ".join(names)
        + " that 1 means here"
        + ("; the field is √ε₀ E or √μ₀ H" if case.electric else "")
    )
    values = (units.length, units.time, units.density or units.mass or "1 kg")
    return [("units", ", ".join(values), note)]


def _of_permittivity(case: "Case") -> list[tuple[str, str, str]]:
    if case.electric is None or not case.particles:
        return []
    return [("smoothing of ε", smoothing_of(case), smoothing_note(case))]


def _in_field(body: dict) -> list[tuple[str, str, str]]:
    name, inside = body["name"], body["centre_field"]
    rows = [(f"field in {name}", _vector(inside), "at its centre")]
    if "force" not in body:
        return rows
    # Loads beside those that the field exerts on a dipole of this size, over about its own length.
    faint = 1e-9 * float(np.linalg.norm(body["dipole"]) * np.linalg.norm(inside))
    note = "no room for a surface around it"
    if np.isfinite(body["maxwell_force"]).all():
        note = f"{_vector(body['maxwell_force'], faint)} by Maxwell stress"
    return [
        *rows,
        (f"dipole of {name}", _vector(body["dipole"]), ""),
        (f"force on {name}", _vector(body["force"], faint), note),
        (f"torque on {name}", _vector(body["torque"], faint), "about its position"),
    ]


def _numbers(rows: list[tuple[str, float, str]]) -> list[tuple[str, str, str]]:
    return [(name, f"{value:.6g}", note) for name, value, note in rows]


def _of_body(body: dict, free: bool, vector: Shown, inertia: bool) -> list[tuple[str, str, str]]:
    name, inside = body["name"], body["interior_velocity"] - body["velocity"]
    told = [
        ("force", "force on", "of the fluid"),
        ("torque", "torque on", "of the fluid, about its position"),
    ]
    if free:
        told = [
            ("velocity", "velocity of", "at the end"),
            ("angular_velocity", "spin of", "at the end"),
            ("position", "place of", "its centre of mass"),
            *told,
        ]
    rows = [(f"{words} {name}", vector(key, body[key]), note) for key, words, note in told]
    offset = body["painted_offset"]
    side = "outside" if offset >= 0 else "inside"
    rows.append((f"surface of {name}", f"{abs(offset):.5g}", f"painted this far {side}"))
    if body["shape"] != "plane":
        slip = f"{np.linalg.norm(inside):.3g}"
        layer = "that of the layer, which the painted surface makes up for"
        note = f"at its centre; {'0 is exact' if inertia else layer}"
        rows.append((f"slip inside {name}", slip, note))
    return rows


def _shown_of(run: "FlowViews") -> Shown:
    """How vectors of a kind are shown, those of round-off as 0: against the largest of the run."""
    drive = run.driving_force * run.grid.volume
    forces = [drive, *run.bodies.state.force, *run.wall_force.values()]
    length = max(run.grid.lengths)
    forces += [torque / length for torque in run.bodies.state.torque]
    force = max(float(np.linalg.norm(f)) for f in forces)
    speed = max(run.extremes.speed)
    largest = {
        "force": force,
        "torque": force * length,
        "drive": force / run.grid.volume,
        "velocity": speed,
        "angular_velocity": speed / length,
        "position": length,
    }
    return lambda kind, values: _vector(values, ROUND_OFF * largest[kind])


def _vector(values: np.ndarray, faint: float | None = None) -> str:
    """Components below `faint` are 0; if it is left out, those that vanish beside the largest."""
    if faint is None:
        faint = ROUND_OFF * float(np.abs(values).max())
    return "(" + ", ".join(f"{0.0 if abs(v) < faint else v:.6g}" for v in values) + ")"


def _limit(step: float) -> str:
    return f"stable up to {step:.4g}" if np.isfinite(step) else "no limit from advection"


def _clock(run: "FlowViews", summary: dict) -> tuple[str, str, str]:
    """Wall-clock, and how much of it was the first step where that is most of it."""
    seconds, note = summary["wall_seconds"], _threads(summary["threads"])
    first = run.wall_seconds - (run.steps - 1) * run.seconds_per_step
    if run.steps > 1 and first > 0.5 * seconds:
        note += f", of which the first step, with compiling, {first:.3g} s"
    return "wall-clock", f"{seconds:.3g} s", note


def _threads(count: int) -> str:
    return "1 thread" if count == 1 else f"{count} threads"


def _round(value: float, digits: int) -> float:
    """Rounded, and never minus zero."""
    return round(value, digits) + 0.0
