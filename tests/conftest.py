"""What every test starts from: one thread, and the possibility of asking for more."""

import os

# Read once, when numba loads. Tests ask for up to four threads, whatever the machine has.
os.environ.setdefault("NUMBA_NUM_THREADS", str(max(4, os.cpu_count() or 1)))

import pytest

from smoothprofile.threads import set_thread_count


@pytest.fixture(autouse=True)
def one_thread():
    """Grids of tests are small: a second thread costs more to wake than it works off."""
    set_thread_count(1)
    yield
    set_thread_count(1)
