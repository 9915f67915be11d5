"""Phases of a run as they are shown: words and colours, told apart by what bounces in them.

Viewer, strip and plots take them from here, so that one stretch of time has one name in all.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..hybrid import EventKind, PhaseInterval, Solution
from ..mechanism import Mechanism
from .reading import in_sight, phase_name

# Okabe and Ito's palette: strong for solids and the strip, and pale behind the curves of plots.
_COLOURS = (
    ("#F0E442", "#FFFFFF"),
    ("#56B4E9", "#A9D5F0"),
    ("#E69F00", "#F6D58C"),
    ("#009E73", "#BFE3D2"),
    ("#CC79A7", "#E9C7DC"),
)
_UNNAMED = ("#777777", "#CCCCCC")
ELSEWHERE = "#F7F0B5"
"""Of phases in which the transition stop is open and another one bounces or is left; pale enough
for plots as well."""


@dataclass(frozen=True)
class Interval:
    """A phase as it is shown.

    Attributes:
        start: Its begin [s].
        end: Its end [s].
        closed: Stops that are closed.
        number: Number of the phase; None for one without, or where another stop bounces.
        name: What happens in it.
        colour: Colour of solids and of the strip, as in #RRGGBB.
        tint: Colour behind the curves of plots, as in #RRGGBB.
    """

    start: float
    end: float
    closed: frozenset[str]
    number: int | None
    name: str
    colour: str
    tint: str


def intervals(solution: Solution) -> list[Interval]:
    """The phases of the turns that are shown.

    A phase without closed stops is the transition only if the transition stop bounces in it. While
    that one is open another stop may be left, or bounce: this has words and a colour of its own.
    In a machine that starts with no stop closed, that phase is not the transition, and is as named.
    """
    found = []
    for item in in_sight(solution, solution.phases):
        others = _elsewhere(solution, item)
        if others is None:
            number, name = item.number, f"phase {phase_name(solution.mechanism, item.closed)}"
            colour, tint = _pair(solution.mechanism, item.closed)
        else:
            number, name = None, others
            colour = tint = ELSEWHERE
        found.append(Interval(item.t_start, item.t_end, item.closed, number, name, colour, tint))
    return found


def legend(solution: Solution) -> list[Interval]:
    """The first interval of each name shown: the model's phases in its order, then others."""
    first: dict[str, Interval] = {}
    for item in intervals(solution):
        first.setdefault(item.name, item)
    order = [phase.closed for phase in solution.mechanism.phases]

    def place(item: Interval) -> int:
        return len(order) if item.colour == ELSEWHERE else _place(order, item.closed)

    return sorted(first.values(), key=place)


def _pair(mechanism: Mechanism, closed: frozenset[str]) -> tuple[str, str]:
    """Strong and pale colour of the phase with these closed stops."""
    order = [phase.closed for phase in mechanism.phases]
    place = _place(order, closed)
    return _UNNAMED if place == len(order) else _COLOURS[place % len(_COLOURS)]


def _place(order: list[frozenset[str]], closed: frozenset[str]) -> int:
    """Place of the phase with these closed stops in the model; behind all for one without name."""
    return order.index(closed) if closed in order else len(order)


def _elsewhere(solution: Solution, item: PhaseInterval) -> str | None:
    """What happens in a phase without closed stops in which the transition stop is not struck."""
    mechanism = solution.mechanism
    main = mechanism.transition_stop
    if item.closed or not main or not mechanism.phase(mechanism.initial_phase).closed:
        return None
    struck = {
        stop
        for event in solution.events
        if event.kind is EventKind.COLLISION and item.t_start <= event.t < item.t_end
        for stop in event.stops
    }
    if main in struck:
        return None
    names = " and ".join(sorted(struck)) or " and ".join(
        stop.name for stop in mechanism.stops if stop.name != main
    )
    if not names:
        return None
    verb = "bounces" if struck else "is off its stop"
    return f"{main} open, {names} {verb}"
