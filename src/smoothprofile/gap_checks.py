"""What can be said of the room between bodies before a case runs: narrow gaps, broken lattices."""

from collections.abc import Iterable
from typing import Any

from smoothprofile.config import AXES, Case, smallest_gap, unfilled_lattices
from smoothprofile.preflight import ROUND_OFF, Check, check_row

LAYERS_APART = 5.0
"""ξ of tanh between two surfaces from which on their layers do not meet."""


def gap_rows(case: Case) -> list[Check]:
    """A warning if two bodies begin nearer than their layers resolve, and nothing stands in.

    Of tanh alone: the compact profiles end at their ξ.
    """
    if case.profile is None or case.profile.kind != "tanh" or case.contact.lubrication:
        return []
    least = LAYERS_APART * case.profile.thickness
    found = smallest_gap(case.particles, case.domain, least * (1.0 - ROUND_OFF))
    if found is None:
        return []
    gap, first, second = found
    pair = f"{first} and its periodic image" if first == second else f"{first} and {second}"
    note = (
        f"between {pair}; below 5ξ the layers of tanh meet and forces are too low: take a thinner "
        'layer, kind = "quartic-centred" or, for spheres that move, contact.lubrication'
    )
    return [check_row("smallest gap", gap, least, "warn", note)]


def lattice_rows(source: Any, overrides: Iterable[str] = ()) -> list[Check]:
    """A warning for each lattice that leaves room in a periodic box, or has too little.

    source and overrides as for `load_case`.
    """
    rows = []
    for key, axis, block, length in unfilled_lattices(source, overrides):
        note = (
            f"the unit cells of {key} take up {block:.6g} of the period {length:.6g} along "
            f"{AXES[axis]}, so that they are no lattice across it: leave out spacing or counts, "
            "or change domain.lengths"
        )
        rows.append(check_row(f"lattice along {AXES[axis]}", block, length, "warn", note))
    return rows
