"""Smoothed dielectric spheres: radial problem, closed forms, forces, and where to paint them."""

import math
import time
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from smoothprofile.calibration import (
    dielectric_offset,
    dielectric_radius,
    dielectric_slope,
    effective_radius,
)
from smoothprofile.errors import CaseError
from smoothprofile.profiles import PROFILES
from smoothprofile.theory import dielectric, maxwell

SMOOTHINGS = pytest.mark.parametrize("smoothing", dielectric.SMOOTHINGS)
CENTRED = ("tanh", "quartic-centred", "sine")
# What a numerical solution of order 8 with these tolerances was seen to keep: 1e-12.
ODE = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14, "max_step": 0.02}


def about(profile, thickness, surface=1.0):
    value = PROFILES[profile].value
    return lambda r: value((np.asarray(r) - surface) / thickness)


def solved(degree, ratio, profile, thickness, smoothing, halved=False, **kwargs):
    ends = PROFILES[profile].core, PROFILES[profile].edge
    edges = dielectric.interface_edges(1.0, thickness, *ends, ratio)
    if halved:
        edges = np.sort(np.concatenate((edges, 0.5 * (edges[1:] + edges[:-1]))))
    indicator = about(profile, thickness)
    return dielectric.solve_multipole(degree, ratio, indicator, smoothing, edges, **kwargs)


@SMOOTHINGS
@pytest.mark.parametrize("profile", PROFILES)
def test_elements_are_fine_enough(profile, smoothing):
    for ratio in (1e-4, 0.01, 0.5, 1.0, 2.0, 100.0, 1e4):
        for degree in (1, 3):
            for thickness in (0.02, 0.3):
                arguments = (degree, ratio, profile, thickness, smoothing)
                once, twice = solved(*arguments), solved(*arguments, halved=True)
                # What the module promises; 2e-12 was the worst.
                assert once.effective_radius == pytest.approx(twice.effective_radius, rel=1e-11)


@SMOOTHINGS
@pytest.mark.parametrize("profile", ["tanh", "quartic"])
@pytest.mark.parametrize(("degree", "ratio"), [(1, 100.0), (2, 0.2), (3, 5.0)])
def test_the_equation_as_it_stands(profile, smoothing, degree, ratio):
    """(r²ε_nF')' = l(l+1)ε_tF marched outwards in F and D, the thesis' way."""
    l, phi = degree, about(profile, 0.1)
    first, last = 0.5, 2.0

    def permittivity(r):
        mean, series = 1 + (ratio - 1) * phi(r), 1 / (1 + (1 / ratio - 1) * phi(r))
        return {"arithmetic": (mean, mean), "harmonic": (series, series)}.get(
            smoothing, (series, mean)
        )

    def rates(r, y):
        normal, tangential = permittivity(r)
        return y[1] / normal, -2 * y[1] / r + l * (l + 1) * tangential * y[0] / r**2

    amplitude = (2 * l + 1) / (l * ratio + l + 1)
    start = [amplitude * first**l, ratio * l * amplitude * first ** (l - 1)]
    marched = solve_ivp(rates, (first, last), start, **ODE).y[:, -1]
    ends = PROFILES[profile].core, PROFILES[profile].edge
    edges = dielectric.interface_edges(1.0, 0.1, *ends, ratio, first, last)
    field = dielectric.solve_multipole(
        degree, ratio, phi, smoothing, edges, amplitude, inner_permittivity=ratio
    )
    # The accuracy of the march.
    assert (field.potential[-1], field.displacement[-1]) == pytest.approx(tuple(marched), rel=1e-10)
    slope = marched[1] / permittivity(last)[0]
    assert field.slope[-1] == pytest.approx(slope, rel=1e-10)
    external = ((l + 1) * marched[0] / last**l + marched[1] / last ** (l - 1)) / (2 * l + 1)
    induced = (marched[1] * last ** (l + 2) - l * marched[0] * last ** (l + 1)) / (2 * l + 1)
    assert (field.external, field.induced) == pytest.approx((external, induced), rel=1e-10)
    assert field.at(last) == (field.potential[-1], field.slope[-1])


