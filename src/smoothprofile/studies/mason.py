"""Beads between sliding electrodes: the apparent viscosity against the Mason number."""

import math
from concurrent.futures import ProcessPoolExecutor
from itertools import starmap
from multiprocessing import get_context

import numpy as np

from smoothprofile.simulation import Simulation
from smoothprofile.studies.mason_figures import pictures
from smoothprofile.studies.study import Row, Study
from smoothprofile.threads import set_thread_count, thread_count

CASE = "er-shear"
RATE, HEIGHT, FACTOR = 0.04, 9.0, 2.0 * 0.75**2
"""Shear rate and gap of the case, and 2β² of its beads, β = (R − 1)/(R + 2), R = 10."""
FIELDS = (1.9, 1.3, 0.9, 0.6, 0.3, 0.06)
"""The strongest first, whose runs take longest; the last stands for none."""
STARTS = 3
"""Random starts of each field."""
STRONG, SHORT_STEP = 1.5, 0.125
"""Fields from which on beads are drawn too far in a step of the case, and the step there."""
LATE = 50.0
"""Means are taken from this time on: a strain of two, of four."""
PARTS = ("wall", "viscous", "contact", "electric")
COLUMNS = (*(f"{name}_stress" for name in PARTS), "longest_chain")
FITTED = 3
"""The smallest Mn, where the field rules, to which the slope is fitted."""
SLOPE_REACH = 0.25

INTRODUCTION = (
    "Eighteen beads of ten times the fluid's permittivity between electrodes that slide past each "
    "other, a tenth of the volume; the case er-shear with several fields and random starts. "
    "Mn = μγ̇/(2εβ²E²) is the viscous force over half that of two dipoles. The stress on the "
    "electrodes is averaged over strains from 2 to 4 and over the starts, and so are its parts: "
    "viscous, μγ̇ + ΣD/V; contact and electric, −Σz·F/V; inertia is the rest. Where the field "
    "rules, the stress above that of the same beads without a field does not depend on the rate of "
    "shear, so that μ_app − μ_free goes as 1/Mn."
)


def run() -> Study:
    """Not in the thesis: some minutes on four cores."""
    jobs = [(field, seed) for field in FIELDS for seed in range(1, STARTS + 1)]
    found = dict(zip(jobs, _side_by_side(jobs), strict=True))
    curve = averaged(found)
    curves = {"viscosity": curve}
    rate = fitted_slope(found)
    return Study(
        title="Apparent viscosity of an electrorheological fluid",
        source="Not in the thesis",
        introduction=INTRODUCTION,
        findings=_findings(curve, rate),
        rows=_rows(curve, rate),
        curves=curves,
        pictures=pictures(curves),
    )


def _side_by_side(jobs: list[tuple[float, int]]) -> list[dict[str, float]]:
    """The means of each run, a process of one thread to each: so small a box has no use for more.

    What comes out does not depend on how many run at once.
    """
    if thread_count() == 1:
        return list(starmap(means, jobs))
    # Numba's threads do not survive a fork.
    fresh = get_context("spawn")
    with ProcessPoolExecutor(thread_count(), fresh, set_thread_count, (1,)) as pool:
        return list(pool.map(means, *zip(*jobs, strict=True)))


def averaged(found: dict[tuple[float, int], dict[str, float]]) -> dict[str, np.ndarray]:
    """Means over the starts of each field, viscosities in μ.

    wall_error is the standard error of μ_app − μ_free, each start less its own without a field.
    """
    rows = []
    for field in FIELDS:
        starts = [found[field, seed] for seed in range(1, STARTS + 1)]
        row = {name: float(np.mean([one[f"{name}_stress"] for one in starts])) for name in PARTS}
        row = {name: value / RATE for name, value in row.items()}
        row["wall_error"] = _error(_walls(found, field) - _walls(found, FIELDS[-1]))
        row["longest_chain"] = float(np.mean([one["longest_chain"] for one in starts]))
        rows.append({"Mn": mason(field), **row})
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _walls(found: dict, field: float) -> np.ndarray:
    """μ_app/μ of each start."""
    stresses = [found[field, seed]["wall_stress"] for seed in range(1, STARTS + 1)]
    return np.array(stresses) / RATE


