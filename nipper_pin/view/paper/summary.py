"""The study on a terminal."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from ...study.paper import PaperStudy
from ...study.paper.study import FAR, NEAR, NOTE
from ..reading import digits
from .tables import percent


def print_paper(study: PaperStudy, console: Console) -> None:
    """Print the published ratios beside ours.

    Args:
        study: The study.
        console: Where to print.
    """
    table = Table(title="Published ratios beside ours", title_justify="left")
    table.add_column("ratio", no_wrap=True)
    for heading in ("published", "ours", "deviation"):
        table.add_column(heading, justify="right")
    for item in study.ratios:
        table.add_row(
            item.name, f"{item.published:g}", digits(item.ours), percent(item.relative_deviation)
        )
    console.print(table)
    console.print(
        f"{study.within(NEAR)} of {len(study.ratios)} within {100 * NEAR:g} %, "
        f"{study.within(FAR)} within {100 * FAR:g} %"
    )
    console.print(NOTE)
