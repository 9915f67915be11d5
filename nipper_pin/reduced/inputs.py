"""Parameters of cases, checked: what a call shares, speeds and rows of spring values."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..errors import InputError
from ..given import LARGEST, column, number, numbers, refuse, whole
from ..hybrid import FASTEST_RPM
from ..tolerances.reduced import COARSEST_TOLERANCE, FINEST_TOLERANCE

# Scratch of so many collisions takes 24 MB.
_MOST_COLLISIONS = 1_000_000


def check_run(rest_rate: float | None, tolerance: float, max_collisions: int) -> None:
    """Check what all cases of a call share.

    Args:
        rest_rate: Threshold of rest [rad/s or m/s], or None.

    Raises:
        InputError: One of them is out of range.
    """
    check_tolerance(tolerance)
    whole("max_collisions", max_collisions, 1, _MOST_COLLISIONS)
    if rest_rate is not None:
        allowed = "a finite rate above 0, or none"
        number("rest_rate", rest_rate, 0.0, LARGEST, open_low=True, allowed=allowed)


def check_tolerance(tolerance: float, where: str = "") -> None:
    """Refuse a tolerance that the reduced engine does not have."""
    number("tolerance", tolerance, FINEST_TOLERANCE, COARSEST_TOLERANCE, allowed="1e-13 to 1e-3",
           where=where)  # fmt: skip


def speed_of(value: object) -> float:
    """A cylinder speed [r/min], checked."""
    return number("speed_rpm", value, 0.0, FASTEST_RPM, open_low=True)


def speeds_of(value: ArrayLike) -> FloatArray:
    """Cylinder speeds, one a case, checked, shape (1,) or (n,) [r/min]."""
    return column("speed_rpm", value, 0.0, FASTEST_RPM, open_low=True)


def one_row(key: str, value: ArrayLike | None, default: FloatArray, low: float) -> FloatArray:
    """Values of all springs in one case, shape (1, springs)."""
    if value is None:
        return default[None]
    given = numbers(key, value)
    return np.array(spring_rows(key, given if given.ndim == 0 else given[None], len(default), low))


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
    of_each = f"one for each of {springs} springs"
    allowed = f"finite numbers from {low:g} to {LARGEST:g}, {of_each}"
    found = numbers(key, value, low, LARGEST, allowed=allowed)
    if found.ndim == 0:
        found = np.full((1, springs), float(found))
    elif found.ndim == 1:
        found = found[:, None] if springs == 1 else found[None]
    if found.ndim != 2 or found.shape[1] != springs:
        refuse(key, value, allowed)
    return found


def of_all_cases(*given: FloatArray) -> list[FloatArray]:
    """Numbers of a batch for each of its n cases, from those of one case or of all.

    Args:
        *given: Columns and rows, shape (1 or n,) or (1 or n, springs).

    Returns:
        The same with n cases. Copies, which may be written: code is compiled for a type of array,
        so once, whatever is given.

    Raises:
        InputError: They have different numbers of cases.
    """
    try:
        cases = np.broadcast_shapes(*(item.shape[:1] for item in given))
    except ValueError as error:
        message = f"the arrays of a batch need the same number of cases: {error}"
        raise InputError(message) from error
    return [np.array(np.broadcast_to(item, cases + item.shape[1:]), order="C") for item in given]
