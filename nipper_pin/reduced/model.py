"""The reduced model: functions of one mechanism as tables, and what is known of their error."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..mechanism import Mechanism, rad_s_from_rpm
from .kernels.layout import HIGH, TRAVEL_MOST, Charts

# Place of the first function of a spring in a table, behind F0, F1, F2 and Fg; each has two: F_k,
# and F_k times the coordinate of the spring.
BY_SPRINGS = 4
# Gaps that tables cover: multiple of the rated speed, restitution, and a factor for flights higher
# than ballistic ones. The part of the range of x below zero: flights end a little beyond it.
FAST, LIVELY, ROOM, MARGIN = 1.5, 0.5, 1.25, 1.0 / 16.0


def lively_speed(mechanism: Mechanism) -> float:
    """Cylinder speed for which gaps and weights are taken [rad/s]."""
    return FAST * rad_s_from_rpm(mechanism.cylinder.rated_speed_rpm)


def factors(mechanism: Mechanism, functions: int, w: float) -> FloatArray:
    """Factors of the functions in x'' at a rate w of x and a lively speed, shape (functions,)."""
    speed = lively_speed(mechanism)
    found = [speed**2, speed * w, w**2, 1.0]
    for spring in mechanism.springs:
        found += [spring.stiffness * spring.preload, spring.stiffness]
    return np.array([*found, 1.0, speed, w][:functions])


@dataclass(frozen=True, kw_only=True)
class Arrival:
    """Tables of a turn from its opening to the touch, for the premise of a transition.

    In the phase that clamps (x = 0, the transition stop closed) the other stop is open until the
    drives bring it back: the opening. Its collision there throws the transition stop open, and from
    then on its gap is the one coordinate that is left, a body that bounces on a stop, rests on it,
    and is released. That is independent of the past.

    Attributes:
        charts: The chart of the transition stop from the touch to the opening, and that of the
            waiting stop from there to the touch; None where these are not known.
        why: Reason why there are no tables; empty if there are.
        asked: Whether the premise can be decided; without tables by simulating whole turns.
    """

    charts: Charts | None = field(default=None, repr=False)
    why: str = ""
    asked: bool = True


@dataclass(frozen=True, kw_only=True)
class Tabulated:
    """What tables keep of a mechanism.

    Attributes:
        name: Its model name.
        springs: Names of the springs.
        charts: Its functions.
        numbers: Those of a case: speed of the cylinder (0), and from its file e_N of all stops,
            stiffnesses of springs and preloads, shape (1 + K + 2 springs,).
    """

    name: str
    springs: tuple[str, ...]
    charts: Charts = field(repr=False, compare=False)
    numbers: FloatArray = field(repr=False, compare=False)


@dataclass(frozen=True, kw_only=True)
class ReducedModel(Tabulated):
    """One degree of freedom x, the coordinate of the transition stop, sampled over a domain.

    x'' = F0 w^2 + F1 w x' + F2 x'^2 + Fg + sum_k k (F_k p + F_k s_k), all functions of
    (u, x): u is the travel of the cylinder from the touch configuration along its motion, w its
    speed, u' = w > 0. Tables are tensor Chebyshev series in x on the whole domain and in u on equal
    cells. The functions are one chart, whose stop arrives at the touch in the initial phase.

    Attributes:
        stop: Name of the transition stop.
        touch_angle_rad: Cylinder angle psi at u = 0 [rad].
        sense: Sign of the rate of psi.
        tolerance: Relative accuracy of the tables.
        arrival: What a turn does between its opening and the touch.
    """

    stop: str
    touch_angle_rad: float
    sense: int
    tolerance: float
    arrival: Arrival = field(repr=False, compare=False)

    @property
    def travel_rad(self) -> float:
        """Largest u [rad]."""
        return float(self.charts.numbers[0, TRAVEL_MOST])

    @property
    def gap_max(self) -> float:
        """Largest x [rad or m]."""
        return float(self.charts.numbers[0, HIGH])


def numbers_of(mechanism: Mechanism) -> dict[str, Any]:
    """Return what tables keep of a mechanism, but for its functions."""
    springs = mechanism.springs
    numbers = [0.0, *(item.restitution for item in mechanism.stops)]
    numbers += [*(item.stiffness for item in springs), *(item.preload for item in springs)]
    names = tuple(item.name for item in springs)
    return {"name": mechanism.name, "springs": names, "numbers": np.array(numbers)}
