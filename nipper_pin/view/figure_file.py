"""Figures as files: the formats that there are, and the same bytes for the same numbers.

Texts are drawn as they are: dollars in a name or a title are no formula.
"""

from __future__ import annotations

from pathlib import Path

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator

from ..errors import InputError
from ..outputs import complete_file

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


def plain(figure: Figure) -> Figure:
    """Have the texts of a figure read as they stand; powers of ten beside axes stay formulas."""
    _make_plain(figure)
    return figure


def _make_plain(artist: Artist) -> None:
    if isinstance(artist, Axis):
        texts = [artist.label]
        if isinstance(artist.get_major_locator(), FixedLocator):
            texts += artist.get_ticklabels()
        for text in texts:
            text.set_parse_math(False)
        return
    if isinstance(artist, Text):
        artist.set_parse_math(False)
    for child in artist.get_children():
        _make_plain(child)
