"""Where a run comes from: versions, machine, case; and which process holds its directory."""

import fcntl
import hashlib
import os
import platform
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path
from typing import IO, Any

from smoothprofile.errors import CaseError, OutputError
from smoothprofile.safefiles import reason
from smoothprofile.threads import available_threads

LOCK = "lock"
LIBRARIES = ("smoothprofile", "numpy", "scipy", "numba", "ducc0", "h5py", "gsd")


def versions() -> dict[str, str]:
    """Of Python and of every library that a number passes through."""
    return {"python": platform.python_version()} | {name: version(name) for name in LIBRARIES}


def machine() -> dict[str, Any]:
    """What a timing depends on: system, processor, number of cores and of threads to use."""
    processor = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.is_file():
        names = [line for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        processor = names[0].partition(":")[2].strip() if names else processor
    return {
        "system": platform.platform(),
        "processor": processor,
        "cores": os.cpu_count(),
        "threads": available_threads(),
    }


def case_hash(case_toml: str) -> str:
    """SHA-256 of the case as it was run, in hexadecimal digits."""
    return hashlib.sha256(case_toml.encode()).hexdigest()


def now() -> str:
    """The time of the clock, in UTC."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def lock(path: Path) -> IO:
    """Hold a directory for this process; CaseError if another run holds it.

    OutputError if the file of the lock cannot be made.
    """
    name = path / LOCK
    while True:
        try:
            handle = name.open("w")
        except OSError as error:
            raise OutputError(f"{name} cannot be written: {reason(error)}.") from error
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            handle.close()
            raise CaseError(f"another run is at work in {path}.") from None
        except OSError:
            # A file system without locks: two runs in one directory are then up to its user.
            return handle
        if _is_at(name, handle):
            return handle
        # The run that held it removed it between our opening and locking it.
        handle.close()


def unlock(path: Path, handle: IO) -> None:
    """Let the directory go. Whoever waits for the lock finds that it is no longer the file."""
    (path / LOCK).unlink(missing_ok=True)
    handle.close()


def _is_at(name: Path, handle: IO) -> bool:
    try:
        there, held = name.stat(), os.fstat(handle.fileno())
    except FileNotFoundError:
        return False
    return (there.st_dev, there.st_ino) == (held.st_dev, held.st_ino)
