"""What every test starts from: one thread, and the possibility of asking for more."""

import os

# Read once, when numba loads. Tests ask for up to four threads, whatever the machine has or its
# user has set.
os.environ["NUMBA_NUM_THREADS"] = str(max(4, os.cpu_count() or 1))

import pytest

from smoothprofile.cli import app
from smoothprofile.console import PREPARING
from smoothprofile.threads import set_thread_count


@pytest.fixture(autouse=True)
def one_thread():
    """Grids of tests are small: a second thread costs more to wake than it works off."""
    set_thread_count(1)
    yield
    set_thread_count(1)


@pytest.fixture
def spm(capsys, tmp_path, monkeypatch):
    """Run a command in an empty folder; returns exit code, standard output and error."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        with pytest.raises(SystemExit) as end:
            app([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        # Where nothing is compiled yet, the first run says that it takes long.
        return end.value.code or 0, out, err.replace(PREPARING + "\n", "")

    return call
