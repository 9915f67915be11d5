"""Plain tables and sentences on a terminal."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text


def plain_table(first: str, *others: str) -> Table:
    """An empty table: the first column is text, the others are numbers.

    Args:
        first: Heading of the first column.
        *others: Headings of the others.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    table.add_column(Text(first), overflow="fold")
    for heading in others:
        table.add_column(Text(heading), justify="right")
    return table


def add_row(table: Table, *cells: str) -> None:
    """Add a row to a table without markup: brackets and colons in names are printed.

    Args:
        table: The table.
        *cells: Texts of its cells.
    """
    table.add_row(*(Text(cell) for cell in cells))


def paste(console: Console, command: str) -> None:
    """Print a command that can be pasted into a shell: it is not broken into lines.

    Args:
        console: Where to print.
        command: The command.
    """
    console.print(Text(command), soft_wrap=True)


def say(console: Console, text: str, *, style: str = "") -> None:
    """Print a sentence without markup: brackets and colons in it are printed.

    Args:
        console: Where to print.
        text: The sentence.
        style: Its style.
    """
    console.print(Text(text, style=style))
