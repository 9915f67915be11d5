"""Parallel coordinates of a sweep: which settings have the lowest and the highest values."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from ....arrays import FloatArray
from ....study.sweep import SweepTable
from ...style import LINES, SMALL
from .beside import distribution_beside, scale_beside, shares_beside
from .columns import Parameter, Quantity, share
from .frame import framed
from .tenths import Tenth, tenths

# Lines that are drawn of all scenarios.
_MOST_LINES = 1500
_OTHERS = "0.55"
_COLUMNS = 17


def parallel_coordinates(
    sweep: SweepTable, parameters: Sequence[Parameter], quantity: Quantity
) -> Figure:
    """One line a scenario across all parameters; the lowest and the highest tenth have a colour.

    Bars beside an axis say which share of the scenarios there belongs to each: of thousands of
    lines alone nobody sees it.

    Args:
        sweep: The sweep.
        parameters: Its parameters.
        quantity: The quantity.
    """
    known = np.flatnonzero(np.isfinite(quantity.values))
    # At random: every k-th one would meet the same values of a grid again and again.
    random = np.random.default_rng(1)
    drawn = np.sort(random.choice(len(known), min(len(known), _MOST_LINES), replace=False))
    y = quantity.values[known]
    low, high = tenths(y, quantity)
    lines = "All" if len(drawn) == len(known) else f"{len(drawn):,}"
    note = (
        f"{lines} scenarios as lines. Bars beside an axis: which share of the scenarios there "
        "belongs to the lowest (left) and to the highest (right); last axis: how many there are."
    )
    subject = f"{quantity.title}: settings with low and with high values"
    figure = framed(sweep, quantity, subject, 4.8, [note])
    axes = figure.subplots()
    ends = float(y.min()), float(y.max())
    columns = [item.places(item.x[known]) for item in parameters]
    columns.append(share(y, *ends, log=False))
    _lines(axes, np.stack(columns, axis=1)[drawn], low.inside[drawn], high.inside[drawn])
    shares_beside(axes, parameters, known, (low, high))
    distribution_beside(axes, len(parameters), columns[-1], (low, high))
    for place, item in enumerate(parameters):
        scale_beside(axes, place, item.ends, item.log)
    scale_beside(axes, len(parameters), ends, False, quantity.short)
    _names(axes, [*(item.shown.label for item in parameters), quantity.shown.label])
    _legend(axes, low, high)
    return figure


def _lines(
    axes: Axes, heights: FloatArray, low: NDArray[np.bool_], high: NDArray[np.bool_]
) -> None:
    """All others below in grey, the two tenths above them, in vector files as a picture."""
    places = np.arange(heights.shape[1], dtype=float)
    points = np.stack([np.broadcast_to(places, heights.shape), heights], axis=2)
    looks = ((~low & ~high, _OTHERS, 0.12), (high, LINES[1], 0.45), (low, LINES[0], 0.45))
    for order, (chosen, colour, alpha) in enumerate(looks, start=1):
        lines = LineCollection(
            list(points[chosen]), colors=colour, linewidths=0.6, alpha=alpha, zorder=order
        )
        # Thousands of lines in a vector file are slow to show; axes and text stay vectors.
        lines.set_rasterized(True)
        axes.add_collection(lines)


def _names(axes: Axes, labels: Sequence[str]) -> None:
    axes.set_xlim(-0.45, len(labels) - 0.5)
    axes.set_ylim(-0.07, 1.07)
    axes.set_yticks([])
    axes.set_xticks(
        range(len(labels)), [textwrap.fill(label, _COLUMNS) for label in labels], fontsize=SMALL
    )
    axes.tick_params(axis="x", length=0)
    for side in axes.spines.values():
        side.set_visible(False)


def _legend(axes: Axes, low: Tenth, high: Tenth) -> None:
    handles = [
        Line2D([], [], color=colour, linewidth=2.5, label=words)
        for colour, words in (
            (LINES[0], low.words), (LINES[1], high.words), (_OTHERS, "all others"),
        )
    ]  # fmt: skip
    axes.legend(
        handles=handles, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=SMALL,
        frameon=False,
    )  # fmt: skip
