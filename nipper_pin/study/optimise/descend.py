"""One descent: sequential quadratic programming from one start, inside bounds and limits.

Bounces and kinematics are smooth in the free numbers as long as the same stops take part, and the
limits of a good design bind: SciPy's SLSQP follows curved limits with a few dozen points, where a
search without derivatives needs thousands. Derivatives are central differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...arrays import FloatArray
from .evaluate import Evaluator, Point, evaluator
from .problem import Problem

STEP = 5e-4
"""Step of differences in unit coordinates: near the cube root of the tolerance of the transitions,
where truncation and round-off of a central difference are equal."""
FEASIBLE = 1e-6
"""Largest violation that counts as none, in units of the limit's scale."""

_MOST_STEPS = 40
_ROUNDS = 3
# Scaled gains of the aim that end a run, and that are worth another one: far above the noise of the
# transitions, since a line search in noise has no end.
_FTOL, _GAIN = 1e-9, 1e-7
# Scaled value of numbers that make no machine: the line search turns back from them.
_UNUSABLE = 1e3


@dataclass(frozen=True)
class Scales:
    """Sizes by which a problem is made dimensionless.

    Attributes:
        aim: Of the aim.
        limits: Of every limit.
    """

    aim: float
    limits: tuple[float, ...]

    def violation(self, point: Point) -> float:
        """Largest violation of a usable point; zero inside the limits."""
        sizes = np.array(self.limits)[list(point.owners)]
        return float(np.max(-point.rows / sizes, initial=0.0))

    def inside(self, point: Point) -> bool:
        """Whether a usable point meets all limits, to the tolerance of the search."""
        return self.violation(point) <= FEASIBLE


@dataclass(frozen=True, kw_only=True)
class Descent:
    """One start and where it led.

    Attributes:
        start: Unit coordinates of the start.
        z: Unit coordinates of the best point on the way: the least aim inside the limits, or else
            the least violation.
        aim: Value of the aim there, in its unit, negative if it is maximised.
        violation: Largest scaled violation there.
        evaluations: Points that were evaluated.
        failures: Of these, those that made no machine.
        converged: Whether the last run ended by its tolerance.
    """

    start: tuple[float, ...]
    z: tuple[float, ...]
    aim: float
    violation: float
    evaluations: int
    failures: int
    converged: bool

    @property
    def feasible(self) -> bool:
        """Whether all limits hold."""
        return self.violation <= FEASIBLE

    @property
    def rank(self) -> tuple[float, float]:
        """Smaller is better: inside the limits by the aim, outside by the violation."""
        return (0.0, self.aim) if self.feasible else (self.violation, self.aim)


