"""Closed triangulated surfaces: read and checked, measured, their distance sampled and painted."""

import numpy as np
import pytest
import trimesh
from numba import njit

from case_makers import refusal, small_case, sphere
from smoothprofile import rotations, shapes
from smoothprofile.assembly import build_flow, build_grid, build_particles
from smoothprofile.config import build_shape, load_case, start_position
from smoothprofile.simulation import Simulation
from smoothprofile.surfaces import joined, sampled_distance
from smoothprofile.triangles import SurfaceError, load_surface, surface_of

ROUND_OFF = 1e-13


def ball(subdivisions=3, radius=1.0):
    return trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)


def block(sides=(2.0, 2.0, 2.0)):
    return trimesh.creation.box(sides)


def surface(mesh):
    return surface_of(mesh.vertices, mesh.faces)


def soup(mesh, keep=slice(None)):
    """STL text of its triangles, those of `keep`, each with corners of its own."""
    lines = ["solid test"]
    for corners in mesh.vertices[mesh.faces[keep]]:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex " + " ".join(repr(float(c)) for c in corner) for corner in corners]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid test", ""])


@njit
def fill_sampled(samples, row, points, out):
    for n in range(out.size):
        out[n] = sampled_distance(samples, row, points[n, 0], points[n, 1], points[n, 2])


def sampled(samples, points, row=0):
    out = np.empty(len(points))
    fill_sampled(samples, row, points, out)
    return out


def scattered(extents, count=20_000, seed=1):
    return np.random.default_rng(seed).uniform(-1.6, 1.6, (count, 3)) * extents


def layer(d, thickness):
    return 0.5 * (1.0 - np.tanh(d / thickness))


def test_a_block_of_triangles_has_the_volume_and_inertia_of_a_box():
    mesh = block((1.0, 2.0, 3.0))
    turn = rotations.from_axis_angle((1, 2, 3), 0.7)
    mesh.vertices = rotations.rotate(turn, mesh.vertices) + np.array([5.0, -7.0, 11.0])
    body, box = shapes.mesh(surface(mesh)), shapes.box((1.0, 2.0, 3.0))
    matrix = rotations.matrix(turn)
    assert body.volume == pytest.approx(6.0, rel=ROUND_OFF)
    np.testing.assert_allclose(body.centroid, [5.0, -7.0, 11.0], rtol=ROUND_OFF)
    # Moving the origin to the centroid takes 195 V from numbers of that size.
    np.testing.assert_allclose(body.inertia, matrix @ box.inertia @ matrix.T, atol=195 * 6 * 1e-14)


def test_a_part_of_triangles_off_its_place_has_the_inertia_of_a_box():
    mesh = block((1.0, 2.0, 3.0))
    mesh.vertices += [0.3, -0.2, 0.5]
    q = rotations.from_axis_angle((1, -1, 2), 1.1)
    places = [([1.0, 2.0, 3.0], q)]
    one = shapes.union([(shapes.mesh(surface(mesh)), *place) for place in places])
    shift = rotations.rotate(q, [0.3, -0.2, 0.5])
    other = shapes.union([(shapes.box((1.0, 2.0, 3.0)), np.add(places[0][0], shift), q)])
    np.testing.assert_allclose(one.centroid, other.centroid, rtol=1e-13)
    np.testing.assert_allclose(one.inertia, other.inertia, atol=1e-11)
    np.testing.assert_allclose(one.extents, other.extents, rtol=1e-12)
    points = scattered(4.0, 500)
    np.testing.assert_allclose(one.distance(points), other.distance(points), atol=1e-12)


def test_spheres_of_triangles_converge_as_the_square_of_their_facets():
    exact = shapes.sphere(1.0)
    errors = []
    for subdivisions in (2, 3, 4):
        body = shapes.mesh(surface(ball(subdivisions)))
        inertia = np.abs(body.inertia - exact.inertia).max() / exact.inertia[0, 0]
        errors.append([1.0 - body.volume / exact.volume, inertia])
    slopes = np.log2(np.divide(errors[:-1], errors[1:]))
    # Sides halve; the next term is of fourth order, 3 % of the first at the coarsest.
    np.testing.assert_allclose(slopes, 2.0, atol=0.05)


