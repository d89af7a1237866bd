"""Physical units in cases: what they become, what is refused, and no result depends on them."""

import itertools
import subprocess
import sys
import tomllib
from typing import get_args

import numpy as np
import pytest

import smoothprofile as sp
from case_makers import refusal, small_case, sphere
from smoothprofile.config import Case, load_case
from smoothprofile.config.dimensions import (
    DIMENSIONS,
    FIXED,
    VACUUM_PERMEABILITY,
    VACUUM_PERMITTIVITY,
)
from smoothprofile.config.refusals import _table_in

# Numbers without a dimension: counts, ratios, directions, fractions.
PURE = {
    *("domain.cells", "domain.stretching.ratio", "time.max_steps", "start.cells", "output.every"),
    *("electric.tolerance", "electric.max_iterations", "electric.every"),
    *("fluid.tolerance", "contact.restitution", "contact.friction", "particles.lattice.counts"),
    *("particles.axis", "particles.normal", "particles.orientation.axis"),
    *("particles.parts.axis", "particles.parts.orientation.axis"),
    *("particles.random.count", "particles.random.volume_fraction", "particles.random.seed"),
}


def numeric_keys(model, path=""):
    """Dotted keys of all fields that say that they hold numbers, with those of inner tables."""
    for name, field in model.model_fields.items():
        inner = _table_in(field.annotation)
        if inner is not None:
            yield from numeric_keys(inner, f"{path}{name}.")
        elif "number" in field.description and str not in get_args(field.annotation):
            yield f"{path}{name}"


def beads(step="0.1 us", cells=16):
    """Two oil-borne beads of 20 um along a field, 30 um from centre to centre."""
    bead = {"shape": "sphere", "radius": "10 um", "motion": "free", "density": "1.2 g/cm^3"}
    bead["permittivity"] = 27.0
    return {
        "domain": {
            "lengths": ["80 um"] * 3,
            "cells": [cells] * 3,
            "boundaries": ["periodic"] * 3,
        },
        "fluid": {"density": "0.97 g/cm^3", "viscosity": "50 mPa s"},
        "electric": {"field": [0, 0, "2 kV/mm"], "permittivity": 2.7},
        "profile": {"thickness": "5 um"},
        "particles": [
            {**bead, "position": ["41 um", "40 um", "25 um"]},
            {**bead, "position": ["40 um", "40 um", "55 um"]},
        ],
        "time": {"step": step, "end": "0.3 us", "scheme": "bdf2"},
    }


UNITS = {"length": "10 um", "time": "1 us", "density": "0.97 g/cm^3"}


def test_units_become_plain_numbers_of_the_case_s_own_units():
    si, own = load_case(beads()), load_case({**beads(), "units": UNITS})
    assert si.fluid.density == 970.0
    assert si.fluid.viscosity == 0.05
    assert si.domain.lengths == (8e-5, 8e-5, 8e-5)
    assert si.units.model_dump(exclude_none=True) == {
        "length": "1 m",
        "time": "1 s",
        "mass": "1 kg",
    }
    # √ε₀ E: its square is a pressure.
    assert si.electric.field[2] ** 2 == pytest.approx(VACUUM_PERMITTIVITY * 4e12, rel=1e-13)
    assert own.domain.lengths == (8.0, 8.0, 8.0)
    assert own.particles[0].position == (4.1, 4.0, 2.5)
    assert own.fluid.density == 1.0
    # Kinematic viscosity in L²/T: 0.05/970 m²/s · 1e-6 s/1e-10 m².
    assert own.fluid.viscosity == pytest.approx(0.05 / 970 * 1e4, rel=1e-13)
    pressure = 970 * (1e-5 / 1e-6) ** 2
    assert own.electric.field[2] ** 2 == pytest.approx(
        VACUUM_PERMITTIVITY * 4e12 / pressure, rel=1e-13
    )
    for case in (si, own):
        assert load_case(tomllib.loads(case.to_toml())) == case


