"""Files that appear only when they are complete."""

from __future__ import annotations

import os
import secrets
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import InputError

# Names of partial files begin like those of their targets, within what file systems allow.
_LONGEST_START = 100


@contextmanager
def complete_file(path: str | Path) -> Iterator[Path]:
    """Give a temporary path whose content takes the place of a file only if nothing fails.

    The file keeps its mode; a new one has that of the umask. A link is followed. A device or a pipe
    is written into and stays what it is. File and folder are synchronised with the disk, so that
    after a crash of the machine the old or the new content is there.

    Args:
        path: The file.

    Yields:
        An empty temporary file of a name that nobody else uses.

    Raises:
        InputError: The file cannot be written.
    """
    try:
        target = Path(path).resolve(strict=False)
        mode = _mode(target)
        partial = _partial(target, mode)
    except (OSError, RuntimeError) as error:
        raise _unwritable(path, error) from error
    try:
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
    finally:
        # Where no file can be there is none to remove, and the first error is the one to tell.
        with suppress(OSError):
            partial.unlink()


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


def _partial(target: Path, mode: int | None) -> Path:
    """An empty file beside the target, or among temporary files if that is no regular file."""
    start = f".{target.name[:_LONGEST_START]}."
    if mode is not None and not stat.S_ISREG(mode):
        handle, name = tempfile.mkstemp(prefix=start, suffix=".partial")
        os.close(handle)
        return Path(name)
    partial = target.with_name(f"{start}{secrets.token_hex(8)}.partial")
    # Nobody else may read what replaces a private file; of a new one the umask decides.
    allowed = 0o666 if mode is None else 0o600
    os.close(os.open(partial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, allowed))
    return partial


def _unwritable(path: str | Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(f"{path}: cannot be written ({reason})", file=str(path))
