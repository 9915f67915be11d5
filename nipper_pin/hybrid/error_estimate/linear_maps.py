"""The linear maps that carry deviations along a run, over flights and over impacts.

Those of panels are found for all parts of a machine at once. None depends on the deviations that
come in, nor do those that a flight makes itself.

Bounces that are not computed before a rest are replaced by one impulse that closes the stop where
the last computed one has left it. With the gap g that is left out, and the rates u of all
coordinates by the rate of the gap, the motion is meanwhile beside the closed one by u g and u g'.
Both are zero in the end, but with A = da/dq and B = da/dv of the closed phase they have moved it by

    dq = B u I,    dv = (A + B B) u I,    I = int g dt = w (1 - e)^2 T^2 / (6 (1 - e^3)),

w being the rate just after the last computed bounce and T the time that is left: flights at one
deceleration, 2 w / T / (1 - e), each with e times the rate of the one before.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...dynamics import System, close_velocities, impact_condition
from ...dynamics.complementarity import inverse_mass_roots
from ...dynamics.impact_laws import same_by_every_law
from ...errors import ImpactError, SingularConfigurationError
from ...mechanism import Stop
from ...tolerances.hybrid import DIFFERENCE_STEP, SMALLEST
from ...tolerances.mechanics import EPS
from ..history import Event, EventKind, Segment, once_a_source
from ..motion.panel import Panel
from .local_error import at_end, unresolved, unsure
from .saltation import impact_map, sequence_map
from .variational import flight_map, free_coordinates
from .zonotope import NOTHING_KNOWN, Part, Zonotope


class PanelMap(NamedTuple):
    """A panel of a flight, as far as it belongs to its segment.

    Attributes:
        matrix: Carries deviations to its end, shape (2 nv, 2 nv).
        made: Deviations there that its beginning and it make themselves, shape (2 nv, K).
        position: What each position is left unresolved by, shape (nv,).
    """

    matrix: FloatArray
    made: FloatArray
    position: FloatArray


class PanelMaps:
    """Maps of panels and ends of segments, each found once for all parts and copies of turns."""

    def __init__(self, system: System, events: Sequence[Event]) -> None:
        """Begin with none."""
        self.system = system
        self.events = events
        self._at: dict[float, list[Event]] = {}
        for event in events:
            self._at.setdefault(event.t, []).append(event)

    @once_a_source
    def pieces(self, segment: Segment) -> list[PanelMap]:
        """The panels of a segment with freedom."""
        pieces = segment.pieces()
        return [self._piece(segment, panel, end - begin) for panel, begin, end in pieces]

    @once_a_source
    def end(self, segment: Segment) -> Zonotope:
        """Deviations at the end of a segment, where drives determine a part."""
        return at_end(self.system, segment)

    @once_a_source
    def free(self, segment: Segment) -> NDArray[np.bool_]:
        """Whether coordinates of a segment are free, shape (nv,)."""
        phase = self.system.constraint_set(segment.closed)
        found = np.zeros(self.system.body.nv, dtype=np.bool_)
        found[free_coordinates(phase, segment.panels[0].split)] = True
        return found

    def _piece(self, segment: Segment, panel: Panel, length: float) -> PanelMap:
        system, phase = self.system, self.system.constraint_set(segment.closed)
        nv, free = system.body.nv, free_coordinates(phase, panel.split)
        try:
            carried, lifted = flight_map(system, phase, panel, length)
        except (SingularConfigurationError, np.linalg.LinAlgError):
            # A motion that a step of 1e-6 takes to a dead centre is known by no derivative.
            lifted = np.full((2 * nv, 1), NOTHING_KNOWN)
            return PanelMap(np.zeros((2 * nv, 2 * nv)), lifted, lifted[:nv, 0])
        carried = np.clip(np.nan_to_num(carried), -NOTHING_KNOWN, NOTHING_KNOWN)
        position, velocity = unresolved(system, phase, panel)
        made = lifted * np.concatenate([position[free], velocity[free]])
        # Where panels meet a gap has the round-off of its coordinate, however small it is.
        loose = EPS * np.abs(panel.q[0, free])
        if panel is segment.panels[0]:
            loose = self._at_start(segment, loose, free)
        return PanelMap(carried, np.hstack([carried[:, free] * loose, made]), position)

    def _at_start(self, segment: Segment, loose: FloatArray, free: list[int]) -> FloatArray:
        """What the free coordinates are wrong by where a segment begins, shape (free,).

        That is the round-off of closures, of stops that have just opened nothing, and the round-off
        of the coordinate in a part that the event there does not reach.
        """
        system, panel = self.system, segment.panels[0]
        events = self._at.get(segment.t_start, [])
        reached = np.full(system.body.nv, not events)
        for event in events:
            for name in event.stops:
                reached[system.members(system.mechanism.stop(name).index)] = True
        found = unsure(system, panel.split)
        # Any other gap that is zero there has been lost in the round-off of its coordinate.
        names = segment.closed.union(*((*event.stops, *event.closed_before) for event in events))
        for stop in map(system.mechanism.stop, names):
            if panel.q[0, stop.index] == stop.at:
                found[stop.index] = 0.0
        return np.where(reached[free], found[free], loose)


def left_out(system: System, rest: Event, remaining: float) -> FloatArray:
    """Deviations (dq, dv) after a rest by what is left out of its series, shape (2 nv,).

    ``remaining`` is the time from the last computed bounce to the rest [s].
    """
    stop, phase = system.mechanism.stop(rest.stops[0]), system.constraint_set(rest.closed_after)
    e_N, rate = stop.restitution, stop.rate(rest.v_before)
    q, v, u = rest.q, rest.v_after, -rest.delta / rate
    size = rate * ((1.0 - e_N) * remaining) ** 2 / (6.0 * (1.0 - e_N**3))
    # Places move along the closures, and rates stay those that belong to them.
    units = system.body.units
    aside = DIFFERENCE_STEP / max(_size(u / units), 1.0 / units[stop.index])
    moved = np.stack([q, q + aside * u])
    _, jacobians = system.body.closures(moved)
    split = system.split(jacobians[0], phase.given, (*phase.stops, *phase.yielding))
    turned = close_velocities(np.stack([v, v]), jacobians, split)[1]
    speed = DIFFERENCE_STEP * max(_size(v / units), abs(rate) / units[stop.index])
    hurried = speed / max(_size(u / units), SMALLEST)
    motion = system.shaft.driven(np.full(3, rest.t))
    a = system.accelerations(
        motion, np.stack([*moved, q]), np.stack([v, turned, v + hurried * u]), phase
    )
    by_place, by_rate = (a[1] - a[0]) / aside, (a[2] - a[0]) / hurried
    again = speed / max(_size(by_rate / units), SMALLEST)
    motion = system.shaft.driven(np.full(2, rest.t))
    a = system.accelerations(motion, np.stack([q, q]), np.stack([v, v + again * by_rate]), phase)
    by_rates = (a[1] - a[0]) / again
    return np.asarray(size * np.concatenate([by_rate, by_place + by_rates]))


def _size(vector: FloatArray) -> float:
    return float(np.abs(vector).max())


class FlightMap(NamedTuple):
    """A flight of a part with n coordinates, from one event of the run to the next.

    Attributes:
        matrix: Carries deviations to its end, shape (2 n, 2 n).
        own: Deviations there that it makes itself.
        rates: Velocities and accelerations at its start, shape (2 n,).
    """

    matrix: FloatArray
    own: Zonotope
    rates: FloatArray


class ImpactMap(NamedTuple):
    """An event with impulses, of a part with n coordinates.

    Attributes:
        matrix: Carries deviations over it, shape (2 n, 2 n).
        own: Deviations after it that it makes itself.
        pushes: Deviations of impulses by those before, shape (stops, 2 n).
        rates: Velocities and accelerations before, shape (2 n,).
        lost: Relative round-off of the largest impulse: the digits that the impact matrix loses.
        beside: Round-off of each impulse in units of ``lost``: of the largest one itself, and of
            those beside it as much in energy [N m s or N s], by name of the stop.
    """

    matrix: FloatArray
    own: Zonotope
    pushes: FloatArray
    rates: FloatArray
    lost: float
    beside: dict[str, float]


class LinearMaps:
    """Maps of flights and impacts of a part, each found once: copies of a turn share them."""

    def __init__(self, part: Part, panels: PanelMaps) -> None:
        """Begin with none."""
        self.system, self.part, self.panels = panels.system, part, panels

    def determined(self, segment: Segment) -> bool:
        """True if drives and closed stops determine the motion of the part."""
        return segment.kinematic or not self.panels.free(segment)[self.part.coordinates].any()

    @once_a_source
    def end(self, segment: Segment) -> Zonotope:
        """Deviations at the end of a segment that determines the part, and forgets those before."""
        return self.part.of(self.panels.end(segment).states)

    def left_out(self, rest: Event, remaining: float) -> Zonotope:
        """Deviations by bounces that are not computed, in a time before a rest [s]."""
        if remaining <= 0.0 or self.system.constraint_set(rest.closed_after).freedom == 0:
            return Zonotope.of(np.empty((2 * self.part.size, 0)))
        try:
            found = left_out(self.system, rest, remaining)
        except (SingularConfigurationError, np.linalg.LinAlgError):
            found = np.full(2 * self.system.body.nv, NOTHING_KNOWN)
        return self.part.of(found[:, None])

    def unresolved(self, segment: Segment, index: int) -> float:
        """What the position of a coordinate is left unresolved by on the last panel of a flight."""
        pieces = self.panels.pieces(segment)
        return float(pieces[-1].position[index]) if pieces else 0.0

    @once_a_source
    def flight(self, segment: Segment) -> FlightMap:
        """A segment of some length in which the part has freedom."""
        part, first = self.part, segment.panels[0]
        piece, *others = self.panels.pieces(segment)
        matrix, own = piece.matrix[part.square], part.of(piece.made).merged()
        for piece in others:
            carried = piece.matrix[part.square]
            with np.errstate(over="ignore", invalid="ignore"):
                matrix = np.nan_to_num(carried @ matrix)
            matrix = np.clip(matrix, -NOTHING_KNOWN, NOTHING_KNOWN)
            own = own.through(carried).joined(part.of(piece.made)).merged()
        rates = np.concatenate([first.v[0], first.a[0]])[part.rows]
        return FlightMap(matrix, own, rates)

    @once_a_source
    def impact(self, event: Event) -> ImpactMap:
        """An event with impulses at some of its stops."""
        system, part, rows = self.system, self.part, self.part.rows
        phase = system.constraint_set(event.closed_before)
        motion = system.shaft.driven(np.array([event.t]))
        a = system.accelerations(motion, event.q[None], event.v_before[None], phase)[0]
        stops = pushing(system, event)
        matrix, pushes, passed = self._law(event, stops)
        _, jacobian = system.body.closures(event.q[None])
        struck = [stop.index for stop in stops]
        lost = min(EPS * impact_condition(system, event.q, jacobian[0], struck), 1.0)
        rough = lost * np.abs(event.delta)
        if not passed:
            # The law itself determines the rates of the stops that are struck.
            rough[struck] = 0.0
        own = Zonotope.independent(np.zeros(part.size), rough[part.coordinates])
        before = np.concatenate([event.v_before, a])[rows]
        matrix = matrix[part.square]
        return ImpactMap(matrix, own, pushes[:, rows], before, lost, self._beside(event))

    def _law(self, event: Event, stops: list[Stop]) -> tuple[FloatArray, FloatArray, bool]:
        """Derivative of the law by which stops push, and whether impulses pass between them."""
        system, rest = self.system, event.kind is EventKind.REST
        size = 2 * system.body.nv
        if not stops:
            return np.eye(size), np.empty((0, size)), False
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
                found = sequence_map(system, event.q, event.v_before, contacts, stops)
            else:
                found = impact_map(system, event.q, event.v_before, stops, restitution, slopes)
        except (ImpactError, SingularConfigurationError, np.linalg.LinAlgError):
            matrix = np.full((size, size), NOTHING_KNOWN)
            return matrix, matrix[: len(stops)], passed
        return *found, passed

    def _beside(self, event: Event) -> dict[str, float]:
        """Round-off of impulses: one linear system gives all, so each has that of the largest."""
        names = list(event.P_N)
        columns = [self.system.mechanism.stop(name).index for name in names]
        sizes = inverse_mass_roots(self.system, event.q, columns)
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