@pytest.mark.parametrize("subdivide", [0, 2])
def test_the_distance_to_a_block_is_that_to_a_box(subdivide):
    mesh = block()
    for _ in range(subdivide):
        mesh = mesh.subdivide()
    found, box = surface(mesh), shapes.box((2.0, 2.0, 2.0))
    points = scattered(1.0)
    d = box.distance(points)
    np.testing.assert_allclose(shapes.mesh(found).distance(points), d, rtol=0, atol=1e-14)
    # What is asked of φ, also at edges and on the medial planes, is 1e-3.
    np.testing.assert_allclose(layer(sampled(found.samples, points), 0.1), layer(d, 0.1), atol=1e-3)


@pytest.mark.parametrize("subdivisions", [4, pytest.param(5, marks=pytest.mark.slow)])
def test_the_distance_to_a_fine_sphere_is_that_to_a_sphere(subdivisions):
    mesh = ball(subdivisions)
    found = surface(mesh)
    points = scattered(1.0)
    d = np.linalg.norm(points, axis=1) - 1.0
    # Facets lie inside the sphere by at most side²/6, the height of the middle of a triangle.
    inset = np.max(mesh.edges_unique_length) ** 2 / 6.0
    exact = shapes.mesh(found).distance(points)
    assert np.all(exact - d > -1e-14)
    assert np.max(exact - d) < inset
    # φ′ ≤ ½ at ξ = .2 leaves of the facets' own inset this, .07 % of φ for the finer one.
    error = np.abs(layer(sampled(found.samples, points), 0.2) - layer(d, 0.2))
    assert np.max(error) < 0.5 * inset / 0.2 + 2e-4
    assert found.depth == pytest.approx(1.0, abs=found.samples.frame[0, 3])


def test_several_surfaces_share_one_table():
    one, two = surface(ball(2)), surface(block((1.0, 0.5, 2.0)))
    points = scattered(1.0, 2000)
    table = joined([one, two, one])
    for row, alone in enumerate((one, two, one)):
        assert np.array_equal(sampled(table, points, row), sampled(alone.samples, points))
    far = np.array([[30.0, 1.0, 2.0], [0.0, 0.0, -4.0]])
    expected = shapes.box((1.0, 0.5, 2.0)).distance(far)
    # Beyond the samples: to the foot of the perpendicular from their end, which lies on the body.
    assert np.all(sampled(table, far, 1) >= expected - 1e-5)
    np.testing.assert_allclose(sampled(table, far, 1), expected, rtol=0.02)


def test_a_solid_with_a_hollow_is_hollow():
    inner = ball(2, 0.5)
    inner.invert()
    found = surface(trimesh.util.concatenate([block(), inner]))
    assert found.volume == pytest.approx(8.0 + inner.volume, rel=1e-12)
    signs = np.sign(shapes.mesh(found).distance(np.array([[0, 0, 0], [0.8, 0, 0], [1.2, 0, 0]])))
    assert signs.tolist() == [1.0, -1.0, 1.0]


def written(folder, mesh, name="body.stl"):
    (folder / name).write_bytes(mesh.export(file_type="stl"))
    return {"shape": "mesh", "file": name, "position": [0, 0, 0]}


def test_files_of_both_kinds_are_read(tmp_path):
    written(tmp_path, ball(2))
    (tmp_path / "text.stl").write_text(soup(ball(2)), encoding="utf-8")
    binary, text = (load_surface(tmp_path / name) for name in ("body.stl", "text.stl"))
    assert len(binary.vertices) == len(text.vertices) == 162
    # Binary files are of single precision.
    assert binary.volume == pytest.approx(text.volume, rel=1e-6)
    assert load_surface(tmp_path / "text.stl", 2.0).volume == pytest.approx(8.0 * text.volume)