class Trace:
    """Points of one descent, each evaluated once, and their derivatives."""

    def __init__(self, source: Evaluator, scales: Scales) -> None:
        """Start with nothing."""
        self.problem: Problem = source.problem
        self.scales = scales
        self._source = source
        self._known: dict[bytes, Point] = {}
        self._slopes: dict[bytes, tuple[FloatArray, FloatArray]] = {}

    def at(self, z: FloatArray) -> Point:
        """The point at some unit coordinates; those outside the bounds are taken to them."""
        inside = np.clip(z, 0.0, 1.0)
        key = inside.tobytes()
        if key not in self._known:
            self._known[key] = self._source.at(inside)
        return self._known[key]

    def aim(self, point: Point) -> float:
        """Value of the aim that is to be small, in its unit."""
        aim = self.problem.aims[0]
        return aim.sense * point.values[aim.quantity]

    def slopes(self, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Derivatives of the aim and of all rows by the unit coordinates, in their units.

        Central differences; one-sided ones where a neighbour leaves the bounds or makes no machine,
        and zero where both do.

        Args:
            z: Unit coordinates of a usable point, shape (parameters,).

        Returns:
            Shapes (parameters,) and (rows, parameters).
        """
        key = z.tobytes()
        if key not in self._slopes:
            here = self._stacked(self.at(z))
            columns = [self._column(z, here, place) for place in range(len(z))]
            table = np.array(columns).T
            self._slopes[key] = table[0], table[1:]
        return self._slopes[key]

    def _column(self, z: FloatArray, here: FloatArray, place: int) -> FloatArray:
        step = np.zeros(len(z))
        step[place] = STEP
        near = {}
        for sense in (1.0, -1.0):
            there = z + sense * step
            if 0.0 <= there[place] <= 1.0 and self.at(there).usable:
                near[sense] = self._stacked(self.at(there))
        if len(near) == 2:
            return np.asarray((near[1.0] - near[-1.0]) / (2.0 * STEP))
        for sense, first in near.items():
            second = self.at(z + 2.0 * sense * step)
            if second.usable:
                return np.asarray(
                    sense * (4.0 * first - self._stacked(second) - 3.0 * here) / (2.0 * STEP)
                )
            return np.asarray(sense * (first - here) / STEP)
        return np.zeros_like(here)

    def _stacked(self, point: Point) -> FloatArray:
        return np.array([self.aim(point), *point.rows])

    def best(self) -> tuple[Point, float]:
        """The best usable point so far and its violation."""
        usable = [item for item in self._known.values() if item.usable]
        broken = [self.scales.violation(item) for item in usable]

        def rank(place: int) -> tuple[float, float]:
            violation = broken[place]
            return (violation if violation > FEASIBLE else 0.0, self.aim(usable[place]))

        place = min(range(len(usable)), key=rank)
        return usable[place], broken[place]

    @property
    def counts(self) -> tuple[int, int]:
        """Points evaluated, and those of them that made no machine."""
        return len(self._known), sum(not item.usable for item in self._known.values())


def descend(text: bytes, scales: Scales, start: tuple[float, ...]) -> Descent:
    """Minimise the first aim of a problem from one start.

    Args:
        text: Text of the problem.
        scales: Its scales.
        start: Unit coordinates of a usable point.
    """
    trace = Trace(evaluator(text), scales)
    return _run(trace, start, _minimise)


def restore(text: bytes, scales: Scales, start: tuple[float, ...]) -> Descent:
    """Make the largest violation of a problem's limits as small as it can be, from one start.

    Args:
        text: Text of the problem.
        scales: Its scales.
        start: Unit coordinates of a usable point.
    """
    trace = Trace(evaluator(text), scales)
    return _run(trace, start, _mend)


def _run(
    trace: Trace, start: tuple[float, ...], method: Callable[[Trace, FloatArray], bool]
) -> Descent:
    """Repeat a method from the best point so far: each run forgets the curvature of the last."""
    z = np.clip(np.array(start), 0.0, 1.0)
    trace.at(z)
    rank = (np.inf, np.inf)
    converged = False
    for _ in range(_ROUNDS):
        converged = method(trace, z)
        point, violation = trace.best()
        now = (max(violation - FEASIBLE, 0.0), trace.aim(point) / trace.scales.aim)
        if now[0] >= rank[0] - _GAIN and now[1] >= rank[1] - _GAIN:
            break
        z, rank = point.z, now
    point, violation = trace.best()
    evaluations, failures = trace.counts
    return Descent(
        start=start,
        z=tuple(point.z.tolist()),
        aim=trace.aim(point),
        violation=violation,
        evaluations=evaluations,
        failures=failures,
        converged=converged,
    )


def _minimise(trace: Trace, z: FloatArray) -> bool:
    from scipy.optimize import minimize

    size = np.array(trace.scales.limits)[list(trace.at(z).owners)]

    def value(x: FloatArray) -> float:
        point = trace.at(x)
        return trace.aim(point) / trace.scales.aim if point.usable else _UNUSABLE

    def rows(x: FloatArray) -> FloatArray:
        point = trace.at(x)
        return point.rows / size if point.usable else np.full(len(size), -_UNUSABLE)

    def value_slopes(x: FloatArray) -> FloatArray:
        return np.asarray(trace.slopes(x)[0] / trace.scales.aim)

    def row_slopes(x: FloatArray) -> FloatArray:
        return np.asarray(trace.slopes(x)[1] / size[:, None])

    found = minimize(
        value,
        z,
        jac=value_slopes,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(z),
        constraints=[{"type": "ineq", "fun": rows, "jac": row_slopes}] if len(size) else [],
        options={"ftol": _FTOL, "maxiter": _MOST_STEPS},
    )
    return bool(found.success)


def _mend(trace: Trace, z: FloatArray) -> bool:
    """Least t with every scaled row above -t: the elastic form of the limits."""
    from scipy.optimize import minimize

    size = np.array(trace.scales.limits)[list(trace.at(z).owners)]
    begin = trace.scales.violation(trace.at(z))

    def rows(x: FloatArray) -> FloatArray:
        point = trace.at(x[:-1])
        inside = point.rows / size if point.usable else np.full(len(size), -_UNUSABLE)
        return np.asarray(inside + x[-1])

    def row_slopes(x: FloatArray) -> FloatArray:
        inner = trace.slopes(np.clip(x[:-1], 0.0, 1.0))[1] / size[:, None]
        return np.column_stack([inner, np.ones(len(size))])

    only_last = np.append(np.zeros(len(z)), 1.0)
    found = minimize(
        lambda x: float(x[-1]),
        np.append(z, begin),
        jac=lambda _: only_last,
        method="SLSQP",
        bounds=[*[(0.0, 1.0)] * len(z), (0.0, None)],
        constraints=[{"type": "ineq", "fun": rows, "jac": row_slopes}],
        options={"ftol": _FTOL, "maxiter": _MOST_STEPS},
    )
    return bool(found.success)
