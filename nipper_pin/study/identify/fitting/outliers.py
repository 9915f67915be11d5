"""Targets that lie farther off than chance explains: studentized residuals, one after the other."""

from __future__ import annotations

import numpy as np
from scipy.stats import norm, t

from ....arrays import FloatArray
from ....tolerances.study import LEAST_FREE_SHARE, OUTLYING

# Standard deviation of a uniform distribution: 1 / sqrt(12) of the range.
_RANGE = 12.0


def leverages(jacobian: FloatArray, prior_weight: float) -> FloatArray:
    """Part of each target that is fitted away: the diagonal of J (J' J + P)^-1 J'.

    Args:
        jacobian: Derivatives J of the residuals by the numbers, in units of their ranges, shape
            (targets, numbers).
        prior_weight: Of the problem; P = 12 + its square.

    Returns:
        Shape (targets,).
    """
    left, values, _ = np.linalg.svd(jacobian, full_matrices=False)
    return np.asarray(left**2 @ (values**2 / (values**2 + _RANGE + prior_weight**2)))


def outliers(
    residuals: FloatArray, jacobian: FloatArray, prior_weight: float, *, absolute: bool
) -> tuple[int, ...]:
    """Find outliers: the worst is taken away, the numbers are fitted again (linearly), and so on.

    The worst of n targets is one if its studentized residual is so large only with a probability
    below :data:`.OUTLYING` (Bonferroni's bound). Without the second fit a single wrong target
    would drag others out with it.

    Args:
        residuals: Of a fit, in sigmas, shape (targets,).
        jacobian: Their derivatives, shape (targets, numbers).
        prior_weight: Of the problem.
        absolute: Whether the sigmas are standard deviations. If not, the scale is that of all
            other targets (Student's distribution).

    Returns:
        Places of the outliers, the worst first. If more than a third of the targets would have to
        go, the misfit is not that of single ones, and they are all that lie outside at first.
    """
    kept = list(range(len(residuals)))
    found: list[int] = []
    at_first: tuple[int, ...] = ()
    while kept:
        rows = jacobian[kept]
        here = residuals[kept] - rows @ _refitted(residuals[kept], rows, prior_weight)
        size, chance = _chances(here, leverages(rows, prior_weight), absolute=absolute)
        order = np.argsort(-size, kind="stable")
        beyond = [kept[place] for place in order if chance[place] * len(kept) < OUTLYING]
        if not found:
            at_first = tuple(beyond)
        if not beyond:
            return tuple(found)
        if len(found) >= len(residuals) // 3:
            return at_first
        found.append(beyond[0])
        kept.remove(beyond[0])
    return at_first


def _refitted(residuals: FloatArray, jacobian: FloatArray, prior_weight: float) -> FloatArray:
    """Step of the numbers to the best fit of some targets, as far as it is linear."""
    known = np.eye(jacobian.shape[1]) * (_RANGE + prior_weight**2)
    return np.asarray(np.linalg.solve(jacobian.T @ jacobian + known, jacobian.T @ residuals))


def _chances(
    residuals: FloatArray, leverage: FloatArray, *, absolute: bool
) -> tuple[FloatArray, FloatArray]:
    """Sizes of the studentized residuals, and the probability of each if it stood alone."""
    # A target that alone determines a number has no residual, and cannot be an outlier.
    size = np.abs(residuals) / np.sqrt(np.maximum(1.0 - leverage, LEAST_FREE_SHARE))
    if absolute:
        return size, 2.0 * norm.sf(size)
    freedom = len(residuals) - leverage.sum() - 1.0
    if freedom <= 0.0:
        return size, np.ones_like(size)
    others = np.maximum(residuals @ residuals - size**2, 0.0) / freedom
    with np.errstate(divide="ignore"):
        return size, 2.0 * t.sf(size / np.sqrt(others), freedom)
