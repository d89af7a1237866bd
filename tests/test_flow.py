"""The flow solver against exact flows, with orders measured as slopes."""

import numpy as np
import pytest

from flows import box, make_flow, points, slope, start
from smoothprofile.errors import BlowUpError
from smoothprofile.flow.advection import advect, advection_spacings
from smoothprofile.flow.monitor import Extremes, watch
from smoothprofile.flow.state import fluid_at_rest
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import Grid, stretched_axis, uniform_axis

TWO_PI = 2 * np.pi
SCHEMES = {"backward-euler": 1, "crank-nicolson": 2, "bdf2": 2, "bdf3": 3}


def wavy(x, y, z):
    """x and y velocities of a flow whose advection is not a gradient, unlike Taylor–Green's."""
    return np.sin(x) * np.cos(y) + 0.5 * np.sin(2 * y) + 0.3 * np.cos(z) + 0 * x


def wavy_y(x, y, z):
    return -np.cos(x) * np.sin(y) + 0.4 * np.cos(x) + 0 * z


def wavy_z(x, y, z):
    return 0.2 * np.sin(x + 0 * y) + 0 * z


def run(flow, state, dt, end):
    for _ in range(round(end / dt)):
        flow.step(state, dt)
    return state


def taylor_green_error(n, dt, end, scheme, nu):
    grid = box((n, n, 2), (TWO_PI, TWO_PI, 1.0), (True, True, True))
    flow = make_flow(grid, scheme, viscosity=nu)
    state = start(
        flow,
        (
            lambda x, y, z: np.sin(x) * np.cos(y) + 0 * z,
            lambda x, y, z: -np.cos(x) * np.sin(y) + 0 * z,
            None,
        ),
    )
    run(flow, state, dt, end)
    x, y, z = points(grid, 0)
    exact = np.sin(x) * np.cos(y) * np.exp(-2 * nu * state.time) + 0 * z
    return np.sqrt(((state.velocity[0] - exact)[1:-1, 1:-1, 1:-1] ** 2).mean())


def test_space_order_of_taylor_green():
    sizes = (16, 24, 32)
    errors = [taylor_green_error(n, 0.005, 0.5, "bdf2", 0.1) for n in sizes]
    # Second-order stencils; Δt = .005 leaves a time error a thousand times smaller.
    assert slope([1 / n for n in sizes], errors) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_time_order_in_a_periodic_box(scheme):
    grid = box((12, 12, 12), (TWO_PI,) * 3, (True, True, True))

    def final(dt):
        flow = make_flow(grid, scheme, viscosity=0.2)
        state = run(flow, start(flow, (wavy, wavy_y, wavy_z)), dt, 0.8)
        return np.stack([c[1:-1, 1:-1, 1:-1] for c in state.velocity])

    steps = [0.04, 0.02, 0.01]
    fine = final(0.00125)
    errors = [np.abs(final(dt) - fine).max() for dt in steps]
    # The reference is 8 times finer than the finest: at first order it biases the slope by .1.
    expected, slack = SCHEMES[scheme], 0.15
    assert slope(steps, errors) == pytest.approx(expected, abs=slack)


def channel_exact(y, t, terms=60):
    """Start-up of plane Poiseuille flow between y = 0 and 1, g = 1, ν = 1."""
    steady = 0.5 * y * (1 - y)
    for m in range(terms):
        k = (2 * m + 1) * np.pi
        steady = steady - 4 / k**3 * np.sin(k * y) * np.exp(-(k**2) * t)
    return steady


def channel_error(n, dt, scheme, end=0.1):
    grid = box((2, n, 2), (1.0, 1.0, 1.0), (True, False, True))
    flow = make_flow(grid, scheme, body_force=(1.0, 0.0, 0.0))
    # From t = .02 on, for at t = 0 the shear at the walls is not smooth in time.
    state = start(flow, (lambda x, y, z: channel_exact(y, 0.02) + 0 * x + 0 * z, None, None))
    run(flow, state, dt, end)
    y = grid.axes[1].centres
    return np.abs(state.velocity[0][1, 1:-1, 1] - channel_exact(y, 0.02 + end)).max()


def test_channel_start_up_in_space():
    sizes = (8, 16, 32)
    errors = [channel_error(n, 0.0005, "bdf3") for n in sizes]
    assert slope([1 / n for n in sizes], errors) == pytest.approx(2.0, abs=0.1)


def duct_series(y, z, t, terms=20):
    """Start-up of flow in the square duct 0 ≤ y, z ≤ 1 under a unit force, ν = 1."""
    total = np.zeros(np.broadcast(y, z).shape)
    for m in range(1, 2 * terms, 2):
        for n in range(1, 2 * terms, 2):
            rate = np.pi**2 * (m * m + n * n)
            weight = 16 / (np.pi**2 * m * n * rate) * (1 - np.exp(-rate * t))
            total = total + weight * np.sin(m * np.pi * y) * np.sin(n * np.pi * z)
    return total


