"""Runs that are killed, disks that fill up: what is left and what is said."""

import errno
import multiprocessing
import os
import random
import resource
import shutil
import signal
import time
from itertools import product
from pathlib import Path

import gsd.hoomd
import h5py
import numpy as np
import pytest

from restarts import files_digest, observer
from smoothprofile.checkpoint import NEWEST, PREVIOUS, read_checkpoint
from smoothprofile.config import load_case
from smoothprofile.running import taken_up
from smoothprofile.runrecord import read_run
from test_resume import body, box, touching

CALLS = ("write", "fsync", "replace", "open", "ftruncate")
HANGS = 120.0
FAULTS = (errno.ENOSPC, errno.EACCES, errno.EIO)


def case_file(tmp_path, **output):
    """Two bodies in contact with all kinds of files, a checkpoint at every step."""
    case = touching()
    case["time"]["max_steps"] = 12
    case["output"] = {"every": 1, "fields_every": 0.02, "checkpoint_every": 1e-9} | output
    file = tmp_path / "case.toml"
    file.write_text(load_case(case).to_toml(), encoding="utf-8")
    return file


@pytest.fixture(scope="module")
def children():
    """Where processes come from that start with everything loaded."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["warmed"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("NUMBA_THREADING_LAYER", "workqueue")
        patch.setenv("NUMBA_NUM_THREADS", "1")
        patch.setenv("PYTHONPATH", str(Path(__file__).parent))
        multiprocessing.forkserver.ensure_running()
    return context


def spm_run(children, case, path, seconds=None, largest=None) -> int:
    """`spm run` in a process of its own, killed after so many seconds; its exit status.

    largest: bytes that no file may exceed, by the system's own limit.
    """
    child = children.Process(target=warmed_run, args=(str(case), str(path), largest))
    child.start()
    child.join(HANGS if seconds is None else seconds)
    if child.is_alive():
        child.kill()
        child.join()
    return child.exitcode


def warmed_run(case, path, largest):
    import warmed

    if largest is not None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest, resource.RLIM_INFINITY))
    warmed.spm_run(case, path)


def assert_readable(path):
    """Every file that is there can be read, at whatever instant the run was killed."""
    if not (path / "case.toml").is_file():
        return
    if not (path / "history.csv").is_file():
        return
    record = read_run(path)
    lengths = {column.size for column in record.history.values()}
    assert len(lengths) <= 1
    if (path / "fields.h5").is_file():
        with h5py.File(path / "fields.h5") as file:
            assert not np.isnan(file["velocity"][()]).any()
    if (path / "trajectory.gsd").is_file() and (path / "trajectory.gsd").stat().st_size:
        with gsd.hoomd.open(str(path / "trajectory.gsd")) as file:
            assert all(frame.particles.N == 2 for frame in file)
    for name in (NEWEST, PREVIOUS):
        if (path / name).exists():
            read_checkpoint(path, record.case_toml, pytest.fail)


def kill_and_resume(children, tmp_path, count):
    """`count` runs killed at random moments until they end; how many kills there were."""
    case, choose = case_file(tmp_path), random.Random(1)
    spm_run(children, case, tmp_path / "first")
    began = time.monotonic()
    assert spm_run(children, case, tmp_path / "whole") == 0
    whole, takes = files_digest(tmp_path / "whole"), time.monotonic() - began
    kills = 0
    for number in range(count):
        path = tmp_path / f"{number}"
        statuses = [spm_run(children, case, path, choose.uniform(0.0, 1.0) * takes)]
        while statuses[-1] != -signal.SIGKILL:
            # It was faster than the first, which the machine had less time for.
            shutil.rmtree(path)
            takes *= 0.9
            statuses = [spm_run(children, case, path, choose.uniform(0.0, 1.0) * takes)]
        while statuses[-1] == -signal.SIGKILL and len(statuses) < 4:
            assert_readable(path)
            statuses.append(spm_run(children, case, path, choose.uniform(0.0, 1.0) * takes))
        if statuses[-1] == -signal.SIGKILL:
            statuses.append(spm_run(children, case, path))
        # It says 2 if there was nothing left to do: the last kill came after its end.
        assert statuses[-1] in (0, 2) and (path / "summary.json").is_file(), statuses
        kills += statuses.count(-signal.SIGKILL)
        assert files_digest(path) == whole
        assert not list(path.glob("**/*.new"))
        shutil.rmtree(path)
    return kills


def test_killed_runs_end_with_the_same_bits(children, tmp_path):
    assert kill_and_resume(children, tmp_path, 3) >= 3


@pytest.mark.slow
def test_two_hundred_killed_runs_end_with_the_same_bits(children, tmp_path):
    kills = kill_and_resume(children, tmp_path, 200)
    print(f"200 runs, {kills} kills")
    assert kills >= 200


class Disk:
    """The system calls of the files of a run; the one numbered `failing` fails, and all after it.

    `short`: it writes half of its bytes first, as a disk that fills up does.
    """

    def __init__(self, patch, failing=None, number=errno.ENOSPC, short=False, once=False):
        self.count, self.failing, self.number = 0, failing, number
        self.short, self.once, self.log = short, once, []
        for name in CALLS:
            patch.setattr(os, name, self._wrapped(name, getattr(os, name)))

    def _wrapped(self, name, real):
        def call(*arguments, **options):
            writes = name != "open" or arguments[1] & (os.O_WRONLY | os.O_RDWR)
            if not writes or not self._is_of_run(arguments[0]):
                return real(*arguments, **options)
            self.count += 1
            bad = self.failing is not None and (
                self.count == self.failing or (self.count > self.failing and not self.once)
            )
            if not bad:
                return real(*arguments, **options)
            self.log.append(name)
            if name == "write" and self.short and self.count == self.failing:
                return real(arguments[0], arguments[1][: len(arguments[1]) // 2])
            raise OSError(self.number, os.strerror(self.number))

        return call

    @staticmethod
    def _is_of_run(target):
        try:
            name = os.readlink(f"/proc/self/fd/{target}") if isinstance(target, int) else target
        except OSError:
            return False
        return "faulty" in str(name)


def faulty_run(tmp_path, spm, **fault):
    """A run in the directory `faulty` whose disk fails from one call on; code, error, its disk."""
    path = tmp_path / "faulty"
    shutil.rmtree(path, ignore_errors=True)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("smoothprofile.running.write_report", lambda path: path / "report.html")
        disk = Disk(patch, **fault)
        code, _, err = spm("run", tmp_path / "case.toml", "--out", path)
    lines = [line for line in err.splitlines() if not line.startswith("Note: ")]
    return code, lines, disk, path


def small_case_file(tmp_path):
    case = box(body([2.4, 3.0, 3.0], "free"), body([5.0, 3.0, 3.0]), time={"max_steps": 3})
    case["output"] = {"every": 1, "fields_every": 0.04, "checkpoint_every": 1e-9}
    (tmp_path / "case.toml").write_text(load_case(case).to_toml(), encoding="utf-8")


def assert_as_documented(tmp_path, spm, whole, **fault):
    """One sentence that names a file and the reason; then, with room again, the same end."""
    code, lines, disk, path = faulty_run(tmp_path, spm, **fault)
    where = f"{fault}: {disk.log[:1]}: {lines}"
    reason = os.strerror(fault.get("number", errno.ENOSPC))
    failed = [line for line in lines if reason in line]
    if not failed:
        # A write that was short once goes on where it left off.
        assert disk.short and disk.once and code == 0, where
        assert files_digest(path) == whole, where
        return
    assert all("cannot be" in line and line.endswith(".") for line in failed), where
    assert not any("Traceback" in line for line in lines), where
    # A checkpoint that fails does not stop a run; a table or a field does.
    assert code == (0 if all("checkpoint.h5" in line for line in failed) else 2), where
    if code == 0:
        assert files_digest(path) == whole, where
        return
    assert not (path / "summary.json").exists() or "run.json" in failed[-1], where
    if (path / "case.toml").is_file():
        simulation, directory = taken_up(path, pytest.fail)
        with directory:
            simulation.run(observer(simulation, directory))
            directory.finish(simulation)
        assert files_digest(path) == whole, where


def every_fault(tmp_path, spm, stride, faults, ways=None):
    """`ways`: of the four ways to fail, (short, once), how many at each place; all if None."""
    small_case_file(tmp_path)
    code, lines, disk, path = faulty_run(tmp_path, spm)
    assert code == 0, lines
    whole, calls = files_digest(path), disk.count
    assert calls > 100
    for place, failing in enumerate(range(1, calls + 1, stride)):
        for number, way in product(faults, range(ways or 4)):
            short, once = divmod((place + way) % 4, 2)
            fault = {"number": number, "short": bool(short), "once": bool(once)}
            assert_as_documented(tmp_path, spm, whole, failing=failing, **fault)


@pytest.mark.slow
def test_every_write_of_a_run_may_fail(tmp_path, spm):
    every_fault(tmp_path, spm, 1, FAULTS)


def test_writes_may_fail(tmp_path, spm):
    every_fault(tmp_path, spm, 31, FAULTS[:1], ways=1)


def test_files_that_may_not_grow_stop_a_run_by_name(children, tmp_path):
    """The system itself refuses, in libraries too: no signal, no traceback, nothing lost."""
    case = case_file(tmp_path, checkpoint_every=1e9)
    assert spm_run(children, case, tmp_path / "whole") == 0
    whole = files_digest(tmp_path / "whole")
    for largest in (0, 700, 3000, 20_000):
        path = tmp_path / f"{largest}"
        assert spm_run(children, case, path, largest=largest) == 2
        if not (path / "case.toml").exists():
            shutil.rmtree(path)
        assert spm_run(children, case, path) == 0
        assert files_digest(path) == whole


def test_a_run_goes_on_without_room_for_its_checkpoints(children, tmp_path):
    case = case_file(tmp_path)
    assert spm_run(children, case, tmp_path / "run", largest=100_000) == 0
    assert not (tmp_path / "run" / NEWEST).exists()
    assert spm_run(children, case, tmp_path / "whole") == 0
    assert (tmp_path / "whole" / NEWEST).stat().st_size > 100_000
    assert files_digest(tmp_path / "run") == files_digest(tmp_path / "whole")
