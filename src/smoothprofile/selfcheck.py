"""The error card of a run: what it can say of its own errors at its end.

divergence       max|∇·u| h / max|u|
momentum         |f V − ΣF_walls + ΣB − d(ρ∫u)/dt| over the sum of their sizes
energy           |work − dissipation − d(½ρ∫u²)/dt| over the sum of their sizes
slip             max|u(R) − V| / max|u| of the whole run
residual         of the last Stokes solve, where there is no inertia; then momentum is its balance
overlap          max(a₁ + a₂ − |R₁ − R₂|) / a        of spheres
a/ξ, ξ/Δx, √(νΔt)/ξ beside its best                  from the checks before the run

Both budgets are those of the last step (`budget.py` has them in full). After a blow-up and a retry
the step that was taken is told. Each is green, amber or red, with its reason; limits are per cent
of an answer, not of round-off.
"""

from typing import Any

import numpy as np

from smoothprofile.budget import Budget
from smoothprofile.config import is_stokes
from smoothprofile.structure import beads_of

Line = dict[str, Any]
GREEN, AMBER, RED = "green", "amber", "red"
SHARES = (0.01, 0.05)
OVERLAPS = (0.01, 0.1)
SLIPS = (0.1, 0.3)
"""Of a Stokes flow."""
STILL = 0.05
"""Of the speed announced, below which a run is taken to be at rest."""
ROUND_OFF = {"double": (1e-10, 1e-6), "single": (1e-4, 1e-2)}
RESOLUTION = ("a/ξ", "ξ/Δx", "√(νΔt)/ξ")


def error_card(run: Any) -> list[Line]:
    """Lines name, value, verdict, note."""
    lines = [_divergence(run)]
    if is_stokes(run.case):
        lines += _of_solve(run)
    elif run.budget is not None:
        lines += [_momentum(run.budget), _energy(run.budget)]
    if run.case.particles:
        lines += [_slip(run), *_overlap(run)]
    lines += [_retried(run)] if run.retries else []
    return lines + [_resolution(check) for check in run.preflight() if check["name"] in RESOLUTION]


def _line(name: str, value: float, limits: tuple[float, float], note: str) -> Line:
    """Green up to the first limit, amber up to the second; a NaN is red."""
    verdict = GREEN if value <= limits[0] else AMBER if value <= limits[1] else RED
    return {"name": name, "value": value, "verdict": verdict, "note": note}


def _divergence(run: Any) -> Line:
    speed, width = max(run.extremes.speed), min(run.grid.smallest_widths)
    if not is_stokes(run.case):
        # Of a fluid at rest there is round-off alone, of what drives it.
        driven = float(np.abs(run.driving_force).max()) * run.time_step
        speed = max(speed, driven / run.case.fluid.density)
    share = run.largest_divergence * width / speed if speed else 0.0
    limits = ROUND_OFF[run.case.domain.precision]
    return _line("divergence", share, limits, "largest, over the largest speed and a cell")


def _momentum(budget: Budget) -> Line:
    note = "drive less what walls, bodies and the gain take, over their sum; last step"
    return _line("momentum", budget.momentum, SHARES, note)


def _energy(budget: Budget) -> Line:
    """With how much of the dissipation is the slip of fluid through the layers of bodies."""
    note = "work less dissipation and gain, over their sum; last step"
    lost = budget.viscous + budget.layers
    if budget.layers and lost > 0.0:
        share = f"{100.0 * budget.layers / lost:.0f} %"
        note += f"; {share} is dissipated by slip through the layers of bodies"
    return _line("energy", budget.energy, SHARES, note)


def _of_solve(run: Any) -> list[Line]:
    """Of the last Stokes solve: its residual, and the balance of the forces on all fluid."""
    report, wanted = run.flow.report, run.flow.tolerance
    note = f"{report.status}, {report.iterations} iterations in the last step"
    forces = [*run.bodies.state.force, run.wall_force["total"]]
    body_force = np.array(run.case.fluid.body_force)
    driven = np.where(run.grid.periodic, run.driving_force, body_force) * run.grid.volume
    lack = np.abs(np.sum(forces, axis=0) - driven).sum()
    size = float(np.abs(forces).sum() + np.abs(driven).sum())
    # Once nothing moves, forces are what the tolerance leaves of those that there were.
    size += wanted * run.case.fluid.viscosity * _speed_seen(run) * min(run.case.domain.lengths)
    balance = "of what drives and holds the fluid, over the sum of it; the last step"
    return [
        _line("residual", report.residual, (wanted, 100.0 * wanted), note),
        _line("momentum", lack / size if size else 0.0, SHARES, balance),
    ]


def _retried(run: Any) -> Line:
    first, last = run.retries[0], run.retries[-1]
    note = (
        f"halved from {first['time_step_before']:.4g}, for the last time at t = "
        f"{last['time']:.4g}, for the run blew up"
    )
    return {"name": "Δt", "value": last["time_step"], "verdict": AMBER, "note": note}


def _speed_seen(run: Any) -> float:
    """max|u| of the history and the last step, at least a twentieth of what the case announces.

    A body that lies on a wall from the start never moves, but for the sub-steps of its contact.
    """
    seen = [*run.history.get("max_speed", ()), *run.extremes.speed]
    return max(float(np.max(seen)), STILL * max(run.pairing.speed))


def _slip(run: Any) -> Line:
    slip = [
        float(np.linalg.norm(body["interior_velocity"] - body["velocity"]))
        for body in run.particles
    ]
    speed, limits = _speed_seen(run), SHARES
    share = max(slip) / speed if speed else 0.0
    note = "at their centres, over the largest speed of the run"
    if is_stokes(run.case):
        limits, note = SLIPS, f"{note}: of the layer, which the painted surface makes up for"
    return _line("slip inside bodies", share, limits, note)


def _overlap(run: Any) -> list[Line]:
    """Of the bodies that are single spheres, if there are two."""
    beads = beads_of(run)
    radius = beads.radius
    if radius.size < 2:
        return []
    pairs, apart = beads.pairs(2.0 * radius.max())
    touching = radius[pairs].sum(axis=1) - np.linalg.norm(apart, axis=1)
    share = float(np.max(touching / radius[pairs].min(axis=1), initial=0.0))
    return [_line("overlap of spheres", share, OVERLAPS, "deepest, over the smaller radius")]


def _resolution(check: Line) -> Line:
    verdict = GREEN if check["verdict"] == "ok" else AMBER
    note = f"beside {check['limit']:.3g}: {check['note']}"
    return {"name": check["name"], "value": check["value"], "verdict": verdict, "note": note}
