"""The linear maps that carry deviations along one run, over flights and over impacts.

Neither depends on the deviations that come in, nor do those that a flight makes itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray
from ...dynamics.moving_mass import impact_condition, impulse_sizes
from ...dynamics.strike import same_by_every_law
from ...dynamics.system import System
from ...errors import ImpactError, SingularConfigurationError
from ...mechanism import Stop
from ...tolerances.mechanics import EPS
from ..event import Event, EventKind
from ..segment import Segment
from .determined import at_end
from .local_error import unresolved, unsure
from .saltation import impact_map
from .sequence_map import sequence_map
from .truncated_bounces import left_out
from .variational import flight_map, free_coordinates
from .zonotope import NOTHING_KNOWN, Deviations


class FlightMap(NamedTuple):
    """A flight, from one event to the next.

    Attributes:
        matrix: Carries deviations to its end, shape (2 nv, 2 nv).
        own: Deviations there that it makes itself.
        rates: Velocities and accelerations at its start, shape (2 nv,).
        position: What each position is left unresolved by on its last panel, shape (nv,).
    """

    matrix: FloatArray
    own: Deviations
    rates: FloatArray
    position: FloatArray


class ImpactMap(NamedTuple):
    """An event with impulses.

    Attributes:
        matrix: Carries deviations over it, shape (2 nv, 2 nv).
        own: Deviations after it that it makes itself.
        pushes: Deviations of impulses by those before, shape (stops, 2 nv).
        rates: Velocities and accelerations before, shape (2 nv,).
        lost: Relative round-off of the largest impulse: the digits that the impact matrix loses.
        beside: Round-off of each impulse in units of ``lost``: of the largest one itself, and of
            those beside it as much in energy [N m s or N s], by name of the stop.
    """

    matrix: FloatArray
    own: Deviations
    pushes: FloatArray
    rates: FloatArray
    lost: float
    beside: dict[str, float]


class LinearMaps:
    """Maps of flights and impacts, each found once: copies of a turn share arrays, and maps.

    Args:
        system: The system.
        events: Events of the run.
    """

    def __init__(self, system: System, events: Sequence[Event]) -> None:
        """Begin with none."""
        self._system = system
        self._touched: dict[float, set[str]] = {}
        for event in events:
            touched = self._touched.setdefault(event.t, set())
            touched.update(event.stops, event.closed_before, event.P_N)
        self._flights: dict[int, FlightMap] = {}
        self._ends: dict[int, Deviations] = {}
        self._impacts: dict[int, ImpactMap] = {}

    def flight(self, segment: Segment) -> FlightMap:
        """A segment with freedom, and of some length."""
        if segment.source not in self._flights:
            self._flights[segment.source] = self._flight(segment)
        return self._flights[segment.source]

    def end(self, segment: Segment) -> Deviations:
        """Deviations at the end of a segment without freedom, which forgets those before."""
        if segment.source not in self._ends:
            self._ends[segment.source] = at_end(self._system, segment)
        return self._ends[segment.source]

    def impact(self, event: Event) -> ImpactMap:
        """An event with impulses at some of its stops."""
        if event.source not in self._impacts:
            self._impacts[event.source] = self._impact(event)
        return self._impacts[event.source]

    def left_out(self, rest: Event, remaining: float) -> Deviations:
        """Deviations by bounces that are not computed, in a time before a rest [s]."""
        if remaining <= 0.0 or self._system.constraint_set(rest.closed_after).freedom == 0:
            return Deviations.of(np.empty((2 * self._system.body.nv, 0)))
        try:
            found = left_out(self._system, rest, remaining)
        except (SingularConfigurationError, np.linalg.LinAlgError):
            found = np.full(2 * self._system.body.nv, NOTHING_KNOWN)
        return Deviations.of(found[:, None])

    def _flight(self, segment: Segment) -> FlightMap:
        system, phase = self._system, self._system.constraint_set(segment.closed)
        first, nv = segment.panels[0], system.body.nv
        touching = self._touching(segment)
        matrix, own = np.eye(2 * nv), Deviations.of(np.empty((2 * nv, 0)))
        position = np.zeros(nv)
        for panel, begin, end in segment.pieces():
            free = free_coordinates(phase, panel.split)
            loose = np.zeros(nv)
            # Where panels meet a gap has the round-off of its coordinate, however small it is; at
            # the start, where it has not just opened, that of the closures.
            loose[free] = EPS * np.abs(panel.q[0, free])
            if panel is first:
                loose[free] = unsure(system, panel.split)[free]
                loose[touching] = 0.0
            own = own.joined(Deviations.independent(loose, np.zeros(nv)))
            try:
                carried, lifted = flight_map(system, phase, panel, end - begin)
            except (SingularConfigurationError, np.linalg.LinAlgError):
                # A motion that a step of 1e-6 takes to a dead centre is known by no derivative.
                carried, lifted = np.zeros((2 * nv, 2 * nv)), np.full((2 * nv, 1), NOTHING_KNOWN)
                made, position = lifted, lifted[:nv, 0]
            else:
                position, velocity = unresolved(system, phase, panel)
                made = lifted * np.concatenate([position[free], velocity[free]])
            with np.errstate(over="ignore", invalid="ignore"):
                matrix = np.nan_to_num(carried @ matrix)
            own = own.through(carried).joined(Deviations.of(made)).merged()
        rates = np.concatenate([first.v[0], first.a[0]])
        return FlightMap(np.clip(matrix, -NOTHING_KNOWN, NOTHING_KNOWN), own, rates, position)

    def _touching(self, segment: Segment) -> list[int]:
        """Coordinates of the stops whose gap is exactly zero where a segment begins.

        Any other gap that is zero there has been lost in the round-off of its coordinate.
        """
        names = self._touched.get(segment.t_start, set()) | segment.closed
        place = segment.panels[0].q[0]
        stops = (self._system.mechanism.stop(name) for name in names)
        return [stop.index for stop in stops if place[stop.index] == stop.at]

    def _impact(self, event: Event) -> ImpactMap:
        system = self._system
        phase = system.constraint_set(event.closed_before)
        motion = system.shaft.driven(np.array([event.t]))
        a = system.accelerations(motion, event.q[None], event.v_before[None], phase)[0]
        stops = pushing(system, event)
        rest = event.kind is EventKind.REST
        rates = [stop.rate(event.v_before) for stop in stops]
        restitution = [
            0.0 if rest else stop.coefficient(rate) for stop, rate in zip(stops, rates, strict=True)
        ]
        slopes = None
        if not rest and any(stop.law is not None for stop in stops):
            slopes = [stop.rebound_slope(rate) for stop, rate in zip(stops, rates, strict=True)]
        contacts = [system.mechanism.stop(name) for name in event.P_N]
        passed = (
            not rest
            and system.mechanism.simultaneous == "sequential"
            and not same_by_every_law(event.v_before, event.v_after, contacts, event.P_N)
        )
        try:
            if passed:
                matrix, pushes = sequence_map(system, event.q, event.v_before, contacts, stops)
            else:
                matrix, pushes = impact_map(
                    system, event.q, event.v_before, stops, restitution, slopes
                )
        except (ImpactError, SingularConfigurationError, np.linalg.LinAlgError):
            size = 2 * system.body.nv
            matrix = np.full((size, size), NOTHING_KNOWN)
            pushes = matrix[: len(stops)]
        _, jacobian = system.body.closures(event.q[None])
        struck = [stop.index for stop in stops]
        lost = min(EPS * impact_condition(system, event.q, jacobian[0], struck), 1.0)
        rough = lost * np.abs(event.delta)
        if not passed:
            # The law itself determines the rates of the stops that are struck.
            rough[struck] = 0.0
        own = Deviations.independent(np.zeros_like(rough), rough)
        motion_before = np.concatenate([event.v_before, a])
        return ImpactMap(matrix, own, pushes, motion_before, lost, self._beside(event))

    def _beside(self, event: Event) -> dict[str, float]:
        """Round-off of impulses: one linear system gives all, so each has that of the largest."""
        names = list(event.P_N)
        columns = [self._system.mechanism.stop(name).index for name in names]
        try:
            sizes = impulse_sizes(self._system, event.q, columns)
        except np.linalg.LinAlgError:
            return dict.fromkeys(names, NOTHING_KNOWN)
        pushed = np.abs(np.array(list(event.P_N.values())))
        energies = pushed * sizes
        largest = float(energies.max(initial=0.0))
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            others = np.nan_to_num(largest / sizes, nan=0.0, posinf=NOTHING_KNOWN)
        # Of the largest one to the last bit.
        found = np.where(energies == largest, pushed, others)
        return dict(zip(names, found.tolist(), strict=True))


def pushing(system: System, event: Event) -> list[Stop]:
    """The stops that give an impulse, those that an event concerns first; negative at a rest."""
    names = [*event.stops, *(name for name in event.P_N if name not in event.stops)]
    return [system.mechanism.stop(name) for name in names if event.P_N.get(name, 0.0) != 0.0]
