"""Derivatives of residuals by unit coordinates, which run from 0 to 1 between their bounds.

A step that makes no machine is taken to the other side: the edge of what can be simulated has a
derivative on one side.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import numpy as np

from ....arrays import FloatArray
from ....errors import NipperError
from ....tolerances.study import FIT_DESCENT_STEP, FIT_STEP

Function = Callable[[FloatArray], FloatArray]


def slopes(function: Function, z: FloatArray) -> FloatArray:
    """One-sided differences: half the work, enough to go down.

    Args:
        function: From unit coordinates to rows.
        z: Unit coordinates, shape (free,).

    Returns:
        Shape (rows, free).

    Raises:
        NipperError: There is no machine here, or none on either side.
    """
    here = function(z)

    def slope(place: int, step: float) -> FloatArray:
        return np.asarray((function(_moved(z, place, step)) - here) / step)

    return np.array([_either(slope, z, place, FIT_DESCENT_STEP) for place in range(len(z))]).T


def jacobian(function: Function, z: FloatArray) -> FloatArray:
    """Central differences; at a bound, or beside an edge, one-sided ones of the same order.

    Arguments, shape and errors are those of :func:`slopes`.
    """

    def one_sided(place: int, step: float) -> FloatArray:
        first, second = (function(_moved(z, place, part * step)) for part in (1.0, 2.0))
        return np.asarray((4.0 * first - second - 3.0 * function(z)) / (2.0 * step))

    def central(place: int) -> FloatArray:
        ahead, behind = (function(_moved(z, place, step)) for step in (FIT_STEP, -FIT_STEP))
        return np.asarray((ahead - behind) / (2.0 * FIT_STEP))

    columns = []
    for place, x in enumerate(z):
        column = None
        if FIT_STEP <= x <= 1.0 - FIT_STEP:
            with suppress(NipperError):
                column = central(place)
        columns.append(_either(one_sided, z, place, FIT_STEP) if column is None else column)
    return np.array(columns).T


def _either(
    slope: Callable[[int, float], FloatArray], z: FloatArray, place: int, step: float
) -> FloatArray:
    """The slope by a step inwards, or outwards where there is no machine."""
    inwards = step if z[place] < 0.5 else -step
    try:
        return slope(place, inwards)
    except NipperError:
        return slope(place, -inwards)


def _moved(z: FloatArray, place: int, step: float) -> FloatArray:
    there = z.copy()
    there[place] += step
    return there
