"""Checkpoints: a tree of numbers, texts and arrays in one file that is whole or not there.

    DIR/checkpoint.h5             the newest
    DIR/checkpoint-previous.h5    the one before it

A checkpoint is written beside, flushed to disk, read back and compared by its SHA-256, and only
then renamed; the directory is flushed too. Whatever happens in between, one whole file remains.
The tree is JSON, whose numbers are exact, with each array named by its number in the file.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from smoothprofile.errors import CaseError

FORMAT = 1
NEWEST, PREVIOUS = "checkpoint.h5", "checkpoint-previous.h5"
ARRAY = "array number"


def write_checkpoint(directory: Path, case_toml: str, tree: Mapping[str, Any]) -> None:
    """Make `tree` the newest checkpoint of a run directory; the newest becomes the previous one.

    OSError if it could not be written or was not read back as it was; the old ones then stand.
    """
    draft, newest = directory / (NEWEST + ".new"), directory / NEWEST
    _write(draft, case_toml, tree)
    _flush(draft)
    try:
        _read(draft, case_toml)
    except CaseError as error:
        raise OSError(f"the checkpoint was not written as it should be: {error}") from error
    if newest.exists():
        os.replace(newest, directory / PREVIOUS)
    os.replace(draft, newest)
    _flush(directory)


def read_checkpoint(directory: Path, case_toml: str) -> dict[str, Any]:
    """The newest whole checkpoint of that case, the previous one if the newest is damaged.

    CaseError if there is none, naming what is wrong with each that there is.
    """
    wrong = []
    for name in (NEWEST, PREVIOUS):
        path = directory / name
        if not path.exists():
            continue
        try:
            return _read(path, case_toml)
        except CaseError as error:
            wrong.append(str(error).rstrip("."))
    if not wrong:
        raise CaseError(f"{directory} holds no checkpoint to go on from.")
    raise CaseError(f"{'; '.join(wrong)}.")


def _write(path: Path, case_toml: str, tree: Mapping[str, Any]) -> None:
    arrays: list[np.ndarray] = []
    text = json.dumps(_packed(tree, arrays))
    with h5py.File(path, "w", locking=False) as file:
        file.attrs["format"] = FORMAT
        file.attrs["smoothprofile"] = version("smoothprofile")
        file.attrs["case"] = _digest_of_text(case_toml)
        file.create_dataset("tree", data=np.frombuffer(text.encode(), dtype=np.uint8))
        for number, values in enumerate(arrays):
            file.create_dataset(f"arrays/{number}", data=values)
        file.attrs["sha256"] = _digest(text, arrays)


def _read(path: Path, case_toml: str) -> dict[str, Any]:
    try:
        with h5py.File(path, "r", locking=False) as file:
            attributes = dict(file.attrs)
            text = bytes(file["tree"][()]).decode()
            group = file.get("arrays", {})
            arrays = [group[str(number)][()] for number in range(len(group))]
    except (OSError, KeyError, ValueError, RuntimeError, TypeError, MemoryError) as error:
        raise CaseError(f"{path} is no checkpoint, or is damaged.") from error
    if attributes.get("format") != FORMAT:
        raise CaseError(
            f"{path} is of format {attributes.get('format')}; this version reads format {FORMAT}."
        )
    if attributes.get("sha256") != _digest(text, arrays):
        raise CaseError(f"{path} is damaged: its content is not what was written.")
    if attributes.get("case") != _digest_of_text(case_toml):
        raise CaseError(f"{path} belongs to another case than case.toml beside it.")
    return _unpacked(json.loads(text), arrays)


def _packed(value: Any, arrays: list[np.ndarray]) -> Any:
    """The tree as JSON takes it; arrays are put aside. Tuples become lists."""
    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {ARRAY: len(arrays) - 1}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Mapping):
        return {name: _packed(inner, arrays) for name, inner in value.items()}
    if isinstance(value, list | tuple):
        return [_packed(inner, arrays) for inner in value]
    return value


def _unpacked(value: Any, arrays: list[np.ndarray]) -> Any:
    if isinstance(value, dict):
        if set(value) == {ARRAY}:
            return arrays[value[ARRAY]]
        return {name: _unpacked(inner, arrays) for name, inner in value.items()}
    if isinstance(value, list):
        return [_unpacked(inner, arrays) for inner in value]
    return value


def _digest(text: str, arrays: list[np.ndarray]) -> str:
    total = hashlib.sha256(text.encode())
    for values in arrays:
        total.update(f"{values.dtype.str} {values.shape}".encode())
        total.update(np.ascontiguousarray(values).data)
    return total.hexdigest()


def _digest_of_text(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _flush(path: Path) -> None:
    """Have the system put a file, or a directory's names, on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
