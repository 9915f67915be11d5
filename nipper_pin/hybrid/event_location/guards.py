"""Triggers: where a gap closes or a contact force vanishes on a panel."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from functools import cache
from typing import NamedTuple

import numpy as np

from ...arrays import FloatArray, product
from ...chebyshev import Series, interpolant, nodes
from ...dynamics import ConstraintSet, System
from ...dynamics.complementarity import force_size
from ...errors import SimulationError
from ...mechanism import Stop
from ...tolerances.hybrid import (
    ACTIVE_SET_ROUND_OFF,
    CLOSING_SHARE,
    GAP_ROUND_OFF,
    RISING_FORCE,
    SIMULTANEOUS,
    SMALLEST,
)
from ...tolerances.mechanics import EPS
from ..motion.panel import Panel, one_state_at, stop_forces_at
from .roots import first_descent, polish

# A double integral over the unit interval, by the largest value at the nodes: a polynomial exceeds
# that by a factor of no more than 1 + 2 log(N) / pi, which is 3.7 for 64 of them.
_FARTHEST = 0.5 * 3.7
# Steps of Newton's method from the ends of its bracket at which a root is inside beyond doubt.
_MARGIN = 100.0


class Trigger(NamedTuple):
    """A root: the gap of an open stop, or the force of a closed one, falls through zero.

    Attributes:
        t: Time [s].
        closes: True for a gap, False for a force.
    """

    t: float
    stop: str
    closes: bool


def triggers(
    system: System,
    phase: ConstraintSet,
    panel: Panel,
    forces: FloatArray,
    watched: Collection[str] | None = None,
) -> tuple[Trigger, ...]:
    """Earliest triggers on a panel, simultaneous ones together.

    Args:
        forces: Forces of the closed stops at its nodes, shape (N, closed).
        watched: Names of the stops that count; all if there are none.
    """
    found = []
    for stop in phase.open:
        if watched is None or stop.name in watched:
            t = _gap_root(system, phase, panel, stop)
            if t is not None:
                found.append(Trigger(t, stop.name, closes=True))
    for column, stop in enumerate(phase.shut):
        if watched is None or stop.name in watched:
            t = _force_root(system, phase, panel, forces[:, column], column)
            if t is not None and not _is_nothing(system, panel, stop, forces[:, column]):
                found.append(Trigger(t, stop.name, closes=False))
    if not found:
        return ()
    earliest = min(trigger.t for trigger in found)
    limit = earliest + SIMULTANEOUS * system.shaft.period
    return tuple(
        trigger if trigger.t == earliest else trigger._replace(t=earliest)
        for trigger in sorted(found, key=lambda item: item.stop)
        if trigger.t <= limit
    )


def _gap_root(system: System, phase: ConstraintSet, panel: Panel, stop: Stop) -> float | None:
    """Time at which a gap falls through zero on a panel, or None."""
    gap, rate = stop.gap(panel.q[0]), stop.rate(panel.v[0])
    if rate < 0.0 and gap <= 0.0:
        # By round-off a zero on the border of two panels may lie on neither; and a stop may touch
        # at the instant at which a collision at another one reverses its rate.
        return panel.t
    if panel.integrated:
        return _flight_root(panel, stop, gap, rate, GAP_ROUND_OFF * system.body.unit_of[stop.index])
    h, gaps = panel.h, stop.gaps(panel.q)
    series = interpolant(gaps)
    if series.positive:
        return None

    def exact(t: float) -> tuple[float, float]:
        state = one_state_at(system, phase, panel, t)
        return stop.gap(state.q), stop.rate(state.v)

    grid = nodes(panel.order)
    values = grid.sample_value @ gaps
    if gap <= 0.0 < rate and values[1] <= 0.0:
        # It opens from round-off and closes before the next sample: its highest place is between.
        peak = panel.t - rate / min(stop.rate(panel.a[0]), -SMALLEST)
        first = panel.t + h * float(grid.samples[1])
        if not peak < first or exact(peak)[0] <= 0.0:
            return panel.t
        return polish(exact, peak, first)

    def lowest(sigma: float) -> float:
        return exact(panel.t + h * sigma)[0]

    bracket = first_descent(grid.samples, values, lowest)
    return None if bracket is None else _polished(panel, bracket, series, exact)


def _flight_root(panel: Panel, stop: Stop, gap: float, rate: float, nothing: float) -> float | None:
    """Time at which a gap in flight falls through zero, or None.

    Dividing out the zero at the start leaves the next one as the only one, to full precision.

    Args:
        gap: Gap of the stop, an open one, at the start of the panel [rad or m].
        nothing: Gap that is round-off.
    """
    grid, h, a = nodes(panel.order), panel.h, panel.a[:, stop.index]
    if -nothing <= gap < 0.0 < rate:
        # It opens from where round-off of the last event has left it, and may close at once.
        gap = 0.0
    nearest = gap + h * min(rate, 0.0)
    if nearest > 0.0 and nearest > _FARTHEST * h**2 * float(np.maximum.reduce(np.abs(a))):
        return None
    scale = stop.sense * h**2
    power = 0 if gap != 0.0 else (1 if rate != 0.0 else 2)
    coefficients = scale * product(grid.deflated[power], a)
    if power == 0:
        coefficients[0] += gap + 0.5 * h * rate
        coefficients[1] += 0.5 * h * rate
    elif power == 1:
        coefficients[0] += h * rate
    series = Series(coefficients)
    if series.positive:
        return None
    first, last = series.ends
    if series.falls and first > 0.0:
        if last > 0.0:
            return None
        bracket = 0.0, 1.0
        guess = min(max(0.5 - 0.5 * series.coefficients[0] / series.coefficients[1], 0.0), 1.0)
        return panel.t + h * polish(series.value_and_slope, *bracket, guess)
    values = scale * (grid.sample_twice[power] @ a)
    if power < 2:
        values += gap + h * rate * grid.samples if power == 0 else h * rate
    # At the start it may be zero: without a pull there, the first samples decide.
    closing = bool(values[0] <= 0.0 and (values[1:] < 0.0).all())
    if power == 2 and (closing or values[0] < -CLOSING_SHARE * float(np.abs(values).max())):
        return panel.t + h * _soon_back(series, values, float(grid.samples[1]))
    if closing:
        if rate < 0.0 < gap <= nothing:
            # It closes within the round-off of its integral.
            return panel.t + min(-gap / rate, h)
        message = (
            f"stop {stop.name!r} is open but its gap starts to close from zero: the accelerations "
            "contradict the closed stops; this is an error of the package, please report the case"
        )
        raise SimulationError(message, stop=stop.name, gap=gap, rate=rate)
    found = first_descent(grid.samples, values, series.value)
    return None if found is None else panel.t + h * polish(series.value_and_slope, *found)


def _soon_back(series: Series, values: FloatArray, first: float) -> float:
    """Place at which a gap that has just opened, at rest, is closed before its first sample.

    A stop opens where its force has fallen to zero, and so has its acceleration: of that, round-off
    is left, and what it becomes tells whether the stop leaves.

    Args:
        series: The gap, divided by the square of the time.
        values: The same at the samples.
        first: The first sample after the start.

    Returns:
        The place; zero where its force only just touched zero: it is pressed shut again.
    """
    nothing, slope = series.value_and_slope(0.0)
    if slope <= 0.0 or values[0] < -CLOSING_SHARE * float(np.abs(values).max()):
        return 0.0
    coefficients = np.array(series.coefficients)
    coefficients[0] -= nothing
    lifted, place = Series(coefficients), first
    while place > EPS:
        if lifted.value(0.5 * place) > 0.0:
            return polish(lifted.value_and_slope, 0.5 * place, place)
        place *= 0.5
    return 0.0


def _force_root(
    system: System,
    phase: ConstraintSet,
    panel: Panel,
    force: FloatArray,
    column: int,
) -> float | None:
    """Time at which the force of a closed stop falls through zero on a panel, or None."""
    series = interpolant(force)
    if series.positive:
        return None
    grid = nodes(panel.order)
    values = grid.sample_value @ force
    if values[0] < 0.0 and not (
        values[1] > 0.0 and -values[0] <= RISING_FORCE * float(np.abs(values).max())
    ):
        # The force was zero to round-off when the stop was taken to be pressed, and does not rise.
        return panel.t

    samples, start = grid.samples, 0
    bracket = first_descent(samples, values, series.value)
    if bracket is None:
        return None

    @cache
    def exact(t: float) -> tuple[float, float]:
        force = float(stop_forces_at(system, phase, panel, t)[column])
        return force, series.value_and_slope((t - panel.t) / panel.h)[1] / panel.h

    first, last = (panel.t + panel.h * end for end in bracket)
    near = panel.t + panel.h * polish(series.value_and_slope, *bracket)
    value, slope = exact(near)
    if slope < 0.0 and _MARGIN * abs(value / slope) < min(near - first, last - near):
        return polish(exact, first, last, near)
    while bracket is not None:
        left, right = bracket
        # The interpolant is not resolved as far as the force itself: it may fall too soon.
        while exact(panel.t + panel.h * right)[0] > 0.0:
            start = int(np.searchsorted(samples, right, side="right"))
            if start == len(samples):
                return None
            left, right = right, float(samples[start])
            if values[start] > 0.0:
                break
        else:
            # Nor too late: then it has vanished at an earlier sample already.
            before = int(np.searchsorted(samples, left))
            while before > 0 and exact(panel.t + panel.h * left)[0] <= 0.0:
                before -= 1
                left, right = float(samples[before]), left
            return _polished(panel, (left, right), series, exact)
        bracket = first_descent(samples[start:], values[start:], series.value)
    return None


def _is_nothing(system: System, panel: Panel, stop: Stop, force: FloatArray) -> bool:
    """True if the force of a closed stop is nothing but round-off: bodies that lie on one another.

    They touch without pressing, as two that fall side by side, and stay in contact.
    """
    q, v, a = panel.q[0], panel.v[0], panel.a[0]
    motion = system.shaft.driven_at(panel.t, panel.middle)
    resists = math.sqrt(system.body.mass_matrix(q)[stop.index, stop.index])
    nothing = ACTIVE_SET_ROUND_OFF * resists * force_size(system, motion, q, v, a, stop.index)
    return float(np.abs(force).max()) <= nothing


def _polished(
    panel: Panel,
    bracket: tuple[float, float],
    series: Series,
    exact: Callable[[float], tuple[float, float]],
) -> float:
    """Root in a bracket by the exact function, from that of the series, which costs little."""
    left, right = (panel.t + panel.h * sigma for sigma in bracket)
    near = panel.t + panel.h * polish(series.value_and_slope, *bracket)
    return polish(exact, left, right, min(max(near, left), right))
