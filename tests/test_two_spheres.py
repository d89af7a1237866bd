"""Two equal spheres: force in a field and mobility, against stored values, series and limits."""

import math

import numpy as np
import pytest

from smoothprofile.theory.pair_images import (
    image_field,
    image_flow,
    periodic_pair_force,
    periodic_pair_mobility,
)
from smoothprofile.theory.two_spheres import (
    DIRECTIONS,
    approach,
    pair_dipole,
    pair_force,
    pair_mobility,
)

FORCES = {
    (2, 0.5): -0.136219,
    (2, 1.0): -0.061560,
    (2, 2.0): -0.018772,
    (10, 0.5): -1.571055,
    (10, 1.0): -0.619628,
    (10, 2.0): -0.175615,
}
IN_A_CUBE = {(2, 0.5): -0.131808, (2, 1.0): -0.054098, (10, 0.5): -1.567287, (10, 1.0): -0.563357}
MOBILITIES = {
    (3, "along"): (1.432040, 0.490520),
    (3, "across"): (1.266802, 0.729671),
    (4, "along"): (1.347240, 0.626299),
    (4, "across"): (1.195030, 0.804402),
}
MAGIC = math.acos(1 / math.sqrt(3))


def free_mobility(distance):
    return pair_mobility(distance, opposite=True)


@pytest.mark.parametrize(("ratio", "gap"), FORCES)
def test_force_along_the_field(ratio, gap):
    # As many digits as are stored.
    assert pair_force(2 + gap, ratio)[0] == pytest.approx(FORCES[ratio, gap], abs=6e-7)


@pytest.mark.parametrize("ratio", [0.1, 3.0, math.inf])
def test_far_apart_they_are_point_dipoles(ratio):
    beta = 1.0 if math.isinf(ratio) else (ratio - 1) / (ratio + 2)
    d = 60.0
    size = 24 * math.pi * beta**2 / d**4
    for angle in (0.0, 0.4, MAGIC, math.pi / 2):
        radial, angular = pair_force(d, ratio, angle)
        c, s = math.cos(angle), math.sin(angle)
        # The next order is β(a/d)³, 5e-6.
        assert radial == pytest.approx(-0.5 * size * (3 * c**2 - 1), abs=2e-5 * size)
        assert angular == pytest.approx(-size * c * s, abs=2e-5 * size)


def test_the_radial_force_vanishes_at_the_magic_angle_when_far_apart():
    """tan²θ = −F_∥/F_⊥; nearer, the attraction reaches further round."""
    angles = []
    for d in (2.5, 3.0, 4.0, 8.0, 40.0):
        along, across = (pair_force(d, 10, angle)[0] for angle in (0.0, math.pi / 2))
        angles.append(math.degrees(math.atan(math.sqrt(-along / across))))
    assert np.all(np.diff(angles) < 0)
    assert angles[-1] == pytest.approx(54.7356, abs=1e-3)


@pytest.mark.parametrize("direction", DIRECTIONS)
@pytest.mark.parametrize("ratio", [0.1, 10.0, math.inf])
def test_the_slope_of_the_dipole_is_its_derivative(direction, ratio):
    step = 1e-4
    for d in (2.3, 3.0):
        ends = [pair_dipole(d + side, ratio, direction)[0] for side in (-step, step)]
        # Truncation of the difference, step² times the third derivative.
        slope = (ends[1] - ends[0]) / (2 * step)
        assert slope == pytest.approx(pair_dipole(d, ratio, direction)[1], rel=1e-5)


def test_no_contrast_no_force():
    assert pair_dipole(2.5, 1.0) == (0.0, 0.0)
    assert pair_force(2.5, 1.0, 0.3) == (0.0, 0.0)


@pytest.mark.parametrize(("distance", "direction"), MOBILITIES)
def test_mobilities(distance, direction):
    found = [pair_mobility(distance, direction, opposite) for opposite in (False, True)]
    assert found == pytest.approx(MOBILITIES[distance, direction], abs=6e-7)