@pytest.mark.parametrize(
    ("key", "text", "value"),
    [
        ("fluid.viscosity", "50mPa·s", 0.05),
        ("fluid.viscosity", ".05 Pa*s", 0.05),
        ("fluid.viscosity", "1 cP", 1e-3),
        ("fluid.density", "1.0e3 kg m^-3", 1000.0),
        ("fluid.density", "1000 kg/m³", 1000.0),
        ("time.end", "2 min", 120.0),
        ("time.steady_tolerance", "1e-3 1/s", 1e-3),
        ("time.steady_tolerance", "1e-3/s", 1e-3),
        ("time.steady_tolerance", "1e-3 s⁻¹", 1e-3),
        # The unit may be micro by either of its two letters.
        ("profile.thickness", "3 µm", 3e-6),
        ("profile.thickness", "3 μm", 3e-6),
        ("electric.angular_frequency", "50 rad/s", 50.0),
        # Hertz and rpm count turns, of 2π each.
        ("electric.angular_frequency", "50 Hz", 314.159265358979),
        ("electric.angular_frequency", "2 kHz", 12566.3706143592),
        ("electric.angular_frequency", "60 rpm", 6.28318530717959),
        ("electric.permittivity", f"{2.7 * VACUUM_PERMITTIVITY} F/m", 2.7),
        ("output.stop_after", "10 min", 600.0),
    ],
)
def test_a_quantity_in_si(key, text, value):
    case = load_case(beads(), {key: text})
    for part in key.split("."):
        case = getattr(case, part)
    # Fifteen digits are kept.
    assert case == pytest.approx(value, rel=2e-15)


def test_angles_and_wall_clock_alone_give_a_case_no_units():
    body = sphere(velocity={"amplitude": [1, 0, 0], "angular_frequency": 2, "phase": "90 deg"})
    case = small_case(body | {"orientation": {"axis": [0, 0, 1], "angle": "0.25 turn"}})
    loaded = load_case(case, {"output.stop_after": "1 h"})
    assert loaded.units is None
    assert loaded.output.stop_after == 3600.0
    assert loaded.particles[0].velocity.phase == pytest.approx(np.pi / 2, rel=1e-14)
    assert loaded.particles[0].orientation.angle == pytest.approx(90.0, rel=1e-14)


def test_sources_and_overrides_take_units():
    case = beads()
    source = {**case["particles"][0], "radius": {"mean": "10 um", "deviation": "1 um"}}
    del source["position"]
    case["particles"] = [source | {"random": {"count": 3, "seed": 1, "gap": "1 um"}}]
    loaded = load_case(case, ["fluid.viscosity=20 mPa s", "units.length=10 um"])
    assert loaded.fluid.viscosity == pytest.approx(0.02 * 1e-5, rel=1e-14)
    assert len(loaded.particles) == 3
    assert all(0.7 <= body.radius <= 1.3 for body in loaded.particles)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {"fluid.viscosity": "3 m"},
            'fluid.viscosity is "3 m"; it must be a dynamic viscosity such as "50 mPa s".',
        ),
        (
            {"electric.field": [0, 0, "2 kV"]},
            'electric.field.2 is "2 kV"; it must be an electric field such as "2 kV/mm".',
        ),
        (
            {"fluid.viscosity": "3 mPas"},
            'fluid.viscosity is "3 mPas"; it must be a dynamic viscosity such as "50 mPa s".',
        ),
        (
            {"fluid.viscosity": "3 foo"},
            'fluid.viscosity is "3 foo"; foo is no known unit; '
            'it must be a dynamic viscosity such as "50 mPa s".',
        ),
        (
            {"fluid.viscosity": 0.05},
            'fluid.viscosity is 0.05; because domain.lengths.0 is "80 um", it needs a unit too, '
            'such as "50 mPa s", or the case a table [units].',
        ),
        ({"units.length": "1 kg"}, 'units.length is "1 kg"; it must be a length such as "10 um".'),
        (
            {"units.length": "1e308 um"},
            'units.length is "1e308 um"; in SI it must be between 1e-30 and 1e+30.',
        ),
        ({"units.length": 3}, 'units.length is 3; it must be a length such as "10 um".'),
        ({"units.length": "um"}, 'units.length is "um"; it must be a length such as "10 um".'),
        ({"units.mass": "-1 kg"}, 'units.mass is "-1 kg"; it must be above 0.'),
        (
            {"units.mass": "1 kg", "units.density": "1 g/cm^3"},
            'units.density is "1 g/cm^3"; units.mass already says what 1 means.',
        ),
        ({"units.lenght": "1 m"}, "units.lenght is not a known key; the nearest is units.length."),
        ({"time.end": "soon"}, 'time.end is "soon"; it must be a finite number above 0.'),
        ({"fluid.density": "-1 g/cm^3"}, "fluid.density is -1000.0; it must be a finite"),
        ({"contact.friction": "3 m"}, 'contact.friction is "3 m"; it must be a finite number'),
        ({"particles.0.orientation": {"axis": [0, 0, 1], "angle": "3 %"}}, "it must be an angle"),
    ],
)
def test_units_of_the_wrong_kind_are_refused(changes, sentence):
    assert refusal(beads(), changes).startswith(sentence) or sentence in refusal(beads(), changes)


