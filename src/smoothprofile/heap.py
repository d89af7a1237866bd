"""Where large arrays live that come and go: apart from the heap, so that it does not fray.

glibc serves large requests by pages of their own, which go back when they are freed; but once a
block of up to 32 MiB was freed, the next ones of its size come from the heap. The buffers of
checkpoints, of ever other sizes, then leave holes that nothing fills.
"""

import ctypes
from contextlib import suppress

LARGE = 1 << 20
"""Bytes of the smallest block that has pages of its own."""
_MMAP_THRESHOLD = -3
"""Of glibc's malloc.h."""


def keep_large_blocks_apart() -> None:
    """Ask for it, from now on; nothing to do where the C library is another."""
    with suppress(OSError, AttributeError):
        ctypes.CDLL("libc.so.6").mallopt(_MMAP_THRESHOLD, LARGE)
