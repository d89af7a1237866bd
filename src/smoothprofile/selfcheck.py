"""The error card of a run: what it can say of its own errors at its end.

divergence       max|∇·u| h / max|u|
momentum         |f V − F_walls − F_bodies| / (|f|V + |F_walls| + |F_bodies|)     at a steady state
slip             max|u(R) − V| / max|u|
overlap          max(a₁ + a₂ − |R₁ − R₂|) / a        of spheres
a/ξ, ξ/Δx, √(νΔt)/ξ beside its best                  from the checks before the run

f is what drives the fluid, by volume; F_walls and F_bodies are what it gives to walls and bodies.
Each is green, amber or red, with its reason; limits are per cent of an answer, not of round-off.
"""

from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from smoothprofile.distances import SPHERE

Line = dict[str, Any]
GREEN, AMBER, RED = "green", "amber", "red"
SHARES = (0.01, 0.05)
OVERLAPS = (0.01, 0.1)
ROUND_OFF = {"double": (1e-10, 1e-6), "single": (1e-4, 1e-2)}
RESOLUTION = ("a/ξ", "ξ/Δx", "√(νΔt)/ξ")


def error_card(run: Any) -> list[Line]:
    """Lines name, value, verdict, note."""
    lines = [_divergence(run)]
    if run.status == "steady":
        lines.append(_momentum(run))
    if run.case.particles:
        lines += [_slip(run), *_overlap(run)]
    return lines + [_resolution(check) for check in run.preflight() if check["name"] in RESOLUTION]


def _line(name: str, value: float, limits: tuple[float, float], note: str) -> Line:
    """Green up to the first limit, amber up to the second; a NaN is red."""
    verdict = GREEN if value <= limits[0] else AMBER if value <= limits[1] else RED
    return {"name": name, "value": value, "verdict": verdict, "note": note}


def _divergence(run: Any) -> Line:
    speed, width = max(run.extremes.speed), min(run.grid.smallest_widths)
    largest = run.flow.projection.largest_divergence(run.state.velocity)
    share = largest * width / speed if speed else 0.0
    limits = ROUND_OFF[run.case.domain.precision]
    return _line("divergence", share, limits, "largest, over the largest speed and a cell")


def _momentum(run: Any) -> Line:
    driven = run.driving_force * run.grid.volume
    walls, bodies = run.wall_force["total"], run.bodies.state.force.sum(axis=0)
    size = sum(float(np.linalg.norm(part)) for part in (driven, walls, bodies))
    left = float(np.linalg.norm(driven - walls - bodies))
    note = "what drives the fluid, less what walls and bodies take, over their sum"
    return _line("momentum", left / size if size else 0.0, SHARES, note)


def _slip(run: Any) -> Line:
    slip = [
        float(np.linalg.norm(body["interior_velocity"] - body["velocity"]))
        for body in run.particles
    ]
    speed = max(run.extremes.speed)
    share = max(slip) / speed if speed else 0.0
    return _line("slip inside bodies", share, SHARES, "at their centres, over the largest speed")


def _overlap(run: Any) -> list[Line]:
    """Of the bodies that are single spheres, if there are two."""
    forms = run.bodies.painter.forms
    first, parts = forms.part_start[:-1], np.diff(forms.part_start)
    balls = np.flatnonzero((parts == 1) & (forms.kind[first] == SPHERE))
    if balls.size < 2:
        return []
    radius = forms.size[first[balls], 0]
    low = np.array([axis.low for axis in run.grid.axes])
    periods = np.where(run.grid.periodic, run.grid.lengths, 0.0)
    place = run.bodies.state.position[balls] - low
    wrapped = np.where(periods > 0.0, place % np.where(periods > 0.0, periods, 1.0), place)
    wrapped = np.where((periods > 0.0) & (wrapped >= periods), 0.0, wrapped)
    pairs = cKDTree(wrapped, boxsize=periods).query_pairs(2.0 * radius.max(), output_type="ndarray")
    apart = wrapped[pairs[:, 0]] - wrapped[pairs[:, 1]]
    apart -= periods * np.round(apart / np.where(periods > 0.0, periods, 1.0))
    touching = radius[pairs].sum(axis=1) - np.linalg.norm(apart, axis=1)
    share = float(np.max(touching / radius[pairs].min(axis=1), initial=0.0))
    return [_line("overlap of spheres", share, OVERLAPS, "deepest, over the smaller radius")]


def _resolution(check: Line) -> Line:
    verdict = GREEN if check["verdict"] == "ok" else AMBER
    note = f"beside {check['limit']:.3g}: {check['note']}"
    return {"name": check["name"], "value": check["value"], "verdict": verdict, "note": note}
