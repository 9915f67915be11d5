"""Who computes what, where several processes work in one folder."""

from __future__ import annotations

import errno
import fcntl
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ....errors import InputError

# Byte of the file that locks the whole folder; the following bytes lock chunks.
_FOLDER = 0
_BUSY = (errno.EACCES, errno.EAGAIN)


class Locks:
    """Locks of single bytes of one file, one byte a chunk.

    The system gives them back when a process ends, however it ends; they hold between machines
    wherever the file system passes POSIX locks on. Threads of one process do not lock each other
    out.

    Args:
        file: The file; made if it does not exist, and left there.
        needed: Whether to refuse a file system without locks. Where nobody else computes the same
            chunks they are not needed.

    Raises:
        InputError: The file cannot be made, or has no locks and they are needed.
    """

    def __init__(self, file: Path, *, needed: bool) -> None:
        """Open the file."""
        self._file, self._needed = file, needed
        try:
            self._handle = os.open(file, os.O_RDWR | os.O_CREAT, 0o666)
        except OSError as error:
            message = f"{file}: cannot be written ({error.strerror or error})"
            raise InputError(message, file=str(file)) from error

    def close(self) -> None:
        """Give back all locks."""
        os.close(self._handle)

    def take(self, number: int) -> bool:
        """Take a chunk if no other process has it."""
        return self._lock(fcntl.LOCK_EX | fcntl.LOCK_NB, 1 + number)

    def release(self, number: int) -> None:
        """Give a chunk back."""
        self._lock(fcntl.LOCK_UN, 1 + number)

    @contextmanager
    def folder(self) -> Iterator[None]:
        """Lock the whole folder; waits until no other process holds it."""
        self._lock(fcntl.LOCK_EX, _FOLDER)
        try:
            yield
        finally:
            self._lock(fcntl.LOCK_UN, _FOLDER)

    def _lock(self, how: int, byte: int) -> bool:
        try:
            fcntl.lockf(self._handle, how, 1, byte)
        except OSError as error:
            if error.errno in _BUSY:
                return False
            if self._needed:
                message = (
                    f"{self._file}: this file system has no locks ({error.strerror or error}), so "
                    "two processes could compute the same; give --chunks, or another folder"
                )
                raise InputError(message, file=str(self._file)) from error
        return True
