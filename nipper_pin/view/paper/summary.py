"""The study on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from ...study.paper import PaperStudy
from ...study.paper.ratios import Ratio, ratio_values, within
from ...study.paper.studies import Studies
from ...study.paper.study import FAR, IDENTIFIED, NEAR, note
from ...terms import digits
from ..console import say
from .tables import percent


def print_paper(study: PaperStudy, console: Console) -> None:
    """Print the published ratios beside ours, or the changes of another machine.

    Args:
        study: The study.
        console: Where to print.
    """
    console.print(_ratios(study.ratios) if study.compared else _changes(study.studies))
    if study.compared:
        say(console, _agreement(study.mechanism.name, study.ratios))
    if study.identified:
        say(console, _agreement(IDENTIFIED, study.identified))
    say(console, note(study))


def _ratios(items: Sequence[Ratio]) -> Table:
    table = _table("Published ratios beside ours", ("published", "ours", "deviation"))
    for item in items:
        table.add_row(
            item.name, f"{item.published:g}", digits(item.ours), percent(item.relative_deviation)
        )
    return table


def _changes(studies: Studies) -> Table:
    table = _table("Changes over the three studies, and shares", ("value",))
    for name, value in ratio_values(studies).items():
        table.add_row(name, digits(value))
    return table


def _table(title: str, headings: Sequence[str]) -> Table:
    table = Table(title=title, title_justify="left", box=box.SIMPLE_HEAD, show_edge=False,
                  pad_edge=False)  # fmt: skip
    table.add_column("ratio")
    for heading in headings:
        table.add_column(heading, justify="right", no_wrap=True)
    return table


def _agreement(name: str, items: Sequence[Ratio]) -> str:
    return (
        f"{name}: {within(items, NEAR)} of {len(items)} within {100 * NEAR:g} %, "
        f"{within(items, FAR)} within {100 * FAR:g} %"
    )
