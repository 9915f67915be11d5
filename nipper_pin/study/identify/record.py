"""An identification as plain data, for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .fitting.determine import DETERMINED, Determinability
from .fitting.fit import Fit
from .fitting.goodness import Goodness
from .fitting.limits import LIMITS
from .fitting.profiles import Profile

WORD = (
    "Fitted, not validated: numbers that were adjusted to the targets cannot be confirmed by them. "
    "An estimate, never the maker's data."
)


def record(
    fit: Fit, judged: Goodness, known: Determinability, profiles: Sequence[Profile] = ()
) -> dict[str, Any]:
    """Return an identification as plain data."""
    problem = fit.objective.problem
    return {
        "title": problem.title,
        "model": problem.mechanism.name,
        "caution": WORD,
        "seed": fit.seed,
        "cost": fit.best.cost,
        "starts": [
            {
                "cost": item.cost if np.isfinite(item.cost) else None,
                "steps": item.steps,
                "converged": item.converged,
                "from": fit.objective.values(item.start),
                "to": fit.objective.values(item.z) if np.isfinite(item.cost) else None,
            }
            for item in fit.descents
        ],
        "goodness": _goodness(judged),
        "within_4_percent": fit.within(0.04),
        "within_10_percent": fit.within(0.10),
        "targets": _targets(fit, judged),
        "limits": dict(zip(LIMITS, map(float, fit.excess), strict=False)),
        "broken_limits": fit.broken_limits,
        "parameters": _numbers(fit, judged, known),
        "correlations": known.correlations.tolist(),
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


def _goodness(judged: Goodness) -> dict[str, Any]:
    return {
        "verdict": judged.verdict.value,
        "sentence": judged.sentence(),
        "chi_square": judged.chi_square,
        "degrees_of_freedom": judged.degrees_of_freedom,
        "probability": judged.probability,
        "scale": judged.scale,
        "absolute_sigma": judged.absolute_sigma,
        "outliers": [judged.names[place] for place in judged.outliers],
        "suspects": list(judged.suspects),
    }


def _targets(fit: Fit, judged: Goodness) -> list[dict[str, Any]]:
    return [
        {
            "name": target.name,
            "wanted": target.value,
            "sigma": target.sigma,
            "found": float(fit.predicted[place]),
            "relative_deviation": _or_none(fit.deviations[place]),
            "residual_sigmas": float(judged.residuals[place]),
            "outlier": place in judged.outliers,
            "premise_holds": fit.premise_holds(target),
        }
        for place, target in enumerate(fit.objective.problem.targets)
    ]


def _numbers(fit: Fit, judged: Goodness, known: Determinability) -> list[dict[str, Any]]:
    left, given = dict(known.ranked()), known.deviations
    scaled = known.scaled_deviations(judged.scale) if judged.scale else {}
    return [
        {
            "path": item.path,
            "low": item.low,
            "high": item.high,
            "before": item.start,
            "identified": fit.values[item.path],
            "standard_deviation": given[item.path] * item.width,
            "standard_deviation_scaled": scaled[item.path] * item.width if scaled else None,
            "range_left": left[item.path],
            "determined": left[item.path] < DETERMINED,
            "at_bound": fit.at_bounds.get(item.path),
            "why": item.why,
        }
        for item in fit.objective.problem.parameters
    ]


def _or_none(value: float) -> float | None:
    """JSON has no infinity: a value that was to be zero has no relative deviation."""
    return float(value) if np.isfinite(value) else None
