"""A solution as tables and sentences for a terminal or a plain text file."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from ...hybrid.event import Event, EventKind
from ...hybrid.result.quantities import COLLISION, Quantity
from ...hybrid.result.solution import Solution
from ...hybrid.result.tables import Collision
from ...units import MJ_PER_J, MS_PER_S
from ..reading import (
    Units,
    case_text,
    damper_text,
    digits,
    fixed,
    force_name,
    force_text,
    index_at,
    phase_name,
    restitution_text,
    shown_collisions,
    shown_events,
    shown_phases,
    shown_transitions,
    shown_until,
    spring_text,
    units_of,
)
from .sampling import force_ranges, lift, shaft_rates

# Below this width the columns stand one space apart.
_ROOMY = 100
# A stop that never comes to rest can collide thousands of times in one turn.
_MOST_ROWS = 100
_HELD_SAMPLES = 1441
_KEPT = (
    "index", "time_s", "approach_rate", "separation_rate", "impulse_N_s", "impulse_N_m_s",
    "energy_lost_J", "rebound_amplitude", "rebound_time_s",
)  # fmt: skip
_DECIMALS = {"index": 4, "time_s": 5}


def print_solution(
    solution: Solution, console: Console, *, forces: bool = False, turns: str = ""
) -> None:
    """Print the results of a run.

    Times count from the first collision. Of many turns the first two are printed.

    Args:
        solution: The solution.
        console: Where to print; 80 columns are enough.
        forces: Print the ranges of the forces of closed stops, too.
        turns: The command that simulates whole turns of the same settings.
    """
    _header(solution, console)
    _collisions(solution, console)
    _phases(solution, console)
    if solution.mechanism.transition_stop:
        _transitions(solution, console)
        _premise(solution, console, turns)
    _releases(solution, console)
    if not solution.system.held:
        _shafts(solution, console)
    if forces:
        _forces(solution, console)
    _checks(solution, console)
    _say(console, solution.outcome.value, style="bold")


def _header(solution: Solution, console: Console) -> None:
    mechanism = solution.mechanism
    _say(console, mechanism.title or mechanism.name, style="bold")
    _say(console, case_text(solution))
    if mechanism.stops:
        _say(console, f"restitution: {restitution_text(mechanism.stops)}")
    _say(console, f"springs: {spring_text(mechanism)}")
    if dampers := damper_text(mechanism):
        _say(console, f"dampers: {dampers}")
    if forces := force_text(mechanism):
        _say(console, f"forces: {forces}")


def _collisions(solution: Solution, console: Console) -> None:
    mechanism = solution.mechanism
    if not solution.collisions:
        _headline(console, "No collisions")
        return
    shown = shown_collisions(solution)
    printed = 0
    for name in dict.fromkeys(item.stop for item in shown):
        of_stop = [item for item in shown if item.stop == name][:_MOST_ROWS]
        place = "along its joint" if mechanism.stop(name).contact is None else "at the contact"
        _headline(
            console, f"Collisions of stop {name} (rates below zero close it; impulse {place})"
        )
        units = units_of(mechanism, mechanism.stop(name).index)
        kept = sorted(
            (item for item in COLLISION if item.name in _KEPT and item.fits(mechanism, name)),
            key=lambda item: _KEPT.index(item.name),
        )
        table = _table(
            console,
            ("no.", *(_heading(item, units) for item in kept)),
        )
        for hit in of_stop:
            table.add_row(str(hit.number), *(_cell(solution, hit, item, units) for item in kept))
        console.print(table)
        printed += len(of_stop)
        if any(item.rebound_time is None for item in of_stop):
            _say(console, "-: the window ends before the rebound does.")
    _more(console, len(solution.collisions) - printed, "collision")
    _copies(solution, console)


def _shown(item: Quantity[Collision], units: Units) -> tuple[str, float]:
    """Unit of a column and the factor from the SI value."""
    by_unit = {
        "s": ("ms", MS_PER_S),
        "J": ("mJ", MJ_PER_J),
        "{gap}": (units.amplitude, units.amplitude_factor),
        "{gap}/s": (units.rate, units.rate_factor),
    }
    return by_unit.get(item.unit, (item.unit, 1.0))


def _heading(item: Quantity[Collision], units: Units) -> str:
    unit, _ = _shown(item, units)
    return "\n".join([*item.words.split(), *([unit] if unit else [])])


def _cell(solution: Solution, hit: Collision, item: Quantity[Collision], units: Units) -> str:
    value = item.read(solution, hit) if item.read else None
    _, factor = _shown(item, units)
    if value is None or item.name not in _DECIMALS:
        return digits(None if value is None else factor * value)
    return fixed(factor * value, _DECIMALS[item.name])


def _copies(solution: Solution, console: Console) -> None:
    """Print a remark if all later turns are equal."""
    turn, cycles = solution.repeated_from, solution.case.cycles
    if turn is not None and turn < cycles:
        later = f"Turn {cycles} is" if turn + 1 == cycles else f"Turns {turn + 1} to {cycles} are"
        _say(console, f"{later} equal to turn {turn}: the motion repeats exactly.")


def _phases(solution: Solution, console: Console) -> None:
    _headline(console, "Phases")
    table = _table(
        console,
        ("from\nindex", "to\nindex", "duration\nms"),
        text=("phase", "closed stops"),
    )
    shown = shown_phases(solution)
    for item in shown[:_MOST_ROWS]:
        table.add_row(
            Text(phase_name(solution.mechanism, item.closed)),
            Text(", ".join(sorted(item.closed)) or "none"),
            fixed(index_at(solution, item.t_start), 4),
            fixed(index_at(solution, item.t_end), 4),
            fixed(MS_PER_S * (item.t_end - item.t_start), 5),
        )
    console.print(table)
    _more(console, len(solution.phases) - min(len(shown), _MOST_ROWS), "phase")


def _transitions(solution: Solution, console: Console) -> None:
    stop = solution.mechanism.transition_stop
    _headline(console, "Transition")
    if not solution.transitions:
        _say(console, f"No transition of the {stop} was completed.")
        return
    shown = shown_transitions(solution)
    for item in shown:
        share = (
            "" if item.first_two_share is None
            else f"; the first two rebounds take {100.0 * item.first_two_share:.2f} % of it"
        )  # fmt: skip
        noun = "collision" if item.collisions == 1 else "collisions"
        text = (
            f"{MS_PER_S * item.duration:.5f} ms from the first collision to rest, {item.collisions}"
        )
        _say(console, f"{text} {noun} computed{share}.")
    _say(console, _how_ended(solution))
    _more(console, len(solution.transitions) - len(shown), "transition")


def _premise(solution: Solution, console: Console, turns: str) -> None:
    """Print a remark if no turn of the machine reaches this transition."""
    if solution.premise_holds is not False:
        return
    _say(console, f"No turn has this transition: {solution.premise.why}", style="bold")
    if turns:
        _say(console, "The one that turns have:")
        # One line on any terminal, so that it can be pasted.
        console.print(Text(turns), soft_wrap=True)
    else:
        _say(console, "The one that turns have is found by simulating them (window cycle).")


def _how_ended(solution: Solution) -> str:
    """Print a remark on the finite duration of infinitely many bounces."""
    mechanism, threshold = solution.mechanism, solution.case.rest_rate
    stop = mechanism.stop(mechanism.transition_stop)
    if stop.restitution == 0.0:
        return "Without restitution the first collision ends it."
    if threshold is None:
        return "The bounces go on for ever; the time of rest is their limit, by extrapolation."
    units = units_of(mechanism, stop.index)
    rate = f"{digits(units.rate_factor * threshold)} {units.rate}"
    return f"It was ended by a threshold: the first rebound slower than {rate}."


def _releases(solution: Solution, console: Console) -> None:
    shown = shown_events(solution, EventKind.RELEASE)
    if not shown:
        return
    _headline(console, "Releases")
    for event in shown[:_MOST_ROWS]:
        _say(console, _release_text(solution, event))
    total = sum(item.kind is EventKind.RELEASE for item in solution.events)
    _more(console, total - min(len(shown), _MOST_ROWS), "release")


def _release_text(solution: Solution, event: Event) -> str:
    mechanism = solution.mechanism
    phase = mechanism.phase_of(event.closed_before)
    where = "" if phase is None else f" in phase {phase.number}"
    who = " and ".join(event.stops)
    leave = "leaves its stop" if len(event.stops) == 1 else "leave their stops"
    text = f"The {who} {leave}{where} at index {index_at(solution, event.t):.4f}"
    lifted = lift(solution, event) if len(event.stops) == 1 else None
    if lifted is not None:
        units = units_of(mechanism, mechanism.stop(event.stops[0]).index)
        gap, duration = digits(units.amplitude_factor * lifted[0]), f"{MS_PER_S * lifted[1]:.3f}"
        text += f", opens by up to {gap} {units.amplitude} and collides {duration} ms later"
    waits = mechanism.transition_stop not in event.closed_before
    if phase is None or phase.number != mechanism.initial_phase or not waits:
        return text + "."
    return (
        f"{text}. This is before the {mechanism.transition_stop} collides: to hold the {who} "
        "closed until then would need a force that pulls."
    )


def _shafts(solution: Solution, console: Console) -> None:
    """Speeds of elastically driven shafts, beside those of held drives."""
    rates = shaft_rates(solution)
    if not rates:
        return
    _headline(console, "Speeds of the driven joints")
    table = _table(
        console,
        ("smallest", "largest", "held:\nsmallest", "held:\nlargest"),
        text=("drive", "unit"),
    )
    times = np.linspace(0.0, shown_until(solution), _HELD_SAMPLES)
    held = solution.shaft.driven(times)[1]
    for column, drive in enumerate(solution.mechanism.drives):
        units = units_of(solution.mechanism, drive.index)
        own = held[:, column]
        values = (*rates[drive.name], float(own.min()), float(own.max()))
        cells = (f"{units.rate_factor * value:.6g}" for value in values)
        table.add_row(Text(drive.name), Text(units.rate), *cells)
    console.print(table)


def _forces(solution: Solution, console: Console) -> None:
    """Ranges of the forces of closed stops in the turns shown."""
    ranges = force_ranges(solution)
    _headline(console, "Forces of closed stops")
    if not ranges:
        _say(console, "No stop is closed in this window.")
        return
    table = _table(
        console,
        ("lowest", "at\nindex", "highest", "at\nindex"),
        text=("phase", "force", "stop"),
    )
    for item in ranges:
        table.add_row(
            Text(phase_name(solution.mechanism, item.closed)),
            Text(force_name(solution.mechanism, item.stop)),
            Text(item.stop),
            fixed(item.lowest, 2),
            fixed(index_at(solution, item.t_lowest), 3),
            fixed(item.highest, 2),
            fixed(index_at(solution, item.t_highest), 3),
        )
    console.print(table)


def _checks(solution: Solution, console: Console) -> None:
    checks = solution.checks
    _headline(console, "Checks and work")
    _say(
        console,
        f"closure {checks.closure_m:.1e} m, closure rate {checks.closure_rate_m_s:.1e} m/s, "
        f"energy balance {checks.energy_balance:.1e} of the largest kinetic energy",
    )
    _say(
        console,
        f"direct engine: {solution.evaluations} evaluations of the dynamics, "
        f"{MS_PER_S * solution.wall_s:.1f} ms",
    )


def _table(console: Console, columns: Iterable[str], text: Sequence[str] = ()) -> Table:
    """Return a table of text columns, then number columns; digits fold rather than get lost."""
    padding = (0, 1) if console.width >= _ROOMY else (0, 0)
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=padding)
    for name in text:
        table.add_column(name, overflow="fold", vertical="bottom")
    for name in columns:
        table.add_column(Text(name), justify="right", overflow="fold", vertical="bottom")
    return table


def _more(console: Console, count: int, noun: str) -> None:
    if count:
        verb = " is" if count == 1 else "s are"
        _say(console, f"{count} more {noun}{verb} not shown.")


def _headline(console: Console, text: str) -> None:
    console.print()
    _say(console, text, style="bold")


def _say(console: Console, text: str, style: str = "") -> None:
    # As Text, names with square brackets are not taken for markup.
    console.print(Text(text, style=style), highlight=False)
