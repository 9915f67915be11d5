"""A commented model to start from: the least machine that does what a comber's nipper does."""

from __future__ import annotations

import re
from pathlib import Path

from ...errors import InputError
from ..load import known_models
from ..new_folder import new_folder
from ..schema import SCHEMA_FILE, schema_text

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]*")


def write_skeleton(folder: Path) -> Path:
    """Write a model that can be checked and simulated, with a comment for every decision in it.

    Args:
        folder: Folder to write; its name becomes the model's. It may exist if it is empty.

    Returns:
        The folder, resolved.

    Raises:
        InputError: The name cannot be a model's, or the folder cannot be written or is not empty.
    """
    target = folder.resolve()
    name = target.name
    if not _NAME.fullmatch(name):
        message = f"{name!r} cannot name a model: a letter, then letters, digits, _ and -"
        raise InputError(message, folder=str(folder))
    if name in known_models():
        message = f"{name} is a model that comes with the package; give yours another name"
        raise InputError(message, folder=str(folder))
    with new_folder(target) as partial:
        for file, text in skeleton(name).items():
            (partial / file).write_text(text, encoding="utf-8")
    return target


def skeleton(name: str) -> dict[str, str]:
    """Texts of the skeleton's files by their names.

    Args:
        name: Name of the model.
    """
    here = Path(__file__).parent
    urdf, document = (
        (here / f"skeleton.{kind}").read_text(encoding="utf-8") for kind in ("urdf", "toml")
    )
    return {
        f"{name}.urdf": urdf.replace('<robot name="skeleton">', f'<robot name="{name}">'),
        f"{name}.toml": document,
        SCHEMA_FILE: schema_text(),
    }
