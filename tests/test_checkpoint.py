"""Checkpoints that rot, that belong elsewhere, or that another run is at work on."""

import random
import shutil

import pytest

from restarts import NO_CHECKPOINTS_OF_THEIR_OWN
from smoothprofile.checkpoint import NEWEST, PREVIOUS, read_checkpoint
from smoothprofile.config import load_case
from smoothprofile.errors import CaseError
from smoothprofile.output import RunDirectory
from smoothprofile.running import taken_up
from smoothprofile.runs import run_of
from test_resume import body, box


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    """A run with two checkpoints, after steps 2 and 3, and what they hold."""
    path = tmp_path_factory.mktemp("stopped") / "run"
    case = box(body([3.5, 3.0, 3.0]), time={"max_steps": 5})
    simulation = run_of(load_case(case, NO_CHECKPOINTS_OF_THEIR_OWN))
    directory = RunDirectory(path, simulation.case.to_toml())
    with directory:
        for _ in range(3):
            simulation.step_once()
            directory.record(simulation)
            directory.checkpoint(simulation)
    return path


def step_of(path, told):
    tree = read_checkpoint(path, (path / "case.toml").read_text(), told.append)
    return tree["simulation"]["flow_state"]["steps"]


def damaged_checkpoints(stopped, tmp_path, count):
    """Each damage of the newest is found, told, and the older one taken; of both, refused."""
    choose, path = random.Random(2), tmp_path / "run"
    shutil.copytree(stopped, path)
    newest, whole = path / NEWEST, (path / NEWEST).read_bytes()
    for number in range(count):
        data = bytearray(whole)
        if number % 3 == 0:
            del data[choose.randrange(len(data)) :]
        elif number % 3 == 1:
            at = choose.randrange(len(data))
            data[at] ^= 1 << choose.randrange(8)
        else:
            at = choose.randrange(len(data))
            length = min(choose.randint(1, 4096), len(data) - at)
            data[at : at + length] = choose.randbytes(length)
        newest.write_bytes(data)
        told = []
        assert step_of(path, told) == (2 if bytes(data) != whole else 3)
        assert len(told) == 1 and str(newest) in told[0] and str(path / PREVIOUS) in told[0]
    (path / PREVIOUS).write_bytes(data)
    with pytest.raises(CaseError) as refused:
        step_of(path, [])
    assert NEWEST in str(refused.value) and PREVIOUS in str(refused.value)


def test_damaged_checkpoints_are_never_taken(stopped, tmp_path):
    damaged_checkpoints(stopped, tmp_path, 200)


@pytest.mark.slow
def test_five_thousand_damaged_checkpoints_are_never_taken(stopped, tmp_path):
    damaged_checkpoints(stopped, tmp_path, 5000)


def test_foreign_checkpoints_are_refused_by_name(stopped, tmp_path, monkeypatch):
    path = tmp_path / "run"
    shutil.copytree(stopped, path)
    (path / PREVIOUS).unlink()
    assert step_of(path, []) == 3
    with pytest.raises(CaseError, match=r"checkpoint.h5 belongs to another case"):
        read_checkpoint(path, "title = 'another'")
    monkeypatch.setattr("smoothprofile.checkpoint.FORMAT", 9)
    with pytest.raises(CaseError, match=r"checkpoint.h5 is of format 4; .* reads format 9"):
        step_of(path, [])
    monkeypatch.undo()
    for content in (b"", b"x" * 500, b"\x89HDF\r\n\x1a\n" * 30):
        (path / NEWEST).write_bytes(content)
        with pytest.raises(CaseError, match="is no checkpoint, or is damaged"):
            step_of(path, [])
    (path / NEWEST).unlink()
    with pytest.raises(CaseError, match="holds no checkpoint"):
        step_of(path, [])


def test_a_checkpoint_of_another_version_is_taken_and_told(stopped, monkeypatch):
    monkeypatch.setattr("smoothprofile.checkpoint.version", lambda name: "9.9")
    told = []
    assert step_of(stopped, told) == 3
    assert "bits may differ" in told[0]


def test_one_run_at_a_time_works_in_a_directory(stopped, tmp_path):
    path = tmp_path / "run"
    shutil.copytree(stopped, path)
    _, directory = taken_up(path, pytest.fail)
    with directory, pytest.raises(CaseError, match="another run is at work in"):
        taken_up(path, pytest.fail)
    with taken_up(path, pytest.fail)[1]:
        pass
