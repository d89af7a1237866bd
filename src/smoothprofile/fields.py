"""Snapshots of fields for ParaView and xarray (see fieldlayout.py), readable at every instant.

    DIR/fields.h5                    all snapshots; while there is one only, the snapshot itself
    DIR/fields/000007-000007.h5      one snapshot, from the second on, which can be read alone too
    DIR/fields/000000-000063.h5      64 of them, put together

With several snapshots fields.h5 is a table of contents: virtual datasets that read from the files
in the folder, to be copied together with it. Each file is written beside its place, flushed and
renamed; none is touched again. What a virtual dataset finds missing reads as NaN.
"""

import os
import re
import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import h5py
import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.fieldlayout import create_field, describe, write_coordinates
from smoothprofile.grid import Grid
from smoothprofile.safefiles import flush_directory, replacing_hdf5, writing

PART = re.compile(r"(\d{6,})-(\d{6,})\.h5", re.ASCII)
TOGETHER = 64
"""Snapshots that one file takes in the end: readers may hold no more than some hundred open."""


class Part(NamedTuple):
    """A file with the snapshots first … last."""

    first: int
    last: int
    path: Path

    @property
    def count(self) -> int:
        return self.last - self.first + 1


class FieldsFile:
    """fields.h5 and its folder: whole after each snapshot and at every instant between."""

    def __init__(self, path: Path | str, grid: Grid, *, precision: str = "single"):
        self.path = Path(path)
        self.folder = self.path.with_suffix("")
        self.grid = grid
        self.dtype = np.dtype({"single": "<f4", "double": "<f8"}[precision])
        self.times: list[float] = []
        self.names: tuple[str, ...] = ()
        self._parts: list[Part] = []

    def cut_back(self, times: Sequence[float], names: Sequence[str]) -> None:
        """Take the files that are there for one's own, with the first snapshots alone.

        CaseError if they hold fewer, or cannot be read.
        """
        self.times, self.names = list(times), tuple(names)
        count = len(self.times)
        try:
            found = self._found_parts()
            self._parts = self._whole_parts(found, count)
            if count == 1 and not self._parts:
                with h5py.File(self.path, "r", locking=False) as file:
                    stored = file["time"][:].tolist()
                if stored != self.times:
                    raise CaseError(f"{self.path} holds other snapshots than the checkpoint says.")
                return
        except (OSError, KeyError) as error:
            raise CaseError(f"{self.path} cannot be gone on with: it is damaged.") from error
        if sum(part.count for part in self._parts) != count:
            raise CaseError(f"{self.folder} holds fewer snapshots than the checkpoint says.")
        if count == 1:
            _link(self._parts[0].path, self.path)
        elif count:
            self._write_contents()
        else:
            self.path.unlink(missing_ok=True)
        # Last, so that fields.h5 names no file that is not there.
        for part in set(found) - set(self._parts):
            part.path.unlink()

    def append(self, time: float, fields: Mapping[str, np.ndarray]) -> None:
        """Add one snapshot of every field: scalars (nx, ny, nz), vectors (3, nx, ny, nz).

        The first call fixes which fields there are. CaseError if the file was there before it;
        ValueError if a later call brings other fields or another shape; OutputError if it cannot
        be written.
        """
        arrays = {name: self._file_order(name, values) for name, values in fields.items()}
        if not self.names:
            if self.path.exists():
                raise CaseError(f"{self.path} exists already and is not overwritten.")
            self.names = tuple(arrays)
        if set(arrays) != set(self.names):
            raise ValueError(f"{self.path} holds {self.names}, not {tuple(arrays)}")
        number = len(self.times)
        if number == 0:
            self._write_snapshot(self.path, time, arrays)
            self.times.append(float(time))
            return
        if number == 1:
            self._keep_first()
        part = self._part(number, number)
        self._write_snapshot(part.path, time, arrays)
        self._parts.append(part)
        self.times.append(float(time))
        self._put_together()
        self._write_contents()

    def _file_order(self, name: str, values: np.ndarray) -> np.ndarray:
        """values[(c,) i, j, k] as array[k, j, i(, c)], the order of the file: x runs fastest."""
        values = np.asarray(values)
        if values.shape not in (self.grid.shape, (3, *self.grid.shape)):
            raise ValueError(f"{name} has shape {values.shape} on a grid of {self.grid.shape}")
        return np.ascontiguousarray(values.T, dtype=self.dtype)

    def _part(self, first: int, last: int) -> Part:
        return Part(first, last, self.folder / f"{first:06d}-{last:06d}.h5")

    def _write_snapshot(self, path: Path, time: float, arrays: Mapping[str, np.ndarray]) -> None:
        with replacing_hdf5(path) as file:
            write_coordinates(file, self.grid, [time])
            for name, values in arrays.items():
                create_field(file, name, (1, *values.shape), values.dtype)[0] = values
            describe(file, self.grid, self.names)

    def _keep_first(self) -> None:
        """Give the first snapshot its place in the folder; fields.h5 is it too, until replaced."""
        part = self._part(0, 0)
        if self._parts == [part]:
            return
        with writing(self.folder):
            self.folder.mkdir(exist_ok=True)
        _link(self.path, part.path)
        self._parts = [part]

    def _put_together(self) -> None:
        """One file of every 64 single ones. The single ones go once nothing reads from them."""
        alone = [part for part in self._parts if part.count == 1]
        if len(alone) < TOGETHER:
            return
        merged = self._joined(alone, self._part(alone[0].first, alone[-1].last))
        self._parts = [part for part in self._parts if part.count > 1] + [merged]
        self._write_contents()
        for part in alone:
            part.path.unlink(missing_ok=True)

    def _joined(self, parts: Sequence[Part], whole: Part) -> Part:
        """Write the first snapshots of `parts`, as many as `whole` takes, to its file."""
        with replacing_hdf5(whole.path) as target:
            write_coordinates(target, self.grid, self.times[whole.first : whole.last + 1])
            row = 0
            for part in parts:
                with h5py.File(part.path, "r", locking=False) as source:
                    count = min(part.count, whole.count - row)
                    for name in self.names:
                        _copy_rows(source[name], target, name, whole.count, row, count)
                row += count
            describe(target, self.grid, self.names)
        return whole

    def _write_contents(self) -> None:
        """fields.h5 anew: virtual datasets over all parts."""
        with h5py.File(self._parts[0].path, "r", locking=False) as file:
            shapes = {name: file[name].shape[1:] for name in self.names}
        with replacing_hdf5(self.path) as file:
            write_coordinates(file, self.grid, self.times)
            for name, shape in shapes.items():
                layout = h5py.VirtualLayout((len(self.times), *shape), self.dtype)
                for part in self._parts:
                    place = f"{self.folder.name}/{part.path.name}"
                    source = h5py.VirtualSource(place, name, (part.count, *shape), self.dtype)
                    layout[part.first : part.last + 1] = source
                file.create_virtual_dataset(name, layout, fillvalue=np.nan)
            describe(file, self.grid, self.names)

    def _found_parts(self) -> list[Part]:
        names = (PART.fullmatch(path.name) for path in self.folder.glob("*.h5"))
        return [self._part(*map(int, name.groups())) for name in names if name]

    def _whole_parts(self, found: Sequence[Part], count: int) -> list[Part]:
        """The files of the first `count` snapshots; one that holds more is written anew."""
        kept: list[Part] = []
        # Where a file of many and those it was made of are both there, the many come first.
        for part in sorted(found, key=lambda part: (part.first, -part.last)):
            following = kept[-1].last + 1 if kept else 0
            if part.first == following and part.first < count:
                cut = self._part(part.first, min(part.last, count - 1))
                kept.append(part if part == cut else self._joined([part], cut))
        return kept


def _link(old: Path, new: Path) -> None:
    """Have `new` be the file `old`, in one go."""
    draft = new.with_name(new.name + ".new")
    with writing(new):
        draft.unlink(missing_ok=True)
        try:
            os.link(old, draft)
        except OSError:
            # Not every file system has hard links.
            shutil.copyfile(old, draft)
        os.replace(draft, new)
        # Renaming does nothing where both are one file already.
        draft.unlink(missing_ok=True)
        flush_directory(new.parent)


def _copy_rows(source: h5py.Dataset, file: h5py.File, name: str, total: int, row: int, count: int):
    """source[:count] to file[name][row : row + count], its chunks as they are, compressed."""
    if name not in file:
        create_field(file, name, (total, *source.shape[1:]), source.dtype)
    target = file[name]
    for number in range(source.id.get_num_chunks()):
        at = source.id.get_chunk_info(number).chunk_offset
        if at[0] < count:
            mask, chunk = source.id.read_direct_chunk(at)
            target.id.write_direct_chunk((at[0] + row, *at[1:]), chunk, mask)
