"""What children that run a small case start from: all kernels are loaded and have run once.

Numba's own thread pool survives a fork, which OpenMP's does not; no bit depends on which it is.
"""

import os
import tempfile
from pathlib import Path

from numba.np.ufunc import parallel

from restarts import run_stopping
from smoothprofile import running
from smoothprofile.cli import app
from test_resume import touching

with tempfile.TemporaryDirectory() as folder:
    run_stopping(touching(), Path(folder) / "run", (3,))


def spm_run(case: str, path: str) -> None:
    """The command, without figures, which take longer than small runs."""
    quiet = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(quiet, stream)
    # A sibling that was killed may have died holding the lock that all of them share.
    parallel._backend_init_process_lock = None
    running.write_report = lambda directory: directory / "report.html"
    app(["run", case, "--out", path, "--resume-if-exists"])
