"""Files that a case names: where they may lie, and tables of numbers in CSV."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from smoothprofile.config.refusals import Refusal, nearest
from smoothprofile.errors import CaseError

LARGEST_FILE = 64 * 2**20
COLUMNS = {
    "position": ("x", "y", "z"),
    "radius": ("radius",),
    "density": ("density",),
    "velocity": ("vx", "vy", "vz"),
    "angular_velocity": ("wx", "wy", "wz"),
    "orientation": ("qw", "qx", "qy", "qz"),
}
"""Columns of a CSV file by the key they give; those of one key come together."""


def located(name: Any, folder: Path, key: str) -> Path:
    """The whole path of a file that a case in `folder` names.

    Refusal if it leaves the folder by a relative path; whoever wants that gives the whole path.
    """
    if not isinstance(name, str) or not name or "\0" in name:
        raise Refusal(key, name, "it must be the path of a file in quotes")
    path = Path(name)
    if path.is_absolute():
        return path
    folder = folder.resolve()
    whole = (folder / path).resolve()
    if not whole.is_relative_to(folder):
        allowed = "it must lie in the folder of the case file or below, or be given by its whole"
        raise Refusal(key, name, f"{allowed} path")
    return whole


@dataclass(frozen=True)
class Row:
    """One body of a CSV file: its line there, and keys with a number or a tuple of numbers each."""

    line: int
    values: dict[str, Any]


def read_bodies(path: Path, name: str) -> list[Row]:
    """The bodies of a CSV file with a header; CaseError naming `name`, line and column."""
    lines = csv.reader(_text(path, name).splitlines(), skipinitialspace=True, strict=True)
    header, rows = None, []
    try:
        for fields in lines:
            if not fields or fields[0].startswith("#"):
                continue
            if header is None:
                header = _header(fields, name, lines.line_num)
                continue
            rows.append(_row(fields, header, name, lines.line_num))
    except csv.Error as error:
        raise CaseError(f"{name} is not CSV at line {lines.line_num}: {error}.") from None
    if not rows:
        what = "nothing" if header is None else "a header and no bodies"
        raise CaseError(f"{name} has {what} in it; it must have a header and a line for each body.")
    return rows


def _text(path: Path, name: str) -> str:
    try:
        with open(path, "rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise CaseError(f"{name} does not exist; looked for {path}.") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise CaseError(f"{name} cannot be read: {reason}.") from None
    if len(content) > LARGEST_FILE:
        raise CaseError(f"{name} is too large: more than {LARGEST_FILE // 2**20} MiB.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise CaseError(f"{name} is not UTF-8 text at line {line}, as CSV must be.") from None


def _header(fields: list[str], name: str, line: int) -> list[str]:
    header = [field.strip() for field in fields]
    known = [column for columns in COLUMNS.values() for column in columns]
    for number, column in enumerate(header, 1):
        where = f"{name} line {line}, column {number}, is {column!r}"
        if column not in known:
            like = nearest(column, known)
            offer = f"the nearest is {like}" if like else f"known are {', '.join(known)}"
            raise CaseError(f"{where}; {offer}.")
        if header.index(column) != number - 1:
            raise CaseError(f"{where}; another column has that name.")
    for key, columns in COLUMNS.items():
        given = [column for column in columns if column in header]
        lacking = [column for column in columns if column not in header]
        if lacking and (given or key == "position"):
            allowed = f"{', '.join(columns)} come together"
            raise CaseError(f"{name} line {line} has no column {lacking[0]}; {allowed}.")
    return header


def _row(fields: list[str], header: list[str], name: str, line: int) -> Row:
    if len(fields) != len(header):
        at = min(len(fields), len(header)) + 1
        raise CaseError(
            f"{name} line {line} has {len(fields)} fields and not {len(header)} as its header, "
            f"from column {at} on."
        )
    numbers = {}
    for column, field in zip(header, fields, strict=True):
        try:
            numbers[column] = float(field)
        except ValueError:
            numbers[column] = math.nan
        if not math.isfinite(numbers[column]) or "_" in field:
            shown = repr(field.strip()[:40])
            raise CaseError(
                f"{name} line {line}, column {column}, is {shown}; it must be a finite number."
            )
        if column in ("radius", "density") and numbers[column] <= 0.0:
            raise CaseError(
                f"{name} line {line}, column {column}, is {field.strip()}; it must be above 0."
            )
    values = {}
    for key, columns in COLUMNS.items():
        if columns[0] in numbers:
            found = [numbers[column] for column in columns]
            values[key] = found if len(found) > 1 else found[0]
    if not any(values.get("orientation", [1.0])):
        raise CaseError(f"{name} line {line}, columns qw to qz, are all 0; they must not be.")
    return Row(line, values)
