"""Folders of models that are written: complete, or not there at all."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import InputError
from ..outputs import complete_folder
from ..texts import followed
from .model_files import known_models

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


def check_model_folder(folder: str | Path) -> Path:
    """Refuse a folder whose name cannot be that of a new model.

    Args:
        folder: Folder that a model is to be written into; its name becomes the model's.

    Returns:
        The folder, resolved.

    Raises:
        InputError: The name cannot be a model's, or belongs to one that comes with the package.
    """
    target = followed(folder)
    name = target.name
    if not _NAME.fullmatch(name):
        message = f"{name!r} cannot name a model: a letter, then letters, digits, _ and -"
        raise InputError(message, folder=str(folder))
    if name in known_models():
        message = f"{name} is a model that comes with the package; give yours another name"
        raise InputError(message, folder=str(folder))
    return target


def check_new_folder(folder: str | Path) -> Path:
    """Refuse a folder that holds something already.

    Args:
        folder: Folder that a model is to be written into. It may exist if it is empty.

    Returns:
        The folder, resolved.

    Raises:
        InputError: It is a file, is not empty, or cannot be looked at.
    """
    target = followed(folder)
    try:
        occupied = target.exists() and (not target.is_dir() or any(target.iterdir()))
    except OSError as error:
        raise _unwritable(target, error) from error
    if occupied:
        message = f"{target} is there already and is not empty; name a new folder"
        raise InputError(message, folder=str(target))
    return target


@contextmanager
def new_folder(folder: str | Path) -> Iterator[Path]:
    """Give a folder of the same name elsewhere that takes its place only if nothing fails.

    Args:
        folder: Folder to write; folders above it are made.

    Yields:
        An empty folder to write into.

    Raises:
        InputError: The folder is occupied or cannot be written.
    """
    with complete_folder(check_new_folder(folder), ()) as partial:
        yield partial


def _unwritable(target: Path, error: OSError) -> InputError:
    message = f"{target} cannot be written: {error.strerror}; name another folder"
    return InputError(message, folder=str(target))
