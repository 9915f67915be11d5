"""Write the page of notation and quantities from nipper_pin/terms.

Run: python scripts/maintain/figures/write_quantity_page.py [DOCS]
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from nipper_pin.terms import SUBJECTS, Term

_HEAD = Path(__file__).with_name("notation_page.md")
_TABLE = """| name | what it is | unit in files | read in |
| --- | --- | --- | --- |"""
_SIDES = ("rad", "m")


def main(docs: str = "docs") -> None:
    """Write the page.

    Args:
        docs: Folder of the pages.
    """
    (Path(docs) / "notation.md").write_text(page(), encoding="utf-8")
    print(f"wrote notation to {docs}")


def page() -> str:
    """Return the text of the page."""
    parts = [_HEAD.read_text(encoding="utf-8").rstrip()]
    for subject, terms in SUBJECTS.items():
        # A force of one stop is a moment of another: two names, one row.
        rows = [_row(list(same)) for _, same in groupby(terms, key=lambda item: item.words)]
        parts.append("\n".join([f"### {subject}\n", _TABLE, *rows]))
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
