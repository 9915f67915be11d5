"""What else a run tells: releases, speeds of shafts, forces, checks, as a terminal shows them."""

from __future__ import annotations

from itertools import chain

import numpy as np
from rich.console import Console

from ...arrays import FloatArray
from ...hybrid import Event, EventKind, Solution
from ...terms import fixed
from ...units import MS_PER_S
from ..console import headline, say, show_table
from ..naming import coordinate_shown, lips_phrase, rate_shown
from ..reading import (
    force_name,
    in_sight,
    index_at,
    phase_name,
    shown_events,
    shown_until,
)
from .sampling import sample_coordinates, sample_forces, sample_motion

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
    following = solution.events[event.number :]
    later = next((item for item in following if event.stops[0] in item.stops), None)
    if len(event.stops) == 1 and later is not None:
        stop = mechanism.stop(event.stops[0])
        gap = float(stop.gaps(sample_coordinates(solution, event.t, later.t)[1]).max())
        height = coordinate_shown(mechanism, stop.index, small=True).phrase(gap)
        text += f", opens by up to {height}{lips_phrase(mechanism, stop, gap)} and collides "
        text += f"{MS_PER_S * (later.t - event.t):.3f} ms later"
    waits = mechanism.transition_stop not in event.closed_before
    if phase is None or phase.number != mechanism.initial_phase or not waits:
        return text + "."
    return (
        f"{text}. This is before the {mechanism.transition_stop} collides: to hold the {who} "
        "closed until then would need a force that pulls."
    )


def shafts(solution: Solution, console: Console) -> None:
    """Print the speeds of elastically driven shafts, beside those of held drives."""
    found = [item.v for item in sample_motion(solution, 0.0, shown_until(solution))]
    if not found:
        return
    headline(console, "Speeds of the driven joints")
    rows = []
    times = np.linspace(0.0, shown_until(solution), _HELD_SAMPLES)
    v, held = np.concatenate(found), solution.shaft.driven(times)[1]
    for column, drive in enumerate(solution.mechanism.drives):
        rate = rate_shown(solution.mechanism, drive.index)
        ranges = (v[:, drive.index], held[:, column])
        ends = (float(end) for values in ranges for end in (values.min(), values.max()))
        cells = (f"{rate.value(end):.6g}" for end in ends)
        rows.append((drive.name, rate.unit, *cells))
    headings = ("drive", "unit", "smallest", "largest", "held: smallest", "held: largest")
    show_table(console, headings, rows, text=(0, 1))


def forces(solution: Solution, console: Console) -> None:
    """Print the ranges of the forces of closed stops in the turns shown."""
    headline(console, "Forces of closed stops")
    mechanism, until = solution.mechanism, shown_until(solution)
    samples: dict[tuple[frozenset[str], str], list[tuple[FloatArray, FloatArray]]] = {}
    for phase in in_sight(solution, solution.phases):
        sampled = sample_forces(solution, phase.t_start, min(phase.t_end, until))
        for stop in sorted(phase.closed):
            samples.setdefault((phase.closed, stop), []).append(sampled[stop])
    rows = []
    for (closed, stop), parts in samples.items():
        t, force = np.concatenate(parts, axis=1)
        if not np.isnan(force).all():
            ends = (np.nanargmin(force), np.nanargmax(force))
            cells = ((fixed(float(force[at]), 2), fixed(index_at(solution, float(t[at])), 3))
                     for at in ends)  # fmt: skip
            name = phase_name(mechanism, closed)
            rows.append((name, force_name(mechanism, stop), stop, *chain(*cells)))
    if not rows:
        say(console, "No stop is closed in this window.")
        return
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
