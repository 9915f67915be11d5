"""What stands beside an axis of parallel coordinates: its scale, and how many scenarios are where.

Heights are places between the ends of an axis, 0 to 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke
from matplotlib.ticker import LogLocator
from numpy.typing import NDArray

from ....arrays import FloatArray
from ...style import LINES, SMALL
from .columns import Parameter, share, short
from .frame import few_ticks
from .tenths import Tenth

_WIDEST = 0.3
_BINS = 40
_BARS, _AXES, _TEXTS = 4, 5, 6
# Inner ticks closer to an end than this would touch its number.
_FROM_ENDS = 0.08


def shares_beside(
    axes: Axes, parameters: Sequence[Parameter], known: NDArray[np.int64], parts: tuple[Tenth, ...]
) -> None:
    """Bars of the share of a cell's scenarios that belong to each tenth, left and right.

    All parameters have one scale, so bars that do not change along an axis say that the parameter
    has no influence.

    Args:
        axes: The axes.
        parameters: Parameters, at places 0, 1, 2 and so on.
        known: Rows of the scenarios that have a value, shape (K,).
        parts: The lowest and the highest tenth of these.
    """
    every = []
    for item in parameters:
        cell, count = item.cell[known], len(item.centres)
        number = np.maximum(np.bincount(cell, minlength=count), 1)
        every.append([np.bincount(cell[part.inside], minlength=count) / number for part in parts])
    widest = max((float(row.max()) for rows in every for row in rows), default=0.0) or 1.0
    for place, (item, rows) in enumerate(zip(parameters, every, strict=True)):
        borders = item.borders
        for values, sign, colour in zip(rows, (-1.0, 1.0), LINES, strict=False):
            axes.barh(
                borders[:-1], sign * _WIDEST * values / widest, np.diff(borders), left=place,
                align="edge", color=colour, alpha=0.75, linewidth=0, zorder=_BARS,
            )  # fmt: skip


def distribution_beside(
    axes: Axes, place: int, heights: FloatArray, parts: tuple[Tenth, ...]
) -> None:
    """Bars of the number of scenarios along the axis of the quantity.

    Args:
        axes: The axes.
        place: Place of the axis.
        heights: Height of every scenario, shape (K,).
        parts: The lowest and the highest tenth of these.
    """
    low, high = parts
    borders = np.linspace(0.0, 1.0, _BINS + 1)
    whole, _ = np.histogram(heights, borders)
    left = np.full(_BINS, float(place))
    groups = ((low.inside, LINES[0]), (~low.inside & ~high.inside, "0.55"), (high.inside, LINES[1]))
    for inside, colour in groups:
        width = _WIDEST * np.histogram(heights[inside], borders)[0] / whole.max()
        axes.barh(
            borders[:-1], width, np.diff(borders), left=left, align="edge", color=colour,
            alpha=0.75, linewidth=0, zorder=_BARS,
        )  # fmt: skip
        left = left + width


def scale_beside(
    axes: Axes,
    place: int,
    ends: tuple[float, float],
    log: bool,
    text: Callable[[float], str] = short,
) -> None:
    """Draw one axis with its ends and a few ticks between them.

    Args:
        axes: The axes.
        place: Its place.
        ends: Its least and its largest value.
        log: Whether its scale is logarithmic.
        text: A value as it is written.
    """
    axes.plot([place, place], [0.0, 1.0], color="0.2", linewidth=1.0, zorder=_AXES)
    halo = [withStroke(linewidth=2.0, foreground="white")]
    for value, height, side in ((ends[0], -0.02, "top"), (ends[1], 1.02, "bottom")):
        axes.text(place, height, text(value), ha="center", va=side, fontsize=SMALL)
    locator = LogLocator(subs=(1.0, 2.0, 5.0)) if log else few_ticks()
    values = np.asarray(locator.tick_values(*ends), dtype=float)
    heights = share(values, *ends, log=log)
    inner = (heights > _FROM_ENDS) & (heights < 1.0 - _FROM_ENDS)
    for value, height in zip(values[inner], heights[inner], strict=True):
        axes.plot([place - 0.02, place], [height, height], color="0.2", linewidth=1.0,
                  zorder=_AXES)  # fmt: skip
        axes.text(place - 0.035, height, text(float(value)), ha="right", va="center",
                  fontsize=SMALL, path_effects=halo, zorder=_TEXTS)  # fmt: skip
