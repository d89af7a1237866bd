"""Checkpoints: a tree of numbers, texts and arrays in one file that is whole or not there.

    DIR/checkpoint.h5             the newest
    DIR/checkpoint-previous.h5    the one before it

The file is HDF5, and after its end stands the SHA-256 of all bytes before, which is compared before
anything else is read. A checkpoint is written beside, flushed to disk, read back and compared, and
only then renamed; whatever happens in between, one whole file remains. The tree is JSON, whose
numbers are exact, with each array named by its number in the file.
"""

import hashlib
import json
from collections.abc import Callable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from smoothprofile.errors import CaseError, OutputError
from smoothprofile.heap import keep_large_blocks_apart
from smoothprofile.provenance import case_hash
from smoothprofile.safefiles import DiskFile, hdf5_on, reason, replacing

FORMAT = 4
NEWEST, PREVIOUS = "checkpoint.h5", "checkpoint-previous.h5"
ARRAY = "array number"
SEAL = b"SHA-256 of all before: "
SEAL_BYTES = len(SEAL) + hashlib.sha256().digest_size
BLOCK = 1 << 22


def write_checkpoint(
    directory: Path, case_toml: str, tree: Mapping[str, Any], keep: bool = True
) -> None:
    """Make `tree` the newest checkpoint of a run directory; the newest becomes the previous one.

    keep = False: the newest is replaced, and the previous one stays.
    OutputError if it could not be written or was not read back as it was; the old ones then stand.
    """
    keep_large_blocks_apart()
    arrays: list[np.ndarray] = []
    text = json.dumps(_packed(tree, arrays))
    newest = directory / NEWEST
    with replacing(newest, keep=directory / PREVIOUS if keep else None) as disk:
        with hdf5_on(disk) as file:
            file.attrs["format"] = FORMAT
            file.attrs["smoothprofile"] = version("smoothprofile")
            file.attrs["case"] = case_hash(case_toml)
            file.create_dataset("tree", data=np.frombuffer(text.encode(), dtype=np.uint8))
            for number, values in enumerate(arrays):
                file.create_dataset(f"arrays/{number}", data=values)
        disk.flush_to_disk()
        if not _same(disk, text, arrays):
            raise OutputError(f"{newest} cannot be written: it is not read back as it was.")
        size = disk.seek(0, 2)
        disk.write(SEAL + _digest(disk, size))


def has_checkpoint(directory: Path) -> bool:
    """Whether there is one, whole or not."""
    return any((directory / name).exists() for name in (NEWEST, PREVIOUS))


def read_checkpoint(
    directory: Path,
    case_toml: str,
    tell: Callable[[str], None] = lambda sentence: None,
    newest_first: bool = True,
) -> dict[str, Any]:
    """The newest whole checkpoint of that case, the previous one if the newest is damaged.

    newest_first = False: the other way round. tell: takes a sentence if the first is damaged, or
    of another version of the program.
    CaseError if there is none, naming what is wrong with each that there is.
    """
    wrong: list[str] = []
    names = (NEWEST, PREVIOUS) if newest_first else (PREVIOUS, NEWEST)
    for name in names:
        if not (directory / name).exists():
            continue
        try:
            tree, written_by = _read(directory / name, case_toml)
        except CaseError as error:
            wrong.append(str(error).rstrip("."))
            continue
        if wrong:
            tell(f"{'; '.join(wrong)}. The other, {directory / name}, is whole, and is used.")
        if written_by != version("smoothprofile"):
            tell(f"{directory / name} was written by version {written_by}: bits may differ.")
        return tree
    if not wrong:
        raise CaseError(f"{directory} holds no checkpoint to go on from.")
    raise CaseError(f"{'; '.join(wrong)}.")


def _same(disk: DiskFile, text: str, arrays: list[np.ndarray]) -> bool:
    """Whether the file holds just that."""
    with h5py.File(disk, "r") as file:
        if bytes(file["tree"][()]).decode() != text:
            return False
        return all(
            file[f"arrays/{number}"][()].tobytes() == values.tobytes()
            for number, values in enumerate(arrays)
        )


def _read(path: Path, case_toml: str) -> tuple[dict[str, Any], str]:
    """The tree, and the version of the program that wrote it. CaseError if it is not whole."""
    try:
        _check_seal(path)
        with h5py.File(path, "r", locking=False) as file:
            attributes = dict(file.attrs)
            if attributes.get("format") != FORMAT:
                raise CaseError(
                    f"{path} is of format {attributes.get('format')}; this version reads format "
                    f"{FORMAT}."
                )
            text = bytes(file["tree"][()]).decode()
            group = file.get("arrays", {})
            arrays = [group[str(number)][()] for number in range(len(group))]
            tree = _unpacked(json.loads(text), arrays)
    except OSError as error:
        raise CaseError(f"{path} cannot be read: {reason(error)}.") from error
    except (LookupError, RuntimeError, TypeError, UnicodeError, json.JSONDecodeError) as error:
        raise CaseError(f"{path} is no checkpoint.") from error
    if attributes.get("case") != case_hash(case_toml):
        raise CaseError(f"{path} belongs to another case than case.toml beside it.")
    return tree, str(attributes.get("smoothprofile"))


def _check_seal(path: Path) -> None:
    with path.open("rb", buffering=0) as file:
        size = file.seek(0, 2) - SEAL_BYTES
        if size <= 0:
            raise CaseError(f"{path} is no checkpoint, or is damaged: it is too short.")
        file.seek(size)
        seal = file.read(SEAL_BYTES)
        if not seal.startswith(SEAL):
            raise CaseError(f"{path} is no checkpoint, or is damaged: its end is missing.")
        if seal != SEAL + _digest(file, size):
            raise CaseError(f"{path} is damaged: its content is not what was written.")


def _digest(file: Any, size: int) -> bytes:
    """SHA-256 of the first bytes; leaves the file after them."""
    total, left = hashlib.sha256(), size
    file.seek(0)
    while left:
        block = file.read(min(left, BLOCK))
        if not block:
            raise OSError("the file ends too early")
        total.update(block)
        left -= len(block)
    return total.digest()


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
