"""Contact between bodies, and with walls."""

import itertools
import math

import numpy as np
import pytest
from numba import njit

from contact_scenes import UPRIGHT, Scene, grid
from smoothprofile import rotations, shapes
from smoothprofile.errors import CaseError
from smoothprofile.particles.contact import ContactParameters, default_parameters, driven
from smoothprofile.particles.contact_gap import part_gap
from smoothprofile.particles.contact_law import Law, damping_ratio, repulsion, restitution_of
from smoothprofile.particles.contact_pairs import Neighbours, bounding_radii

BALL = shapes.sphere(1.0)
SOLIDS = {
    "sphere": shapes.sphere(0.5),
    "ellipsoid": shapes.ellipsoid([1.0, 0.6, 0.4]),
    "capsule": shapes.capsule(0.3, 1.0),
    "box": shapes.box([1.0, 0.8, 0.6]),
    "cylinder": shapes.cylinder(0.5, 1.2),
    "union": shapes.centred(
        shapes.union(
            [
                (shapes.sphere(0.4), (0.0, 0.0, 0.0), UPRIGHT),
                (shapes.sphere(0.3), (0.6, 0.0, 0.0), UPRIGHT),
                (shapes.sphere(0.3), (0.0, 0.6, 0.0), UPRIGHT),
            ]
        )
    ),
}


@njit(cache=True)
def gap_between(kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b):
    """(h, n, point) of two parts, from scratch."""
    normal, point, start = np.empty(3), np.empty(3), np.full(3, np.nan)
    gap = part_gap(kind_a, size_a, turn_a, centre_a, kind_b, size_b, turn_b, centre_b, start,
                   normal, point)  # fmt: skip
    return gap, normal, point


def turned(generator, count=1):
    return rotations.normalise(generator.normal(size=(count, 4)))


def head_on(speed, **options):
    scene = Scene([BALL] * 2, [[4.0, 5.0, 5.0], [6.15, 5.0, 5.0]], **options)
    scene.velocity[:, 0] = speed, -speed
    return scene


# --- the law


def test_the_force_is_the_slope_of_a_potential_and_ever_steeper():
    law, touch = Law(0.2, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), 3.0

    def energy(h):
        inside = touch * (0.2 / 3 - h + h**2 / 0.2)
        return inside if h < 0 else touch * (0.2 - h) ** 3 / (3 * 0.2**2)

    gaps = np.linspace(0.199, -0.3, 400)
    found = np.array([repulsion(law, h, touch) for h in gaps])
    slope = [-(energy(h + 1e-6) - energy(h - 1e-6)) / 2e-6 for h in gaps]
    # Differences over 1e-6 of a cubic: 1e-10 from rounding.
    assert found[:, 0] == pytest.approx(slope, abs=1e-8)
    assert np.all(np.diff(found[:, 0]) > 0)
    assert np.all(np.diff(found[:, 1]) > -1e-12)
    assert repulsion(law, 0.2, touch) == (0.0, 0.0)


@pytest.mark.parametrize("restitution", [1.0, 0.8, 0.5, 0.2])
def test_two_spheres_rebound_at_the_restitution_whatever_their_speed(restitution):
    assert restitution_of(damping_ratio(restitution)) == pytest.approx(restitution, rel=1e-12)
    for speed in (0.9, 0.1, 0.01):
        scene = head_on(speed, restitution=restitution)
        for _ in range(8):
            scene.step(0.06 / speed)
        rebound = np.diff(scene.velocity[:, 0])[0] / (2 * speed)
        # Sub-steps of an eighth of the stiffest oscillation's stability limit.
        assert rebound == pytest.approx(restitution, rel=0.03, abs=0.01)


def test_the_rebound_converges_with_the_substeps():
    """e = .5 to second order: a symplectic step, and damping seen half a step early each way."""
    errors = []
    for count in (1, 4):
        scene = head_on(0.5, restitution=0.5)
        for _ in range(20 * count):
            scene.step(0.02 / count)
        errors.append(abs(np.diff(scene.velocity[:, 0])[0] - 0.5))
    assert errors[1] < 0.3 * errors[0]
    assert errors[1] < 2e-3


