"""Option 2 of the thesis in three dimensions: bodies made stiff by a smoothed viscosity."""

import numpy as np

from smoothprofile.profiles import profile_named
from smoothprofile.studies.smoothed_viscosity_curves import (
    EXACT,
    LAYERS,
    RATIOS,
    SMOOTHINGS,
    STIFF,
    Solved,
    all_curves,
    dilute_exact,
)
from smoothprofile.studies.smoothed_viscosity_figures import pictures
from smoothprofile.studies.study import Row, Study
from smoothprofile.theory.dielectric import flat_offsets
from smoothprofile.theory.viscous_drop import mobility_slope, stresslet_slope
from smoothprofile.viscous.smoothed_viscosity_radius import error_of

REACH = 0.03
"""Of the drag at ξ = 0.1a and R = 1000."""
THINNEST = min(LAYERS)
SHORT = 2e-4
"""ξ/a at which a slope in ξ is taken."""

INTRODUCTION = (
    "∇·(2μe) − ∇p + f = 0, ∇·u = 0 in a periodic box, with the viscosity of the fluid outside of a "
    "sphere and R times it inside, smoothed as φ is: arithmetic (μ is interpolated), harmonic "
    "(1/μ is), or as a tensor, harmonic for the shear of neighbouring layers and arithmetic for "
    "all other strains. Across a layer tractions are continuous, along it gradients of velocity. "
    "Staggered grid, tanh, conjugate gradients. Retracted: painted with the radius at which a lone "
    "sphere has its exact drag, by the radial problem. Exact: a simple cubic lattice of rigid "
    "spheres, c = 0.064 (Zick and Homsy 1982; a drop of R = 1000 has 0.03 % less); for a lone drop "
    "Hadamard and Rybczynski's drag and Eshelby's stresslet, (40π/3)(R−1)/(2R+3) μa³E. Beside them "
    "the solver that holds a body to a rigid motion by a force. The thesis has option 2 for a flat "
    "wall alone (3.6–3.7, study couette)."
)


def run() -> Study:
    """Ten to thirty seconds on two cores."""
    curves, solved = all_curves()
    return Study(
        title="Smoothed viscosity: spheres that are stiff, not rigid",
        source="Option 2 of the thesis (3.6–3.7), in three dimensions",
        introduction=INTRODUCTION,
        findings=_findings(curves),
        rows=[*_drags(solved), *_viscosities(solved), *_slopes(), *_orders(curves)],
        curves=curves,
        pictures=pictures(curves),
    )


def _drags(solved: dict[tuple, Solved]) -> list[Row]:
    rows = []
    for smoothing in SMOOTHINGS:
        for kind in ("retracted", "painted"):
            one = solved[smoothing, kind, THINNEST]
            shown = "as painted" if kind == "painted" else kind
            name = f"F/(6πμaU), R = {STIFF:g}, ξ = {THINNEST}a, {smoothing}, {shown}"
            error = 100.0 * (one.value / EXACT - 1.0)
            remark = f"{error:+.2f} %, {one.iterations} iterations"
            # As painted there is nothing to agree with: the layer is part of the sphere.
            exact = EXACT if kind == "retracted" else None
            rows.append(Row(name, None, exact, one.value, REACH * EXACT, remark))
    rigid = solved["constrained", THINNEST]
    error = 100.0 * (rigid.value / EXACT - 1.0)
    cost = solved["harmonic", "retracted", THINNEST].seconds / rigid.seconds
    rows.append(
        Row(
            f"F/(6πμaU), rigid motion imposed, {LAYERS[THINNEST]}³ cells",
            *(None, EXACT, rigid.value, 0.01 * EXACT),
            f"{error:+.2f} %, {rigid.iterations} iterations; harmonic takes {cost:.1f} times as "
            "long on the same grid",
        )
    )
    return rows


def _viscosities(solved: dict[tuple, Solved]) -> list[Row]:
    rows = []
    for ratio in RATIOS:
        one = solved["dilute", "harmonic", "stresslet", ratio]
        exact = dilute_exact(ratio)
        share = 100.0 * ((one.value - 1.0) / (exact - 1.0) - 1.0)
        rows.append(
            Row(
                f"μ_eff/μ, c = 0.01, R = {ratio:g}, harmonic, painted for the stresslet",
                *(None, exact, one.value, 0.01 * (exact - 1.0)),
                f"series in c; {share:+.2f} % of the increment, {one.iterations} iterations",
            )
        )
    return rows


