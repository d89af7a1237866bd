"""The tables of a case: defaults, and the one sentence for whatever cannot be run."""

import math

import pytest

from case_makers import refusal, small_case, sphere
from smoothprofile.config import Case, load_case
from smoothprofile.config.refusals import _table_in

FIXED = "fluid.wall_velocity.y_low"


def test_stages_are_the_preliminary_runs_and_then_the_case():
    first, second, last = load_case("duct-thesis-fine").stages()
    assert (first.domain.cells, first.profile.thickness) == ((128, 45, 45), 0.3)
    assert (first.time.step, first.time.end) == (0.05, 50.0)
    # What a preliminary run leaves out is the case's own.
    assert second.time.steady_tolerance == last.time.steady_tolerance == 1e-6
    assert last.domain.cells == (256, 90, 90)
    assert not any(stage.start for stage in (first, second, last))


def test_defaults_depend_on_what_is_given():
    still, moving = load_case(
        small_case(sphere(), sphere(position=[3, 0, 0], velocity=[1, 0, 0]))
    ).particles
    assert (still.motion, moving.motion) == ("held", "prescribed")
    assert (still.name, moving.name) == ("sphere 0", "sphere 1")
    assert load_case("duct").particles[0].name == "sphere"
    assert load_case(small_case()).domain.sides == {
        "x_low": "periodic",
        "x_high": "periodic",
        "y_low": "wall",
        "y_high": "wall",
        "z_low": "wall",
        "z_high": "slip",
    }


