"""Common style of figures: sizes, colours safe for colour-blind readers, axes, shading."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..hybrid import Solution
from ..mechanism import INDEX_PER_TURN, Mechanism
from ..units import MS_PER_S, S_PER_MS
from .phases import intervals, legend
from .reading import (
    case_text,
    index_at,
    restitution_text,
    shown_until,
    spring_text,
)

WIDTH_IN = 7.2
TITLE = 10.5
TEXT = 9.0
SMALL = 8.0
# Okabe and Ito's palette; phases take pale tints of it, which stand in phases.py.
LINES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7")
MARKERS = ("o", "s", "^", "D")
# Letters of a line: of a title in bold letters, of texts above a run's figures, and below others.
_TITLE_COLUMNS, _TEXT_COLUMNS, _NOTE_COLUMNS = 72, 92, 104
_NARROWEST_LABEL = 0.025
# As many entries of a legend as have room beside one another.
_COLUMNS = 4


def blank(height_in: float) -> Figure:
    """Return an empty figure; its own canvas leaves matplotlib's global state alone."""
    figure = Figure(figsize=(WIDTH_IN, height_in), dpi=200, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def framed(subject: str, notes: Iterable[str], height_in: float) -> Figure:
    """Return an empty figure with its title, and below it sentences about what it is of."""
    figure = blank(height_in)
    title = "\n".join(textwrap.fill(line, _TITLE_COLUMNS) for line in subject.splitlines())
    figure.suptitle(title, fontsize=TITLE, fontweight="bold")
    below = "\n".join(textwrap.fill(text, _NOTE_COLUMNS) for text in notes)
    figure.supxlabel(below, fontsize=SMALL, color="0.35")
    return figure


def new_figure(solution: Solution, subject: str, height_in: float) -> Figure:
    """Return an empty figure with a title that names subject, model and case."""
    figure = blank(height_in)
    mechanism = solution.mechanism
    model = textwrap.fill(mechanism.title or mechanism.name, _TEXT_COLUMNS)
    restitution = f"restitution: {restitution_text(mechanism.stops)}"
    values = textwrap.fill(f"{restitution}; springs: {spring_text(mechanism)}", _TEXT_COLUMNS)
    text = f"{subject}\n{model}\n{case_text(solution)}\n{values}"
    figure.suptitle(text, fontsize=TEXT, parse_math=False)
    return figure


def tidy(axes: Axes, xlabel: str, ylabel: str) -> None:
    """Label axes with readable sizes."""
    axes.set_xlabel(xlabel, fontsize=TEXT)
    axes.set_ylabel(ylabel, fontsize=TEXT)
    axes.tick_params(labelsize=SMALL)


def line_colour(mechanism: Mechanism, stop: str) -> str:
    """Colour of a stop's lines."""
    return LINES[_place(mechanism, stop) % len(LINES)]


def marker(mechanism: Mechanism, stop: str) -> str:
    """Marker of a stop, so that colour is not all that tells stops apart."""
    return MARKERS[_place(mechanism, stop) % len(MARKERS)]


def phase_patches(solution: Solution) -> list[Artist]:
    """Legend entries of all tints that are shown, with the words of the viewer's strip."""
    return [
        Patch(facecolor=item.tint, edgecolor="0.4", linewidth=0.6, label=item.name)
        for item in legend(solution)
    ]


def legend_below(figure: Figure, *rows: Sequence[Artist]) -> None:
    """Put one legend under all panels, row by row; a long row goes on in the next one."""
    rows = tuple(row[at : at + _COLUMNS] for row in rows for at in range(0, len(row), _COLUMNS))
    columns = max(len(row) for row in rows)
    blank = Line2D([], [], linestyle="none", label=" ")
    # Matplotlib fills a legend column by column.
    handles = [
        row[column] if column < len(row) else blank for column in range(columns) for row in rows
    ]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=columns, fontsize=SMALL, frameon=False
    )


def shade_phases(solution: Solution, axes: Axes, *, numbered: bool) -> None:
    """Shade the phases along a time axis in ms and number those that are wide enough."""
    until = shown_until(solution)
    for item in intervals(solution):
        begin, end = MS_PER_S * item.start, MS_PER_S * min(item.end, until)
        axes.axvspan(begin, end, facecolor=item.tint, linewidth=0, zorder=0)
        if (
            numbered
            and item.number is not None
            and end - begin > _NARROWEST_LABEL * MS_PER_S * until
        ):
            axes.text(0.5 * (begin + end), 0.97, str(item.number), fontsize=SMALL, color="0.25",
                      transform=axes.get_xaxis_transform(), ha="center", va="top")  # fmt: skip
    axes.set_xlim(0.0, MS_PER_S * until)


def index_scale(solution: Solution, axes: Axes) -> None:
    """Add the comber's index above a time axis in ms."""
    start = index_at(solution, 0.0)
    per_ms = S_PER_MS * INDEX_PER_TURN / solution.shaft.period

    def index(t: ArrayLike) -> FloatArray:
        return start + per_ms * np.asarray(t, dtype=float)

    def time(index: ArrayLike) -> FloatArray:
        return (np.asarray(index, dtype=float) - start) / per_ms

    above = axes.secondary_xaxis("top", functions=(index, time))
    above.set_xlabel("index of the comb cycle (40 to a turn)", fontsize=TEXT)
    above.tick_params(labelsize=SMALL)
    scale: Axis = above.xaxis
    scale.set_major_locator(MaxNLocator(nbins=10, steps=[1, 2, 4, 5, 10]))
    scale.set_major_formatter(FuncFormatter(lambda value, _: f"{value % INDEX_PER_TURN:g}"))


def _place(mechanism: Mechanism, stop: str) -> int:
    return [item.name for item in mechanism.stops].index(stop)
