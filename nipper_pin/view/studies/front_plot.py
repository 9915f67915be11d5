"""A Pareto front as a figure: both aims, what holds each design back, and its numbers."""

from __future__ import annotations

import textwrap

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...arrays import FloatArray
from ...study.optimise.problem.problem import Problem
from ...study.optimise.result import Optimum
from ..style import LINES, MARKERS, SMALL, framed, tidy
from .optimise_report import number_shown, quantity_shown, ranges, sides

_LABEL_COLUMNS = 30
# Heights [inch] of the front, of a row of limits and of a number, and of all texts.
_FRONT_IN, _ROW_IN, _NUMBER_IN, _TEXTS_IN = 2.4, 0.4, 0.75, 1.3
_NOTHING = "no limit"


def front_figure(optimum: Optimum) -> Figure:
    """Draw a front: the second aim across, the first upwards, below what belongs to each design."""
    problem = optimum.problem
    rows = _rows(optimum)
    heights = [_FRONT_IN, 0.15 + _ROW_IN * len(rows)]
    heights += [_NUMBER_IN] * len(problem.parameters)
    one, two = (quantity_shown(problem, item.quantity) for item in problem.aims)
    subject = f"The best designs: {one.words} against {two.words}"
    figure = framed(subject, _below(problem), _TEXTS_IN + sum(heights))
    panels = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    across = two.value(np.array([item.values[problem.aims[1].quantity] for item in optimum.front]))
    _aims(optimum, panels[0], across)
    _limits(panels[1], across, rows)
    for place, axes in enumerate(panels[2:]):
        _number(optimum, axes, across, place)
    panels[-1].set_xlabel(two.label)
    return figure


def _aims(optimum: Optimum, axes: Axes, across: FloatArray) -> None:
    """Both aims of every design of the front, and those of the model."""
    first, second = (item.quantity for item in optimum.problem.aims)
    one, two = (quantity_shown(optimum.problem, name) for name in (first, second))
    upwards = one.value(np.array([item.values[first] for item in optimum.front]))
    axes.plot(
        across, upwards, color=LINES[0], marker=MARKERS[0], markersize=4, label="best designs"
    )
    if optimum.before is not None:
        word = "the model as it is" + ("" if optimum.before.inside else " (breaks a limit)")
        before = optimum.before.values
        axes.plot(
            [two.value(before[second])], [one.value(before[first])], color=LINES[1],
            marker=MARKERS[1], linestyle="none", label=word,
        )  # fmt: skip
    axes.legend(fontsize=SMALL, frameon=False)
    tidy(axes, "", textwrap.fill(one.label, _LABEL_COLUMNS))


def _rows(optimum: Optimum) -> dict[str, list[bool]]:
    """Words of what holds any design of the front back, and which designs it holds."""
    rows = {
        side.words: [name in item.holding for item in optimum.front]
        for name, side in sides(optimum.problem).items()
    }
    rows = {words: held for words, held in rows.items() if any(held)}
    free = [not item.holding for item in optimum.front]
    return {**rows, _NOTHING: free} if any(free) else rows


def _limits(axes: Axes, across: FloatArray, rows: dict[str, list[bool]]) -> None:
    """A row for each limit, with a mark below every design that has no room left by it."""
    for row, (words, held) in enumerate(rows.items()):
        at = across[held]
        axes.plot(
            at, np.full(len(at), -float(row)), color=LINES[row % len(LINES)],
            marker=MARKERS[row % len(MARKERS)], markersize=5, linestyle="none", label=words,
        )  # fmt: skip
        axes.annotate(
            words, (0.0, 0.5 - float(row)), (4.0, 0.0), xycoords=axes.get_yaxis_transform(),
            textcoords="offset points", va="center", fontsize=SMALL, annotation_clip=False,
        )  # fmt: skip
    axes.set_ylim(0.6 - len(rows), 0.85)
    axes.set_yticks([])
    tidy(axes, "", "held\nback by")


def _number(optimum: Optimum, axes: Axes, across: FloatArray, place: int) -> None:
    """A free number along the front, in its unit, over the whole of its range."""
    item = optimum.problem.parameters[place]
    shown = number_shown(item)
    values = shown.value(np.array([design.numbers[item.name] for design in optimum.front]))
    axes.plot(across, values, color="0.25", marker=MARKERS[0], markersize=3)
    low, high = shown.value(item.low), shown.value(item.high)
    axes.set_ylim(low - 0.06 * (high - low), high + 0.06 * (high - low))
    for end in (0, -1):
        # Into the middle, where there is room.
        side = 5.0 if values[end] < 0.5 * (low + high) else -5.0
        axes.annotate(
            f"{values[end]:.4g}", (across[end], values[end]), (0.0, side), fontsize=SMALL,
            textcoords="offset points", ha="center", va="bottom" if side > 0.0 else "top",
        )  # fmt: skip
    axes.set_yticks([low, high], [f"{low:g}", f"{high:g}"])
    tidy(axes, "", "")
    axes.set_title(shown.label, fontsize=SMALL, loc="left", pad=3.0)


def _below(problem: Problem) -> tuple[str, str]:
    """What the figure is of, and what all of its designs keep to."""
    # Lines break between limits, not inside them.
    limits = "; ".join(text.replace(" ", "\u00a0") for text in ranges(problem)) or "none"
    return problem.title, f"Limits: {limits}"
