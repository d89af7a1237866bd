from decimal import Decimal, localcontext

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from smoothprofile import shapes
from smoothprofile.errors import CaseError
from smoothprofile.rotations import from_axis_angle

AT_REST = (1.0, 0.0, 0.0, 0.0)
ROUND_OFF = 1e-14

BODIES = {
    "sphere": shapes.sphere(0.8),
    "ellipsoid": shapes.ellipsoid((1.2, 0.8, 0.5)),
    "disc": shapes.ellipsoid((1.0, 0.1, 1.0)),
    "needle": shapes.ellipsoid((0.1, 0.1, 1.0)),
    "cylinder": shapes.cylinder(0.6, 1.4),
    "capsule": shapes.capsule(0.4, 1.1),
    "box": shapes.box((0.9, 1.4, 2.0)),
}


def surface(body):
    """A dense sampling of a primitive's surface, and the largest gap between its points."""
    kind, (s0, s1, s2) = body.parts[0].kind, body.parts[0].size
    n = 300
    u, v = np.meshgrid(np.linspace(-1, 1, n), np.linspace(0, 2 * np.pi, 2 * n), indexing="ij")
    ring = np.stack([np.cos(v), np.sin(v), 0 * v], -1)
    up = np.array([0.0, 0.0, 1.0])
    polar = 0.5 * np.pi * u[..., None]
    ball = np.cos(polar) * ring + np.sin(polar) * up
    side = s0 * ring + s1 * u[..., None] * up
    if kind in (shapes.SPHERE, shapes.ELLIPSOID):
        pieces = [ball * ([s0, s0, s0] if kind == shapes.SPHERE else [s0, s1, s2])]
    elif kind == shapes.CAPSULE:
        pieces = [side, s0 * ball + s1 * np.sign(u)[..., None] * up]
    elif kind == shapes.CYLINDER:
        pieces = [side, *(s0 * 0.5 * (1 + u)[..., None] * ring + h * up for h in (-s1, s1))]
    else:
        half, w = np.array([s0, s1, s2]), v / np.pi - 1
        faces = [np.stack([np.full_like(u, e), u, w], -1) for e in (-1, 1)]
        pieces = [half * np.roll(face, axis, -1) for axis in range(3) for face in faces]
    return np.concatenate([piece.reshape(-1, 3) for piece in pieces]), 3.2 * max(s0, s1, s2) / n


