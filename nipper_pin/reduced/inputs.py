"""Parameters of cases, checked: what a call shares, and the numbers of each."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..errors import InputError
from ..given import LARGEST, column, number, numbers, refuse, whole
from ..hybrid import FASTEST_RPM
from ..tolerances.reduced import COARSEST_TOLERANCE, FINEST_TOLERANCE
from ..units import S_PER_MIN
from .kernels.layout import Cases, Settings
from .model import Tabulated

_RAD_S = math.tau / S_PER_MIN
# Scratch of so many collisions takes 24 MB.
_MOST_COLLISIONS = 1_000_000


def checked_run(rest_rate: float | None, tolerance: float, max_collisions: int) -> Settings:
    """What all cases of a call share, refused if it is out of range."""
    check_tolerance(tolerance)
    whole("max_collisions", max_collisions, 1, _MOST_COLLISIONS)
    if rest_rate is not None:
        allowed = "a finite rate above 0, or none"
        number("rest_rate", rest_rate, 0.0, LARGEST, open_low=True, allowed=allowed)
    return Settings(float(rest_rate or 0.0), float(tolerance))


def check_tolerance(tolerance: float, where: str = "") -> None:
    """Refuse a tolerance that the reduced engine does not have."""
    number("tolerance", tolerance, FINEST_TOLERANCE, COARSEST_TOLERANCE, allowed="1e-13 to 1e-3",
           where=where)  # fmt: skip


def one_case(
    model: Tabulated, speed_rpm: float, restitutions: FloatArray, stiffness: ArrayLike | None,
    preload: ArrayLike | None,
) -> Cases:  # fmt: skip
    """Numbers of a single case: as :func:`cases_of`, in less time.

    Args:
        restitutions: e_N of all stops, checked, shape (K,).
        stiffness: Spring rates, one number or shape (springs,); so are the deflections.
    """

    def row(key: str, value: ArrayLike | None, default: FloatArray) -> FloatArray:
        if value is None:
            return default[None]
        given = numbers(key, value)
        return np.array(spring_rows(key, given if given.ndim == 0 else given[None], len(default)))

    return Cases(
        np.array([number("speed_rpm", speed_rpm, 0.0, FASTEST_RPM, open_low=True) * _RAD_S]),
        restitutions[None],
        row("stiffness", stiffness, model.stiffness),
        row("preload", preload, model.preload),
    )


def cases_of(
    model: Tabulated, speed_rpm: ArrayLike, restitutions: list[FloatArray],
    stiffness: ArrayLike | None, preload: ArrayLike | None,
) -> Cases:  # fmt: skip
    """Numbers of n cases; a single number stands for all of them.

    Args:
        restitutions: e_N of every stop, checked, each (1,) or (n,).
        stiffness: Spring rates, shape (n,) with one spring or (n, springs); None: the model's.
        preload: Deflections in the springs at zero, likewise.
    """
    speed, count = speeds_of(speed_rpm) * _RAD_S, len(model.stiffness)
    rates = spring_rows("stiffness", model.stiffness if stiffness is None else stiffness, count)
    lengths = spring_rows("preload", model.preload if preload is None else preload, count)
    speed, rates, lengths, *columns = of_all_cases(speed, rates, lengths, *restitutions)
    return Cases(speed, np.stack(columns, axis=1), rates, lengths)


def speeds_of(value: ArrayLike) -> FloatArray:
    """Cylinder speeds, one a case, checked, shape (1,) or (n,) [r/min]."""
    return column("speed_rpm", value, 0.0, FASTEST_RPM, open_low=True)


def spring_rows(key: str, value: ArrayLike, springs: int) -> FloatArray:
    """One row of spring values a case, checked, shape (1 or n, springs).

    Args:
        key: Name of the parameter, which begins with stiffness or preload.
        value: One number for all, shape (n,) with one spring or (springs,) with more, or
            (n, springs).
    """
    low = 0.0 if key.startswith("stiffness") else -LARGEST
    allowed = f"finite numbers from {low:g} to {LARGEST:g}, one for each of {springs} springs"
    found = numbers(key, value, low, LARGEST, allowed=allowed)
    if found.ndim == 0:
        found = np.full((1, springs), float(found))
    elif found.ndim == 1:
        found = found[:, None] if springs == 1 else found[None]
    if found.ndim != 2 or found.shape[1] != springs:
        refuse(key, value, allowed)
    return found


def of_all_cases(*given: FloatArray) -> list[FloatArray]:
    """Numbers of n cases, from columns and rows of one case or of all.

    Copies, which may be written: code is compiled for a type of array, so once, whatever is given.
    """
    try:
        cases = np.broadcast_shapes(*(item.shape[:1] for item in given))
    except ValueError as error:
        message = f"the arrays of a table need the same number of cases: {error}"
        raise InputError(message) from error
    return [np.array(np.broadcast_to(item, cases + item.shape[1:]), order="C") for item in given]
