"""Beads between sliding electrodes: the apparent viscosity against the Mason number."""

import math

import numpy as np

from smoothprofile.simulation import Simulation
from smoothprofile.studies.mason_figures import pictures
from smoothprofile.studies.study import Row, Study

CASE = "er-shear"
RATE, HEIGHT, FACTOR = 0.04, 9.0, 2.0 * 0.75**2
"""Shear rate and gap of the case, and 2β² of its beads, β = (R − 1)/(R + 2), R = 10."""
FIELDS = (1.9, 1.3, 0.9, 0.6, 0.3, 0.06)
LATE = 50.0
"""Means are taken from this time on: a strain of two, of four."""
PARTS = ("wall", "viscous", "contact", "electric")
SLOPE_REACH = 0.25

INTRODUCTION = (
    "Eighteen beads of ten times the fluid's permittivity between electrodes that slide past each "
    "other, a tenth of the volume; the case er-shear with several fields. "
    "Mn = μγ̇/(2εβ²E²) is the viscous force over half that of two dipoles. The stress on the "
    "electrodes is averaged over strains from 2 to 4, and so are its parts: viscous, "
    "μγ̇ + ΣD/V; contact and electric, −Σz·F/V; inertia is the rest. Where the field rules, "
    "the stress above that of the same beads without a field does not depend on the rate of shear, "
    "so that μ_app − μ_free goes as 1/Mn."
)


def run() -> Study:
    """Not in the thesis: some minutes on four cores."""
    found = {field: means(field) for field in FIELDS}
    curve = {
        "Mn": np.array([mason(field) for field in FIELDS]),
        **{
            name: np.array([one[f"{name}_stress"] / RATE for one in found.values()])
            for name in PARTS
        },
        "longest_chain": np.array([one["longest_chain"] for one in found.values()]),
    }
    curves = {"viscosity": curve}
    return Study(
        title="Apparent viscosity of an electrorheological fluid",
        source="Not in the thesis",
        introduction=INTRODUCTION,
        findings=_findings(curve),
        rows=_rows(curve),
        curves=curves,
        pictures=pictures(curves),
    )


def mason(field: float) -> float:
    """Mn = μγ̇/(2εβ²E²), μ = ε = 1."""
    return RATE / (FACTOR * field**2)


def means(field: float) -> dict[str, float]:
    """Mean over the late part of a run of each column of its history that is asked for here."""
    simulation = Simulation.from_file(CASE, {"electric.electrodes.high": field * HEIGHT})
    simulation.run()
    late = np.array(simulation.history["time"]) >= LATE
    names = [f"{name}_stress" for name in PARTS] + ["longest_chain"]
    return {name: float(np.mean(np.array(simulation.history[name])[late])) for name in names}


def slope(curve: dict[str, np.ndarray], points: int = 3) -> float:
    """d ln(μ_app − μ_free)/d ln Mn over the smallest Mn, μ_free that of the largest."""
    order = np.argsort(curve["Mn"])
    number, excess = curve["Mn"][order], curve["wall"][order] - curve["wall"][order[-1]]
    return float(np.polyfit(np.log(number[:points]), np.log(excess[:points]), 1)[0])


def _rows(curve: dict[str, np.ndarray]) -> list[Row]:
    rows = []
    for number, value, chain in zip(
        curve["Mn"], curve["wall"], curve["longest_chain"], strict=True
    ):
        remark = f"longest chain {chain:.1f} beads on average"
        rows.append(Row(f"μ_app/μ, Mn = {number:.3g}", None, None, float(value), 0.0, remark))
    remark = "least squares over the three smallest Mn; one small box, one start"
    name = "slope of ln(μ_app − μ_free) against ln Mn"
    rows.append(Row(name, None, -1.0, slope(curve), SLOPE_REACH, remark))
    return rows


def _findings(curve: dict[str, np.ndarray]) -> tuple[str, ...]:
    low, high = int(np.argmin(curve["Mn"])), int(np.argmax(curve["Mn"]))
    local = [slope({n: v[pair] for n, v in curve.items()}, 2) for pair in _pairs(curve)]
    shares = [100.0 * curve[name][low] / curve["wall"][low] for name in PARTS[1:]]
    return (
        f"The apparent viscosity falls from {curve['wall'][low]:.2f}μ at Mn = "
        f"{curve['Mn'][low]:.2g} to {curve['wall'][high]:.2f}μ at Mn = {curve['Mn'][high]:.2g}, "
        f"where the field no longer matters; Einstein's 1 + 2.5c is "
        f"{1.0 + 2.5 * _fraction():.2f}μ.",
        f"At the smallest Mn the viscous part bears {shares[0]:.0f} % of the stress, contact "
        f"{shares[1]:.0f} % and the field {shares[2]:.0f} %.",
        f"From one Mn to the next the slope goes from {local[0]:.2f} to {local[-1]:.2f}: eighteen "
        f"beads make three or four chains, and what holds at the small end tells of the box too.",
    )


def _pairs(curve: dict[str, np.ndarray]) -> list[np.ndarray]:
    """Rows of neighbouring Mn, of the four smallest, each with the largest, which has no field."""
    order = np.argsort(curve["Mn"])
    return [np.append(order[k : k + 2], order[-1]) for k in range(3)]


def _fraction() -> float:
    return 18 * 4.0 / 3.0 * math.pi / (10.0 * 8.0 * HEIGHT)