@pytest.mark.parametrize("degree", [1, 2, 3])
def test_tensor_smoothing_as_one_equation_of_first_order(degree):
    """y' = φr^{2l}(2l+1 + C l(l+1)/(2l+1)(1 − y/r^{2l+1})²), y = a_eff^{2l+1}."""
    l, ratio = degree, 20.0
    for profile in PROFILES:
        phi, contrast = about(profile, 0.1), (ratio - 1) ** 2 / ratio

        def rate(r, y, phi=phi, contrast=contrast):
            short = 1 - y / r ** (2 * l + 1)
            spread = contrast * l * (l + 1) / (2 * l + 1)
            return phi(r) * r ** (2 * l) * (2 * l + 1 + spread * short**2)

        # From 0.05, where tanh has φ = 1 − 6e-9, and y < 1e-3 to begin with.
        marched = solve_ivp(rate, (0.05, 3.5), [0.05 ** (2 * l + 1)], **ODE).y[0, -1]
        found = effective_radius(1, 0.1, ratio, profile, "tensor", l) ** (2 * l + 1)
        assert found == pytest.approx(marched, rel=1e-10)
        # C, and with it the radius, is the same for 1/R: round-off.
        inverse = effective_radius(1, 0.1, 1 / ratio, profile, "tensor", l)
        assert inverse ** (2 * l + 1) == pytest.approx(found, rel=1e-12)


@SMOOTHINGS
def test_a_sphere_of_no_contrast_has_its_volume(smoothing):
    for profile in PROFILES:
        phi = about(profile, 0.1)
        grid = np.linspace(0, 4, 400001)
        for degree in (1, 2):
            moment = np.trapezoid((2 * degree + 1) * phi(grid) * grid ** (2 * degree), grid)
            # The trapezoidal rule with steps of 1e-4 ξ across kinks of φ'': 1e-9.
            expected = pytest.approx(moment ** (1 / (2 * degree + 1)), rel=2e-9)
            assert effective_radius(1, 0.1, 1.0, profile, smoothing, degree) == expected
            # Regular there: R − 1 = 1e-9 changes nothing beyond.
            near = effective_radius(1, 0.1, 1 + 1e-9, profile, smoothing, degree)
            assert near == expected


@pytest.mark.parametrize(("degree", "ratio"), [(1, 3.0), (2, 0.1), (4, 50.0)])
def test_a_sharp_ball(degree, ratio):
    l, factor = degree, dielectric.sharp_factor(degree, ratio)
    assert dielectric.sharp_factor(1, ratio) == pytest.approx((ratio - 1) / (ratio + 2))  # (4.5)
    assert dielectric.sharp_factor(2, ratio) == pytest.approx(
        2 * (ratio - 1) / (2 * ratio + 3)
    )  # (4.18)
    below, above = np.array([1.5 - 1e-12]), np.array([1.5])
    inner = dielectric.sharp_field(l, ratio, 1.5, below)
    outer = dielectric.sharp_field(l, ratio, 1.5, above)
    # F and D are continuous: what 1e-12 of r changes.
    np.testing.assert_allclose(inner, outer, rtol=1e-10)
    # An indicator that jumps at an edge is the sharp ball, and the elements solve it exactly:
    # powers of r, to the accuracy of their sixteenth order on the elements' widths, 1e-12.
    edges = np.concatenate((np.geomspace(0.05, 1.5, 16), np.geomspace(1.5, 3, 8)[1:]))
    ball = dielectric.solve_multipole(
        l, ratio, lambda r: np.where(r < 1.5, 1.0, 0.0), "tensor", edges
    )
    assert ball.effective_radius == pytest.approx(1.5, rel=1e-12)
    assert (ball.external, ball.induced) == pytest.approx((1.0, factor * 1.5 ** (2 * l + 1)))
    exact = dielectric.sharp_field(l, ratio, 1.5, edges)
    np.testing.assert_allclose((ball.potential, ball.displacement), exact, rtol=1e-11)


