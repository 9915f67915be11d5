"""A benchmark as files: JSON, tables and the log-log plot of work against precision."""

from __future__ import annotations

import json
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...outputs import complete_folder
from ...tolerances.bench import LEAST_SHOWN_ERROR
from ...view.plain_texts import plain
from ...view.style import LINES, MARKERS, SMALL, TEXT, WIDTH_IN, tidy
from ..run_time.benchmark import Benchmark
from ..run_time.work_precision import Row
from .benchmark_report import markdown

_ENGINES = ("direct", "reduced", "reduced, batch")


def write_benchmark(result: Benchmark, folder: str | Path) -> list[Path]:
    """Write ``benchmark.json``, ``tables.md`` and ``work_precision.png``.

    Args:
        result: The benchmark.
        folder: Folder, made if it does not exist; files of the same names are replaced.

    Returns:
        The files.

    Raises:
        InputError: The folder cannot be written.
    """
    with complete_folder(folder, _FILES) as new:
        document = json.dumps(result.record(), indent=1, allow_nan=False) + "\n"
        texts = (document, markdown(result))
        for name, text in zip(_FILES, texts, strict=False):
            (new / name).write_text(text, encoding="utf-8")
        plain(work_precision_figure(result)).savefig(new / _FILES[-1], format="png")
    return [Path(folder) / name for name in _FILES]


_FILES = ("benchmark.json", "tables.md", "work_precision.png")


def work_precision_figure(result: Benchmark) -> Figure:
    """Draw wall time against the worst error of four, one line for each engine and peer.

    The fastest of the repeats is drawn: what other programs on the machine add only ever adds.
    """
    figure = Figure(figsize=(WIDTH_IN, 5.2), dpi=200, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    # Engines and peers that never came to an answer have nothing to show.
    shown: dict[str, list[Row]] = {}
    for row in (*result.engines, *result.peers):
        if row.error_worst is not None:
            shown.setdefault(row.engine, []).append(row)
    handles = []
    for number, (name, rows) in enumerate(shown.items()):
        own = name in _ENGINES
        short = name.partition(" (")[0]
        colour = LINES[number % len(LINES)]
        marker = MARKERS[(number // len(LINES) + number) % len(MARKERS)]
        errors = [max(row.error_worst or 0.0, LEAST_SHOWN_ERROR) for row in rows]
        style = {"linewidth": 2.2 if own else 1.0, "linestyle": "-" if own else "--"}
        axes.plot(
            errors,
            [row.fastest_ms for row in rows],
            color=colour,
            marker=marker,
            markersize=5.0 if own else 4.0,
            **style,  # type: ignore[arg-type]
        )
        handles.append(Line2D([], [], color=colour, marker=marker, label=short, **style))  # type: ignore[arg-type]
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.invert_xaxis()
    axes.grid(visible=True, which="major", color="0.88", linewidth=0.6)
    tidy(
        axes,
        "worst relative error: first and second rebound time, first amplitude, transition time",
        "wall time, fastest of the repeats [ms]",
    )
    when, processor = result.environment["date"][:10], result.environment["processor"]
    axes.set_title(
        f"One transition of the jaw, 650 r/min, e = 0.2 ({when}, {processor})", fontsize=TEXT
    )
    figure.legend(
        handles=handles, loc="outside lower center", ncols=2, fontsize=SMALL, frameon=False
    )
    return figure
