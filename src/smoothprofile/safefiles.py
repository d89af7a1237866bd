"""Files that are whole or not there, and one sentence for those that cannot be written.

A file is written beside its place, flushed to the disk, renamed, and its directory flushed, so that
whoever reads sees the old file or the new one at every instant, also after a kill or a power cut.
"""

import errno
import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import h5py

from smoothprofile.errors import OutputError

NOT_FOR_DIRECTORIES = (errno.EINVAL, errno.ENOTSUP)


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """OutputError, naming `path` and the reason, for what the system refuses within `with`."""
    try:
        yield
    except (OSError, RuntimeError) as error:
        raise OutputError(f"{path} cannot be written: {reason(error)}.") from error


def reason(error: BaseException) -> str:
    """What the system says is wrong, in its own words or those of a library."""
    text = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return text.splitlines()[0].rstrip(".")


@contextmanager
def replacing(path: Path, keep: Path | None = None) -> Iterator["DiskFile"]:
    """A binary file to write, which takes the place of `path` at the end. OutputError if it fails.

    If it does, whatever stood there before still stands; if not, it stands at `keep`. Only where
    the directory cannot be flushed at last is the new file there, and none if none was before.
    """
    draft = path.with_name(path.name + ".new")
    unfinished = [draft] if path.exists() else [draft, path]
    try:
        with writing(path):
            with DiskFile(draft) as file:
                yield file
                file.flush_to_disk()
            if keep is not None and path.exists():
                os.replace(path, keep)
            os.replace(draft, path)
            flush_directory(path.parent)
    except BaseException:
        for left in unfinished:
            with suppress(OSError):
                left.unlink()
        raise


def write_text(path: Path, text: str) -> None:
    """Replace a file by that text, in one go."""
    with replacing(path) as file:
        file.write(text.encode("utf-8"))


@contextmanager
def replacing_hdf5(path: Path) -> Iterator[h5py.File]:
    """As `replacing`, an HDF5 file."""
    with replacing(path) as disk, hdf5_on(disk) as file:
        yield file


@contextmanager
def hdf5_on(disk: "DiskFile") -> Iterator[h5py.File]:
    """An HDF5 file to write through `disk`; the first error of its writes is raised at the end.

    HDF5 cannot close a file whose writes fail, and brings the process down when it ends.
    """
    disk.keep_errors = True
    with h5py.File(disk, "w") as file:
        yield file
    disk.keep_errors = False
    if disk.error:
        raise disk.error


class DiskFile(io.RawIOBase):
    """A new file, written in whole or with an OSError.

    With `keep_errors` the first error is kept, and what follows happens in memory alone: whoever
    writes finds what it wrote, and can come to its end.
    """

    def __init__(self, path: Path):
        self.keep_errors, self.error = False, None
        self._memory: io.BytesIO | None = None
        # A draft that a killed run left could be a link to what must stay as it is.
        with suppress(FileNotFoundError):
            os.unlink(path)
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)

    def readable(self) -> bool:
        return True

    def writable(self) -> bool:
        return True

    def seekable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        if self._memory is not None:
            return self._memory.readinto(buffer)
        return os.readv(self._handle, [buffer])

    def seek(self, offset: int, whence: int = os.SEEK_SET) -> int:
        if self._memory is not None:
            return self._memory.seek(offset, whence)
        return os.lseek(self._handle, offset, whence)

    def truncate(self, size: int | None = None) -> int:
        size = self.tell() if size is None else size
        if self._memory is None:
            try:
                os.ftruncate(self._handle, size)
                return size
            except OSError as error:
                self._go_on_in_memory(error)
        content = self._memory.getvalue()[:size].ljust(size, b"\0")
        position = self._memory.tell()
        self._memory = io.BytesIO(content)
        self._memory.seek(position)
        return size

    def write(self, data: Any) -> int:
        left = memoryview(data).cast("B")
        total = len(left)
        try:
            while left and self._memory is None:
                left = left[os.write(self._handle, left) :]
        except OSError as error:
            self._go_on_in_memory(error)
        if self._memory is not None:
            self._memory.write(left)
        return total

    def flush_to_disk(self) -> None:
        """Have the system put what was written on the disk."""
        os.fsync(self._handle)

    def close(self) -> None:
        if not self.closed:
            os.close(self._handle)
        super().close()

    def _go_on_in_memory(self, error: OSError) -> None:
        if not self.keep_errors:
            raise error
        self.error, position = error, os.lseek(self._handle, 0, os.SEEK_CUR)
        self._memory = io.BytesIO(os.pread(self._handle, os.fstat(self._handle).st_size, 0))
        self._memory.seek(position)


def flush_directory(path: Path) -> None:
    """Have the system put the names in a directory on the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        # Some network file systems cannot, and rename in order without being asked.
        if error.errno not in NOT_FOR_DIRECTORIES:
            raise
    finally:
        os.close(handle)
