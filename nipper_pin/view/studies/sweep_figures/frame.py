"""What all figures of a sweep share: the title above, and what it is of below."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from ....study.sweep import SweepTable
from ...style import framed
from .columns import Quantity

COLOURS = "viridis"
ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)
"""Steps of scales, each times a power of ten."""


def sweep_figure(
    sweep: SweepTable, quantity: Quantity, subject: str, height_in: float, note: str = ""
) -> Figure:
    """An empty figure with its title; below it how to read it, what it is of, and the scenarios."""
    notes = filter(None, (note, sweep.title, sweep.model, _counts(sweep, quantity)))
    return framed(subject, notes, height_in)


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
