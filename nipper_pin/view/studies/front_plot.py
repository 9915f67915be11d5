"""A Pareto front as a figure: the two aims, and the numbers along it."""

from __future__ import annotations

import textwrap
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ...outputs import complete_file
from ...study.optimise.result import Optimum
from ...terms import named
from ..plain_texts import plain
from ..style import LINES, MARKERS, SMALL, TEXT, WIDTH_IN, tidy

_COLUMNS = 92


def plot_front(optimum: Optimum, path: str | Path) -> Path:
    """Write the figure of a front; the file appears only when it is complete.

    Args:
        optimum: An optimum with a front.
        path: The file, in the format of its suffix.

    Returns:
        The path.

    Raises:
        InputError: The file cannot be written.
    """
    target = Path(path)
    with complete_file(target) as partial:
        plain(front_figure(optimum)).savefig(partial, format=target.suffix.removeprefix("."))
    return target


def front_figure(optimum: Optimum) -> Figure:
    """Draw the second aim across, the first one upwards, and below the numbers in their bounds.

    Args:
        optimum: An optimum with a front.
    """
    problem = optimum.problem
    figure = Figure(figsize=(WIDTH_IN, 5.6), dpi=200, layout="constrained")
    FigureCanvasAgg(figure)
    # Lines break between limits, not inside them.
    limits = "; ".join(str(item).replace(" ", "\u00a0") for item in problem.limits) or "none"
    texts = [problem.title, f"limits: {limits}"]
    figure.suptitle("\n".join(textwrap.fill(text, _COLUMNS) for text in texts), fontsize=TEXT)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    one, two = (item.quantity for item in problem.aims)
    across = np.array([item.values[two] for item in optimum.front])
    above.plot(
        across,
        [item.values[one] for item in optimum.front],
        color=LINES[0],
        marker=MARKERS[0],
        markersize=4,
        label="front",
    )
    if optimum.before is not None:
        word = "the model" if optimum.before.inside else "the model (breaks a limit)"
        before = optimum.before.values
        above.plot(
            [before[two]], [before[one]], color=LINES[1], marker=MARKERS[1], linestyle="none",
            label=word,
        )  # fmt: skip
    above.legend(fontsize=SMALL, frameon=False)
    tidy(above, "", named(one, problem.units[one]).label)
    _numbers_along(optimum, below)
    tidy(below, named(two, problem.units[two]).label, "place in its bounds")
    return figure


def _numbers_along(optimum: Optimum, axes: Axes) -> None:
    """Places of the numbers between their bounds, 0 to 1, along the front."""
    two = optimum.problem.aims[1].quantity
    across = [item.values[two] for item in optimum.front]
    for place, item in enumerate(optimum.problem.parameters):
        axes.plot(
            across,
            [design.z[place] for design in optimum.front],
            color=LINES[place % len(LINES)],
            marker=MARKERS[place % len(MARKERS)],
            markersize=3,
            label=f"{item.name}, {item.low:g} to {item.high:g}",
        )
    axes.set_ylim(-0.05, 1.05)
    axes.legend(fontsize=SMALL, frameon=False)