@pytest.mark.parametrize("ratio", [0.02, 0.5, 1.0, 2.0, 100.0])
def test_flat_offsets_of_tanh(ratio):
    tanh = PROFILES["tanh"]
    half = 0.5 * math.log(ratio)
    for smoothing, exact in (
        ("arithmetic", (half, 0.0)),
        ("harmonic", (0.0, -half)),
        ("tensor", (0.0, 0.0)),
    ):
        found = dielectric.flat_offsets(tanh.value, ratio, smoothing, tanh.core, tanh.edge)
        # Asked of the quadrature: 1e-13 a piece.
        assert found == pytest.approx(exact, abs=1e-12)


@pytest.mark.parametrize("ratio", [0.1, 2.0, 100.0])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_closed_slopes_of_tanh(degree, ratio):
    l = degree
    spread = math.log(ratio) / (2 * (l * ratio + l + 1))
    arithmetic = dielectric_slope(ratio, "tanh", "arithmetic", l)
    harmonic = dielectric_slope(ratio, "tanh", "harmonic", l)
    # Quadrature: 1e-13.
    assert arithmetic == pytest.approx(l * ratio * spread, abs=1e-12)
    assert harmonic == pytest.approx(-(l + 1) * spread, abs=1e-12)
    crossing = (l + 1) / l
    assert dielectric_slope(crossing, "tanh", "arithmetic", l) == pytest.approx(
        -dielectric_slope(crossing, "tanh", "harmonic", l), abs=1e-12
    )


@SMOOTHINGS
@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("degree", [1, 2])
def test_slopes_are_the_limits_of_the_radial_problem(profile, smoothing, degree):
    for ratio in (0.1, 10.0):
        slope = dielectric_slope(ratio, profile, smoothing, degree)
        found = [
            (effective_radius(1, xi, ratio, profile, smoothing, degree) - 1) / xi
            for xi in (4e-3, 2e-3, 1e-3, 5e-4)
        ]
        # ξ, ξ² and ξ³ taken out by halving; the next is some (5e-4)⁴·10³ for tanh.
        for power in (2, 4, 8):
            found = [(power * b - a) / (power - 1) for a, b in pairwise(found)]
        assert found[0] == pytest.approx(slope, abs=1e-8)


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize("ratio", [0.1, 10.0])
def test_second_order_of_the_tensor(profile, degree, ratio):
    known = PROFILES[profile]
    excess, _ = dielectric.flat_offsets(known.value, ratio, "tensor", known.core, known.edge)
    moment = dielectric.first_moment(known.value, excess, known.core, known.edge)
    if profile == "tanh":
        assert moment == pytest.approx(math.pi**2 / 24, abs=1e-12)  # quadrature
    found = [
        (effective_radius(1, xi, ratio, profile, "tensor", degree) - 1 - excess * xi) / xi**2
        for xi in (2e-3, 1e-3, 5e-4)
    ]
    # ξ and ξ² taken out by halving; the next is 300ξ³/8, and round-off of a_eff over ξ² 1e-9.
    found = [(2 * b - a) for a, b in pairwise(found)]
    assert (4 * found[1] - found[0]) / 3 == pytest.approx(2 * degree * moment, abs=1e-6)


@pytest.mark.parametrize("profile", CENTRED)
@pytest.mark.parametrize("degree", [1, 2, 3])
@pytest.mark.parametrize(
    ("smoothing", "order"), [("arithmetic", 1), ("harmonic", 1), ("tensor", 2)]
)
def test_orders(profile, degree, smoothing, order):
    thin, thick = (
        abs(effective_radius(1, xi, 10.0, profile, smoothing, degree) - 1) for xi in (1e-3, 2e-3)
    )
    # The next power of ξ is 2e-3 of the leading one, times up to 40 for harmonic quadrupoles.
    assert math.log2(thick / thin) == pytest.approx(order, abs=0.03)


