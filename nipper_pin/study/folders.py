"""Folders that hold the results of one piece of work, and of no other."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..outputs import complete_file
from ..texts import MOST_JSON, read_text


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


def claim(
    folder: Path, file_name: str, here: Mapping[str, Any], work: str, names: Mapping[str, str]
) -> None:
    """Make a folder that of a piece of work, or see that it is already.

    Args:
        folder: The folder, made if it does not exist.
        file_name: Name of the file in it that says what the work is.
        here: What the results depend on.
        work: What such work is called, for messages.
        names: What keys of ``here`` are called, for messages; others by themselves.

    Raises:
        InputError: It cannot be written, or holds the results of other work.
    """
    make_folder(folder)
    file = folder / file_name
    if not file.exists():
        with complete_file(file) as partial:
            partial.write_text(json.dumps(here, indent=1) + "\n", encoding="utf-8")
        return
    try:
        stored = json.loads(read_text(file, MOST_JSON))
        other = [key for key in here if stored.get(key) != here[key]]
    except (OSError, ValueError, AttributeError, RecursionError) as error:
        message = f"{file}: says of no {work} what it is, or is damaged ({error})"
        raise InputError(message, file=str(file)) from error
    if other:
        words = ", ".join(names.get(key, key) for key in other)
        message = (
            f"{folder}: holds the results of another {work} (they differ in: {words}); give "
            "another folder with --out, or remove this one"
        )
        raise InputError(message, folder=str(folder), differences=other)