def points_around(body, count, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform(-1.6, 1.6, (count, 3)) * np.minimum(body.extents, 1.5)


def gradient(body, points, h=1e-6):
    steps = h * np.eye(3)
    d = [(body.distance(points + e) - body.distance(points - e)) / (2 * h) for e in steps]
    return np.stack(d, axis=-1)


def curvature(body, points):
    part = body.parts[0]
    return np.array([shapes.curvature(part.kind, *part.size, *point) for point in points])


def decimal_distance(radii, point):
    """Signed distance to an ellipsoid by bisection of Σ(eᵢyᵢ/(t + eᵢ²))² = 1 to 40 digits."""
    with localcontext(prec=50):
        pairs = [
            (Decimal(float(e)), abs(Decimal(float(y)))) for e, y in zip(radii, point, strict=True)
        ]
        m = min(e for e, _ in pairs)
        moved = [(e, y, e * e - m * m) for e, y in pairs if y]
        if all(q for _, _, q in moved) and sum((e * y / q) ** 2 for e, y, q in moved) <= 1:
            return -m * (1 - sum((y * y / q for _, y, q in moved), Decimal(0))).sqrt()
        # In s = t + m², first by factors, as the root may lie many decades below m².
        low, high = Decimal("1e-40") * m * m, sum(e * y for e, y in pairs) + m * m
        for halving in range(170):
            middle = (low * high).sqrt() if halving < 50 else (low + high) / 2
            inside = sum((e * y / (middle + q)) ** 2 for e, y, q in moved) > 1
            low, high = (middle, high) if inside else (low, middle)
        t = low - m * m
        return t * sum((y / (low + q)) ** 2 for _, y, q in moved).sqrt()


@pytest.mark.parametrize("name", BODIES)
def test_distance_is_that_of_the_nearest_surface_point(name):
    body = BODIES[name]
    samples, gap = surface(body)
    points = points_around(body, 400)
    d = body.distance(points)
    nearest, _ = cKDTree(samples).query(points)
    assert np.all(nearest >= np.abs(d) - ROUND_OFF)
    # A sample lies within gap of the nearest point, and the surface between is flat or bent
    # towards the point by no more than gap²/2|d|; on it by at most the gap.
    excess = np.minimum(gap, gap**2 / np.maximum(np.abs(d), 1e-12))
    assert np.all(nearest <= np.abs(d) + excess)
    # Sampled points are at distance zero to round-off.
    assert np.max(np.abs(body.distance(samples[::97]))) < ROUND_OFF


@pytest.mark.parametrize("name", BODIES)
def test_distance_is_negative_inside(name):
    body = BODIES[name]
    x, y, z = (points := points_around(body, 500)).T
    s0, s1, s2 = body.parts[0].size
    inside = {
        "sphere": x**2 + y**2 + z**2 < s0**2,
        "cylinder": (x**2 + y**2 < s0**2) & (abs(z) < s1),
        "capsule": x**2 + y**2 + (z - np.clip(z, -s1, s1)) ** 2 < s0**2,
        "box": (abs(x) < s0) & (abs(y) < s1) & (abs(z) < s2),
        "ellipsoid": np.sum((points / [s0, s1 or 1, s2 or 1]) ** 2, axis=1) < 1,
    }[body.name]
    np.testing.assert_array_equal(body.distance(points) < 0, inside)
    assert 10 < np.sum(inside) < 490


@pytest.mark.parametrize("name", [*BODIES, "infinite cylinder", "plane"])
def test_the_gradient_of_the_distance_is_a_unit_vector(name):
    more = {"infinite cylinder": shapes.cylinder(0.7), "plane": shapes.plane((1, 2, 2))}
    body = (BODIES | more)[name]
    slope = np.linalg.norm(gradient(body, points_around(body, 400)), axis=1)
    # Central differences of step h = 1e-6: round-off/h = 1e-10, and h²κ² = 1e-8 at the sharpest
    # curvature, 100, of the disc's rim.
    np.testing.assert_allclose(slope, 1.0, rtol=0, atol=1e-7)


def test_a_plane_and_an_infinite_cylinder_have_their_closed_forms():
    points = points_around(BODIES["box"], 50)
    plane = shapes.plane((0, 3, -4)).distance(points)
    np.testing.assert_allclose(plane, points @ [0, 0.6, -0.8], rtol=0, atol=ROUND_OFF)
    cylinder = shapes.cylinder(0.7).distance(points + np.array([0, 0, 1e3]))
    np.testing.assert_allclose(cylinder, np.hypot(*points[:, :2].T) - 0.7, rtol=0, atol=ROUND_OFF)


RADII = [
    (1, 1, 1),
    (2, 1, 1),
    (1, 2, 2),
    (3, 1, 2),
    (1, 10, 1),
    (10, 1, 10),
    (10, 3, 1),
    (1, 1 + 1e-9, 1 + 1e-5),
    (1e-6, 3e-6, 1e-5),
]


def difficult_points(radii, rng):
    """Points around, on the surface, on axes and planes of symmetry, near the centre, far away,
    and at the focal curve, where the nearest points of two halves meet."""
    e, n = np.array(radii, dtype=float), 12
    box = rng.uniform(-1.5, 1.5, (n, 3)) * e
    shell = rng.normal(size=(n, 3))
    shell *= e * (1 + 1e-6 * rng.normal(size=(n, 1))) / np.linalg.norm(shell, axis=1)[:, None]
    planes = box * rng.integers(0, 2, (n, 3))
    decades = 10 ** rng.uniform(-17, 2, (n, 3)) * e
    flat = np.argmin(e)
    focal = rng.normal(size=(n, 3)) * (np.arange(3) != flat)
    focal *= (e**2 - e[flat] ** 2) / e / np.linalg.norm(focal, axis=1)[:, None]
    focal *= 1 + 10 ** rng.uniform(-16, -1, (n, 1)) * rng.choice([-1, 1], (n, 1))
    focal[:, flat] = 10 ** rng.uniform(-17, 0, n) * e[flat]
    return np.concatenate([box, shell, planes, decades, focal, np.diag(e), np.zeros((1, 3))])


@pytest.mark.parametrize("radii", RADII)
def test_ellipsoid_distance_is_exact(radii):
    points = difficult_points(radii, np.random.default_rng(3))
    exact = np.array([float(decimal_distance(radii, point)) for point in points])
    ours = shapes.ellipsoid(radii).distance(points)
    # Near the surface d is a difference of coordinates and keeps their round-off, no more digits.
    np.testing.assert_allclose(ours, exact, rtol=1e-12, atol=4e-16 * max(radii))


def test_an_ellipsoid_of_equal_radii_is_a_sphere():
    points = points_around(BODIES["sphere"], 100)
    ellipsoid = shapes.ellipsoid((0.8, 0.8, 0.8))
    np.testing.assert_allclose(
        ellipsoid.distance(points), BODIES["sphere"].distance(points), rtol=0, atol=ROUND_OFF
    )
    np.testing.assert_allclose(curvature(ellipsoid, points), 2 / 0.8, rtol=ROUND_OFF)
    assert not ellipsoid.curvature_varies


@pytest.mark.parametrize("a, b, c", RADII[3:8])
def test_ellipsoid_curvature_at_its_poles(a, b, c):
    poles = np.diag([a, b, c]) * np.array([1.0, -1.0, 1.0])[:, None]
    exact = [a / b**2 + a / c**2, b / a**2 + b / c**2, c / a**2 + c / b**2]
    body = shapes.ellipsoid((a, b, c))
    # The pole's own curvature turns round-off of the position into a change of at most 1e-13.
    np.testing.assert_allclose(curvature(body, poles), exact, rtol=1e-12)
    # Beyond a pole, as far out as one likes, and at the centre the nearest point is a pole.
    np.testing.assert_allclose(curvature(body, 5 * poles), exact, rtol=1e-12)
    np.testing.assert_allclose(curvature(body, np.zeros((1, 3))), [min(exact)], rtol=1e-12)


@pytest.mark.parametrize("name", ["sphere", "ellipsoid", "cylinder", "capsule", "box"])
def test_curvature_is_the_laplacian_of_the_distance_on_the_surface(name):
    body, h = BODIES[name], 1e-3
    points = points_around(body, 600)
    foot = points - body.distance(points)[:, None] * gradient(body, points)
    around = [body.distance(foot + s * e) for e in h * np.eye(3) for s in (-1, 1)]
    laplacian = (sum(around) - 6 * body.distance(foot)) / h**2
    # Edges and the capsule's seams, where κ jumps, are left out, by the stencil's own width.
    size = body.parts[0].size
    smooth = np.ones(len(foot), dtype=bool)
    if name in ("cylinder", "capsule"):
        smooth = np.abs(np.abs(foot[:, 2]) - size[1]) > 2 * h
    if name == "cylinder":
        smooth |= np.hypot(foot[:, 0], foot[:, 1]) < size[0] - 2 * h
    if name == "box":
        smooth = np.sum(size - np.abs(foot) < 2 * h, axis=1) == 1
    assert np.sum(smooth) > 100
    # h²κ³/4 = 1e-5 at κ = 5, of which the ellipsoid's tip has a few times more.
    expected = curvature(body, points)
    np.testing.assert_allclose(laplacian[smooth], expected[smooth], rtol=0, atol=1e-4)


def test_ellipsoid_curvature_is_continuous_across_its_focal_plane():
    points = np.array([[0.3, 0.2, z] for z in (0.0, 1e-305, 1e-14, 1e-10)])
    body = BODIES["ellipsoid"]
    # The foot moves by about z, and κ with it.
    np.testing.assert_allclose(curvature(body, points), curvature(body, points)[0], rtol=1e-9)


def moments(distance, low, high, cells=96):
    """Volume and inertia about the origin by the midpoint rule, cut cells counted by ½ − d/h."""
    h = np.max(high - low) / cells
    n = np.ceil((high - low) / h).astype(int)
    r = (low + h * (np.indices(n).reshape(3, -1).T + 0.5)).reshape(-1, 3)
    weights = h**3 * np.clip(0.5 - distance(r) / h, 0, 1)
    second = (r.T * weights) @ r
    return np.sum(weights), weights @ r, np.trace(second) * np.eye(3) - second


# h² of 96 cells along the longest side, 1e-4 of its square, times a few for the shorter sides:
# the ramp smears the surface by h²/24 for the volume, and edges and r² count for more.
@pytest.mark.parametrize("name", ["sphere", "ellipsoid", "cylinder", "capsule", "box"])
def test_volume_and_inertia_agree_with_quadrature(name):
    body = BODIES[name]
    volume, _, inertia = moments(body.distance, -1.07 * body.extents, 1.07 * body.extents)
    assert body.volume == pytest.approx(volume, rel=1e-3)
    np.testing.assert_allclose(np.diag(body.inertia), np.diag(inertia), rtol=2e-3)
    assert np.all(body.inertia == np.diag(np.diag(body.inertia)))
    assert np.all(body.centroid == 0.0)


def test_an_infinite_cylinder_is_measured_per_length():
    long = shapes.cylinder(0.7, 100.0)
    endless = shapes.cylinder(0.7)
    assert endless.volume == pytest.approx(long.volume / 100.0)
    assert endless.inertia[2, 2] == pytest.approx(long.inertia[2, 2] / 100.0)
    assert endless.inertia[0, 0] == np.inf and endless.inertia[0, 1] == 0.0
    np.testing.assert_array_equal(endless.extents, [0.7, 0.7, np.inf])
    assert endless.reach == np.inf


def test_a_half_space_has_no_end():
    body = shapes.plane()
    assert body.volume == np.inf and body.reach == np.inf
    assert np.all(np.isinf(body.extents)) and np.all(np.isfinite(body.centroid))


@pytest.mark.parametrize("name", BODIES)
def test_reach_and_extents_touch_the_turned_surface(name):
    turn = from_axis_angle((1, 2, 3), 0.7)
    samples, gap = surface(BODIES[name])
    placed = samples @ Rotation.from_quat(np.roll(turn, -1)).as_matrix().T
    body = shapes.union([(BODIES[name], (0, 0, 0), turn)])
    farthest = np.max(np.linalg.norm(samples, axis=1))
    # The farthest point of a bent surface is missed by less than half the gap.
    assert farthest - ROUND_OFF <= body.reach <= farthest + gap / 2
    beyond = body.extents - np.max(np.abs(placed), axis=0)
    assert np.all((beyond >= -ROUND_OFF) & (beyond <= gap / 2))


def test_a_turned_infinite_cylinder_is_endless_only_along_itself():
    turn = from_axis_angle((1, 0, 0), np.pi / 2)
    body = shapes.union([(shapes.cylinder(0.7), (0, 0, 0.3), turn)])
    np.testing.assert_allclose(body.extents, [0.7, np.inf, 1.0], rtol=ROUND_OFF)


def test_a_union_is_the_least_of_its_parts_distances():
    first, second = from_axis_angle((1, 2, 3), 0.7), from_axis_angle((0, 1, -1), 2.0)
    body = shapes.union(
        [(BODIES["capsule"], (0.2, 0, -0.3), first), (BODIES["box"], (0, 0.5, 0.4), second)]
    )
    points = points_around(body, 200)
    turns = [Rotation.from_quat(np.roll(q, -1)) for q in (first, second)]
    capsule = BODIES["capsule"].distance(turns[0].inv().apply(points - [0.2, 0, -0.3]))
    box = BODIES["box"].distance(turns[1].inv().apply(points - [0, 0.5, 0.4]))
    np.testing.assert_allclose(
        body.distance(points), np.minimum(capsule, box), rtol=0, atol=ROUND_OFF
    )
    assert min(np.sum(capsule < box), np.sum(box < capsule)) > 20


def test_a_union_of_unions_keeps_every_part_in_place():
    q, p = from_axis_angle((1, 2, 3), 0.7), from_axis_angle((0, 1, -1), 2.0)
    inner = shapes.union([(BODIES["box"], (0.3, 0, 0), q), (BODIES["sphere"], (2, 0, 0), AT_REST)])
    outer = shapes.union([(inner, (0, 1, 0), p)])
    points = points_around(outer, 100)
    back = Rotation.from_quat(np.roll(p, -1)).inv().apply(points - [0, 1, 0])
    np.testing.assert_allclose(outer.distance(points), inner.distance(back), rtol=0, atol=ROUND_OFF)
    assert outer.volume == pytest.approx(inner.volume, rel=ROUND_OFF)


def test_parts_that_do_not_overlap_add_up_exactly():
    ball = shapes.sphere(0.5)
    diagonal = np.array([1.0, 1.0, 1.0]) / np.sqrt(3)
    # They touch, and their bounding boxes overlap.
    body = shapes.union([(ball, 0 * diagonal, AT_REST), (ball, diagonal, AT_REST)])
    assert body.volume == pytest.approx(2 * ball.volume, rel=ROUND_OFF)
    np.testing.assert_allclose(body.centroid, diagonal / 2, rtol=ROUND_OFF)
    across = np.eye(3) - np.outer(diagonal, diagonal)
    exact = 2 * ball.inertia + 2 * ball.volume * 0.25 * across
    np.testing.assert_allclose(body.inertia, exact, rtol=0, atol=ROUND_OFF)


def test_a_turned_part_turns_its_inertia():
    q = from_axis_angle((1, 2, 3), 0.7)
    turn = Rotation.from_quat(np.roll(q, -1)).as_matrix()
    body = shapes.union([(BODIES["box"], (1, 2, 3), q)])
    exact = turn @ BODIES["box"].inertia @ turn.T
    # Moving the origin to the centroid takes 14 V from numbers of that size.
    np.testing.assert_allclose(body.inertia, exact, rtol=0, atol=1e-12)


# What the docstring of `union` promises.
SHARED_ERROR = 5e-5


@pytest.mark.parametrize("gap", [0.3, 1.0, 1.7])
def test_two_overlapping_spheres_share_a_lens(gap):
    direction = np.array([2.0, 1.0, 2.0]) / 3.0
    ball = shapes.sphere(1.0)
    body = shapes.union([(ball, 0 * direction, AT_REST), (ball, gap * direction, AT_REST)])
    lens = np.pi * (4 + gap) * (2 - gap) ** 2 / 12
    exact = 2 * ball.volume - lens
    assert body.volume == pytest.approx(exact, rel=SHARED_ERROR)
    np.testing.assert_allclose(body.centroid, 0.5 * gap * direction, rtol=0, atol=SHARED_ERROR)


def test_two_overlapping_boxes_make_a_box():
    cube, long = shapes.box((1, 1, 1)), shapes.box((1.6, 1, 1))
    q = from_axis_angle((1, 2, 3), 0.7)
    along = Rotation.from_quat(np.roll(q, -1)).apply([1.0, 0, 0])
    body = shapes.union([(cube, -0.3 * along, q), (cube, 0.3 * along, q)])
    exact = shapes.union([(long, (0, 0, 0), q)])
    assert body.volume == pytest.approx(1.6, rel=SHARED_ERROR)
    np.testing.assert_allclose(body.inertia, exact.inertia, rtol=0, atol=SHARED_ERROR)


def test_a_part_hidden_in_another_counts_once():
    body = shapes.union(
        [(BODIES["box"], (0, 0, 0), AT_REST), (shapes.sphere(0.3), (0.1, 0.2, 0.3), AT_REST)]
    )
    assert body.volume == pytest.approx(BODIES["box"].volume, rel=SHARED_ERROR)
    np.testing.assert_allclose(body.inertia, BODIES["box"].inertia, rtol=0, atol=SHARED_ERROR)


def test_a_thin_overlap_is_measured_in_little_memory():
    box = shapes.box((1, 1, 1))
    body = shapes.union([(box, (0, 0, 0), AT_REST), (box, (0.3, 0.4, 1 - 1e-7), AT_REST)])
    assert body.volume - 2 == pytest.approx(-0.42e-7, abs=ROUND_OFF)


def test_curvature_varies_where_it_does():
    varies = {name: body.curvature_varies for name, body in BODIES.items()}
    even = {"sphere", "box"}
    assert varies == {name: name not in even for name in BODIES}
    assert not shapes.cylinder(1.0).curvature_varies
    assert not shapes.plane().curvature_varies
    places = [((0, 0, 0), AT_REST), ((2, 0, 0), AT_REST)]
    ball, larger = shapes.sphere(0.5), shapes.sphere(0.7)
    assert not shapes.union([(ball, *places[0]), (ball, *places[1])]).curvature_varies
    assert shapes.union([(ball, *places[0]), (larger, *places[1])]).curvature_varies


def test_shapes_cannot_be_changed():
    body = shapes.sphere(1.0)
    with pytest.raises(ValueError, match="read-only"):
        body.parts[0].size[0] = 2.0
    with pytest.raises(AttributeError):
        body.volume = 1.0


@pytest.mark.parametrize("bad", [0, -1.0, np.nan, np.inf, "wide", None, (1, 2)])
def test_a_size_that_is_no_length_is_refused(bad):
    for name, make in {
        "sphere radius": lambda: shapes.sphere(bad),
        "cylinder radius": lambda: shapes.cylinder(bad, 1),
        "capsule radius": lambda: shapes.capsule(bad, 1),
        "capsule length": lambda: shapes.capsule(1, bad),
        "ellipsoid radii": lambda: shapes.ellipsoid((1, 2, bad)),
        "box sides": lambda: shapes.box((bad, 2, 1)),
    }.items():
        with pytest.raises(CaseError, match=f"{name} is .*; it must be .* above 0\\."):
            make()
    if bad is not None:
        with pytest.raises(CaseError, match="cylinder length is"):
            shapes.cylinder(1, bad)


def test_a_union_that_makes_no_sense_is_refused():
    with pytest.raises(CaseError, match="no parts"):
        shapes.union([])
    with pytest.raises(CaseError, match="union position is"):
        shapes.union([(BODIES["sphere"], (0, np.nan, 0), AT_REST)])
    with pytest.raises(CaseError, match="quaternion is"):
        shapes.union([(BODIES["sphere"], (0, 0, 0), (0, 0, 0, 0))])
