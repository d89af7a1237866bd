"""Snapshots of fields in one HDF5 file that both ParaView (VTKHDF) and xarray read.

The group `VTKHDF` is what VTK reads: cell data of an ImageData where all axes are uniform
(VTK 9.3, ParaView 5.12 or later), of a RectilinearGrid where one is stretched (VTK 9.7,
ParaView 6.2 or later). The root of the file is what xarray, netCDF4 or h5py read: the same
arrays under a second name, with the dimensions time, z, y, x and their coordinates (cell
centres). Nothing is stored twice: a hard link gives an HDF5 dataset a second name.

Format: VTKHDF specification, https://docs.vtk.org/en/latest/vtk_file_formats.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np

from smoothprofile.errors import CaseError
from smoothprofile.grid import AXIS_NAMES, Grid

COMPRESSION = {"compression": "gzip", "compression_opts": 1, "shuffle": True}
CHUNK_BYTES = 1 << 20

DESCRIPTIONS = {
    "velocity": "fluid velocity at cell centres",
    "pressure": "pressure",
    "indicator": "share of the cell that is particle, 0 to 1",
    "potential": "electric potential",
    "electric_field": "electric field at cell centres",
}


class FieldsFile:
    """fields.h5: made at the first snapshot, complete and closed after each one.

    Between snapshots no process holds the file, so it can be opened, copied or plotted while
    the run goes on. A run that is killed while it writes one may leave the file unreadable.
    """

    def __init__(self, path: Path | str, grid: Grid, *, precision: str = "single"):
        self.path = Path(path)
        self.grid = grid
        self.dtype = np.dtype({"single": "<f4", "double": "<f8"}[precision])
        self.times: list[float] = []
        self.names: tuple[str, ...] = ()

    def cut_back(self, times: Sequence[float], names: Sequence[str]) -> None:
        """Take the file that is there for one's own, with the first snapshots alone.

        CaseError if it holds fewer, or cannot be read.
        """
        try:
            with h5py.File(self.path, "r+", locking=False) as file:
                if file["time"].shape[0] < len(times):
                    raise CaseError(f"{self.path} holds fewer snapshots than the checkpoint says.")
                for name in ("time", *names):
                    file[name].resize(len(times), axis=0)
                self.names, self.times = tuple(names), list(times)
                if times:
                    _describe_for_vtk(file, self.grid, self.names)
        except (OSError, KeyError) as error:
            raise CaseError(f"{self.path} cannot be gone on with: it is damaged.") from error

    def append(self, time: float, fields: Mapping[str, np.ndarray]) -> None:
        """Add one snapshot of every field: scalars (nx, ny, nz), vectors (3, nx, ny, nz).

        The first call fixes which fields the file holds. CaseError if the file was there
        before it; ValueError if a later call brings other fields or another shape.
        """
        arrays = {name: self._file_order(name, values) for name, values in fields.items()}
        if not self.names:
            self._create(arrays)
        if set(arrays) != set(self.names):
            raise ValueError(f"{self.path} holds {self.names}, not {tuple(arrays)}")
        # A viewer that has the file open must not be able to stop the run: no lock is taken.
        with h5py.File(self.path, "r+", locking=False) as file:
            step = file["time"].shape[0]
            file["time"].resize(step + 1, axis=0)
            file["time"][step] = time
            for name, values in arrays.items():
                file[name].resize(step + 1, axis=0)
                file[name][step] = values
            _describe_for_vtk(file, self.grid, self.names)
        self.times.append(float(time))

    def _file_order(self, name: str, values: np.ndarray) -> np.ndarray:
        """values[(c,) i, j, k] as array[k, j, i(, c)], the order of the file: x runs fastest."""
        values = np.asarray(values)
        if values.shape not in (self.grid.shape, (3, *self.grid.shape)):
            raise ValueError(f"{name} has shape {values.shape} on a grid of {self.grid.shape}")
        return np.ascontiguousarray(values.T, dtype=self.dtype)

    def _create(self, arrays: Mapping[str, np.ndarray]) -> None:
        try:
            file = h5py.File(self.path, "x", locking=False)
        except FileExistsError as error:
            raise CaseError(f"{self.path} exists already and is not overwritten.") from error
        with file:
            _write_coordinates(file, self.grid)
            for name, values in arrays.items():
                _create_field(file, name, values)
        self.names = tuple(arrays)


def _write_coordinates(file: h5py.File, grid: Grid) -> None:
    """The coordinates of the dimensions: time, x, y, z of the cell centres, component names."""
    for axis in grid.axes:
        file[axis.name] = axis.centres
        file[axis.name].attrs["long_name"] = f"{axis.name} of the cell centres"
    file.create_dataset("time", shape=(0,), maxshape=(None,), chunks=(64,), dtype="f8")
    file.create_dataset("component", data=list(AXIS_NAMES), dtype=h5py.string_dtype())
    for name in (*AXIS_NAMES, "time", "component"):
        file[name].make_scale(name)


def _create_field(file: h5py.File, name: str, values: np.ndarray) -> h5py.Dataset:
    """An empty dataset (time, z, y, x[, component]) that grows in time."""
    data = file.create_dataset(
        name,
        shape=(0, *values.shape),
        maxshape=(None, *values.shape),
        chunks=(1, *_chunk(values.shape, values.itemsize)),
        dtype=values.dtype,
        **COMPRESSION,
    )
    for number, dimension in enumerate(("time", "z", "y", "x", "component")[: data.ndim]):
        data.dims[number].attach_scale(file[dimension])
    data.attrs["long_name"] = DESCRIPTIONS.get(name, name)
    return data


def _chunk(shape: tuple[int, ...], itemsize: int) -> tuple[int, ...]:
    """Halve z, then y, until a chunk is no larger than CHUNK_BYTES; rows stay whole."""
    chunk = list(shape)
    for number in (0, 1):
        while chunk[number] > 1 and np.prod(chunk) * itemsize > CHUNK_BYTES:
            chunk[number] = -(-chunk[number] // 2)
    return tuple(chunk)


def _describe_for_vtk(file: h5py.File, grid: Grid, names: tuple[str, ...]) -> None:
    """Write the group VTKHDF anew from the root of the file.

    VTK takes a file of one time step for one without time, whose arrays lack that dimension:
    it is given a virtual dataset, a view of the only step.
    """
    if "VTKHDF" in file:
        del file["VTKHDF"]
    group = file.create_group("VTKHDF")
    _write_geometry(group, grid)
    cells = group.create_group("CellData")
    count = file["time"].shape[0]
    for name in names:
        if count == 1:
            cells.create_virtual_dataset(name, _only_step(file[name]))
        else:
            cells[name] = file[name]
        if file[name].ndim == 5:
            cells[name].attrs["Attribute"] = np.bytes_("Vectors")
    if count == 1:
        group.create_group("FieldData")["TimeValue"] = file["time"][:]
        return
    steps = group.create_group("Steps")
    steps.attrs["NSteps"] = count
    steps["Values"] = file["time"][:]
    for name in names:
        steps[f"CellDataOffsets/{name}"] = np.arange(count)
    if group.attrs["Type"] == b"RectilinearGrid":
        for name in AXIS_NAMES:
            steps[f"{name.upper()}CoordinatesOffsets"] = np.zeros(count, dtype=np.int64)


def _only_step(data: h5py.Dataset) -> h5py.VirtualLayout:
    """data[0] of the same file, as a dataset of its own."""
    layout = h5py.VirtualLayout(shape=data.shape[1:], dtype=data.dtype)
    source = h5py.VirtualSource(".", data.name, data.shape, data.dtype, maxshape=data.maxshape)
    layout[...] = source[0]
    return layout


def _write_geometry(group: h5py.Group, grid: Grid) -> None:
    """What VTK needs to place the cells: origin and spacing, or the faces of each axis."""
    points = [axis.cells + 1 for axis in grid.axes]
    if all(axis.uniform for axis in grid.axes):
        group.attrs["Version"] = np.array([2, 0])
        group.attrs["Type"] = np.bytes_("ImageData")
        group.attrs["WholeExtent"] = np.array([n for p in points for n in (0, p - 1)], dtype="i4")
        group.attrs["Origin"] = np.array([axis.low for axis in grid.axes])
        group.attrs["Spacing"] = np.array([axis.length / axis.cells for axis in grid.axes])
        group.attrs["Direction"] = np.eye(3).ravel()
        return
    group.attrs["Version"] = np.array([2, 7])
    group.attrs["Type"] = np.bytes_("RectilinearGrid")
    group.attrs["Dimensions"] = np.array(points, dtype="i4")
    for axis in grid.axes:
        group[f"{axis.name.upper()}Coordinates"] = axis.faces
