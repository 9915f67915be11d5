"""What all figures of a sweep share: the title above, and what it is of below."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ....study.sweep import SweepTable
from ...style import SMALL, TITLE, WIDTH_IN
from .columns import Quantity

COLOURS = "viridis"
ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Steps of scales, each times a power of ten."""
_TITLE_COLUMNS = 72
_NOTE_COLUMNS = 104
_GREY = "0.35"


def framed(
    sweep: SweepTable, quantity: Quantity, subject: str, height_in: float, notes: Sequence[str] = ()
) -> Figure:
    """An empty figure with its title, and below it the study, the model and the scenarios.

    Args:
        quantity: What is drawn.
        subject: The title.
        height_in: Height [inch].
        notes: Sentences below that say how to read it.
    """
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=200, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(textwrap.fill(subject, _TITLE_COLUMNS), fontsize=TITLE, fontweight="bold")
    lines = [*notes, *(text for text in (sweep.title, sweep.model) if text)]
    below = [textwrap.fill(text, _NOTE_COLUMNS) for text in (*lines, _counts(sweep, quantity))]
    figure.supxlabel("\n".join(below), fontsize=SMALL, color=_GREY)
    return figure


def few_ticks() -> MaxNLocator:
    """Places of three to seven ticks at round numbers."""
    return MaxNLocator(6, steps=ROUND)


def _counts(sweep: SweepTable, quantity: Quantity) -> str:
    """How many scenarios there are, are taken and have no value."""
    taken = len(quantity.values)
    missing = int(np.count_nonzero(~np.isfinite(quantity.values)))
    text = f"{sweep.stored:,} of {sweep.scenarios:,} scenarios"
    if sweep.stored == sweep.scenarios:
        text = f"{sweep.stored:,} scenarios"
    if taken < sweep.stored:
        text += f", {taken:,} of them taken"
    if missing:
        text += f", {missing:,} of them without a value"
    return text
