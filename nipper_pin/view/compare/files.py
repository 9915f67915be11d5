"""A comparison as files: its table, and its curves as a figure."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...arrays import FloatArray
from ...errors import InputError
from ...outputs import complete_folder
from ...study.compare import Comparison
from ...units import MS_PER_S
from ..figure_file import save_figure
from ..scene import Look
from ..style import SMALL, TEXT, blank
from .pair import COLOUR_A, COLOUR_B, Lane, Pair, clock_text, lanes, pair
from .words import changes_text, comparison_csv, names

_FILES = ("comparison.csv", "curves.png", "curves.svg")
_LANE_IN, _HEAD_IN, _COLUMNS = 1.5, 1.5, 100
# Room beside the transition, by its length; of two panels the transition takes the wider one.
_ROOM, _WIDTHS = 0.1, (1.0, 1.3)


def write_files(comparison: Comparison, folder: str | Path) -> None:
    """Write the table as CSV and the curves of both as PNG and SVG.

    Args:
        folder: Folder, made if it does not exist; its files of an earlier comparison are replaced.

    Raises:
        InputError: The folder cannot be written, or one of the runs has no motion.
    """
    figure = curves_figure(comparison)
    with complete_folder(folder, _FILES) as target:
        table, *pictures = (target / name for name in _FILES)
        table.write_text(comparison_csv(comparison), encoding="utf-8")
        for path in pictures:
            save_figure(figure, path, path.suffix.removeprefix("."))


def curves_figure(comparison: Comparison) -> Figure:
    """Gaps, clamping force and strokes of both against time: the window, and the transition.

    Raises:
        InputError: There is nothing to draw.
    """
    both = pair(comparison, Look())
    found, spans = lanes(both), _spans(both)
    if not found:
        message = "neither A nor B has a stop, so there are no curves to draw; --json needs none"
        raise InputError(message)
    figure = blank(_HEAD_IN + _LANE_IN * len(found))
    said = f"{changes_text(comparison)} {clock_text(both)}"
    figure.suptitle(textwrap.fill(said, _COLUMNS), fontsize=SMALL)
    grid = figure.subplots(len(found), len(spans), sharex="col", squeeze=False,
                           width_ratios=_WIDTHS[: len(spans)])  # fmt: skip
    for row, lane in zip(grid, found, strict=True):
        for axes, span in zip(row, spans, strict=True):
            _draw(axes, lane, MS_PER_S * both.a.pace.machine, span)
        row[0].set_ylabel("\n".join(lane.first.label), fontsize=TEXT)
    for axes in grid[-1]:
        axes.set_xlabel("time [ms]", fontsize=TEXT)
    one, other = names(comparison)
    lines = [
        Line2D([], [], color=COLOUR_A, linestyle="-", label=f"A: {one}"),
        Line2D([], [], color=COLOUR_B, linestyle="--", label=f"B: {other}"),
    ]
    figure.legend(handles=lines, loc="outside lower center", fontsize=SMALL, frameon=False)
    return figure


def _draw(axes: Axes, lane: Lane, t: FloatArray, span: tuple[float, float]) -> None:
    for colour, values in lane.lines:
        style = "--" if colour == COLOUR_B else "-"
        # Beyond the axes a curve ends, as in the film: an open jaw would hide its rebounds.
        axes.plot(t, values, color=colour, linestyle=style, linewidth=1.2)
    axes.set_xlim(*span)
    axes.set_ylim(0.0, lane.most)
    axes.tick_params(labelsize=SMALL)


def _spans(both: Pair) -> list[tuple[float, float]]:
    """Stretches of time that are drawn [ms]: the film, and the transitions of both."""
    t = both.a.pace.machine
    spans = [(float(t[0]), float(t[-1]))]
    found = [
        (item.t_start - by, item.t_start + item.duration - by)
        for film, by in ((both.a, 0.0), (both.b, both.later))
        for item in film.solution.transitions[:1]
        if item.duration > 0.0
    ]
    if found:
        begin, end = min(item[0] for item in found), max(item[1] for item in found)
        room = _ROOM * (end - begin)
        if end - begin + 2.0 * room < 0.5 * (spans[0][1] - spans[0][0]):
            spans.append((begin - room, end + room))
    return [(MS_PER_S * low, MS_PER_S * high) for low, high in np.array(spans).tolist()]
