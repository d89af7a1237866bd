"""A run made again from its directory, and compared with it: `spm rerun`."""

import hashlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.provenance import case_hash, versions
from smoothprofile.runrecord import read_json

TABLES = ("history.csv", "particles.csv", "lines.csv")
SAME, OTHER, NONE = "same bits", "differs", "none"


def check_repeatable(path: Path) -> list[str]:
    """What of the surroundings is not as it was, in words.

    CaseError if the directory holds no finished run, or another case than was run.
    """
    if not (path / "case.toml").is_file():
        raise CaseError(f"{path} is not a run directory: it holds no case.toml.")
    record = read_json(path / "run.json")
    if not (path / "summary.json").is_file():
        raise CaseError(f"the run in {path} has not ended: {record.get('status', 'unknown')}.")
    if record.get("case") != case_hash((path / "case.toml").read_text(encoding="utf-8")):
        raise CaseError(f"{path / 'case.toml'} is not the case that was run: its hash differs.")
    then = record.get("versions", {})
    return [
        f"{name} is {now}, and was {then.get(name)}"
        for name, now in versions().items()
        if then.get(name) != now
    ]


def compared(old: Path, new: Path) -> dict[str, str]:
    """File to "same bits", "differs" or "none": what both directories hold of the results."""
    found = {name: _verdict(_digest(old / name), _digest(new / name)) for name in TABLES}
    found["fields.h5"] = _verdict(_fields(old / "fields.h5"), _fields(new / "fields.h5"))
    return found


def _verdict(old: Any, new: Any) -> str:
    if old is None and new is None:
        return NONE
    return SAME if old == new else OTHER


def _digest(path: Path) -> str | None:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None


def _fields(path: Path) -> dict[str, str] | None:
    """SHA-256 of each dataset, a snapshot at a time; how it is stored does not count."""
    if not path.is_file():
        return None
    found = {}
    with h5py.File(path, "r", locking=False) as file:
        for name, data in file.items():
            if not isinstance(data, h5py.Dataset) or data.dtype.kind != "f":
                continue
            total = hashlib.sha256(f"{data.shape} {data.dtype}".encode())
            for part in data:
                total.update(np.ascontiguousarray(part).tobytes())
            found[name] = total.hexdigest()
    return found
