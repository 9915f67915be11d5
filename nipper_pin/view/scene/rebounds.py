"""Rebounds that are drawn larger: flights of the transition stop from one collision to the next."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...arrays import FloatArray
from ...hybrid import EventKind, Solution


@dataclass(frozen=True)
class Flight:
    """A rebound, or the last ones of a series together.

    Attributes:
        begin: Time at which it begins [s].
        end: Time at which the stop is closed again [s].
        highest: Largest gap [rad or m].
    """

    begin: float
    end: float
    highest: float


def rebound_flights(solution: Solution) -> list[Flight]:
    """Flights between a collision of the transition stop and its next one, or its rest.

    The closing before the first collision and the opening after the last are none.
    """
    stop = solution.mechanism.transition_stop
    closes = [
        event
        for event in solution.events
        if stop in event.stops and event.kind in (EventKind.COLLISION, EventKind.REST)
    ]
    own = (hit for hit in solution.collisions if hit.stop == stop)
    heights = {hit.event.number: hit.rebound_amplitude or 0.0 for hit in own}
    return [
        Flight(first.t, second.t, heights.get(first.number, 0.0))
        for first, second in pairwise(closes)
        if first.kind is EventKind.COLLISION
    ]


def highest_drawn(solution: Solution, t: FloatArray, gap: FloatArray) -> float:
    """Largest gap of a rebound in the frames of a film, in the unit of the gaps.

    Args:
        t: Times of the frames [s], shape (K,).
        gap: Gaps of the transition stop there, shape (K,).
    """
    flights = rebound_flights(solution)
    found = (gap[(t >= item.begin) & (t <= item.end)].max(initial=0.0) for item in flights)
    return float(max(found, default=0.0))


def factors(
    solution: Solution, t: FloatArray, gap: FloatArray, factor: float, limit: float
) -> FloatArray:
    """Factor on the gap of the transition stop in every frame.

    A rebound has one factor from its begin to its end, at both of which the gap is zero, so the
    drawing does not jump. A rebound that would be drawn beyond the limit has a smaller factor; all
    else is drawn as it is.

    Args:
        t: Times of the frames [s], shape (K,).
        gap: Gaps of the transition stop there, shape (K,) [rad or m].
        factor: Factor on rebounds [-].
        limit: Largest gap of a rebound that is drawn [rad or m].

    Returns:
        Shape (K,), at least 1.
    """
    found = np.ones(len(t))
    for flight in rebound_flights(solution):
        inside = (t >= flight.begin) & (t <= flight.end)
        highest = max(flight.highest, float(gap[inside].max(initial=0.0)))
        most = limit / highest if highest > 0.0 else factor
        found[inside] = max(1.0, min(factor, most))
    return found
