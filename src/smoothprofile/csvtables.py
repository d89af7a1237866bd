"""CSV tables that grow row by row, and reading them back as columns."""

import csv
import io
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.jsontext import plain
from smoothprofile.safefiles import writing

SUFFIXES = {3: "xyz", 4: "wxyz", 6: ("xx", "yy", "zz", "yz", "xz", "xy")}


class GrowingTable:
    """A CSV file that grows: the first row names the columns, each row is written at once."""

    def __init__(self, path: Path, size: int | None = None):
        """A new file, or one to go on with, cut back to `size` bytes. OutputError if it fails.

        CaseError if there is less to go on with.
        """
        self._path, self._columns = path, ()
        new = os.O_EXCL if size is None else 0
        with writing(path):
            self._handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | new, 0o666)
            if os.fstat(self._handle).st_size < (size or 0):
                raise CaseError(f"{path} is shorter than the checkpoint says.")
            os.ftruncate(self._handle, size or 0)
        self._begun = bool(size)

    @property
    def size(self) -> int:
        """Bytes that are safely on the disk."""
        with writing(self._path):
            os.fsync(self._handle)
            return os.fstat(self._handle).st_size

    def append(self, row: Mapping[str, Any]) -> None:
        """One row more, or OutputError and none."""
        text = io.StringIO()
        writer = csv.DictWriter(text, self._columns or list(row), lineterminator="\n")
        if not self._columns and not self._begun:
            writer.writeheader()
        self._columns = writer.fieldnames
        writer.writerow(row)
        with writing(self._path):
            self._write(text.getvalue().encode("utf-8"))

    def close(self) -> None:
        os.close(self._handle)

    def _write(self, data: bytes) -> None:
        before, left = os.fstat(self._handle).st_size, memoryview(data)
        try:
            while left:
                left = left[os.write(self._handle, left) :]
        except OSError:
            # A row is there whole or not at all.
            os.ftruncate(self._handle, before)
            raise


def read_table(path: Path) -> list[dict[str, str]]:
    """The rows of a CSV file; a last line that was cut off in the writing is left out."""
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    return list(csv.DictReader(io.StringIO(text[: text.rfind("\n") + 1], newline="")))


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
