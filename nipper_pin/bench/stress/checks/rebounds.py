"""Check the table of collisions against the motion of the solution."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from ....arrays import FloatArray
from ....hybrid.result.solution import Solution
from ....hybrid.result.tables import Collision
from ....mechanism import Stop
from ....tolerances.bench import AMPLITUDE_SHARE, CLOSURE_SUM, EPS
from ..observations import beyond, some

_LOOKED_AT = 12
# Points over the whole flight, then about its highest one, three times: 3e-5 of the flight apart in
# the end, where a parabola leaves less than 1e-9 of its height.
_FIRST, _NEXT = 65, 17


def rebounds(solution: Solution) -> Iterator[str]:
    """Amplitude and time of rebounds, from positions at many times and from the next event."""
    events, span = solution.events, solution.trajectory.span
    hits = solution.collisions
    for hit in (hits[place] for place in some(len(hits), _LOOKED_AT)):
        where = f"collision {hit.number}"
        stop = solution.mechanism.stop(hit.stop)
        yield from _numbers(where, stop, hit)
        own = [item.energy_lost for item in hits if item.event is hit.event]
        whole = hit.event.energy_lost
        left, most = abs(math.fsum(own) - whole), 8.0 * EPS * len(own) * abs(whole)
        yield from beyond(f"{where}: energy lost is not that of its event", left, most)
        following = [e for e in events[hit.event.number :] if hit.stop in e.P_N]
        amplitude, time = hit.rebound_amplitude, hit.rebound_time
        flies = stop.rate(hit.event.v_after) > 0.0
        if amplitude is None or time is None or not flies or not following:
            continue
        end = following[0]
        if np.array_equal(end.q, hit.event.q) or end.t > span[1] or end.t <= hit.t:
            # The flight was not integrated: rest followed from the series.
            continue
        clock = 16.0 * EPS * end.t
        yield from beyond(f"{where}: rebound time is not that to the next event [s]",
                           abs(time - (end.t - hit.t)), clock)  # fmt: skip
        seen = _highest(solution, stop, hit.t, end.t)
        moved = abs(stop.at) + amplitude
        most = (
            AMPLITUDE_SHARE * amplitude
            + 16.0 * EPS * moved
            + clock * abs(hit.separation_rate)
            + CLOSURE_SUM
        )
        most += 10.0 * solution.case.resolution.tolerance * amplitude
        yield from beyond(f"{where}: rebound amplitude is not that of the motion [rad or m]",
                           abs(amplitude - seen), most)  # fmt: skip


def _numbers(where: str, stop: Stop, hit: Collision) -> Iterator[str]:
    """Rates and impulse of the row are those of its event."""
    event = hit.event
    rows = (
        ("approach rate", hit.approach_rate, stop.sense * event.v_before[stop.index]),
        ("separation rate", hit.separation_rate, stop.sense * event.v_after[stop.index]),
        ("impulse", hit.impulse * stop.lever, event.P_N[stop.name]),
        ("time", hit.t, event.t),
    )
    for name, found, told in rows:
        yield from beyond(f"{where}: {name} is not that of its event",
                           abs(found - told), 8.0 * EPS * abs(told))  # fmt: skip


def _highest(solution: Solution, stop: Stop, begin: float, end: float) -> float:
    """Largest gap between two times, from positions alone; the gap has kinks between segments."""
    borders = [item.t_start for item in solution.segments if begin < item.t_start < end]
    parts = pairwise([begin, *borders, end])
    return max(_highest_of(solution, stop, *part) for part in parts)


def _highest_of(solution: Solution, stop: Stop, begin: float, end: float) -> float:
    def gaps(times: FloatArray) -> FloatArray:
        return stop.gaps(solution.trajectory.evaluate(times, left=True).q)

    times = np.linspace(begin, end, _FIRST)
    for _ in range(3):
        place = int(np.argmax(gaps(times)))
        low, high = times[max(place - 1, 0)], times[min(place + 1, len(times) - 1)]
        times = np.linspace(low, high, _NEXT)
    values = gaps(times)
    place = int(np.argmax(values))
    if not 0 < place < len(times) - 1:
        return float(values.max())
    left, middle, right = values[place - 1 : place + 2]
    bend = 2.0 * middle - left - right
    return float(middle + 0.125 * (right - left) ** 2 / bend if bend > 0.0 else middle)
