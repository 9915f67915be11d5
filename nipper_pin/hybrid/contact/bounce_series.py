"""The end of an infinite series of bounces.

At a stop with restitution e < 1 that is pressed on, rebound rates w_0, w_1, ... fall like e^n and
the collision times t_0, t_1, ... converge. Near the limit the motion is smooth in time, gap and
rate, so that all collisions lie on one smooth curve w(t), which ends in w(t_rest) = 0. Its slope
is known there, too: a flight lasts 2 w / alpha in the limit, alpha being the deceleration at rest,
and the next rate is e w, so w'(t_rest) = -(1 - e) alpha / 2; alpha(t) is another smooth function
with a known value at every collision.

Newton's polynomials through the last collisions give w and alpha; that of w is turned to the known
slope where it vanishes, which is t_rest. The error of m points shrinks like the product of their
distances from t_rest, e^(m (m - 1) / 2), and the slope is worth one or two more, so a few bounces
are enough. The inverse, t as a function of w, is smooth only up to where alpha vanishes: of a stop
that is pressed on little its polynomials agree with each other and not with the limit.

A series may hold series itself. Two stops at rest can throw each other open: a collision at one
opens the other, which bounces, comes to rest at the limit of its own series, and the first one,
falling back, throws it open again. Each such collision finds all the other stops at rest, so the
rate w at which it comes is all there is to say about the state, and a smaller one only makes what
follows slower and shorter: the time of such a collision is a smooth function of its rate, t =
t_rest + c_1 w + c_2 w^2 + ... t_rest is the value of the polynomial through the last collisions at
w = 0. The slope is not known beforehand here, unlike that of a single series, as it holds the inner
series.

The rates fall by a factor of their own, not by a restitution, and slowly where the stops hardly
yield to one another. That the rests of the inner series are themselves limits costs nothing but
their errors. Nesting may go deeper: what comes to rest together is one inner series of a third.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import inf

import numpy as np

from ...tolerances.hybrid import (
    NEARLY_GEOMETRIC,
    NESTED_ERROR_PART,
    NESTED_ERROR_SAFETY,
    SERIES_EARLIER,
    SERIES_LIMIT_STEP,
    SERIES_PACE,
    SERIES_PART,
    SERIES_SAFETY,
    SETTLED_DECELERATION,
    TIME_ROUND_OFF,
)
from ...tolerances.mechanics import EPS

_MOST_POINTS = 8
# Collisions with more than this part of the fastest rate are too far away to improve the limit, and
# the little that they change says nothing about its error.
_FAR = 0.5
# By how much the rates of the collisions that are kept should differ, if the earliest is dropped.
_SPAN = 2.0
_MOST_STEPS = 12


@dataclass(frozen=True)
class BounceSeries:
    """Consecutive collisions of one stop, undisturbed by others.

    Attributes:
        stop: Name of the stop.
        start: Time of the first collision [s].
        fastest: Largest rebound rate [rad/s or m/s].
        times: Times of the collisions [s].
        rates: Rebound rates of its coordinate, positive [rad/s or m/s].
        decelerations: At the start of the flights after them, positive [rad/s^2 or m/s^2].
        count: Number of collisions, with those that are no longer kept.
    """

    stop: str
    start: float
    fastest: float = 0.0
    times: tuple[float, ...] = field(default=())
    rates: tuple[float, ...] = field(default=())
    decelerations: tuple[float, ...] = field(default=())
    count: int = 0

    def bounced(self, t: float, rate: float, deceleration: float) -> BounceSeries:
        """Return the series with one more collision."""
        times, rates = (*self.times, t), (*self.rates, rate)
        decelerations = (*self.decelerations, deceleration)
        if len(times) > _MOST_POINTS:
            left = _left_out(times, rates)
            times, rates, decelerations = (
                item[:left] + item[left + 1 :] for item in (times, rates, decelerations)
            )
        return BounceSeries(
            self.stop, self.start, max(self.fastest, rate), times, rates, decelerations,
            self.count + 1,
        )  # fmt: skip

    @property
    def uneven(self) -> float:
        """By how much the last flight differs from one at a constant deceleration, relative.

        In its length, or between its ends; infinite before there is one.
        """
        if len(self.times) < 2 or self.decelerations[-1] <= 0.0:
            return inf
        far, near = self.decelerations[-2:]
        length = 0.5 * (self.times[-1] - self.times[-2]) * near / self.rates[-2]
        return max(abs(length - 1.0), abs(far / near - 1.0))

    def anew(self) -> BounceSeries:
        """Return the series without its collisions: beyond a knot they tell nothing of it."""
        return BounceSeries(self.stop, self.start, self.fastest, count=self.count)

    def limit(self, e_N: float) -> tuple[float, float]:
        """Extrapolate to rest.

        Returns:
            Time of rest [s] and an estimate of its error [s]; both infinite while three collisions
            do not show the rates falling, or if nothing presses the stop shut.
        """
        w = self.rates
        falling = len(w) >= 3 and all(near < far for far, near in pairwise(w))
        if e_N >= 1.0 or not falling or self.decelerations[-1] <= 0.0:
            return inf, inf
        # Times are taken from the last collision, where the digits matter.
        last = self.times[-1]
        ends = self._ends([t - last for t in reversed(self.times)], 0.5 * (1.0 - e_N))
        changes = [abs(end - before) for before, end in pairwise(ends)]
        best, least = (inf, inf), inf
        for order in range(2, len(ends)):
            shown = max(SERIES_SAFETY * changes[order - 1], SERIES_PART * changes[order - 2])
            if shown < least:
                least = shown
                best = (last + ends[order], max(shown, _later(changes, order)))
        return best

    def _ends(self, times: list[float], half: float) -> list[float]:
        """Limits by the last 1, 2, ... collisions, as many as belong to one smooth curve.

        Args:
            times: Times of the collisions, the last one first.
            half: (1 - e) / 2.
        """
        rates = divided(times, self.rates[::-1])
        pressing = divided(times, self.decelerations[::-1])
        nearest = self.decelerations[-1]
        end = self.rates[-1] / (half * nearest)
        ends = [end]
        far = zip(self.rates[-2::-1], self.decelerations[-2::-1], strict=True)
        for count, (rate, deceleration) in enumerate(far, start=2):
            if rate > _FAR * self.fastest and count > 3:
                break
            if abs(deceleration / nearest - 1.0) > SETTLED_DECELERATION:
                break
            end = _root(times[:count], rates, pressing, half, end)
            if not end > 0.0:
                break
            ends.append(end)
        return ends


def _left_out(times: Sequence[float], rates: Sequence[float]) -> int:
    """Place of the collision that tells least of the limit."""
    if rates[1] >= _SPAN * rates[-1]:
        return 0
    # Collisions that lose little lie close beside the time that is left: a few that are far apart
    # tell more than all the last ones.
    return min(range(1, len(times) - 2), key=lambda place: times[place + 1] - times[place - 1])


def _later(changes: Sequence[float], order: int) -> float:
    """Error of an order, estimated from the differences before and after it."""
    # No order is better than what the next one changes.
    found = max(changes[order : order + 1], default=0.0)
    if order > 2 and changes[order - 3] > 0.0:
        earlier, before, last = changes[order - 3 : order]
        pace = SERIES_PACE * max(before * before / earlier, last)
        found = max(found, min(SERIES_EARLIER * earlier, pace))
    return found


def divided(x: Sequence[float], y: Sequence[float]) -> list[float]:
    """Divided differences y[x_0], y[x_0, x_1], ...: the coefficients of Newton's polynomials."""
    found = list(y)
    for order in range(1, len(x)):
        for i in range(len(x) - 1, order - 1, -1):
            found[i] = (found[i] - found[i - 1]) / (x[i] - x[i - order])
    return found