def test_a_mesh_in_a_case_is_painted_as_the_shape_it_is(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body = written(tmp_path, block((2.0, 3.0, 4.0))) | {"scale": 0.5, "position": [0.2, 0.1, -0.3]}
    body["orientation"] = {"axis": [1, 2, 3], "angle": 40}
    box = {**body, "shape": "box", "sides": [1.0, 1.5, 2.0]}
    del box["file"], box["scale"]
    painted = []
    for entry in (body, box):
        data = small_case(entry)
        data["domain"]["cells"] = [40, 32, 32]
        data["profile"] = {"thickness": 0.25, "retract": False}
        case = load_case(data)
        flow = build_flow(case, build_grid(case.domain))
        painter = build_particles(case, flow, 0.01).painter
        painted.append([painter.dense(c) for c in range(3)])
    for mesh, exact in zip(*painted, strict=True):
        # What is asked of φ.
        np.testing.assert_allclose(mesh, exact, atol=1e-3)
        assert mesh.max() > 0.9


def test_a_case_keeps_the_whole_path_and_notices_another_content(tmp_path):
    (tmp_path / "sub").mkdir()
    body = written(tmp_path / "sub", ball(2))
    data = small_case(body | {"file": "sub/body.stl", "motion": "free", "density": 2.0})
    file = tmp_path / "case.toml"
    text = load_case(small_case(sphere())).to_toml().split("[[particles]]")[0]
    entry = '[[particles]]\nshape = "mesh"\nfile = "sub/body.stl"\nposition = [0, 0, 0]\n'
    file.write_text(text + entry + "[time]\nend = 1.0\n", encoding="utf-8")
    case = load_case(file)
    assert case.particles[0].file == str(tmp_path / "sub" / "body.stl")
    (tmp_path / "resolved.toml").write_text(case.to_toml(), encoding="utf-8")
    assert load_case(tmp_path / "resolved.toml") == case
    written(tmp_path / "sub", ball(3))
    text = refusal(tmp_path / "resolved.toml")
    assert text.startswith("particles.0.digest is ") and "is another; leave digest out" in text
    assert load_case(file).particles[0].digest != case.particles[0].digest
    assert "no such file; looked for" in refusal(data)


def test_meshes_stand_where_their_triangles_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    off = block()
    off.vertices += [1.0, 1.0, 1.0]
    body = written(tmp_path, off)
    # From a corner, the block takes up 0 to 2 along each axis, the wall being at 4.
    load_case(small_case(body | {"position": [0, 2, 2]}))
    assert "takes up 2.1 to 4.1 along y" in refusal(small_case(body | {"position": [0, 2.1, 2]}))
    beside = sphere(radius=0.5, position=[2.51, 1, 1])
    load_case(small_case(body, beside))
    assert "overlaps" in refusal(small_case(body, beside | {"position": [2.49, 1, 1]}))
    # Corners clear of each other, faces not.
    again = body | {"position": [1.5, 0.5, 0.5]}
    assert "overlaps" in refusal(small_case(body, again))
    (free,) = load_case(small_case(body | {"motion": "free", "density": 2.0})).particles
    np.testing.assert_allclose(start_position(free), [1.0, 1.0, 1.0], rtol=1e-6)
    assert build_shape(free).name == "mesh"
    assert "particles.0.file" in refusal(small_case(body), ["profile.thickness=1.2"])


def test_balls_that_stand_for_a_mesh_in_contact_fill_it():
    for mesh, exact, room in (
        (ball(3), shapes.sphere(1.0), 0.04),
        (block(), shapes.box([2] * 3), 0.1),
    ):
        body = shapes.touching(shapes.mesh(surface(mesh)))
        radii = np.array([part.size[0] for part in body.parts])
        centres = np.array([part.position for part in body.parts])
        # Balls lie inside, to the millionth that their radii are found to.
        assert np.all(exact.distance(centres) + radii < 1e-5)
        points = trimesh.sample.sample_surface(mesh, 2000, seed=5)[0]
        # What 256 balls leave free, most of it along edges and at corners.
        assert body.distance(points).max() < room
        assert body.volume == shapes.mesh(surface(mesh)).volume


def test_a_free_mesh_stops_at_a_wall(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body = written(tmp_path, block()) | {"motion": "free", "density": 3.0, "position": [0, -2.7, 0]}
    data = small_case(body, boundaries=("periodic", "wall", "periodic"))
    data["fluid"] |= {"gravity": [0, -2, 0]}
    data["domain"]["cells"] = [20, 16, 16]
    data["profile"]["thickness"] = 0.5
    data["time"] = {"end": 3.0, "step": 0.02}
    data["contact"] = {"range": 0.1}
    simulation = Simulation(load_case(data))
    simulation.run()
    height = simulation.particles[0]["position"][1]
    # A face of the block is 1 below its centre and the wall at −4; at rest at least half of the
    # range is left between, and no more than all of it.
    assert -2.95 < height < -2.9


def open_box():
    mesh = block()
    mesh.update_faces(np.arange(len(mesh.faces)) != 0)
    return mesh


def inverted():
    mesh = ball(1)
    mesh.invert()
    return mesh


def turned_both_ways():
    mesh = ball(1)
    mesh.faces[3] = mesh.faces[3][::-1]
    return mesh


def with_a_sliver():
    mesh = block()
    a, b, c = mesh.faces[0]
    middle = 0.5 * (mesh.vertices[a] + mesh.vertices[b])
    vertices = np.vstack([mesh.vertices, middle])
    n = len(mesh.vertices)
    faces = np.vstack([mesh.faces[1:], [[a, n, b], [n, b, c], [a, n, c]]])
    return trimesh.Trimesh(vertices, faces, process=False)


def crossing():
    other = block()
    other.vertices += [0.5, 0.3, 0.2]
    return trimesh.util.concatenate([block(), other])


def inside_out_inside():
    return trimesh.util.concatenate([block(), ball(1, 0.5)])


MENDED = {"open": open_box, "inverted": inverted, "both": turned_both_ways}


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (open_box, "its surface is open along 3 edges; it must be closed, and repair = true"),
        (inverted, "its surface is inverted, with volume -3.659; it must face outwards, and repa"),
        (turned_both_ways, "its triangles are turned both ways round, along 3 edges; they must"),
        (with_a_sliver, "1 triangle of it is without area; repair = true"),
        (crossing, "its surface crosses itself, encloses a place twice"),
        (inside_out_inside, "its surface crosses itself, encloses a place twice"),
    ],
)
def test_surfaces_that_bound_no_solid_are_refused(mesh, expected, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "body.stl").write_text(soup(mesh()), encoding="utf-8")
    text = refusal(small_case({"shape": "mesh", "file": "body.stl", "position": [0, 0, 0]}))
    assert text.startswith('particles.0.file is "')
    assert expected in text


