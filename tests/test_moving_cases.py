"""The built-in cases of bodies that move, run in full: `pytest -m slow -s`."""

import numpy as np
import pytest

import smoothprofile as sp
from smoothprofile import cases
from smoothprofile.motion_numbers import motion_numbers, vectors

SETTLING = ("settling-sphere", "settling-sphere-e2", "settling-sphere-e3", "settling-sphere-e4")
QUANTITIES = ("position", "velocity", "angular_velocity")


def histories(name, **changes):
    """Body name to columns, as a run directory keeps them, of the case run to its end."""
    sp.threads.set_thread_count(2)
    run = sp.Simulation.from_file(name, changes)
    rows = {body["name"]: [] for body in run.particles}

    def record(run):
        for body in run.particles:
            parts = [body[q] for q in QUANTITIES]
            rows[body["name"]].append([run.time, *np.concatenate(parts), *body["orientation"]])

    record(run)
    run.run(record)
    heads = ["time", *(f"{q}_{axis}" for q in QUANTITIES for axis in "xyz")]
    heads += [f"orientation_{part}" for part in "wxyz"]
    return {
        body: dict(zip(heads, np.array(values).T, strict=True)) for body, values in rows.items()
    }


@pytest.mark.parametrize("name", SETTLING)
def test_settling_cases_are_read(name):
    """One experiment each: the sphere is heavier than its oil and starts 120 mm above the floor."""
    case = sp.load_case(name)
    (body,) = case.particles
    assert case.fluid.density < body.density == 1120.0
    assert body.position[2] - body.radius == pytest.approx(0.12)
    assert cases.reference(name)["peak_speed"] > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", SETTLING)
def test_a_settling_sphere_reaches_its_peak(name):
    """Within 1.5 % of the quasi-steady speed, and not above by more than half a per cent."""
    found = motion_numbers(histories(name))["peak_speed"] / cases.reference(name)["peak_speed"]
    print(f"\n{name}: {100 * (found - 1):+.2f} %")
    assert -0.015 < found - 1 < 0.005


@pytest.mark.slow
def test_a_sphere_in_shear_turns_at_half_its_rate():
    found = motion_numbers(histories("sphere-in-shear"))["angular_velocity"]
    print(f"\nΩ/γ̇ = {-found / 0.1:.4f}")
    # Re = .1, walls 20a apart, images 14a: less than 2 %.
    assert found == pytest.approx(-0.05, rel=0.02)


@pytest.mark.slow
def test_an_ellipsoid_in_shear_follows_jeffery():
    found = motion_numbers(histories("ellipsoid-in-shear"))["half_period"]
    print(f"\nhalf a period: {found:.4f}, {100 * (found / 7.853982 - 1):+.2f} %")
    assert found == pytest.approx(7.853982, rel=0.03)


@pytest.mark.slow
def test_a_pair_drafts_kisses_and_tumbles():
    bodies = histories("drafting-pair")
    leader, follower = (vectors(bodies[n], "position") for n in ("leader", "follower"))
    line = follower - leader
    apart = np.linalg.norm(line, axis=0)
    kiss = int(np.argmax(apart < 2.2))
    tumble = int(np.argmax(line[2] < 0.0))
    assert 0 < kiss < tumble
    # Drafting: the follower is the faster all the way. Kissing: they stay together for a while.
    falls = [vectors(bodies[n], "velocity")[2] for n in ("leader", "follower")]
    assert np.all((falls[1] < falls[0])[kiss // 2 : kiss])
    assert np.count_nonzero(apart < 2.2) * (bodies["leader"]["time"][1]) > 10.0
    # They part after they have turned over, and never overlap.
    assert apart[-1] > 3.0
    assert apart.min() > 2.0
    print(f"\nleast distance {apart.min():.3f}a")


@pytest.mark.slow
def test_spheres_in_a_channel_gather_off_the_middle():
    """From both sides to one distance, near half way to the wall for a sphere a quarter as wide."""
    bodies = histories("inertial-migration")
    ends = [abs(columns["position_y"][-1]) / 4.0 for columns in bodies.values()]
    print(f"\nat {ends} of the way")
    assert ends[0] == pytest.approx(ends[1], abs=0.03)
    assert 0.38 < min(ends) < max(ends) < 0.6


@pytest.mark.slow
def test_a_light_sphere_rises_as_in_unsteady_stokes_flow():
    (columns,) = histories("rising-sphere").values()
    known = cases.reference("rising-sphere")["speed"]
    found = np.interp(known["coordinate"], columns["time"], columns["velocity_z"])
    print(f"\nfrom the curve: {100 * (found / known['value'] - 1)} %")
    # From a²/2ν on; before it, the layer is as thick as what viscosity has reached.
    late = np.array(known["coordinate"]) >= 0.5
    assert found[late] == pytest.approx(np.array(known["value"])[late], rel=0.02)
    assert found == pytest.approx(known["value"], rel=0.04)
