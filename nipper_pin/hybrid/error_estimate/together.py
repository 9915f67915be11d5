"""Errors of stops that are struck in the event of another one.

A neighbouring motion strikes each of them at a time of its own: by dt after the first one, until
when it goes on without the change of velocity u that this stop makes, with the accelerations from
before. At the time of the first one it deviates by -u dt, and what u moves has struck with other
rates. Parts that do not touch are followed apart (``freedoms.py``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...dynamics import System
from ...tolerances.hybrid import NEGLIGIBLE_DEVIATION
from ..event import Event
from ..segment import Segment
from .freedoms import Part
from .saltation import pushed_by
from .zonotope import Zonotope


class StrikeError(NamedTuple):
    """Estimated errors of one stop that an event strikes.

    Attributes:
        time: Of the time at which it is struck [s].
        relative: Of its rates and its impulse [-].
        since: Of the time since the event before, of the first stops of its part [s].
    """

    time: float
    relative: float
    since: float


class Beside(NamedTuple):
    """A stop that is struck in the event of another one.

    Attributes:
        late: By how much later than the first one each source has it struck [s], shape (K,).
        moved: What its impulse adds to the velocities of the part, shape (n,).
        along: True where it does, shape (n,).
        time: Error of the time at which it is struck [s].
        relative: Relative error of its rates [-].
    """

    name: str
    late: FloatArray
    moved: FloatArray
    along: FloatArray
    time: float
    relative: float


def still_apart(
    system: System, part: Part, event: Event, segment: Segment | None, found: Zonotope
) -> Zonotope:
    """Add what the gaps of stops that are struck together were at the time of their event.

    Within round-off of one time they are closed at that of the earliest.

    Args:
        event: The event, with the stops of all parts.
        segment: The motion to it; None if a run begins with it.
        found: Deviations of the part before it.
    """
    struck = event.struck(system.mechanism)
    if len(struck) == 1 or segment is None or segment.t_end <= segment.t_start:
        return found
    q, _ = segment.panels[-1].interpolate_at(event.t)
    gaps = np.zeros(len(q))
    for stop in struck:
        gaps[stop.index] = stop.gap(q)
    gaps = gaps[part.coordinates]
    return found.joined(Zonotope.independent(gaps, np.zeros_like(gaps)))


def beside(
    system: System, part: Part, event: Event, a: FloatArray, before: Zonotope
) -> tuple[Zonotope, list[Beside]]:
    """Deviations where stops are struck in the event of another one.

    Args:
        a: Accelerations of the part before it, shape (n,).
        before: Deviations at the times at which the first stop is struck.

    Returns:
        The deviations, of each part when it is struck itself, and the stops.
    """
    states = before.states.copy()
    stops: list[Beside] = []
    for stop in event.struck(system.mechanism)[1:]:
        rate, place = float(event.v_before[stop.index]), part.place(stop.index)
        late = -before.states[place] / rate
        moved = pushed_by(system, event.q, stop, event.P_N[stop.name])[part.coordinates]
        size = np.abs(moved)
        along = size > NEGLIGIBLE_DEVIATION * size.max()
        states[part.size :][along] += np.outer(a[along], late)
        time = float(np.abs(before.late + late).sum())
        relative = float(np.abs(states[part.size + place]).sum()) / abs(rate)
        stops.append(Beside(stop.name, late, moved, along, time, relative))
    return replace(before, states=states), stops


def after_all(
    system: System, part: Part, event: Event, stops: list[Beside], after: Zonotope
) -> Zonotope:
    """Deviations after an event, back at the times at which its first stop is struck.

    Args:
        stops: The stops that it strikes beside that one.
        after: Deviations after the impacts, of each part when it is struck itself.
    """
    if not stops:
        return after
    phase, motion = system.constraint_set(event.closed_after), system.shaft.driven_at(event.t)
    a = system.accelerations(motion, event.q[None], event.v_after[None], phase)
    a, states, n = a[0, part.coordinates], after.states.copy(), part.size
    for stop in stops:
        states[:n] -= np.outer(stop.moved, stop.late)
        states[n:][stop.along] -= np.outer(a[stop.along], stop.late)
    return replace(after, states=states)


def stated(
    first: StrikeError, stops: list[Beside], event: Event, impulses: Mapping[str, float]
) -> dict[str, StrikeError]:
    """Errors of each stop that an event strikes, by name; nothing if it strikes one alone.

    Args:
        first: Errors of its first stop.
        impulses: Errors of its impulses, by stop.
    """
    found = {event.stops[0]: first} if stops else {}
    for stop in stops:
        size = abs(event.P_N[stop.name])
        relative = stop.relative + (impulses[stop.name] / size if size > 0.0 else 0.0)
        found[stop.name] = StrikeError(stop.time, min(relative, 1.0), first.since)
    return found
