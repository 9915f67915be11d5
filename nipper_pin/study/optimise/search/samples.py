"""Where descents start, and the global check: samples of the whole box, and differential evolution.

A descent finds the nearest valley. Starts come from samples over the bounds, the best and mutually
distant ones first; differential evolution, which uses no derivatives and sees the whole box, then
says whether they have missed a lower one.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from ....arrays import FloatArray
from ....hybrid.result.turns import INDICES
from ....tolerances.study import FEASIBLE, LEAST_SCALE, NO_SPREAD
from ..points import Point, evaluator
from ..problem.problem import Aim, Problem
from .trace import Scales

Merit = tuple[float, str]
"""Value that the evolution minimises, and the engine of it; empty without a machine."""
Mapper = Callable[[Callable[[FloatArray], Merit], Iterable[FloatArray]], Iterable[Merit]]

SCREEN_BITS = 6
"""The screen has two to this power samples."""
SHARE = 8
"""Samples that are evaluated as one task."""

# Least distance of two starts in unit coordinates, and generations and members by parameters of
# the differential evolution.
_APART = 0.15
_GENERATIONS, _MEMBERS = 40, 10
_BROKEN, _NO_MACHINE = 1e3, 1e6


@dataclass(frozen=True, kw_only=True)
class Found:
    """Best member of a differential evolution.

    Attributes:
        z: Unit coordinates.
        feasible: Whether all limits hold there.
        evaluations: Points that were evaluated.
        engines: Numbers of those that made a machine by the engine that found them.
    """

    z: tuple[float, ...]
    feasible: bool
    evaluations: int
    engines: Mapping[str, int]


def samples(problem: Problem, seed: int) -> FloatArray:
    """The model's own values, and a scrambled Sobol sequence over the bounds.

    Returns:
        Unit coordinates, shape (samples, parameters).
    """
    from scipy.stats import qmc

    size = len(problem.parameters)
    draws = qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed))
    own = np.clip(problem.start, 0.0, 1.0)
    return np.concatenate([own[None], draws.random_base2(SCREEN_BITS)])


def look(text: bytes, places: FloatArray) -> list[Point]:
    """Evaluate samples.

    Args:
        places: Unit coordinates, shape (samples, parameters).
    """
    return [evaluator(text).at(z) for z in places]


def scales(problem: Problem, aim: Aim, seen: Sequence[Point]) -> Scales:
    """Sizes of an aim and of the limits: how much they vary over the bounds.

    Args:
        seen: Samples, some of them usable.
    """

    def size(quantity: str) -> float:
        if quantity in INDICES:
            return 1.0
        values = [item.values[quantity] for item in seen if item.usable]
        spread = float(np.std(values))
        largest = float(np.max(np.abs(values)))
        return spread if spread > NO_SPREAD * largest else max(largest, LEAST_SCALE)

    return Scales(size(aim.quantity), tuple(size(item.quantity) for item in problem.limits))


def begins(
    seen: Sequence[Point], aim: Aim, by: Scales, count: int
) -> tuple[tuple[float, ...], ...]:
    """Starts of descents: the model's own values, then the best samples that are far apart.

    Args:
        seen: Samples, the model's own values first.
        by: Scales of aim and limits.
        count: Number of starts; fewer are returned if there are not that many usable samples.
    """
    own = [item for item in seen[:1] if item.usable]
    others = [item for item in seen[1:] if item.usable]
    ranked = own + sorted(others, key=lambda item: by.rank(item, aim))
    chosen: list[Point] = []
    for apart in (_APART, 0.0):
        for item in ranked:
            distance = min((math.dist(item.z, other.z) for other in chosen), default=math.inf)
            if distance > apart and len(chosen) < count:
                chosen.append(item)
    return tuple(tuple(item.z.tolist()) for item in chosen)


def evolve(text: bytes, by: Scales, seed: int, mapper: Mapper) -> Found:
    """Search the whole box by differential evolution.

    Args:
        mapper: Maps the merit over the members of a generation, in their order.
    """
    from scipy.optimize import differential_evolution

    size = len(evaluator(text).problem.parameters)
    engines: Counter[str] = Counter()

    def mapped(_: object, places: Iterable[FloatArray]) -> list[float]:
        judged = list(mapper(partial(merit, text, by), places))
        engines.update(engine for _, engine in judged if engine)
        return [value for value, _ in judged]

    found = differential_evolution(
        lambda z: merit(text, by, z)[0],
        [(0.0, 1.0)] * size,
        rng=np.random.default_rng(seed),
        init="sobol",
        popsize=_MEMBERS,
        maxiter=_GENERATIONS,
        polish=False,
        updating="deferred",
        workers=mapped,
    )
    z = tuple(np.asarray(found.x).tolist())
    return Found(
        z=z,
        feasible=bool(found.fun < _BROKEN),
        evaluations=int(found.nfev),
        engines=dict(engines),
    )


def merit(text: bytes, by: Scales, z: FloatArray) -> Merit:
    """Value that the evolution minimises: lower at any feasible point than at all others."""
    source = evaluator(text)
    point = source.at(z)
    if not point.usable:
        return _NO_MACHINE, ""
    violation = by.violation(point)
    if violation > FEASIBLE:
        return _BROKEN + min(violation, _BROKEN), point.engine
    aim = source.problem.aims[0]
    return aim.sense * point.values[aim.quantity] / by.aim, point.engine
