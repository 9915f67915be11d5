"""Errors part by part: what does not touch is not carried along, and does not count.

A part has its own deviations, from event to event of its own: those of other parts end segments of
its flights and change nothing. An event of stops of several parts is one of each of them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics import System
from ..event import Event
from .zonotope import Deviations


@dataclass(frozen=True, eq=False)
class Part:
    """A part of a machine with stops.

    Attributes:
        coordinates: Its coordinates and those of held shafts that move it, n of them, in order.
        rows: Where they and their rates are in a state (q, v), shape (2 n,).
        square: The same in a matrix of states by states.
        stops: Names of its stops.
    """

    coordinates: NDArray[np.intp]
    rows: NDArray[np.intp]
    square: tuple[NDArray[np.intp], ...]
    stops: frozenset[str]

    @property
    def size(self) -> int:
        """Number of its coordinates."""
        return len(self.coordinates)

    def place(self, index: int) -> int:
        """Place of a coordinate of the machine among those of the part."""
        return int(np.searchsorted(self.coordinates, index))

    def of(self, states: FloatArray) -> Deviations:
        """Those of deviations of the whole machine that are of this part, from (2 nv, K)."""
        return Deviations.of(states[self.rows])

    def event(self, event: Event) -> Event:
        """What an event is for this part."""
        if self.stops.issuperset((*event.stops, *event.P_N)):
            return event
        impulses = {name: P for name, P in event.P_N.items() if name in self.stops}
        stops = tuple(name for name in event.stops if name in self.stops)
        return replace(event, stops=stops, P_N=impulses)


def part_of(system: System, stop: str) -> Part:
    """The part of a stop."""
    coordinates = system.members(system.mechanism.stop(stop).index)
    rows = np.concatenate([coordinates, system.body.nv + coordinates])
    return Part(coordinates, rows, np.ix_(rows, rows), system.coupled([stop]))


def parts_of(system: System) -> Iterator[Part]:
    """The parts of a machine that have stops."""
    for first, *_ in system.apart(system.mechanism.stops):
        yield part_of(system, first.name)
