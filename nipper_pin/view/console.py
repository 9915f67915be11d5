"""Plain tables and sentences on a terminal."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.table import Table


def plain_table(first: str, *others: str) -> Table:
    """An empty table: the first column is text, the others are numbers.

    Args:
        first: Heading of the first column.
        *others: Headings of the others.
    """
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    table.add_column(first, overflow="fold")
    for heading in others:
        table.add_column(heading, justify="right")
    return table


def paste(console: Console, command: str) -> None:
    """Print a command that can be pasted into a shell: it is not broken into lines.

    Args:
        console: Where to print.
        command: The command.
    """
    console.print(command, markup=False, highlight=False, soft_wrap=True)


def say(console: Console, text: str, *, style: str = "") -> None:
    """Print a sentence as it stands: what looks like markup in it is the user's text.

    Args:
        console: Where to print.
        text: The sentence.
        style: Its style.
    """
    console.print(text, style=style, markup=False, highlight=False)