def test_duct_start_up_against_its_series():
    errors, sizes = [], (12, 24)
    for n in sizes:
        grid = box((2, n, n), (1.0, 1.0, 1.0), (True, False, False))
        flow = make_flow(grid, "bdf2", body_force=(1.0, 0.0, 0.0))
        state = run(flow, start(flow, (None, None, None)), 0.0005, 0.05)
        y, z = grid.axes[1].centres[:, None], grid.axes[2].centres[None, :]
        difference = state.velocity[0][1, 1:-1, 1:-1] - duct_series(y, z, 0.05)
        errors.append(np.sqrt((difference**2).mean()))
    assert slope([1 / n for n in sizes], errors) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_time_order_with_walls(scheme):
    """An oscillating lid over a closed box: the error against a finer Δt on the same grid."""
    grid = box((10, 10, 4), (1.0, 1.0, 1.0), (False, False, True))
    walls = Walls(velocity={"y_high": lambda t: (np.sin(2 * t) ** 2, 0.0, 0.0)})

    def final(dt):
        flow = make_flow(grid, scheme, walls=walls, viscosity=0.05)
        state = run(flow, start(flow, (None, None, None)), dt, 0.64)
        return np.stack([c[1:-1, 1:-1, 1:-1] for c in state.velocity])

    steps = [0.04, 0.02, 0.01]
    fine = final(0.00125)
    errors = [np.sqrt(((final(dt) - fine) ** 2).mean()) for dt in steps]
    # Splitting the pressure off limits any scheme to second order at walls.
    assert slope(steps, errors) >= min(SCHEMES[scheme], 2) - 0.15


def manufactured(grid, nu):
    """u = g S(x)S'(y), v = −g S'(x)S(y), S = sin²πx, p = g cos πx cos πy in a closed square.

    No-slip at all four walls, zero normal gradient of p there. Returns velocity(t), forcing(t).
    """
    pi = np.pi

    def shapes(x):
        return (
            np.sin(pi * x) ** 2,
            pi * np.sin(2 * pi * x),
            2 * pi**2 * np.cos(2 * pi * x),
            -4 * pi**3 * np.sin(2 * pi * x),
        )

    def parts(component, t):
        x, y, z = points(grid, component)
        g, dg = np.cos(2 * t), -2 * np.sin(2 * t)
        (s, s1, s2, s3), (r, r1, r2, r3) = shapes(x), shapes(y)
        u, v = g * s * r1, -g * s1 * r
        if component == 0:
            value, rate = u, dg * s * r1
            gradient = (g * s1 * r1, g * s * r2)
            laplacian = g * (s2 * r1 + s * r3)
            pressure = -pi * g * np.sin(pi * x) * np.cos(pi * y)
        else:
            value, rate = v, -dg * s1 * r
            gradient = (-g * s2 * r, -g * s1 * r1)
            laplacian = -g * (s3 * r + s1 * r2)
            pressure = -pi * g * np.cos(pi * x) * np.sin(pi * y)
        force = rate + u * gradient[0] + v * gradient[1] - nu * laplacian + pressure
        return value + 0 * z, force + 0 * z

    def velocity(t):
        return parts(0, t)[0], parts(1, t)[0], grid.zeros()

    def forcing(t):
        return parts(0, t)[1], parts(1, t)[1], grid.zeros()

    return velocity, forcing


def manufactured_error(n, dt, scheme, end, nu=0.1):
    grid = box((n, n, 2), (1.0, 1.0, 1.0), (False, False, True))
    velocity, forcing = manufactured(grid, nu)
    flow = make_flow(grid, scheme, viscosity=nu, forcing=forcing)
    state = start(flow, tuple(lambda x, y, z, f=f: f for f in velocity(0.0)))
    run(flow, state, dt, end)
    difference = state.velocity[0] - velocity(state.time)[0]
    return np.sqrt((difference[1:-1, 1:-1, 1:-1] ** 2).mean())


def test_space_order_of_a_manufactured_flow_between_walls():
    sizes = (16, 24, 32)
    errors = [manufactured_error(n, 0.002, "bdf2", 0.2) for n in sizes]
    assert slope([1 / n for n in sizes], errors) == pytest.approx(2.0, abs=0.1)


def test_wrong_forcing_would_be_seen():
    """The same flow with viscosity off by a tenth does not converge."""
    grid = box((16, 16, 2), (1.0, 1.0, 1.0), (False, False, True))
    velocity, forcing = manufactured(grid, 0.1)
    flow = make_flow(grid, "bdf2", viscosity=0.11, forcing=forcing)
    state = start(flow, tuple(lambda x, y, z, f=f: f for f in velocity(0.0)))
    run(flow, state, 0.002, 0.2)
    wrong = np.abs(state.velocity[0] - velocity(state.time)[0])[1:-1, 1:-1, 1:-1].max()
    assert wrong > 5 * manufactured_error(16, 0.002, "bdf2", 0.2)


