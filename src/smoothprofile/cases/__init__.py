"""The built-in cases: TOML files that begin with a comment on what they are, and references.

`references/NAME.json` holds what a case should give: title, label and source; numbers such as
force; lines, {name: {coordinate, value}} for the lines of the case's output; wall_line likewise.
"""

import json
from typing import Any, NamedTuple

from smoothprofile.config import load_case
from smoothprofile.config.library import case_names, case_path, reference_path

__all__ = ["CaseEntry", "case_path", "list_cases", "reference"]


TAKES: dict[str, str] = {
    "channel": "about 10 s",
    "couette": "about 20 s",
    "cylinder-array": "about 10 s",
    "dielectric-lattice": "about 10 s",
    "dielectric-pair": "about 10 s",
    "dielectric-sphere": "about 10 s",
    "dielectric-suspension": "about 20 s",
    "drafting-pair": "about 1 min",
    "duct": "about 10 s",
    "duct-refined": "about 30 s",
    "duct-thesis-coarse": "about 20 s",
    "duct-thesis-fine": "about 5 min",
    "ellipsoid-in-shear": "about 3 min",
    "er-chains": "about 2 min",
    "er-shear": "about 20 s",
    "inertial-migration": "about 1 min",
    "lid-cavity": "about 30 s",
    "magnetic-chains": "about 1 min",
    "pair-attraction": "about 3 min",
    "rising-sphere": "about 20 s",
    "rotating-sphere": "about 10 s",
    "settling-sphere": "about 1 min",
    "settling-sphere-e2": "about 1 min",
    "settling-sphere-e3": "about 30 s",
    "settling-sphere-e4": "about 1 min",
    "sphere-array": "about 5 s",
    "sphere-in-shear": "about 30 s",
    "stokes-array": "about 10 s",
    "stokes-duct": "about 5 s",
    "stokes-layer": "about 20 s",
    "stokes-pair-attraction": "about 30 s",
    "stokes-sedimentation": "about 30 s",
    "suspension-1000": "about 2 min",
}
"""Name -> how long it takes on one core, once compiled; of a long run from some of its steps."""


class CaseEntry(NamedTuple):
    """A built-in case: its name, its title, the first line of its comment, how long it takes."""

    name: str
    title: str
    description: str
    takes: str


def list_cases() -> list[CaseEntry]:
    """All built-in cases, sorted by name."""
    return [_entry(name) for name in case_names()]


def reference(name: str) -> dict[str, Any]:
    """The reference of that name; CaseError with the nearest name if there is none."""
    return json.loads(reference_path(name).read_text(encoding="utf-8"))


def _entry(name: str) -> CaseEntry:
    first = case_path(name).read_text(encoding="utf-8").split("\n", 1)[0]
    return CaseEntry(name, load_case(name).title, first.lstrip("# "), TAKES[name])
