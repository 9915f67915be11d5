"""What a run leaves behind: events, motion, and the verdict."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .gauss import Step, values_between

Array = np.ndarray


class Event(NamedTuple):
    """A collision, a rest or a release.

    Attributes:
        kind: "collision", "rest" or "release".
        t: Time from the start [s].
        stops: Stops that it concerns: of a collision those that are struck or receive an impulse.
        before: Rates of the gaps of the stops in contact before it, by name.
        after: The same after it.
        impulses: Along the gaps, by name [N s or N m s].
        lost: Kinetic energy lost at the stops [J].
        closed: Closed stops after it.
    """

    kind: str
    t: float
    stops: tuple[str, ...]
    before: dict[str, float]
    after: dict[str, float]
    impulses: dict[str, float]
    lost: float
    closed: frozenset[str]


class Stretch(NamedTuple):
    """One step with the forces at its nodes."""

    step: Step
    coordinates: Array
    rates: Array
    stops: dict[str, Array]
    drives: dict[str, Array]


@dataclass
class Verdict:
    """The outcome of a run.

    Attributes:
        reason: Empty if it went to its end; else why not (see ``verdict.Refusal``).
        detail: The same in words.
        t: Where it ended [s].
        events: In order of time.
        stretches: Motion in order of time.
        coordinates: Names of the coordinates.
        independence: Least independence of the rows of constraint that was met.
        unresolved: Largest unresolved share of an acceleration in a step.
    """

    reason: str = ""
    detail: str = ""
    t: float = 0.0
    events: list[Event] = field(default_factory=list)
    stretches: list[Stretch] = field(default_factory=list)
    coordinates: tuple[str, ...] = ()
    independence: float = 1.0
    unresolved: float = 0.0

    def _at(self, t: float) -> tuple[Stretch, Array]:
        starts = np.array([item.step.t0 for item in self.stretches])
        item = self.stretches[max(int(np.searchsorted(starts, t, side="right")) - 1, 0)]
        return item, np.array([(t - item.step.t0) / item.step.h])

    def motion(self, t: float) -> tuple[Array, Array]:
        """Coordinates of the joints and their rates at a time."""
        item, sigma = self._at(t)
        return values_between(item.coordinates, sigma)[0], values_between(item.rates, sigma)[0]

    def stop_force(self, name: str, t: float) -> float:
        """Force of a stop along its gap; zero while it is open [N or N m]."""
        item, sigma = self._at(t)
        return float(values_between(item.stops[name], sigma)[0]) if name in item.stops else 0.0

    def drive_force(self, name: str, t: float) -> float:
        """Torque or force of a drive on its coordinate [N m or N]."""
        item, sigma = self._at(t)
        return float(values_between(item.drives[name], sigma)[0])
