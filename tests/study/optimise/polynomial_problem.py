"""A design problem whose quantities are polynomials of two numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nipper_pin.mechanism import load
from nipper_pin.study.identify.problem.geometry import Sources
from nipper_pin.study.optimise.points import Point
from nipper_pin.study.optimise.points.point import slack_rows
from nipper_pin.study.optimise.problem.problem import Aim, Limit, Parameter, Problem
from nipper_pin.study.sweep.axes import Target

LOW, HIGH = (10.0, -1.0), (14.0, 1.0)


def problem(*limits: Limit, aims: tuple[Aim, ...] = (), **others: Any) -> Problem:
    """Minimise the rebound by a preload and a ratio."""
    wanted = aims or (Aim(quantity="rebound_amplitude_1", sense=1.0),)
    units = {"rebound_amplitude_1": "rad", "duration_s": "s", "clamping_force_N": "N"}
    given = {
        "title": "mine", "model": "e62", "changes": {"stops.jaw.restitution": 0.25},
        "sources": Sources.of(load("e62")), "speed_rpm": 600.0, "rest_rate": None,
        "tolerance": 1e-10,
        "parameters": tuple(
            Parameter(name=name, target=Target(kind="model", path=f"to.{name}"), low=low,
                      high=high, start=low + 0.25 * (high - low))
            for name, low, high in zip(("one", "two"), LOW, HIGH, strict=True)
        ),
        "aims": wanted, "limits": limits,
        "units": {item.quantity: units.get(item.quantity, "") for item in (*wanted, *limits)},
    }  # fmt: skip
    return Problem(**{**given, **others})


Quantities = dict[str, Callable[[np.ndarray], float]]


class Source:
    """Takes the place of an evaluator; no machine beyond an edge."""

    def __init__(self, asking: Problem, values: Quantities, edge: float = 2.0) -> None:
        """Count what is asked."""
        self.problem, self._values, self._edge = asking, values, edge
        self.asked: list[np.ndarray] = []

    def at(self, z: np.ndarray) -> Point:
        """The point."""
        self.asked.append(z.copy())
        if z[0] > self._edge:
            return Point(z=z, values={}, rows=np.zeros(0), owners=(), why="beyond the edge")
        values = {name: float(of(z)) for name, of in self._values.items()}
        rows, owners = slack_rows(self.problem.limits, values, np.zeros(0))
        return Point(z=z, values=values, rows=rows, owners=owners, engine="direct")

    def errors(self, z: np.ndarray) -> dict[str, float]:
        """A thousandth of every quantity."""
        return {name: 1e-3 * abs(of(z)) for name, of in self._values.items()}