def fitted_slope(found: dict[tuple[float, int], dict[str, float]]) -> tuple[float, float]:
    """The mean of the starts' own slopes over the smallest Mn, and its standard error."""
    fields = (*FIELDS[:FITTED], FIELDS[-1])
    number = np.array([mason(field) for field in fields])
    walls = np.array([_walls(found, field) for field in fields])
    slopes = [slope({"Mn": number, "wall": column}, FITTED) for column in walls.T]
    return float(np.mean(slopes)), _error(np.array(slopes))


def _error(values: np.ndarray) -> float:
    """σ/√n of the mean of n values."""
    return float(np.std(values, ddof=1) / math.sqrt(values.size))


def mason(field: float) -> float:
    """Mn = μγ̇/(2εβ²E²), μ = ε = 1."""
    return RATE / (FACTOR * field**2)


def means(field: float, seed: int) -> dict[str, float]:
    """Mean over the late part of a run of each column of its history that is asked for here."""
    changes = {"electric.electrodes.high": field * HEIGHT, "particles.0.random.seed": seed}
    if field > STRONG:
        changes["time.step"] = SHORT_STEP
    simulation = Simulation.from_file(CASE, changes)
    simulation.run()
    late = np.array(simulation.history["time"]) >= LATE
    return {name: float(np.mean(np.array(simulation.history[name])[late])) for name in COLUMNS}


def slope(curve: dict[str, np.ndarray], points: int = 3) -> float:
    """d ln(μ_app − μ_free)/d ln Mn over the smallest Mn, μ_free that of the largest."""
    order = np.argsort(curve["Mn"])
    number, excess = curve["Mn"][order], curve["wall"][order] - curve["wall"][order[-1]]
    return float(np.polyfit(np.log(number[:points]), np.log(excess[:points]), 1)[0])


def _rows(curve: dict[str, np.ndarray], rate: tuple[float, float]) -> list[Row]:
    rows = []
    columns = (curve[name] for name in ("Mn", "wall", "wall_error", "longest_chain"))
    for number, value, error, chain in zip(*columns, strict=True):
        spread = f"± {error:.2f} above the weakest field's; " if error else ""
        remark = f"{spread}longest chain {chain:.1f} beads on average"
        rows.append(Row(f"μ_app/μ, Mn = {number:.3g}", None, None, float(value), 0.0, remark))
    remark = f"± {rate[1]:.2f} by {STARTS} starts; least squares over the {FITTED} smallest Mn"
    name = "slope of ln(μ_app − μ_free) against ln Mn"
    rows.append(Row(name, None, -1.0, rate[0], SLOPE_REACH, remark))
    return rows


def _findings(curve: dict[str, np.ndarray], rate: tuple[float, float]) -> tuple[str, ...]:
    low, high = int(np.argmin(curve["Mn"])), int(np.argmax(curve["Mn"]))
    order = np.argsort(curve["Mn"])
    excess = (curve["wall"] - curve["wall"][high]) * curve["Mn"]
    yields = ", ".join(f"{value:.3f}" for value in excess[order[:4]])
    numbers = ", ".join(f"{value:.2g}" for value in curve["Mn"][order[:4]])
    shares = [100.0 * curve[name][low] / curve["wall"][low] for name in PARTS[1:]]
    return (
        f"The apparent viscosity falls from {curve['wall'][low]:.2f}μ at Mn = "
        f"{curve['Mn'][low]:.2g} to {curve['wall'][high]:.2f}μ at Mn = {curve['Mn'][high]:.2g}, "
        f"where the field no longer matters; Einstein's 1 + 2.5c is "
        f"{1.0 + 2.5 * _fraction():.2f}μ.",
        f"At the smallest Mn the viscous part bears {shares[0]:.0f} % of the stress, contact "
        f"{shares[1]:.0f} % and the field {shares[2]:.0f} %.",
        f"Over the {FITTED} smallest Mn the slope is {rate[0]:.2f} ± {rate[1]:.2f}. The stress "
        f"that the field adds, over 2εβ²E², is {yields} at Mn = {numbers}: steady while chains "
        f"hold, and less from Mn = .1 on, where shear tears them.",
    )


def _fraction() -> float:
    return 18 * 4.0 / 3.0 * math.pi / (10.0 * 8.0 * HEIGHT)
