"""Errors of amplitude and time of the rebound after a collision."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ...tolerances.hybrid import CLOCK_ROUND_OFF
from ..error_estimate.event_errors import EventError
from ..error_estimate.linear_maps import LinearMaps, PanelMaps
from ..error_estimate.zonotope import part_of
from ..history import EventKind, Segment
from .solution import Solution
from .tables import Collision


class ReboundError(NamedTuple):
    """Estimated errors of a rebound: of its largest gap [rad or m], and of its time [s]."""

    amplitude: float
    time: float


def rebound_error(solution: Solution, hit: Collision) -> ReboundError:
    """Estimate the errors of the rebound after a collision.

    Its time is that between two events, of which what makes both late is no part. Of a nearly
    ballistic flight the height goes with the square of the rate: the collision at its end holds
    what the flight has left unresolved.

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
    part = solution.system.coupled([hit.stop])
    relative, late = error.at(hit.stop).relative, 0.0
    for event in solution.events[hit.event.number - 1 : end.number]:
        own = [name for name in event.stops if name in part]
        if not own:
            continue
        item = solution.errors[event.number - 1]
        late += item.at(own[0]).since if event is not hit.event else 0.0
        # What lies between two events of a part is that between their first stops.
        if hit.stop in item.strikes and hit.stop != own[0]:
            late += item.strikes[hit.stop].time
    if end.kind is EventKind.COLLISION and end is not hit.event:
        relative = max(relative, solution.errors[end.number - 1].at(hit.stop).relative)
    return ReboundError(2.0 * relative * height, late)


def _left_out(
    solution: Solution, hit: Collision, flown: Sequence[Segment], error: EventError
) -> ReboundError:
    """Errors of a rebound that the run did not follow: those of its rate, and of its own flight."""
    index = solution.mechanism.stop(hit.stop).index
    part = part_of(solution.led_system, hit.stop)
    maps, last = LinearMaps(part, PanelMaps(solution.led_system, solution.led_events)), flown[-1]
    own = [maps.flight(segment).own for segment in flown if segment.t_end > segment.t_start]
    _, v = last.panels[-1].interpolate_at(last.t_end)
    rate = abs(float(v[index]))
    place = part.place(index)
    slower, off = (sum(item.size(row) for item in own) for row in (part.size + place, place))
    relative = error.at(hit.stop).relative + slower / rate
    duration = last.t_end - flown[0].t_start
    late = off / rate + CLOCK_ROUND_OFF * (hit.t + duration)
    return ReboundError(
        2.0 * relative * float(hit.rebound_amplitude or 0.0), relative * duration + late
    )
