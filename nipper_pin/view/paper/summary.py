"""The study on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table

from ...study.paper import PaperStudy
from ...study.paper.ratios import Ratio, within
from ...study.paper.study import FAR, IDENTIFIED, NEAR, NOTE
from ..reading import digits
from .tables import percent


def print_paper(study: PaperStudy, console: Console) -> None:
    """Print the published ratios beside ours.

    Args:
        study: The study.
        console: Where to print.
    """
    table = Table(title="Published ratios beside ours", title_justify="left", box=box.SIMPLE_HEAD,
                  show_edge=False, pad_edge=False)  # fmt: skip
    table.add_column("ratio")
    for heading in ("published", "ours", "deviation"):
        table.add_column(heading, justify="right", no_wrap=True)
    for item in study.ratios:
        table.add_row(
            item.name, f"{item.published:g}", digits(item.ours), percent(item.relative_deviation)
        )
    console.print(table)
    console.print(_agreement(study.mechanism.name, study.ratios))
    if study.identified:
        console.print(_agreement(IDENTIFIED, study.identified))
    console.print(NOTE)


def _agreement(name: str, items: Sequence[Ratio]) -> str:
    return (
        f"{name}: {within(items, NEAR)} of {len(items)} within {100 * NEAR:g} %, "
        f"{within(items, FAR)} within {100 * FAR:g} %"
    )
