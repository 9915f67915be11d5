"""Segments of motion between two events, with one set of closed stops; states between them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import wraps
from typing import Any, NamedTuple, TypeVar, TypeVarTuple

from ..arrays import FloatArray
from ..dynamics import Driven, System
from .contact.active_set import Closed
from .contact.bounce_series import BounceSeries
from .event import Event
from .motion.panel import Panel


class State(NamedTuple):
    """State of a run between two segments.

    Attributes:
        t: Time [s].
        q: Configuration, shape (nv,).
        v: Velocity (right limit), shape (nv,).
        jacobian: Closure Jacobian, shape (m, nv).
        motion: Driven coordinates at this time, as one row.
        closed: Closed stops.
        series: Bounces that have not come to rest yet, of each stop that bounces.
    """

    t: float
    q: FloatArray
    v: FloatArray
    jacobian: FloatArray
    motion: Driven
    closed: Closed
    series: tuple[BounceSeries, ...] = ()

    @classmethod
    def at(cls, system: System, t: float, q: FloatArray, v: FloatArray, closed: Closed) -> State:
        """Return the state of closed coordinates, where nothing bounces."""
        jacobian = system.body.closures(q[None])[1][0]
        return cls(t, q, v, jacobian, system.shaft.driven_at(t), closed)


@dataclass(frozen=True, eq=False)
class Segment:
    """Motion with one set of closed stops.

    Attributes:
        t_start: Start [s].
        t_end: End [s].
        panels: Panels in order of time; the last one may reach beyond the end.
        kinematic: True if the drives determine the motion.
        source: Place in the run of the segment that this one is a copy of; its own if it is none.
    """

    t_start: float
    t_end: float
    closed: frozenset[str]
    panels: tuple[Panel, ...]
    kinematic: bool
    source: int = 0

    def shifted(self, delay: float, wound: FloatArray) -> Segment:
        """Return the same motion at a later time; arguments as :meth:`Panel.shifted`."""
        return replace(
            self,
            t_start=self.t_start + delay,
            t_end=self.t_end + delay,
            panels=tuple(panel.shifted(delay, wound) for panel in self.panels),
        )

    def pieces(self) -> Iterator[tuple[Panel, float, float]]:
        """Panels with the part of each that belongs to the segment: begin and end [s]."""
        for panel in self.panels:
            begin, end = max(panel.t, self.t_start), min(panel.t + panel.h, self.t_end)
            if end > begin:
                yield panel, begin, end

    def panel_number(self, t: float) -> int:
        """Return the place of the panel that holds time t [s]."""
        return max(bisect_right(self.panels, t, key=lambda panel: panel.t) - 1, 0)


_Item = TypeVar("_Item", Event, Segment)
_Found = TypeVar("_Found")
_Rest = TypeVarTuple("_Rest")


def once_a_source(
    find: Callable[[Any, _Item, *_Rest], _Found],
) -> Callable[[Any, _Item, *_Rest], _Found]:
    """Keep what a method finds of an event or a segment, for all copies of it."""
    name = f"{find.__name__} of sources"

    @wraps(find)
    def found(owner: Any, item: _Item, *rest: *_Rest) -> _Found:
        known: dict[tuple[object, ...], _Found] = vars(owner).setdefault(name, {})
        key = item.source, *rest
        if key not in known:
            known[key] = find(owner, item, *rest)
        return known[key]

    return found
