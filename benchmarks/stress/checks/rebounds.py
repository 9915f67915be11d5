"""Check the table of collisions against the motion of the solution."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.polynomial.chebyshev import Chebyshev, chebfit, chebpts2

from nipper_pin.arrays import FloatArray
from nipper_pin.hybrid import Collision, Solution
from nipper_pin.mechanism import Stop

from ...tolerances import AMPLITUDE_SHARE, CLOSURE_SUM, EPS
from ..observations import beyond, some

_LOOKED_AT = 12
# Degree beyond the nodes of a panel: two of its integrals, some for gaps that closures determine.
_FURTHER = 8


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
        most = (AMPLITUDE_SHARE + 10.0 * solution.case.resolution.tolerance) * amplitude
        most += 16.0 * EPS * moved + clock * abs(hit.separation_rate) + CLOSURE_SUM
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
    """Largest gap between two times, from positions alone.

    On each panel they are a polynomial of the time, or nearly so: one of more terms tells where all
    its crests are, however many there are, and the positions there tell how high they are.
    """

    def gaps(times: FloatArray) -> FloatArray:
        return stop.gaps(solution.trajectory.evaluate(times, left=True).q)

    best = -np.inf
    for first, last, degree in _parts(solution, begin, end):
        places = chebpts2(degree + 1)
        times = np.clip(0.5 * (first + last) + 0.5 * (last - first) * places, first, last)
        course = Chebyshev(chebfit(places, gaps(times), degree), domain=[first, last])
        crests = course.trim(EPS * np.abs(course.coef).max()).deriv().roots()
        tops = np.clip([first, last, *crests.real[crests.imag == 0.0]], first, last)
        best = max(best, float(gaps(np.sort(tops)).max()))
    return best


def _parts(solution: Solution, begin: float, end: float) -> Iterator[tuple[float, float, int]]:
    """Ends [s] of the parts of panels between two times, and a degree that tells each of them."""
    for segment in solution.segments:
        for panel, first, last in segment.pieces():
            if last > begin and first < end:
                yield max(first, begin), min(last, end), panel.order + _FURTHER
