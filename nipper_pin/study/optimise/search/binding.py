"""Slacks, active limits and bounds of an optimum, and their Lagrange multipliers.

At an optimum the gradient of the aim is a combination of the gradients of what is active, with
weights of one sign (Karush, Kuhn and Tucker). The weights are the prices: how much better the aim
becomes by one unit more of a limit. What the combination leaves of the gradient says how far the
point is from being an optimum of first order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....arrays import FloatArray
from ....tolerances.study import ACTIVE_LIMIT
from ..points import Evaluator
from ..problem.problem import Problem
from .trace import Scales, Trace


@dataclass(frozen=True, kw_only=True)
class Binding:
    """A limit or a bound at an optimum.

    Attributes:
        name: The limit, or the bound of a parameter, in words.
        kind: "limit" or "bound".
        value: Value of the limited quantity or of the parameter.
        slack: Room that is left, in its unit; near zero if it is active.
        active: Whether it is.
        price: Improvement of the aim, in its unit, by one unit more of room; zero if not active.
    """

    name: str
    kind: str
    value: float
    slack: float
    active: bool
    price: float


@dataclass(frozen=True, kw_only=True)
class Account:
    """Active limits and bounds of an optimum.

    Attributes:
        bindings: All limits, then the bounds that are active.
        residual: Part of the aim's gradient, by unit coordinates, that nothing active explains,
            by the gradient itself: zero at an optimum.
    """

    bindings: tuple[Binding, ...]
    residual: float


def account(problem: Problem, scales: Scales, z: tuple[float, ...]) -> Account:
    """Find what is active at a point, and its price.

    Args:
        problem: The problem; its first aim counts.
        z: Unit coordinates of a usable point.
    """
    from scipy.optimize import nnls

    trace = Trace(Evaluator(problem), scales)
    place = np.array(z)
    point = trace.at(place)
    gradient, slopes = trace.slopes(place)
    sizes = np.array(scales.limits)[list(point.owners)]
    rows = np.flatnonzero(point.rows <= ACTIVE_LIMIT * sizes)
    bounds = [(int(k), 1.0) for k in np.flatnonzero(place <= ACTIVE_LIMIT)]
    bounds += [(int(k), -1.0) for k in np.flatnonzero(place >= 1.0 - ACTIVE_LIMIT)]
    columns = [slopes[row] / sizes[row] for row in rows]
    columns += [sense * np.eye(len(place))[k] for k, sense in bounds]
    weights, rest = np.zeros(0), float(np.linalg.norm(gradient))
    if columns:
        weights, rest = nnls(np.array(columns).T, gradient)
    size = float(np.linalg.norm(gradient))
    prices = np.zeros(len(problem.limits))
    for row, weight, unit in zip(rows, weights, sizes[rows], strict=False):
        prices[point.owners[row]] += weight / unit
    active = {point.owners[row] for row in rows}
    found = [
        Binding(
            name=str(limit),
            kind="limit",
            value=point.values[limit.quantity],
            slack=slack,
            active=k in active,
            price=float(prices[k]),
        )
        for k, (limit, slack) in enumerate(zip(problem.limits, point.slacks, strict=True))
    ]
    found += _bounds(problem, place, bounds, weights[len(rows) :])
    return Account(bindings=tuple(found), residual=rest / size if size > 0.0 else 0.0)


def _bounds(
    problem: Problem, z: FloatArray, bounds: list[tuple[int, float]], weights: FloatArray
) -> list[Binding]:
    found = []
    for (k, sense), weight in zip(bounds, weights, strict=True):
        item, width = problem.parameters[k], problem.width[k]
        found.append(
            Binding(
                name=item.bound("low" if sense > 0.0 else "high"),
                kind="bound",
                value=problem.numbers(z)[item.name],
                slack=float(width * (z[k] if sense > 0.0 else 1.0 - z[k])),
                active=True,
                price=float(weight / width),
            )
        )
    return found
