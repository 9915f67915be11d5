"""Files that appear only when they are complete."""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import InputError
from ..texts import followed
from .hidden import hidden_file


@contextmanager
def complete_file(path: str | Path) -> Iterator[Path]:
    """Give a temporary path whose content takes the place of a file only if nothing fails.

    The file keeps its mode; a new one has that of the umask. A link is followed. A device or a pipe
    is written into and stays what it is. File and folder are synchronised with the disk, so that
    after a crash of the machine the old or the new content is there.

    Yields:
        An empty temporary file of a name that nobody else uses.

    Raises:
        InputError: The file cannot be written.
    """
    target = followed(path)
    try:
        mode = _mode(target)
        with _place(target, mode) as partial:
            yield partial
            if mode is not None and not stat.S_ISREG(mode):
                with partial.open("rb") as source, target.open("wb") as stream:
                    shutil.copyfileobj(source, stream)
                return
            if mode is not None:
                partial.chmod(stat.S_IMODE(mode))
            synchronise(partial)
            partial.replace(target)
        synchronise(target.parent)
    except OSError as error:
        raise _unwritable(path, error) from error


def synchronise(path: Path) -> None:
    """Wait until a file, or the entries of a folder, are on the disk.

    Raises:
        OSError: They cannot be written.
    """
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _mode(target: Path) -> int | None:
    """Type and permissions of what is there; None if nothing is."""
    try:
        found = target.stat().st_mode
    except FileNotFoundError:
        return None
    if stat.S_ISDIR(found):
        raise IsADirectoryError(0, "it is a folder")
    return found


@contextmanager
def _place(target: Path, mode: int | None) -> Iterator[Path]:
    """An empty file beside the target, or among temporary files if that is no regular file."""
    if mode is None or stat.S_ISREG(mode):
        # Nobody else may read what replaces a private file; of a new one the umask decides.
        with hidden_file(target, 0o666 if mode is None else 0o600) as partial:
            yield partial
        return
    with tempfile.NamedTemporaryFile(prefix=f".{target.name[:50]}.", suffix=".partial") as item:
        yield Path(item.name)


def _unwritable(path: str | Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(f"{path}: cannot be written ({reason})", file=str(path))
