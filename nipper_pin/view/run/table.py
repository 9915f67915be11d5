"""A solution as tables and sentences for a terminal or a plain text file."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console

from ...hybrid import Collision, Solution
from ...hybrid.result.quantities import COLLISION, Quantity, coordinate_unit
from ...mechanism import Mechanism
from ...terms import Shown, fixed
from ...units import MS_PER_S
from ..console import headline, say, show_table
from ..naming import coordinate_shown, lips_shown
from ..phases import intervals
from ..reading import in_sight, index_at
from .lead import header, premise, transitions
from .remarks import MOST_ROWS, checks, forces, more, releases, shafts

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
