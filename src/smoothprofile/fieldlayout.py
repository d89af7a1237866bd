"""How fields lie in an HDF5 file that both ParaView (VTKHDF) and xarray read.

The group `VTKHDF` is what VTK reads: cell data of an ImageData where all axes are uniform
(VTK 9.3, ParaView 5.12 or later), of a RectilinearGrid where one is stretched (VTK 9.7,
ParaView 6.2 or later). The root of the file is what xarray, netCDF4 or h5py read: the same
arrays under a second name, with the dimensions time, z, y, x and their coordinates (cell
centres). Nothing is stored twice: a hard link gives an HDF5 dataset a second name.

Format: VTKHDF specification, https://docs.vtk.org/en/latest/vtk_file_formats.
"""

from collections.abc import Sequence

import h5py
import numpy as np

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


def write_coordinates(file: h5py.File, grid: Grid, times: Sequence[float]) -> None:
    """The coordinates of the dimensions: time, x, y, z of the cell centres, component names."""
    for axis in grid.axes:
        file[axis.name] = axis.centres
        file[axis.name].attrs["long_name"] = f"{axis.name} of the cell centres"
    file["time"] = np.array(times, dtype=np.float64)
    file.create_dataset("component", data=list(AXIS_NAMES), dtype=h5py.string_dtype())
    for name in (*AXIS_NAMES, "time", "component"):
        file[name].make_scale(name)


def create_field(file: h5py.File, name: str, shape: tuple[int, ...], dtype) -> h5py.Dataset:
    """A compressed dataset (time, z, y, x[, component]) without values yet."""
    return file.create_dataset(
        name,
        shape=shape,
        chunks=(1, *_chunk(shape[1:], np.dtype(dtype).itemsize)),
        dtype=dtype,
        **COMPRESSION,
    )


def describe(file: h5py.File, grid: Grid, names: Sequence[str]) -> None:
    """Name the dimensions of the fields for xarray, and write the group VTKHDF."""
    for name in names:
        data = file[name]
        for number, dimension in enumerate(("time", "z", "y", "x", "component")[: data.ndim]):
            data.dims[number].attach_scale(file[dimension])
        data.attrs["long_name"] = DESCRIPTIONS.get(name, name)
    _describe_for_vtk(file, grid, names)


def _chunk(shape: tuple[int, ...], itemsize: int) -> tuple[int, ...]:
    """Halve z, then y, until a chunk is no larger than CHUNK_BYTES; rows stay whole."""
    chunk = list(shape)
    for number in (0, 1):
        while chunk[number] > 1 and np.prod(chunk) * itemsize > CHUNK_BYTES:
            chunk[number] = -(-chunk[number] // 2)
    return tuple(chunk)


def _describe_for_vtk(file: h5py.File, grid: Grid, names: Sequence[str]) -> None:
    """The group VTKHDF, from the root of the file.

    VTK takes a file of one time step for one without time, whose arrays lack that dimension:
    it is given a virtual dataset, a view of the only step.
    """
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