@pytest.mark.parametrize(
    ("override", "key", "value", "allowed"),
    [
        ("fluid.viscosty=1", "fluid.viscosty", "", "nearest is fluid.viscosity"),
        ("viscosity=1", "viscosity", "", "nearest is fluid.viscosity"),
        ("fluid.walls=1", "fluid.walls", "", "nearest is fluid.wall_velocity."),
        ("fluid.plume=1", "fluid.plume", "", "known here are flow, "),
        ("particles.0.radus=1", "particles.0.radus", "", "nearest is particles.0.radius"),
        ("fluid.mean_velocity.w=1", "fluid.mean_velocity.w", "", "x, y, z"),
        ("fluid.viscosity=-1", "fluid.viscosity", "-1", "above 0"),
        ("fluid.viscosity=0", "fluid.viscosity", "0", "above 0"),
        ("fluid.density=0.0", "fluid.density", "0.0", "above 0"),
        ("fluid.viscosity=nan", "fluid.viscosity", "nan", "finite"),
        ("fluid.viscosity=inf", "fluid.viscosity", "inf", "finite"),
        ("fluid.viscosity=water", "fluid.viscosity", '"water"', "finite"),
        ("fluid.viscosity=true", "fluid.viscosity", "true", "finite"),
        ("fluid.advection=1", "fluid.advection", "1", "true or false"),
        ("fluid.body_force=[1, nan, 0]", "fluid.body_force", "[1, nan, 0]", "three finite"),
        ("fluid.initial_velocity=[0,1,0]", "fluid.initial_velocity", "[0.0, 1.0, 0.0]", "y"),
        ("domain.lengths=[1, 2]", "domain.lengths", "[1, 2]", "three"),
        ("domain.lengths=[1, 0, 3]", "domain.lengths", "[1, 0, 3]", "above 0"),
        ("domain.lengths=5", "domain.lengths", "5", "three"),
        ("domain.cells=[1.5, 2, 3]", "domain.cells", "[1.5, 2, 3]", "whole"),
        ("domain.cells.1=0", "domain.cells", "[10, 0, 8]", "from 1"),
        ("domain.boundaries.0=open", "domain.boundaries", '["open"', '"periodic"'),
        ("domain.precision=half", "domain.precision", '"half"', '"double"'),
        ("domain=3", "domain", "3", "table"),
        ("domain.stretching=[1,2,3]", "domain.stretching", "[1, 2, 3]", '"uniform"'),
        ("profile.thickness=0", "profile.thickness", "0", "above 0"),
        ("profile.thickness=1.5", "profile.thickness", "1.5", "particles.0.radius"),
        ("profile.kind=step", "profile.kind", '"step"', "tanh"),
        ("profile.retract=1", "profile.retract", "1", '"planar"'),
        ("time.step=0", "time.step", "0", "above 0"),
        ("time.step=soon", "time.step", '"soon"', '"auto"'),
        ("time.step=nan", "time.step", "nan", "finite"),
        ("time.scheme=rk4", "time.scheme", '"rk4"', "bdf3"),
        ("time.end=-2", "time.end", "-2", "above 0"),
        ("time.max_steps=0", "time.max_steps", "0", "whole"),
        ("start=[{}]", "start.0.cells", "missing", "three whole"),
        ("start=[{cells=[4,4,4], thickness=2}]", "start.0.thickness", "2", "radius"),
        ("reference=ducc", "reference", '"ducc"', "duct"),
        ("fluid.wall_velocity.x_low=[0,1,0]", "fluid.wall_velocity.x_low", "[0.0, 1", "periodic"),
        ("fluid.wall_velocity.z_high=[1,0,0]", "fluid.wall_velocity.z_high", "[1.0", "slip"),
        (f"{FIXED}=[0,1,0]", FIXED, "[0.0, 1.0, 0.0]", "y component"),
        (f"{FIXED}=3", FIXED, "3", "amplitude"),
        (f"{FIXED}={{amplitude=[1,0,0]}}", f"{FIXED}.angular_frequency", "missing", "above 0"),
        (f"{FIXED}={{amplitud=[1,0,0]}}", f"{FIXED}.amplitud", "", "amplitude"),
        ("fluid.mean_velocity.y=1", "fluid.mean_velocity.y", "1", "walls"),
        ("particles=3", "particles", "3", "[[particles]]"),
        ("particles.0.radius=-1", "particles.0.radius", "-1", "above 0"),
        ("particles.0.shape=blob", "particles.0.shape", '"blob"', "capsule"),
        ("particles.0.sides=[1,1,1]", "particles.0.sides", "[1.0, 1.0, 1.0]", "takes radius"),
        (
            "particles=[{shape='sphere', position=[0,0,0]}]",
            "particles.0.radius",
            "missing",
            "needs",
        ),
        ("particles.0.motion=loose", "particles.0.motion", '"loose"', '"free"'),
        ("particles.0.name=''", "particles.0.name", '""', "of one line"),
        ('particles.0.name="a\\u2028b"', "particles.0.name", '"a\u2028b"', "of one line"),
        ('particles.0.name="a\\nb"', "particles.0.name", '"a\\nb"', "of one line"),
        ("particles.0.motion=free", "particles.0.density", "missing", "a free body needs density"),
        ("particles.0.density=2.0", "particles.0.density", "2.0", 'motion = "free"'),
        ("particles.0.position=[6,0,0]", "particles.0.position", "[6.0", "-5 to 5 along x"),
        ("particles.0.position=[0,3.5,0]", "particles.0.position", "[0.0, 3.5", "-4 to 4"),
        ("profile.thickness=1e-300", "profile.thickness", "1e-300", "between 1e-40 and 1e40"),
        ("domain.lengths=[1e300, 8, 8]", "domain.lengths", "[1e+300, 8, 8]", "between 1e-40"),
        ("fluid.gravity=[0, 0, -1e300]", "fluid.gravity", "[0, 0, -1e+300]", "between 1e-40"),
        (f"{FIXED}=[1e41, 0, 0]", FIXED, "[1e+41, 0, 0]", "between 1e-40"),
        ("fluid.gravity=[0, -9.81]", "fluid.gravity", "[0, -9.81]", "three finite"),
        ("fluid.gravity=9.81", "fluid.gravity", "9.81", "three finite"),
        ("contact.restitution=2", "contact.restitution", "2", "from 0.01 to 1"),
        ("contact.restitution=nan", "contact.restitution", "nan", "from 0.01 to 1"),
        ("contact.friction=-1", "contact.friction", "-1", "0 or more"),
        ("contact.range=0", "contact.range", "0", "above 0"),
        ("contact.lubrication=yes", "contact.lubrication", '"yes"', "true or false"),
        ("contact.lubrication=1", "contact.lubrication", "1", "true or false"),
        ("contact.resitution=1", "contact.resitution", "", "nearest is contact.restitution"),
        ("contact.stiffness=1", "contact.stiffness", "", "known here are range"),
        ("contact=3", "contact", "3", "a table with the keys range"),
        ("particles.0.force=[1, 0, 0]", "particles.0.force", "[1.0", 'motion = "free" has a force'),
        ("particles.0.torque=[1, 0, 0]", "particles.0.torque", "[1.0", "free"),
        ("output.every=0", "output.every", "0", "whole"),
        ("output.fields=['speed']", "output.fields", '["speed"]', "velocity"),
        ("output.plane.at=9", "output.plane.at", "9", "-4 to 4"),
        ("output.wall_line={wall='x_low', at=0}", "output.wall_line.wall", '"x_low"', "periodic"),
        ("output.lines=[{axis='x'}]", "output.lines.0.name", "missing", "name"),
    ],
)
def test_bad_values_are_refused_by_key_value_and_what_is_allowed(override, key, value, allowed):
    text = refusal(small_case(sphere()), [override])
    assert text.startswith(f"{key} is {value}")
    assert allowed in text


