"""The interface of a peer, and the bookkeeping of those with an event loop in Python.

The scene is one transition: from the first collision, in the touch configuration with the steeve
on its stop, to rest of the jaw. Unless a peer says otherwise rest is the limit of the bounces.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from math import isfinite
from typing import Protocol, cast

from nipper_pin.errors import SimulationError
from nipper_pin.hybrid.contact.bounce_series import BounceSeries
from nipper_pin.mechanism import Mechanism

MODULES = ("rk4", "scipy_ivp", "scipy_pinocchio", "fixed_steps", "mujoco_shell")
MOST_COLLISIONS = 60


@dataclass(frozen=True)
class Four:
    """The four numbers that a peer is graded by; the amplitude is that of the jaw angle [rad].

    Its work is in evaluations of the equation of motion, or in steps where these are not counted.
    """

    first_rebound_time_s: float
    second_rebound_time_s: float
    first_amplitude: float
    transition_time_s: float
    evaluations: int


@dataclass(frozen=True)
class Setting:
    """One way to run a peer: a step [s], or the relative tolerance of an adaptive one."""

    label: str
    value: float
    quick: bool = True
    method: str = ""


Run = Callable[[Setting], Four]


class Peer(Protocol):
    """A module of this package that solves the transition with somebody else's solver."""

    NAME: str
    PACKAGE: str
    SETTINGS: tuple[Setting, ...]

    def prepare(self, mechanism: Mechanism, speed_rpm: float) -> Run:
        """Do everything that is done once (models, compilation); what is returned is timed."""
        ...


@dataclass
class Bounces:
    """Collisions of the jaw as an event loop finds them."""

    restitution: float
    rate: float  # after the first collision [rad/s]
    deceleration: float  # after it [rad/s^2]
    closing: float  # relative uncertainty of the limit at which the series is closed
    amplitude: float = 0.0  # largest angle so far in the first rebound [rad]
    times: list[float] = field(default_factory=list)  # from the first collision on [s]
    _series: BounceSeries = field(init=False)

    def __post_init__(self) -> None:
        """Start with the first collision."""
        self._series = BounceSeries("jaw", 0.0).bounced(0.0, self.rate, self.deceleration)
        self.times.append(0.0)

    def add(self, t: float, rate: float, deceleration: float) -> bool:
        """Record a collision; True when the limit is known well enough: the transition is over.

        Raises:
            SimulationError: The bounces do not come to an end.
        """
        self.times.append(t)
        self._series = self._series.bounced(t, rate, deceleration)
        if len(self.times) > MOST_COLLISIONS:
            message = "the bounces do not come to an end; take a smaller step or tolerance"
            raise SimulationError(message, collisions=len(self.times))
        limit, error = self._series.limit(self.restitution)
        # Both are infinite while the rates do not fall.
        return len(self.times) > 3 and isfinite(error) and error <= self.closing * limit

    def four(self, evaluations: int) -> Four:
        """Return the numbers of a finished series."""
        limit, _ = self._series.limit(self.restitution)
        t = self.times
        return Four(t[1], t[2] - t[1], self.amplitude, limit, evaluations)


def stepped(transition: Callable[[Setting], tuple[float, float, float, float, int]]) -> Run:
    """A run by compiled steps, whose times are not finite where the bounces do not end."""

    def run(setting: Setting) -> Four:
        found = Four(*transition(setting))
        if not isfinite(found.transition_time_s):
            message = f"the bounces do not come to an end with a step of {setting.value:g} s"
            raise SimulationError(message, step_s=setting.value)
        return found

    return run


def available() -> Iterator[tuple[Peer, str]]:
    """Peers whose package is installed, each with the version of that package."""
    for name in MODULES:
        try:
            module = import_module(f".{name}", __package__)
            found = version(module.PACKAGE)
        except (ImportError, PackageNotFoundError):
            continue
        yield cast("Peer", module), found
