"""A stress campaign as a table for a terminal."""

from __future__ import annotations

from rich.console import Console

from nipper_pin.view.console import say, show_table

from ..stress import WRONG, Campaign

_FAILURES = 20


def print_campaign(campaign: Campaign, console: Console) -> None:
    """Print what was tried, how often, and what happened."""
    record, words = campaign.record(), ("right", "refused", "wrong")
    families = {**record["families"], "all": record}
    rows = [(name, *(str(found[word]) for word in words)) for name, found in families.items()]
    show_table(console, ("family", *words), rows)
    for title in ("errors", "outcomes"):
        text = ", ".join(f"{kind} {count}" for kind, count in record[title].items())
        say(console, f"{title}: {text or 'none'}")
    # Of one case alone the reason of a refusal is asked for, too.
    alone = len(campaign.verdicts) == 1
    wrong = [item for item in campaign.verdicts if alone or item.word == WRONG]
    for item in wrong[:_FAILURES]:
        text = f"case {item.number} ({item.family}): {item.word}, {item.kind}"
        say(console, f"{text}: {item.detail}" if item.detail else text)
    if len(wrong) > _FAILURES:
        say(console, f"and {len(wrong) - _FAILURES} more")
    say(
        console,
        f"{record['cases']} cases, seed {campaign.seed}, {campaign.wall_s:.3g} s; "
        f"digest {record['digest'][:16]}",
    )
