"""The command `spm` as people and programs meet it: texts, JSON, exit codes, files left behind."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import pytest

from smoothprofile import __version__
from smoothprofile.runrecord import read_run

CASE = """\
title = "A sphere between sliding walls"

[domain]
lengths = [4.0, 4.0, 4.0]
cells = [12, 12, 12]
boundaries = ["periodic", "wall", "periodic"]

[fluid]
density = 1.0
viscosity = 0.1

[fluid.wall_velocity]
y_high = [1.0, 0.0, 0.0]

[profile]
thickness = 0.35

[[particles]]
shape = "sphere"
radius = 1.05
position = [2.0, 2.0, 2.0]

[time]
end = 1.0
max_steps = 4

[output]
wall_line = { wall = "y_high", component = "x", along = "x", at = 2.0 }

[[output.lines]]
name = "across"
axis = "y"
through = [0.5, 2.0]
"""

# A body force in a periodic box announces no speed beforehand, and this one drives a great one.
PUSHED = """\
title = "Pushed too hard"

[domain]
lengths = [1.0, 1.0, 1.0]
cells = [8, 8, 8]
boundaries = ["periodic", "periodic", "periodic"]

[fluid]
density = 1.0
viscosity = 1e-3
body_force = [50.0, 0.0, 0.0]

[profile]
thickness = 0.2
retract = false

[[particles]]
shape = "sphere"
radius = 0.25
position = [0.5, 0.5, 0.5]

