"""Progress: what is done, of how many, the time gone, and the time left if known."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol

# Where there is no terminal: time until the first line, and between two later ones [s].
_FIRST_S, _EVERY_S = 1.0, 30.0


class Tell(Protocol):
    """Says how far the work is."""

    def __call__(self, done: int, total: int | None, what: str | None = None) -> None:
        """Say it.

        Args:
            done: Parts that are done.
            total: All parts; None where that is not known.
            what: What they are now; None: as before.
        """


@contextmanager
def progress(what: str, total: int | None = None, *, alike: bool = True) -> Iterator[Tell]:
    """Show a line of progress where stderr is a terminal, and lines of text now and then elsewhere.

    Args:
        alike: Whether all parts take about the same time: only then is the time left told.
    """
    shown = _bar if sys.stderr.isatty() else _lines
    with shown(what, total, alike) as tell:
        yield tell


@contextmanager
def _bar(what: str, total: int | None, alike: bool) -> Iterator[Tell]:
    from rich.progress import (
        BarColumn,
        Progress,
        ProgressColumn,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    from .console import Terminal

    columns: list[ProgressColumn] = [
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        TextColumn("{task.fields[count]}"),
        TimeElapsedColumn(),
        TextColumn("gone"),
    ]
    if alike:
        columns += [TimeRemainingColumn(), TextColumn("left")]
    bar = Progress(*columns, console=Terminal(stderr=True), transient=True)
    task = bar.add_task(what, total=total, count=_count(0, total))

    def tell(done: int, total: int | None, what: str | None = None) -> None:
        bar.update(task, completed=done, total=total, count=_count(done, total), description=what)

    with bar:
        yield tell


@contextmanager
def _lines(parts: str, total: int | None, alike: bool) -> Iterator[Tell]:
    """A line after a second, by then also if no part is done, and another every half minute."""
    began = told = time.monotonic()
    first: tuple[int, float] | None = None
    latest = parts, 0, total

    def say() -> None:
        what, done, total = latest
        seconds, left = time.monotonic() - began, ""
        if alike and total is not None and first is not None and done > first[0]:
            rest = (total - done) * (began + seconds - first[1]) / (done - first[0])
            left = f", about {rest:,.0f} s left"
        sys.stderr.write(
            f"nipper-pin: {what}: {_count(done, total)} after {seconds:,.0f} s{left}\n"
        )
        sys.stderr.flush()

    def tell(done: int, total: int | None, what: str | None = None) -> None:
        nonlocal told, first, latest
        now = time.monotonic()
        first, latest = first or (done, now), (what or parts, done, total)
        if now - told >= _EVERY_S:
            told = now
            say()

    early = threading.Timer(_FIRST_S, say)
    early.daemon = True
    early.start()
    try:
        yield tell
    finally:
        early.cancel()


def _count(done: int, total: int | None) -> str:
    return f"{done:,} done" if total is None else f"{done:,} of {total:,}"
