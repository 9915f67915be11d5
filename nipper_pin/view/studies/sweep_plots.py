"""Figures of a sweep: a quantity over each parameter by itself, and its level lines over two."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import InputError, UnknownNameError
from ...hybrid import START_INDEX
from ...hybrid.result.turns import INDICES
from ...mechanism import counted_from, within_turn
from ...outputs import complete_folder
from ...study.sweep import SweepTable, read_sweep
from ...terms import NONE, Shown, named
from ..figure_file import save_figure
from ..style import LINES, SMALL, TEXT, framed, tidy

# Cells of a sampled parameter: enough scenarios in each, and not more than can be seen.
_FEWEST = 4
_MOST_CELLS = 24
_IN_CELL = 12
_COLOURS = "viridis"
_ROUND = (1.0, 2.0, 2.5, 5.0, 10.0)  # steps of scales, each times a power of ten
_LEVELS = 8
_MEANS = "Every value is the mean of the scenarios near it, whatever their other parameters."
_LABEL_COLUMNS = 34
# Rows that are read.
_MOST_ROWS = 1_000_000
# Columns that can be drawn beside quantities, where a sweep has them.
_COUNTS = ("collisions", "turns", "repeats_after")


@dataclass(frozen=True, eq=False, kw_only=True)
class Quantity:
    """A quantity of all scenarios.

    Attributes:
        name: Its name in the table.
        shown: Its words and its unit for people.
        values: Its values in that unit, NaN where a scenario has none, shape (rows,); indices count
            on from the start of the turn, so that they have means.
    """

    name: str
    shown: Shown
    values: FloatArray

    @classmethod
    def of(cls, sweep: SweepTable, name: str) -> Quantity:
        """Read it from a sweep."""
        unit = (sweep.table.schema.field(name).metadata or {}).get(b"unit", NONE.encode()).decode()
        shown = named(name, unit)
        values = shown.value(np.asarray(sweep.table[name].to_numpy(), dtype=float))
        if name in INDICES:
            values = counted_from(START_INDEX, values)
        return cls(name=name, shown=shown, values=values)

    def short(self, value: float, _: object = None) -> str:
        """A value beside an axis; an index on the one scale from 0 to 40."""
        return short(float(within_turn(value)) if self.name in INDICES else value)

    @property
    def title(self) -> str:
        """Its words at the beginning of a sentence."""
        return self.shown.words[:1].upper() + self.shown.words[1:]


@dataclass(frozen=True, eq=False, kw_only=True)
class Parameter:
    """A parameter, and the cells that its values fall into.

    Attributes:
        name: Its name in the study.
        shown: Its words and its unit for people.
        log: Whether its scale is logarithmic.
        cell: Cell of every scenario, shape (rows,).
        centres: Middles of the cells in that unit, shape (cells,); those of a grid are its values.
        grid: Whether its values are those of a grid.
    """

    name: str
    shown: Shown
    log: bool
    cell: NDArray[np.int64]
    centres: FloatArray
    grid: bool

    @classmethod
    def of(cls, sweep: SweepTable, place: int) -> Parameter:
        """Grid values are cells of their own; the range of samples is divided evenly."""
        axis = sweep.axes[place]
        name, log = str(axis["name"]), axis["scale"] == "log"
        shown = named(str(axis["path"]))
        x = np.asarray(sweep.table[name].to_numpy())
        if axis["values"]:
            centres = np.unique(np.array(axis["values"], dtype=float))
            cell = np.searchsorted(centres, x)
        else:
            low, high = float(axis["low"]), float(axis["high"])
            # Grids that are crossed with the samples do not make them more.
            different = len(np.unique(x))
            count = min(max(_FEWEST, int(math.sqrt(different / _IN_CELL))), _MOST_CELLS)
            scale = np.log if log else np.asarray
            parts = (scale(x) - scale(low)) / ((scale(high) - scale(low)) or 1.0)
            cell = np.minimum((parts * count).astype(np.int64), count - 1)
            middle = (np.arange(count) + 0.5) / count
            centres = low * (high / low) ** middle if log else low + (high - low) * middle
        return cls(
            name=name,
            shown=shown,
            log=log,
            cell=cell,
            centres=shown.value(centres),
            grid=bool(axis["values"]),
        )


def short(value: float) -> str:
    """A value beside an axis: three digits, and no powers of ten for what a designer reads."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"


def plot_sweep(
    folder: str | Path,
    *,
    quantities: Sequence[str] | None = None,
    across: str | None = None,
    upwards: str | None = None,
    kind: str = "svg",
    target: str | Path | None = None,
) -> list[Path]:
    """Write the figures of a sweep; they take the place of earlier ones in one step.

    Args:
        folder: Folder of the sweep.
        quantities: What to draw; by default the first quantity of the study.
        across: Parameter across, of the level lines; by default the first one left.
        upwards: Parameter upwards; by default the next one left.
        kind: "svg", "png" or "pdf".
        target: Folder of the figures; by default ``plots`` in that of the sweep.

    Returns:
        For each quantity ``main_effects_NAME`` and, with two parameters or more,
        ``level_lines_NAME``.

    Raises:
        InputError: There is no such sweep, parameter or quantity, or nothing to draw.
    """
    sweep = read_sweep(folder, _MOST_ROWS)
    chosen = list(quantities or sweep.quantities[:1])
    counts = [name for name in _COUNTS if name in sweep.table.column_names]
    known = (*counts, *sweep.quantities)
    for name in chosen:
        if name not in known:
            raise UnknownNameError(kind="quantity", name=name, known=known, where=str(folder))
    parameters = [Parameter.of(sweep, place) for place in range(len(sweep.axes))]
    pair = _pair(parameters, across, upwards, str(folder))
    written: list[Path] = []
    home = Path(target) if target is not None else Path(folder) / "plots"
    with complete_folder(home, ()) as new:
        for name in chosen:
            quantity = Quantity.of(sweep, name)
            if not np.isfinite(quantity.values).any():
                message = f"{folder}: no scenario has a value of {name}; see the column message"
                raise InputError(message, quantity=name)
            figures = {"main_effects": main_effects(sweep, parameters, quantity)}
            if pair is not None:
                figures["level_lines"] = level_lines(sweep, *pair, quantity)
            for subject, figure in figures.items():
                file = new / f"{subject}_{name}.{kind}"
                save_figure(figure, file, kind)
                written.append(home / file.name)
    return written


def _pair(
    parameters: Sequence[Parameter], across: str | None, upwards: str | None, where: str
) -> tuple[Parameter, Parameter] | None:
    """The two parameters of the level lines, or None if there are not two."""
    by_name = {item.name: item for item in parameters}
    for name in (across, upwards):
        if name is not None and name not in by_name:
            raise UnknownNameError(kind="parameter", name=name, known=by_name, where=where)
    if across is not None and across == upwards:
        message = f"--x and --y are both {across}; level lines need two parameters"
        raise InputError(message, parameter=across)
    left = [name for name in by_name if name not in (across, upwards)]
    first = across or (left.pop(0) if left else None)
    second = upwards or (left.pop(0) if left else None)
    if first is None or second is None:
        if across or upwards:
            message = (
                f"--x and --y: level lines need two parameters; {where} has only {first or second}"
            )
            raise InputError(message, parameter=across or upwards)
        return None
    return by_name[first], by_name[second]


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
