"""Estimated errors of event times and impulses, from what a run has left unresolved.

A flight of length T that leaves a stop at the rate w ends with a gap error eps and a rate error
eta of its own, and finds its end to an error delta = eps/|w-| plus the round-off of time. The next
collision then is off by

    dt' = dt + T dw/w + delta,      dw'/w' = dw/w + (eta + |a| delta)/|w-|,

since time and final rate of a ballistic flight are proportional to w. Flights with one freedom are
followed more closely: the fundamental matrix of their variational equation (``propagation.py``)
carries an error of the rate, and a start that is late by dt, to their end. Elsewhere a stop that
arrives slower than it moved before is taken to arrive later by as much more.

eps and eta come from what the dynamics say between the nodes, where the interpolant is wrong by the
Chebyshev coefficients that it lacks, from what one more sweep would change and from what the
round-off of a state does to its acceleration, more than round-off where masses differ much. In a
phase without freedom the past is forgotten: only the round-off of its closures and of time is left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from ..arrays import FloatArray
from ..dynamics.assembly import inverted
from ..dynamics.impact import impact_condition
from ..dynamics.multipliers import multipliers
from ..dynamics.system import ConstraintSet, System
from ..mechanism import Stop
from .collocation import evaluate, nodes
from .event import Event, EventKind
from .panel import NEARBY, Panel, defect, forces_at, nearby
from .propagation import fundamental_matrix
from .segment import Segment

_EPS = float(np.finfo(float).eps)
# True errors were up to 4.6 times the bare estimate, over ten runs at six tolerances; with masses
# that differ by 1e8 up to 11 times.
_SAFETY = 8.0
# With several freedoms, elastic drive trains above all, what one leaves unresolved disturbs the
# others in later flights: up to 3.5 times the estimate was seen.
_COUPLED = 4.0
# Round-off of a polynomial, in units of that of its largest term.
_OPERATIONS = 4.0
# Part of a panel over which the slope of a stop force is taken.
_SLOPE_STEP = 1e-3


@dataclass(frozen=True)
class EventError:
    """Estimated errors of an event.

    Attributes:
        time: Of its time [s].
        impulse: Of its impulse and rates, relative [-].
    """

    time: float
    impulse: float


@dataclass(frozen=True)
class _Known:
    """What has been found of panels and flights, by their arrays: copies share theirs."""

    left_over: dict[tuple[int, int], tuple[float, float]] = field(default_factory=dict)
    matrices: dict[tuple[int, int], tuple[FloatArray, FloatArray] | None] = field(
        default_factory=dict
    )
    impacts: dict[int, float] = field(default_factory=dict)


def event_errors(
    system: System, segments: Sequence[Segment], events: Sequence[Event]
) -> tuple[EventError, ...]:
    """Estimate the errors of all events, in their order.

    Args:
        system: The system.
        segments: Segments in order of time.
        events: Events in order of time.
    """
    found: list[EventError] = []
    error = EventError(0.0, 16.0 * _EPS)
    known = _Known()
    place, struck = 0, None
    for event in events:
        stop = system.mechanism.stop(event.stops[0])
        while place < len(segments) and segments[place].t_end <= event.t:
            error = _carried(system, segments[place], stop, struck, error, known)
            place += 1
        # A rest lies beyond the end of the motion: what is left of its series has the error of its
        # rate.
        beyond = event.t - segments[place - 1].t_end if place else 0.0
        left = max(beyond, 0.0) * error.impulse + event.series_error
        if event.kind is EventKind.RELEASE and place:
            # What follows starts with a force of zero, wherever it starts: nothing is carried on.
            left = _release(system, segments[place - 1], stop.index)
        struck = stop if event.kind is EventKind.COLLISION else None
        if struck is not None:
            error = replace(error, impulse=min(error.impulse + _impact(system, event, known), 1.0))
        found.append(replace(error, time=error.time + left))
    return tuple(found)


def _carried(
    system: System,
    segment: Segment,
    stop: Stop,
    struck: Stop | None,
    before: EventError,
    known: _Known,
) -> EventError:
    """Errors at the end of a segment, at a stop, from those at its start, where one was struck."""
    index = stop.index
    if segment.t_end - segment.t_start <= 0.0:
        return before
    last = segment.panels[-1]
    q, v = last.interpolate(np.array([segment.t_end]))
    velocity = float(v[0, index])
    if velocity == 0.0:
        return before
    end = np.array([(segment.t_end - last.t) / last.h])
    braking = float(evaluate(last.a[:, index], end, 0)[0])
    clock = 2.0 * _EPS * segment.t_end
    if segment.kinematic:
        rate = abs(velocity)
        shift = float(round_off(system, last, q)[index]) / rate + clock
        return EventError(shift, 16.0 * _EPS + abs(braking) * shift / rate)
    rows = system.constraint_set(segment.closed)
    own = _own_errors(system, rows, segment, stop, known)
    arrival = _Arrival(velocity, braking, clock, *own)
    key = (id(segment.panels[0].q), index)
    if key not in known.matrices:
        known.matrices[key] = fundamental_matrix(system, rows, segment, index)
    propagation = known.matrices[key]
    if propagation is None:
        return _after_ballistic_flight(segment, stop, arrival, before)
    origin = index if struck is None else struck.index
    return _after_propagation(segment, origin, propagation, arrival, before)


class _Arrival(NamedTuple):
    """How a flight comes to a stop, and what it is wrong by of its own.

    Attributes:
        velocity: Of the stop's coordinate at the end [rad/s or m/s].
        braking: Its acceleration there [rad/s^2 or m/s^2].
        clock: Round-off of the time [s].
        eps: Error of the gap [rad or m].
        eta: Error of its rate [rad/s or m/s].
    """

    velocity: float
    braking: float
    clock: float
    eps: float
    eta: float


def _own_errors(
    system: System, rows: ConstraintSet, segment: Segment, stop: Stop, known: _Known
) -> tuple[float, float]:
    """What a flight leaves unresolved in the gap of a stop and in its rate."""
    index, left_over = stop.index, known.left_over
    eta = 0.0
    # Where a gap has not just opened its start has the round-off of the closures.
    start = segment.panels[0]
    eps = (
        0.0 if start.q[0, index] == stop.at else float(round_off(system, start, start.q[:1])[index])
    )
    for panel in segment.panels:
        if panel is not start:
            # Where panels meet a gap has the round-off of its coordinate, however small it is.
            eps += _EPS * abs(float(panel.q[0, index]))
        key = (id(panel.q), index)
        if key not in left_over:
            left_over[key] = _left_over(system, rows, panel, index)
        gap, slope = left_over[key]
        eps += gap + panel.h * eta
        eta += slope
    if rows.freedom > 1:
        return _COUPLED * eps, _COUPLED * eta
    return eps, eta


def _after_propagation(
    segment: Segment,
    origin: int,
    propagation: tuple[FloatArray, FloatArray],
    arrival: _Arrival,
    before: EventError,
) -> EventError:
    """Errors after a flight with one freedom, whose variational equation carries those before.

    Args:
        segment: The flight.
        origin: Coordinate of the stop that was struck at its start.
        propagation: Its fundamental matrix, and the direction of its one freedom.
        arrival: Its end.
        before: Errors at its start.
    """
    matrix, direction = propagation
    first, rate = segment.panels[0], abs(arrival.velocity)
    # An error of the rate of the stop that was struck, and a start that is late.
    w, slowing = float(first.v[0, origin]), float(first.a[0, origin])
    errors = np.array([[0.0, before.time * w], [before.impulse * w, before.time * slowing]])
    ends = matrix @ errors / max(abs(float(direction[origin])), _EPS)
    lates = ends[0] / -arrival.velocity
    late = float(np.abs(lates).sum())
    slower = float(np.abs(ends[1] + arrival.braking * lates).sum()) / rate
    grown = max(1.0, abs(float(matrix[1, 1])))
    shift = grown * arrival.eps / rate + arrival.clock
    relative = slower + (grown * arrival.eta + abs(arrival.braking) * shift) / rate
    length = segment.t_end - segment.t_start
    return EventError(min(late, before.time + length) + shift, min(relative, 1.0))


def _after_ballistic_flight(
    segment: Segment, stop: Stop, arrival: _Arrival, before: EventError
) -> EventError:
    """Errors after a flight whose length and final rate are taken to go with its first rate.

    Args:
        segment: The flight.
        stop: The stop that it ends at.
        arrival: Its end.
        before: Errors at its start.
    """
    rate, length = abs(arrival.velocity), segment.t_end - segment.t_start
    fastest = max(float(np.abs(panel.v[:, stop.index]).max()) for panel in segment.panels)
    shift = arrival.eps / rate + arrival.clock
    # 1 in a ballistic flight.
    slower = max(fastest / rate, 1.0)
    late = min(length * before.impulse * slower, length)
    wrong = arrival.eta + abs(arrival.braking) * (shift + late * (1.0 - 1.0 / slower))
    # At 1 nothing is known any more.
    relative = min(before.impulse * slower + wrong / rate, 1.0)
    return EventError(before.time + late + shift, relative)


def _impact(system: System, event: Event, known: _Known) -> float:
    """Relative round-off of the rates after a collision: the digits that its matrix loses."""
    key = id(event.delta)
    if key not in known.impacts:
        _, jacobian = system.body.closures(event.q[None])
        struck = [system.mechanism.stop(n).index for n, P in event.P_N.items() if P > 0.0]
        condition = impact_condition(system, event.q, jacobian[0], struck)
        known.impacts[key] = min(_EPS * condition, 1.0)
    return known.impacts[key]


def _release(system: System, segment: Segment, index: int) -> float:
    """Error of the time at which a stop force vanishes: what it is wrong by over its slope [s]."""
    rows = system.constraint_set(segment.closed)
    panel, t = segment.panels[-1], segment.t_end
    if index not in rows.stops or segment.t_start >= t:
        return 0.0
    column, step = rows.stops.index(index), _SLOPE_STEP * min(panel.h, t - panel.t)
    q, v, _, forces = forces_at(system, rows, panel, np.array([t - step, t]))
    slope = float(forces.la_N[1, column] - forces.la_N[0, column]) / step if step else 0.0
    nv = q.shape[1]
    position, velocity = round_off(system, panel, q[1:]), NEARBY * _EPS * np.abs(v[1])
    if panel.integrated:
        left_over = _left_over_alone(system, rows, panel)
        position, velocity = position + left_over[0], velocity + left_over[1]
    # One coordinate, then one rate at a time.
    moved = q[1] + np.vstack([np.diag(position), np.zeros((nv, nv))])
    moving = v[1] + np.vstack([np.zeros((nv, nv)), np.diag(velocity)])
    _, jacobian = system.body.closures(moved)
    motion = system.shaft.driven(np.full(2 * nv, t))
    a = system.accelerations(motion, moved, moving, rows)
    there = multipliers(system, motion, moved, moving, a, jacobian, rows, panel.split)
    wrong = float(np.abs(there.la_N[:, column] - forces.la_N[1, column]).sum())
    length = t - segment.t_start
    return min(wrong / abs(slope), length) if slope else length


def round_off(system: System, panel: Panel, q: FloatArray) -> FloatArray:
    """Round-off of positions, (nv,): of dependent ones that of the closures, by their lever."""
    lever = np.ones(q.shape[1])
    if panel.split.dependent:
        _, jacobian = system.body.closures(q)
        _, inverse = inverted(jacobian[0].take(panel.split.columns, 1))
        lever[panel.split.columns] = np.abs(inverse).sum(axis=1)
    return np.asarray(8.0 * _EPS * system.body.reach_m * lever)


def _left_over(
    system: System, rows: ConstraintSet, panel: Panel, index: int
) -> tuple[float, float]:
    """What a flight panel leaves unresolved in one position and one velocity.

    A coordinate that the closures determine has the errors of those that determine it besides.
    """
    columns, shares = [index], np.ones(1)
    if index in panel.split.dependent:
        columns = [index, *(k for k in panel.split.independent if system.free[k])]
        shares = np.append(shares, np.abs(_lever(system, panel, index)[columns[1:]]))
    position, velocity = _left_over_alone(system, rows, panel)
    return float(shares @ position[columns]), float(shares @ velocity[columns])


def _lever(system: System, panel: Panel, index: int) -> FloatArray:
    """Change of a dependent coordinate by each independent one at the end of a panel, (nv,)."""
    _, jacobian = system.body.closures(panel.q[-1:])
    _, inverse = inverted(jacobian[0].take(panel.split.columns, 1))
    return np.asarray(inverse[panel.split.dependent.index(index)] @ jacobian[0])


def _between(system: System, rows: ConstraintSet, panel: Panel) -> FloatArray:
    """Largest difference of the dynamics from the interpolant between the nodes, (nv,).

    The last coefficients may be small by chance; what is wrong between the nodes is not.
    """
    return np.asarray(defect(system, rows, panel, nodes(panel.order).between).max(axis=0))


def _left_over_alone(
    system: System, rows: ConstraintSet, panel: Panel
) -> tuple[FloatArray, FloatArray]:
    """What a flight panel leaves unresolved in all positions and velocities, each (nv,)."""
    grid, h, a = nodes(panel.order), panel.h, panel.a
    motion = system.shaft.driven(panel.times)
    again = system.accelerations(motion, panel.q, panel.v, rows)
    swept = again - a
    there = system.accelerations(motion, *nearby(system, panel.q, panel.v, panel.split), rows)
    rough = np.abs(there - again).max(axis=0)
    missing = _between(system, rows, panel)
    if system.mechanism.tabulated_springs:
        # Across a row of a table coefficients decay by powers: of k^-3 that all follow, twice
        # integrated, a quarter of their number times the last one is missing.
        last = np.abs(grid.integrals[0][-2:] @ a).max(axis=0)
        missing = np.maximum(missing, 0.25 * panel.order * last)
    round_off = _OPERATIONS * _EPS * (np.abs(panel.v[0]) + h * np.abs(a).max(axis=0))
    position = missing / (2.0 * panel.order) ** 2 + np.abs(grid.twice @ swept).max(axis=0)
    velocity = missing / (2.0 * panel.order) + np.abs(grid.once @ swept).max(axis=0)
    return (
        _SAFETY * h**2 * (position + 0.5 * rough) + h * round_off,
        _SAFETY * h * (velocity + rough) + round_off,
    )
