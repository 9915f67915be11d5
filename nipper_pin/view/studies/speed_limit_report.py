"""How fast a machine can run, on the terminal."""

from __future__ import annotations

import numpy as np
from rich.console import Console

from ...study.speed_limit import SpeedLimit, Verdict, where
from ..console import headline, say, show_table

_ROWS = 12
_HEADINGS = ("speed r/min", "touches", "rests", "opens", "margin", "clamped %", "repeats after")


def print_speed_limit(result: SpeedLimit, console: Console) -> None:
    """Print the limits and a few speeds."""
    low, high = result.speed_rpm[0], result.speed_rpm[-1]
    say(console, f"{result.title}: {low:g} to {high:g} r/min", style="bold")
    chosen = np.unique(np.linspace(0, len(result.speed_rpm) - 1, _ROWS).astype(int))
    show_table(console, _HEADINGS, [_row(result, int(place)) for place in chosen], text=())
    say(
        console,
        "touches, rests, opens: index in the last turn; margin: indices from rest "
        "to opening; clamped: share of the turn; repeats after: turns, > if not within those "
        "followed",
    )
    headline(console, f"Found: {_sentence(result)}")


def _row(result: SpeedLimit, place: int) -> tuple[str, ...]:
    again = int(result.repeats_after[place])
    indices = (result.closing, result.rest, result.opening, result.margin)
    return (
        f"{result.speed_rpm[place]:.4g}",
        *(_index(values[place]) for values in indices),
        f"{100.0 * result.clamped_share[place]:.1f}",
        str(again) if again else (">" if result.status[place] == "followed" else "-"),
    )


def _index(value: float) -> str:
    return f"{value:.2f}" if np.isfinite(value) else "-"


def _sentence(result: SpeedLimit) -> str:
    """Where the stop rests, where turns repeat, and where that is not known."""
    rests, restless = (where(result.settled, verdict) for verdict in (Verdict.YES, Verdict.NO))
    single, others = (where(result.single, verdict) for verdict in (Verdict.YES, Verdict.NO))
    said = [
        f"The {result.stop} comes to rest before it opens {rests}." if rests else "",
        f"The {result.stop} is not at rest before it opens {restless}." if restless else "",
        f"Every turn repeats the one before {single}." if single else "",
        f"Turns do not repeat the one before {others}." if others else "",
        f"Not known {where(result.settled, Verdict.UNKNOWN)}. {result.lost}" if result.lost else "",
    ]
    return " ".join(filter(None, said))