@pytest.mark.parametrize("distance", [2.02, 2.2, 3.0, 10.0])
def test_along_the_line_against_bipolar_series(distance):
    """Stimson & Jeffery (1926) for equal velocities, Brenner (1961) for opposite ones."""
    alpha = math.acosh(distance / 2)
    n = np.arange(1.0, 40 / alpha + 10)
    weight = 4 / 3 * math.sinh(alpha) * n * (n + 1) / ((2 * n - 1) * (2 * n + 3))
    high, low = (2 * n + 1) * alpha, (2 * n + 1) * math.sinh(2 * alpha)
    edge = ((2 * n + 1) * math.sinh(alpha)) ** 2
    equal = weight * (1 - (4 * np.sinh(high / 2) ** 2 - edge) / (2 * np.sinh(high) + low))
    parting = weight * ((4 * np.cosh(high / 2) ** 2 + edge) / (2 * np.sinh(high) - low) - 1)
    # Round-off of the least squares.
    assert pair_mobility(distance) == pytest.approx(1 / equal.sum(), rel=1e-10)
    assert pair_mobility(distance, opposite=True) == pytest.approx(1 / parting.sum(), rel=1e-9)


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_far_apart_mobilities_are_those_of_rotne_and_prager(direction):
    d = 40.0
    cross = 1.5 / d - 1 / d**3 if direction == "along" else 0.75 / d + 0.5 / d**3
    for opposite, sign in ((False, 1), (True, -1)):
        # The next order: −15/4 (a/d)⁴ along, 1.5e-6.
        assert pair_mobility(d, direction, opposite) == pytest.approx(1 + sign * cross, abs=2e-6)


def test_the_approach_from_four_to_two_and_a_half_radii():
    times, distances = approach(4.0, 2.5, lambda d: pair_force(d, 10)[0], free_mobility)
    assert times[-1] == pytest.approx(66.572, abs=6e-4)
    assert (distances[0], distances[-1]) == (4.0, 2.5)
    slowed = approach(4.0, 2.5, lambda d: pair_force(d, 10)[0], lambda d: 0.5 * free_mobility(d))
    assert slowed[0][-1] == pytest.approx(2 * times[-1], rel=1e-6)


def test_image_sums_against_lorentz_and_hasimoto():
    """A cubic lattice's own field is p/3V; a point force is slowed by 2.837297/(6πL)."""
    side = 7.0
    # Both dipoles at one place: twice that.
    assert image_field(1e-3, side) == pytest.approx(2 / (3 * side**3), rel=1e-5)
    assert image_flow(0.0, side) == pytest.approx(-2.837297 / (6 * math.pi * side), rel=3e-7)
    assert image_flow(1e-4, side) == pytest.approx(image_flow(0.0, side), rel=1e-7)
    # By halves of the cube's side the sums know that they are periodic.
    ahead, behind = (image_flow(side / 2 + s, side) + 1 / (4 * math.pi * (side / 2 + s))
                     for s in (1.0, -1.0))  # fmt: skip
    assert ahead == pytest.approx(behind, rel=1e-12)


@pytest.mark.parametrize(("ratio", "gap"), IN_A_CUBE)
def test_pair_in_a_periodic_cube(ratio, gap):
    # Images as uniform fields: see the head of `pair_images`. Without them it is 1 to 10 % off.
    known = IN_A_CUBE[ratio, gap]
    assert periodic_pair_force(2 + gap, ratio, 8.0) == pytest.approx(known, rel=3.5e-3)


def test_far_images_do_nothing():
    # Of order (a/L)³.
    assert periodic_pair_force(3.0, 10, 1e3) == pytest.approx(pair_force(3.0, 10)[0], rel=1e-6)
    assert periodic_pair_mobility(3.0, 1e3) == pytest.approx(free_mobility(3.0), rel=1e-6)


def test_what_cannot_be_is_refused():
    for distance in (1.9, 2.0, 2.001, math.nan, math.inf):
        with pytest.raises(ValueError, match="the centres are"):
            pair_dipole(distance, 10)
        with pytest.raises(ValueError, match="the centres are"):
            pair_mobility(distance)
    for ratio in (0.0, -1.0, math.nan):
        with pytest.raises(ValueError, match="ratio of permittivities"):
            pair_dipole(3.0, ratio)
    with pytest.raises(ValueError, match="must be one of along, across"):
        pair_mobility(3.0, "around")
