"""A benchmark as tables, for a terminal and as Markdown, and as files."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from nipper_pin.outputs import complete_folder
from nipper_pin.view.console import say

from ..run_time.benchmark import Benchmark
from ..run_time.recorded import ALLOWED, Slower
from .sheet import Sheet

_NONE = "-"
_FILES = ("benchmark.json", "tables.md", "work_precision.png")
_TIMES = {"ms": "wall_ms", "fastest": "fastest_ms", "spread": "spread_ms", "first": "first_ms",
          "worst of four": "error_worst", "transition": "error_duration"}  # fmt: skip
_ENGINES = {
    "engine": "engine", "setting": "setting", **_TIMES, "times": "error_times",
    "impulses": "error_impulses", "amplitudes": "error_amplitudes",
    "trajectory": "error_trajectory", "evaluations": "evaluations",
}  # fmt: skip
_PEERS = {"peer": "engine", "version": "version", "setting": "setting", **_TIMES,
          "evaluations": "evaluations"}  # fmt: skip
_TURNS = {
    "engine": "engine", "setting": "setting", "ms": "wall_ms", "turns a second": "turns_per_s",
    "tables ms": "tables_ms", "times": "error_times", "impulses": "error_impulses",
}  # fmt: skip
_COSTS = {
    "Growth with the number of turns at 650 r/min": "turns",
    "Growth with the number of links: chain of N four-bars, one turn": "links",
}


def print_benchmark(result: Benchmark, console: Console) -> None:
    """Print a benchmark on a terminal of any width."""
    for line in header(result):
        say(console, line)
    for sheet in sheets(result):
        sheet.show(console)
    for line in result.unavailable:
        say(console, f"Not measured: {line}")


def print_slower(found: list[Slower], console: Console) -> None:
    """Print what became slower than in the recorded run, or that nothing did."""
    if not found:
        say(console, f"Nothing became slower than in the recorded run by more than {ALLOWED:g}.")
        return
    rows = tuple((item.engine, item.setting, f"{item.ratio:.2f}") for item in found)
    headings = "engine", "setting", "time by that time"
    Sheet("Slower than in the recorded run, in times of the peers", headings, rows, 2).show(console)


def markdown(result: Benchmark) -> str:
    """Return the same tables as Markdown."""
    parts = ["\n".join(f"{line}  " for line in header(result))]
    parts += [sheet.markdown() for sheet in sheets(result)]
    parts += [f"Not measured: {line}" for line in result.unavailable]
    return "\n\n".join(parts) + "\n"


def write_benchmark(result: Benchmark, folder: str | Path) -> list[Path]:
    """Write ``benchmark.json``, ``tables.md`` and ``work_precision.png``, in place of older ones.

    Raises:
        InputError: The folder cannot be written.
    """
    from nipper_pin.view.figure_file import save_figure

    from .work_precision_plot import work_precision_figure

    with complete_folder(folder, _FILES) as new:
        document = json.dumps(result.record(), indent=1, allow_nan=False) + "\n"
        for name, text in zip(_FILES, (document, markdown(result)), strict=False):
            (new / name).write_text(text, encoding="utf-8")
        save_figure(work_precision_figure(result), new / _FILES[-1], "png")
    return [Path(folder) / name for name in _FILES]


def header(result: Benchmark) -> list[str]:
    """Say where and with what the benchmark was run."""
    found = result.environment
    versions = ", ".join(f"{name} {value}" for name, value in found["versions"].items())
    threads = ", ".join(
        f"{name} {'not set' if value is None else value}"
        for name, value in found["threads"].items()
    )
    load = found["load_average"]
    return [
        f"{found['date']}, {'quick' if result.quick else 'full'} run",
        f"{found['platform']}, {found['processor']}, {found['cores']} cores "
        f"({found['cores_allowed'] or 'all'} allowed)" + (f", load {load[0]:.2f}" if load else ""),
        f"Python {found['python']}, {versions}",
        f"threads: {threads}",
    ]


def sheets(result: Benchmark) -> list[Sheet]:
    """Return all tables of a benchmark."""
    found = [
        _measured("Engines: one transition, 650 r/min, e = 0.2", _ENGINES, result.engines, 2),
        _measured("Direct engine in every certified transition", _ENGINES, result.accuracy, 2),
    ]
    if result.peers:
        found.append(_measured("Peers: the same transition", _PEERS, result.peers, 3))
    rows = tuple((name, _cell(name, value)) for name, value in result.reduced.items())
    found.append(Sheet("Reduced engine", ("what", "value"), rows))
    found.append(_measured("A whole turn, against the certified one", _TURNS, result.turns, 2))
    for title, name in _COSTS.items():
        costs: list[dict[str, Any]] = result.cost[name]
        headings = tuple(key.replace("_", " ") for key in costs[0])
        cells = tuple(tuple(_cell("", value) for value in row.values()) for row in costs)
        found.append(Sheet(title, headings, cells))
    return found


def _measured(title: str, columns: Mapping[str, str], rows: Iterable[object], text: int) -> Sheet:
    cells = (tuple(_cell(name, getattr(row, name)) for name in columns.values()) for row in rows)
    return Sheet(title, tuple(columns), tuple(cells), text)


def _cell(name: str, value: object) -> str:
    """A value as it is shown; errors, and what is as small, by their power of ten."""
    if isinstance(value, float):
        small = 0.0 < abs(value) < 1e-3 and not name.endswith("_ms")
        return f"{value:.1e}" if small or name.startswith("error_") else _number(value)
    return _NONE if value is None else str(value)


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"
