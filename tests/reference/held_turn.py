"""A turn of the planar nipper in 80-bit arithmetic, with what holds its jaw shut.

The events are those of ``extended.py``; the force at the lips follows from the equation of motion
of ``planar.py`` along the closed jaw. Nothing here is shared with the package.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from events import JAW, STEEVE
from extended import COLLISION, RELEASE, REST, Happening, L, Solution

# Places along a stretch, and within a bracket that is narrowed.
_PLACES, _WITHIN = 2001, 65


class HeldTurn:
    """One turn from the foremost position, jaw open and steeve on its stop.

    Args:
        changes: parameters (names of ``planar.PARAMETERS``) that differ, as decimals.

    Attributes:
        events: as of ``extended.cycle``.
        holds: the phases in which the jaw was closed.
    """

    def __init__(self, changes: dict[str, str]) -> None:
        self.run = Solution(changes, foremost=True)
        self.run.follow(STEEVE, L(0))
        self.holds = [phase for phase in self.run.trace.phases if phase.closed == JAW]

    @property
    def events(self) -> list[Happening]:
        """What happened."""
        return self.run.events

    def force(self, times: Any) -> Any:
        """Force at the lips while the jaw is closed, N."""
        return self.run.held(JAW, times)[1][0] / self.run.machine.lever

    def extremes(self) -> tuple[Any, Any] | None:
        """Least and largest force at the lips, N; None where the jaw is never held."""
        held = [phase for phase in self.holds if phase.force_min is not None]
        if not held:
            return None
        lever = self.run.machine.lever
        least, most = min(hold.force_min for hold in held), max(hold.force_max for hold in held)
        return least / lever, most / lever

    def clamped(self, level: Any) -> Any:
        """Time with the jaw closed and its force above a level, s."""
        total = L(0)
        for hold in self.holds:
            times = np.linspace(hold.start, hold.end, _PLACES, dtype=L)
            above = self.force(times) >= level
            corners = [hold.start]
            for i in np.flatnonzero(above[1:] != above[:-1]):
                corners.append(self._passes(times[i], times[i + 1], level, bool(above[i + 1])))
            corners.append(hold.end)
            first = 0 if above[0] else 1
            total += sum(
                (corners[i + 1] - corners[i] for i in range(first, len(corners) - 1, 2)), L(0)
            )
        return total

    def _passes(self, low: Any, high: Any, level: Any, rising: bool) -> Any:
        """Time at which the force passes a level in a bracket."""
        for _ in range(12):
            times = np.linspace(low, high, _WITHIN, dtype=L)
            beyond = (self.force(times) >= level) == rising
            place = int(np.argmax(beyond))
            if place == 0:
                return times[0]
            low, high = times[place - 1], times[place]
        return (low + high) / 2

    def energy_lost(self) -> Any:
        """Kinetic energy lost in all collisions, J."""
        total = L(0)
        for hit in self.events:
            if hit.kind == COLLISION:
                total -= hit.impulse * (1 - self.run.restitution(hit.stop)) * hit.approach / 2
        return total

    def impulse_sum(self, stop: str) -> Any:
        """Sum of impulses at a stop, with those of each series beyond the last that is known."""
        total, e = L(0), self.run.restitution(stop)
        last = L(0)
        for event in self.events:
            if event.stop != stop:
                continue
            if event.kind == COLLISION:
                last = event.impulse
                total += last
            elif event.kind == REST:
                total += last * e / (1 - e)
        return total


def quantities(turn: HeldTurn, share: float) -> dict[str, Any]:
    """What can be asked about a turn; times in s, forces in N, impulses along the joint.

    Args:
        turn: the turn.
        share: the jaw clamps above this share of the range of its force.
    """
    jaw = [event for event in turn.events if event.stop == JAW]
    extremes = turn.extremes()
    level = 0.0
    if extremes is not None and share > 0.0:
        level = float(extremes[0] + L(share) * (extremes[1] - extremes[0]))
    heights = [event.amplitude for event in jaw if event.amplitude is not None]

    def first(found: list[Any]) -> Any:
        return found[0] if found else None

    return {
        "level": level,
        "closed_at": first([event.time for event in jaw if event.kind == COLLISION]),
        "rests_at": first([event.time for event in jaw if event.kind == REST]),
        "lost_at": first([hold.end for hold in turn.holds if hold.ended_by == RELEASE]),
        "opened_at": first([hold.end for hold in turn.holds if hold.ended_by == STEEVE]),
        "clamped": turn.clamped(L(level)),
        "least_force": None if extremes is None else extremes[0],
        "most_force": None if extremes is None else extremes[1],
        "largest_gap": max(heights, default=None),
        "energy_lost": turn.energy_lost(),
        **{f"impulse_sum_{stop}": turn.impulse_sum(stop) for stop in (JAW, STEEVE)},
        **{
            f"largest_impulse_{stop}": max(
                (hit.impulse for hit in turn.events if (hit.kind, hit.stop) == (COLLISION, stop)),
                default=L(0),
            )
            for stop in (JAW, STEEVE)
        },
    }