@pytest.mark.parametrize(
    "unit", ["m/0", "m+s", "m^9^9^9", "(m", ")", "m^m", "km^999999", "__import__", "m" * 99]
)
def test_what_is_no_unit_is_refused_at_once(unit):
    assert "no known unit" in refusal(beads(), {"time.end": f"2 {unit}"})


def test_numbers_of_a_file_need_units(tmp_path):
    (tmp_path / "beads.csv").write_text("x,y,z\n2e-5,2e-5,2e-5\n")
    case = beads()
    del case["particles"][0]["position"]
    case["particles"] = [{**case["particles"][0], "csv": str(tmp_path / "beads.csv")}]
    assert "need a table [units]" in refusal(case)
    assert load_case(case, {"units.length": "1 m"}).particles[0].position == (2e-5,) * 3


def test_every_number_of_a_case_has_a_dimension_or_none():
    keys = set(numeric_keys(Case))
    assert keys - PURE - set(DIMENSIONS) == set()
    assert set(DIMENSIONS) & PURE == set()


def test_kinds_say_what_si_makes_of_them():
    """Each kind's powers of length, time and mass are those of its SI unit, and its example's."""
    import pint

    registry = pint.UnitRegistry()
    electric, magnetic = registry("F/m") ** 0.5, registry("H/m") ** 0.5
    factors = {"V/m": electric, "V": electric, "A/m": magnetic, "A": magnetic, "T": 1 / magnetic}
    kinds = {kind for kind in DIMENSIONS.values() if kind not in FIXED}
    kinds |= {other for kind in kinds for other in kind.others}
    for kind in kinds:
        found = (registry(kind.unit) * factors.get(kind.unit, 1.0)).to_base_units().dimensionality
        powers = [found.get(f"[{name}]", 0.0) for name in ("length", "time", "mass")]
        assert powers == pytest.approx(kind.powers), kind.name
        # A current left over would be a wrong power of ε₀.
        assert found.get("[current]", 0.0) == pytest.approx(0.0), kind.name
        assert registry.parse_expression(kind.example).is_compatible_with(kind.unit), kind.name


def test_magnetic_fields_stand_for_electric_ones():
    """√μ₀ H: a field of 20 kA/m and the 25.13 mT of the same are √(μ₀H²) in √Pa."""
    density = 1.25663706127 * 4e8 * 1e-6
    teslas = VACUUM_PERMEABILITY * 2e4
    for text in ("20 kA/m", f"{teslas} T"):
        field = load_case(beads(), {"electric.field": [0, 0, text]}).electric.field[2]
        assert field**2 == pytest.approx(density, rel=1e-12)
    case = load_case(beads(), {"electric.permittivity": f"{5 * VACUUM_PERMEABILITY} H/m"})
    assert case.electric.permittivity == pytest.approx(5.0, rel=1e-14)


