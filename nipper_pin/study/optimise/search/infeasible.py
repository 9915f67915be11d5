"""Limits that no descent meets: the nearest design, and its excess over each limit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from ....errors import InfeasibleError
from ....tolerances.study import FEASIBLE
from ..points import Evaluator
from ..problem.problem import Problem
from ..work import Work
from .descend import Descent, descend, restore
from .trace import Scales


def from_feasible_designs(
    problem: Problem, by: Scales, tried: Sequence[Descent], work: Work
) -> list[Descent]:
    """Descents from designs that meet all limits, found by making violations small alone.

    Args:
        problem: The problem with one aim.
        tried: Descents, none of which meets the limits.

    Raises:
        InfeasibleError: There are no such designs.
    """
    text = problem.text()
    nearest = work.all([partial(restore, text, by, item.z) for item in tried])
    met = [item for item in nearest if item.feasible]
    if met:
        return work.all([partial(descend, text, by, item.z) for item in met])
    raise _infeasible(problem, by, min(nearest, key=lambda item: item.violation), work)


def _infeasible(problem: Problem, by: Scales, nearest: Descent, work: Work) -> InfeasibleError:
    """The error, with every limit that the nearest design breaks."""
    z = np.array(nearest.z)
    point = Evaluator(problem).at(z)
    broken, words = [], []
    for k, (limit, slack) in enumerate(zip(problem.limits, point.slacks, strict=True)):
        if slack >= -FEASIBLE * by.limits[k]:
            continue
        alone = replace(problem, limits=(limit,)).text()
        task = partial(restore, alone, Scales(by.aim, (by.limits[k],)), nearest.z)
        (single,) = work.all([task])
        item = {
            "limit": str(limit),
            "reached": point.values[limit.quantity],
            "missed_by": -slack,
            "can_be_met_alone": single.feasible,
            "missed_by_alone": single.violation * by.limits[k],
        }
        broken.append(item)
        words.append(_sentence(item, problem.units[limit.quantity]))
    numbers = problem.numbers(z)
    design = ", ".join(f"{key} = {value:.6g}" for key, value in numbers.items())
    wider = " or ".join(problem.bounds_at(z))
    message = (
        f"no design within the bounds meets all limits; the nearest ({design}) breaks "
        f"{'; '.join(words)}. "
        f"Relax these limits{f', or widen the bound {wider}' if wider else ''}"
    )
    return InfeasibleError(message, limits=broken, numbers=numbers)


def _sentence(item: dict[str, object], unit: str) -> str:
    short = f"{item['missed_by']:.4g}{f' {unit}' if unit else ''}"
    alone = (
        "alone it could be met"
        if item["can_be_met_alone"]
        else f"alone it is still missed by {item['missed_by_alone']:.4g}"
    )
    return f"{item['limit']}: {item['reached']:.6g} is reached, missed by {short} ({alone})"
