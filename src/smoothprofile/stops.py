"""When a run has to stop before its end: signals, a limit of wall-clock time, the end of a job.

The step under way is finished first. A second signal of the same kind stops at once.
"""

import os
import signal
import time as clock
from collections.abc import Callable

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGUSR1)
BEFORE_JOB_ENDS = 60.0
"""Seconds that are left to write a checkpoint and a report before Slurm ends a job."""
JOB_END = "SLURM_JOB_END_TIME"


class Stops:
    """Watches for reasons to stop, within `with`."""

    def __init__(self, limit: float | None, tell: Callable[[str], None]):
        """limit: seconds of wall clock from now on. tell: takes a sentence at the first signal."""
        self._tell, self._asked = tell, ""
        self._end = clock.monotonic() + limit if limit else None
        self._job_end = _job_end()
        self._before: dict[int, object] = {}

    def __enter__(self) -> "Stops":
        for number in SIGNALS:
            self._before[number] = signal.signal(number, self._note)
        return self

    def __exit__(self, *_) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def reason(self) -> str:
        """Why to stop now, in words; empty to go on."""
        if self._asked:
            return self._asked
        if self._end is not None and clock.monotonic() >= self._end:
            return "output.stop_after"
        if self._job_end is not None and clock.time() >= self._job_end - BEFORE_JOB_ENDS:
            return "the end of the job"
        return ""

    def _note(self, number: int, _frame: object) -> None:
        name = signal.Signals(number).name
        if self._asked == name:
            raise KeyboardInterrupt
        self._asked = name
        self._tell(f"{name}: stopping after this step; the same signal again stops at once.")


def _job_end() -> float | None:
    """When Slurm ends this job, in seconds of the clock; None without Slurm."""
    try:
        return float(os.environ[JOB_END])
    except (KeyError, ValueError):
        return None
