"""Quantities read off a simulated turn, by nothing that a search uses.

A search evaluates transitions and kinematics. Here peaks of the dense motion are found by looking
closer and closer, and means by sums over the stretches in which a stop is closed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ....arrays import FloatArray
from ....errors import SimulationError
from ....hybrid.event import EventKind
from ....mechanism import INDEX_PER_TURN
from ....tolerances.study import CONTROL_EDGE, CONTROL_ROUND_OFF
from ....units import MM_PER_M, S_PER_MIN
from .turn import ControlTurn

# Places of a stretch at which a peak is looked for, and how often closer around the best one.
_PLACES, _LOOKS = 240, 4
_HIT = EventKind.COLLISION


class Read(NamedTuple):
    """A quantity read off a turn.

    Attributes:
        value: The quantity, in its unit.
        error: Stated error of it, in the same unit.
    """

    value: float
    error: float


def _amplitude(turn: ControlTurn) -> Read:
    """Largest gap between the first two collisions."""
    first, *later = turn.hits
    second = next((hit for hit in later if hit.event.number < turn.rest.number), None)
    error = turn.blurred(first.event)
    if second is None:
        height = first.rebound_amplitude or 0.0
    else:
        stop = turn.mechanism.stop(turn.stop)
        height = _peak(turn, stop.index, first.t, second.t)
        error = max(error, turn.blurred(second.event))
    return Read(height, (2.0 * error + CONTROL_ROUND_OFF) * height)


def _rebound_time(turn: ControlTurn) -> Read:
    """Time between the first two collisions."""
    first, *later = turn.hits
    second = next((hit for hit in later if hit.event.number < turn.rest.number), None)
    if second is None:
        return Read(first.rebound_time or 0.0, turn.late(first.event))
    return Read(second.t - first.t, turn.late(first.event) + turn.late(second.event))


def _duration(turn: ControlTurn) -> Read:
    """Time from the first collision to rest."""
    first = turn.hits[0]
    return Read(turn.rest.t - first.t, turn.late(first.event) + turn.late(turn.rest))


def _closing_index(turn: ControlTurn) -> Read:
    """Index of the first collision."""
    return _index(turn, turn.hits[0].t, turn.late(turn.hits[0].event))


def _opening_index(turn: ControlTurn) -> Read:
    """Index at which the transition stop opens again."""
    return _index(turn, turn.opening.t, turn.late(turn.opening))


def _index(turn: ControlTurn, t: float, late: float) -> Read:
    psi = float(turn.solution.shaft.angle(t))
    error = INDEX_PER_TURN * (late / turn.solution.shaft.period + CONTROL_ROUND_OFF)
    return Read(turn.mechanism.cylinder.index_from_angle(psi), error)


def _clamping_force(turn: ControlTurn) -> Read:
    """Mean lip force over the middle half from first collision to opening; none while open."""
    first, last = turn.hits[0].t, turn.opening.t
    quarter = 0.25 * (last - first)
    whole = error = 0.0
    for item in turn.solution.phases:
        begin, end = max(item.t_start, first + quarter), min(item.t_end, last - quarter)
        if turn.stop not in item.closed or end <= begin:
            continue
        part = (end - begin) / (2.0 * quarter)
        coarse, fine = (_mean_force(turn, begin, end, n) for n in (_PLACES, 2 * _PLACES))
        whole += part * (4.0 * fine - coarse) / 3.0
        error += part * abs(fine - coarse)
    return Read(whole, error + CONTROL_ROUND_OFF * abs(whole))


def _mean_force(turn: ControlTurn, begin: float, end: float, parts: int) -> float:
    """Mean lip force by the midpoint rule, since the force of an end belongs to either phase."""
    places = begin + (end - begin) * (np.arange(parts) + 0.5) / parts
    return float(turn.solution.trajectory.reactions(places).contacts[turn.stop].mean())


def _stop_force(turn: ControlTurn) -> Read:
    """Least force of the initial phase's stop while the other is open; zero if it is left."""
    first, last = turn.open_between
    left = any(
        event.kind is EventKind.RELEASE and turn.waiting in event.stops and first < event.t < last
        for event in turn.solution.events
    )
    if left:
        return Read(0.0, 0.0)
    found = []
    for item in turn.solution.phases:
        begin, end = max(item.t_start, first), min(item.t_end, last)
        if turn.waiting in item.closed and begin < end:
            # At the ends of a phase the stop is just being hit or left.
            edge = CONTROL_EDGE * (end - begin)
            found.append(-_closer(lambda t: -_force(turn, t), begin + edge, end - edge))
    low = min(found, default=0.0)
    return Read(low, CONTROL_ROUND_OFF * abs(low))


