"""Folders whose files appear together."""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import shutil
from collections.abc import Collection, Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from ..errors import InputError
from ..texts import followed
from .check import check_folder
from .file import synchronise
from .hidden import hidden_folder

_EXCHANGE, _HERE = 2, -100  # RENAME_EXCHANGE and AT_FDCWD of Linux
_NO_EXCHANGE = {
    errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EBUSY, errno.EXDEV, errno.EACCES, errno.EPERM,
}  # fmt: skip
_NOTHING = ".nipper-pin.there-is-none"


@contextmanager
def complete_folder(path: str | Path, ours: Collection[str]) -> Iterator[Path]:
    """Give an empty folder whose files take their place in a folder in one step.

    What else lies in the folder stays; files of ``ours`` that are not written again go. A folder
    that is the working directory of this process, or where something is mounted, cannot be
    exchanged: the new files are written in it, and take the place of the old ones one by one once
    they are complete, never beside old ones.

    Args:
        path: The folder; it is made with those above it. A link is followed.
        ours: Names of all files that such a folder may have been given before.

    Yields:
        The folder to write into.

    Raises:
        InputError: The folder cannot be written.
    """
    check_folder(path)
    target = followed(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        stays = _stays(target)
        with hidden_folder(target / target.name if stays else target) as home:
            new = home / target.name
            new.mkdir()
            yield new
            _placed(new, target, ours, stays=stays)
        synchronise(target if stays else target.parent)
    except InputError as error:
        # Of a file in it: where it was to be, not where it was written.
        if str(new) not in error.message:
            raise
        message = error.message.replace(str(new), str(path))
        raise InputError(message, folder=str(path)) from error
    except OSError as error:
        raise _unwritable(path, error) from error


def _stays(target: Path) -> bool:
    """Whether a folder is there that cannot be exchanged for another one beside it."""
    if not target.exists():
        return False
    if target in (Path.cwd(), *Path.cwd().parents) or not os.access(target.parent, os.W_OK):
        return True
    # Of all that is mounted, also of the same file system, the system tells only by what fails.
    try:
        os.rename(target.parent / _NOTHING, target / _NOTHING)
    except FileNotFoundError:
        return False
    except OSError:
        pass
    return True


def _placed(new: Path, target: Path, ours: Collection[str], *, stays: bool) -> None:
    """Let the files of a new folder take their place."""
    for item in (*new.rglob("*"), new):
        synchronise(item)
    with _alone(target.parent):
        if not target.exists():
            new.replace(target)
            return
        replaced = {name for name in ours if not _is_folder(target / name)}
        for item in new.iterdir():
            if _is_folder(target / item.name) and not item.is_dir():
                raise IsADirectoryError(errno.EISDIR, f"{item.name} in it is a folder")
            replaced.add(item.name)
        if stays or not _exchanged(new, target, replaced):
            _moved(new, target, replaced)


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Wait until no other process exchanges anything in a folder, where that can be known."""
    with ExitStack() as stack:
        with suppress(OSError):
            handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
            stack.callback(os.close, handle)
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield


def _exchanged(new: Path, target: Path, replaced: Collection[str]) -> bool:
    """Put a new folder, with all else that the old one holds, in the place of the old one."""
    for item in target.iterdir():
        if item.name in replaced:
            continue
        if _is_folder(item):
            shutil.copytree(item, new / item.name, symlinks=True, copy_function=_linked)
        else:
            _linked(item, new / item.name)
    shutil.copystat(target, new)
    synchronise(new)
    return _swapped(new, target)


def _linked(source: str | Path, target: str | Path) -> None:
    """A second name of a file; a copy where there can be none."""
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, target, follow_symlinks=False)


def _swapped(one: Path, other: Path) -> bool:
    """Exchange two folders in one step; False where the system has no such call."""
    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    done = rename(_HERE, os.fsencode(one), _HERE, os.fsencode(other), _EXCHANGE)
    if done == 0:
        return True
    code = ctypes.get_errno()
    if code in _NO_EXCHANGE:
        return False
    raise OSError(code, os.strerror(code))


def _moved(new: Path, target: Path, replaced: Collection[str]) -> None:
    """Replace the files of a folder that stays: the old ones go before the first new one comes."""
    written = [name for name in replaced if os.path.lexists(new / name)]
    old = new.parent.with_name("old")
    old.mkdir()
    try:
        for name in replaced:
            with suppress(FileNotFoundError):
                (target / name).replace(old / name)
        for name in written:
            (new / name).replace(target / name)
    except BaseException:
        for name in written:
            if not (new / name).exists():
                (target / name).replace(new / name)
        for file in old.iterdir():
            file.replace(target / file.name)
        raise
    synchronise(target)


def _unwritable(path: str | Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    if isinstance(error, shutil.Error):
        # One of what may be many, each with two names and a reason.
        reason = error.args[0][0][-1]
    message = f"{path}: cannot be written ({reason}); name another folder"
    return InputError(message, folder=str(path))
