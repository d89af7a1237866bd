"""The house itself: import contracts, sizes of files and functions, and flow on its own."""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import smoothprofile

PACKAGE = Path(smoothprofile.__file__).parent
ROOT = Path(__file__).parent.parent
SOURCES = sorted(PACKAGE.rglob("*.py"))
# About a tenth over what a file and a function should be: a limit, not an aim.
LONGEST_FILE, LONGEST_FUNCTION = 330, 70

FLOW_ALONE = """
import sys
import numpy as np
from smoothprofile.flow.advance import Flow, FlowParameters
from smoothprofile.flow.state import fluid_at_rest
from smoothprofile.flow.walls import Walls
from smoothprofile.grid import Grid, uniform_axis
from smoothprofile.schemes import scheme_named

grid = Grid(tuple(uniform_axis(n, 0.0, 1.0, 4, n == "x") for n in "xyz"))
kinds = (("periodic", "periodic"), ("wall", "wall"), ("wall", "wall"))
parameters = FlowParameters(
    density=1.0, viscosity=1.0, body_force=(1.0, 0.0, 0.0), mean_velocity=(None, None, None),
    walls=Walls(kinds, {}), scheme=scheme_named("backward-euler"), advection=True,
)
flow, state = Flow(grid, parameters), fluid_at_rest(grid)
flow.step(state, 0.01)
assert 0 < np.abs(state.velocity[0]).max() < 0.01, state.velocity[0].max()
met = [name for name in sys.modules if name.startswith("smoothprofile.")]
print("\\n".join(met))
"""


def name_of(path):
    return str(path.relative_to(PACKAGE))


def functions(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            yield node


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_files_and_functions_stay_small(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST_FILE
    for function in functions(path):
        length = function.end_lineno - function.lineno + 1
        assert length <= LONGEST_FUNCTION, f"{function.name} has {length} lines"


@pytest.mark.parametrize("path", SOURCES, ids=name_of)
def test_files_say_what_they_are_for(path):
    assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))


def lint_imports(folder):
    """Exit code and text of the import contracts, applied to the package in `folder`/src."""
    command = [
        sys.executable,
        "-c",
        "from importlinter.cli import lint_imports_command as lint; lint()",
    ]
    found = subprocess.run(
        [*command, "--no-logo", "--no-cache"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(folder / "src")},
        capture_output=True,
        text=True,
    )
    return found.returncode, found.stdout + found.stderr


def copy_of_the_house(folder, without=()):
    """The package in `folder`/src, less some of its files and folders; returns the package."""
    package = folder / "src" / "smoothprofile"
    ignore = shutil.ignore_patterns("__pycache__", *without)
    shutil.copytree(PACKAGE, package, ignore=ignore)
    shutil.copy(ROOT / "pyproject.toml", folder)
    return package


def test_import_contracts_hold():
    code, text = lint_imports(ROOT)
    assert code == 0, text


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("flow/state.py", "from smoothprofile.particles import bodies"),
        ("flow/state.py", "from smoothprofile.config import Case"),
        ("particles/bodies.py", "from smoothprofile.flow import state"),
        ("theory/planar.py", "from smoothprofile.errors import CaseError"),
        ("grid.py", "from smoothprofile.boundaries import fill_ghosts"),
        ("pairing.py", "from smoothprofile import plots"),
        ("fields.py", "import ducc0"),
        ("report.py", "import matplotlib"),
    ],
)
def test_import_contracts_notice_what_they_forbid(file, line, tmp_path):
    package = copy_of_the_house(tmp_path)
    with (package / file).open("a", encoding="utf-8") as source:
        source.write(line + "\n")
    code, text = lint_imports(tmp_path)
    assert code == 1, text
    assert "BROKEN" in text


def test_a_new_file_must_be_given_its_floor(tmp_path):
    package = copy_of_the_house(tmp_path)
    (package / "attic.py").write_text('"""A file."""\n', encoding="utf-8")
    assert lint_imports(tmp_path)[0] == 1


def test_flow_works_where_there_are_no_particles(tmp_path):
    copy_of_the_house(tmp_path, ("particles", "electric", "coupling.py"))
    found = subprocess.run(
        [sys.executable, "-c", FLOW_ALONE],
        cwd=tmp_path,
        # Not compiled: that would take half a minute, and 64 cells do without.
        env={**os.environ, "PYTHONPATH": str(tmp_path / "src"), "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
    )
    assert found.returncode == 0, found.stderr
    assert "smoothprofile.flow.advance" in found.stdout
    assert not {"config", "simulation"} & {m.split(".")[1] for m in found.stdout.split()}