def _root(
    x: Sequence[float], rates: Sequence[float], pressing: Sequence[float], half: float, near: float
) -> float:
    """Root of the polynomial of rates, with the slope that follows from the deceleration there.

    Args:
        x: Times of the collisions, the last one first.
        rates: Divided differences of the rates.
        pressing: Divided differences of the decelerations.
        half: (1 - e) / 2.
        near: A time to start with.

    Returns:
        The time; -1 if nothing presses the stop shut there, or none was found.
    """
    t = near
    for _ in range(_MOST_STEPS):
        value = slope = alpha = inverse = 0.0
        for place in range(len(x) - 1, -1, -1):
            past = t - x[place]
            slope = slope * past + value
            value = value * past + rates[place]
            alpha = alpha * past + pressing[place]
            inverse += 1.0 / past
        if alpha <= 0.0:
            break
        # Adding a multiple of the product of (t - t_k) changes the slope, not the points.
        step = (value - (slope + half * alpha) / inverse) / (half * alpha)
        t += step
        if not 0.0 < t < inf:
            break
        if abs(step) <= SERIES_LIMIT_STEP * abs(t - near) + TIME_ROUND_OFF * t:
            return t
    return -1.0


_MOST_NESTED = 8


@dataclass(frozen=True)
class NestedSeries:
    """Collisions of one stop that find the same stops at rest and throw some of them open.

    Attributes:
        start: Time of the first collision [s].
        fastest: Its approach rate [rad/s or m/s].
        times: Times of the last collisions [s].
        rates: Approach rates, positive and falling [rad/s or m/s].
        first: Number of the event that was the first collision.
        events: Number of all events since then, those of series inside among them.
    """

    start: float = 0.0
    fastest: float = 0.0
    times: tuple[float, ...] = field(default=())
    rates: tuple[float, ...] = field(default=())
    first: int = 0
    events: int = 0

    def struck(self, t: float, rate: float, number: int = 0) -> NestedSeries:
        """Return the series with one more collision, an event; a faster one starts it anew."""
        if not self.rates or rate >= self.rates[-1]:
            return NestedSeries(t, rate, (t,), (rate,), number)
        times, rates = (*self.times, t)[-_MOST_NESTED:], (*self.rates, rate)[-_MOST_NESTED:]
        return replace(self, times=times, rates=rates, events=number - self.first)

    def limit(self) -> tuple[float, float]:
        """Extrapolate to rest.

        Returns:
            Time of rest [s] and an estimate of its error [s]; both infinite while the collisions
            do not show it.
        """
        if len(self.rates) < 4:
            return inf, inf
        last = self.times[-1]
        values = _extrapolated(self.rates, [t - last for t in self.times])
        best = (inf, inf)
        change = inf
        for count, (lower, higher) in enumerate(pairwise(values), start=2):
            before, change = change, abs(higher - lower)
            noise = EPS * abs(last) * _amplified(self.rates[-count:])
            error = NESTED_ERROR_SAFETY * max(change, NESTED_ERROR_PART * before) + noise
            if error < best[1]:
                best = (higher, error)
        far, near = self.rates[-2:]
        geometric = (last - self.times[-2]) * near / (far - near)
        if not abs(best[0] - geometric) <= NEARLY_GEOMETRIC * geometric:
            return inf, inf
        return last + best[0], best[1]


def _extrapolated(w: Sequence[float], y: Sequence[float]) -> list[float]:
    """Values at w = 0 of the polynomials through the last 1, 2, ... points: Neville's scheme."""
    values = list(y)
    found = [values[-1]]
    for order in range(1, len(w)):
        pairs = zip(w, w[order:], strict=False)
        values = [
            (far * values[i + 1] - near * values[i]) / (far - near)
            for i, (far, near) in enumerate(pairs)
        ]
        found.append(values[-1])
    return found


def _amplified(rates: Sequence[float]) -> float:
    """Largest factor by which an extrapolation to rate zero multiplies errors of the times."""
    points = np.array(rates)
    apart = points[:, None] - points
    np.fill_diagonal(apart, 1.0)
    factors = np.repeat(points[None], len(points), axis=0)
    np.fill_diagonal(factors, 1.0)
    return float(np.abs((factors / apart).prod(axis=1)).sum())
