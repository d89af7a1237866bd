"""fields.h5 as its readers see it: VTK (and so ParaView), xarray, and h5py."""

import subprocess
import sys

import h5py
import numpy as np
import pytest
import vtk
import xarray
from vtk.util.numpy_support import vtk_to_numpy

from smoothprofile.errors import CaseError
from smoothprofile.fieldlayout import CHUNK_BYTES, _chunk
from smoothprofile.fields import FieldsFile
from smoothprofile.grid import Axis, Grid

TIMES = (0.0, 0.25, 1.5)


def make_grid(stretched: bool) -> Grid:
    """4×3×5 cells off the origin: no two axes alike, so that a swapped pair shows."""
    x = np.linspace(-1.0, 1.0, 5)
    y = np.linspace(0.5, 2.0, 4)
    z = np.array([0.0, 0.1, 0.3, 0.7, 1.5, 3.1]) if stretched else np.linspace(0.0, 3.0, 6)
    return Grid((Axis("x", x, True), Axis("y", y, False), Axis("z", z, False)))


def position(grid: Grid) -> np.ndarray:
    """The field x + 10y + 100z at the cell centres, (nx, ny, nz)."""
    x, y, z = np.meshgrid(*(axis.centres for axis in grid.axes), indexing="ij")
    return x + 10 * y + 100 * z


def snapshot(grid: Grid, time: float) -> dict[str, np.ndarray]:
    field = position(grid)
    return {
        "velocity": np.stack([field + time, 2 * field - time, 3 * field]),
        "pressure": field * (1 + time),
    }


def write(path, grid: Grid, **options) -> FieldsFile:
    file = FieldsFile(path, grid, **options)
    for time in TIMES:
        file.append(time, snapshot(grid, time))
    return file


@pytest.fixture(params=[False, True], ids=["uniform", "stretched"])
def written(request, tmp_path):
    grid = make_grid(request.param)
    write(tmp_path / "fields.h5", grid)
    return tmp_path / "fields.h5", grid


def read_with_vtk(path, time: float):
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    reader.UpdateTimeStep(time)
    return reader, reader.GetOutputDataObject(0)


def test_vtk_reads_times_and_the_right_kind_of_grid(written):
    path, grid = written
    reader, data = read_with_vtk(path, TIMES[0])
    pipeline = vtk.vtkStreamingDemandDrivenPipeline
    assert reader.GetOutputInformation(0).Get(pipeline.TIME_STEPS()) == TIMES
    uniform = all(axis.uniform for axis in grid.axes)
    assert data.GetClassName() == ("vtkImageData" if uniform else "vtkRectilinearGrid")
    low_high = [edge for axis in grid.axes for edge in (axis.low, axis.high)]
    # VTK adds spacings up in another order than numpy does: the last bits differ.
    assert data.GetBounds() == pytest.approx(low_high, rel=1e-14)


@pytest.mark.parametrize("time", TIMES)
def test_vtk_reads_each_value_at_its_place_and_time(written, time):
    path, _ = written
    _, data = read_with_vtk(path, time)
    centres = vtk.vtkCellCenters()
    centres.SetInputData(data)
    centres.Update()
    x, y, z = vtk_to_numpy(centres.GetOutput().GetPoints().GetData()).T
    field = x + 10 * y + 100 * z
    cells = data.GetCellData()
    velocity = vtk_to_numpy(cells.GetArray("velocity"))
    expected = np.stack([field + time, 2 * field - time, 3 * field], axis=1)
    # Both sides went through single precision: 2⁻²³ of the largest value, about 1e3.
    assert np.allclose(velocity, expected, rtol=0, atol=5e-4)
    assert np.allclose(
        vtk_to_numpy(cells.GetArray("pressure")), field * (1 + time), rtol=0, atol=5e-4
    )
    assert cells.GetVectors().GetName() == "velocity"


def test_xarray_reads_named_dimensions_and_coordinates(written):
    path, grid = written
    with xarray.open_dataset(path, engine="h5netcdf") as data:
        assert data["velocity"].dims == ("time", "z", "y", "x", "component")
        assert data["pressure"].dims == ("time", "z", "y", "x")
        assert set(data.data_vars) == {"velocity", "pressure"}
        assert list(data["component"].values) == ["x", "y", "z"]
        assert np.array_equal(data["time"], TIMES)
        for axis in grid.axes:
            assert np.array_equal(data[axis.name], axis.centres)
        field = data["x"] + 10 * data["y"] + 100 * data["z"]
        expected = field * (1 + data["time"])
        # Stored in single precision: 2⁻²⁴ relative.
        xarray.testing.assert_allclose(
            data["pressure"].astype(float), expected.transpose(*data["pressure"].dims), rtol=6e-8
        )
        second = data["velocity"].sel(component="y", time=1.5)
        assert np.allclose(second, (2 * field - 1.5).transpose("z", "y", "x"), rtol=6e-8)


def test_nothing_is_stored_twice(written):
    path, _ = written
    with h5py.File(path) as file:
        assert file["velocity"] == file["VTKHDF/CellData/velocity"]
        assert file["velocity"].dtype == np.float32


