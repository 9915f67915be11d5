"""Results of a sweep as figures: level lines, parallel coordinates, main effects."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...errors import InputError, UnknownNameError
from ...outputs import complete_folder
from ...study.sweep import SweepTable, read_sweep
from ..plain_texts import plain
from ..style import LINES, SMALL, TEXT, WIDTH_IN, tidy

# Rows that are read, and lines that are drawn of them.
_MOST_ROWS = 1_000_000
_MOST_LINES = 1500
# Cells of a sampled parameter: enough scenarios in each, and not more than can be seen.
_FEWEST = 4
_MOST_CELLS = 24
_IN_CELL = 12
_COLOURS = "viridis"
# Columns that can be drawn beside quantities, where a sweep has them.
_COUNTS = ("collisions", "turns", "repeats_after")


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
        kind: "svg" or "png".
        target: Folder of the figures; by default ``plots`` in that of the sweep.

    Returns:
        For each quantity ``main_effects_NAME``, ``parallel_NAME`` and, with two parameters or
        more, ``level_lines_NAME``.

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
    parameters = [_Parameter.of(sweep, place) for place in range(len(sweep.axes))]
    pair = _pair(parameters, across, upwards, str(folder))
    written: list[Path] = []
    home = Path(target) if target is not None else Path(folder) / "plots"
    with complete_folder(home, ()) as new:
        for name in chosen:
            y = np.asarray(sweep.table[name].to_numpy(), dtype=float)
            if not np.isfinite(y).any():
                message = f"{folder}: no scenario has a value of {name}; see the column message"
                raise InputError(message, quantity=name)
            figures = {
                "main_effects": main_effects(sweep, parameters, name, y),
                "parallel": parallel_coordinates(sweep, parameters, name, y),
            }
            if pair is not None:
                figures["level_lines"] = level_lines(sweep, *pair, name, y)
            for subject, figure in figures.items():
                file = new / f"{subject}_{name}.{kind}"
                plain(figure).savefig(file, format=kind)
                written.append(home / file.name)
    return written


@dataclass(frozen=True, eq=False, kw_only=True)
class _Parameter:
    """A parameter, and the cells that its values fall into."""

    name: str
    label: str
    log: bool
    x: FloatArray
    cell: NDArray[np.int64]
    centres: FloatArray

    @classmethod
    def of(cls, sweep: SweepTable, place: int) -> _Parameter:
        """Grid values are cells of their own; the range of samples is divided evenly."""
        axis = sweep.axes[place]
        name, log = str(axis["name"]), axis["scale"] == "log"
        x = np.asarray(sweep.table[name].to_numpy())
        if axis["values"]:
            centres = np.unique(np.array(axis["values"], dtype=float))
            cell = np.searchsorted(centres, x)
        else:
            low, high = float(axis["low"]), float(axis["high"])
            # Grids that are crossed with the samples do not make them more.
            different = len(np.unique(x))
            count = min(max(_FEWEST, int(math.sqrt(different / _IN_CELL))), _MOST_CELLS)
            unit = _unit(x, low, high, log=log)
            cell = np.minimum((unit * count).astype(np.int64), count - 1)
            middle = (np.arange(count) + 0.5) / count
            centres = low * (high / low) ** middle if log else low + (high - low) * middle
        last = str(axis["path"]).rsplit(".", 1)[-1]
        label = name if last == name or name == axis["path"] else f"{name} ({last})"
        return cls(name=name, label=label, log=log, x=x, cell=cell, centres=centres)


def main_effects(
    sweep: SweepTable, parameters: Sequence[_Parameter], name: str, y: FloatArray
) -> Figure:
    """Mean of a quantity over each parameter, and where the middle 80 % of scenarios lie.

    Args:
        sweep: The sweep.
        parameters: Its parameters.
        name: Name of the quantity.
        y: Its values, shape (rows,).
    """
    columns = min(2, len(parameters))
    lines = -(-len(parameters) // columns)
    figure = _figure(sweep, f"Main effects on {name}", y, 1.2 + 2.2 * lines)
    known = np.isfinite(y)
    panels = figure.subplots(lines, columns, squeeze=False, sharey=True)
    for axes in panels.flat[len(parameters) :]:
        axes.set_axis_off()
    for axes, item in zip(panels.flat, parameters, strict=False):
        parts = [y[known & (item.cell == cell)] for cell in range(len(item.centres))]
        seen = [place for place, part in enumerate(parts) if len(part)]
        x = item.centres[seen]
        low, high = np.array([np.percentile(parts[cell], [10, 90]) for cell in seen]).T
        axes.fill_between(x, low, high, color=LINES[0], alpha=0.2, linewidth=0)
        axes.plot(x, [parts[cell].mean() for cell in seen], color=LINES[0], marker=".")
        if item.log:
            axes.set_xscale("log")
        tidy(axes, item.label, name)
        if axes not in panels[:, 0]:
            axes.set_ylabel("")
    return figure


def parallel_coordinates(
    sweep: SweepTable, parameters: Sequence[_Parameter], name: str, y: FloatArray
) -> Figure:
    """One line a scenario across all parameters to the quantity, which colours it.

    Args:
        sweep: The sweep.
        parameters: Its parameters.
        name: Name of the quantity.
        y: Its values, shape (rows,).
    """
    known = np.flatnonzero(np.isfinite(y))
    # At random: every k-th one would meet the same values of a grid again and again.
    random = np.random.default_rng(1)
    shown = np.sort(random.choice(known, min(len(known), _MOST_LINES), replace=False))
    subject = f"{name} over all parameters; {len(shown):,} scenarios drawn"
    figure = _figure(sweep, subject, y, 4.2)
    axes = figure.subplots()
    low, high = float(y[known].min()), float(y[known].max())
    columns = [
        _unit(item.x[shown], *_ends(item.centres, item.x), log=item.log) for item in parameters
    ]
    columns.append(_unit(y[shown], low, high, log=False))
    places = np.arange(len(columns), dtype=float)
    points = np.stack([np.broadcast_to(places, (len(shown), len(places))),
                       np.stack(columns, axis=1)], axis=2)  # fmt: skip
    lines = LineCollection(
        list(points), cmap=_COLOURS, norm=Normalize(low, high), linewidths=0.5, alpha=0.5
    )
    lines.set_array(y[shown])
    # Thousands of lines in a vector file are slow to show; axes and text stay vectors.
    lines.set_rasterized(True)
    axes.add_collection(lines)
    for place, item in enumerate(parameters):
        _scale_beside(axes, place, *_ends(item.centres, item.x))
    _scale_beside(axes, len(parameters), low, high)
    axes.set_xlim(-0.4, len(columns) - 0.6)
    axes.set_ylim(-0.1, 1.1)
    axes.set_yticks([])
    labels = [_folded(item.label) for item in parameters]
    axes.set_xticks(places, [*labels, _folded(name)], fontsize=SMALL)
    bar = figure.colorbar(lines, ax=axes)
    bar.set_label(name, fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)
    return figure


def level_lines(
    sweep: SweepTable, across: _Parameter, upwards: _Parameter, name: str, y: FloatArray
) -> Figure:
    """Lines of equal quantity over two parameters, the mean over all others.

    Args:
        sweep: The sweep.
        across: Parameter across.
        upwards: Parameter upwards.
        name: Name of the quantity.
        y: Its values, shape (rows,).
    """
    rest = len(sweep.axes) > 2 or not (sweep.axes[0]["values"] and sweep.axes[1]["values"])
    subject = f"Level lines of {name}{', means of cells and other parameters' if rest else ''}"
    figure = _figure(sweep, subject, y, 4.6)
    axes = figure.subplots()
    mean = cell_means(across.cell, upwards.cell, (len(across.centres), len(upwards.centres)), y)
    field = np.ma.masked_invalid(mean.T)
    drawn: ScalarMappable
    if field.count() > 2 and min(field.shape) > 1 and np.ptp(field.compressed()) > 0.0:
        drawn = filled = axes.contourf(
            across.centres, upwards.centres, field, levels=12, cmap=_COLOURS
        )
        lines = axes.contour(
            across.centres, upwards.centres, field, levels=filled.levels, colors="k",
            linewidths=0.6,
        )  # fmt: skip
        axes.clabel(lines, fontsize=SMALL)
    else:
        drawn = axes.pcolormesh(
            across.centres, upwards.centres, field, cmap=_COLOURS, shading="nearest"
        )
    if across.log:
        axes.set_xscale("log")
    if upwards.log:
        axes.set_yscale("log")
    tidy(axes, across.label, upwards.label)
    bar = figure.colorbar(drawn, ax=axes)
    bar.set_label(name, fontsize=TEXT)
    bar.ax.tick_params(labelsize=SMALL)
    return figure


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


def _pair(
    parameters: Sequence[_Parameter], across: str | None, upwards: str | None, where: str
) -> tuple[_Parameter, _Parameter] | None:
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


def _figure(sweep: SweepTable, subject: str, y: FloatArray, height_in: float) -> Figure:
    """A figure with a title that says of what, and how many scenarios have no value."""
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=200, layout="constrained")
    FigureCanvasAgg(figure)
    count = f"{sweep.stored:,} of {sweep.scenarios:,} scenarios"
    missing = int(np.count_nonzero(~np.isfinite(y)))
    if len(y) < sweep.stored:
        count += f", {len(y):,} of them taken"
    if missing:
        count += f", {missing:,} of them without a value"
    texts = [text for text in (sweep.title, sweep.model) if text]
    figure.suptitle(
        "\n".join([subject, *(textwrap.fill(text, 92) for text in texts), count]), fontsize=TEXT
    )
    return figure


def _scale_beside(axes: Axes, place: int, low: float, high: float) -> None:
    """Draw one axis of parallel coordinates with its ends."""
    axes.axvline(place, color="0.3", linewidth=0.8)
    for value, height, side in ((low, -0.02, "top"), (high, 1.02, "bottom")):
        axes.text(place, height, f"{value:.4g}", ha="center", va=side, fontsize=SMALL)


def _folded(name: str) -> str:
    """A long name on several lines, broken behind its dots and before its units."""
    return textwrap.fill(name.replace(".", ". ").replace("_", "_ "), 18).replace("_ ", "_")


def _ends(centres: FloatArray, x: FloatArray) -> tuple[float, float]:
    return float(min(centres.min(), x.min())), float(max(centres.max(), x.max()))


def _unit(x: FloatArray, low: float, high: float, *, log: bool) -> FloatArray:
    """Places between two ends, 0 to 1."""
    if not high > low:
        return np.full(len(x), 0.5)
    if log:
        return np.asarray(np.log(x / low) / math.log(high / low))
    return np.asarray((x - low) / (high - low))