[time]
step = 0.05
end = 100.0
"""

SECOND_SPHERE = """
[[particles]]
shape = "sphere"
radius = 0.5
position = [2.0, 3.2, 2.0]
"""

README = Path(__file__).parent.parent / "README.md"

MAIN = "from smoothprofile.cli import main; main()"


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(CASE, encoding="utf-8")
    return path


def assert_refused(answer, *words):
    """Exit code 2, nothing on standard output, one sentence with the words on the other."""
    code, out, err = answer
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    assert err.rstrip().endswith(".")
    for word in words:
        assert word in err


def assert_refused_as_json(answer, *words):
    code, out, err = answer
    found = json.loads(out)
    assert code == 2
    assert (found["status"], found["exit_code"]) == ("refused", 2)
    assert found["error"] == err.rstrip("\n")
    for word in words:
        assert word in found["error"]


BAD_SETTINGS = [
    (["fluid.viscocity=1"], ["fluid.viscocity", "fluid.viscosity"]),
    (["flow.viscosity=1"], ["flow"]),
    (["fluid.viscosity=thick"], ["fluid.viscosity", '"thick"']),
    (["domain.cells=[12.5, 12, 12]"], ["domain.cells", "12.5"]),
    (["fluid.advection=1"], ["fluid.advection", "1", "true or false"]),
    (["fluid.viscosity=nan"], ["fluid.viscosity", "nan"]),
    (["time.end=inf"], ["time.end", "inf"]),
    (["particles.0.position=[2, nan, 2]"], ["particles.0.position", "nan"]),
    (["fluid.viscosity=-0.1"], ["fluid.viscosity", "-0.1", "above 0"]),
    (["fluid.viscosity=0"], ["fluid.viscosity", "0", "above 0"]),
    (["fluid.density=0"], ["fluid.density", "0", "above 0"]),
    (["profile.thickness=-0.35"], ["profile.thickness", "-0.35", "above 0"]),
    (["profile.thickness=0"], ["profile.thickness", "0", "above 0"]),
    (["domain.lengths=[4, -4, 4]"], ["domain.lengths", "-4", "above 0"]),
    (["domain.lengths.2=0"], ["domain.lengths", "0", "above 0"]),
    (["particles.0.radius=0"], ["particles.0.radius", "0", "above 0"]),
    (["particles.0.position=[2, 9, 2]"], ["particles.0.position", "9", "0 to 4"]),
    (["particles.0.position=[2, 3.5, 2]"], ["particles.0.position", "3.5", "walls"]),
    (["profile.thickness=1.2"], ["profile.thickness", "1.2", "1.05"]),
    (["domain.cells=[100000, 100000, 100000]"], ["domain.cells", "100000×100000", "GiB"]),
    (["time.step=50"], ["time.step", "50", "stable only up to"]),
    (["time.step=0"], ["time.step", "0"]),
    (["fluid.wall_velocity.x_low=[0, 1, 0]"], ["fluid.wall_velocity.x_low", "periodic"]),
    (["fluid.wall_velocity.y_low=[0, 1, 0]"], ["fluid.wall_velocity.y_low"]),
    (["time.scheme=euler"], ["time.scheme", '"euler"', "backward-euler"]),
    (["particles.3.radius=1"], ["particles.3.radius"]),
    (["viscosity"], ["viscosity", "table.key=value"]),
]


@pytest.mark.parametrize(("settings", "words"), BAD_SETTINGS)
def test_bad_input_is_refused_in_one_sentence(spm, case, settings, words):
    arguments = ["run", case, *(part for text in settings for part in ("--set", text))]
    assert_refused(spm(*arguments), *words)
    assert_refused_as_json(spm(*arguments, "--json"), *words)
    assert not case.with_name("runs").exists()
    assert_refused(spm("check", *arguments[1:]), *words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (CASE + SECOND_SPHERE, ["particles.1.position", "overlaps", "particles.0"]),
        (CASE.replace("viscosity", "viscosty"), ["fluid.viscosty", "fluid.viscosity"]),
        (CASE.replace("[fluid]", "[fluid"), ["small.toml is not TOML at line 8"]),
        (CASE.replace("[time]\nend = 1.0", "[time]"), ["time.end is missing"]),
        ("\x00\x01", ["small.toml is not TOML"]),
        ("", ["domain is missing"]),
    ],
)
def test_bad_files_are_refused_in_one_sentence(spm, case, text, words):
    case.write_text(text, encoding="utf-8")
    assert_refused(spm("run", case), *words)
    assert_refused_as_json(spm("run", case, "--json"), *words)


def test_what_is_not_there_is_refused(spm, case):
    assert_refused(spm("run", "ducct"), "ducct", "the nearest is duct")
    assert_refused(spm("run", "none.toml"), "none.toml does not exist")
    assert_refused(spm("run", "."), "is a directory")
    assert_refused(spm("report", "runs"), "runs is not a run directory")
    assert_refused(spm("new", "channels"), "the nearest is channel")
    assert_refused(spm("run", case, "--threads", "0"), "threads is 0")
    assert_refused(spm("new", "channel", "--out", "none/x.toml"), "none/x.toml")


def test_nothing_is_overwritten(spm, case, tmp_path):
    for name in ("there", "there.json"):
        (tmp_path / name).write_text("mine")
    assert_refused(spm("run", case, "--out", "there"), "there exists already")
    assert_refused_as_json(spm("run", case, "--out", "there", "--json"), "there exists already")
    assert_refused(spm("new", "channel", "--out", "there"), "there exists already")
    for command in (["cases"], ["check", case], ["bench"], ["doctor"], ["report", "there"]):
        assert_refused(spm(*command, "--out", "there.json"), "there.json exists already")
    assert (tmp_path / "there.json").read_text() == "mine"
    assert_refused(spm("run", case, "--out", "there/inside"), "there/inside", "cannot be made")


WRONG_LINES = [
    (["run"], ["spm run needs CASE"]),
    (["chekc", "duct"], ["no command chekc", "the nearest is check"]),
    (["walk"], ["no command walk", "it has cases, new"]),
    (["run", "duct", "--threads", "many"], ["--threads is many", "a whole number from 1"]),
    (["run", "duct", "--retry", "-1"], ["--retry is -1", "a whole number from 0"]),
    (["run", "duct", "--thread", "2"], ["no option --thread;", "the nearest is --threads"]),
    (["run", "--quickly"], ["no option --quickly", "it has --out, --set"]),
    (["run", "duct", "more"], ["spm run takes CASE and options alone; more is too much."]),
    (
        ["new", "duct", "more", "yet"],
        ["spm new takes NAME and options alone; more yet is too much."],
    ),
    (["cases", "more"], ["spm cases takes options alone; more is too much."]),
    (["run", "duct", "--set"], ["'--set' requires an argument"]),
]


@pytest.mark.parametrize(("arguments", "words"), WRONG_LINES)
def test_a_line_that_cannot_be_read_is_told_in_one_sentence(spm, arguments, words):
    assert_refused(spm(*arguments), *words)
    if arguments[-1] != "--set":
        assert_refused_as_json(spm(*arguments, "--json"), *words)


def test_spm_alone_shows_its_commands(spm):
    code, out, err = spm()
    assert (code, "Usage: spm" in out + err, "study" in out + err) == (2, True, True)


def test_a_layer_thinner_than_a_cell_is_only_a_warning(spm, case):
    code, out, err = spm("run", case, "--set", "profile.thickness=0.2", "--set", "time.max_steps=1")
    assert code == 0
    assert "Note: ξ/Δx is 0.6, against 1" in err
    code, out, _ = spm("check", case, "--set", "profile.thickness=0.2", "--json")
    checks = {check["name"]: check for check in json.loads(out)["checks"]}
    assert (code, checks["ξ/Δx"]["verdict"]) == (0, "warn")
    assert checks["time step"]["verdict"] == "ok"


def test_run_answers_programs_with_one_object(spm, case, tmp_path):
    code, out, err = spm("run", case, "--json", "--out", "here", "--set", "output.every=2")
    found = json.loads(out)
    assert (code, err) == (0, "")
    assert (found["status"], found["steps"], found["cells"]) == ("max_steps", 4, 12**3)
    assert found["time"] == pytest.approx(4 * found["time_step"], rel=1e-12)  # a sum of four
    assert found["wall_seconds"] > 0
    assert found["seconds_per_step"] > 0
    assert found["threads"] == 1
    (body,) = found["bodies"]
    for quantity in ("force", "torque", "position", "velocity", "interior_velocity"):
        assert len(body[quantity]) == 3
    assert body["position"] == [2.0, 2.0, 2.0]
    assert body["force"][0] != 0
    assert set(found["wall_force"]) == {"y_low", "y_high", "total"}
    assert all(len(force) == 3 for force in found["wall_force"].values())
    assert found["directory"] == "here"
    assert json.loads((tmp_path / "here" / "summary.json").read_text()).items() <= found.items()
    assert (tmp_path / found["report"]).read_text().startswith("<!doctype html>")
    record = read_run("here")
    assert list(record.history["step"]) == [2, 4]
    assert record.run["status"] == "max_steps"
    assert record.case["output"]["every"] == 2
    assert record.lines["across"][0].size > 12
    assert record.wall_shear is not None
    assert {path.name for path in (tmp_path / "here").iterdir()} == {
        "case.toml", "run.json", "history.csv", "particles.csv", "lines.csv", "plane.npz",
        "fields.h5", "summary.json", "report.html", "figures",
    }  # fmt: skip


def test_run_tells_people_and_numbers_its_directories(spm, case, tmp_path):
    arguments = ["run", case, "--set", "time.max_steps=1"]
    code, out, err = spm(*arguments)
    assert code == 0
    assert "A sphere between sliding walls" in out
    for shown in ("max_steps", "time step", "force on sphere", "force on the walls"):
        assert shown in out
    assert err == "Everything is in runs/small; open runs/small/report.html.\n"
    assert "runs/small-2/report.html" in spm(*arguments)[2]
    assert len(list((tmp_path / "runs").iterdir())) == 2


def test_a_resolved_case_runs_again_to_the_same_result(spm, case):
    first = json.loads(spm("run", case, "--json", "--out", "one")[1])
    again = json.loads(spm("run", "one/case.toml", "--json", "--out", "two")[1])
    assert again["bodies"] == first["bodies"]
    assert read_run("two").case_toml == read_run("one").case_toml


def test_a_case_without_particles_runs(spm, case):
    case.write_text(CASE[: CASE.index("[profile]")] + CASE[CASE.index("[time]") :])
    code, out, _ = spm("run", case, "--json")
    found = json.loads(out)
    assert (code, found["bodies"]) == (0, [])


def test_report_is_rebuilt(spm, case, tmp_path):
    spm("run", case, "--out", "here", "--json")
    page = tmp_path / "here" / "report.html"
    first = page.read_text()
    page.unlink()
    assert spm("report", "here") == (0, "", "Wrote here/report.html.\n")
    assert page.read_text() == first
    code, out, err = spm("report", "here", "--out", "page.html", "--json")
    assert (code, json.loads(out), err) == (0, {"report": "page.html"}, "")
    assert (tmp_path / "page.html").read_text() == first
    for name in ("summary.json", "plane.npz", "case.toml"):
        (tmp_path / "here" / name).write_text("{")
        assert_refused(spm("report", "here"), "here", "is damaged: ")


def test_a_report_shows_torque_where_there_is_no_force(spm, case, tmp_path):
    spinning = CASE.replace("y_high = [1.0, 0.0, 0.0]", "y_high = [0.0, 0.0, 0.0]")
    spinning = spinning.replace("[time]", "angular_velocity = [0.0, 0.0, 1.0]\n\n[time]")
    case.write_text(spinning)
    assert spm("run", case, "--out", "here")[0] == 0
    figures = {path.stem for path in (tmp_path / "here" / "figures").iterdir()}
    assert "torque" in figures
    assert "force" not in figures
    assert "Torque of the fluid on each particle" in (tmp_path / "here/report.html").read_text()


def test_couette_gives_its_stress_beside_the_exact_one(spm, tmp_path):
    small = ["domain.cells=[2, 48, 2]", "profile.thickness=0.25", "time.end=100"]
    settings = [part for text in small for part in ("--set", text)]
    code, _, _ = spm("run", "couette", "--out", "here", *settings)
    assert code == 0
    page = (tmp_path / "here" / "report.html").read_text()
    row = page[page.index("wall stress") :][:300].replace("−", "-")
    cells = re.findall(r'<td class="number">([^<]*)</td>', row)
    # Six per mille of difference are allowed here, two cells across the layer and no more.
    assert abs(float(cells[0]) - 1 / 3) < 0.002
    assert float(cells[1]) == 0.33333


def test_cases_can_be_listed_written_out_and_checked(spm, tmp_path):
    code, out, _ = spm("cases", "--json")
    names = [entry["name"] for entry in json.loads(out)["cases"]]
    assert code == 0
    assert {"duct", "couette", "channel", "lid-cavity"} <= set(names)
    code, out, _ = spm("cases")
    assert code == 0
    assert all(name in out for name in names)
    code, out, err = spm("new", "couette")
    assert (code, out) == (0, "")
    assert "spm check couette.toml" in err
    assert tomllib.loads((tmp_path / "couette.toml").read_text())["reference"] == "couette"
    assert_refused(spm("new", "couette"), "couette.toml exists already")
    assert json.loads(spm("new", "duct", "--out", "mine.toml", "--json")[1]) == {
        "file": "mine.toml"
    }
    code, out, err = spm("check", "couette.toml")
    assert (code, err) == (0, "")
    for shown in ("Couette flow under a plane body", "time step", "ξ/Δx", "memory (GiB)", "ok"):
        assert shown in out
    assert spm("check", "couette.toml", "--out", "checks.json")[0] == 0
    checks = json.loads((tmp_path / "checks.json").read_text())["checks"]
    assert {"name", "value", "limit", "verdict", "note"} == set(checks[0])


def test_version_and_help(spm):
    assert spm("--version") == (0, f"smoothprofile {__version__}\n", "")
    code, out, _ = spm("--help")
    assert code == 0
    for command in ("cases", "new", "check", "run", "report", "bench", "doctor"):
        assert command in out
        assert "--json" in spm(command, "--help")[1]
        assert "--out" in spm(command, "--help")[1]


def test_bench_measures_against_an_fft(spm):
    code, out, err = spm("bench", "--cells", "24,12,12", "--threads", "1", "--json")
    found = json.loads(out)
    assert (code, err) == (0, "")
    assert (found["cells"], found["threads"]) == (24 * 12 * 12, 1)
    assert found["step_seconds"] > 0
    assert found["fft_round_trip_seconds"] > 0
    quotient = found["step_seconds"] / found["fft_round_trip_seconds"]
    assert found["ratio"] == pytest.approx(quotient, rel=1e-12)  # the same division
    assert "peak_fields_per_cell" in found


def test_doctor_finds_this_installation_sound(spm):
    code, out, _ = spm("doctor", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["smoothprofile"] == __version__
    assert {test["verdict"] for test in found["tests"]} == {"ok"}


def test_a_run_that_blows_up_says_where_and_leaves_a_report(spm, case, tmp_path):
    case.write_text(PUSHED)
    code, out, _ = spm("run", case, "--json", "--out", "here")
    found = json.loads(out)
    assert (code, found["status"], found["exit_code"]) == (3, "blew_up", 3)
    for word in ("At time ", "velocity component x", "in cell (", "may not exceed", "Δt = 0.05"):
        assert word in found["error"]
    assert found["report"] == "here/report.html"
    record = read_run("here")
    assert (record.run["status"], record.run["message"]) == ("blew_up", found["error"])
    assert record.history["time"].size > 0
    page = (tmp_path / "here" / "report.html").read_text(encoding="utf-8")
    assert "blew up" in page
    assert "velocity component x" in page
    code, out, err = spm("run", case)
    assert (code, out) == (3, "")
    assert "What was computed is in runs/small" in err
    assert "Traceback" not in err


def start(folder, *arguments):
    return subprocess.Popen(
        [sys.executable, "-c", MAIN, *map(str, arguments)],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
        env={**os.environ, "PYTHONUTF8": "1"},
        # Whoever runs the tests in the background may have had it ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_a_run_with_what_it_has(case, tmp_path, stop):
    run = start(tmp_path, "run", case, "--out", "here", "--json",
                "--set", "time.end=1e9", "--set", "time.max_steps=1000000")  # fmt: skip
    rows = tmp_path / "here" / "history.csv"
    give_up = time.monotonic() + 300  # where nothing is compiled yet, that comes first
    while not (rows.exists() and rows.read_text().count("\n") > 3):
        assert run.poll() is None and time.monotonic() < give_up, run.communicate()
        time.sleep(0.05)
    run.send_signal(stop)
    out, err = run.communicate(timeout=60)
    found = json.loads(out)
    assert (run.returncode, found["status"], found["exit_code"]) == (4, "interrupted", 4)
    assert "Traceback" not in err
    record = read_run(tmp_path / "here")
    assert record.run["status"] == "interrupted"
    assert record.history["time"].size >= 3
    assert "interrupted" in (tmp_path / "here" / "report.html").read_text(encoding="utf-8")


def test_exit_codes_reach_the_shell(case, tmp_path):
    run = start(tmp_path, "run", case, "--json")
    out, err = run.communicate(timeout=300)
    assert (run.returncode, err) == (0, "")
    assert json.loads(out)["status"] == "max_steps"
    run = start(tmp_path, "run", case, "--set", "fluid.viscosity=0")
    out, err = run.communicate(timeout=60)
    assert (run.returncode, out) == (2, "")
    assert err.startswith("fluid.viscosity is 0")


def test_what_the_readme_shows_works(spm, case, tmp_path, capsys):
    """Its case runs (for a step), and its lines of Python do."""
    blocks = re.findall(
        r"```(toml|python)\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL
    )
    assert [language for language, _ in blocks] == ["toml", "python", "toml", "python"]
    case.write_text(blocks[0][1], encoding="utf-8")
    code, out, err = spm("run", case, "--set", "time.max_steps=1", "--json")
    assert (code, err, json.loads(out)["status"]) == (0, "", "max_steps")
    exec(compile(blocks[1][1], str(README), "exec"), {})
    assert "[" in capsys.readouterr().out
    case.write_text(blocks[2][1], encoding="utf-8")
    few = ["--set", "domain.cells=[24,24,24]", "--set", "particles.0.random={count=2}"]
    code, out, err = spm("run", case, *few, "--out", tmp_path / "field", "--json")
    assert (code, json.loads(out)["status"]) == (0, "finished")
    exec(compile(blocks[3][1], str(README), "exec"), {})
    # A lattice of c = .4, 2.364 by the multipole series, at 32 cells.
    assert capsys.readouterr().out.startswith("2.37")
