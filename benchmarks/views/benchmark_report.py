"""A benchmark as tables, for a terminal and as Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console

from nipper_pin.view.console import headline, say, show_table

from ..run_time.benchmark import Benchmark
from ..run_time.work_precision import Row

_NONE = "-"
# A narrower terminal shows the columns that matter most.
_ROOMY = 140
_LESS = ("held_energy_balance", "inertial_energy_balance", "cut_pins", "fastest_ms")


@dataclass(frozen=True)
class Sheet:
    """One table.

    Attributes:
        title: What it shows.
        headings: Column headings.
        rows: Cells.
        text: Number of leading columns that hold words.
        brief: Columns that a narrow terminal shows; all by default.
    """

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    text: int = 1
    brief: tuple[int, ...] = ()


def print_benchmark(result: Benchmark, console: Console) -> None:
    """Print a benchmark.

    Args:
        result: The benchmark.
        console: Where to print, of any width.
    """
    for line in header(result):
        say(console, line)
    for sheet in sheets(result):
        headline(console, sheet.title)
        _print(sheet, console)
    for line in result.unavailable:
        say(console, f"Not measured: {line}")


def _print(sheet: Sheet, console: Console) -> None:
    """Print a table; a narrow terminal shows the columns that matter most, and says so."""
    every = tuple(range(len(sheet.headings)))
    columns = sheet.brief if console.width < _ROOMY and sheet.brief else every
    rows, above = [], ""
    for row in sheet.rows:
        cells = [row[number] for number in columns]
        # A name that is repeated from row to row is printed once.
        if sheet.text > 1 and row[0] == above:
            cells[0] = ""
        above = row[0]
        rows.append(cells)
    text = [place for place, number in enumerate(columns) if number < sheet.text]
    headings = [sheet.headings[number] for number in columns]
    show_table(console, headings, rows, text=text, keys=max(1, len(text)))
    left = [heading for number, heading in enumerate(sheet.headings) if number not in columns]
    if left:
        say(console, f"not shown, for want of room: {', '.join(left)} (all of them: --json, --out)")


def markdown(result: Benchmark) -> str:
    """Return the same tables as Markdown."""
    parts = ["\n".join(f"{line}  " for line in header(result))]
    for sheet in sheets(result):
        rule = ["---"] * sheet.text + ["---:"] * (len(sheet.headings) - sheet.text)
        lines = [_line(sheet.headings), _line(rule), *(_line(row) for row in sheet.rows)]
        parts.append(f"### {sheet.title}\n\n" + "\n".join(lines))
    parts += [f"Not measured: {line}" for line in result.unavailable]
    return "\n\n".join(parts) + "\n"


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
        _errors("Engines: one transition, 650 r/min, e = 0.2", result.engines),
        _errors("Direct engine in every certified transition", result.accuracy),
    ]
    found.append(_stated(result))
    if result.peers:
        found.append(_peers(result.peers))
    if result.reduced is not None:
        rows = tuple((name, _any(value)) for name, value in result.reduced.items())
        found.append(Sheet("Reduced engine", ("what", "value"), rows))
    found += [
        Sheet(
            title,
            tuple(name.replace("_", " ") for name in rows[0]),
            tuple(tuple(_any(value) for value in row.values()) for row in rows),
            brief=tuple(place for place, name in enumerate(rows[0]) if name not in _LESS),
        )
        for title, rows in _costs(result.cost)
    ]
    return found


def _costs(cost: dict[str, Any]) -> list[tuple[str, list[dict[str, Any]]]]:
    return [
        ("A whole turn, against the certified one", cost["cycle"]),
        ("Cost of the phases of a turn at 450 r/min", cost["phases"]),
        ("Parts of one transition at 650 r/min, tolerance 1e-9", cost["parts"]),
        ("Growth with the number of collisions: bouncing mass", cost["collisions"]),
        ("Growth with the number of turns at 650 r/min", cost["turns"]),
        ("Growth with the number of links: chain of N four-bars, one turn", cost["links"]),
        ("Peak memory", cost["memory"]),
    ]


def _errors(title: str, rows: Iterable[Row]) -> Sheet:
    return Sheet(
        title,
        (
            "engine", "setting", "ms", "fastest", "spread", "first", "worst of four", "transition",
            "times", "impulses", "amplitudes", "trajectory", "evaluations",
        ),
        tuple(
            (
                row.engine, row.setting, *_times(row), _error(row.error_worst),
                _error(row.error_duration), _error(row.error_times),
                _error(row.error_impulses), _error(row.error_amplitudes),
                _error(row.error_trajectory), _any(row.evaluations),
            )
            for row in rows
        ),
        text=2,
        brief=(0, 1, 2, 4, 6, 7, 11, 12),
    )  # fmt: skip


def _stated(result: Benchmark) -> Sheet:
    """Largest ratio over all certified cases, by tolerance."""
    rows = []
    for tolerance in dict.fromkeys(item.tolerance for item in result.stated):
        chosen = [item for item in result.stated if item.tolerance == tolerance]
        times = max(item.times for item in chosen)
        impulses = max(item.impulses for item in chosen)
        rows.append((f"{tolerance:.0e}", _number(times), _number(impulses)))
    return Sheet(
        "True over stated error of the direct engine, largest over all certified transitions",
        ("tolerance", "times", "impulses"),
        tuple(rows),
        text=0,
    )


def _peers(rows: Sequence[Row]) -> Sheet:
    return Sheet(
        "Peers: the same transition",
        (
            "peer", "version", "setting", "ms", "fastest", "spread", "first", "worst of four",
            "transition", "evaluations",
        ),
        tuple(
            (
                row.engine, row.version or _NONE, row.setting, *_times(row),
                _error(row.error_worst), _error(row.error_duration), _any(row.evaluations),
            )
            for row in rows
        ),
        text=3,
        brief=(0, 2, 3, 5, 7, 8, 9),
    )  # fmt: skip


def _times(row: Row) -> tuple[str, ...]:
    return tuple(
        _number(value) for value in (row.wall_ms, row.fastest_ms, row.spread_ms, row.first_ms)
    )


def _error(value: float | None) -> str:
    return _NONE if value is None else f"{value:.1e}"


def _number(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def _any(value: object) -> str:
    if isinstance(value, float):
        return _error(value) if 0.0 < abs(value) < 1e-3 else _number(value)
    return _NONE if value is None else str(value)


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"
