"""Reduced problems against closed forms, and against a second, plainer discretisation."""

import math

import numpy as np
import pytest
import scipy.sparse as sparse
from scipy.sparse.linalg import spsolve
from scipy.special import iv, ivp

from smoothprofile.profiles import PROFILES
from smoothprofile.theory import radial, sharp
from smoothprofile.theory.collocation import gauss_stages, solve_linear
from smoothprofile.theory.elements import radial_edges
from smoothprofile.theory.planar import planar_shift, tanh_shift

WALL = 8.0


def test_gauss_stages_integrate_polynomials():
    nodes, a, b = gauss_stages(8)
    powers = np.arange(8)
    # Round-off of sums of eight terms.
    np.testing.assert_allclose(
        a @ nodes[:, None] ** powers, nodes[:, None] ** (powers + 1) / (powers + 1), atol=1e-15
    )
    for power in range(16):
        assert b @ nodes**power == pytest.approx(1 / (power + 1), abs=1e-15)


def test_a_boundary_layer_to_round_off():
    # y'' = 400 y on [0, 1], y'(0) = 20 y(0): growth by e²⁰ = 5e8 on eight elements.
    def matrix(x):
        return np.broadcast_to(np.array([[0.0, 1.0], [400.0, 0.0]]), (x.size, 2, 2))

    edges = np.linspace(0, 1, 9)
    y = solve_linear(
        matrix, edges, np.array([[-20.0, 1]]), np.array([[1.0, 0]]), np.array([math.exp(20)])
    )
    # The [8/8] Padé approximant of e^{2.5} errs by (8!)²/(16! 17!)·2.5¹⁷ = 1.3e-12 eight times.
    np.testing.assert_allclose(y[:, 0], np.exp(20 * edges), rtol=2e-11)


@pytest.mark.parametrize("implicit", [1.0, 0.5])
@pytest.mark.parametrize("ratio", [0.1, 0.755, 2.0])
def test_closed_form_of_the_tanh_wall(ratio, implicit):
    def resistance(z):
        phi = PROFILES["tanh"].value(z)
        return phi / ((1 - (1 - implicit) * phi) * ratio**2)

    # χ is cut at |z| = 20, where it is e⁻⁴⁰/k² = 4e-16: what counts is the solver's 1e-11.
    numerical = planar_shift(resistance, -20.0, 20.0)
    assert tanh_shift(ratio, implicit) == pytest.approx(numerical, abs=2e-11)


def test_a_sharp_penalised_wall_retreats_by_the_brinkman_length():
    # φ = H(−z): W = e^{z/k} inside, so that s₀ = k. Polynomials of an exponential: 1e-13.
    assert planar_shift(lambda z: np.full_like(z, 1 / 0.3**2), -1.0, 0.0) == pytest.approx(
        0.3, abs=1e-13
    )


def test_the_thesis_couette_stress():
    # τ/τ₀ − 1 = h/(h + ξs₀) − 1 at h = 3, k = 0.75; the digits are all that was printed.
    for xi, error in ((0.05, 1.497e-4), (0.1, 2.995e-4)):
        assert 3 / (3 + xi * tanh_shift(0.75)) - 1 == pytest.approx(error, abs=6e-8)


def test_sharp_resistances_have_their_limits():
    # λ = 1e-9: Stokes' values, but for 9λ/4.
    assert sharp.sphere_drag(1, 1e9) == pytest.approx(6 * math.pi, rel=1e-8)
    assert sharp.sphere_torque(1, 1e9) == pytest.approx(8 * math.pi, rel=1e-8)
    assert sharp.cylinder_torque(1, 1e9) == pytest.approx(4 * math.pi, rel=1e-8)
    # A gap of 1e-3 is a film: the flux Ua sinθ through it takes a pressure of slope
    # 12Ua sinθ/ε³, and so a force 12π(a/ε)³, within O(ε).
    assert sharp.cylinder_drag(1, 1.001) == pytest.approx(12 * math.pi * 1e9, rel=5e-3)


@pytest.mark.parametrize(
    ("dimension", "exact"),
    [
        (3, {"drag": sharp.sphere_drag, "torque": sharp.sphere_torque}),
        (2, {"drag": sharp.cylinder_drag, "torque": sharp.cylinder_torque}),
    ],
)
def test_a_dense_sharp_body_is_solid(dimension, exact):
    # g = 1 and χ = 1/l² inside r < 1 only: a porous body, solid but for O(l) = 1e-4.
    edges = np.concatenate(
        (np.geomspace(1e-3, 0.9, 20), 1 - np.geomspace(0.1, 1e-5, 30)[1:], [1.0])
    )
    edges = np.concatenate((edges, np.geomspace(1.0, WALL, 12)[1:]))

    def resistance(r):
        return np.where(r < 1, 1e8, 0.0)

    drag = radial.penalised_drag(dimension, resistance, np.zeros_like, edges)
    torque = radial.penalised_torque(dimension, resistance, edges)
    assert drag == pytest.approx(exact["drag"](1, WALL), rel=4e-4)
    assert torque == pytest.approx(exact["torque"](1, WALL), rel=4e-4)


