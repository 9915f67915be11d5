"""A comparison on the terminal and as CSV."""

from __future__ import annotations

from rich.console import Console

from ...study.compare import Comparison, Row
from ..console import headline, say, show_table
from ..run.csv_tables import csv_text
from .words import OF_LIPS, change_texts, difference_text, finding, names, row_shown

_HEADINGS = ("quantity", "unit", "A", "B", "difference")
# Rows of a whole turn begin here.
_TURN = "repeats_after"


def print_comparison(comparison: Comparison, console: Console) -> None:
    """Print what differs, the table, and what was found."""
    for side, name in zip("AB", names(comparison), strict=True):
        say(console, f"{side}: {name}")
    _changes(comparison, console)
    for name, rows in _parts(comparison):
        headline(console, name)
        show_table(console, _HEADINGS, [cells(row) for row in rows])
    if comparison.rows:
        say(console, "difference: B less A, in per cent of A; of indices and counts as it is")
    if comparison.notes:
        headline(console, "Notes")
        for note in comparison.notes:
            say(console, note)
    headline(console, finding(comparison))


def comparison_csv(comparison: Comparison) -> str:
    """The table as CSV, by the names of files and in SI units."""
    names = ("name", "unit", "a", "b", "difference")
    columns = {name: [getattr(row, name) for row in comparison.rows] for name in names}
    columns["difference_percent"] = [row.percent for row in comparison.rows]
    return csv_text(columns)


def shown_rows(comparison: Comparison) -> list[Row]:
    """Rows of which at least one run has a value; gaps of rebounds at the contact point, too."""
    found, runs = [], (comparison.a, comparison.b)
    stops = [run.mechanism.stop(run.mechanism.transition_stop) for run in runs if comparison.rows]
    for row in comparison.rows:
        if row.a is None and row.b is None:
            continue
        found.append(row)
        if row.unit == "rad" and all(stop.contact is not None for stop in stops):
            one, other = (None if value is None else stop.lever * value
                          for stop, value in zip(stops, (row.a, row.b), strict=True))  # fmt: skip
            found.append(Row(row.name, OF_LIPS, one, other))
    return found


def _parts(comparison: Comparison) -> list[tuple[str, list[Row]]]:
    """Rows of the transition, then those of the turn; nothing without any."""
    rows = shown_rows(comparison)
    names = [row.name for row in rows]
    place = names.index(_TURN) if _TURN in names else len(rows)
    parts = [("Transition", rows[:place]), ("Whole turn", rows[place:])]
    return [(name, part) for name, part in parts if part]


def cells(row: Row) -> tuple[str, str, str, str, str]:
    """Words, unit, both values and the difference, as people read them."""
    found = row_shown(row)
    return found.words, found.unit, found.text(row.a), found.text(row.b), difference_text(row)


def _changes(comparison: Comparison, console: Console) -> None:
    if not comparison.changes:
        say(console, "Machine and setting are the same.")
        return
    headline(console, "What differs")
    for text in change_texts(comparison):
        say(console, text)
