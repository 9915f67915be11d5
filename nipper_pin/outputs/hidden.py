"""Hidden files and folders for what is not complete yet; those of dead processes are removed.

Whoever works in one holds a lock on it, which the system gives back when the process ends, however
it ends. The names are numbered, and the first number that is free is taken: a name without a lock
is that of a process that was killed, and is removed first. So what kills leave does not add up.
"""

from __future__ import annotations

import fcntl
import os
import shutil
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path

# File systems allow 255 bytes; the rest of a name needs fewer than these leave.
_LONGEST_START = 200


@contextmanager
def hidden_file(target: Path, allowed: int) -> Iterator[Path]:
    """Give an empty file beside another, and remove it at the end if it is still there.

    Args:
        target: The other file; a name that begins like its own is given.
        allowed: Permissions of the new one, less those of the umask.

    Raises:
        OSError: There can be none.
    """

    def made(path: Path) -> int:
        return os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, allowed)

    path, handle = _taken(target, made)
    try:
        yield path
    finally:
        _given_back(path, handle)


@contextmanager
def hidden_folder(target: Path) -> Iterator[Path]:
    """Give an empty folder beside a target, and remove it with all that it holds at the end.

    Args:
        target: A name that begins like its own is given.

    Raises:
        OSError: There can be none.
    """

    def made(path: Path) -> int:
        path.mkdir(0o700)
        try:
            return os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
        except FileNotFoundError as error:
            # Another process has taken it for a dead one's, since it had no lock yet.
            raise FileExistsError from error

    path, handle = _taken(target, made)
    try:
        # One folder deeper, so that whoever locks the folder that this one lies in does not wait.
        inner = path / "new"
        inner.mkdir()
        yield inner
    finally:
        _given_back(path, handle)


def _taken(target: Path, make: Callable[[Path], int]) -> tuple[Path, int]:
    """Make something under the first number that no living process has, and lock it."""
    start = os.fsdecode(os.fsencode(target.name)[:_LONGEST_START])

    def numbered(number: int) -> Path:
        return target.with_name(f".{start}.{number}.partial")

    number, handle = 0, None
    while handle is None:
        _remove_dead(numbered(number))
        handle = _locked(numbered(number), make)
        number += handle is None
    later = count(number + 1)
    while os.path.lexists(path := numbered(next(later))):
        _remove_dead(path)
    return numbered(number), handle


def _locked(path: Path, make: Callable[[Path], int]) -> int | None:
    """The handle of something new that is locked; None where this name is another process's."""
    try:
        handle = make(path)
    except FileExistsError:
        return None
    # Where there are no locks, all that is there counts as that of a living process.
    with suppress(OSError):
        fcntl.flock(handle, fcntl.LOCK_EX)
    if _is_at(path, handle):
        return handle
    os.close(handle)
    return None


def _given_back(path: Path, handle: int) -> None:
    """Remove what is still there; once it was renamed, its name may be another process's."""
    if _is_at(path, handle):
        _gone(path)
    os.close(handle)


def _remove_dead(path: Path) -> None:
    """Remove what has this name if no living process has locked it."""
    with suppress(OSError):
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_at(path, handle):
                _gone(path)
        finally:
            os.close(handle)


def _is_at(path: Path, handle: int) -> bool:
    """Whether a handle is that of what has this name now."""
    with suppress(FileNotFoundError):
        return os.path.samestat(path.lstat(), os.fstat(handle))
    return False


def _gone(path: Path) -> None:
    """Remove a file or a folder; what cannot be removed is left to the next process."""
    with suppress(OSError):
        if stat.S_ISDIR(path.lstat().st_mode):
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink()
