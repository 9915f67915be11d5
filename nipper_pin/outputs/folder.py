"""Folders whose files appear together."""

from __future__ import annotations

import ctypes
import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import InputError
from .check import check_folder
from .file import synchronise

_EXCHANGE, _HERE = 2, -100  # RENAME_EXCHANGE and AT_FDCWD of Linux


@contextmanager
def complete_folder(path: str | Path, ours: Collection[str]) -> Iterator[Path]:
    """Give an empty folder whose files take their place in a folder in one step.

    What else lies in the folder stays; files of ``ours`` that are not written again go. If the
    folder is the working directory of this process, or a mount point, it cannot be exchanged: then
    the old files of ``ours`` go first, and the new ones come one by one, never beside old ones.

    Args:
        path: The folder; it is made with those above it. A link is followed.
        ours: Names of all files that such a folder may have been given before.

    Yields:
        The folder to write into.

    Raises:
        InputError: The folder cannot be written.
    """
    check_folder(path)
    target = Path(path)
    try:
        target = target.resolve(strict=False)
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(
            dir=target.parent, prefix=f".{target.name[:100]}-"
        ) as home:
            new = Path(home) / "new"
            new.mkdir()
            yield new
            written = [file.name for file in new.iterdir()]
            for name in written:
                synchronise(new / name)
            if not target.exists():
                synchronise(new)
                new.replace(target)
            elif not _exchanged(new, target, {*ours, *written}):
                _moved(new, target, ours, written)
        synchronise(target.parent)
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or error
        message = f"{path}: cannot be written ({reason}); name another folder"
        raise InputError(message, folder=str(path)) from error


def _exchanged(new: Path, target: Path, replaced: Collection[str]) -> bool:
    """Put a new folder, with all else that the old one holds, in the place of the old one."""
    if target == Path.cwd() or target in Path.cwd().parents or target.is_mount():
        return False
    for item in target.iterdir():
        if item.name in replaced:
            continue
        if item.is_dir() and not item.is_symlink():
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
    if code in {errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EBUSY, errno.EXDEV}:
        return False
    raise OSError(code, os.strerror(code))


def _moved(new: Path, target: Path, ours: Collection[str], written: Collection[str]) -> None:
    """Replace the files of a folder that stays: the old ones go before the first new one comes."""
    for name in ours:
        with suppress(FileNotFoundError):
            if stat.S_ISREG((target / name).lstat().st_mode):
                (target / name).unlink()
    for name in written:
        (new / name).replace(target / name)
    synchronise(target)