def test_default_parameters_hold_a_fall_and_a_weight():
    for gravity, speed in ((0.0, 1.0), (-2.0, 0.0)):
        weight = abs(gravity) * BALL.volume
        scene = Scene(
            [BALL], [[5, 5, 1.2]], box=grid(periodic=(True, True, False)), weight=[weight]
        )
        scene.gravity[2], scene.velocity[0, 2] = gravity, -speed
        least = min(scene.step(0.02).least_gap for _ in range(200))
        assert least > 0.0
        if gravity:
            rest = scene.position[0, 2] - 1.0
            force = scene.parameters.touch_force[0]
            # s(1 − √(W/F₀)); the damping sees the fall of half a sub-step, which is 1 % of s.
            assert rest == pytest.approx(0.1 * (1 - math.sqrt(weight / force)), abs=1e-3)


@pytest.mark.parametrize(
    "wrong",
    [{"range": 0.0}, {"restitution": 0.0}, {"friction": -1.0}, {"touch_force": np.zeros(2)}],
)
def test_unusable_parameters_are_refused(wrong):
    right = {"range": 0.1, "touch_force": np.ones(2)}
    key = next(iter(wrong))
    with pytest.raises(CaseError, match=f"contact.{key} is"):
        ContactParameters(**(right | wrong))
    with pytest.raises(CaseError, match="contact's speed is 0"):
        default_parameters(0.1, 0.0, np.ones(2), np.ones(2))


# --- gaps


def support(part, direction):
    """The farthest points of a part in its frame along directions (n, 3)."""
    size, n = part.size, direction
    if part.kind == 0:
        return size[0] * n
    if part.kind == 1:
        return size**2 * n / np.sqrt(((size * n) ** 2).sum(axis=1, keepdims=True))
    if part.kind == 4:
        return size * np.sign(n)
    ends = np.zeros_like(n)
    ends[:, 2] = size[1] * np.sign(n[:, 2])
    if part.kind == 3:
        return ends + size[0] * n
    ends[:, :2] = size[0] * n[:, :2] / np.linalg.norm(n[:, :2], axis=1, keepdims=True)
    return ends


def separation(a, turn_a, centre_a, b, turn_b, centre_b, generator):
    """max over unit n of the width of the slab normal to n between two convex bodies."""

    def width(n):
        into_a, into_b = -n @ turn_a, n @ turn_b
        nearest = (support(a, into_a) * into_a).sum(axis=1)
        farthest = (support(b, into_b) * into_b).sum(axis=1)
        return n @ (centre_a - centre_b) - nearest - farthest

    best, spread = generator.normal(size=(4000, 3)), 1.0
    for _ in range(40):
        best /= np.linalg.norm(best, axis=1, keepdims=True)
        top = best[np.argmax(width(best))]
        spread *= 0.6
        best = np.vstack([top[None], top + spread * generator.normal(size=(300, 3))])
    return width(top[None])[0]


CONVEX = [name for name in SOLIDS if name != "union"]


@pytest.mark.parametrize("pair", list(itertools.combinations_with_replacement(CONVEX, 2)))
def test_gaps_are_distances_and_normals_their_slopes(pair):
    generator = np.random.default_rng(3)
    a, b = (SOLIDS[name].parts[0] for name in pair)
    centre_b, e = np.zeros(3), 1e-5
    for _ in range(6):
        turn_a, turn_b = rotations.matrix(turned(generator, 2))
        way = generator.normal(size=3)
        way /= np.linalg.norm(way)

        def gap(centre, turn, turn_a=turn_a, turn_b=turn_b):
            return gap_between(a.kind, a.size, turn, centre, b.kind, b.size, turn_b, centre_b)

        centre = 2.5 * way
        for _ in range(5):
            h, n, _ = gap(centre, turn_a)
            centre = centre - (h - generator.uniform(0.02, 0.2)) / max(n @ way, 0.3) * way
        h, n, point = gap(centre, turn_a)
        # The search for the separating slab ends within 1e-5 of its size; so wide is its maximum.
        exact = separation(a, turn_a, centre, b, turn_b, centre_b, generator)
        assert h == pytest.approx(exact, abs=2e-5)
        swapped = gap_between(b.kind, b.size, turn_b, centre_b, a.kind, a.size, turn_a, centre)
        assert swapped[0] == pytest.approx(h, abs=1e-6)
        assert swapped[1] == pytest.approx(-n, abs=2e-3)
        # Differences over 1e-5, of gaps that end within 1e-9.
        moved = [(gap(centre + s * e * way, turn_a)[0]) for s in (1, -1)]
        assert (moved[0] - moved[1]) / (2 * e) == pytest.approx(n @ way, abs=2e-4)
        spun = [
            gap(centre, rotations.matrix(rotations.from_vector(s * e * way)) @ turn_a)[0]
            for s in (1, -1)
        ]
        expected = np.cross(point - centre, n) @ way
        assert (spun[0] - spun[1]) / (2 * e) == pytest.approx(expected, abs=2e-4)


