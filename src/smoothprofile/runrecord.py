"""A run directory read back, for reports."""

import json
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from smoothprofile.csvtables import grouped_by, number_columns, read_table
from smoothprofile.errors import CaseError


@dataclass(frozen=True, eq=False)
class RunRecord:
    """A run directory read back; whatever a broken-off run did not write is empty."""

    path: Path
    case_toml: str
    case: dict[str, Any]
    run: dict[str, Any] = field(default_factory=dict)
    summary: dict[str, Any] = field(default_factory=dict)
    history: dict[str, np.ndarray] = field(default_factory=dict)
    """Column name to values."""
    particles: dict[str, dict[str, np.ndarray]] = field(default_factory=dict)
    """Particle name to columns."""
    lines: dict[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    """Line name to coordinates and velocity component."""
    wall_shear: tuple[np.ndarray, np.ndarray] | None = None
    plane: dict[str, np.ndarray] = field(default_factory=dict)


def read_run(path: Path | str) -> RunRecord:
    """Everything in a run directory. CaseError if the directory is not one, or is damaged."""
    path = Path(path)
    if not (path / "case.toml").is_file():
        raise CaseError(f"{path} is not a run directory: it holds no case.toml.")
    try:
        return _record(path)
    except CaseError:
        raise
    except (ValueError, BadZipFile) as error:
        raise CaseError(f"a file in {path} is damaged: {error}.") from error


def _record(path: Path) -> RunRecord:
    case_toml = (path / "case.toml").read_text(encoding="utf-8")
    sampled = grouped_by(read_table(path / "lines.csv"), "quantity")
    velocity = grouped_by(sampled.get("velocity", []), "name")
    shear = sampled.get("wall_shear", [])
    plane = {}
    if (path / "plane.npz").is_file():
        with np.load(path / "plane.npz") as data:
            plane = {name: data[name] for name in data.files}
    return RunRecord(
        path=path,
        case_toml=case_toml,
        case=tomllib.loads(case_toml),
        run=read_json(path / "run.json"),
        summary=read_json(path / "summary.json"),
        history=number_columns(read_table(path / "history.csv")),
        particles={
            name: number_columns(rows)
            for name, rows in grouped_by(read_table(path / "particles.csv"), "name").items()
        },
        lines={name: _curve(rows) for name, rows in velocity.items()},
        wall_shear=_curve(shear) if shear else None,
        plane=plane,
    )


def _curve(rows: list[dict[str, str]]) -> tuple[np.ndarray, np.ndarray]:
    columns = number_columns(rows)
    return columns["coordinate"], columns["value"]


def read_json(path: Path) -> dict[str, Any]:
    """The object in a JSON file; empty if there is none. CaseError if it is damaged."""
    try:
        return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    except ValueError as error:
        raise CaseError(f"{path} is damaged: {error}.") from error
