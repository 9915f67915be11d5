"""Quantities read off a simulated turn, by nothing that a search uses.

A search evaluates transitions and kinematics. Here peaks of the dense motion are found by looking
closer and closer, and means by sums over the stretches in which a stop is closed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from ....arrays import FloatArray
from ....hybrid.event import EventKind
from ....mechanism import INDEX_PER_TURN
from ....tolerances.study import CONTROL_EDGE, CONTROL_ROUND_OFF
from ....units import MM_PER_M, S_PER_MIN
from .turn import ControlTurn

# Places of a stretch at which a peak is looked for, and how often closer around the best one.
_PLACES, _LOOKS = 240, 4


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
}
"""How each quantity is read, by name; in its unit."""
