"""Write the page of quantities from nipper_pin/terms.

Run: python scripts/maintain/figures/write_quantity_page.py [DOCS]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from nipper_pin.terms import SUBJECTS, Term

_HEAD = """# Quantities

Results have one name in all files (JSON, CSV, tables of cases, sweeps) and one in words, which
tables, plots, reports and the live page show. Files are in the units of the third column, people
read those of the last: angles of rebounds are small and read in mdeg, lengths of rebounds in um.
Times `t` count from the start of the run, which for people is zero everywhere; `time_s` of a
document counts from the first collision. Symbols: [notation](notation.md).

A place in the turn is an index from 0 to below 40 everywhere. Differences of two, and means of
many, go around the turn: a comparison tells the short way, figures of sweeps count on from index
24. Tables of turns that an earlier version wrote have 24 to 64: 40 less is the same place.

Of collision K of a transition the name is `NAME_K`, as in `rebound_amplitude_1`; of a stop or a
drive in a turn `NAME_STOP`, as in `collisions_jaw`. Numbers of a model are named by their paths
([numbers](model_elements.md#numbers-by-path)), which end with the unit of the file."""
_TABLE = """| name | what it is | unit in files | read in |
| --- | --- | --- | --- |"""
_SIDES = ("rad", "m")


def main(docs: str = "docs") -> None:
    """Write the page.

    Args:
        docs: Folder of the pages.
    """
    (Path(docs) / "quantities.md").write_text(page(), encoding="utf-8")
    print(f"wrote quantities to {docs}")


def page() -> str:
    """Return the text of the page."""
    parts = [_HEAD]
    for subject, terms in SUBJECTS.items():
        # A force of one stop is a moment of another: two names, one row.
        rows = [_row(list(same)) for _, same in groupby(terms, key=lambda item: item.words)]
        parts.append("\n".join([f"## {subject}\n", _TABLE, *rows]))
    return "\n\n".join(parts) + "\n"


def _row(terms: Sequence[Term]) -> str:
    symbol = f" `{terms[0].symbol}`" if terms[0].symbol else ""
    files = [item.unit.format(gap=side) for item in terms for side in _SIDES]
    people = [item.shown(side).unit for item in terms for side in _SIDES]
    names = ", ".join(f"`{item.name}`" for item in terms)
    return f"| {names} | {terms[0].words}{symbol} | {_either(files)} | {_either(people)} |"


def _either(units: Sequence[str]) -> str:
    return " or ".join(dict.fromkeys(units)) or "-"


if __name__ == "__main__":
    main(*sys.argv[1:])
