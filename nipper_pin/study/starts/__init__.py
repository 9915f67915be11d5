"""Commented files of studies to start from."""

from __future__ import annotations

from pathlib import Path

from ...errors import InputError
from ...outputs import complete_file
from ...texts import followed

STUDIES = ("sweep", "optimise", "identify")
"""Studies, by their commands."""


def write_study(study: str, target: str | Path) -> Path:
    """Write the file of a study of the model e62, with a comment for every decision in it.

    Args:
        study: One of ``STUDIES``.
        target: ``NAME.toml``.

    Returns:
        The file, resolved.

    Raises:
        InputError: The file is there, is no TOML file, or cannot be written.
    """
    file = followed(target)
    wrong = "is there already; name another file" if file.exists() else ""
    if file.suffix != ".toml":
        wrong = "is no name of a study, which is a file NAME.toml"
    if wrong:
        message = f"{target} {wrong}"
        raise InputError(message, file=str(file))
    text = (Path(__file__).parent / f"{study}.toml").read_text(encoding="utf-8")
    with complete_file(file) as partial:
        partial.write_text(text, encoding="utf-8")
    return file
