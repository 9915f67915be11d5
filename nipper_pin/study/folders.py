"""Folders that hold the results of one piece of work, and of no other."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from ..errors import InputError


def make_folder(folder: str | Path) -> None:
    """Make a folder if it does not exist.

    Raises:
        InputError: It cannot be made.
    """
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"{folder}: cannot be made a folder ({error.strerror or error})"
        raise InputError(message, folder=str(folder)) from error


@contextmanager
def alone_in(folder: str | Path, *, shared: bool = False) -> Iterator[None]:
    """Be the only process that works in a folder, as far as its file system has locks for folders.

    The system gives the lock back when the process ends, however it ends.

    Args:
        folder: The folder, made if it does not exist.
        shared: Let others in that share it, too.

    Raises:
        InputError: Another process works in it, or it cannot be made.
    """
    make_folder(folder)
    with ExitStack() as stack:
        with suppress(OSError):
            handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            stack.callback(os.close, handle)
            try:
                how = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
                fcntl.flock(handle, how | fcntl.LOCK_NB)
            except BlockingIOError as error:
                message = f"{folder}: another process works in it; wait for it, or give --out"
                raise InputError(message, folder=str(folder)) from error
        yield
