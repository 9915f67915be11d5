"""Progress on a terminal: what is done, of how many, the time gone, and the time left if known."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol


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
    """Show a line of progress where stderr is a terminal, and nothing elsewhere.

    Args:
        what: What the parts are.
        total: All parts, as far as known at the start.
        alike: Whether all parts take about the same time: only then is the time left told.
    """
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
    # Nothing at all elsewhere, not even the cursor's movements.
    quiet = not sys.stderr.isatty()
    bar = Progress(*columns, console=Terminal(stderr=True), transient=True, disable=quiet)
    task = bar.add_task(what, total=total, count=_count(0, total))

    def tell(done: int, total: int | None, what: str | None = None) -> None:
        bar.update(task, completed=done, total=total, count=_count(done, total), description=what)

    with bar:
        yield tell


def _count(done: int, total: int | None) -> str:
    return f"{done:,} done" if total is None else f"{done:,} of {total:,}"
