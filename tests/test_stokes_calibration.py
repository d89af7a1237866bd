"""Painted radius and compliances of steady Stokes flow, against the sharp sphere's resistances."""

import math

import numpy as np
import pytest

from smoothprofile.calibration import stokes
from smoothprofile.errors import CaseError
from smoothprofile.shapes import sphere
from smoothprofile.theory import planar, radial, sharp, straining
from smoothprofile.theory.grid_layer import grid_shift
from smoothprofile.viscous.around import stokes_around
from stokes_scenes import at, box

LAYERS = [("sine", 0.2, 0.04), ("tanh", 0.05, 0.0375), ("quartic-centred", 0.3, 0.06)]


def unclipped(xi, ell, profile):
    """The sphere of radius one, and whether its compliance is the one that Faxén's law wants."""
    found = stokes.stokes_sphere(1.0, xi, ell, profile=profile)
    most = stokes.SHARE * stokes.layer_yield(found.radius, xi, ell, profile)[0]
    return found, found.translation > -0.999 * most


@pytest.mark.parametrize(("profile", "xi", "ell"), LAYERS)
def test_drag_in_walls_of_any_width(profile, xi, ell):
    found, free = unclipped(xi, ell, profile)
    for wall in (16.0, 6.0, 3.0, 2.0):
        drag = stokes._drag(found.radius, xi, ell, profile, wall)
        exact = sharp.sphere_drag(1.0, wall)
        got = 1.0 / (1.0 / drag + found.translation)
        # Exact at 16 by construction and at 3 where the compliance is not cut short; between and
        # below, what is left are higher multipoles, of order ξ².
        if wall == 16.0 or (wall == 3.0 and free):
            assert got == pytest.approx(exact, rel=1e-8)
        elif free:
            assert got == pytest.approx(exact, rel=2e-3)
        # With the right drag in the wide wall alone, the narrow one is 2 % off.
        plain = stokes.translation_radius(1.0, xi, ell, profile)
        if wall == 2.0:
            other = stokes._drag(plain, xi, ell, profile, wall)
            assert abs(other / exact - 1.0) > 2.0 * abs(got / exact - 1.0)


@pytest.mark.parametrize(("profile", "xi", "ell"), LAYERS)
def test_torque_and_stresslet_of_a_lone_sphere(profile, xi, ell):
    found, _ = unclipped(xi, ell, profile)
    chi, edges = stokes._problem(found.radius, xi, ell, profile, 16.0)
    torque = radial.penalised_torque(3, chi, edges)
    stresslet = straining.penalised_stresslet(chi, np.zeros_like, edges)
    got = 1.0 / (1.0 / torque + found.rotation), 1.0 / (1.0 / stresslet + found.straining)
    exact = sharp.sphere_torque(1.0, 16.0), sharp.sphere_stresslet(1.0, 16.0)
    assert got == pytest.approx(exact, rel=1e-9)
    # And are not without.
    assert abs(torque / exact[0] - 1.0) > 1e-3
    assert abs(stresslet / exact[1] - 1.0) > 1e-2


@pytest.mark.parametrize("ratio", [0.1, 0.5])
@pytest.mark.parametrize("profile", ["sine", "tanh"])
def test_compliances_never_exceed_what_the_layer_gives(profile, ratio):
    """∫φ|r|² and ∫φ of the layer's own bound them, so that the problem stays definite."""
    for xi in (0.05, 0.3):
        ell = ratio * xi
        found = stokes.stokes_sphere(1.0, xi, ell, profile=profile)
        moving, deforming = stokes.layer_yield(found.radius, xi, ell, profile)
        # Met to the root's own 1e-10.
        most = stokes.SHARE * (1.0 + 1e-8)
        assert found.translation >= -most * moving
        assert found.rotation >= -most * 0.5 * deforming
        assert found.straining >= -most * deforming
        drag = stokes._drag(found.radius, xi, ell, profile, 16.0)
        exact = sharp.sphere_drag(1.0, 16.0)
        assert 1.0 / (1.0 / drag + found.translation) == pytest.approx(exact, rel=1e-8)


