import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from smoothprofile import rotations
from smoothprofile.errors import CaseError

# A few products of numbers of order one: some units of round-off.
ROUND_OFF = 1e-14


@pytest.fixture
def rng():
    return np.random.default_rng(7)


def scipy_rotation(quaternion):
    return Rotation.from_quat(np.roll(quaternion, -1, axis=-1))


def test_axis_and_angle_agree_with_scipy(rng):
    axes, angles = rng.normal(size=(20, 3)), rng.uniform(-6.0, 6.0, 20)
    units = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    ours = rotations.matrix(rotations.from_axis_angle(axes, angles))
    theirs = Rotation.from_rotvec(units * angles[:, None]).as_matrix()
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=ROUND_OFF)


def test_a_quarter_turn_about_z_takes_x_to_y():
    quarter = rotations.from_axis_angle((0, 0, 2), np.pi / 2)
    np.testing.assert_allclose(
        rotations.rotate(quarter, (1, 0, 0)), (0, 1, 0), rtol=0, atol=ROUND_OFF
    )


def test_one_axis_serves_many_angles():
    angles = np.linspace(0.0, 1.0, 5)
    assert rotations.from_axis_angle((0, 0, 1), angles).shape == (5, 4)


def test_matrix_and_rotate_agree_with_scipy(rng):
    q = rotations.normalise(rng.normal(size=(20, 4)))
    v = rng.normal(size=(20, 3))
    np.testing.assert_allclose(
        rotations.matrix(q), scipy_rotation(q).as_matrix(), rtol=0, atol=ROUND_OFF
    )
    np.testing.assert_allclose(
        rotations.rotate(q, v), scipy_rotation(q).apply(v), rtol=0, atol=ROUND_OFF
    )


def test_one_quaternion_rotates_many_vectors(rng):
    q, v = rotations.normalise(rng.normal(size=4)), rng.normal(size=(4, 5, 3))
    np.testing.assert_allclose(
        rotations.rotate(q, v), v @ rotations.matrix(q).T, rtol=0, atol=ROUND_OFF
    )


def test_a_product_turns_by_its_right_factor_first(rng):
    p, q = rotations.normalise(rng.normal(size=(2, 4)))
    product = rotations.multiply(p, q)
    expected = (scipy_rotation(p) * scipy_rotation(q)).as_matrix()
    np.testing.assert_allclose(rotations.matrix(product), expected, rtol=0, atol=ROUND_OFF)


def test_the_conjugate_turns_back(rng):
    q = rotations.normalise(rng.normal(size=(6, 4)))
    product = rotations.multiply(rotations.conjugate(q), q)
    np.testing.assert_allclose(product, np.tile([1.0, 0, 0, 0], (6, 1)), rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("scale", [1e-200, 1.0, 1e200])
def test_normalise_keeps_the_direction_at_any_size(scale):
    unit = rotations.normalise(scale * np.array([1.0, -2.0, 2.0, 4.0]))
    np.testing.assert_allclose(unit, np.array([1.0, -2.0, 2.0, 4.0]) / 5.0, rtol=ROUND_OFF)


# From parallel through nearly opposite to opposite: angles between the two directions.
@pytest.mark.parametrize("gap", [0.0, 1e-9, 1e-5, 1.4e-3, 1.5e-3, 0.1, 1.0, np.pi])
def test_two_vectors_give_the_rotation_between_them(gap, rng):
    for start in (*np.eye(3), *-np.eye(3), *rng.normal(size=(5, 3))):
        normal = rotations.rotate(rotations.from_axis_angle(start, 1.0), np.cross(start, [1, 2, 3]))
        turn = rotations.from_axis_angle(normal, np.pi - gap)
        end = 3.0 * rotations.rotate(turn, start)
        q = rotations.from_two_vectors(start, end)
        turned = rotations.rotate(q, start) / np.linalg.norm(start)
        # 1 + a·b keeps ten digits where it is smallest, beside a × b a thousand times larger.
        np.testing.assert_allclose(turned, end / np.linalg.norm(end), rtol=0, atol=1e-12)
        # Close to opposite directions the axis is free by the gap itself.
        assert 2 * np.arccos(abs(q[0])) == pytest.approx(np.pi - gap, abs=2e-3)


@pytest.mark.parametrize("bad", [(0, 0, 0), (np.nan, 0, 1), (np.inf, 0, 1), (1, 0)])
def test_a_useless_axis_is_refused(bad):
    with pytest.raises(CaseError, match="rotation axis is"):
        rotations.from_axis_angle(bad, 1.0)
    with pytest.raises(CaseError, match="direction is"):
        rotations.from_two_vectors((0, 0, 1), bad)


@pytest.mark.parametrize("bad", [(0, 0, 0, 0), (1, 0, 0, np.nan), (1, 0, 0)])
def test_a_useless_quaternion_is_refused(bad):
    with pytest.raises(CaseError, match="quaternion is"):
        rotations.normalise(bad)
