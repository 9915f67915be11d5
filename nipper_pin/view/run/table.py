"""A solution as tables and sentences for a terminal or a plain text file."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain

import numpy as np
from rich.console import Console

from ...arrays import FloatArray
from ...hybrid import Collision, Event, EventKind, Solution, Transition
from ...hybrid.result.quantities import COLLISION, Quantity, coordinate_unit
from ...mechanism import Mechanism
from ...terms import Shown, counted, fixed
from ...units import MS_PER_S
from ..console import headline, paste, say, show_table
from ..phases import intervals
from ..reading import (
    case_text,
    coordinate_shown,
    element_lines,
    force_name,
    in_sight,
    index_at,
    law_text,
    lips_phrase,
    lips_shown,
    phase_name,
    rate_shown,
    restitution_text,
    shown,
    shown_events,
    shown_until,
)
from .sampling import sample_coordinates, sample_forces, sample_motion

_TOLD = ("First", "second")
MOST_ROWS = 100
"""Rows of one kind that are printed: a stop can collide thousands of times in a turn."""
_HELD_SAMPLES = 1441
_KEPT = (
    "index", "t_s", "approach_rate", "separation_rate", "impulse_N_s", "impulse_N_m_s",
    "energy_lost_J", "rebound_amplitude", "rebound_time_s",
)  # fmt: skip
# Rebounds below this part of the largest one of their stop are told together, in one line.
_MICRO = 1e-3


def print_solution(
    solution: Solution,
    console: Console,
    *,
    with_forces: bool = False,
    turns: str = "",
) -> None:
    """Print the results of a run: what its transition came to, then tables.

    Times count from the start of the run. Of many turns the first two are printed.

    Args:
        with_forces: Print the ranges of the forces of closed stops, too.
        turns: The command that simulates whole turns of the same settings.
    """
    header(solution, console)
    if solution.mechanism.transition_stop:
        transitions(solution, console)
        premise(solution, console, turns)
    for text in solution.warnings:
        say(console, text, style="bold")
    _collisions(solution, console)
    _phases(solution, console)
    releases(solution, console)
    if not solution.system.held:
        shafts(solution, console)
    if with_forces:
        forces(solution, console)
    checks(solution, console)
    headline(console, solution.outcome.value)


def header(solution: Solution, console: Console) -> None:
    """Print the machine, the setting and where time is zero."""
    mechanism = solution.mechanism
    say(console, mechanism.title or mechanism.name, style="bold")
    say(console, case_text(solution))
    if mechanism.stops:
        say(console, f"restitution: {restitution_text(mechanism.stops)}")
    if law := law_text(mechanism):
        say(console, law)
    for line in element_lines(mechanism):
        say(console, line)
    say(console, f"Times t count from the start of the run at index {index_at(solution, 0.0):.3f}.")


def transitions(solution: Solution, console: Console) -> None:
    """Print the completed transitions: how long they take and how far the stop rebounds."""
    stop = solution.mechanism.transition_stop
    headline(console, "Transition")
    if not solution.transitions:
        say(console, f"No transition of the {stop} was completed.")
        return
    told = in_sight(solution, solution.transitions)
    for item in told:
        say(console, _duration(solution, item))
    say(console, _rebounds(solution, told[0] if told else solution.transitions[0]))
    say(console, _how_ended(solution))
    more(console, len(solution.transitions) - len(told), "transition")


def premise(solution: Solution, console: Console, turns: str) -> None:
    """Print a remark if no turn of the machine reaches this transition.

    Args:
        turns: The command that simulates whole turns; empty if unknown.
    """
    if solution.premise_holds is not False:
        return
    say(console, f"No turn has this transition: {solution.premise.why}", style="bold")
    if turns:
        say(console, "The one that turns have:")
        paste(console, turns)
    else:
        say(console, "The one that turns have is found by simulating them (window cycle).")


def _duration(solution: Solution, item: Transition) -> str:
    mechanism = solution.mechanism
    share = (
        "" if item.first_two_share is None
        else "; the first two rebounds take "
        f"{shown(mechanism, 'first_two_share').phrase(item.first_two_share)} of it"
    )  # fmt: skip
    hits = counted(item.collisions, "collision")
    duration = shown(mechanism, "duration_s").phrase(item.duration)
    return f"{duration} from the first collision to rest, {hits} computed{share}."


def _rebounds(solution: Solution, item: Transition) -> str:
    """The first two rebounds of a transition in words."""
    mechanism = solution.mechanism
    stop, parts = mechanism.stop(mechanism.transition_stop), []
    hits = (hit for hit in solution.collisions if hit.stop == stop.name and hit.t >= item.t_start)
    for word, hit in zip(_TOLD, hits, strict=False):
        if hit.rebound_amplitude:
            height = shown(mechanism, "rebound_amplitude").phrase(hit.rebound_amplitude)
            lasting = shown(mechanism, "rebound_time_s").phrase(hit.rebound_time)
            lips = lips_phrase(mechanism, stop, hit.rebound_amplitude)
            parts.append(f"{word} rebound {height}{lips} in {lasting}")
    return f"{'; '.join(parts)}." if parts else "It does not rebound."


def _how_ended(solution: Solution) -> str:
    """A remark on the finite duration of infinitely many bounces."""
    mechanism, threshold = solution.mechanism, solution.case.rest_rate
    stop = mechanism.stop(mechanism.transition_stop)
    if stop.restitution == 0.0:
        return "Without restitution the first collision ends it."
    if threshold is None:
        return "The bounces go on for ever; the time of rest is their limit, by extrapolation."
    rate = rate_shown(mechanism, stop.index).phrase(threshold)
    return f"It was ended by a threshold: the first rebound slower than {rate}."


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


def _collisions(solution: Solution, console: Console) -> None:
    if not solution.collisions:
        headline(console, "No collisions")
        return
    told = in_sight(solution, solution.collisions)
    seen = 0
    for name in dict.fromkeys(item.stop for item in told):
        of_stop = [item for item in told if item.stop == name]
        seen += min(len(of_stop), MOST_ROWS)
        _of_stop(solution, name, of_stop[:MOST_ROWS], console)
    more(console, len(solution.collisions) - seen, "collision")
    _copies(solution, console)


def _of_stop(solution: Solution, name: str, hits: Sequence[Collision], console: Console) -> None:
    """Collisions of one stop as a table, with the smallest rebounds in a line below."""
    mechanism = solution.mechanism
    place = "along its joint" if mechanism.stop(name).contact is None else "at the contact"
    headline(console, f"Collisions of stop {name} (rates below zero close it; impulse {place})")
    kept = sorted(
        (item for item in COLLISION if item.name in _KEPT and item.fits(mechanism, name)),
        key=lambda item: _KEPT.index(item.name),
    )
    columns = [(_shown(item, mechanism, name), item.read) for item in kept]
    if (lips := lips_shown(mechanism, mechanism.stop(name))) is not None:
        columns.insert(-1, (lips, lambda _, hit: hit.rebound_amplitude))
    largest = max((item.rebound_amplitude or 0.0 for item in hits), default=0.0)
    micro = [
        item
        for item in hits
        if item.rebound_amplitude is not None and item.rebound_amplitude < _MICRO * largest
    ]
    rows = [
        (str(hit.number), *(term.text(read(solution, hit) if read else None)
                            for term, read in columns))
        for hit in hits if hit not in micro
    ]  # fmt: skip
    headings = ("no.", *(f"{term.words} {term.unit}".rstrip() for term, _ in columns))
    show_table(console, headings, rows, text=())
    if micro:
        index = mechanism.stop(name).index
        limit = coordinate_shown(mechanism, index, small=True).phrase(_MICRO * largest)
        noun = "rebound" if len(micro) == 1 else "rebounds"
        say(console, f"{len(micro)} more {noun} below {limit} (all of them: --json, --out).")
    if any(item.rebound_time is None for item in hits):
        say(console, "-: the window ends before the rebound does.")


def _shown(item: Quantity[Collision], mechanism: Mechanism, stop: str) -> Shown:
    found = item.term.shown(coordinate_unit(mechanism, mechanism.stop(stop).index))
    return found.called("t") if item.name == "t_s" else found


def _copies(solution: Solution, console: Console) -> None:
    """Print a remark if all later turns are equal."""
    turn, cycles = solution.repeated_from, solution.case.cycles
    if turn is not None and turn < cycles:
        later = f"Turn {cycles} is" if turn + 1 == cycles else f"Turns {turn + 1} to {cycles} are"
        say(console, f"{later} equal to turn {turn}: the motion repeats exactly.")


def _phases(solution: Solution, console: Console) -> None:
    headline(console, "Phases")
    told = intervals(solution)
    rows = [
        (
            item.name.removeprefix("phase "),
            ", ".join(sorted(item.closed)) or "none",
            fixed(index_at(solution, item.start), 3),
            fixed(index_at(solution, item.end), 3),
            fixed(MS_PER_S * item.start, 3),
            fixed(MS_PER_S * (item.end - item.start), 3),
        )
        for item in told[:MOST_ROWS]
    ]
    headings = ("phase", "closed stops", "from index", "to index", "from t ms", "duration ms")
    show_table(console, headings, rows, text=(0, 1))
    more(console, len(solution.phases) - min(len(told), MOST_ROWS), "phase")