def test_the_cylinder_has_the_same_offset_as_the_sphere():
    """(rε_nF')' = l²ε_tF/r with tensor smoothing: a_eff = a + (2l−1)m₁ξ²/a."""
    ratio, xi = 8.0, 0.02
    phi = about("sine", xi)

    def rates(r, y):
        return (
            y[1] * (1 + (1 / ratio - 1) * phi(r)) / r,
            (1 + (ratio - 1) * phi(r)) * y[0] / r,
        )

    ode = {**ODE, "max_step": xi / 10}
    potential, flux = solve_ivp(rates, (0.9, 1.1), [0.9, 0.9 * ratio], **ode).y[:, -1]
    induced = (flux - potential) / (flux + potential) * 1.1**2
    cylinder = math.sqrt(induced * (ratio + 1) / (ratio - 1))
    _, first = dielectric_offset(1.0, xi, ratio, "sine")
    # κ = 1; the next order is ξ/a of it.
    assert cylinder - 1 == pytest.approx(-first, rel=0.1)
    sine = PROFILES["sine"]
    moment = dielectric.first_moment(sine.value, 0.0, sine.core, sine.edge)
    assert -first == pytest.approx(moment * xi**2, rel=0.05)


@SMOOTHINGS
@pytest.mark.parametrize("profile", PROFILES)
def test_painted_radii_cancel_the_error(profile, smoothing):
    for ratio in (0.01, 0.5, 1.0, 2.0, 30.0):
        for degree in (1, 2):
            for thickness in (0.01, 0.1, 0.2):
                arguments = (thickness, ratio, profile, smoothing, degree)
                painted = dielectric_radius(1.0, *arguments)
                # Twice the tolerance of the search.
                assert effective_radius(painted, *arguments) == pytest.approx(1.0, abs=2e-11)


def test_radii_scale_with_the_sphere():
    small = dielectric_radius(1.0, 0.1, 5.0, "sine", "arithmetic")
    assert dielectric_radius(3.0, 0.3, 5.0, PROFILES["sine"], "arithmetic") == pytest.approx(
        3 * small, rel=1e-12
    )
    flat, first = dielectric_offset(3.0, 0.3, 5.0, "sine", "arithmetic")
    assert 3 + flat + first * 2 / 3 == pytest.approx(3 * small, rel=1e-12)
    assert flat == pytest.approx(-0.3 * dielectric_slope(5.0, "sine", "arithmetic"))


def test_flat_walls_of_tensor_smoothing_stay():
    for profile in CENTRED:
        # The excess of a centred profile, by quadrature.
        assert dielectric_offset(1.0, 0.1, 7.0, profile)[0] == pytest.approx(0.0, abs=1e-13)
    assert dielectric_offset(1.0, 0.1, 7.0, "quartic")[0] == pytest.approx(-0.1 / 30, abs=1e-13)


def test_a_radius_is_found_at_once():
    dielectric_radius(1.0, 0.09, 2.0)
    start = time.perf_counter()
    for ratio in (3.0, 4.0, 5.0, 6.0):
        dielectric_radius(1.0, 0.11, ratio)
    # Some 8 ms each on an idle core.
    assert time.perf_counter() - start < 4 * 0.05


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((0.0, 0.1, 2.0), "radius"),
        ((1.0, -0.1, 2.0), "thickness"),
        ((1.0, 0.1, 0.0), "permittivity_ratio"),
        ((1.0, 0.1, math.nan), "permittivity_ratio"),
        ((1.0, 0.9, 2.0), "at most 0.8"),
        ((1.0, 0.1, 2.0, "cubic"), "quartic-centred"),
        ((1.0, 1e-9, 2.0), "thickness is 1e-09"),
        ((1.0, 0.1, 1e10), "permittivity_ratio is 1e.10"),
        ((1.0, 0.1, 1e-10), "permittivity_ratio is 1e-10"),
        ((1.0, 0.1, 2.0, "tanh", "geometric"), "arithmetic, harmonic, tensor"),
        ((1.0, 0.1, 2.0, "tanh", "tensor", 0), "multipole"),
        ((1.0, 0.1, 2.0, "tanh", "tensor", 1.5), "multipole"),
    ],
)
def test_bad_input_is_refused(arguments, named):
    for function in (effective_radius, dielectric_radius):
        with pytest.raises(CaseError, match=named):
            function(*arguments)


