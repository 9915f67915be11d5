"""How good a fit is: chi-square and its probability, residuals in sigmas, and what lies outside."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np
from scipy.stats import chi2

from ....arrays import FloatArray
from ....errors import MisfitError
from ....tolerances.study import CONTRADICTED
from .determine import Determinability
from .objective import Objective
from .outliers import leverages, outliers
from .suspects import suspected_units

UNSCALABLE = 10.0
"""Sigmas that are weights alone may be too small by this factor; beyond it the fit is wrong."""

# With less than half a degree of freedom nothing is left over that could test a fit.
_LEAST_FREEDOM = 0.5
_NAMED = 5


class Verdict(Enum):
    """Verdicts on a fit by its misfit."""

    AGREES = "agrees"
    TOO_GOOD = "too good"
    CONTRADICTED = "contradicted"
    WEIGHTS_ALONE = "weights alone"
    UNTESTED = "untested"


@dataclass(frozen=True, eq=False, kw_only=True)
class Goodness:
    """Goodness of a fit, of its targets alone: limits and prior are no data.

    Attributes:
        names: Names of the targets, n of them.
        residuals: (found - wanted) / sigma of every target, shape (n,).
        chi_square: Sum of the squared residuals.
        fitted: Effective number of numbers that the targets determine: the trace of the hat
            matrix, numbers at their bounds left out.
        probability: Probability of a chi-square as large as this one or larger; None where there
            is nothing left over to test, or sigmas are weights alone.
        outliers: Places of targets that lie outside of what chance explains, the worst first
            (:func:`nipper_pin.study.identify.fitting.outliers.outliers`).
        suspects: What units the targets may be in by mistake, in words.
        absolute_sigma: Whether the sigmas are standard deviations, or weights alone.
    """

    names: tuple[str, ...]
    residuals: FloatArray
    chi_square: float
    fitted: float
    probability: float | None
    outliers: tuple[int, ...]
    suspects: tuple[str, ...]
    absolute_sigma: bool

    @property
    def degrees_of_freedom(self) -> float:
        """Number of targets less the effective number of fitted numbers."""
        return len(self.residuals) - self.fitted

    @property
    def scale(self) -> float | None:
        """Factor of all sigmas that makes chi-square its degrees of freedom; None without any."""
        if self.degrees_of_freedom < _LEAST_FREEDOM:
            return None
        return float(np.sqrt(self.chi_square / self.degrees_of_freedom))

    @property
    def verdict(self) -> Verdict:
        """Verdict by the misfit."""
        if self.scale is None:
            return Verdict.CONTRADICTED if self.suspects else Verdict.UNTESTED
        if self.probability is None:
            wrong = self.suspects or self.scale > UNSCALABLE
            return Verdict.CONTRADICTED if wrong else Verdict.WEIGHTS_ALONE
        if self.probability < CONTRADICTED:
            return Verdict.CONTRADICTED
        return Verdict.TOO_GOOD if self.probability > 1.0 - CONTRADICTED else Verdict.AGREES

    def sentence(self) -> str:
        """Verdict by the misfit as a sentence."""
        if self.scale is None:
            return " ".join(
                [
                    f"The targets ({len(self.names)}) are no more than the numbers that they "
                    f"determine ({self.fitted:.3g}): nothing is left over that could test the fit.",
                    *self._reasons(),
                ]
            )
        found = (
            f"chi-square {self.chi_square:.4g}, degrees of freedom {self.degrees_of_freedom:.3g}"
        )
        if self.probability is not None:
            found += f", probability {self.probability:.2g}"
        words = {
            Verdict.AGREES: f"The data agree with the fit: {found}.",
            Verdict.TOO_GOOD: f"The fit is better than its sigmas allow: {found}. They are "
            "stated too large, or the targets are no measurements.",
            Verdict.WEIGHTS_ALONE: f"Sigmas are weights alone, so there is no test of the fit: "
            f"{found}; sigmas {self.scale:.3g} times as large would be met.",
            Verdict.CONTRADICTED: f"THE DATA CONTRADICT THE FIT: {found}. Its numbers and their "
            "standard deviations are not to be used.",
        }
        return " ".join([words[self.verdict], *self._reasons()])

    def check(self) -> None:
        """Refuse a fit that its data contradict.

        Raises:
            MisfitError: They do.
        """
        if self.verdict is Verdict.CONTRADICTED:
            raise MisfitError(
                self.sentence(),
                chi_square=self.chi_square,
                degrees_of_freedom=self.degrees_of_freedom,
                probability=self.probability,
                outliers=[self.names[place] for place in self.outliers],
            )

    def _reasons(self) -> list[str]:
        """Possible causes of a misfit: units, single targets, or all sigmas."""
        text = list(self.suspects)
        if self.outliers and not self.suspects:
            worst = ", ".join(
                f"{self.names[place]} ({self.residuals[place]:+.3g} sigmas)"
                for place in self.outliers[:_NAMED]
            )
            more = len(self.outliers) - _NAMED
            text.append(f"Outliers: {worst}{f' and {more} more' if more > 0 else ''}.")
        if self.verdict is Verdict.CONTRADICTED and self.scale is not None and not self.suspects:
            text.append(
                f"Either measurements are wrong, or sigmas are too small ({self.scale:.3g} times "
                "as large would be met), or the model lacks something."
            )
        return text


def goodness(
    objective: Objective, z: FloatArray, predicted: FloatArray, known: Determinability
) -> Goodness:
    """Return the goodness of a fit by the residuals of its targets.

    The targets see n - p degrees of freedom, p = trace(J C J'), with the derivatives J of the
    residuals by the numbers that are inside their bounds and C = (J' J + P)^-1; P holds what is
    known of the numbers otherwise, their ranges and the prior. Where the targets determine all of
    k numbers, p = k to the digits that are shown.

    Args:
        objective: The problem as residuals.
        z: Unit coordinates of the fit, shape (free,).
        predicted: Values of the targets there, shape (targets,).
        known: What the targets determine, at this fit.
    """
    problem = objective.problem
    residuals = objective.misfit(predicted)
    # Numbers at a bound could not follow the targets.
    jacobian = known.jacobian[:, (z > 1e-3) & (z < 1.0 - 1e-3)]
    leverage = leverages(jacobian, problem.prior_weight)
    fitted, chi_square = float(leverage.sum()), float(residuals @ residuals)
    freedom = len(residuals) - fitted
    tested = freedom >= _LEAST_FREEDOM
    probability = None
    if tested and problem.absolute_sigma:
        probability = float(chi2.sf(chi_square, freedom))
    return Goodness(
        names=tuple(target.name for target in problem.targets),
        residuals=residuals,
        chi_square=chi_square,
        fitted=fitted,
        probability=probability,
        outliers=outliers(
            residuals, jacobian, problem.prior_weight, absolute=problem.absolute_sigma
        )
        if tested
        else (),
        suspects=suspected_units(objective, z, predicted),
        absolute_sigma=problem.absolute_sigma,
    )
