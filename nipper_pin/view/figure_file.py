"""Figures as files: the formats that there are, and the same bytes for the same numbers."""

from __future__ import annotations

from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from ..errors import InputError
from ..outputs import complete_file
from .plain_texts import plain

FORMATS = ("svg", "png", "pdf")
"""Suffixes of files that a figure can be written to."""
_UNDATED = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


def figure_format(path: str | Path) -> str:
    """The format of a figure, by the suffix of its file.

    Raises:
        InputError: It is none of :data:`FORMATS`.
    """
    kind = Path(path).suffix.removeprefix(".").lower()
    if kind not in FORMATS:
        message = f"{path}: a figure is written as NAME.{', NAME.'.join(FORMATS)}"
        raise InputError(message, file=str(path))
    return kind


def write_figure(figure: Figure, path: str | Path) -> Path:
    """Write a figure in the format of its file's suffix; it appears only when it is complete.

    Raises:
        InputError: The file cannot be written, or its suffix names no format.
    """
    target, kind = Path(path), figure_format(path)
    with complete_file(target) as partial:
        save_figure(figure, partial, kind)
    return target


def save_figure(figure: Figure, path: Path, kind: str) -> None:
    """Write a figure that is not yet drawn in a format; its texts are drawn as they stand."""
    # Without a salt matplotlib draws the names of an SVG's parts by lot.
    with rc_context({"svg.hashsalt": "nipper_pin"}):
        plain(figure).savefig(path, format=kind, metadata=_UNDATED.get(kind))
