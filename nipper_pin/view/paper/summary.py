"""The study on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from ...study.paper import PaperStudy
from ...study.paper.ratios import Ratio, ratio_values, within
from ...study.paper.studies import Studies
from ...study.paper.study import FAR, IDENTIFIED, NEAR, note
from ...terms import digits
from ..console import say, show_table
from .tables import percent


def print_paper(study: PaperStudy, console: Console) -> None:
    """Print the published ratios beside ours, or the changes of another machine.

    Args:
        study: The study.
        console: Where to print.
    """
    if study.compared:
        _ratios(study.ratios, console)
        say(console, _agreement(study.mechanism.name, study.ratios))
    else:
        _changes(study.studies, console)
    if study.identified:
        say(console, _agreement(IDENTIFIED, study.identified))
    say(console, note(study))


def _ratios(items: Sequence[Ratio], console: Console) -> None:
    say(console, "Published ratios beside ours", style="bold")
    rows = [
        (item.name, f"{item.published:g}", digits(item.ours), percent(item.relative_deviation))
        for item in items
    ]
    show_table(console, ("ratio", "published", "ours", "deviation"), rows)


def _changes(studies: Studies, console: Console) -> None:
    say(console, "Changes over the three studies, and shares", style="bold")
    rows = [(name, digits(value)) for name, value in ratio_values(studies).items()]
    show_table(console, ("ratio", "value"), rows)


def _agreement(name: str, items: Sequence[Ratio]) -> str:
    return (
        f"{name}: {within(items, NEAR)} of {len(items)} within {100 * NEAR:g} %, "
        f"{within(items, FAR)} within {100 * FAR:g} %"
    )
