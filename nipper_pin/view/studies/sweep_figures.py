"""Figures of a sweep: a quantity over each parameter by itself, and its level lines over two."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...hybrid.result.turns import INDICES
from ...study.sweep import SweepTable
from ..style import LINES, SMALL, TEXT, framed, tidy
from .sweep_columns import Parameter, Quantity

_COLOURS = "viridis"
_ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)  # steps of scales, each times a power of ten
_LEVELS = 8
_MEANS = "Every value is the mean of the scenarios near it, whatever their other parameters."
_LABEL_COLUMNS = 34


def main_effects(sweep: SweepTable, parameters: Sequence[Parameter], quantity: Quantity) -> Figure:
    """Mean of a quantity over each parameter, and where the middle 80 % of scenarios lie."""
    columns = min(2, len(parameters))
    lines = -(-len(parameters) // columns)
    subject = f"{quantity.title}: how it changes with each parameter"
    figure = _framed(sweep, quantity, subject, 1.6 + 2.0 * lines)
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
        axes.xaxis.set_major_locator(_few_ticks())
    axes.yaxis.set_major_locator(_few_ticks())
    if quantity.name in INDICES:
        axes.yaxis.set_major_formatter(FuncFormatter(quantity.short))
    axes.grid(axis="y", color="0.88", linewidth=0.6)
    axes.set_axisbelow(True)


def level_lines(
    sweep: SweepTable, across: Parameter, upwards: Parameter, quantity: Quantity
) -> Figure:
    """Lines of equal quantity over two parameters, the mean over all others."""
    rest = len(sweep.axes) > 2 or not (across.grid and upwards.grid)
    subject = f"{quantity.title} over {across.shown.words} and {upwards.shown.words}"
    figure = _framed(sweep, quantity, subject, 4.8, _MEANS if rest else "")
    axes = figure.subplots()
    shape = (len(across.centres), len(upwards.centres))
    mean = cell_means(across.cell, upwards.cell, shape, quantity.values)
    field = np.ma.masked_invalid(mean.T)
    drawn = _field(axes, across.centres, upwards.centres, field, quantity.short)
    for scale, locator, item in (
        (axes.set_xscale, axes.xaxis.set_major_locator, across),
        (axes.set_yscale, axes.yaxis.set_major_locator, upwards),
    ):
        if item.log:
            scale("log")
        else:
            locator(_few_ticks())
    tidy(axes, across.shown.label, upwards.shown.label)
    ticks = FuncFormatter(quantity.short) if quantity.name in INDICES else None
    bar = figure.colorbar(drawn, ax=axes, format=ticks)
    bar.set_label(quantity.shown.label, fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)
    return figure


def _field(
    axes: Axes,
    x: FloatArray,
    y: FloatArray,
    field: np.ma.MaskedArray[tuple[int, int], np.dtype],
    short: Callable[[float], str],
) -> ScalarMappable:
    """Levels, filled and with their values; cells where there are too few values for levels."""
    if field.count() > 2 and min(field.shape) > 1 and np.ptp(field.compressed()) > 0.0:
        ends = float(field.min()), float(field.max())
        levels = MaxNLocator(_LEVELS, steps=_ROUND).tick_values(*ends)
        filled = axes.contourf(x, y, field, levels=levels, cmap=_COLOURS)
        lines = axes.contour(x, y, field, levels=filled.levels, colors="k", linewidths=0.6)
        axes.clabel(lines, fontsize=SMALL, fmt=short)
        return filled
    return axes.pcolormesh(x, y, field, cmap=_COLOURS, shading="nearest")


def cell_means(
    across: NDArray[np.int64], upwards: NDArray[np.int64], shape: tuple[int, int], y: FloatArray
) -> FloatArray:
    """Means over the cells of two parameters; NaN in empty ones.

    Args:
        across: Cell of each scenario by one parameter, shape (rows,).
        upwards: Cell by the other, shape (rows,).
        shape: Numbers of cells.
        y: Values, those that are not finite are left out, shape (rows,).

    Returns:
        Means of the given shape.
    """
    known = np.isfinite(y)
    flat = across[known] * shape[1] + upwards[known]
    count = np.bincount(flat, minlength=shape[0] * shape[1])
    total = np.bincount(flat, weights=y[known], minlength=shape[0] * shape[1])
    with np.errstate(invalid="ignore"):
        return np.asarray(total / count).reshape(shape)


def _framed(
    sweep: SweepTable, quantity: Quantity, subject: str, height_in: float, note: str = ""
) -> Figure:
    """An empty figure with its title; below it how to read it, what it is of, and the scenarios."""
    notes = filter(None, (note, sweep.title, sweep.model, _counts(sweep, quantity)))
    return framed(subject, notes, height_in)


def _few_ticks() -> MaxNLocator:
    """Places of three to seven ticks at round numbers."""
    return MaxNLocator(6, steps=_ROUND)


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
