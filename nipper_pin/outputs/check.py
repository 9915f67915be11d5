"""Can this be written? Asked before hours of work, not after them."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import InputError
from ..texts import followed
from .hidden import hidden_folder


def check_folder(path: str | Path) -> None:
    """Refuse a folder that can neither be made nor written into.

    Args:
        path: The folder; it need not exist, nor those above it.

    Raises:
        InputError: It, or what it would lie in, is no folder or cannot be written.
    """
    target, whole = Path(path), followed(path)
    place = next(item for item in (whole, *whole.parents) if os.path.lexists(item))
    if not place.is_dir():
        what = "is" if place == whole else f"cannot be made: {place} is"
        message = f"{target} {what} not a folder; name another one"
        raise InputError(message, folder=str(target))
    try:
        # Permissions do not tell all: file systems are read-only, full, or no place for files.
        with hidden_folder(place / "nipper-pin"):
            pass
    except OSError as error:
        message = f"{target} cannot be written ({error.strerror} in {place}); name another folder"
        raise InputError(message, folder=str(target)) from error


def check_file(path: str | Path) -> None:
    """Refuse a file that cannot be written.

    Args:
        path: The file; the folder that it lies in has to exist.

    Raises:
        InputError: It is a folder, or where it is to lie is none that can be written.
    """
    target = Path(path)
    if _there(target) and target.is_dir():
        message = f"{target} cannot be written: it is a folder; name a file"
        raise InputError(message, file=str(target))
    if not _there(target.absolute().parent):
        message = f"{target} cannot be written: there is no folder {target.parent}; make it first"
        raise InputError(message, file=str(target))
    if _there(target) and not target.is_file():
        # A device or a pipe is written into; no file is made beside it.
        if not os.access(target, os.W_OK):
            message = f"{target} cannot be written (permission denied); name another file"
            raise InputError(message, file=str(target))
        return
    try:
        target.stat()
    except FileNotFoundError:
        # Also a link to a file that is yet to be made.
        pass
    except OSError as error:
        message = f"{target} cannot be written ({error.strerror}); name another file"
        raise InputError(message, file=str(target)) from error
    check_folder(followed(target).parent)


def _there(path: Path) -> bool:
    """Return whether a path exists; one that cannot be read counts as missing."""
    try:
        return path.exists()
    except OSError:
        return False
