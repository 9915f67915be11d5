"""What is simulated: one immutable case, validated when it is made."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

from ..dynamics.system import DriveMode
from ..errors import InputError
from ..tolerances.hybrid import LARGEST_TOLERANCE, LEAST_TOLERANCE

# Faster ones overflow in squares of rates long before they mean anything.
_FASTEST_RPM = 1e9
# Days of a machine; their events would fill the memory.
_MOST_CYCLES = 1_000_000
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
        integrator: Name of the integrator of motion with freedom.

    Raises:
        InputError: A value is out of range.
    """

    tolerance: float = 1e-12
    flight_nodes: int = 13
    kinematic_nodes: int = 24
    panels_per_turn: int = 12
    adaptive: bool = True
    integrator: str = "picard"

    def __post_init__(self) -> None:
        """Validate."""
        allowed = LEAST_TOLERANCE <= self.tolerance <= LARGEST_TOLERANCE
        _require(allowed, "tolerance", self.tolerance, "1e-14 to 1e-3")
        for key in ("flight_nodes", "kinematic_nodes"):
            _require(3 <= getattr(self, key) <= 64, key, getattr(self, key), "3 to 64")
        _require(self.panels_per_turn >= 1, "panels_per_turn", self.panels_per_turn, "at least 1")


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
        _require(0.0 < self.speed_rpm <= _FASTEST_RPM, "speed_rpm", self.speed_rpm,
                 f"a speed above 0 and up to {_FASTEST_RPM:g} r/min")  # fmt: skip
        _require(1 <= self.cycles <= _MOST_CYCLES, "cycles", self.cycles,
                 f"a whole number from 1 to {_MOST_CYCLES}")  # fmt: skip
        _require(math.isfinite(self.start_index), "start_index", self.start_index, "a number")
        _require(self.max_collisions >= 1, "max_collisions", self.max_collisions, "at least 1")
        if self.rest_rate is not None:
            _require(math.isfinite(self.rest_rate) and self.rest_rate > 0.0, "rest_rate",
                     self.rest_rate, "a finite rate above 0, or none for the limit")  # fmt: skip


def _require(right: bool, key: str, value: object, allowed: str) -> None:
    if not right:
        message = f"case: {key} = {value!r} cannot be used: {allowed}"
        raise InputError(message, key=key, value=value, allowed=allowed)
