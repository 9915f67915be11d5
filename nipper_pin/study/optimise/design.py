"""A design with its quantities, as it is reported."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...tolerances.study import ACTIVE_LIMIT
from .points import Evaluator, Point
from .problem.problem import Problem
from .search.trace import Scales


@dataclass(frozen=True, kw_only=True)
class Design:
    """One set of numbers.

    Attributes:
        z: Unit coordinates.
        numbers: Values of the free numbers by name.
        values: Quantities by name.
        errors: Their stated errors.
        slacks: Slack of every limit, in the order of the problem.
        inside: Whether all limits hold, to the tolerance of the search.
        holding: Limits and bounds without room to speak of, each in the words of
            :class:`~.search.binding.Binding`.
        engine: Engine that found its transition, or its whole turn if one is asked for: "reduced"
            or "direct"; "reduced_turn" or "turn", the same two on whole turns.
    """

    z: tuple[float, ...]
    numbers: Mapping[str, float]
    values: Mapping[str, float]
    errors: Mapping[str, float]
    slacks: tuple[float, ...]
    inside: bool
    holding: tuple[str, ...]
    engine: str

    def record(self) -> dict[str, Any]:
        """The design as plain data for JSON."""
        return {
            "numbers": dict(self.numbers),
            "values": {name: _finite(value) for name, value in self.values.items()},
            "errors": {name: _finite(value) for name, value in self.errors.items()},
            "slacks": list(self.slacks),
            "inside": self.inside,
            "holding": list(self.holding),
            "engine": self.engine,
        }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def design(source: Evaluator, by: Scales, z: tuple[float, ...]) -> Design | None:
    """The design of unit coordinates; None if they make no machine that can be simulated."""
    place = np.array(z)
    point = source.at(place)
    if not point.usable:
        return None
    return Design(
        z=z,
        numbers=source.problem.numbers(place),
        values=dict(point.values),
        errors=source.errors(place),
        slacks=point.slacks,
        inside=by.inside(point),
        holding=_holding(source.problem, by, point),
        engine=point.engine,
    )


def _holding(problem: Problem, by: Scales, point: Point) -> tuple[str, ...]:
    """Names of the limits with less than the least room, and of the bounds that are as near."""
    limits = zip(problem.limits, point.slacks, by.limits, strict=True)
    found = [str(limit) for limit, slack, size in limits if slack <= ACTIVE_LIMIT * size]
    return (*found, *problem.bounds_at(point.z))
