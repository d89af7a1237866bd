"""One place owns the number of threads of both pools: numba's kernels and ducc0's transforms.

Numba's OpenMP workers spin after each kernel and starve the transforms that follow, so they are
told to sleep instead. OpenMP reads that wish once, when its library loads, so that the package's
`__init__`, which always runs first, is where it is said.
"""

import numba

from smoothprofile.errors import CaseError


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
            f"threads is {count}; it must be between 1 and {available_threads()} on this machine."
        )
    numba.set_num_threads(count)
