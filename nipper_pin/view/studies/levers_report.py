"""What bounces and what calms it, on the terminal."""

from __future__ import annotations

import numpy as np
from rich.console import Console

from ...study.levers import Bounce, Levers
from ...terms import TERMS
from ...units import MS_PER_S
from ..console import headline, paste, say, show_table
from ..reading import lips_phrase

_HEADINGS = ("change", "from and to", "first rebound", "time to rest", "holds ms")


def print_levers(found: Levers, console: Console, compare: str) -> None:
    """Print the bounce, and the strongest changes with their effects.

    Args:
        compare: The command line that compares the machine with itself, to which a change is added.
    """
    say(console, found.mechanism.title or found.mechanism.name, style="bold")
    say(console, f"{found.speed_rpm:g} r/min, stop {found.stop}")
    headline(console, "What bounces")
    say(console, _why(found))
    say(console, _bounce(found))
    headline(console, "What calms it most, one unit of each part")
    if not found.found:
        say(console, f"None of {found.tried} changed machines has a lower first rebound.")
        return
    rows = [
        (
            str(item),
            item.values,
            _percent(item.amplitude_change),
            _percent(item.duration_change),
            _held(item.after),
        )
        for item in found.found
    ]
    show_table(console, _HEADINGS, rows, text=(0, 1))
    say(console, f"Holds now: {_held(found.bounce)} ms. {found.tried} changed machines were run.")
    headline(console, "Next: see one beside the machine as it is")
    for item in found.found:
        paste(console, f"{compare} --set-b {item.setting}")


def _why(found: Levers) -> str:
    """How fast the stop is struck, and what sends it back."""
    rate = TERMS["approach_rate"].shown(found.unit)
    before, after = (
        f"{rate.value(abs(value)):.4g} {rate.unit}"
        for value in (found.approach_rate, found.separation_rate)
    )
    share = abs(found.separation_rate / found.approach_rate) if found.approach_rate else np.nan
    said = f"The {found.stop} is struck at {before} and sent back at {after}, {share:.2g} of that."
    if found.premise_holds is False:
        said += " The machine arrives otherwise than a transition assumes: this is its turn's."
    return said


def _bounce(found: Levers) -> str:
    """How high and how long it bounces."""
    stop, bounce = found.mechanism.stop(found.stop), found.bounce
    gap = TERMS["rebound_amplitude"].shown(found.unit)
    height = f"{gap.phrase(bounce.amplitude)}{lips_phrase(found.mechanism, stop, bounce.amplitude)}"
    if bounce.duration_s is None:
        return f"Its highest rebound in a turn: {height}."
    return f"First rebound {height}; at rest after {MS_PER_S * bounce.duration_s:.4g} ms."


def _held(bounce: Bounce) -> str:
    return "-" if bounce.clamped_time_s is None else f"{MS_PER_S * bounce.clamped_time_s:.4g}"


def _percent(change: float | None) -> str:
    return "-" if change is None else f"{100.0 * change + 0.0:+.1f} %"
