"""The linear maps that carry deviations along one run: over panels and over impacts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics.impact import impact_condition
from ..dynamics.system import ConstraintSet, System
from ..errors import SingularConfigurationError
from ..mechanism import Stop
from .deviations import NOTHING_KNOWN
from .event import Event, EventKind
from .panel import Panel
from .propagation import flight_map, free_coordinates
from .saltation import impact_map
from .unresolved import unresolved

_EPS = float(np.finfo(float).eps)


class FlightMap(NamedTuple):
    """A panel of a flight.

    Attributes:
        matrix: Carries deviations to its end, shape (2 nv, 2 nv).
        own: Deviations there that it makes itself, one column each, shape (2 nv, 2 f).
        position: What each position is left unresolved by, shape (nv,).
    """

    matrix: FloatArray
    own: FloatArray
    position: FloatArray


class ImpactMap(NamedTuple):
    """An event with impulses.

    Attributes:
        matrix: Carries deviations over it, shape (2 nv, 2 nv).
        pushes: Deviations of impulses by those before, shape (stops, 2 nv).
        a: Acceleration before, shape (nv,).
        lost: Relative round-off: the digits that the impact matrix loses.
    """

    matrix: FloatArray
    pushes: FloatArray
    a: FloatArray
    lost: float


class LinearMaps:
    """Maps of panels and impacts, each found once: copies of a turn share arrays, and maps.

    Args:
        system: The system.
    """

    def __init__(self, system: System) -> None:
        """Begin with none."""
        self._system = system
        self._flights: dict[int, FlightMap] = {}
        self._impacts: dict[int, ImpactMap] = {}

    def flight(self, rows: ConstraintSet, panel: Panel, length: float) -> FlightMap:
        """A panel of which this length belongs to a segment [s]."""
        if id(panel.q) not in self._flights:
            self._flights[id(panel.q)] = self._flight(rows, panel, length)
        return self._flights[id(panel.q)]

    def position(self, panel: Panel) -> FloatArray:
        """What each position of a flight panel is left unresolved by, shape (nv,)."""
        known = self._flights.get(id(panel.q))
        # A segment that ends where a panel starts has had no use for it.
        return np.zeros(self._system.body.nv) if known is None else known.position

    def impact(self, event: Event) -> ImpactMap:
        """An event with impulses at some of its stops."""
        if id(event.delta) not in self._impacts:
            self._impacts[id(event.delta)] = self._impact(event)
        return self._impacts[id(event.delta)]

    def _flight(self, rows: ConstraintSet, panel: Panel, length: float) -> FlightMap:
        free = free_coordinates(rows, panel.split)
        try:
            matrix, lifted = flight_map(self._system, rows, panel, length)
        except (SingularConfigurationError, np.linalg.LinAlgError):
            # A motion that a step of 1e-6 takes to a dead centre is known by no derivative.
            nv = self._system.body.nv
            unknown = np.full((2 * nv, 1), NOTHING_KNOWN)
            return FlightMap(np.zeros((2 * nv, 2 * nv)), unknown, unknown[:nv, 0])
        position, velocity = unresolved(self._system, rows, panel)
        own = lifted * np.concatenate([position[free], velocity[free]])
        return FlightMap(matrix, own, position)

    def _impact(self, event: Event) -> ImpactMap:
        system = self._system
        rows = system.constraint_set(event.closed_before)
        motion = system.shaft.driven(np.array([event.t]))
        a = system.accelerations(motion, event.q[None], event.v_before[None], rows)[0]
        stops = pushing(system, event)
        rest = event.kind is EventKind.REST
        restitution = [0.0 if rest else stop.restitution for stop in stops]
        try:
            matrix, pushes = impact_map(system, event.q, event.v_before, stops, restitution)
        except (SingularConfigurationError, np.linalg.LinAlgError):
            size = 2 * system.body.nv
            matrix = np.full((size, size), NOTHING_KNOWN)
            pushes = matrix[: len(stops)]
        _, jacobian = system.body.closures(event.q[None])
        condition = impact_condition(system, event.q, jacobian[0], [stop.index for stop in stops])
        return ImpactMap(matrix, pushes, a, min(_EPS * condition, 1.0))


def pushing(system: System, event: Event) -> list[Stop]:
    """The stops that give an impulse, those that an event concerns first; negative at a rest."""
    names = [*event.stops, *(name for name in event.P_N if name not in event.stops)]
    return [system.mechanism.stop(name) for name in names if event.P_N.get(name, 0.0) != 0.0]
