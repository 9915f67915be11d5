"""Computing time against error of this package's engines and of other people's solvers."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nipper_pin.view.style import LINES, MARKERS, SMALL, TITLE, WIDTH_IN, tidy

from ..run_time.benchmark import Benchmark
from ..run_time.work_precision import Row
from ..tolerances import LEAST_SHOWN_ERROR

_OWN = {
    "direct": "nipper_pin, direct engine",
    "reduced": "nipper_pin, reduced engine",
    "reduced, batch": "nipper_pin, reduced engine, many at once",
}
_NAME_COLUMNS = 50
_TASK = "One transition of the jaw of the E62 estimate, 650 r/min, restitution 0.2"
_DRAWN = "fastest of the repeats; thick lines: this package, dashed ones: other solvers"


def work_precision_figure(result: Benchmark) -> Figure:
    """Draw computing time against the worst error of four, one line for each engine and peer.

    The fastest of the repeats is drawn: what other programs on the machine add only ever adds.
    Settings that never came to an answer have nothing to show.
    """
    date, processor = result.environment["date"][:10], result.environment["processor"]
    figure = Figure(figsize=(WIDTH_IN, 5.8), dpi=200, layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle("Exact results in little time lie at the lower right", fontsize=TITLE,
                    fontweight="bold")  # fmt: skip
    axes = figure.add_subplot()
    shown: dict[str, list[Row]] = {}
    for row in (*result.engines, *result.peers):
        if row.error_worst is not None:
            shown.setdefault(row.engine, []).append(row)
    labels = _labels(list(shown))
    handles = [
        _line(axes, number, name, labels[name], found)
        for number, (name, found) in enumerate(shown.items())
    ]
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.invert_xaxis()
    axes.grid(visible=True, which="major", color="0.88", linewidth=0.6)
    tidy(
        axes,
        "largest relative error of both first rebound times, first height and time to rest",
        "computing time [ms]",
    )
    axes.set_title(f"{_TASK} ({date}, {processor})\n{_DRAWN}", fontsize=SMALL, color="0.35")
    figure.legend(
        handles=handles, loc="outside lower center", ncols=2, fontsize=SMALL, frameon=False,
        handlelength=1.8, columnspacing=1.2,
    )  # fmt: skip
    return figure


def _line(axes: Axes, number: int, name: str, label: str, rows: Sequence[Row]) -> Line2D:
    """One line, and its entry of the legend with the same look."""
    own = name in _OWN
    (line,) = axes.plot(
        [max(row.error_worst or 0.0, LEAST_SHOWN_ERROR) for row in rows],
        [row.fastest_ms for row in rows],
        color=LINES[number % len(LINES)],
        marker=MARKERS[(number // len(LINES) + number) % len(MARKERS)],
        markersize=5.0 if own else 4.0,
        linewidth=2.2 if own else 1.0,
        linestyle="-" if own else "--",
        label=textwrap.fill(label, _NAME_COLUMNS),
    )
    return line


def _labels(names: Sequence[str]) -> dict[str, str]:
    """What each is called: as short as it can be without two of one name."""
    short = {name: _OWN.get(name, name.partition(" (")[0]) for name in names}
    often = Counter(short.values())
    return {name: text if often[text] == 1 else name for name, text in short.items()}
