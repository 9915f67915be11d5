"""The first place in a step at which a function that was positive turns negative."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq, minimize_scalar

Array = np.ndarray
_SAMPLES = np.linspace(0.0, 1.0, 65)


def first_fall(value: Callable[[Array], Array], noise: float = 1e-11) -> float | None:
    """First root with a falling value in 0 to 1; 0.0 if it is negative from the start.

    Of its largest value ``noise`` is the share of round-off.
    """
    values = value(_SAMPLES)
    small = noise * float(np.abs(values).max())

    def one(place: float) -> float:
        return float(value(np.array([place]))[0])

    below = np.flatnonzero(values < -small)
    last = int(below[0]) if len(below) else len(values)
    dip = _dip(one, values[:last], small)
    if dip is not None:
        before, place = dip
        return _root(one, before, place)
    if last == len(values):
        return None
    over = np.flatnonzero(values[:last] > 0.0)
    if not len(over):
        return 0.0
    return _root(one, float(_SAMPLES[over[-1]]), float(_SAMPLES[last]))


def _root(one: Callable[[float], float], left: float, right: float) -> float:
    if not one(left) > 0.0:
        return left
    return right if one(right) > 0.0 else float(brentq(one, left, right, xtol=1e-15, rtol=8.9e-16))


def _dip(one: Callable[[float], float], values: Array, small: float) -> tuple[float, float] | None:
    """A place between samples where the function is negative, and the sample before it."""
    for i in range(1, len(values) - 1):
        if values[i] <= values[i - 1] and values[i] <= values[i + 1]:
            bend = values[i - 1] - 2.0 * values[i] + values[i + 1]
            if values[i] - bend > 0.0:
                continue
            ends = (float(_SAMPLES[i - 1]), float(_SAMPLES[i + 1]))
            found = minimize_scalar(one, bounds=ends, method="bounded", options={"xatol": 1e-9})
            if found.fun < -small:
                return float(_SAMPLES[i - 1]), float(found.x)
    return None
