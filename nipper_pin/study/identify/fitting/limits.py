"""Excess of a working cycle over its limits, each in units of its uncertainty."""

from __future__ import annotations

import math

import numpy as np

from ....arrays import FloatArray
from ....mechanism import index_difference
from ..problem.problem import Limits
from ..problem.working_cycle import SAMPLES, WorkingCycle

INDEX_SIGMA = 0.05
"""Uncertainty of an index limit: a limit broken by this counts like a target off by one sigma."""
FORCE_SIGMA_N = 1.0
"""The same for the stop force [N]."""
OPENING_SIGMA_DEG = 0.2
"""The same for the opening of the jaw [deg]."""

LIMITS = ("closing_index", "opening_index", "jaw_opening_deg", "stop_force_N")
"""Limits of the working cycle."""
BROKEN = 1.0
"""A limit that is missed by more sigmas than this is broken: they are weights in a sum of squares,
so a fit that leans on one is always a little outside."""
_SIGMAS = dict(
    zip(LIMITS, (INDEX_SIGMA, INDEX_SIGMA, OPENING_SIGMA_DEG, FORCE_SIGMA_N), strict=True)
)


def excesses(limits: Limits, cycle: WorkingCycle) -> FloatArray:
    """Excess of a working cycle over its limits, in sigmas, in the order of :data:`LIMITS`.

    Returns:
        Zero inside, shape (4,); of the stop force the worst.
    """
    rows = limit_rows(limits, cycle)
    return np.array([*rows[:3], rows[3:].min()])


def broken_limits(excess: FloatArray) -> dict[str, float]:
    """Limits that are broken, and by how much, each in its own unit.

    Args:
        excess: What :func:`excesses` gave, shape (4,); empty without limits.
    """
    return {
        name: float(value) * _SIGMAS[name]
        for name, value in zip(LIMITS, excess, strict=False)
        if abs(value) > BROKEN
    }


def limit_rows(limits: Limits, cycle: WorkingCycle) -> FloatArray:
    """Rows of the residuals for limits.

    The stop force has a row for each of its samples: the least of them alone would have a kink
    wherever another sample becomes the least, and a descent would stick there.

    Returns:
        Closing and opening index, opening of the jaw, and the force of every sample, in sigmas
        outside the limits, shape (3 + SAMPLES,).
    """
    rows = np.zeros(3 + SAMPLES)
    for row, (value, bounds) in enumerate(
        (
            (cycle.closing_index, limits.closing_index),
            (cycle.opening_index, limits.opening_index),
        )
    ):
        if bounds is not None:
            rows[row] = _outside(value, *bounds) / INDEX_SIGMA
    if limits.jaw_opening_deg is not None:
        widest = math.degrees(cycle.waiting.gap.max())
        rows[2] = min(0.0, widest - limits.jaw_opening_deg) / OPENING_SIGMA_DEG
    if limits.stop_force_N is not None:
        short = np.minimum(0.0, cycle.waiting.force - limits.stop_force_N)
        rows[3:] = short / FORCE_SIGMA_N
    return rows


def _outside(index: float, low: float, high: float) -> float:
    """Distance of an index from a range, the short way around the turn, with its sign."""
    away = index_difference(index, 0.5 * (low + high))
    half = 0.5 * (high - low)
    return float(np.sign(away) * max(0.0, abs(away) - half))
