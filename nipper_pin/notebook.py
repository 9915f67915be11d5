"""The HTML of a value in a notebook: a heading, facts and a table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

SHOWN = 12
"""Rows of a table that a notebook shows."""


def html(
    title: str,
    facts: Mapping[str, object],
    header: Sequence[str] = (),
    rows: Sequence[Sequence[object]] = (),
    count: int | None = None,
) -> str:
    """Return the HTML; every text in it is escaped.

    Args:
        title: What it is.
        facts: Values by name.
        header: Names of the columns.
        rows: Rows, of which the first :data:`SHOWN` are shown.
        count: Number of all rows, if only the first of them are given.
    """
    told = "".join(f"{_row([name, value], 'td')}" for name, value in facts.items())
    text = f"<p><b>{escape(title)}</b></p><table>{told}</table>"
    if not rows:
        return text
    shown = "".join(_row(row, "td") for row in rows[:SHOWN])
    more = (len(rows) if count is None else count) - SHOWN
    tail = f"<p>and {more:,} more</p>" if more > 0 else ""
    return f"{text}<table><thead>{_row(header, 'th')}</thead><tbody>{shown}</tbody></table>{tail}"


def _row(cells: Iterable[object], kind: str) -> str:
    return "<tr>" + "".join(f"<{kind}>{escape(_text(cell))}</{kind}>" for cell in cells) + "</tr>"


def _text(cell: object) -> str:
    if cell is None:
        return "-"
    return f"{cell:.6g}" if isinstance(cell, float) else str(cell)
