"""A stress campaign as a table for a terminal."""

from __future__ import annotations

from rich.console import Console

from nipper_pin.view.console import say, show_table

from ..stress import WRONG, Campaign, Verdict

_FAILURES = 20


def print_campaign(campaign: Campaign, console: Console) -> None:
    """Print what was tried, how often, and what happened."""
    record, words = campaign.record(), ("right", "refused", "wrong")
    rows = [
        (family, *(str(found[word]) for word in words))
        for family, found in record["families"].items()
    ]
    rows.append(("all", *(str(record[word]) for word in words)))
    show_table(console, ("family", *words), rows)
    for title in ("errors", "outcomes"):
        text = ", ".join(f"{kind} {count}" for kind, count in record[title].items())
        say(console, f"{title}: {text or 'none'}")
    # Of one case alone the reason of a refusal is asked for, too.
    alone = len(campaign.verdicts) == 1
    wrong = [item for item in campaign.verdicts if alone or item.word == WRONG]
    for item in wrong[:_FAILURES]:
        print_verdict(item, console)
    if len(wrong) > _FAILURES:
        say(console, f"and {len(wrong) - _FAILURES} more")
    say(
        console,
        f"{record['cases']} cases, seed {campaign.seed}, {campaign.wall_s:.3g} s; "
        f"digest {record['digest'][:16]}",
    )


def print_verdict(verdict: Verdict, console: Console) -> None:
    """Print one verdict."""
    text = f"case {verdict.number} ({verdict.family}): {verdict.word}, {verdict.kind}"
    say(console, f"{text}: {verdict.detail}" if verdict.detail else text)