def test_drag_of_a_porous_sphere():
    # Brinkman's 6πa·2β²s/(2β²+3s), s = 1 − tanh β/β, far from the wall; with β = a/√k.
    beta, wall = 3.0, 1e4
    edges = np.concatenate((np.geomspace(1e-3, 1, 12), np.geomspace(1, wall, 25)[1:]))
    drag = radial.penalised_drag(3, lambda r: np.where(r < 1, beta**2, 0.0), np.zeros_like, edges)
    s = 1 - math.tanh(beta) / beta
    free = 12 * math.pi * beta**2 * s / (2 * beta**2 + 3 * s)
    # The wall's first reflection, 9/4 · F/(6πR); the next is in R⁻³.
    confined = 1 / (1 / free - 9 / 4 / (6 * math.pi * wall))
    assert drag == pytest.approx(confined, rel=1e-7)  # rounding in the stiff centre, 1e-9 here


@pytest.mark.parametrize("dimension", [2, 3])
def test_the_centre_may_be_left_out(dimension):
    # A porous shell, χ = 50 on ½ < r < 1. Inside it flow only the uniform and the parabolic
    # stream, which the conditions at the first edge admit exactly, wherever it stands.
    shell = np.concatenate((np.linspace(0.5, 1, 5), np.geomspace(1, WALL, 12)[1:]))

    def resistance(r):
        return np.where((r > 0.5) & (r < 1), 50.0, 0.0)

    drags = [
        radial.penalised_drag(
            dimension, resistance, np.zeros_like, np.concatenate((centre[:-1], shell))
        )
        for centre in (np.geomspace(0.4, 0.5, 3), np.geomspace(1e-3, 0.5, 15))
    ]
    assert drags[0] == pytest.approx(drags[1], rel=1e-9)  # the elements' own error


@pytest.mark.parametrize("dimension", [2, 3])
def test_torque_of_a_porous_body(dimension):
    # Inside A = r^{1−n/2} I_{n/2}(βr), outside αr + cr^{−m}; their A'/A agree at r = 1.
    beta, m, order = 3.0, dimension - 1, dimension / 2
    edges = np.concatenate((np.geomspace(1e-3, 1, 12), np.geomspace(1, WALL, 12)[1:]))
    torque = radial.penalised_torque(dimension, lambda r: np.where(r < 1, beta**2, 0.0), edges)
    q = 1 - order + beta * ivp(order, beta) / iv(order, beta)
    ratio = (1 - q) / (q + m)  # c/α
    per = 4 * math.pi if dimension == 2 else 8 * math.pi
    exact = -per * ratio / (1 + ratio * WALL**-dimension)
    # The centre is cut at 1e-3, where β²r² = 1e-5 is left out of a body 1e-3 in size.
    assert torque == pytest.approx(exact, rel=1e-9)


def finite_volume_drag(dimension, cells, surface, thickness, length):
    """Drag of the layer φ = ½(1 − tanh z), z = (r²−a²)/(2aξ), from (A, B, P) on staggered cells.

    Nothing is shared with the theory: no Q, no ℓ, drag as the sum of the impulses. z is even in
    r because the cusp of (r−a)/ξ at the centre would make this mesh first order.
    """
    m, h = dimension - 1, WALL / cells
    faces, centres = np.arange(cells + 1) * h, (np.arange(cells) + 0.5) * h
    inner, bulk = np.arange(1, cells), np.arange(cells)
    a, b, p = np.arange(cells + 1), cells + 1 + bulk, 2 * cells + 1 + bulk
    entries = []

    def add(rows, columns, values):
        entries.append(np.broadcast_arrays(rows, columns, values))

    def phi(r):
        return 0.5 * (1 - np.tanh((r * r - surface**2) / (2 * surface * thickness)))

    def fluid(r):
        return 0.5 * (1 + np.tanh((r * r - surface**2) / (2 * surface * thickness)))

    known = np.zeros(3 * cells + 1)
    add(0, a[0], 1.0), add(0, b[0], -1.0), add(cells, a[cells], 1.0)
    known[cells] = 1.0
    r, out, back = faces[inner], centres[inner] ** m, centres[inner - 1] ** m
    scale = 1 / (h * h * r**m)
    add(inner, a[inner + 1], out * scale), add(inner, a[inner - 1], back * scale)
    add(inner, a[inner], -(out + back) * scale - 2 * m / r**2 - phi(r) / length**2)
    add(inner, b[inner], m / r**2), add(inner, b[inner - 1], m / r**2)
    add(inner, p[inner], -1 / h), add(inner, p[inner - 1], 1 / h)
    r, out, back = centres, faces[1:] ** m, faces[:-1] ** m
    scale = 1 / (h * h * r**m)
    add(b[:-1], b[1:], (out * scale)[:-1]), add(b[1:], b[:-1], (back * scale)[1:])
    at_wall = np.where(bulk == cells - 1, 1.0, 0.0)  # B = 1 half a cell out: a mirrored ghost
    known[b] -= 2 * at_wall * out * scale
    add(b, b, -((1 + at_wall) * out + back) * scale - 2 / r**2 - phi(r) / length**2)
    add(b, a[:-1], 1 / r**2), add(b, a[1:], 1 / r**2), add(b, p, -1 / r)
    add(p, a[1:], out * fluid(faces[1:]) / h), add(p, a[:-1], -back * fluid(faces[:-1]) / h)
    add(p, b, -m * r ** (m - 1) * fluid(r))
    rows, columns, values = (np.concatenate([np.ravel(e[i]) for e in entries]) for i in range(3))
    matrix = sparse.csc_matrix((values, (rows, columns)), shape=(known.size, known.size))
    x = spsolve(matrix, known)
    stream = 0.5 * (x[a[1:]] + x[a[:-1]]) + m * x[b]
    return 2 * math.pi * m / dimension * h / length**2 * np.sum(phi(r) * stream * r**m)