def test_a_body_force_beside_a_held_mean_velocity_is_refused():
    text = refusal(small_case(), ["fluid.body_force=[1, 0, 0]", "fluid.mean_velocity.x=1"])
    assert text.startswith("fluid.body_force is [1")
    assert "along x the mean velocity is held, whatever drives it" in text


@pytest.mark.parametrize(
    ("changes", "key", "value", "allowed"),
    [
        ({"density": 0}, "density", "0", "above 0"),
        ({"density": -1.0}, "density", "-1.0", "above 0"),
        ({"density": math.nan}, "density", "nan", "finite"),
        ({"density": "heavy"}, "density", '"heavy"', "finite"),
        ({"density": None}, "density", "missing", "a free body needs density"),
        ({"force": [1, 2]}, "force", "[1, 2]", "three finite"),
        ({"torque": 5}, "torque", "5", "three finite"),
        (
            {"velocity": {"amplitude": [1, 0, 0], "angular_frequency": 1}},
            "velocity",
            "{ amplitude = [1.0, 0.0, 0.0] }",
            "at the start, three numbers",
        ),
        (
            {"shape": "plane", "radius": None, "normal": [0, 1, 0]},
            "motion",
            '"free"',
            "a plane without an end cannot move freely",
        ),
        ({"shape": "cylinder", "axis": [1, 0, 0]}, "motion", '"free"', "a cylinder without an end"),
    ],
)
def test_free_bodies_that_cannot_be_are_refused(changes, key, value, allowed):
    body = sphere(motion="free", density=2.0) | changes
    text = refusal(small_case({name: given for name, given in body.items() if given is not None}))
    assert text.startswith(f"particles.0.{key} is {value}; ")
    assert allowed in text


@pytest.mark.parametrize(
    ("stretching", "key", "value"),
    [
        ({"focus": 9, "ratio": 2}, "domain.stretching.1.focus", "9"),
        ({"focus": 0, "ratio": 0.5}, "domain.stretching.1.ratio", "0.5"),
        ({"faces": [-4, 4]}, "domain.stretching.1.faces", "[-4.0, 4.0]"),
        ({"faces": [0, -1]}, "domain.stretching.1.faces", "[0, -1]"),
        ({"faces": [0, 1, 2, 3, 4, 5, 6, 7, 8]}, "domain.stretching.1.faces", "[0.0, 1.0"),
        ({"focuss": 1}, "domain.stretching.1.focuss", ""),
    ],
)
def test_stretching_that_does_not_fit_is_refused(stretching, key, value):
    case = small_case()
    case["domain"]["stretching"] = ["uniform", stretching, "uniform"]
    assert refusal(case).startswith(f"{key} is {value}")


def test_names_are_told_apart():
    twins = [sphere(name="a"), sphere(name="a", position=[3, 0, 0])]
    assert refusal(small_case(*twins)).startswith('particles.1.name is "a"')
    line = {"name": "b", "axis": "x", "through": [0, 0]}
    case = small_case() | {"output": {"lines": [line, line]}}
    assert refusal(case).startswith('output.lines.1.name is "b"')


def test_particles_need_a_profile():
    case = small_case(sphere())
    del case["profile"]
    assert refusal(case).startswith("profile is missing; ")
    assert load_case(case | {"particles": []}).profile is None


def test_every_field_says_what_it_may_be():
    waiting, seen = [Case], set()
    while waiting:
        table = waiting.pop()
        seen.add(table.__name__)
        for name, field in table.model_fields.items():
            assert field.description, f"{table.__name__}.{name}"
            inner = _table_in(field.annotation)
            if inner is not None and inner.__name__ not in seen:
                waiting.append(inner)
    assert {"Domain", "Particle", "Solid", "Line", "Start"} <= seen