def _force(turn: ControlTurn, t: FloatArray) -> FloatArray:
    return turn.solution.trajectory.reactions(t).contacts[turn.waiting]


def _jaw_opening(turn: ControlTurn) -> Read:
    """Largest coordinate of the transition stop between opening and closing."""
    index = turn.mechanism.stop(turn.stop).index
    widest = math.degrees(_peak(turn, index, *turn.open_between))
    return Read(widest, CONTROL_ROUND_OFF * widest)


def _stroke(turn: ControlTurn) -> Read:
    """Largest coordinate of the initial phase's stop between rest and opening."""
    index = turn.mechanism.stop(turn.waiting).index
    most = MM_PER_M * _peak(turn, index, turn.rest.t, turn.opening.t)
    return Read(most, CONTROL_ROUND_OFF * most)


def _closed(turn: ControlTurn) -> list[tuple[float, float]]:
    """Stretches of the turn on which the transition stop is closed."""
    found = []
    for item in turn.solution.phases:
        begin, end = max(item.t_start, turn.begin), min(item.t_end, turn.end)
        if turn.stop in item.closed and begin < end:
            found.append((begin, end))
    return found


def _clamped_time(turn: ControlTurn) -> Read:
    """Time with the transition stop closed: it opens where its force has fallen to zero."""
    whole = math.fsum(end - begin for begin, end in _closed(turn))
    late = math.fsum(
        turn.late(event)
        for event in turn.events
        if (turn.stop in event.closed_before) != (turn.stop in event.closed_after)
    )
    return Read(whole, late + CONTROL_ROUND_OFF * whole)


def _clamped_share(turn: ControlTurn) -> Read:
    """The same by the time of a turn."""
    time, period = _clamped_time(turn), turn.solution.shaft.period
    return Read(time.value / period, time.error / period)


def _rest_index(turn: ControlTurn) -> Read:
    """Index of the first rest."""
    return _index(turn, turn.rest.t, turn.late(turn.rest))


def _rest_margin(turn: ControlTurn) -> Read:
    """Indices from rest to opening."""
    scale = INDEX_PER_TURN / turn.solution.shaft.period
    late = turn.late(turn.rest) + turn.late(turn.opening)
    margin = scale * (turn.opening.t - turn.rest.t)
    return Read(margin, scale * late + INDEX_PER_TURN * CONTROL_ROUND_OFF)


def _extreme_force(turn: ControlTurn, sign: float) -> Read:
    """Largest force of the transition stop by sign, over the stretches on which it is closed."""

    def signed(t: FloatArray) -> FloatArray:
        return sign * turn.solution.trajectory.reactions(t).contacts[turn.stop]

    found = []
    for begin, end in _closed(turn):
        edge = CONTROL_EDGE * (end - begin)
        near, far = (_closer(signed, begin + k * edge, end - k * edge) for k in (1.0, 2.0))
        # What is left out at the ends goes on as it does beside them.
        found.append((near, 2.0 * abs(near - far)))
    if not found:
        message = f"the stop {turn.stop} is not closed"
        raise SimulationError(message, stop=turn.stop)
    force, error = max(found)
    return Read(sign * force, error + CONTROL_ROUND_OFF * abs(force))


