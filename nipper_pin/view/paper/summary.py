"""The study on a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from ...study.paper import PaperStudy
from ...study.paper.designer import Designer
from ...study.paper.ratios import Ratio, ratio_values, within
from ...study.paper.studies import Studies
from ...study.paper.study import FAR, IDENTIFIED, NEAR, note
from ...terms import digits
from ..console import headline, paste, say, show_table
from .front_page import front_page
from .tables import percent, ratio_words


def print_paper(study: PaperStudy, console: Console, found: Designer | None = None) -> None:
    """Print the published ratios beside ours, or the changes of another machine.

    Args:
        study: The study.
        console: Where to print.
        found: What a designer wants to know; printed last, with the next command.
    """
    if study.compared:
        _ratios(study.ratios, console)
        say(console, _agreement(study.mechanism.name, study.ratios))
    else:
        _changes(study.studies, console)
    if study.identified:
        say(console, _agreement(IDENTIFIED, study.identified))
    say(console, note(study))
    if found is not None:
        _found(study, found, console)


def _ratios(items: Sequence[Ratio], console: Console) -> None:
    say(console, "Published ratios beside ours", style="bold")
    show_table(
        console,
        ("ratio", "published", "ours", "deviation"),
        [
            (ratio_words(item.name), f"{item.published:g}", digits(item.ours),
             percent(item.relative_deviation))
            for item in items
        ],
    )  # fmt: skip


def _changes(studies: Studies, console: Console) -> None:
    say(console, "Changes over the three studies, and shares", style="bold")
    rows = [(name_words(name), digits(value)) for name, value in ratio_values(studies).items()]
    show_table(console, ("ratio", "value"), rows)


def name_words(name: str) -> str:
    """A ratio in words without the values of the E62, between which another machine's differ.

    Args:
        name: Study and quantity, as in the JSON document.
    """
    study, _, quantity = name.partition(".")
    over = {"stiffness": "spring rate"}.get(study, study)
    return f"{quantity.replace('_', ' ')} over the {over}"


def _found(study: PaperStudy, found: Designer, console: Console) -> None:
    """What a designer wants to know, and the command that tries the strongest lever."""
    page = front_page(study, found)
    headline(console, "For the designer")
    for text in (*page.bounces, *page.fast):
        # Terminals may lack the Greek letter.
        say(console, text.replace("µm", "um"))
    for lever in page.levers:
        say(
            console,
            f"{lever.words} ({lever.value}): first rebound {lever.amplitude_change}, time to rest "
            f"{lever.duration_change}, clamping force {lever.clamping_change}",
        )
    if page.levers:
        paste(
            console,
            f"Next: nipper-pin simulate {study.mechanism.name} --speed {found.speed_rpm:g} "
            f"{page.levers[0].typed}",
        )


def _agreement(name: str, items: Sequence[Ratio]) -> str:
    return (
        f"{name}: {within(items, NEAR)} of {len(items)} within {100 * NEAR:g} %, "
        f"{within(items, FAR)} within {100 * FAR:g} %"
    )
