"""A fit: least squares inside bounds, one descent, and what the best of several came to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.optimize import least_squares

from ....arrays import FloatArray
from ....errors import MisfitError, NipperError
from ....hybrid.result.premise import Premise
from ....tolerances.study import AT_BOUND, FIT_END, FIT_LAST_STEP, FIT_START
from ..problem.targets import Condition, Target
from .determine import Determinability, determinability
from .differences import slopes
from .goodness import Goodness, goodness
from .limits import broken_limits
from .objective import Objective

_MAX_STEPS = 60


@dataclass(frozen=True, eq=False)
class Descent:
    """One start and the end of its descent.

    Attributes:
        start: Unit coordinates of the start, shape (free,).
        z: Unit coordinates of the end, shape (free,).
        cost: Half the sum of squares of all residuals there; infinite if no machine was found.
        steps: Evaluations of the residuals, those for derivatives left out.
        converged: Whether it ended by its tolerance.
    """

    start: FloatArray
    z: FloatArray
    cost: float
    steps: int
    converged: bool


@dataclass(frozen=True, eq=False)
class Fit:
    """The best of several descents.

    Attributes:
        objective: The problem as residuals.
        seed: Seed of the starts.
        descents: All descents, the best first; equal ones in the order of their starts.
        values: Values of the free numbers by path.
        predicted: Values of the targets, shape (targets,).
        excess: How far the working cycle is outside its limits, in sigmas, in the order of
            ``LIMITS``; zero inside, empty without limits.
        premises: For each setting of the targets whether the machine of the fit arrives as a
            transition assumes. Where it does not, the transition of the turn was taken.
    """

    objective: Objective
    seed: int
    descents: tuple[Descent, ...]
    values: dict[str, float]
    predicted: FloatArray
    excess: FloatArray
    premises: dict[Condition, Premise]

    @cached_property
    def known(self) -> Determinability:
        """Information of the targets on the free numbers at this fit."""
        return determinability(self.objective, self.best.z)

    @cached_property
    def goodness(self) -> Goodness:
        """How good it is: chi-square, outliers, and whether its data contradict it."""
        return goodness(self.objective, self.best.z, self.predicted, self.known)

    def check(self) -> None:
        """Refuse a fit that cannot be used.

        Raises:
            MisfitError: Its data contradict it, or it breaks a limit.
        """
        self.goodness.check()
        if self.broken_limits:
            words = ", ".join(f"{name} by {by:+.3g}" for name, by in self.broken_limits.items())
            message = (
                f"the fit breaks limits: {words}. No machine that was found meets them and the "
                "targets: free more numbers, widen their ranges, or doubt targets and limits"
            )
            raise MisfitError(message, limits=self.broken_limits)

    @property
    def broken_limits(self) -> dict[str, float]:
        """Limits that are broken, and by how much, each in its own unit."""
        return broken_limits(self.excess)

    @property
    def at_bounds(self) -> dict[str, str]:
        """Numbers that end at a bound of their range: "low" or "high", by path."""
        ends = zip(self.objective.problem.parameters, self.best.z, strict=True)
        return {
            item.path: "low" if z < 0.5 else "high"
            for item, z in ends
            if min(z, 1.0 - z) < AT_BOUND
        }

    @property
    def best(self) -> Descent:
        """The descent with the least cost."""
        return self.descents[0]

    @property
    def deviations(self) -> FloatArray:
        """Relative deviations from the targets, predicted / wanted - 1, shape (targets,)."""
        wanted = np.array([target.value for target in self.objective.problem.targets])
        return np.asarray(self.predicted / wanted - 1.0)

    def premise_holds(self, target: Target) -> bool | None:
        """Whether a target's transitions are as assumed; None where that cannot be told."""
        asked = (target.at, *(() if target.since is None else (target.since,)))
        found = [self.premises[at].holds for at in asked]
        if False in found:
            return False
        return None if None in found else True

    def within(self, part: float) -> int:
        """Number of targets that are met within a relative deviation."""
        return int(np.count_nonzero(np.abs(self.deviations) <= part))


def descend(objective: Objective, begin: FloatArray, max_steps: int = _MAX_STEPS) -> Descent:
    """Go down from one start.

    Args:
        begin: Unit coordinates, shape (free,); or several draws, shape (draws, free), of which
            the first is taken that makes a machine.
        max_steps: Largest number of evaluations, those for derivatives left out.
    """
    draws = np.atleast_2d(begin)
    for draw in draws:
        start = np.clip(draw, FIT_START, 1.0 - FIT_START)
        try:
            fenced = objective.fenced(objective.rows(start))
            found = least_squares(
                fenced.residuals,
                start,
                jac=partial(slopes, fenced.rows),
                bounds=(0.0, 1.0),
                ftol=FIT_END,
                xtol=FIT_LAST_STEP,
                gtol=FIT_LAST_STEP,
                max_nfev=max_steps,
            )
        except NipperError:
            continue
        steps, ended = int(found.nfev), bool(found.status > 0)
        return Descent(draw, found.x, float(found.cost), steps, converged=ended)
    return Descent(draws[0], draws[0], np.inf, len(draws), converged=False)
