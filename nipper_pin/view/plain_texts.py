"""Texts of figures are drawn as they are: dollars in a name or a title are no formula."""

from __future__ import annotations

from matplotlib.artist import Artist
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FixedLocator


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