@pytest.mark.parametrize("name", MENDED)
def test_repair_mends_what_can_be_mended(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "body.stl").write_text(soup(MENDED[name]()), encoding="utf-8")
    body = {"shape": "mesh", "file": "body.stl", "position": [0, 0, 0], "repair": True}
    (particle,) = load_case(small_case(body)).particles
    whole = block() if name == "open" else ball(1)
    assert build_shape(particle).volume == pytest.approx(whole.volume, rel=1e-12)


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "it is not an STL file, ASCII or binary"),
        (b"PK\x03\x04" * 50, "it is not an STL file, ASCII or binary"),
        (b"solid x\nendsolid x\n", "it is not an STL file, ASCII or binary"),
        (soup(block(), slice(0, 3)).encode(), "it has 3 triangles; a closed surface has 4 or more"),
        (soup(block()).replace("1.0", "nan").encode(), "that are not finite numbers"),
    ],
)
def test_files_that_hold_no_surface_are_refused(content, expected, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "body.stl").write_bytes(content)
    text = refusal(small_case({"shape": "mesh", "file": "body.stl", "position": [0, 0, 0]}))
    assert text.startswith('particles.0.file is "')
    assert expected in text


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"file": "../body.stl"}, 'particles.0.file is "../body.stl"; it must lie in the folder'),
        ({"file": "none.stl"}, 'particles.0.file is "none.stl"; there is no such file; looked'),
        ({"file": 3}, "particles.0.file is 3; it must be the path of a file in quotes"),
        ({"file": None}, "particles.0.file is missing; a mesh needs file"),
        ({"scale": 0}, "particles.0.scale is 0; it must be a finite number above 0"),
        ({"repair": 1}, "particles.0.repair is 1; it must be true or false"),
        ({"radius": 1}, "particles.0.radius is 1.0; a mesh needs file, and may have scale"),
        ({"shape": "sphere", "radius": 1}, 'particles.0.file is "body.stl"; a sphere takes radius'),
    ],
)
def test_meshes_that_cannot_be_are_refused(change, expected, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    body = written(tmp_path, ball(1)) | change
    assert expected in refusal(small_case({k: v for k, v in body.items() if v is not None}))


def test_a_surface_says_what_is_wrong_from_python_too():
    mesh = open_box()
    with pytest.raises(SurfaceError, match="open along 3 edges"):
        surface(mesh)
