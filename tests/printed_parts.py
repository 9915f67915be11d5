"""What is printed, in its parts: sentences, and tables with the cells that they were given."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

# What begins a command that is pasted into a shell, and stays on one line however long it is.
COMMANDS = ("Next: ", "Run next: ", "Then: ", "Look at it: ", "  nipper-pin ", "figure: ", "file: ")
WIDE = 10_000


@dataclass(frozen=True)
class Part:
    """One table as it was made, and as it was printed."""

    title: str
    headings: list[str]
    columns: list[list[str]]
    numbers: list[bool]
    text: str


@dataclass
class Parts(Console):
    """A console that keeps tables apart from sentences."""

    columns_wide: int = WIDE
    tables: list[Part] = field(default_factory=list)
    sentences: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.stream = io.StringIO()
        super().__init__(file=self.stream, width=self.columns_wide)

    def print(self, *objects: Any, **named: Any) -> None:
        """Print, and keep what it was."""
        before = len(self.stream.getvalue())
        super().print(*objects, **named)
        text = self.stream.getvalue()[before:]
        if objects and isinstance(objects[0], Table):
            self.tables.append(_part(objects[0], text))
        else:
            self.sentences.append(text)

    @property
    def text(self) -> str:
        """All that was printed."""
        return self.stream.getvalue()


def _part(table: Table, text: str) -> Part:
    headings = [" ".join(str(item.header).split()) for item in table.columns]
    cells = [[_plain(cell) for cell in item.cells] for item in table.columns]
    numbers = [item.justify == "right" for item in table.columns]
    return Part(str(table.title or ""), headings, cells, numbers, text)


def _plain(cell: Any) -> str:
    return cell.plain if isinstance(cell, Text) else str(cell)


def faults(write: Callable[[Console], None], width: int, wide: int = WIDE) -> list[str]:
    """What is wrong with a text at a width, compared with that where nothing is too long.

    Args:
        write: Prints it.
        width: Columns of the terminal.
        wide: Columns where nothing has to give way.
    """
    here, there = Parts(width), Parts(wide)
    for console in (here, there):
        write(console)
    found = [
        f"too long: {line!r}"
        for line in here.text.splitlines()
        if len(line) > width and len(line.split()) > 1 and not line.startswith(COMMANDS)
    ]
    said, wanted = ("".join(item.sentences).split() for item in (here, there))
    found += [f"a sentence: {one!r}, {two!r}" for one, two in _differ(said, wanted)]
    for part in here.tables:
        found += _broken(part)
    return found + _lost(here.tables, there.tables)


def _differ(one: list[str], two: list[str]) -> list[tuple[str, str]]:
    """The first words that are not the same."""
    longest = max(len(one), len(two))
    pairs = zip(one + [""] * (longest - len(one)), two + [""] * (longest - len(two)), strict=True)
    return [pair for pair in pairs if pair[0] != pair[1]][:1]


def _broken(part: Part) -> list[str]:
    """Words of a table that are not whole, and numbers that are not on one line."""
    cells = [cell for column in part.columns for cell in column]
    words = Counter(" ".join([part.title, *part.headings, *cells]).split())
    lines = part.text.splitlines()
    shown = Counter(word for line in lines for word in line.split() if set(word) != {"─"})
    found = [f"a table: {word!r}" for word in (words - shown) + (shown - words)]
    digits = [cell.strip() for cells, number in zip(part.columns, part.numbers, strict=True)
              for cell in cells if number]  # fmt: skip
    return found + [
        f"a number: {cell!r}" for cell in digits if not any(cell in line for line in lines)
    ]


def _keys(part: Part, table: Part, done: int) -> int | None:
    """Number of first columns that a part repeats before the columns that are its turn."""
    size = len(part.headings)
    for keys in range(1, size) if done else (0,):
        rest = slice(done, done + size - keys)
        if (
            part.headings == table.headings[:keys] + table.headings[rest]
            and part.columns == table.columns[:keys] + table.columns[rest]
        ):
            return keys
    return None


def _lost(parts: list[Part], whole: list[Part]) -> list[str]:
    """Columns of whole tables that are in none of the parts, or stand there with other cells."""
    left = list(parts)
    for table in whole:
        done = 0
        while done < len(table.headings):
            if not left:
                return [f"a column is missing: {table.headings[done:]}"]
            part = left.pop(0)
            keys = _keys(part, table, done)
            if keys is None:
                return [f"not columns of the table: {part.headings}"]
            done += len(part.headings) - keys
    return [f"a table too many: {part.headings}" for part in left]
