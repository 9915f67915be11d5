"""Deviations of a computed motion from the true one: a set that linear maps carry along.

Errors come from many independent sources, each of a size that is known and of a sign that is not.
So the deviation (dq, dv) is one of a zonotope, the sum of columns of which each counts with a
factor between -1 and 1. Maps act on the columns with their signs; only where an error is stated are
their sizes added. Small columns are merged along the principal directions of their sum, which makes
the set a little larger and never smaller.

Errors go part by part: what does not touch is not carried along, and does not count. A part has its
own deviations, from event to event of its own: those of other parts end segments of its flights and
change nothing. An event of stops of several parts is one of each of them.

Source: A.-K. Kopetzki, B. Schuermann, M. Althoff, Methods for Order Reduction of Zonotopes, IEEE
Conference on Decision and Control 2017.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics import System
from ...tolerances.hybrid import NEGLIGIBLE_DEVIATION
from ..history import Event

# Columns for each row before half of them are merged: every merging makes the set a little larger,
# and a chain of twenty hinges brings two columns a row with every panel.
_ORDER = 16
NOTHING_KNOWN = 1e100
"""Beyond any motion: a deviation that has grown to this says nothing, and may not overflow."""


@dataclass(frozen=True, eq=False)
class Zonotope:
    """Deviations of positions and velocities, at the time of an event of their own.

    Attributes:
        states: (dq, dv), one column a source, shape (2 nv, K).
        late: By how much each source makes the last event late [s], shape (K,); zero in flight,
            where states are compared at one time.
        before: By how much each makes the event before that late [s], shape (K,).
    """

    states: FloatArray
    late: FloatArray
    before: FloatArray

    @classmethod
    def of(cls, states: FloatArray) -> Zonotope:
        """Sources of deviations at one time, shape (2 nv, K); those that are nothing are none."""
        counting = states[:, np.abs(states).any(axis=0)]
        return cls(counting, *np.zeros((2, counting.shape[1])))

    @classmethod
    def independent(cls, q: FloatArray, v: FloatArray) -> Zonotope:
        """Deviations of every position and every velocity of their own, each of shape (nv,)."""
        return cls.of(np.diag(np.concatenate([q, v])))

    def through(self, matrix: FloatArray) -> Zonotope:
        """Return them after a linear map of the states."""
        with np.errstate(over="ignore", invalid="ignore"):
            states = matrix @ self.states
            if not np.vdot(states, states) < NOTHING_KNOWN**2:
                states = np.nan_to_num(states, nan=NOTHING_KNOWN)
                states = np.clip(states, -NOTHING_KNOWN, NOTHING_KNOWN)
        return replace(self, states=states)

    def joined(self, other: Zonotope) -> Zonotope:
        """Return the sum of two sets whose sources are independent."""
        return Zonotope(
            np.concatenate([self.states, other.states], axis=1),
            np.concatenate([self.late, other.late]),
            np.concatenate([self.before, other.before]),
        )

    def departed(self, rates: FloatArray) -> Zonotope:
        """Return them at one time, after an event that each source makes late.

        Rates are velocities and accelerations there, shape (2 nv,).
        """
        return replace(self.later(-self.late, rates), before=self.late)

    def later(self, late: FloatArray, rates: FloatArray) -> Zonotope:
        """Return them later by so much [s] for each source, (K,); rates as of :meth:`departed`."""
        states = self.states + np.outer(rates, late)
        return replace(self, states=states, late=self.late + late)

    def size(self, row: int) -> float:
        """Largest deviation of one position or velocity."""
        return float(np.abs(self.states[row]).sum())

    def within(self, row: int, most: float) -> Zonotope:
        """Return them with this position or velocity deviating by no more."""
        size = self.size(row)
        if size <= most:
            return self
        states = self.states.copy()
        states[row] *= most / size
        return replace(self, states=states)

    def merged(self) -> Zonotope:
        """Return a set that contains this one and has few columns."""
        columns = np.vstack([self.states, self.late, self.before])
        rows, count = columns.shape
        if count <= _ORDER * rows:
            return self
        sizes = np.abs(columns).sum(axis=1, keepdims=True)
        scaled = columns / np.where(sizes > 0.0, sizes, 1.0)
        order = np.argsort(-np.abs(scaled).sum(axis=0), kind="stable")
        most = _ORDER * rows // 2
        kept, small = columns[:, order[:most]], scaled[:, order[most:]]
        directions, lengths, _ = np.linalg.svd(small, full_matrices=False)
        # The closures leave only some: the others are round-off.
        directions = directions[:, lengths > NEGLIGIBLE_DEVIATION * lengths[0]]
        box = directions * np.abs(directions.T @ small).sum(axis=1)
        columns = np.hstack([kept, box * sizes])
        return Zonotope(columns[:-2], columns[-2], columns[-1])


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