def test_capsules_are_segments_also_where_they_are_parallel():
    rod = SOLIDS["capsule"].parts[0]
    side = np.eye(3)
    across = rotations.matrix(rotations.from_axis_angle([1.0, 0.0, 0.0], math.pi / 2))
    cases = [
        (side, [0.7, 0.0, 0.4], 0.1, [1, 0, 0]),
        (side, [0.0, 0.0, 1.75], 0.15, [0, 0, 1]),
        (across, [0.65, 0.2, 0.3], 0.05, [1, 0, 0]),
        (across, [0.0, 1.4, 0.0], math.hypot(0.9, 0.0) - 0.6, [0, 1, 0]),
    ]
    for turn, centre, expected, normal in cases:
        found = gap_between(3, rod.size, turn, np.array(centre), 3, rod.size, side, np.zeros(3))
        assert found[0] == pytest.approx(expected, abs=1e-14)
        assert found[1] == pytest.approx(normal, abs=1e-14)


# --- conservation


def crowd(count, seed, lengths=(6.0, 6.0, 6.0), **options):
    """Spheres of radii .2 to .5 flying into each other from a jittered lattice, spinning."""
    generator = np.random.default_rng(seed)
    side = math.ceil(count ** (1 / 3))
    places = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), axis=-1)
    places = (places.reshape(-1, 3)[:count] + 0.5) * np.array(lengths) / side
    balls = [shapes.sphere(r) for r in generator.uniform(0.2, 0.5, count)]
    scene = Scene(balls, places, box=grid(lengths), cell=0.1, **options)
    scene.velocity[:] = generator.normal(size=(count, 3))
    scene.spin[:] = generator.normal(size=(count, 3))
    return scene


@pytest.mark.parametrize("viscosity", [0.0, 0.1])
def test_spheres_that_collide_rub_and_lubricate_keep_all_momentum(viscosity):
    scene = crowd(50, 1, lengths=(40.0,) * 3, friction=0.5, viscosity=viscosity)
    scene.position = 18.0 + 0.13 * scene.position / 1.3
    start = scene.momentum, scene.angular_momentum, scene.energy
    hits = 0
    for _ in range(20):
        moved = scene.step(0.05)
        hits += np.count_nonzero(moved.impulse.any(axis=1))
        # Pairs are equal and opposite; sums of some hundred of them round.
        assert np.abs(moved.impulse.sum(axis=0)).max() < 1e-13 * np.abs(moved.impulse).max() * 50
    assert hits > 100
    scale = np.abs(scene.mass[:, None] * scene.velocity).sum()
    assert np.abs(scene.momentum - start[0]).max() < 1e-13 * scale
    assert np.abs(scene.angular_momentum - start[1]).max() < 1e-13 * 20 * scale
    assert scene.energy < 30 * start[2]


@pytest.mark.parametrize("name", [name for name in SOLIDS if name != "sphere"])
def test_solids_of_any_shape_push_each_other_with_no_net_force_or_torque(name):
    """So short a step that the bodies move by less than places round."""
    generator = np.random.default_rng(5)
    for other in SOLIDS:
        scene = Scene(
            [SOLIDS[name], SOLIDS[other]],
            [[5.0, 5.0, 5.0], [5.75, 5.2, 5.1]],
            friction=0.4,
            cell=0.6,
        )
        scene.quaternion = turned(generator, 2)
        scene.velocity[:], scene.spin[:] = generator.normal(size=(2, 2, 3))
        start = scene.position.copy()
        moved = scene.step(1e-16)
        assert moved.substeps == 1
        impulse, moment = moved.impulse, moved.angular_impulse
        scale = np.abs(impulse).max()
        assert scale > 0.0
        assert impulse[0] == pytest.approx(-impulse[1], abs=1e-13 * scale)
        total = (np.cross(start, impulse) + moment).sum(axis=0)
        # Arms of 10 lengths times the rounding of the impulses.
        assert total == pytest.approx(0.0, abs=1e-12 * scale)