def test_a_layer_yields_by_its_own_volume():
    # Of a hard sphere ℓ²/V and 5ℓ²/(Va²).
    volume = 4.0 / 3.0 * math.pi
    hard = stokes.layer_yield(1.0, 1e-6, 0.1, "sine")
    assert hard == pytest.approx((0.01 / volume, 0.05 / volume), rel=1e-4)
    # tanh: ∫φ dV = V(1 + (πξ/2a)²), but for its tails beyond 4ξ, 2e-3 of that.
    moving, _ = stokes.layer_yield(1.0, 0.2, 0.1, "tanh")
    assert moving == pytest.approx(0.01 / (volume * (1.0 + (0.1 * math.pi) ** 2)), rel=5e-3)


@pytest.mark.parametrize(
    ("profile", "thickness"), [("tanh", 0.4), ("tanh", 0.2), ("sine", 0.2), ("sine", 0.8)]
)
def test_held_spheres_that_almost_touch_keep_the_problem_definite(profile, thickness):
    """What compliances take back is bounded by what the layers give on this very grid."""
    side, cells = (16.0 * math.pi / 3.0 / 0.7) ** (1.0 / 3.0), 12
    grid = box([side] * 3, [cells] * 3)
    stokes = stokes_around(grid, [sphere(1.0)] * 4, 1.0, profile=profile, thickness=thickness)
    places = np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]])
    found = stokes.resistance(at(side * (places + 0.1)), [1.0, 0.0, 0.0], 0.0)
    # Face-centred cubic, c = .7 of at most .74. With a bound by 4πa³/3 in place of ∫φ dV the first
    # of these has no solution.
    assert found.report.converged
    assert -found.force[:, 0].min() > 6.0 * math.pi
    layers = stokes.bodies
    given = 1.0 / (layers.cell * layers.totals.max())
    # A coarse grid's ∫φ dV changes with the place of a sphere by a few per cent, .05 is left.
    assert layers.compliance[:, 0].min() > -given


def test_the_flat_wall_is_that_of_theory():
    # tanh is cut at z = 4, where W = z: the wall moves by ∫χz²dz of what is cut, χ = e^{−2z}/ℓ².
    cut = math.exp(-8.0) * (8.0 + 2.0 + 0.25) / 0.75**2
    flat = planar.tanh_shift(0.75) + cut
    assert stokes.stokes_shift("tanh", 1.0, 0.75) == pytest.approx(flat, abs=1e-4)
    # A step of resistance 1/ℓ² acts ℓ behind itself; sine is a thin layer beside a large ℓ.
    assert stokes.stokes_shift("sine", 0.01, 1.0) == pytest.approx(1.0, rel=1e-3)


def test_the_part_of_the_grid_is_of_second_order():
    def wall(z):
        return 4.0 * np.clip(0.5 - 0.5 * np.sin(math.pi * np.clip(z, -0.5, 0.5)), 0.0, 1.0)

    shifts = [grid_shift(wall, h, -0.5, 0.5) for h in (0.4, 0.2, 0.1)]
    orders = np.log2(np.array(shifts[:-1]) / shifts[1:])
    assert orders == pytest.approx([2.0, 2.0], abs=0.1)
    assert grid_shift(wall, 0.0, -0.5, 0.5) == 0.0
    # The layer of a grid is the thicker one, so that the wall retreats.
    assert min(shifts) > 0.0


def test_radii_scale_with_the_sphere():
    small = stokes.stokes_sphere(1.0, 0.2, 0.04, 0.08)
    large = stokes.stokes_sphere(2.0, 0.4, 0.08, 0.16)
    assert large.radius == pytest.approx(2.0 * small.radius)
    assert large.translation == pytest.approx(small.translation / 2.0)
    assert large.rotation == pytest.approx(small.rotation / 8.0)
    assert large.straining == pytest.approx(small.straining / 8.0)


def test_a_thick_layer_is_refused():
    with pytest.raises(CaseError, match=r"profile\.thickness is 0\.9"):
        stokes.stokes_sphere(1.0, 0.9, 0.1)
    with pytest.raises(CaseError, match=r"profile\.kind is 'cosine'"):
        stokes.stokes_profile("cosine")
