"""Phases of a film in words and colours, told apart by what bounces in them."""

from __future__ import annotations

from dataclasses import dataclass

from ...hybrid.event import EventKind
from ...hybrid.result.solution import Solution
from ...hybrid.result.tables import PhaseInterval
from ..reading import phase_name, shown_phases
from .colours import ELSEWHERE, phase_colour


@dataclass(frozen=True)
class Interval:
    """A phase as it is shown.

    Attributes:
        start: Its begin [s].
        name: What happens in it.
        colour: Colour, as in #RRGGBB.
    """

    start: float
    name: str
    colour: str


def intervals(solution: Solution) -> list[Interval]:
    """The phases of the turns that are shown.

    A phase without closed stops is the transition only if the transition stop bounces in it. While
    that one is open another stop may be left, or bounce: this has a colour of its own.

    Args:
        solution: The solution.
    """
    mechanism = solution.mechanism
    found = []
    for item in shown_phases(solution):
        name, colour = phase_name(mechanism, item.closed), phase_colour(mechanism, item.closed)
        others = _elsewhere(solution, item)
        if others is not None:
            name, colour = others, ELSEWHERE
        else:
            name = f"phase {name}"
        found.append(Interval(item.t_start, name, colour))
    return found


def _elsewhere(solution: Solution, item: PhaseInterval) -> str | None:
    """What happens in a phase without closed stops in which the transition stop is not struck."""
    main = solution.mechanism.transition_stop
    if item.closed or not main:
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
        stop.name for stop in solution.mechanism.stops if stop.name != main
    )
    verb = "bounces" if struck else "is off its stop"
    return f"{main} open, {names} {verb}"