@pytest.mark.parametrize("dimension", [2, 3])
def test_drag_against_finite_volumes(dimension):
    surface, thickness, length = 1.0, 0.3, 0.755 * 0.3
    tanh = PROFILES["tanh"]

    def z(r):
        return (r * r - surface**2) / (2 * surface * thickness)

    found = radial.penalised_drag(
        dimension,
        lambda r: tanh.value(z(r)) / length**2,
        lambda r: tanh.fluid_slope(z(r)) * r / (surface * thickness),
        radial_edges(surface, thickness, WALL, tanh.core, tanh.edge, True),
    )
    errors = [
        finite_volume_drag(dimension, cells, surface, thickness, length) / found - 1
        for cells in (400, 800, 1600)
    ]
    # Second order or better: the coarsest cells, h = ξ/15, err by (h/ξ)²/60 or less, and what
    # extrapolation leaves is their next term.
    assert abs(errors[0]) < 8e-5
    assert abs(errors[1]) < 0.3 * abs(errors[0])
    assert abs(4 * errors[2] - errors[1]) / 3 < 2e-6


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", ["quartic", "sine"])
def test_core_is_the_limit_of_a_vanishing_weight(dimension, name):
    # With g + ε for g the core is solenoidal, so p is harmonic in it, and nothing is singular:
    # the drag tends to that of `core_conditions`, linearly in ε.
    profile, thickness, length = PROFILES[name], 0.3, 0.06
    surface, small = 1.0, 1e-5
    resistance = _layer(profile, surface, thickness, length)
    edges = radial_edges(surface, thickness, WALL, profile.core, profile.edge, False)
    closed = radial.penalised_drag(
        dimension,
        resistance,
        lambda r: profile.fluid_slope((r - surface) / thickness) / thickness,
        edges,
        core=True,
    )
    rim = surface + profile.core * thickness
    near = math.sqrt(small) * thickness * 1.5 ** np.arange(-3, 14)
    near = near[near < 0.2 * thickness]
    whole = radial_edges(surface, thickness, WALL, profile.core, profile.edge, True)
    whole = np.unique(np.concatenate((whole, rim + near, rim - near)))

    def softened(r):
        z = (r - surface) / thickness
        return -profile.slope(z) / (1 - profile.value(z) + small) / thickness

    open_core = radial.penalised_drag(dimension, resistance, softened, whole)
    # The slope in ε is below 0.02.
    assert closed == pytest.approx(open_core, rel=1e-6)


def _layer(profile, surface, thickness, length):
    return lambda r: profile.value((r - surface) / thickness) / length**2


@pytest.mark.parametrize("core", [-np.inf, -0.5])
def test_elements_span_the_radius_and_know_the_kinks(core):
    edges = radial_edges(1.0, 0.1, WALL, core, -core, True)
    assert np.all(np.diff(edges) > 0)
    assert edges[0] < 2e-3
    assert edges[-1] == pytest.approx(WALL, abs=1e-14)
    if core == -0.5:
        rim = radial_edges(1.0, 0.1, WALL, core, -core, False)
        assert rim[0] == pytest.approx(0.95)
        for kink in (0.95, 1.05):
            assert np.abs(edges - kink).min() < 1e-15


def test_a_rational_value_of_the_shift():
    # k = ½: ψ(1) = −Γ, so s₀ = −½ exactly.
    assert tanh_shift(0.5) == pytest.approx(-0.5, abs=1e-15)
