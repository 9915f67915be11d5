"""Main effects of a sweep: a quantity over each parameter by itself."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from ....hybrid.result.turns import INDICES
from ....study.sweep import SweepTable
from ...style import LINES, SMALL, tidy
from .columns import Parameter, Quantity
from .frame import few_ticks, sweep_figure

_LABEL_COLUMNS = 34


def main_effects(sweep: SweepTable, parameters: Sequence[Parameter], quantity: Quantity) -> Figure:
    """Mean of a quantity over each parameter, and where the middle 80 % of scenarios lie."""
    columns = min(2, len(parameters))
    lines = -(-len(parameters) // columns)
    subject = f"{quantity.title}: how it changes with each parameter"
    figure = sweep_figure(sweep, quantity, subject, 1.6 + 2.0 * lines)
    panels = figure.subplots(lines, columns, squeeze=False, sharey=True)
    for axes in panels.flat[len(parameters) :]:
        axes.set_axis_off()
    label = textwrap.fill(quantity.shown.label, _LABEL_COLUMNS)
    for axes, item in zip(panels.flat, parameters, strict=False):
        _panel(axes, item, quantity)
        tidy(axes, item.shown.label, label if axes in panels[:, 0] else "")
    panels[0, 0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=SMALL, frameon=False)
    return figure


def _panel(axes: Axes, item: Parameter, quantity: Quantity) -> None:
    """The mean and the middle 80 % in every cell that has scenarios."""
    y, known = quantity.values, np.isfinite(quantity.values)
    parts = [y[known & (item.cell == cell)] for cell in range(len(item.centres))]
    seen = [place for place, part in enumerate(parts) if len(part)]
    x = item.centres[seen]
    low, high = np.array([np.percentile(parts[cell], [10, 90]) for cell in seen]).T
    axes.fill_between(
        x, low, high, color=LINES[0], alpha=0.2, linewidth=0, label="middle 80 % of the scenarios"
    )
    axes.plot(
        x, [parts[cell].mean() for cell in seen], color=LINES[0], marker=".",
        label="mean of the scenarios",
    )  # fmt: skip
    if item.log:
        axes.set_xscale("log")
    else:
        axes.xaxis.set_major_locator(few_ticks())
    axes.yaxis.set_major_locator(few_ticks())
    if quantity.name in INDICES:
        axes.yaxis.set_major_formatter(FuncFormatter(quantity.short))
    axes.grid(axis="y", color="0.88", linewidth=0.6)
    axes.set_axisbelow(True)