def test_pint_is_loaded_for_units_only():
    code = (
        "import sys; from smoothprofile.config import load_case; load_case('duct');"
        "assert 'pint' not in sys.modules"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


@pytest.fixture(scope="module")
def runs():
    """The same beads in SI and in three other systems of units, run for three steps."""
    systems = (
        {"length": "1 m"},
        UNITS,
        {"length": "1 nm"},
        {"mass": "1 ug", "time": "1 h"},
    )
    found = []
    for units in systems:
        run = sp.Simulation.from_file({**beads(), "units": units})
        run.run()
        found.append(run)
    return found


def test_no_result_depends_on_the_units(runs):
    """Forces in SI from runs in other units: to round-off, as every operation is of one degree."""
    scales = [(1.0, 1.0, 1.0), (1e-5, 1e-6, 970e-15), (1e-9, 1.0, 1.0), (1.0, 3600.0, 1e-9)]
    for quantity, powers in (
        ("force", (1, -2, 1)),
        ("electric_force", (1, -2, 1)),
        ("velocity", (1, -1, 0)),
        ("position", (1, 0, 0)),
    ):
        values = [
            run.particles[0][quantity] * np.prod(np.power(scale, powers))
            for run, scale in zip(runs, scales, strict=True)
        ]
        for one, other in itertools.pairwise(values):
            # The potential is solved to 1e-4 in the same iterations; what differs is round-off.
            np.testing.assert_allclose(other, one, rtol=1e-9, atol=1e-9 * np.abs(one).max())
    for run in runs[1:]:
        for name, number in run.summary()["numbers"].items():
            assert number == pytest.approx(runs[0].summary()["numbers"][name], rel=1e-9), name


def test_forces_are_the_plain_case_s_times_the_electric_scale(runs):
    """F = ε₀ a²E² · F(ε₀ = 1, a = 1, E = 1), and not with ε₀ once more or less, or in cm."""
    case = beads()
    plain = {
        "domain": {"lengths": [8] * 3, "cells": [16] * 3, "boundaries": ["periodic"] * 3},
        "electric": {"field": [0, 0, 1], "permittivity": 2.7, "tolerance": 1e-4},
        "particles": [
            {"shape": "sphere", "radius": 1, "permittivity": 27.0, "position": position}
            for position in ([4.1, 4, 2.5], [4, 4, 5.5])
        ],
    }
    plain["electric"]["effective"] = False
    si = {key: case[key] for key in ("domain", "electric")}
    si["electric"] = {**case["electric"], "tolerance": 1e-4, "effective": False}
    si["particles"] = [
        {key: body[key] for key in ("shape", "radius", "permittivity", "position")}
        for body in case["particles"]
    ]
    one, other = (sp.Electrostatics.from_file(each) for each in (plain, si))
    one.run(), other.run()
    scale = VACUUM_PERMITTIVITY * (1e-5 * 2e6) ** 2
    for body, known in zip(other.particles, one.particles, strict=True):
        # Round-off; the field is given with fifteen digits.
        np.testing.assert_allclose(
            body["force"], scale * known["force"], atol=1e-9 * scale * np.abs(known["force"]).max()
        )


def test_an_angle_does_not_ask_for_units_and_a_rate_does():
    turned = {"axis": [0, 0, 1], "angle": "20 deg"}
    box = {"shape": "box", "sides": [1, 1, 1], "position": [0, 0, 0], "orientation": turned}
    assert load_case(small_case(box)).particles[0].orientation.angle == pytest.approx(20.0)
    assert refusal(small_case(box | {"angular_velocity": ["1 rad/s", 0, 0]})) == (
        'domain.lengths.0 is 10; because particles.0.angular_velocity.0 is "1 rad/s", it needs a '
        'unit too, such as "10 um", or the case a table [units].'
    )
