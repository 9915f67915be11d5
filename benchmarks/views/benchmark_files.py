"""A benchmark as files: JSON, tables and the log-log plot of work against precision."""

from __future__ import annotations

import json
from pathlib import Path

from matplotlib.figure import Figure

from nipper_pin.outputs import complete_folder
from nipper_pin.view.figure_file import save_figure

from ..run_time.benchmark import Benchmark
from .benchmark_report import markdown
from .work_precision_plot import draw_rows


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
        save_figure(work_precision_figure(result), new / _FILES[-1], "png")
    return [Path(folder) / name for name in _FILES]


_FILES = ("benchmark.json", "tables.md", "work_precision.png")


def work_precision_figure(result: Benchmark) -> Figure:
    """Draw computing time against error; see :func:`~.work_precision_plot.draw_rows`.

    Args:
        result: The benchmark.
    """
    environment = result.environment
    rows = (*result.engines, *result.peers)
    return draw_rows(rows, environment["date"][:10], environment["processor"])
