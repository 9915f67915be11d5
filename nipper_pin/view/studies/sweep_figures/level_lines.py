"""Level lines of a sweep: a quantity over two parameters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from ....arrays import FloatArray
from ....hybrid.result.turns import INDICES
from ....study.sweep import SweepTable
from ...style import SMALL, TEXT, tidy
from .columns import Parameter, Quantity
from .frame import COLOURS, ROUND, few_ticks, sweep_figure

_LEVELS = 8
_MEANS = "Every value is the mean of the scenarios near it, whatever their other parameters."


def level_lines(
    sweep: SweepTable, across: Parameter, upwards: Parameter, quantity: Quantity
) -> Figure:
    """Lines of equal quantity over two parameters, the mean over all others."""
    rest = len(sweep.axes) > 2 or not (across.grid and upwards.grid)
    subject = f"{quantity.title} over {across.shown.words} and {upwards.shown.words}"
    figure = sweep_figure(sweep, quantity, subject, 4.8, _MEANS if rest else "")
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
            locator(few_ticks())
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
        levels = MaxNLocator(_LEVELS, steps=ROUND).tick_values(*ends)
        filled = axes.contourf(x, y, field, levels=levels, cmap=COLOURS)
        lines = axes.contour(x, y, field, levels=filled.levels, colors="k", linewidths=0.6)
        axes.clabel(lines, fontsize=SMALL, fmt=short)
        return filled
    return axes.pcolormesh(x, y, field, cmap=COLOURS, shading="nearest")


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
