"""The reduced model: functions of one mechanism as tables, and what is known of their error."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..arrays import FloatArray
from ..mechanism import Mechanism, Stop, rad_s_from_rpm
from .kernels.layout import ARRIVE, ARRIVE_ERROR, HIGH, LOW, OWN, TRAVEL_MOST, Charts

# Places of the functions of the equation of motion in a table; two for each spring follow:
# F_k, and F_k times the coordinate of the spring.
BY_SPEED, BY_SPEED_AND_RATE, BY_RATE, BY_GRAVITY, BY_SPRINGS = range(5)
# Gaps that tables cover: multiple of the rated speed, restitution, and a factor for flights higher
# than ballistic ones. The part of the range of x below zero: flights end a little beyond it.
FAST, LIVELY, ROOM, MARGIN = 1.5, 0.5, 1.25, 1.0 / 16.0


def lively_speed(mechanism: Mechanism) -> float:
    """Cylinder speed for which gaps and weights are taken [rad/s]."""
    return FAST * rad_s_from_rpm(mechanism.cylinder.rated_speed_rpm)


def factors(mechanism: Mechanism, functions: int, w: float) -> FloatArray:
    """Factors of the functions in x'' at a rate w of x and a lively speed, shape (functions,)."""
    speed = lively_speed(mechanism)
    found = np.zeros(functions)
    found[BY_SPEED], found[BY_SPEED_AND_RATE] = speed**2, speed * w
    found[BY_RATE], found[BY_GRAVITY] = w**2, 1.0
    for row, spring in enumerate(mechanism.springs):
        place = BY_SPRINGS + 2 * row
        found[place], found[place + 1] = spring.stiffness * spring.preload, spring.stiffness
    elements = BY_SPRINGS + 2 * len(mechanism.springs)
    if functions > elements:
        found[elements:] = 1.0, speed, w
    return found


# Fields of a reduced model that are numbers of its chart.
_OF_CHART = {
    "travel_rad": TRAVEL_MOST, "gap_low": LOW, "gap_max": HIGH, "approach_rate": ARRIVE,
    "approach_residual": ARRIVE_ERROR,
}  # fmt: skip


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
class ReducedModel:
    """One degree of freedom x, the coordinate of the transition stop, sampled over a domain.

    x'' = F0 w^2 + F1 w x' + F2 x'^2 + Fg g / g0 + sum_k k (F_k p + F_k s_k), all functions of
    (u, x): u is the travel of the cylinder from the touch configuration along its motion, w its
    speed, u' = w > 0. Tables are tensor Chebyshev series in x on the whole domain and in u on equal
    cells.

    Attributes:
        name: Model name of the mechanism.
        stop: Name of the transition stop.
        springs: Names of the springs.
        other_stops: Names of the other stops, which have to stay open.
        touch_angle_rad: Cylinder angle psi at u = 0 [rad].
        sense: Sign of the rate of psi.
        charts: The functions, one chart. Its stop arrives at the touch in the initial phase.
        restitutions: e_N of all stops in the mechanism's file, shape (K,).
        stiffness: Spring rates likewise, shape (springs,) [N/m or N m/rad].
        preload: Deflections in the springs at zero likewise, shape (springs,) [m or rad].
        gravity_m_s2: Gravity likewise.
        tolerance: Relative accuracy of the tables.
        samples: Points of the domain that were sampled.
        arrival: What a turn does between its opening and the touch.
        travel_rad: Largest u [rad].
        gap_low: Least x of the tables, below zero by a margin that flights overshoot into.
        gap_max: Largest x [rad or m].
        approach_rate: dx/du just before the first collision, negative [1 or m/rad].
        approach_residual: Bound on its round-off.
        lever: Rate of the normal gap by that of x [m/rad or 1].
        restitution: e_N of the transition stop, used where a case gives none.
    """

    name: str
    stop: str
    springs: tuple[str, ...]
    other_stops: tuple[str, ...]
    touch_angle_rad: float
    sense: int
    charts: Charts = field(repr=False, compare=False)
    restitutions: FloatArray = field(repr=False, compare=False)
    stiffness: FloatArray = field(repr=False, compare=False)
    preload: FloatArray = field(repr=False, compare=False)
    gravity_m_s2: float
    tolerance: float
    samples: int
    arrival: Arrival = field(repr=False, compare=False)

    travel_rad: float = field(init=False)
    gap_low: float = field(init=False)
    gap_max: float = field(init=False)
    approach_rate: float = field(init=False)
    approach_residual: float = field(init=False)
    lever: float = field(init=False)
    restitution: float = field(init=False)

    def __post_init__(self) -> None:
        """Read what the chart tells of itself."""
        for name, place in _OF_CHART.items():
            object.__setattr__(self, name, float(self.charts.numbers[0, place]))
        own = self.charts.stops[0, OWN]
        object.__setattr__(self, "lever", float(self.charts.lever[own]))
        object.__setattr__(self, "restitution", float(self.restitutions[own]))

    @property
    def equation(self) -> FloatArray:
        """Coefficients of F0, F1, F2, Fg, F_k, F_k s_k, shape (4 + 2 springs, cells, Nu, Nx)."""
        return np.asarray(self.charts.equation[0])

    @property
    def cells(self) -> int:
        """Number of cells along the travel."""
        return int(self.equation.shape[1])

    @property
    def degrees(self) -> tuple[int, int]:
        """Coefficients along the travel in each cell, and along x."""
        return int(self.equation.shape[2]), int(self.equation.shape[3])


def numbers_of(mechanism: Mechanism, stop: Stop, others: tuple[Stop, ...]) -> dict[str, Any]:
    """Return the fields of a reduced model that are those of its mechanism."""
    return {
        "name": mechanism.name,
        "stop": stop.name,
        "springs": tuple(spring.name for spring in mechanism.springs),
        "other_stops": tuple(item.name for item in others),
        "touch_angle_rad": mechanism.cylinder.angle_at_touch_rad,
        "sense": mechanism.cylinder.sense,
        "restitutions": np.array([item.restitution for item in mechanism.stops]),
        "stiffness": np.array([spring.stiffness for spring in mechanism.springs]),
        "preload": np.array([spring.preload for spring in mechanism.springs]),
        "gravity_m_s2": mechanism.gravity_m_s2,
    }
