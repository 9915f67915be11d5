"""An identification as plain data, for JSON, and read back."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from .determine import DETERMINED, Determinability, Profile
from .fit import Fit
from .objective import LIMITS

WORD = (
    "Fitted, not validated: numbers that were adjusted to the targets cannot be confirmed by them. "
    "An estimate, never the maker's data."
)

_KEYS = {"title", "model", "caution", "seed", "targets", "free", "within_4_percent",
         "singular_values", "identifiable_directions", "profiles"}  # fmt: skip
_TARGET_KEYS = {"name", "wanted", "found", "relative_deviation"}
_FREE_KEYS = {"path", "low", "high", "before", "identified", "range_left", "determined"}


def record(fit: Fit, known: Determinability, profiles: Sequence[Profile] = ()) -> dict[str, Any]:
    """Return an identification as plain data.

    Args:
        fit: The fit.
        known: What the targets determine.
        profiles: Profile likelihoods.
    """
    problem = fit.objective.problem
    left, deviations = dict(known.ranked()), known.deviations
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
                "standard_deviation": deviations[item.path] * (item.high - item.low),
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


def read_identification(path: str | Path) -> dict[str, Any]:
    """Read what ``nipper-pin identify --json FILE`` wrote.

    Args:
        path: The file.

    Raises:
        InputError: It cannot be read, or is not such a document.
    """
    try:
        document = json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        message = (
            f"{path}: cannot be read as JSON ({error}); write it by nipper-pin identify --json"
        )
        raise InputError(message, file=str(path)) from error
    right = isinstance(document, dict) and document.keys() >= _KEYS
    for key, needed in (("targets", _TARGET_KEYS), ("free", _FREE_KEYS)):
        rows = document[key] if right else None
        right = isinstance(rows, list) and all(
            isinstance(row, dict) and row.keys() >= needed for row in rows
        )
    if not right:
        message = f"{path}: is no identification; write it by nipper-pin identify --json"
        raise InputError(message, file=str(path))
    return dict(document)