def _slopes() -> list[Row]:
    """The shift to first order in ξ, against its closed form."""
    rows, known, ratio = [], profile_named("tanh"), 10.0
    for smoothing in SMOOTHINGS:
        offsets = flat_offsets(known.value, ratio, smoothing, known.core, known.edge)
        # What should be zero is the round-off of integrals.
        normal, tangential = (round(offset, 12) for offset in offsets)
        load = tangential if smoothing == "harmonic" else 0.0
        exact = {
            "drag": -mobility_slope(ratio, normal, tangential, load),
            "stresslet": stresslet_slope(ratio, normal, tangential),
        }
        for motion, value in exact.items():
            pair = [
                error_of(motion, 1.0, xi, ratio, "tanh", smoothing) / xi
                for xi in (2.0 * SHORT, SHORT)
            ]
            rows.append(
                Row(
                    f"error of the {motion} over ξ/a as ξ → 0, R = {ratio:g}, {smoothing}",
                    *(None, value, 2.0 * pair[1] - pair[0], 1e-3),
                    "radial problem and closed form",
                )
            )
    return rows


def _orders(curves: dict) -> list[Row]:
    """Of the drag as painted, between the thinnest two layers."""
    columns, rows = curves["lattice"], []
    xi = columns["thickness"]
    for smoothing in SMOOTHINGS:
        error = np.abs(columns[f"{smoothing}_painted"])
        order = float(np.log(error[-2] / error[-1]) / np.log(xi[-2] / xi[-1]))
        name = f"order in ξ of the drag's error as painted, R = {STIFF:g}, {smoothing}"
        rows.append(Row(name, None, None, order, 0.0, f"from ξ = {xi[-2]:g} to {xi[-1]:g}a"))
    return rows


def _findings(curves: dict) -> tuple[str, ...]:
    lattice, dilute, contrast = curves["lattice"], curves["dilute"], curves["contrast"]
    errors = {s: 100.0 * lattice[f"{s}_retracted"][-1] for s in SMOOTHINGS}
    painted = {s: 100.0 * lattice[f"{s}_painted"][-1] for s in SMOOTHINGS}
    low, high = curves["lone_sphere_R10"], curves["lone_sphere_R1000"]
    at = int(np.argmin(np.abs(low["thickness"] - 0.1)))
    mild, stiff = (
        {s: 100.0 * c[f"{s}_stresslet_retracted"][at] for s in SMOOTHINGS} for c in (low, high)
    )
    turned = {s: 100.0 * high[f"{s}_torque_retracted"][at] for s in SMOOTHINGS}
    worst = 100.0 * np.nanmax(np.abs(dilute["harmonic_stresslet"]))
    counts = ", ".join(
        f"{s} {contrast[f'{s}_iterations'][0]:.0f} to {contrast[f'{s}_iterations'][-1]:.0f}"
        for s in SMOOTHINGS
    )
    rigid = 100.0 * lattice["constrained"][-1]
    return (
        f"R = {STIFF:g}, ξ = {THINNEST}a: as painted the drag is off by "
        f"{painted['arithmetic']:+.0f} % (arithmetic), {painted['harmonic']:+.1f} (harmonic) and "
        f"{painted['tensor']:+.0f} (tensor); retracted by {errors['arithmetic']:+.2f}, "
        f"{errors['harmonic']:+.2f} and {errors['tensor']:+.2f} %. Imposing rigid motion, on the "
        f"same cells: {rigid:+.2f} %.",
        "With tanh, arithmetic smoothing is harmonic smoothing moved out by ½ξ ln R: retracted, "
        "they are one.",
        f"At R = 10 the tensor is best: painted for its drag, a lone sphere with ξ = 0.1a has its "
        f"stresslet to {mild['tensor']:+.1f} %, harmonic {mild['harmonic']:+.1f}. At R = 1000 it "
        f"is {stiff['tensor']:+.0f} and {stiff['harmonic']:+.1f} %, the torque "
        f"{turned['tensor']:+.0f} and {turned['harmonic']:+.1f} %: the tensor's layer stiffens "
        "strains along itself from where Rφ ~ 1 on, and asks for R(ξ/a)³ ≪ 1.",
        "Painted for its stresslet, a harmonic sphere gives the increment of a dilute "
        f"suspension's viscosity within {worst:.1f} % at every R from {RATIOS[0]:g} to "
        f"{RATIOS[-1]:g}.",
        f"Iterations from R = {RATIOS[0]:g} to {RATIOS[-1]:g}, ξ = 0.14a: {counts}.",
    )
