"""Which numbers the targets can determine at all: scaled Jacobian, singular values, deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....arrays import FloatArray
from .differences import jacobian
from .objective import Objective

DETERMINED = 0.5
"""A number counts as determined if the targets narrow its range to less than this part."""

# Standard deviation of a uniform distribution over the range of a number, in units of the range.
_RANGE_SIGMA = 1.0 / np.sqrt(12.0)


@dataclass(frozen=True, eq=False)
class Determinability:
    """Information of the targets on the free numbers, linearised at a fit.

    All numbers are in units of their ranges, all targets in units of their sigmas; limits and
    prior are left out: this is about the data.

    Attributes:
        paths: The free numbers, n of them.
        jacobian: Derivatives of the targets, shape (targets, n).
        singular_values: Of the Jacobian, falling, shape (min(targets, n),). A direction with a
            value s changes the targets by s sigmas over the whole range.
        directions: Rows: the directions they belong to, shape (min(targets, n), n).
        narrowed: Standard deviation of every number with the targets by that without them
            (nothing but its range known): 1 not determined, 0 determined exactly; shape (n,).
        correlations: Of the numbers' errors, with sigmas as they are given, shape (n, n).
    """

    paths: tuple[str, ...]
    jacobian: FloatArray
    singular_values: FloatArray
    directions: FloatArray
    narrowed: FloatArray
    correlations: FloatArray

    @property
    def identifiable_directions(self) -> int:
        """Number of directions that the targets narrow to less than ``DETERMINED``."""
        limit = np.sqrt(1.0 / DETERMINED**2 - 1.0) / _RANGE_SIGMA
        return int(np.count_nonzero(self.singular_values > limit))

    @property
    def determined(self) -> tuple[str, ...]:
        """Numbers that the targets determine, the best first."""
        order = np.argsort(self.narrowed, kind="stable")
        return tuple(self.paths[i] for i in order if self.narrowed[i] < DETERMINED)

    @property
    def deviations(self) -> dict[str, float]:
        """Standard deviations of all numbers by path, with the targets, in units of their ranges.

        Of a number that the targets leave open this is the one of its range alone, 1 / sqrt(12).
        """
        return self.scaled_deviations(1.0)

    def scaled_deviations(self, scale: float) -> dict[str, float]:
        """Return the same as they would be with other sigmas.

        Args:
            scale: Factor of all sigmas, above zero.
        """
        covariance = _covariance(self.jacobian / scale)
        return dict(zip(self.paths, np.sqrt(np.diag(covariance)).tolist(), strict=True))

    def strongest(self, least: float) -> tuple[tuple[str, str, float], ...]:
        """Pairs of numbers whose errors are correlated, the strongest first.

        Args:
            least: Least size of the correlation.
        """
        rows, columns = np.triu_indices(len(self.paths), 1)
        sizes = self.correlations[rows, columns]
        order = np.argsort(-np.abs(sizes), kind="stable")
        return tuple(
            (self.paths[rows[k]], self.paths[columns[k]], float(sizes[k]))
            for k in order
            if abs(sizes[k]) >= least
        )

    def ranked(self) -> tuple[tuple[str, float], ...]:
        """All numbers with what is left of their ranges, the best determined first."""
        order = np.argsort(self.narrowed, kind="stable")
        return tuple((self.paths[i], float(self.narrowed[i])) for i in order)


def determinability(objective: Objective, z: FloatArray) -> Determinability:
    """Linearise the targets and see what they determine.

    The uncertainty is that of a linear model with a prior as wide as the range of each number,
    C = (J' J + 12 I)^-1.

    Args:
        z: Unit coordinates, shape (free,).

    Raises:
        NipperError: The transitions cannot be simulated here.
    """
    derivatives = jacobian(lambda x: objective.misfit(objective.predicted(x)), z)
    _, values, rows = np.linalg.svd(derivatives, full_matrices=False)
    covariance = _covariance(derivatives)
    deviations = np.sqrt(np.diag(covariance))
    return Determinability(
        paths=tuple(item.path for item in objective.problem.parameters),
        jacobian=derivatives,
        singular_values=values,
        directions=rows,
        narrowed=deviations / _RANGE_SIGMA,
        correlations=covariance / np.outer(deviations, deviations),
    )


def _covariance(jacobian: FloatArray) -> FloatArray:
    """C = (J' J + 12 I)^-1, in units of the ranges, shape (n, n)."""
    known = np.eye(jacobian.shape[1]) / _RANGE_SIGMA**2
    return np.asarray(np.linalg.inv(jacobian.T @ jacobian + known))
