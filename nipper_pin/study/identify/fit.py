"""Least squares inside bounds, from several starts; the same seed gives the same bits."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import qmc

from ...arrays import FloatArray
from ...errors import InputError, NipperError, SimulationError
from ..processes import mapped
from .limits import excesses
from .objective import Objective
from .problem import Problem

Progress = Callable[[int, int, float], None]
"""Called with (starts done, starts in all, least cost so far)."""

_MAX_STEPS = 60
# Draws for one start until it makes a machine whose jaw closes.
_DRAWS = 64


@dataclass(frozen=True, eq=False)
class Descent:
    """One start and where it led.

    Attributes:
        start: Unit coordinates of the start, shape (free,).
        z: Unit coordinates of the end, shape (free,).
        cost: Half the sum of squares of all residuals there; infinite if no machine was found.
        steps: Evaluations of the residuals, those for derivatives left out.
        converged: Whether it ended by its tolerance.
        reason: Why no machine was found; empty if one was.
    """

    start: FloatArray
    z: FloatArray
    cost: float
    steps: int
    converged: bool
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Fit:
    """The best of several descents.

    Attributes:
        objective: The problem as residuals.
        seed: Seed of the starts.
        descents: All descents, the best first; equal ones in the order of their starts.
        values: Values of the free numbers by path.
        predicted: Values of the targets, shape (targets,).
        broken: Limits that are broken, in sigmas, in the order of ``LIMITS``; zero inside, empty
            without limits.
    """

    objective: Objective
    seed: int
    descents: tuple[Descent, ...]
    values: dict[str, float]
    predicted: FloatArray
    broken: FloatArray

    @property
    def best(self) -> Descent:
        """The descent with the least cost."""
        return self.descents[0]

    @property
    def deviations(self) -> FloatArray:
        """Relative deviations from the targets, predicted / wanted - 1, shape (targets,)."""
        wanted = np.array([target.value for target in self.objective.problem.targets])
        return np.asarray(self.predicted / wanted - 1.0)

    def within(self, part: float) -> int:
        """Number of targets that are met within a relative deviation."""
        return int(np.count_nonzero(np.abs(self.deviations) <= part))


def identify(
    problem: Problem,
    *,
    starts: int = 16,
    seed: int = 1,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Fit the free numbers of a problem.

    The first descent starts from the model's own values, the others from a scrambled Sobol
    sequence over the bounds. Each is independent of all others, so the number of workers does not
    change a bit of the result.

    Args:
        problem: The problem.
        starts: Number of descents.
        seed: Seed of the starts.
        workers: Processes; by default as many as there are processors. 1: this process alone.
        progress: Called after every descent.

    Raises:
        InputError: An argument is out of range.
        SimulationError: No start led to a machine that can be simulated.
    """
    for name, value in (("starts", starts), ("workers", 1 if workers is None else workers)):
        if value < 1:
            message = f"{name} = {value}: at least 1"
            raise InputError(message, argument=name, value=value)
    objective = Objective(problem)
    begins = list(_starts(objective, starts, seed))
    found: list[Descent] = []
    count = min(starts, workers if workers is not None else os.cpu_count() or 1)
    for descent in mapped(partial(descend, objective), begins, count):
        found.append(descent)
        if progress is not None:
            progress(len(found), starts, min(item.cost for item in found))
    ranked = tuple(sorted(found, key=lambda item: item.cost))
    if not np.isfinite(ranked[0].cost):
        message = (
            f"none of {starts} starts is a machine whose transitions can be simulated (the first: "
            f"{found[0].reason}); narrow the bounds around the model's own values"
        )
        raise SimulationError(message, starts=starts, seed=seed, reason=found[0].reason)
    z = ranked[0].z
    broken = np.zeros(0)
    if problem.limits is not None:
        broken = excesses(problem.limits, objective.cycle(objective.mechanism(z), problem.limits))
    return Fit(
        objective=objective,
        seed=seed,
        descents=ranked,
        values=objective.values(z),
        predicted=objective.predicted(z),
        broken=broken,
    )


def _starts(objective: Objective, count: int, seed: int) -> Iterator[FloatArray]:
    """The model's own values, then points of a Sobol sequence, in blocks of draws."""
    yield objective.start
    if count == 1:
        return
    size = len(objective.problem.free)
    draws = qmc.Sobol(size, scramble=True, rng=np.random.default_rng(seed))
    needed = (count - 1) * _DRAWS
    points = draws.random_base2(int(np.ceil(np.log2(needed))))[:needed]
    # Drawn within the middle of the ranges: a descent has to have room on both sides.
    yield from 0.1 + 0.8 * points.reshape(count - 1, _DRAWS, size)


def descend(objective: Objective, begin: FloatArray, max_steps: int = _MAX_STEPS) -> Descent:
    """Go down from one start.

    Args:
        objective: The residuals.
        begin: Unit coordinates, shape (free,); or several draws, shape (draws, free), of which
            the first is taken that makes a machine.
        max_steps: Largest number of evaluations, those for derivatives left out.
    """
    draws = np.atleast_2d(begin)
    reason = ""
    for draw in draws:
        start = np.clip(draw, 1e-6, 1.0 - 1e-6)
        try:
            fenced = objective.fenced(objective.rows(start))
            found = least_squares(
                fenced.residuals,
                start,
                jac=fenced.slopes,
                bounds=(0.0, 1.0),
                ftol=1e-8,
                xtol=1e-6,
                gtol=1e-6,
                max_nfev=max_steps,
            )
        except NipperError as error:
            reason = reason or error.message
            continue
        steps, ended = int(found.nfev), bool(found.status > 0)
        return Descent(draw, found.x, float(found.cost), steps, converged=ended)
    return Descent(draws[0], draws[0], np.inf, len(draws), converged=False, reason=reason)
