"""One table, for a terminal and as Markdown."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rich.console import Console

from nipper_pin.view.console import headline, show_table


@dataclass(frozen=True)
class Sheet:
    """One table; its first columns, so many, hold words."""

    title: str
    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    text: int = 1

    def show(self, console: Console) -> None:
        """Print it; a name that is repeated from row to row is printed once."""
        headline(console, self.title)
        rows, above = [], ""
        for row in self.rows:
            repeated = self.text > 1 and row[0] == above
            rows.append(("", *row[1:]) if repeated else row)
            above = row[0]
        show_table(console, self.headings, rows, text=range(self.text), keys=max(1, self.text))

    def markdown(self) -> str:
        """Return it as Markdown."""
        rule = ["---"] * self.text + ["---:"] * (len(self.headings) - self.text)
        lines = [_line(self.headings), _line(rule), *(_line(row) for row in self.rows)]
        return f"### {self.title}\n\n" + "\n".join(lines)


def _line(cells: Iterable[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"
