"""What else a run tells: releases, speeds of shafts, forces, checks, as a terminal shows them."""

from __future__ import annotations

import numpy as np
from rich.console import Console

from ...hybrid import Event, EventKind, Solution
from ...terms import fixed
from ...units import MS_PER_S
from ..console import headline, say, show_table
from ..naming import coordinate_shown, rate_shown
from ..reading import (
    force_name,
    index_at,
    phase_name,
    shown_events,
    shown_until,
)
from .sampling import force_ranges, lift, shaft_rates

MOST_ROWS = 100
"""Rows of one kind that are printed: a stop can collide thousands of times in a turn."""
_HELD_SAMPLES = 1441


def more(console: Console, count: int, noun: str) -> None:
    """Print how many rows of one kind were left out."""
    if count:
        verb = " is" if count == 1 else "s are"
        say(console, f"{count} more {noun}{verb} not shown.")


def releases(solution: Solution, console: Console) -> None:
    """Print where stops are left because their force falls to zero."""
    shown = shown_events(solution, EventKind.RELEASE)
    if not shown:
        return
    headline(console, "Releases")
    for event in shown[:MOST_ROWS]:
        say(console, _release_text(solution, event))
    total = sum(item.kind is EventKind.RELEASE for item in solution.events)
    more(console, total - min(len(shown), MOST_ROWS), "release")


def _release_text(solution: Solution, event: Event) -> str:
    mechanism = solution.mechanism
    phase = mechanism.phase_of(event.closed_before)
    where = "" if phase is None else f" in phase {phase.number}"
    who = " and ".join(event.stops)
    leave = "leaves its stop" if len(event.stops) == 1 else "leave their stops"
    text = f"The {who} {leave}{where} at index {index_at(solution, event.t):.3f}"
    lifted = lift(solution, event) if len(event.stops) == 1 else None
    if lifted is not None:
        term = coordinate_shown(mechanism, mechanism.stop(event.stops[0]).index, small=True)
        gap, duration = term.phrase(lifted[0]), f"{MS_PER_S * lifted[1]:.3f}"
        text += f", opens by up to {gap} and collides {duration} ms later"
    waits = mechanism.transition_stop not in event.closed_before
    if phase is None or phase.number != mechanism.initial_phase or not waits:
        return text + "."
    return (
        f"{text}. This is before the {mechanism.transition_stop} collides: to hold the {who} "
        "closed until then would need a force that pulls."
    )


def shafts(solution: Solution, console: Console) -> None:
    """Print the speeds of elastically driven shafts, beside those of held drives."""
    rates = shaft_rates(solution)
    if not rates:
        return
    headline(console, "Speeds of the driven joints")
    rows = []
    times = np.linspace(0.0, shown_until(solution), _HELD_SAMPLES)
    held = solution.shaft.driven(times)[1]
    for column, drive in enumerate(solution.mechanism.drives):
        rate = rate_shown(solution.mechanism, drive.index)
        own = held[:, column]
        values = (*rates[drive.name], float(own.min()), float(own.max()))
        cells = (f"{rate.value(value):.6g}" for value in values)
        rows.append((drive.name, rate.unit, *cells))
    headings = ("drive", "unit", "smallest", "largest", "held: smallest", "held: largest")
    show_table(console, headings, rows, text=(0, 1))


def forces(solution: Solution, console: Console) -> None:
    """Print the ranges of the forces of closed stops in the turns shown."""
    ranges = force_ranges(solution)
    headline(console, "Forces of closed stops")
    if not ranges:
        say(console, "No stop is closed in this window.")
        return
    rows = [
        (
            phase_name(solution.mechanism, item.closed),
            force_name(solution.mechanism, item.stop),
            item.stop,
            fixed(item.lowest, 2),
            fixed(index_at(solution, item.t_lowest), 3),
            fixed(item.highest, 2),
            fixed(index_at(solution, item.t_highest), 3),
        )
        for item in ranges
    ]
    headings = ("phase", "force", "stop", "lowest", "at index", "highest", "at index")
    show_table(console, headings, rows, text=(0, 1, 2))


def checks(solution: Solution, console: Console) -> None:
    """Print how well the run keeps its closures and its energy, and its work."""
    found = solution.checks
    headline(console, "Checks and work")
    say(
        console,
        f"closure {found.closure_m:.1e} m, closure rate {found.closure_rate_m_s:.1e} m/s, "
        f"energy balance {found.energy_balance:.1e} of the largest kinetic energy",
    )
    say(
        console,
        f"direct engine: {solution.evaluations} evaluations of the dynamics, "
        f"{MS_PER_S * solution.wall_s:.1f} ms",
    )
