"""One place owns the number of threads of both pools: numba's kernels and ducc0's transforms.

Numba's OpenMP workers spin after each kernel and starve the transforms that follow, so they are
told to sleep instead. OpenMP reads that wish once, when its library loads, so that the package's
`__init__`, which always runs first, is where it is said.
"""

import math

import numba

from smoothprofile.errors import CaseError

WARM_UP = 2
TRIES = 5
MUCH_SLOWER = 1.3
_asked = False


def available_threads() -> int:
    """How many threads this process may use: the most that can be asked for."""
    return numba.config.NUMBA_NUM_THREADS


def thread_count() -> int:
    """How many threads kernels and transforms use now."""
    return numba.get_num_threads()


def set_thread_count(count: int) -> None:
    """Use `count` threads from now on; CaseError unless 1 ≤ count ≤ available_threads()."""
    if not 1 <= count <= available_threads():
        raise CaseError(
            f"threads is {count}; it must be from 1 to {available_threads()}, the processors that "
            "this process may use, or as many as NUMBA_NUM_THREADS says."
        )
    global _asked
    _asked = True
    numba.set_num_threads(count)


class ThreadTrial:
    """How many threads take the shortest steps, found on the first steps of a run.

    All, then half as many, and so on unless that is much slower: on small grids waking threads
    costs more than they work off, by how much differs between machines. No bit of a result depends
    on it. A number asked for by `set_thread_count` is kept. The first steps, which may compile,
    do not count.
    """

    def __init__(self):
        most = available_threads()
        halved = [] if _asked else [most >> i for i in range(most.bit_length())]
        self._plan = halved[:1] * WARM_UP + [count for count in halved for _ in range(TRIES)]
        self._warming = WARM_UP
        self._best = (math.inf, most)
        self._now = math.inf

    def begin(self) -> None:
        """Before a step."""
        if self._plan:
            numba.set_num_threads(self._plan[0])

    def end(self, seconds: float) -> None:
        """After a step, which took so long."""
        if not self._plan:
            return
        count = self._plan.pop(0)
        if self._warming:
            self._warming -= 1
            return
        self._now = min(self._now, seconds)
        if self._plan[:1] == [count]:
            return
        if self._now > MUCH_SLOWER * self._best[0]:
            self._plan = []
        self._best, self._now = min(self._best, (self._now, count)), math.inf
        if not self._plan:
            numba.set_num_threads(self._best[1])
