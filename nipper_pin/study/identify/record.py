"""An identification as plain data, for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .determine import DETERMINED, Determinability, Profile
from .fit import Fit
from .objective import LIMITS

WORD = (
    "Fitted, not validated: numbers that were adjusted to the targets cannot be confirmed by them. "
    "An estimate, never the maker's data."
)


def record(fit: Fit, known: Determinability, profiles: Sequence[Profile] = ()) -> dict[str, Any]:
    """Return an identification as plain data.

    Args:
        fit: The fit.
        known: What the targets determine.
        profiles: Profile likelihoods.
    """
    problem = fit.objective.problem
    left = dict(known.ranked())
    return {
        "title": problem.title,
        "model": problem.sources.name,
        "caution": WORD,
        "seed": fit.seed,
        "cost": fit.best.cost,
        "starts": [
            {
                "cost": item.cost if np.isfinite(item.cost) else None,
                "steps": item.steps,
                "converged": item.converged,
            }
            for item in fit.descents
        ],
        "within_4_percent": fit.within(0.04),
        "within_10_percent": fit.within(0.10),
        "targets": [
            {
                "name": target.name,
                "wanted": target.value,
                "sigma": target.sigma,
                "found": float(found),
                "relative_deviation": float(deviation),
            }
            for target, found, deviation in zip(
                problem.targets, fit.predicted, fit.deviations, strict=True
            )
        ],
        "limits": dict(zip(LIMITS, map(float, fit.broken), strict=False)),
        "free": [
            {
                "path": item.path,
                "low": item.low,
                "high": item.high,
                "before": item.start,
                "identified": fit.values[item.path],
                "range_left": left[item.path],
                "determined": left[item.path] < DETERMINED,
                "why": item.why,
            }
            for item in problem.free
        ],
        "singular_values": known.singular_values.tolist(),
        "directions": [
            dict(zip(known.paths, row, strict=True)) for row in known.directions.tolist()
        ],
        "identifiable_directions": known.identifiable_directions,
        "profiles": [
            {
                "path": item.path,
                "sigma": item.sigma,
                "values": item.values.tolist(),
                "cost": item.cost.tolist(),
                "quadratic": item.quadratic.tolist(),
            }
            for item in profiles
        ],
    }
