"""Limits of series of bounces, compiled."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from ...arrays import FloatArray
from ...tolerances.reduced import LATE_REST_SAFETY, LIMIT_CHANGE_SHARE
from . import layout as rows
from .compiled import part
from .flight_errors import drift, size
from .layout import Motion, Settings, Solver
from .panel import acceleration, range_along
from .turn_charts import surface

_POINTS = 8


@part
def limit(series: FloatArray, count: int, changes: float) -> tuple[float, float, float]:
    """Extrapolate times to zero rate by Neville's scheme.

    Extrapolations of two orders may agree better than either is right, since the bounces that they
    share are nearest to the limit; so one is compared with those without the last bounces.

    Returns:
        The limit, a bound on its error, and by what those still change if their changes with each
        bounce go on to fall as the last did.
    """
    first = max(0, count - _POINTS)
    size = count - first
    for i in range(first, count - 1):
        if series[1, i + 1] >= series[1, i]:
            return np.inf, np.inf, np.inf
    for i in range(size):
        series[2, i] = series[0, first + i] - series[0, count - 1]
    best, best_error, previous, gained = np.inf, np.inf, 0.0, 0.0
    older, old, now = np.nan, np.nan, series[2, 0]
    for order in range(1, size):
        for i in range(size - order):
            far, near = series[1, first + i], series[1, first + i + order]
            series[2, i] = (far * series[2, i + 1] - near * series[2, i]) / (far - near)
        last = series[2, size - order - 1]
        older, old, now = old, now, series[2, 0]
        # Extrapolations may agree by chance. Each should gain about the ratio of its rates, but
        # no more than the remaining change of x'': far bounces do not depend on it.
        ratio = max(series[1, count - 1] / series[1, count - order], changes)
        error = max(abs(last - previous), ratio * gained)
        if error < best_error:
            best, best_error = last, error
        gained = abs(last - previous)
        previous = last
    # Of fewer than three bounces the change before is not known.
    before, change = abs(old - older), abs(now - old)
    still = change * min(change / before, 1.0) if before > 0.0 else 0.0
    return best, best_error, still


@part
def settles(solver: Solver, settings: Settings, at: Motion, count: int, late: bool,
            still: float) -> tuple[bool, float, float]:  # fmt: skip
    """Whether the rest of a series of bounces is known, how far it is ahead, and the error of that.

    Args:
        at: After the last collision, with a rate above zero; its place was contracted into the
            first row.
        count: Bounces.
        late: Whether the rebounds are slow enough for an extrapolation.
        still: x'' at x = 0 at rest.
    """
    c, w, series, tolerance = at.chart, at.v, solver.work.series, settings.tolerance
    restitution, speed = solver.one.restitution[solver.charts.stops[c, rows.OWN]], solver.one.speed
    if settings.rest_rate > 0.0:
        return w < settings.rest_rate and still < 0.0, 0.0, 0.0
    a = acceleration(solver, c, rows.ZERO, 0.0, w)
    ahead, uncertain = np.inf, np.inf
    if a < 0.0 and restitution < 1.0:
        ahead = -2.0 * w / (a * (1.0 - restitution))
    found = ahead <= tolerance * 2.0 * pi / speed
    if found or late:
        changes = drift(solver.work.sizes[c], speed, w, a, ahead)
        if found:
            uncertain = ahead * changes
        else:
            further, uncertain, still_changes = limit(series, count, changes)
            found = uncertain <= tolerance * (series[0, count - 1] + ahead)
            if found:
                ahead = further
                uncertain = max(uncertain, LIMIT_CHANGE_SHARE * still_changes)
    return found and still < 0.0, ahead, uncertain


@part
def surely_over(solver: Solver, at: Motion, still: float) -> tuple[bool, float]:
    """Whether a series surely ends while its stop is pressed, and how long it takes at the most.

    With x'' between -b and -a a flight takes 2 w / a at the most, and lands no faster than
    w sqrt(b / a). So all of them together take no more than 2 w / (a - e sqrt(a b)).

    Args:
        at: After the last collision, with a rate above zero.
        still: x'' at x = 0 at rest.
    """
    charts, work, c, u, w, d = solver.charts, solver.work, at.chart, at.u, at.v, -still
    number, sizes, speed = charts.numbers[c], work.sizes[c], solver.one.speed
    restitution = solver.one.restitution[charts.stops[c, rows.OWN]]
    if not (d > 0.0 and restitution < 1.0):
        return False, 0.0
    ahead = LATE_REST_SAFETY * 2.0 * w / (d * (1.0 - restitution))
    # Rates stay below 2 w, and gaps below w w / d.
    over, gap = u + speed * ahead, w * w / d
    if over >= number[rows.TRAVEL_MOST] or gap > number[rows.HIGH]:
        return False, ahead
    low, high = range_along(work.line[c], number[rows.PER_RAD], u, over)
    felt = 2.0 * w * size(sizes, rows.BY_V, 2.0 * w) + gap * size(sizes, rows.BY_X, 2.0 * w)
    least, most = -high - felt, felt - low
    if not (least > 0.0 and most <= 4.0 * least):
        return False, ahead
    if 2.0 * w > ahead * (least - restitution * sqrt(least * most)):
        return False, ahead
    # No rebound meets another stop that it opens: along the closed stop none closes.
    gaps = charts.gaps[c]
    others = len(gaps) // 3
    for row in range(others, 2 * others):
        if min(surface(gaps, row, number, u, 0.0), surface(gaps, row, number, over, 0.0)) < 0.0:
            return False, ahead
    return True, ahead
