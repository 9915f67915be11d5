"""A stress campaign as a table for a terminal."""

from __future__ import annotations

from rich import box
from rich.console import Console
from rich.table import Table

from ...view.console import paste
from ..stress import WRONG, Campaign, Verdict

_FAILURES = 20


def print_campaign(campaign: Campaign, console: Console) -> None:
    """Print what was tried, how often, and what happened.

    Args:
        campaign: The campaign.
        console: Where to print; 80 columns are enough.
    """
    record = campaign.record()
    table = Table(box=box.SIMPLE_HEAD)
    for name in ("family", "right", "refused", "wrong"):
        table.add_column(name, justify="left" if name == "family" else "right")
    for family, words in record["families"].items():
        table.add_row(family, *(str(words[name]) for name in ("right", "refused", "wrong")))
    table.add_section()
    table.add_row("all", *(str(record[name]) for name in ("right", "refused", "wrong")))
    console.print(table)
    for title in ("errors", "outcomes"):
        text = ", ".join(f"{kind} {count}" for kind, count in record[title].items())
        paste(console, f"{title}: {text or 'none'}")
    wrong = [item for item in campaign.verdicts if item.word == WRONG]
    for item in wrong[:_FAILURES]:
        print_verdict(item, console)
    if len(wrong) > _FAILURES:
        console.print(f"and {len(wrong) - _FAILURES} more")
    console.print(
        f"{record['cases']} cases, seed {campaign.seed}, {campaign.wall_s:.3g} s; "
        f"digest {record['digest'][:16]}"
    )


def print_verdict(verdict: Verdict, console: Console) -> None:
    """Print one verdict."""
    text = f"case {verdict.number} ({verdict.family}): {verdict.word}, {verdict.kind}"
    paste(console, f"{text}: {verdict.detail}" if verdict.detail else text)
