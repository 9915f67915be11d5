"""Points of a descent, each evaluated once, their derivatives, and the sizes of a problem."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np

from ....arrays import FloatArray
from ....errors import SimulationError
from ....tolerances.study import DESIGN_STEP, FEASIBLE
from ..points import Evaluator, Point
from ..problem.problem import Aim, Problem


@dataclass(frozen=True)
class Scales:
    """Sizes by which a problem is made dimensionless."""

    aim: float
    limits: tuple[float, ...]

    def violation(self, point: Point) -> float:
        """Largest violation of a usable point; zero inside the limits."""
        sizes = np.array(self.limits)[list(point.owners)]
        return float(np.max(-point.rows / sizes, initial=0.0))

    def inside(self, point: Point) -> bool:
        """Whether a usable point meets all limits, to the tolerance of the search."""
        return self.violation(point) <= FEASIBLE

    def rank(self, point: Point, aim: Aim) -> tuple[float, float]:
        """Smaller is better: inside the limits by the aim, outside by the violation."""
        violation = self.violation(point)
        return (violation if violation > FEASIBLE else 0.0, aim.sense * point.values[aim.quantity])


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
            z: Unit coordinates, shape (parameters,).

        Returns:
            Shapes (parameters,) and (rows, parameters).

        Raises:
            SimulationError: The point makes no machine.
        """
        key = z.tobytes()
        if key not in self._slopes:
            point = self.at(z)
            if not point.usable:
                raise SimulationError(point.why)
            here = self._stacked(point)
            columns = [self._column(z, here, place) for place in range(len(z))]
            table = np.array(columns).T
            self._slopes[key] = table[0], table[1:]
        return self._slopes[key]

    def _column(self, z: FloatArray, here: FloatArray, place: int) -> FloatArray:
        step = np.zeros(len(z))
        step[place] = DESIGN_STEP
        near = {}
        for sense in (1.0, -1.0):
            there = z + sense * step
            if 0.0 <= there[place] <= 1.0 and self.at(there).usable:
                near[sense] = self._stacked(self.at(there))
        if len(near) == 2:
            return np.asarray((near[1.0] - near[-1.0]) / (2.0 * DESIGN_STEP))
        for sense, first in near.items():
            second = self.at(z + 2.0 * sense * step)
            if second.usable:
                return np.asarray(
                    sense * (4.0 * first - self._stacked(second) - 3.0 * here) / (2.0 * DESIGN_STEP)
                )
            return np.asarray(sense * (first - here) / DESIGN_STEP)
        return np.zeros_like(here)

    def _stacked(self, point: Point) -> FloatArray:
        return np.array([self.aim(point), *point.rows])

    def best(self) -> tuple[Point, float]:
        """The best usable point so far and its violation."""
        usable = [item for item in self._known.values() if item.usable]
        point = min(usable, key=lambda item: self.scales.rank(item, self.problem.aims[0]))
        return point, self.scales.violation(point)

    @property
    def counts(self) -> tuple[int, int]:
        """Points evaluated, and those of them that made no machine."""
        return len(self._known), sum(not item.usable for item in self._known.values())

    @property
    def engines(self) -> dict[str, int]:
        """Numbers of usable points by the engine that found them."""
        return dict(Counter(item.engine for item in self._known.values() if item.usable))
