"""What is simulated: one immutable case, validated when it is made."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

from ..dynamics import DriveMode
from ..errors import InputError
from ..given import LARGEST, flag, number, refuse, whole
from ..tolerances.hybrid import LARGEST_TOLERANCE, LEAST_TOLERANCE

# Faster ones overflow in squares of rates long before they mean anything.
FASTEST_RPM = 1e9
"""Largest speed of a case [r/min]."""
# Days of a machine; their events would fill the memory.
_MOST_CYCLES = 1_000_000
_MOST_EVENTS = 1_000_000_000
# Shorter ones than by a turn and this are below the shortest of all.
_MOST_PANELS = 1_000_000
# Turns away, where an index still has ten digits of a turn.
_FAR = 1e6
_CASE = "case"
START_INDEX = 24.0
"""Index at which turns start unless it is given."""


class Window(StrEnum):
    """The stretch of motion that is simulated."""

    TRANSITION = "transition"
    """From the first collision in the touch configuration to the rest of the transition stop."""
    CYCLE = "cycle"
    """Whole turns of the cylinder."""


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """How finely a motion is resolved.

    Attributes:
        tolerance: Relative accuracy of positions and event times.
        flight_nodes: Collocation nodes of a panel with freedom; with 4 n + 1 of them, iteration
            starts on coarser grids that are nested in this one.
        kinematic_nodes: Collocation nodes of a panel without freedom.
        panels_per_turn: Longest panel with freedom, as a fraction of a turn; without it the first
            panel of a phase may have 2.5 times its length, and those after it 3.1 times.
        adaptive: Halve panels that the nodes do not resolve. Without it the error falls with the
            panel length by the order of the method, which is how that order is measured.

    Raises:
        InputError: A value is out of range.
    """

    tolerance: float = 1e-12
    flight_nodes: int = 13
    kinematic_nodes: int = 24
    panels_per_turn: int = 12
    adaptive: bool = True

    def __post_init__(self) -> None:
        """Validate and normalise."""
        bounds = LEAST_TOLERANCE, LARGEST_TOLERANCE
        tolerance = number(
            "tolerance", self.tolerance, *bounds, allowed="1e-14 to 1e-3", where=_CASE
        )
        adaptive = flag("adaptive", self.adaptive, where=_CASE)
        values = {"tolerance": tolerance, "adaptive": adaptive}
        for key in ("flight_nodes", "kinematic_nodes"):
            values[key] = whole(key, getattr(self, key), 3, 64, where=_CASE)
        values["panels_per_turn"] = whole(
            "panels_per_turn", self.panels_per_turn, 1, _MOST_PANELS, where=_CASE
        )
        _normalise(self, values)


@dataclass(frozen=True, kw_only=True)
class Case:
    """One simulation of a mechanism.

    Attributes:
        speed_rpm: Cylinder speed [r/min].
        window: Transition or cycle.
        cycles: Number of turns (window "cycle").
        start_index: Index at which the turns start; the mechanism is in its initial phase there.
        drive: Held or inertial shafts.
        rest_rate: None: a series of bounces ends at its limit. A number: a stop comes to rest at
            the first rebound slower than this, in the unit of its coordinate [rad/s or m/s].
        resolution: How finely the motion is resolved.
        reuse_cycles: Copy a cycle that must repeat exactly instead of computing it again.
        max_collisions: Collisions in one turn (or transition) after which the run stops.

    Raises:
        InputError: A value is out of range.
    """

    speed_rpm: float
    window: Window = Window.TRANSITION
    cycles: int = 1
    start_index: float = START_INDEX
    drive: DriveMode = DriveMode.HELD
    rest_rate: float | None = None
    resolution: Resolution = field(default_factory=Resolution)
    reuse_cycles: bool = True
    max_collisions: int = 10_000

    def __post_init__(self) -> None:
        """Validate and normalise."""
        try:
            object.__setattr__(self, "window", Window(self.window))
            object.__setattr__(self, "drive", DriveMode(self.drive))
        except ValueError as error:
            message = f"{error}; windows: transition, cycle; drives: held, inertial"
            raise InputError(message, window=self.window, drive=self.drive) from error
        speed = number("speed_rpm", self.speed_rpm, 0.0, FASTEST_RPM, open_low=True, where=_CASE,
                       allowed=f"a speed above 0 and up to {FASTEST_RPM:g} r/min")  # fmt: skip
        rate = self.rest_rate
        if rate is not None:
            allowed = "a finite rate above 0, or none for the limit"
            rate = number(
                "rest_rate", rate, 0.0, LARGEST, open_low=True, allowed=allowed, where=_CASE
            )
        if not isinstance(self.resolution, Resolution):
            refuse("resolution", self.resolution, "a Resolution, as Resolution()", _CASE)
        values = {
            "speed_rpm": speed,
            "cycles": whole("cycles", self.cycles, 1, _MOST_CYCLES, where=_CASE),
            "start_index": number("start_index", self.start_index, -_FAR, _FAR, where=_CASE),
            "rest_rate": rate,
            "reuse_cycles": flag("reuse_cycles", self.reuse_cycles, where=_CASE),
            "max_collisions": whole(
                "max_collisions", self.max_collisions, 1, _MOST_EVENTS, where=_CASE
            ),
        }
        _normalise(self, values)


def _normalise(made: Case | Resolution, values: dict[str, Any]) -> None:
    """Write checked values, numbers of numpy as those of Python."""
    for key, value in values.items():
        object.__setattr__(made, key, value)
