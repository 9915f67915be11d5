"""Parameters of cases, checked: numbers, columns of a batch, rows of spring values."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..errors import InputError
from ..tolerances.reduced import COARSEST_TOLERANCE, FINEST_TOLERANCE

# Scratch of so many collisions takes 24 MB.
_MOST_COLLISIONS = 1_000_000


def check_run(rest_rate: float | None, tolerance: float, max_collisions: int) -> None:
    """Check what all cases of a call share.

    Args:
        rest_rate: Threshold of rest [rad/s or m/s], or None.
        tolerance: Relative accuracy.
        max_collisions: Largest number of collisions.

    Raises:
        InputError: One of them is out of range.
    """
    if not FINEST_TOLERANCE <= tolerance <= COARSEST_TOLERANCE:
        message = f"tolerance = {tolerance!r} cannot be used: 1e-13 to 1e-3"
        raise InputError(message, tolerance=tolerance)
    whole("max_collisions", max_collisions, _MOST_COLLISIONS)
    if rest_rate is not None and not (math.isfinite(rest_rate) and rest_rate > 0.0):
        message = f"rest_rate = {rest_rate!r} cannot be used: a finite rate above 0, or none"
        raise InputError(message, rest_rate=rest_rate)


def whole(key: str, value: int, most: int) -> None:
    """Refuse what is no whole number from 1 to the largest one allowed."""
    right = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not (right and 1 <= value <= most):
        allowed = f"a whole number from 1 to {most:,}"
        message = f"{key} = {value!r} cannot be used: {allowed}"
        raise InputError(message, key=key, value=value, allowed=allowed)


def number(key: str, value: float, low: float, high: float, *, open_low: bool = False) -> float:
    """Return one number; anything but a valid number is checked like a column of a batch."""
    if isinstance(value, float) and low < value < high:
        return value
    return float(column(key, [value], low, high, open_low=open_low)[0])


def one_row(key: str, value: ArrayLike | None, default: FloatArray, low: float) -> FloatArray:
    """Values of all springs in one case, shape (springs,)."""
    if value is None:
        return default
    if isinstance(value, float) and low <= value < math.inf:
        return np.full(len(default), value)
    given = _numbers(key, value)
    row: FloatArray = spring_rows(
        key, given if given.ndim == 0 else given[None], len(default), low
    )[0]
    return row


def column(
    key: str, value: ArrayLike, low: float, high: float, *, open_low: bool = False
) -> FloatArray:
    """One number a case, checked.

    Args:
        key: Name of the parameter, for messages.
        value: A number or shape (n,).
        low: Least value allowed, or the one above which all are with ``open_low``.
        high: Largest value allowed.
        open_low: Whether ``low`` itself is excluded.

    Returns:
        Shape (1,) or (n,).

    Raises:
        InputError: A value is out of range, or the array has another shape.
    """
    found = np.atleast_1d(_numbers(key, value))
    right = np.isfinite(found) & (found <= high) & ((found > low) if open_low else (found >= low))
    if found.ndim != 1 or not right.all():
        bound = "above" if open_low else "from"
        allowed = f"finite numbers {bound} {low:g} to {high:g}, one a case"
        message = f"{key} = {value!r} cannot be used: {allowed}"
        raise InputError(message, key=key, value=value, allowed=allowed)
    return found


def spring_rows(key: str, value: ArrayLike, springs: int, low: float) -> FloatArray:
    """One row of spring values a case, checked.

    Args:
        key: Name of the parameter, for messages.
        value: One number for all, shape (n,) with one spring or (springs,) with more, or
            (n, springs).
        springs: Number of springs.
        low: Least value allowed.

    Returns:
        Shape (1 or n, springs).

    Raises:
        InputError: A value is out of range, or the array has another shape.
    """
    found = _numbers(key, value)
    if found.ndim == 0:
        found = np.full((1, springs), float(found))
    elif found.ndim == 1:
        found = found[:, None] if springs == 1 else found[None]
    if (
        found.ndim != 2
        or found.shape[1] != springs
        or not np.isfinite(found).all()
        or (found < low).any()
    ):
        allowed = f"finite numbers from {low:g}, one for each of {springs} springs"
        message = f"{key} = {value!r} cannot be used: {allowed}"
        raise InputError(message, key=key, value=value, allowed=allowed)
    return found


def _numbers(key: str, value: ArrayLike) -> FloatArray:
    try:
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as error:
        message = f"{key} = {value!r} cannot be used: numbers"
        raise InputError(message, key=key, value=value) from error