def _least_force(turn: ControlTurn) -> Read:
    """Smallest force of the transition stop while it is closed."""
    return _extreme_force(turn, -1.0)


def _largest_force(turn: ControlTurn) -> Read:
    """Largest force of it."""
    return _extreme_force(turn, 1.0)


def _largest_gap(turn: ControlTurn) -> Read:
    """Largest gap between two collisions of the transition stop, with none of another between."""
    index = turn.mechanism.stop(turn.stop).index
    inside = [event for event in turn.events if event.kind is _HIT]
    found = []
    for pair in pairwise(inside):
        one, other = pair
        if all(turn.stop in [stop.name for stop in hit.struck(turn.mechanism)] for hit in pair):
            error = max(turn.blurred(one), turn.blurred(other))
            found.append((_peak(turn, index, one.t, other.t), error))
    if not found:
        return _amplitude(turn)
    height, error = max(found)
    return Read(height, (2.0 * error + CONTROL_ROUND_OFF) * height)


def _energy_lost(turn: ControlTurn) -> Read:
    """Kinetic energy lost in the collisions of the turn, and in the bounces too small to follow."""
    hits = [event for event in turn.events if event.kind is _HIT]
    whole = math.fsum(event.energy_lost for event in hits)
    error = math.fsum(2.0 * turn.blurred(event) * event.energy_lost for event in hits)
    further = 0.0
    for event, after in pairwise(turn.events):
        if event.kind is _HIT and after.kind is EventKind.REST and event.stops == after.stops:
            for stop in event.struck(turn.mechanism):
                e_N = stop.restitution
                further += event.energy_lost_at(stop) * e_N**2 / (1.0 - e_N**2)
    # A series that ends at a rate has none of them, so all of it may be wrong.
    return Read(whole + further, error + further + CONTROL_ROUND_OFF * whole)


def _speed(turn: ControlTurn) -> Read:
    """Cylinder speed."""
    speed = S_PER_MIN / turn.solution.shaft.period
    return Read(speed, CONTROL_ROUND_OFF * speed)


def _peak(turn: ControlTurn, index: int, begin: float, end: float) -> float:
    """Largest value of a coordinate between two times."""
    trajectory = turn.solution.trajectory
    first, last = trajectory.span
    return _closer(
        lambda t: trajectory.evaluate(t, left=True).q[:, index], max(begin, first), min(end, last)
    )


def _closer(of: Callable[[FloatArray], FloatArray], begin: float, end: float) -> float:
    """Largest value on a stretch, by looking closer around the largest one."""
    best = -math.inf
    for _ in range(_LOOKS):
        t = np.linspace(begin, end, _PLACES)
        values = of(t)
        place = int(np.argmax(values))
        best = max(best, float(values[place]))
        begin, end = t[max(place - 1, 0)], t[min(place + 1, len(t) - 1)]
    return best


READ: Mapping[str, Callable[[ControlTurn], Read]] = {
    "rebound_amplitude_1": _amplitude,
    "rebound_time_s_1": _rebound_time,
    "duration_s": _duration,
    "closing_index": _closing_index,
    "opening_index": _opening_index,
    "clamping_force_N": _clamping_force,
    "stop_force_N": _stop_force,
    "jaw_opening_deg": _jaw_opening,
    "stroke_mm": _stroke,
    "speed_rpm": _speed,
    "clamped_time_s": _clamped_time,
    "clamped_share": _clamped_share,
    "rest_index": _rest_index,
    "rest_margin": _rest_margin,
    "least_clamping_force_N": _least_force,
    "largest_clamping_force_N": _largest_force,
    "largest_gap": _largest_gap,
    "energy_lost_turn_J": _energy_lost,
}
"""How each quantity is read, by name; in its unit."""
