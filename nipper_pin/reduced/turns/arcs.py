"""Stretches of a turn along which a stop can be closed while no other is passed.

From the configuration in which turns start, the closed stop is followed along the cylinder until
the gap of another falls through zero: there that one takes over. Stops on the far side of a flight
are found by opening the near one until they close, and followed in the same way.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from ...arrays import FloatArray
from ...dynamics import ShaftMotion, System
from ...errors import SimulationError
from ...mechanism import Mechanism, Stop
from ...tolerances.mechanics import EPS, KNOT_ANGLE
from ..tables.functions import Sampler

TURN = 2.0 * math.pi
# Step along the cylinder [rad], and steps across a flight by the reach of its coordinate.
_STEP, _ACROSS, _CLOSING = math.radians(3.0), 64, 16
_WIDEST = {"revolute": 0.5 * math.pi, "prismatic": 0.25}
_ROOT_STEPS = 40


@dataclass(frozen=True, eq=False)
class ContactArc:
    """A stretch of a turn along which one stop can be closed.

    Attributes:
        begin: Travel from the start of the turn [rad].
        end: Likewise, at most a turn.
        after: The stop that is closed beyond ``end``.
        travels: Travels from ``begin`` to ``end``, counted from ``begin``, shape (W,).
        path: Configurations there with the stop closed, shape (W, nv).
    """

    stop: Stop
    begin: float
    end: float
    after: Stop
    travels: FloatArray
    path: FloatArray


def system_at(mechanism: Mechanism, travel: float, start_angle: float) -> System:
    """The held system whose shaft turns at 1 rad/s, after a travel from an angle."""
    angle = start_angle + mechanism.cylinder.sense * travel
    return System(mechanism, ShaftMotion(mechanism, 1.0, angle))


class ContactContinuation:
    """Follows stops along a turn that starts at an angle of the cylinder."""

    def __init__(self, mechanism: Mechanism, start_angle: float) -> None:
        """Begin without arcs."""
        self._mechanism, self._start = mechanism, start_angle
        self._system = system_at(mechanism, 0.0, start_angle)

    def around(self, stop: Stop, home: FloatArray) -> Iterator[ContactArc]:
        """Follow a stop, and those that take over from it, through one turn.

        Args:
            home: Configuration at the start of the turn with it closed, shape (nv,).

        Raises:
            SimulationError: The stops jam the mechanism, or it cannot be followed.
        """
        first, begin = stop, 0.0
        while begin < TURN * (1.0 - KNOT_ANGLE):
            arc = self._arc(stop, begin, home)
            stop, begin, home = arc.after, arc.end, arc.path[-1]
            # A turn that starts where a stop takes over ends there.
            yield arc if begin < TURN * (1.0 - KNOT_ANGLE) else replace(arc, after=first)

    def opposite(self, stop: Stop, home: FloatArray) -> tuple[Stop, FloatArray] | None:
        """The stop that ends a flight from another one at the start of a turn, closed."""
        sampler = Sampler(self._system, stop, home)
        kind = self._mechanism.joints[stop.index].kind
        x = np.linspace(0.0, _WIDEST[kind], _ACROSS + 1)[1:, None]
        with suppress(SimulationError):
            for (q,) in sampler.along(np.zeros(1), x, home[None]):
                for other in self._mechanism.stops:
                    if other.name != stop.name and other.gap(q) <= 0.0:
                        return other, Sampler(self._system, other, q).closed(0.0, q)[0]
        return None

    def closing(self, stop: Stop, q: FloatArray) -> FloatArray:
        """The configuration at the start of a turn in which an open stop has been closed."""
        x = np.linspace(stop.gap(q), 0.0, _CLOSING + 1)[1:, None]
        *_, (row,) = Sampler(self._system, stop, q).along(np.zeros(1), x, q[None])
        return np.asarray(row)

    def _arc(self, stop: Stop, begin: float, home: FloatArray) -> ContactArc:
        system = system_at(self._mechanism, begin, self._start)
        sampler = Sampler(system, stop, home)
        end = min(begin + self._system.shaft.smooth_for(begin), TURN)
        others = [item for item in self._mechanism.stops if item.name != stop.name]
        count = max(1, math.ceil((end - begin) / _STEP))
        travels, path, after = [0.0], [home], stop
        (old,) = sampler.rates(np.zeros(1), home[None])[1]
        opened = {other.name for other in others if other.rate(old) > 0.0 or other.gap(home) > 0.0}
        for travel in np.linspace(0.0, end - begin, count + 1)[1:].tolist():
            low, before = travels[-1], path[-1]
            row, new = sampler.closed(travel, before)
            # Where each stop has closed, or the lowest place of its gap may be beyond it.
            corners = [
                (*found, other)
                for other in others
                if (other.gap(row) < 0.0 or other.rate(old) < 0.0 <= other.rate(new))
                and (found := _corner(sampler, other, low, travel, before)) is not None
            ]
            if any(other.name not in opened and low == 0.0 for *_, other in corners):
                names = ", ".join(repr(other.name) for *_, other in corners)
                message = f"stop {stop.name!r} cannot stay closed beside {names}: they jam"
                raise SimulationError(message, stop=stop.name)
            if corners:
                travel, row, after = min(corners, key=lambda corner: corner[0])
                row[after.index] = after.at
                end = begin + travel
            travels.append(travel)
            path.append(row)
            old = new
            if corners:
                break
        return ContactArc(stop, begin, end, after, np.array(travels), np.array(path))


def _corner(
    sampler: Sampler, other: Stop, low: float, high: float, before: FloatArray
) -> tuple[float, FloatArray] | None:
    """Where the gap of another stop falls through zero between two travels, by Newton's method.

    Args:
        before: Configuration at ``low``, shape (nv,).

    Returns:
        The travel, and the configuration there, shape (nv,); None if the gap is above zero at
        ``high`` and, between, where it is least.
    """
    travel, below = high, False
    for _ in range(_ROOT_STEPS):
        row, m = sampler.closed(travel, before)
        gap, rate = other.gap(row), other.rate(m)
        below |= gap <= -4.0 * EPS * travel * rate
        # Ahead of a place at or below zero, or of the lowest one.
        ahead = gap > 0.0 and (below or rate < 0.0)
        low, high = (travel, high) if ahead else (low, travel)
        new = travel - gap / rate if rate < 0.0 else math.nan
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - travel) <= 4.0 * EPS * travel or gap == 0.0:
            break
        travel = new
    return (travel, row) if below else None
