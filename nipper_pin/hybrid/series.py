"""The end of an infinite series of bounces.

At a stop with restitution e < 1 that is pressed on, rebound rates w_0, w_1, ... fall like e^n and
the collision times t_0, t_1, ... converge. Near the limit the motion is smooth in time, gap and
rate, so the time of a collision is a smooth function of its rebound rate,
t = t_rest + c_1 w + c_2 w^2 + ...; each collision is a point on it, t_rest its value at w = 0.
Neville's scheme extrapolates there; the error of m points shrinks like the product of their rates,
e^(m (m - 1) / 2), so a few bounces are enough.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from math import inf

_MOST_POINTS = 8


@dataclass(frozen=True)
class BounceSeries:
    """Consecutive collisions of one stop, undisturbed by others.

    Attributes:
        stop: Name of the stop.
        start: Time of the first collision [s].
        fastest: Fastest rebound rate of the series.
        times: Times of the collisions [s].
        rates: Rebound rates of its coordinate, positive [rad/s or m/s].
    """

    stop: str
    start: float
    fastest: float = 0.0
    times: tuple[float, ...] = field(default=())
    rates: tuple[float, ...] = field(default=())

    def bounced(self, t: float, rate: float) -> BounceSeries:
        """Return the series with one more collision."""
        return BounceSeries(
            self.stop,
            self.start,
            max(self.fastest, rate),
            (*self.times, t)[-_MOST_POINTS:],
            (*self.rates, rate)[-_MOST_POINTS:],
        )

    def limit(self) -> tuple[float, float]:
        """Extrapolate to rest.

        Returns:
            Time of rest [s] and an estimate of its error [s]; both infinite while two collisions
            do not show the rates falling.
        """
        w = self.rates
        if len(w) < 2 or any(near >= far for far, near in pairwise(w)):
            return inf, inf
        last = self.times[-1]
        # Times are taken from the last collision, where the digits matter.
        column = [t - last for t in self.times]
        best = (inf, inf)
        previous = column[-1]
        for order in range(1, len(w)):
            column = [
                (far * later - near * earlier) / (far - near)
                for far, near, earlier, later in zip(w, w[order:], column, column[1:], strict=False)
            ]
            error = abs(column[-1] - previous)
            previous = column[-1]
            if error < best[1]:
                best = (last + column[-1], error)
        return best