def test_divergence_is_round_off():
    grid = Grid(
        (
            uniform_axis("x", 0.0, 2.0, 12, True),
            stretched_axis("y", 0.0, 1.0, 10, False, 0.0, 3.0),
            uniform_axis("z", 0.0, 1.0, 9, False),
        )
    )
    walls = Walls(
        (("wall", "wall"), ("wall", "slip"), ("slip", "wall")), {"z_high": lambda t: (1, 0, 0)}
    )
    flow = make_flow(grid, "bdf2", walls=walls, viscosity=0.05)
    state = start(flow, (wavy, wavy_y, wavy_z))
    for _ in range(5):
        flow.step(state, 0.01)
        assert flow.projection.largest_divergence(state.velocity) < 1e-12  # of speeds/widths ~10


@pytest.mark.parametrize("scheme", SCHEMES)
def test_walls_take_what_the_fluid_loses(scheme):
    """Momentum budget of each step: γ-weighted change = body force − walls, to round-off."""
    grid = box((8, 9, 10), (1.0, 1.3, 0.9), (True, False, False))
    walls = Walls(velocity={"y_high": lambda t: (1.0 + t, 0.0, 0.0)})
    force = (0.7, 0.0, 0.0)
    flow = make_flow(grid, scheme, walls=walls, viscosity=0.1, density=2.0, body_force=force)
    state = start(flow, (wavy, None, None))
    dt, momenta = 0.01, []

    def momentum():
        return 2.0 * flow.mean_flow.plain_mean(state.velocity[0], 0) * grid.volume

    momenta.append(momentum())
    for _ in range(4):
        used = flow.scheme(state)
        flow.step(state, dt)
        now = momentum()
        change = used.gamma * now - sum(
            a * m for a, m in zip(used.past, reversed(momenta), strict=False)
        )
        walls_take = sum(f[0] for f in flow.wall_force(state).values())
        assert change / dt == pytest.approx(force[0] * grid.volume - walls_take, rel=1e-10)
        momenta.append(now)


def test_mean_velocity_is_held_by_a_body_force():
    grid = box((4, 16, 4), (1.0, 1.0, 1.0), (True, False, True))
    flow = make_flow(grid, "bdf2", mean_velocity=(0.5, None, None))
    state = run(flow, start(flow, (None, None, None)), 0.01, 1.0)
    assert flow.mean_flow.plain_mean(state.velocity[0], 0) == pytest.approx(0.5, rel=1e-12)
    # Poiseuille: mean = g h²/(12ν); the discrete parabola is exact but for 1/(2n²) of its mean.
    assert flow.mean_flow.force[0] == pytest.approx(12 * 0.5, rel=3 / 16**2)


def test_free_slip_takes_no_shear():
    grid = box((4, 8, 4), (1.0, 1.0, 1.0), (True, False, True))
    flow = make_flow(grid, walls=Walls((("wall",) * 2, ("slip",) * 2, ("wall",) * 2)))
    state = start(flow, (lambda x, y, z: 0 * (x + y + z) + 1.0, None, None))
    run(flow, state, 0.1, 1.0)
    assert np.all(state.velocity[0][1:-1, 1:-1, 1:-1] == pytest.approx(1.0, abs=1e-14))
    assert all(np.allclose(f, 0, atol=1e-13) for f in flow.wall_force(state).values())


def test_advection_keeps_kinetic_energy_without_viscosity():
    grid = box((8, 9, 10), (1.0, 1.0, 1.0), (True, True, True))
    flow = make_flow(grid)
    rng = np.random.default_rng(3)
    state = start(flow, (None, None, None))
    for component in state.velocity:
        component[...] = rng.standard_normal(component.shape)
    flow.fill(state.velocity, 0.0)
    flow.projection.make_divergence_free(state.velocity)
    flow.fill(state.velocity, 0.0)
    out = tuple(grid.zeros() for _ in range(3))
    advect(state.velocity, out, advection_spacings(grid))
    inner = (slice(1, -1),) * 3
    work = sum((u[inner] * n[inner]).sum() for u, n in zip(state.velocity, out, strict=True))
    size = sum(np.abs(u[inner] * n[inner]).sum() for u, n in zip(state.velocity, out, strict=True))
    assert abs(work) < 1e-13 * size


def test_single_precision_runs_close_to_double():
    results = []
    for dtype in (np.float64, np.float32):
        grid = box((8, 8, 8), (TWO_PI,) * 3, (True, False, True), dtype)
        flow = make_flow(grid, viscosity=0.3)
        state = run(flow, start(flow, (wavy, None, None)), 0.05, 0.5)
        assert state.velocity[0].dtype == dtype
        results.append(state.velocity[0].astype(float))
    assert np.abs(results[0] - results[1]).max() < 2e-5  # float32 round-off over ten steps


def test_a_courant_number_that_exceeds_its_limit_is_shown_to_do_so():
    grid = Grid(tuple(uniform_axis(name, 0.0, 1.0, 4, True) for name in "xyz"))
    fast = Extremes(speed=(100.0004, 0.0, 0.0))
    with pytest.raises(BlowUpError, match=r"Courant number is 100\.0004 and may not exceed 100;"):
        watch(grid, fluid_at_rest(grid), fast, 0.25, True)
