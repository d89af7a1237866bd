"""The built-in cases: TOML files that begin with a comment on what they are, and references.

`references/NAME.json` holds what a case should give: title, label and source; numbers such as
force; lines, {name: {coordinate, value}} for the lines of the case's output; wall_line likewise.
"""

import json
from typing import Any, NamedTuple

from smoothprofile.config import load_case
from smoothprofile.config.library import case_names, case_path, reference_path

__all__ = ["CaseEntry", "case_path", "list_cases", "reference"]


class CaseEntry(NamedTuple):
    """A built-in case: its name, its title, and the first line of its comment."""

    name: str
    title: str
    description: str


def list_cases() -> list[CaseEntry]:
    """All built-in cases, sorted by name."""
    return [_entry(name) for name in case_names()]


def reference(name: str) -> dict[str, Any]:
    """The reference of that name; CaseError with the nearest name if there is none."""
    return json.loads(reference_path(name).read_text(encoding="utf-8"))


def _entry(name: str) -> CaseEntry:
    first = case_path(name).read_text(encoding="utf-8").split("\n", 1)[0]
    return CaseEntry(name, load_case(name).title, first.lstrip("# "))