def test_double_precision_keeps_every_bit(tmp_path):
    grid = make_grid(stretched=True)
    write(tmp_path / "fields.h5", grid, precision="double")
    with h5py.File(tmp_path / "fields.h5") as file:
        assert np.array_equal(file["pressure"][2].T, snapshot(grid, TIMES[2])["pressure"])


@pytest.mark.parametrize("stretched", [False, True])
def test_file_is_complete_after_each_snapshot(tmp_path, stretched):
    grid, path = make_grid(stretched), tmp_path / "fields.h5"
    file = FieldsFile(path, grid)
    for number, time in enumerate(TIMES, start=1):
        file.append(time, snapshot(grid, time))
        reader, data = read_with_vtk(path, time)
        assert reader.GetNumberOfSteps() == number
        assert data.GetCellData().GetArray("velocity").GetNumberOfComponents() == 3
        read = vtk_to_numpy(data.GetCellData().GetArray("pressure"))
        expected = snapshot(grid, time)["pressure"].ravel(order="F")
        assert np.allclose(read, expected, rtol=6e-8)  # single precision
        with xarray.open_dataset(path, engine="h5netcdf") as opened:
            assert opened.sizes["time"] == number


def test_many_snapshots_are_put_together_and_cut_back(tmp_path, monkeypatch):
    """Files of three here; what is read is the same at any number, and after any cut."""
    monkeypatch.setattr("smoothprofile.fields.TOGETHER", 3)
    grid, path = make_grid(stretched=False), tmp_path / "fields.h5"
    file = FieldsFile(path, grid, precision="double")

    def assert_holds(count):
        with h5py.File(path) as opened:
            assert list(opened["time"]) == [float(n) for n in range(count)]
            for n in range(count):
                assert np.array_equal(opened["pressure"][n].T, snapshot(grid, n)["pressure"])
        assert not list(tmp_path.glob("**/*.new"))

    for number in range(8):
        file.append(float(number), snapshot(grid, number))
        assert_holds(number + 1)
    names = sorted(entry.name for entry in (tmp_path / "fields").iterdir())
    assert names[:2] == ["000000-000002.h5", "000003-000005.h5"] and len(names) == 4
    for count in (7, 5, 2, 1):
        again = FieldsFile(path, grid, precision="double")
        again.cut_back([float(n) for n in range(count)], ("velocity", "pressure"))
        assert_holds(count)
    for number in range(1, 5):
        again.append(float(number), snapshot(grid, number))
        assert_holds(number + 1)


def test_a_missing_part_reads_as_nothing_and_is_refused_to_go_on_with(tmp_path):
    grid, path = make_grid(stretched=False), tmp_path / "fields.h5"
    write(path, grid)
    (tmp_path / "fields" / "000001-000001.h5").unlink()
    with h5py.File(path) as opened:
        assert np.isnan(opened["pressure"][1]).all() and not np.isnan(opened["pressure"][2]).any()
    with pytest.raises(CaseError, match="holds fewer snapshots"):
        FieldsFile(path, grid).cut_back(TIMES, ("velocity", "pressure"))


def test_a_viewer_that_holds_the_file_does_not_stop_the_run(tmp_path):
    grid, path = make_grid(stretched=False), tmp_path / "fields.h5"
    file = FieldsFile(path, grid)
    file.append(0.0, snapshot(grid, 0.0))
    script = (
        "import h5py, sys; f = h5py.File(sys.argv[1]); print('open', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", script, str(path)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as viewer:
        assert viewer.stdout.readline() == "open\n"
        file.append(1.0, snapshot(grid, 1.0))
        viewer.stdin.close()
    with h5py.File(path) as opened:
        assert list(opened["time"]) == [0.0, 1.0]


def test_an_existing_file_is_not_overwritten(tmp_path):
    path = tmp_path / "fields.h5"
    path.write_text("mine")
    grid = make_grid(stretched=False)
    with pytest.raises(CaseError, match="exists already"):
        FieldsFile(path, grid).append(0.0, snapshot(grid, 0.0))
    assert path.read_text() == "mine"


def test_other_fields_or_shapes_are_refused(tmp_path):
    grid = make_grid(stretched=False)
    file = FieldsFile(tmp_path / "fields.h5", grid)
    with pytest.raises(ValueError, match="shape"):
        file.append(0.0, {"pressure": np.zeros(grid.padded_shape)})
    file.append(0.0, {"pressure": np.zeros(grid.shape)})
    with pytest.raises(ValueError, match="holds"):
        file.append(1.0, {"indicator": np.zeros(grid.shape)})
    assert file.times == [0.0]


@pytest.mark.parametrize("shape", [(90, 90, 256), (90, 90, 256, 3), (2, 3000, 3000), (1, 1, 1)])
def test_chunks_are_modest_and_rows_whole(shape):
    chunk = _chunk(shape, 4)
    assert np.prod(chunk) * 4 <= CHUNK_BYTES
    assert chunk[2:] == shape[2:]
    # Not split further than it must be: one more halving would have been one too many.
    assert chunk == shape or np.prod(chunk) * 4 > CHUNK_BYTES / 3