def test_elastic_solids_keep_their_energy():
    """Solids whose moments are equal, so that between collisions they turn evenly: a cube, a
    cylinder of length √3a, four spheres at the corners of a tetrahedron."""
    corners = [(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]
    four = [(shapes.sphere(0.35), 0.25 * np.array(x), UPRIGHT) for x in corners]
    solids = [shapes.box([0.9] * 3), shapes.cylinder(0.5, 0.5 * math.sqrt(3.0))]
    solids = [*solids, shapes.centred(shapes.union(four)), shapes.sphere(0.5)] * 2
    generator = np.random.default_rng(8)
    places = np.stack(np.meshgrid(*[[0.9, 2.7]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    scene = Scene(solids, places, box=grid((3.6,) * 3), restitution=1.0, speed=6.0, cell=0.1)
    scene.quaternion = turned(generator, 8)
    scene.velocity = generator.normal(size=(8, 3))
    start, hits, energies = scene.energy, 0, []
    for _ in range(400):
        hits += np.count_nonzero(scene.step(0.01).impulse.any(axis=1))
        energies.append(scene.energy)
    assert hits > 200
    # While bodies are pressed together a part of the energy is in the contact; none is gained.
    assert max(energies) < 1.03 * start
    assert np.median(energies) == pytest.approx(start, rel=0.02)


# --- nothing passes through


@pytest.mark.parametrize("name", SOLIDS)
@pytest.mark.parametrize("speed", [1.0, 100.0])
def test_nothing_leaves_through_walls(name, speed):
    """Thrown at walls and corners at up to 100 times the expected speed, spinning."""
    generator = np.random.default_rng(11)
    box = grid((3.0, 3.0, 3.0), (False, False, False))
    scene = Scene([SOLIDS[name]], [[1.5, 1.5, 1.5]], box=box, cell=0.1, friction=0.3)
    scene.quaternion = turned(generator)
    least = math.inf
    for _ in range(40):
        scene.velocity[:] = speed * generator.normal(size=3)
        scene.spin[:] = 2 * generator.normal(size=3)
        moved = scene.step(0.4 if speed == 1.0 else 0.05)
        least = min(least, moved.least_gap)
        assert np.all((scene.position > 0.0) & (scene.position < 3.0))
    assert least < 0.1
    # A turn is not foreseen: in each sub-step a surface turns in by (ωδt)² of its size at most.
    assert least > (-1e-12 if name == "sphere" else -1e-3 if speed == 1.0 else -0.03)


def test_no_acceleration_or_crowd_pushes_a_sphere_through_a_wall():
    scene = crowd(40, 2, lengths=(3.2,) * 3)
    scene = Scene(
        [shapes.sphere(0.3)] * 40,
        scene.position,
        box=grid((3.2,) * 3, (False, False, False)),
        cell=0.05,
    )
    scene.gravity[:] = 0.0, 0.0, -1000.0
    for _ in range(60):
        scene.step(0.02)
        assert np.all(scene.position > 0.3 - 1e-12)
        assert np.all(scene.position < 2.9 + 1e-12)


def test_bullets_do_not_tunnel():
    """One sphere at 200 times the expected speed against one at rest, 4 radii in a step."""
    scene = Scene([BALL] * 2, [[1.5, 5.0, 5.0], [4.0, 5.0, 5.0]])
    scene.velocity[0, 0] = 200.0
    for _ in range(5):
        moved = scene.step(0.02)
        apart = scene.position[1, 0] - scene.position[0, 0]
        assert apart >= 2.0 - 1e-9
        assert moved.least_gap >= -1e-9
    assert scene.momentum[0] == pytest.approx(200.0 * BALL.volume, rel=1e-14)


@pytest.mark.parametrize("depth", [0.05, 0.5, 1.5])
def test_overlapping_bodies_part_gently(depth):
    scene = Scene([BALL] * 2, [[4.0, 5.0, 5.0], [6.0 - depth, 5.0, 5.0]])
    for _ in range(200):
        scene.step(0.05)
    # √(2F₀s/3m) with F₀ = 3mU²/s of the pair's m/2: twice the expected speed, in relative terms.
    assert 0.0 < np.diff(scene.velocity[:, 0])[0] <= 2.0 + 1e-9
    assert np.diff(scene.position[:, 0])[0] > 2.0


def test_a_pile_of_overlapping_bodies_comes_apart():
    generator = np.random.default_rng(4)
    scene = Scene(
        [shapes.sphere(0.4)] * 30,
        generator.uniform(0.5, 2.5, (30, 3)),
        box=grid((3.0, 3.0, 3.0), (True, True, False)),
    )
    for _ in range(150):
        scene.step(0.05)
        assert np.abs(scene.velocity).max() < 12.0
    assert np.all((scene.position[:, 2] > 0.4 - 1e-9) & (scene.position[:, 2] < 2.6 + 1e-9))


# --- neighbours, images, restarts


def test_candidates_are_all_pairs_within_reach_on_mixed_axes():
    """Radii over two decades, against all pairs; the far end of a periodic axis included."""
    generator = np.random.default_rng(6)
    n, period = 150, np.array([4.0, 0.0, 3.0])
    radius = 10 ** generator.uniform(-2, -0.3, n)
    centre = generator.uniform(-1.0, 5.0, (n, 3))
    centre[:2] = [[4.0, 1.0, 3.0], [0.0, 1.0, -0.0]]
    body, kind = np.arange(n) // 2, np.zeros(n, int)
    mobile = body % 3 > 0
    near = Neighbours(body, kind, radius, mobile, np.zeros(3), np.full(3, 4.0), period)
    found = near.within(centre, 0.1)
    expected = []
    for i, j in itertools.combinations(range(n), 2):
        apart = centre[i] - centre[j]
        apart -= period * np.round(apart / np.where(period > 0, period, 1))
        close = np.linalg.norm(apart) < radius[i] + radius[j] + 0.1
        if close and body[i] != body[j] and (mobile[i] or mobile[j]):
            expected.append((i, j, 0))
    for i in np.flatnonzero(mobile):
        for side, gap in enumerate((centre[i, 1], 4.0 - centre[i, 1])):
            if gap - radius[i] < 0.1:
                expected.append((i, -3 - side, 0))
    assert [tuple(row) for row in found] == sorted(expected)
    assert len(found) > 100


def test_balls_about_parts_hold_them():
    for shape in SOLIDS.values():
        for part in shape.parts:
            radius = bounding_radii(np.array([part.kind]), part.size[None])[0]
            n = np.random.default_rng(0).normal(size=(500, 3))
            n /= np.linalg.norm(n, axis=1, keepdims=True)
            assert np.linalg.norm(support(part, n), axis=1).max() <= radius * (1 + 1e-12)


def test_a_pair_meets_across_periodic_faces_as_anywhere():
    results = []
    for shift in (0.0, 5.0, -27.0):
        scene = head_on(0.5)
        scene.position[0, 0] += shift
        scene.position[1, 0] += shift % 10.0
        for _ in range(10):
            scene.step(0.05)
        results.append(scene.velocity.copy())
    # Coordinates of up to 27 round at 4e-15, and so do gaps; a stiff contact magnifies that.
    assert results[1] == pytest.approx(results[0], abs=1e-8)
    assert results[2] == pytest.approx(results[0], abs=1e-8)
    assert results[0][0, 0] < 0.0


def test_a_restart_and_a_second_run_give_the_same_bits():
    runs = []
    for kind in ("whole", "again", "restarted"):
        scene = crowd(60, 7, friction=0.3, viscosity=0.05)
        for k in range(12):
            if kind == "restarted" and k == 5:
                fresh = crowd(60, 7, friction=0.3, viscosity=0.05)
                for name in ("position", "quaternion", "velocity", "spin"):
                    setattr(fresh, name, getattr(scene, name))
                scene = fresh
            scene.step(0.05)
        runs.append((scene.position, scene.quaternion, scene.velocity, scene.spin))
    for other in runs[1:]:
        assert all(np.array_equal(a, b) for a, b in zip(runs[0], other, strict=True))
    assert not np.array_equal(runs[0][3], crowd(60, 7).spin)


def test_bodies_that_meet_nothing_move_as_if_there_were_no_contact():
    """To the bit: R + Δt V̄ and exp(Δt Ω̄)q, also beside others that collide."""
    scene = Scene([BALL] * 3, [[2.0, 5, 5], [4.05, 5, 5], [8.0, 2.0, 2.0]])
    generator = np.random.default_rng(2)
    older, newer, spin = generator.normal(size=(3, 3, 3))
    scene.quaternion = turned(generator, 3)
    nothing = np.zeros((3, 3))
    mean, rate = driven(newer, older, nothing, 0.01)
    start, q, dt = scene.position.copy(), scene.quaternion.copy(), 0.01
    moved = scene.contact.move(start, q, (mean, rate), (spin, nothing), dt)
    assert moved.substeps > 1
    assert moved.impulse[0, 0] < 0.0
    assert np.array_equal(moved.position[2], (start + dt * (1.5 * newer - 0.5 * older))[2])
    turn = rotations.multiply(rotations.from_vector(dt * spin), q)
    assert np.array_equal(moved.quaternion[2], rotations.normalise(turn)[2])
    assert not moved.impulse[2].any()
    assert not moved.history.velocity_gain[2].any()


def test_what_contact_gave_is_not_extrapolated():
    """V̄ and V̇ of a fall with a bounce in the last step: those of the fall."""
    fall, kick, dt = np.array([[0.0, 0.0, -0.2]]), np.array([[0.0, 0.0, 3.0]]), 0.1
    older = np.array([[0.0, 0.0, -1.0]])
    mean, rate = driven(older + fall + kick, older, kick, dt)
    assert mean == pytest.approx(older + 1.5 * fall + kick, abs=1e-15)
    assert rate == pytest.approx(fall / dt, abs=1e-14)


# --- friction, walls and bodies that do not give way


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.4])
def test_a_sliding_sphere_comes_to_roll(friction):
    """V = V₀ − μgt and aΩ = (5/2)μgt until they meet at 5V₀/7; without friction it slides on."""
    scene = Scene(
        [shapes.sphere(0.5)],
        [[5.0, 5.0, 0.5]],
        box=grid(periodic=(True, True, False)),
        cell=0.01,
        weight=[shapes.sphere(0.5).volume],
        friction=friction,
        restitution=0.2,
    )
    scene.position[0, 2] += 0.01 * (1 - math.sqrt(scene.mass[0] / scene.parameters.touch_force[0]))
    scene.gravity[2], scene.velocity[0, 0] = -1.0, 1.0
    for _ in range(50):
        scene.step(0.02)
    # The point of contact lies half the gap below the sphere, .5 % of its radius.
    if friction == 0.1:
        assert scene.velocity[0, 0] == pytest.approx(0.9, rel=0.01)
        assert scene.spin[0, 1] * 0.5 == pytest.approx(0.25, rel=0.02)
    else:
        expected = 5 / 7 if friction else 1.0
        assert scene.velocity[0, 0] == pytest.approx(expected, rel=0.01)
        assert scene.spin[0, 1] * 0.5 == pytest.approx(expected if friction else 0.0, rel=0.01)


def test_a_sliding_wall_drags_a_body_and_gets_what_it_gives():
    scene = Scene([BALL], [[5.0, 5.0, 1.01]], box=grid(periodic=(True, True, False)), friction=0.5)
    walls = np.zeros((3, 2, 3))
    walls[2, 0, 0] = 0.7
    total = 0.0
    for _ in range(5):
        moved = scene.step(0.02, walls)
        total = total + moved.wall_impulse
        assert moved.wall_impulse[2, 0] == pytest.approx(-moved.impulse[0], abs=1e-15)
    assert scene.velocity[0, 0] > 0.01
    assert scene.velocity[0, 2] > 0.0
    assert total[2, 0] == pytest.approx(-scene.momentum, rel=1e-12)
    assert not total[:2].any()


@pytest.mark.parametrize("still", ["sphere", "box", "plane", "cylinder"])
def test_held_bodies_do_not_give_way(still):
    held = {
        "sphere": (shapes.sphere(1.0), (5.0, 5.0, 3.0)),
        "box": (shapes.box([2.0, 2.0, 2.0]), (5.0, 5.0, 3.0)),
        "plane": (shapes.plane((0.0, 0.0, 1.0)), (0.0, 0.0, 4.0)),
        "cylinder": (shapes.cylinder(1.0), (5.0, 5.0, 5.0)),
    }
    form, place = held[still]
    at, way = ((5.0, 5.0, 4.8), 2) if still != "cylinder" else ((6.8, 5.0, 5.0), 0)
    scene = Scene([form, shapes.sphere(0.5)], [place, at], held=[0], restitution=1.0)
    scene.velocity[1, way] = -1.0
    for _ in range(20):
        scene.step(0.05)
    assert scene.velocity[1, way] == pytest.approx(1.0, rel=0.01)
    assert scene.position[0] == pytest.approx(place, abs=0.0)
    assert not scene.velocity[0].any()


def test_a_moving_body_pushes_others_before_it():
    """A prescribed sphere, as a piston, throws a free one on at twice its speed if e = 1."""
    scene = Scene([BALL] * 2, [[3.0, 5.0, 5.0], [5.3, 5.0, 5.0]], held=[0], restitution=1.0)
    scene.velocity[0, 0] = 0.5
    for _ in range(20):
        scene.step(0.1)
    assert scene.velocity[1, 0] == pytest.approx(1.0, rel=0.01)
    assert scene.velocity[0, 0] == 0.5
