"""The Pareto front of two aims, by the epsilon constraint.

The first aim is made best while the second is held to a limit, and the limit goes in even steps
from what the best design by the first aim has to the best value of the second. Unlike weighted
sums this finds hollow parts of a front, too, and spaces its points evenly.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import islice
from typing import Literal

import numpy as np

from ....tolerances.study import NO_CONFLICT
from ..points import Evaluator
from ..problem.problem import Limit, Problem
from ..work import Work
from .descend import Descent, descend
from .trace import Scales

# The last limit stops short of the best value of the second aim: exactly there the limits leave the
# first one no room at all, and descents along an edge of no width do not end.
_LAST = 1.0 - 1e-3


def front(
    problem: Problem,
    by: tuple[Scales, ...],
    ends: tuple[Descent, Descent],
    points: int,
    work: Work,
) -> tuple[tuple[tuple[float, ...], ...], list[Descent]]:
    """Find the front.

    Args:
        problem: A problem with two aims.
        by: Scales by each aim.
        ends: The best by the first aim and the best by the second.
        points: Points, both ends included.
        work: Does the descents.

    Returns:
        Unit coordinates of points that no other one beats, the best by the first aim first, and
        the descents that led to them. A single point if one design is the best by both aims.
    """
    one, two = problem.aims
    side: Literal["low", "high"] = "high" if two.sense > 0.0 else "low"
    # Of the first aim with the second held to a value.
    scales = Scales(by[0].aim, (*by[0].limits, by[1].aim))
    source = Evaluator(problem)
    reached = _second(source, ends[0])
    if reached - ends[1].aim <= NO_CONFLICT * by[1].aim:
        return (ends[0].z,), []
    tasks: list[Callable[[], Descent]] = []
    counts: list[int] = []
    for k in range(1, points):
        part = k / (points - 1)
        held = reached + min(part, _LAST) * (ends[1].aim - reached)
        limit = Limit(quantity=two.quantity, side=side, value=two.sense * held)
        text = problem.with_aim(one, limit).text()
        blend = (1.0 - part) * np.array(ends[0].z) + part * np.array(ends[1].z)
        starts = [ends[0].z, ends[1].z]
        if source.at(blend).usable:
            starts.insert(1, tuple(blend.tolist()))
        counts.append(len(starts))
        tasks += [partial(descend, text, scales, z) for z in starts]
    found = work.all(tasks)
    left = iter(found)
    groups = [list(islice(left, count)) for count in counts]
    best = [ends[0], *(min(group, key=lambda item: item.rank) for group in groups)]
    places = [item.z for item in best if item.feasible]
    aims = [(item.aim, _second(source, item)) for item in best if item.feasible]
    return tuple(z for z, own in zip(places, aims, strict=True) if not _beaten(own, aims)), found


def _second(source: Evaluator, item: Descent) -> float:
    """Value of the second aim, to be small, of a descent by the first one."""
    aim = source.problem.aims[1]
    return aim.sense * source.at(np.array(item.z)).values[aim.quantity]


def _beaten(own: tuple[float, float], others: list[tuple[float, float]]) -> bool:
    """Whether another point is as good by both aims and better by one."""
    return any(other[0] <= own[0] and other[1] <= own[1] and other != own for other in others)
