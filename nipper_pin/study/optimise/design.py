"""A design with its quantities, as it is reported."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .points import Evaluator
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
        engine: Engine that found its transition, or its whole turn if one is asked for: "reduced"
            or "direct"; "reduced_turn" or "turn", the same two on whole turns.
    """

    z: tuple[float, ...]
    numbers: Mapping[str, float]
    values: Mapping[str, float]
    errors: Mapping[str, float]
    slacks: tuple[float, ...]
    inside: bool
    engine: str

    def record(self) -> dict[str, Any]:
        """The design as plain data for JSON."""
        return {
            "numbers": dict(self.numbers),
            "values": {name: _finite(value) for name, value in self.values.items()},
            "errors": {name: _finite(value) for name, value in self.errors.items()},
            "slacks": list(self.slacks),
            "inside": self.inside,
            "engine": self.engine,
        }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def design(source: Evaluator, by: Scales, z: tuple[float, ...]) -> Design | None:
    """The design of some numbers; None if they make no machine that can be simulated.

    Args:
        source: Evaluates points of the problem.
        by: Scales of its limits.
        z: Unit coordinates.
    """
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
        engine=point.engine,
    )
