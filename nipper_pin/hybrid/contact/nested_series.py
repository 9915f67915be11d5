"""The end of a series of bounces that holds series itself.

Two stops at rest can throw each other open: a collision at one opens the other, which bounces,
comes to rest at the limit of its own series, and the first one, falling back, throws it open again.
Each such collision finds all the other stops at rest, so the rate w at which it comes is all there
is to say about the state, and a smaller one only makes what follows slower and shorter: the time of
such a collision is a smooth function of its rate, t = t_rest + c_1 w + c_2 w^2 + ... t_rest is the
value of the polynomial through the last collisions at w = 0. The slope is not known beforehand
here, unlike that of a single series (:mod:`.series`), as it holds the inner series.

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

from ...tolerances.hybrid import NEARLY_GEOMETRIC, NESTED_ERROR_PART, NESTED_ERROR_SAFETY
from ...tolerances.mechanics import EPS

_MOST_POINTS = 8


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
        times, rates = (*self.times, t)[-_MOST_POINTS:], (*self.rates, rate)[-_MOST_POINTS:]
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
