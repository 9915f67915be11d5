"""What a run leaves behind: events, motion, and the verdict."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .gauss import Step

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
    """One step, with the state in which it starts and its closed stops."""

    step: Step
    q: Array
    v: Array
    closed: frozenset[str]


class Sample(NamedTuple):
    """Coordinates, their rates, forces of closed stops and of drives at one time."""

    coordinates: Array
    rates: Array
    stops: dict[str, float]
    drives: dict[str, float]


@dataclass
class Verdict:
    """The outcome of a run.

    Attributes:
        reason: Empty if it went to its end; else why not (see ``verdict.Refusal``).
        detail: The same in words.
        t: Where it ended [s].
        known: Until when it is worth comparing; infinite to the end [s].
        events: In order of time.
        stretches: Motion in order of time.
        coordinates: Names of the coordinates.
        independence: Least independence of the rows of constraint that was met.
        unresolved: Largest unresolved share of an acceleration in a step.
        sampler: What goes through a step again, to a time in it.
    """

    reason: str = ""
    detail: str = ""
    t: float = 0.0
    known: float = math.inf
    events: list[Event] = field(default_factory=list)
    stretches: list[Stretch] = field(default_factory=list)
    coordinates: tuple[str, ...] = ()
    independence: float = 1.0
    unresolved: float = 0.0
    sampler: Callable[[Stretch, float], Sample] = field(default=None, repr=False)  # type: ignore[assignment]
    _samples: dict[float, Sample] = field(default_factory=dict, repr=False)

    def sample(self, t: float) -> Sample:
        """Motion and forces at a time [s]."""
        if t not in self._samples:
            starts = np.array([item.step.t0 for item in self.stretches])
            place = max(int(np.searchsorted(starts, t, side="right")) - 1, 0)
            self._samples[t] = self.sampler(self.stretches[place], t)
        return self._samples[t]

    def motion(self, t: float) -> tuple[Array, Array]:
        """Coordinates of the joints and their rates at a time."""
        found = self.sample(t)
        return found.coordinates, found.rates

    def stop_force(self, name: str, t: float) -> float:
        """Force of a stop along its gap; zero while it is open [N or N m]."""
        return self.sample(t).stops.get(name, 0.0)

    def drive_force(self, name: str, t: float) -> float:
        """Torque or force of a drive on its coordinate [N m or N]."""
        return self.sample(t).drives[name]
