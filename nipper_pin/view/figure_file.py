"""Figures as files, with the same bytes for the same numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from matplotlib import rc_context
from matplotlib.figure import Figure

from .plain_texts import plain

_UNDATED = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}


def save_figure(
    figure: Figure, path: Path, kind: str, dpi: float | Literal["figure"] = "figure"
) -> None:
    """Write a figure, whose texts are drawn as they stand.

    Args:
        figure: The figure, complete but not yet drawn.
        kind: "svg", "png" or "pdf".
        dpi: Pixels of an inch, by default those of the figure.
    """
    # Without a salt matplotlib draws the names of an SVG's parts by lot.
    with rc_context({"svg.hashsalt": "nipper_pin"}):
        plain(figure).savefig(path, format=kind, dpi=dpi, metadata=_UNDATED.get(kind))
