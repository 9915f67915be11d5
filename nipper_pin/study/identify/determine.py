"""Which numbers the targets can determine at all: scaled Jacobian, singular values, profiles."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from ...arrays import FloatArray
from ..processes import mapped
from .fit import Fit
from .objective import Objective

DETERMINED = 0.5
"""A number counts as determined if the targets narrow its range to less than this part."""

# Standard deviation of a number of which nothing but its range is known, in units of the range.
_RANGE_SIGMA = 1.0 / np.sqrt(12.0)
_STEPS = 30


@dataclass(frozen=True, eq=False)
class Determinability:
    """What the targets say about the free numbers, linearised at a fit.

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
    """

    paths: tuple[str, ...]
    jacobian: FloatArray
    singular_values: FloatArray
    directions: FloatArray
    narrowed: FloatArray

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
        return dict(zip(self.paths, (_RANGE_SIGMA * self.narrowed).tolist(), strict=True))

    def ranked(self) -> tuple[tuple[str, float], ...]:
        """All numbers with what is left of their ranges, the best determined first."""
        order = np.argsort(self.narrowed, kind="stable")
        return tuple((self.paths[i], float(self.narrowed[i])) for i in order)


def determinability(objective: Objective, z: FloatArray) -> Determinability:
    """Linearise the targets and see what they determine.

    The uncertainty is that of a linear model with a prior as wide as the range of each number,
    C = (J' J + 12 I)^-1.

    Args:
        objective: The residuals of a problem.
        z: Unit coordinates, shape (free,).

    Raises:
        NipperError: The transitions cannot be simulated here.
    """
    jacobian = objective.jacobian(z, lambda x: objective.misfit(objective.predicted(x)))
    _, values, rows = np.linalg.svd(jacobian, full_matrices=False)
    covariance = np.linalg.inv(jacobian.T @ jacobian + np.eye(len(z)) / _RANGE_SIGMA**2)
    return Determinability(
        paths=tuple(item.path for item in objective.problem.free),
        jacobian=jacobian,
        singular_values=values,
        directions=rows,
        narrowed=np.sqrt(np.diag(covariance)) / _RANGE_SIGMA,
    )


@dataclass(frozen=True, eq=False)
class Profile:
    """Profile likelihood of one number: the best of all others for each of its values.

    Attributes:
        path: The number.
        values: Its values, shape (points,).
        cost: Half the least sum of squares for each, above that of the fit, shape (points,).
            A value is off by one standard deviation where this is 1/2.
        quadratic: The same of the linear model, shape (points,).
        sigma: Standard deviation in the linear model, limits and prior included.
    """

    path: str
    values: FloatArray
    cost: FloatArray
    quadratic: FloatArray
    sigma: float


def profile(
    fit: Fit, path: str, *, points: int = 5, reach: float = 2.0, workers: int | None = None
) -> Profile:
    """Follow the best fit while one number is held at several values.

    Args:
        fit: The fit.
        path: A free number.
        points: Number of values, spread evenly about the fit.
        reach: Farthest value, in standard deviations of the linear model; bounds cut it short.
        workers: Processes; by default as many as there are processors.
    """
    objective, z = fit.objective, fit.best.z
    place = [item.path for item in objective.problem.free].index(path)
    jacobian = objective.jacobian(z)
    # Numbers on a bound cannot move both ways: the linear model leaves them where they are.
    free = [i for i in range(len(z)) if i == place or 1e-3 < z[i] < 1.0 - 1e-3]
    covariance = np.linalg.pinv(jacobian[:, free].T @ jacobian[:, free])
    sigma = float(np.sqrt(covariance[free.index(place), free.index(place)]))
    low, high = max(0.0, z[place] - reach * sigma), min(1.0, z[place] + reach * sigma)
    grid = np.linspace(low, high, points)
    task = partial(_held, objective, z, place)
    count = workers if workers is not None else os.cpu_count() or 1
    cost = np.array(list(mapped(task, grid, count))) - fit.best.cost
    # Only a number that its bound holds back has a slope at the best fit.
    slope = float(jacobian[:, place] @ objective.residuals(z))
    off = grid - z[place]
    width = objective.width[place]
    return Profile(
        path=path,
        values=objective.low[place] + width * grid,
        cost=cost,
        quadratic=slope * off + 0.5 * (off / sigma) ** 2,
        sigma=sigma * width,
    )


def _held(objective: Objective, z: FloatArray, place: int, value: float) -> float:
    """Least cost with one unit coordinate held."""
    others = [i for i in range(len(z)) if i != place]

    def whole(part: FloatArray) -> FloatArray:
        point = np.empty(len(z))
        point[place], point[others] = value, part
        return point

    if not others:
        return 0.5 * float(np.sum(objective.residuals(whole(np.empty(0))) ** 2))
    found = least_squares(
        lambda part: objective.residuals(whole(part)),
        np.clip(z[others], 1e-6, 1.0 - 1e-6),
        jac=lambda part: objective.slopes(whole(part))[:, others],
        bounds=(0.0, 1.0),
        ftol=1e-7,
        xtol=1e-6,
        gtol=1e-6,
        max_nfev=_STEPS,
    )
    return float(found.cost)
