"""CSV tables that grow row by row, and reading them back as columns."""

import csv
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from smoothprofile.jsontext import plain

SUFFIXES = {3: "xyz", 4: "wxyz", 6: ("xx", "yy", "zz", "yz", "xz", "xy")}


class GrowingTable:
    """A CSV file that grows: the first row names the columns, each row is flushed."""

    def __init__(self, path: Path, size: int | None = None):
        """A new file, or one that is there, cut back to `size` bytes, to go on with."""
        self._file = path.open("x" if size is None else "r+", newline="", encoding="utf-8")
        self._writer: csv.DictWriter | None = None
        if size is not None:
            self._file.truncate(size)
            self._file.seek(size)
        self._begun = bool(size)

    @property
    def size(self) -> int:
        """Bytes that are safely on the disk."""
        self._file.flush()
        os.fsync(self._file.fileno())
        return os.fstat(self._file.fileno()).st_size

    def append(self, row: Mapping[str, Any]) -> None:
        if self._writer is None:
            self._writer = csv.DictWriter(self._file, list(row), lineterminator="\n")
            if not self._begun:
                self._writer.writeheader()
        self._writer.writerow(row)
        self._file.flush()

    def close(self) -> None:
        self._file.close()


def read_table(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file; a last line that was cut off in the writing is left out."""
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    return list(csv.DictReader(text[: text.rfind("\n") + 1].splitlines()))


def grouped_by(rows: list[dict[str, str]], column: str) -> dict[str, list[dict[str, str]]]:
    """Rows grouped by the value of one column, in the order of first appearance."""
    groups: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        groups.setdefault(row[column], []).append(row)
    return groups


def number_columns(rows: list[dict[str, str]]) -> dict[str, np.ndarray]:
    """The numeric columns of a table; an empty field is NaN, a column of words is left out."""
    columns = {}
    for name in rows[0] if rows else ():
        try:
            columns[name] = np.array([float(row[name] or "nan") for row in rows])
        except ValueError:
            continue
    return columns


def flat_row(values: Mapping[str, Any]) -> dict[str, Any]:
    """A vector as columns _x, _y, _z, a quaternion as four, _w first, a symmetric tensor as six."""
    flat = {}
    for name, value in values.items():
        parts = plain(value) if isinstance(value, list | tuple | np.ndarray) else None
        if parts is None:
            flat[name] = value
            continue
        suffixes = SUFFIXES.get(len(parts)) or range(len(parts))
        flat |= {f"{name}_{suffix}": part for suffix, part in zip(suffixes, parts, strict=True)}
    return flat
