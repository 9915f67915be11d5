"""Freedoms along which neighbours of a motion are compared, one of each part at a time.

Parts of a machine that do not touch one another answer each for itself: a motion beside another one
in every part at once tells of all of them what one beside it in a single part tells of that.

Errors go part by part: what does not touch is not carried along, and does not count. A part has its
own deviations, from event to event of its own: those of other parts end segments of its flights and
change nothing. An event of stops of several parts is one of each of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray, Vectors
from ...dynamics import ConstraintSet, Partition, System
from ...mechanism import Stop
from ...tolerances.hybrid import DIFFERENCE_STEP, SMALLEST
from ..event import Event
from .zonotope import Zonotope


def free_coordinates(phase: ConstraintSet, split: Partition) -> list[int]:
    """Independent coordinates that forces move: one for each freedom of a phase."""
    return [k for k in split.independent if phase.moving[k]]


@dataclass(frozen=True, eq=False)
class Freedoms:
    """Coordinates that are moved each for itself, those of different parts at once.

    Attributes:
        units: What each coordinate is measured in, shape (nv,) [rad or m].
        columns: The coordinates, F of them.
        part: Place of the part of each in ``members``.
        members: Coordinates of every part.
    """

    units: FloatArray
    columns: tuple[int, ...]
    part: tuple[int, ...]
    members: tuple[NDArray[np.intp], ...]

    @classmethod
    def of(cls, system: System, columns: Sequence[int]) -> Freedoms:
        """Coordinates of any parts.

        Args:
            columns: The coordinates; no held shaft is among them.
        """
        numbers = system.parts[list(columns)].tolist()
        # The number of a part is one of its coordinates.
        found = list(dict.fromkeys(numbers)) or [0]
        members = [system.members(number) for number in found]
        part = tuple(found.index(number) for number in numbers)
        return cls(system.body.units, tuple(columns), part, tuple(members))

    @classmethod
    def of_one(cls, system: System, columns: Sequence[int], members: NDArray[np.intp]) -> Freedoms:
        """Coordinates of one part, whose members are, held shafts that move it among them."""
        return cls(system.body.units, tuple(columns), (0,) * len(columns), (members,))

    @classmethod
    def struck(cls, system: System, split: Partition, stops: Sequence[Stop]) -> Freedoms:
        """Independent coordinates of the part of stops, of which there is one at least."""
        members = system.members(stops[0].index)
        return cls.of_one(system, [k for k in split.independent if k in members], members)

    @cached_property
    def direction(self) -> tuple[int, ...]:
        """Which one of its part each coordinate is: those of one number are moved at once."""
        return tuple(self.part[:place].count(part) for place, part in enumerate(self.part))

    @cached_property
    def directions(self) -> FloatArray:
        """The coordinates that are moved at once, by ones, shape (C, nv)."""
        found = np.zeros((max(self.direction, default=-1) + 1, len(self.units)))
        found[list(self.direction), list(self.columns)] = 1.0
        return found

    @cached_property
    def own(self) -> NDArray[np.bool_]:
        """True where a coordinate is of the part of a freedom, shape (nv, F)."""
        found = np.zeros((len(self.units), len(self.members)), dtype=np.bool_)
        for place, members in enumerate(self.members):
            found[members, place] = True
        return found[:, list(self.part)]

    def alike(self) -> Iterator[tuple[NDArray[np.intp], NDArray[np.intp]]]:
        """Parts with as many freedoms as one another.

        Yields:
            Their places, P of them; and those of their freedoms, shape (P, f).
        """
        places: list[list[int]] = [[] for _ in self.members]
        for place, part in enumerate(self.part):
            places[part].append(place)
        for count in sorted({len(own) for own in places} - {0}):
            chosen = [part for part, own in enumerate(places) if len(own) == count]
            yield np.array(chosen), np.array([places[part] for part in chosen])

    def steps(self, tangents: FloatArray) -> FloatArray:
        """Steps of difference quotients along each direction in each part, shape (C, parts).

        Args:
            tangents: Derivatives of all coordinates along the directions, shape (C, N, nv).
        """
        sizes = self.largest(np.abs(tangents / self.units).max(axis=1, initial=0.0))
        most = np.maximum(sizes, self.largest(self.directions / self.units))
        # Parts of fewer freedoms than others do not move in the last directions.
        return np.asarray(DIFFERENCE_STEP / np.where(most > 0.0, most, 1.0))

    def fastest(self, v: Vectors) -> FloatArray:
        """Largest rate of each part in units of its coordinate [1/s], never zero, (parts,)."""
        return np.maximum(self.largest(np.abs(v / self.units).max(axis=0)), SMALLEST)

    def largest(self, values: FloatArray) -> FloatArray:
        """Largest value in each part, shape (..., parts), of one for each coordinate, (..., nv)."""
        ends = np.cumsum([0, *(len(own) for own in self.members[:-1])])
        found: FloatArray = np.maximum.reduceat(
            values[..., np.concatenate(self.members)], ends, axis=-1
        )
        return found

    def spread(self, values: FloatArray) -> FloatArray:
        """Values of parts at each of their coordinates, shape (C, 1, nv), from (C, parts)."""
        found = np.zeros((len(values), 1, len(self.units)))
        for place, members in enumerate(self.members):
            found[:, 0, members] = values[:, place, None]
        return found


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

    def of(self, states: FloatArray) -> Zonotope:
        """Those of deviations of the whole machine that are of this part, from (2 nv, K)."""
        return Zonotope.of(states[self.rows])

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
