"""The end of an infinite series of bounces.

At a stop with restitution e < 1 that is pressed on, rebound rates w_0, w_1, ... fall like e^n and
the collision times t_0, t_1, ... converge. Near the limit the motion is smooth in time, gap and
rate, so the time of a collision is a smooth function of its rebound rate,
t = t_rest + c_1 w + c_2 w^2 + ...; each collision is a point on it, t_rest its value at w = 0.
Its slope there is known, too: a flight lasts 2 w / alpha in the limit, alpha being the
deceleration at rest, and the next rate is e w, so c_1 = -2 / (alpha (1 - e)); alpha(w) is another
smooth function with a known value at every collision.

Neville's scheme extrapolates alpha and t; the polynomial through the points is then turned to the
known slope. The error of m points shrinks like the product of their rates, e^(m (m - 1) / 2), and
the slope is worth one or two more, so a few bounces are enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from math import inf

_MOST_POINTS = 8
# The difference of two orders shows the error of the higher one up to a factor, unless it changes
# its sign just there: then a part of the difference before stands for it.
_SAFETY, _PART = 4.0, 0.015
# More of it where the deceleration was another one: by this times its relative change.
_CHANGED = 0.12
# Collisions with more than this part of the fastest rate are too far away to improve the limit, and
# the little that they change says nothing about its error.
_FAR = 0.5
# Nor do collisions where the deceleration was another one altogether: a polynomial through them
# seems to converge, to the wrong limit.
_SETTLED = 0.75


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
    """

    stop: str
    start: float
    fastest: float = 0.0
    times: tuple[float, ...] = field(default=())
    rates: tuple[float, ...] = field(default=())
    decelerations: tuple[float, ...] = field(default=())

    def bounced(self, t: float, rate: float, deceleration: float) -> BounceSeries:
        """Return the series with one more collision."""
        return BounceSeries(
            self.stop,
            self.start,
            max(self.fastest, rate),
            (*self.times, t)[-_MOST_POINTS:],
            (*self.rates, rate)[-_MOST_POINTS:],
            (*self.decelerations, deceleration)[-_MOST_POINTS:],
        )

    def anew(self) -> BounceSeries:
        """Return the series without its collisions: beyond a knot they tell nothing of it."""
        return BounceSeries(self.stop, self.start, self.fastest)

    def limit(self, e_N: float) -> tuple[float, float]:
        """Extrapolate to rest.

        Args:
            e_N: Restitution of the stop.

        Returns:
            Time of rest [s] and an estimate of its error [s]; both infinite while three collisions
            do not show the rates falling, or if nothing presses the stop shut.
        """
        w = self.rates
        if e_N >= 1.0 or len(w) < 3 or any(near >= far for far, near in pairwise(w)):
            return inf, inf
        last = self.times[-1]
        # Times are taken from the last collision, where the digits matter.
        lines = extrapolated(w, [t - last for t in self.times])
        pressing = extrapolated(w, self.decelerations)
        best = (inf, inf)
        previous, change, inverse_rates = inf, 0.0, 0.0
        points = zip(reversed(w), reversed(self.decelerations), lines, pressing, strict=True)
        for rate, own, (value, slope), (alpha, _) in points:
            inverse_rates += 1.0 / rate
            if alpha <= 0.0 or (rate > _FAR * self.fastest and best[1] < inf):
                break
            unlike = abs(own / self.decelerations[-1] - 1.0)
            if unlike > _SETTLED:
                break
            # Adding a multiple of the product of (w - w_k) changes the slope, not the points.
            found = value + (slope + 2.0 / (alpha * (1.0 - e_N))) / inverse_rates
            before, change = change, abs(found - previous)
            previous = found
            error = _SAFETY * max(change, max(_PART, _CHANGED * unlike) * before)
            if error < best[1]:
                best = (last + found, error)
        return best


def extrapolated(w: Sequence[float], y: Sequence[float]) -> list[tuple[float, float]]:
    """Value and slope at w = 0 of the polynomials through the last 1, 2, ... points."""
    values, slopes = list(y), [0.0] * len(y)
    found = [(values[-1], 0.0)]
    for order in range(1, len(w)):
        pairs = list(zip(w, w[order:], strict=False))
        slopes = [
            (values[i] - values[i + 1] + far * slopes[i + 1] - near * slopes[i]) / (far - near)
            for i, (far, near) in enumerate(pairs)
        ]
        values = [
            (far * values[i + 1] - near * values[i]) / (far - near)
            for i, (far, near) in enumerate(pairs)
        ]
        found.append((values[-1], slopes[-1]))
    return found
