"""Errors of amplitude and time of the rebound after a collision."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...tolerances.hybrid import CLOCK_ROUND_OFF
from ..error_estimate.event_errors import EventError
from ..error_estimate.linear_maps import LinearMaps
from ..event import EventKind
from ..segment import Segment
from .solution import Solution
from .tables import Collision


class ReboundError(NamedTuple):
    """Estimated errors of a rebound.

    Attributes:
        amplitude: Of its largest gap [rad or m].
        time: Of its time [s].
    """

    amplitude: float
    time: float


def rebound_error(solution: Solution, hit: Collision) -> ReboundError:
    """Estimate the errors of the rebound after a collision.

    Its time is that between two events, of which what makes both late is no part. Of a nearly
    ballistic flight the height goes with the square of the rate: the collision at its end holds
    what the flight has left unresolved.

    Args:
        solution: The solution.
        hit: One of its collisions.

    Returns:
        Infinite errors where a rebound is unknown.
    """
    height, duration = hit.rebound_amplitude, hit.rebound_time
    end, left_out = hit.rebounds.until(hit.event, hit.stop)
    if height is None or duration is None or end is None:
        return ReboundError(np.inf, np.inf)
    error = solution.errors[hit.event.number - 1]
    if left_out is not None:
        return _left_out(solution, hit, left_out, error)
    later = solution.errors[hit.event.number : end.number]
    relative, late = error.at(hit.stop).relative, float(sum(item.since for item in later))
    if end.kind is EventKind.COLLISION and later:
        relative = max(relative, later[-1].at(hit.stop).relative)
    # What lies between two events is that between their first stops.
    events = solution.events[hit.event.number - 1 : end.number]
    for event, item in zip(events, (error, *later), strict=True):
        if hit.stop in item.strikes and hit.stop != event.stops[0]:
            late += item.strikes[hit.stop].time
    return ReboundError(2.0 * relative * height, late)


def _left_out(
    solution: Solution, hit: Collision, flown: Sequence[Segment], error: EventError
) -> ReboundError:
    """Errors of a rebound that the run did not follow: those of its rate, and of its own flight."""
    index = solution.mechanism.stop(hit.stop).index
    maps, last = LinearMaps(solution.led_system, solution.led_events), flown[-1]
    own = [maps.flight(segment).own for segment in flown if segment.t_end > segment.t_start]
    _, v = last.panels[-1].interpolate_at(last.t_end)
    rate = abs(float(v[index]))
    slower, off = (sum(item.size(row) for item in own) for row in (len(v) + index, index))
    relative = error.at(hit.stop).relative + slower / rate
    duration = last.t_end - flown[0].t_start
    late = off / rate + CLOCK_ROUND_OFF * (hit.t + duration)
    return ReboundError(
        2.0 * relative * float(hit.rebound_amplitude or 0.0), relative * duration + late
    )
