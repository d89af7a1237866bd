"""The words in figures: symbols, units, and names as users wrote them.

Units are the case's own: whatever length, time and mass its numbers were given in.
"""

from collections.abc import Mapping
from typing import Any

SYMBOLS = {"x": "x₁", "y": "x₂", "z": "x₃"}
NUMBERS = {"x": "₁", "y": "₂", "z": "₃"}
LOADS = {
    "force": ("F", "force (mass·length/time²)"),
    "torque": ("T", "torque (mass·length²/time²)"),
}


def load_label(owner: str, load: str, component: str) -> str:
    """F₁, sphere."""
    return f"{LOADS[load][0]}{NUMBERS[component]}, {literal(owner)}"


def line_label(line: Mapping[str, Any]) -> str:
    """The name of a line, and where it lies: wake (x₁ = 2, x₃ = 0)."""
    others = [axis for axis in SYMBOLS if axis != line["axis"]]
    where = ", ".join(map(position, others, line["through"]))
    return f"{literal(line['name'])} ({where})"


def position(axis: str, value: float) -> str:
    """x₁ = −2, with a real minus sign."""
    return f"{SYMBOLS[axis]} = {value:g}".replace("-", "−")


def reference_label(reference: Mapping[str, Any]) -> str:
    """What a reference calls itself."""
    return literal(reference.get("label", "reference"))


def literal(name: str) -> str:
    """A user's name as it stands: matplotlib would read what is between dollar signs as maths."""
    return name.replace("$", r"\$")
