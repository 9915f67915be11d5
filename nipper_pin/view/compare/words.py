"""A comparison as people read it: rows, what differs, what was found; on the terminal, as CSV."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from rich.console import Console

from ...dynamics import DriveMode
from ...hybrid import Solution, Window
from ...hybrid.result.turns import INDICES
from ...mechanism import Mechanism
from ...study.compare import Change, Comparison, Row
from ...terms import Shown, digits, fixed, named
from ..console import headline, say, show_table
from ..reading import AT_CONTACT, shown
from ..run.csv_tables import csv_text

# Counts and places on a scale: their difference is told, not its share.
_COUNTED = ("collisions", "repeats_after")
_LEAST_INDEX = 0.001
_MOST_CHANGES, _MOST_NAMED = 12, 2
OF_LIPS = "m at the contact"
"""Unit of rows that tell the gap of the row above once more, at the contact point."""
_LEAST_PERCENT, _ROUND_PERCENT, _WHOLE_PERCENT = 0.005, 10.0, 1000.0
# What a designer asks first, and what is said if B has more or less of it.
_ASKED = (
    ("rebound_amplitude_1", "rebounds {} further", "rebounds {} less far"),
    ("duration_s", "takes {} longer to rest", "comes to rest in {} less time"),
    ("least_clamping_force_N", "clamps with {} more force", "clamps with {} less force"),
)
_HEADINGS = ("quantity", "unit", "A", "B", "difference")
# Rows of a whole turn begin here.
_TURN = "repeats_after"


def names(comparison: Comparison) -> list[str]:
    """Both runs in words; where these are the same, with what differs in their machines."""
    runs = comparison.a, comparison.b
    found, told = [_label(run) for run in runs], comparison.changes[:_MOST_NAMED]
    if found[0] != found[1] or not told:
        return found
    left = len(comparison.changes) - len(told)
    more = f" and {left} more" if left else ""
    setting = partial(_setting, runs[0].mechanism)
    values = [item.a for item in told], [item.b for item in told]
    return [
        _label(run, f" with {', '.join(map(setting, told, side))}{more}")
        for run, side in zip(runs, values, strict=True)
    ]


def _setting(mechanism: Mechanism, change: Change, value: float | str | None) -> str:
    found = shown(mechanism, change.path)
    return f"{found.words} {_value(found, value)} {found.unit}".rstrip()


def _label(run: Solution, machine: str = "") -> str:
    """Model, speed and window of a run, and its drive if it is not held."""
    case = run.case
    what = "transition"
    if case.window is Window.CYCLE:
        turns = "1 turn" if case.cycles == 1 else f"{case.cycles} turns"
        what = f"{turns} from index {case.start_index:g}"
    drive = "" if case.drive is DriveMode.HELD else f", {case.drive.value} drive"
    return f"{run.mechanism.name}{machine}, {case.speed_rpm:g} r/min, {what}{drive}"


def row_shown(row: Row) -> Shown:
    """How people read a quantity."""
    if row.unit == OF_LIPS:
        return AT_CONTACT.called("at the contact")
    found = named(row.name, row.unit)
    # Of the transition, where turns count the collisions of each stop as well.
    return found.called("collisions until rest") if row.name == "collisions" else found


def difference_text(row: Row) -> str:
    """The difference in per cent, or in the quantity's own unit where that says more."""
    if row.difference is None:
        return "-"
    if row.difference == 0.0:
        return "0"
    if row.name in INDICES or row.name.startswith(_COUNTED):
        return index_text(row.difference, row_shown(row).decimals or 0)
    if row.percent is None:
        return _signed(row_shown(row).phrase(row.difference))
    return percent_text(row.percent)


def index_text(difference: float, decimals: int = 3) -> str:
    """A difference of indices, or without decimals of counts, with its sign."""
    text = fixed(difference, decimals)
    return _signed(text) if float(text) else f"< {_LEAST_INDEX}"


def percent_text(percent: float) -> str:
    """A difference in per cent with its sign."""
    size = abs(percent)
    if size < _LEAST_PERCENT:
        return "< 0.01 %"
    decimals = 2 if size < _ROUND_PERCENT else (1 if size < _WHOLE_PERCENT else 0)
    return f"{'-' if percent < 0.0 else '+'}{fixed(size, decimals)} %"


def change_text(comparison: Comparison, change: Change) -> str:
    """What differs, in words."""
    if change.path.startswith("shapes"):
        return f"{change.path} differ"
    found = shown(comparison.a.mechanism, change.path)
    for value, side in ((change.a, "B"), (change.b, "A")):
        if value is None:
            return f"{change.path} is in {side} alone"
    values = f"{_value(found, change.a)} -> {_value(found, change.b)}"
    return f"{found.words} {values} {found.unit}".rstrip()


def change_texts(comparison: Comparison) -> list[str]:
    """What differs, one thing each, and how much more."""
    told = [change_text(comparison, item) for item in comparison.changes[:_MOST_CHANGES]]
    more = len(comparison.changes) - len(told)
    return [*told, *([f"{more} more (all of them: --json FILE)"] if more else [])]


def changes_text(comparison: Comparison) -> str:
    """What differs, as one sentence."""
    if not comparison.changes:
        return "Machine and setting are the same."
    return f"What differs: {'; '.join(change_texts(comparison))}."


def finding(comparison: Comparison) -> str:
    """What was found, in one sentence or two."""
    if not comparison.rows:
        return "A and B have no quantity in common."
    if comparison.same:
        other = " although they are set differently" if comparison.changes else ""
        return f"A and B are the same: all {len(comparison.rows)} quantities are equal{other}."
    rows = {row.name: row for row in comparison.rows}
    told = [
        text
        for name, more, less in _ASKED
        if name in rows and (text := _told(rows[name], more, less))
    ]
    never = _never(rows)
    if not told and never:
        return never
    if not told:
        count = sum(row.a != row.b for row in comparison.rows)
        return f"{count} of {len(comparison.rows)} quantities differ, none of the rebound."
    ending = f" and {told.pop()}" if len(told) > 1 else ""
    return f"B {', '.join(told)}{ending} than A. {never}".rstrip()


def _never(rows: Mapping[str, Row]) -> str:
    """Which run does not come to rest where the other one does; empty if both do or none."""
    row = rows.get("duration_s")
    if row is None or (row.a is None) is (row.b is None):
        return ""
    return f"{'A' if row.a is None else 'B'} does not come to rest, and the other one does."


def _told(row: Row, more: str, less: str) -> str:
    """A part of the finding; empty if nothing differs that could be told."""
    if row.percent is None or abs(row.percent) < _LEAST_PERCENT:
        return ""
    text = percent_text(abs(row.percent)).removeprefix("+")
    return (more if row.percent > 0.0 else less).format(text)


def _signed(text: str) -> str:
    return text if text.startswith("-") else f"+{text}"


def _value(found: Shown, value: float | str | None) -> str:
    if isinstance(value, str) or value is None:
        return value or "none"
    # As written in a file: 9 and 11000, not 9.000.
    text = f"{found.value(value):.10g}"
    return text if len(text) <= len("-123.4567") else digits(found.value(value))


def print_comparison(comparison: Comparison, console: Console) -> None:
    """Print what differs, the table, and what was found."""
    for side, name in zip("AB", names(comparison), strict=True):
        say(console, f"{side}: {name}")
    if comparison.changes:
        headline(console, "What differs")
        for text in change_texts(comparison):
            say(console, text)
    else:
        say(console, changes_text(comparison))
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
