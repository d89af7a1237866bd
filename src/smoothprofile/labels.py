"""The words in figures: symbols, units, and names as users wrote them.

Units are the case's own, whatever length, time and mass its numbers were given in; where [units]
says what 1 means, axes of lengths, times and speeds carry that.
"""

import re
from collections.abc import Mapping
from typing import Any

from smoothprofile.grid import AXIS_NAMES

LOADS = {
    "force": ("F", "force (mass·length/time²)"),
    "torque": ("T", "torque (mass·length²/time²)"),
}


LENGTHS_AND_TIMES = re.compile(r"\((length|time|length/time|1/time)\)")


def in_units(label: str, units: Mapping[str, str]) -> str:
    """z (20 um) for z (length), Ω (1/(10 ms)) for Ω (1/time); words of other units stay."""

    def named(found: re.Match) -> str:
        above, _, below = found[1].partition("/")
        top = _plain(units.get(above, above))
        if not below:
            return f"({top})"
        bottom = _plain(units.get(below, below))
        return f"({top}/({bottom}))" if above == "1" and " " in bottom else f"({top}/{bottom})"

    return LENGTHS_AND_TIMES.sub(named, label)


def _plain(unit: str) -> str:
    """um for 1 um, and 20 um as it stands."""
    return unit.removeprefix("1 ").strip()


def load_label(owner: str, load: str, component: str) -> str:
    """Fx, sphere."""
    return f"{LOADS[load][0]}{component}, {literal(owner)}"


def line_label(line: Mapping[str, Any]) -> str:
    """The name of a line, and where it lies: wake (x = 2, z = 0)."""
    others = [axis for axis in AXIS_NAMES if axis != line["axis"]]
    where = ", ".join(map(position, others, line["through"]))
    return f"{literal(line['name'])} ({where})"


def position(axis: str, value: float) -> str:
    """x = −2, with a real minus sign."""
    return f"{axis} = {value:g}".replace("-", "−")


def reference_label(reference: Mapping[str, Any]) -> str:
    """What a reference calls itself."""
    return literal(reference.get("label", "reference"))


def literal(name: str) -> str:
    """A user's name as it stands: matplotlib would read what is between dollar signs as maths."""
    return name.replace("$", r"\$")
