"""Profile likelihoods: the misfit while one number is held and all others are fitted again."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.optimize import least_squares

from ....arrays import FloatArray
from ....errors import NipperError
from ....tolerances.study import FIT_LAST_STEP, FIT_START, PROFILE_END
from ...processes import mapped, worker_count
from .differences import jacobian, slopes
from .fit import Fit
from .objective import Objective

_STEPS = 30


@dataclass(frozen=True, eq=False)
class Profile:
    """Profile likelihood of one number: the best of all others for each of its values.

    Attributes:
        path: The number.
        values: Its values, shape (points,); those that make no machine are left out.
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
        path: A free number.
        points: Number of values, spread evenly about the fit.
        reach: Farthest value, in standard deviations of the linear model; bounds cut it short.
        workers: Processes; by default as many as there are processors.
    """
    objective, z = fit.objective, fit.best.z
    place = [item.path for item in objective.problem.parameters].index(path)
    derivatives = jacobian(objective.rows, z)
    # Numbers on a bound cannot move both ways: the linear model leaves them where they are.
    free = [i for i in range(len(z)) if i == place or 1e-3 < z[i] < 1.0 - 1e-3]
    covariance = np.linalg.pinv(derivatives[:, free].T @ derivatives[:, free])
    sigma = float(np.sqrt(covariance[free.index(place), free.index(place)]))
    low, high = max(0.0, z[place] - reach * sigma), min(1.0, z[place] + reach * sigma)
    grid = np.linspace(low, high, points)
    task = partial(_held, objective, z, place)
    cost = np.array(list(mapped(task, grid, worker_count(workers)))) - fit.best.cost
    # Values that make no machine have no cost.
    grid, cost = grid[np.isfinite(cost)], cost[np.isfinite(cost)]
    # Only a number that its bound holds back has a slope at the best fit.
    slope = float(derivatives[:, place] @ objective.residuals(z))
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
    """Least cost with one unit coordinate held; infinite if it makes no machine."""
    others = [i for i in range(len(z)) if i != place]

    def whole(part: FloatArray) -> FloatArray:
        point = np.empty(len(z))
        point[place], point[others] = value, part
        return point

    begin = np.clip(z[others], FIT_START, 1.0 - FIT_START)
    try:
        rows = objective.rows(whole(begin))
        if not others:
            return 0.5 * float(rows @ rows)
        fenced = objective.fenced(rows)
        found = least_squares(
            lambda part: fenced.residuals(whole(part)),
            begin,
            jac=lambda part: slopes(fenced.rows, whole(part))[:, others],
            bounds=(0.0, 1.0),
            ftol=PROFILE_END,
            xtol=FIT_LAST_STEP,
            gtol=FIT_LAST_STEP,
            max_nfev=_STEPS,
        )
    except NipperError:
        return np.inf
    return float(found.cost)
