"""Tables and sentences on a terminal of any width, without a broken word or number."""

from __future__ import annotations

import os
import re
import sys
import textwrap
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from rich import box
from rich.console import Console, ConsoleOptions, JustifyMethod, RenderableType
from rich.segment import Segment
from rich.table import Table
from rich.text import Text

from ..errors import printable

# Of a terminal that does not say, in letters.
_USUAL = 80
# Wider than any line.
_UNBROKEN = 100_000
# A space that no line breaks at: between a number and its unit, or a word and its number.
_GLUE = "\u00a0"
_UNITS = r"(?:m?deg|[mu]?m|ms|s|r/min|N|N/mm|mJ|kg|%|rad|mm/s|rad/s)"
_BEFORE_UNIT = re.compile(rf"(?<=\d) (?={_UNITS}(?![\w/]))")
_BEFORE_NUMBER = re.compile(r"(?<=\bindex) (?=\d)")


@dataclass(frozen=True)
class _Column:
    """A column with the widths that its words need.

    Attributes:
        place: Its place in the rows.
        text: Whether it is text, which may be broken between words.
        least: Width of its longest word, of numbers that of the longest cell.
        most: Width at which no cell is broken.
    """

    place: int
    text: bool
    heading: str
    least: int
    most: int


class Terminal(Console):
    """Where all commands print: no text of a file can command it."""

    def __init__(self, **options: Any) -> None:
        """Take the options of rich; a terminal that says it has no width has the usual one."""
        super().__init__(**options)
        if self.width < 1:
            self.width = _USUAL

    def render(
        self, renderable: RenderableType, options: ConsoleOptions | None = None
    ) -> Iterable[Segment]:
        """Render as rich does, with codes in texts written out."""
        for part in super().render(renderable, options):
            # Codes of rich itself are no texts yet.
            yield part if part.control else Segment(printable(part.text, "\n"), part.style)


def show_table(
    console: Console,
    headings: Sequence[str],
    rows: Sequence[Sequence[str]],
    *,
    text: Collection[int] = (0,),
    keys: int = 1,
) -> None:
    """Print a table; one that is wider than the terminal becomes several with the first columns.

    Args:
        rows: Texts of the cells; brackets and colons in them are printed.
        text: Places of columns of text; all others are numbers.
        keys: Number of first columns that name a row.
    """
    columns = [_column(place, headings, rows, text) for place in range(len(headings))]
    for part in _parts(columns, keys, console.width):
        console.print(_table(part, rows, console.width))


def unbroken_console() -> Console:
    """The output as a console: as wide as the terminal, and where there is none without breaks.

    For sentences that scripts search, too.
    """
    if sys.stdout.isatty() or "COLUMNS" in os.environ:
        return Terminal()
    # A width alone does not count where the terminal is said to be a simple one.
    return Terminal(width=_UNBROKEN, height=1)


def say(console: Console, text: str, *, style: str = "") -> None:
    """Print a sentence without markup: brackets and colons in it are printed."""
    glued = _BEFORE_NUMBER.sub(_GLUE, _BEFORE_UNIT.sub(_GLUE, text))
    lines = textwrap.fill(
        glued, console.width, break_long_words=False, break_on_hyphens=False
    ).replace(_GLUE, " ")
    console.print(Text(lines, style=style), highlight=False, soft_wrap=True)


def headline(console: Console, text: str) -> None:
    """Print the heading of what follows, after an empty line."""
    console.print()
    say(console, text, style="bold")


def paste(console: Console, command: str) -> None:
    """Print a command that can be pasted into a shell: it is not broken into lines."""
    console.print(Text(command), highlight=False, soft_wrap=True)


def ending(console: Console, following: str = "", written: Iterable[str | None] = ()) -> None:
    """Print which files were written (None: none), and the command to run next, if there is one."""
    for place in written:
        if place is not None and place != "-":
            paste(console, f"written: {place}")
    if following:
        paste(console, f"Next: {following}")


def _column(
    place: int, headings: Sequence[str], rows: Sequence[Sequence[str]], text: Collection[int]
) -> _Column:
    heading, cells = headings[place], [row[place] for row in rows]
    words = max(map(len, heading.split()), default=0)
    most = max([words, *map(len, cells)])
    least = most
    if place in text:
        least = max([words, *(len(word) for cell in cells for word in cell.split())])
    return _Column(place, place in text, heading, least, most)


def _parts(columns: Sequence[_Column], keys: int, width: int) -> list[list[_Column]]:
    """Columns that fit beside one another, the first ones in each part."""
    parts = [list(columns[:keys])]
    for item in columns[keys:]:
        if len(parts[-1]) > keys and _width([*parts[-1], item]) > width:
            parts.append(list(columns[:keys]))
        parts[-1].append(item)
    return parts


def _width(part: Sequence[_Column], gap: int = 1) -> int:
    return sum(item.least for item in part) + gap * (len(part) - 1)


def _table(part: Sequence[_Column], rows: Sequence[Sequence[str]], width: int) -> Table:
    gap = 2 if _width(part, gap=2) <= width else 1
    widths = _widths(part, width - gap * (len(part) - 1))
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, gap - 1, 0, 0))
    headings = [
        textwrap.wrap(item.heading, size, break_long_words=False, break_on_hyphens=False)
        for item, size in zip(part, widths, strict=True)
    ]
    most = max(map(len, headings))
    for item, size, lines in zip(part, widths, headings, strict=True):
        # Headings stand on the line below them, cells of several lines begin at the top.
        text = "\n".join([*[""] * (most - len(lines)), *lines])
        justify: JustifyMethod = "left" if item.text else "right"
        table.add_column(Text(text), justify=justify, width=size, no_wrap=not item.text)
    for row in rows:
        table.add_row(*(Text(row[item.place]) for item in part))
    return table


def _widths(part: Sequence[_Column], room: int) -> list[int]:
    """Widths of columns: text gives way, the widest one first, numbers never."""
    widths = [item.most for item in part]
    while sum(widths) > room:
        free = [place for place, item in enumerate(part) if widths[place] > item.least]
        if not free:
            break
        widths[max(free, key=lambda place: widths[place])] -= 1
    return widths