def test_a_sphere_that_cannot_be_painted():
    with pytest.raises(CaseError, match="thinner"):
        dielectric_radius(1.0, 0.4, 1e4, "tanh", "arithmetic")


def test_weights_refuse_unknown_smoothings():
    with pytest.raises(ValueError, match="tensor"):
        dielectric.weights(PROFILES["tanh"].value, 2.0, "geometric")


def test_permittivities_are_the_means_they_say():
    phi, ratio = np.array([0.0, 0.25, 1.0]), 4.0
    normal, tangential = dielectric.permittivities(lambda x: x, ratio, "tensor")
    np.testing.assert_allclose(tangential(phi), [1, 1.75, 4])
    np.testing.assert_allclose(normal(phi), [1, 1 / (0.75 + 0.25 / 4), 4])
    for smoothing, mean in (("arithmetic", tangential), ("harmonic", normal)):
        for found in dielectric.permittivities(lambda x: x, ratio, smoothing):
            np.testing.assert_allclose(found(phi), mean(phi))


def test_stress_on_any_gauss_sphere():
    # A field without symmetry between its terms; (rF₁'−F₁)(rF₂'+3F₂) from their products alone.
    dipole, quadrupole = (0.7, -0.3), (1.9, 0.4)
    closed = maxwell.gauss_force(1.3, dipole, quadrupole, 2.5)
    # Smooth and periodic in θ but for |sin|: 2e-7 at 4000 intervals, a quarter at twice that.
    coarse, fine = (
        maxwell.stress_integral(1.3, dipole, quadrupole, n, 2.5) - closed for n in (4000, 8000)
    )
    assert abs(fine) < 1e-6 * abs(closed)
    assert coarse / fine == pytest.approx(4, rel=1e-3)


def test_force_on_a_sharp_sphere():
    ratio, external, gradient, radius = 2.0, 1.3, 0.7, 1.2
    k1, k2 = (dielectric.sharp_factor(l, ratio) for l in (1, 2))
    exact = maxwell.exact_force(external, gradient, k1, radius)
    assert exact == pytest.approx(8 * math.pi * 1.3 * 0.7 * 0.25 * 1.2**3)
    for r in (1.2, 2.0, 7.0):
        b1, b2 = external * k1 * radius**3, gradient * k2 * radius**5
        dipole = external * r - b1 / r**2, external + 2 * b1 / r**3
        quadrupole = gradient * r**2 - b2 / r**3, 2 * gradient * r + 3 * b2 / r**4
        # Round-off, whatever the sphere.
        assert maxwell.gauss_force(r, dipole, quadrupole) == pytest.approx(exact, rel=1e-13)


def test_the_thesis_trapezoid():
    # R = 2, E∞ = E_A2 = 1, α = 0.1, 500 intervals: 6.28299 against 2π, as printed.
    r, k1, k2 = 1.1, 1 / 4, 2 / 7
    dipole = r - k1 / r**2, 1 + 2 * k1 / r**3
    quadrupole = r**2 - k2 / r**3, 2 * r + 3 * k2 / r**4
    assert maxwell.stress_integral(r, dipole, quadrupole, 500) == pytest.approx(6.28299, abs=5e-6)
    assert maxwell.gauss_force(r, dipole, quadrupole) == pytest.approx(2 * math.pi, rel=1e-14)
