"""The four numbers of one transition, and the settings of what computes them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Four:
    """The four numbers that a peer is graded by, and its work.

    Attributes:
        first_rebound_time_s: From the first to the second collision [s].
        second_rebound_time_s: From the second to the third collision [s].
        first_amplitude: Largest jaw angle between the first two collisions [rad].
        transition_time_s: From the first collision to rest [s].
        evaluations: Evaluations of the equation of motion, or steps where a package does not
            count its evaluations.
    """

    first_rebound_time_s: float
    second_rebound_time_s: float
    first_amplitude: float
    transition_time_s: float
    evaluations: int


@dataclass(frozen=True)
class Setting:
    """One way to run a peer.

    Attributes:
        label: What tables show.
        value: Step [s] of a fixed-step peer, relative tolerance of an adaptive one.
        quick: Part of a quick benchmark.
        method: Variant of the peer, where it has more than one.
    """

    label: str
    value: float
    quick: bool = True
    method: str = ""


Run = Callable[[Setting], Four]
