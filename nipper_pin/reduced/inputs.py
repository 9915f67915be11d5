"""Parameters of cases, checked: what a call shares, and the numbers of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..errors import InputError
from ..given import LARGEST, column, number, numbers, refuse, whole
from ..hybrid import FASTEST_RPM
from ..tolerances.reduced import COARSEST_TOLERANCE, FINEST_TOLERANCE
from ..units import S_PER_MIN
from .kernels.layout import Settings
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


def cases_of(
    model: Tabulated, speed_rpm: ArrayLike, restitution: Mapping[int, tuple[str, ArrayLike]],
    stiffness: ArrayLike | None, preload: ArrayLike | None, *, one: bool = False,
) -> FloatArray:  # fmt: skip
    """Numbers of n cases in the order of a model's, shape (n, numbers).

    Args:
        restitution: e_N of stops by their places, with names of the parameters; of all others those
            of the model.
        stiffness: Spring rates, shape (n,) with one spring or (n, springs); None: the model's.
        preload: Deflections in the springs at zero, likewise.
        one: Whether there is a single case, whose springs have numbers or shape (springs,).
    """
    take: Callable[..., Any] = number if one else column
    given: list[tuple[int | slice, Any]] = []
    given.append((0, take("speed_rpm", speed_rpm, 0.0, FASTEST_RPM, open_low=True) * _RAD_S))
    for place, (key, value) in restitution.items():
        given.append((1 + place, take(key, value, 0.0, 1.0)))
    cases, springs, most = model.numbers[None], len(model.springs), 1.0 if one else math.inf
    first = cases.shape[1] - springs
    if stiffness is not None:
        rates = spring_rows("stiffness", stiffness, springs, most)
        given.append((slice(first - springs, first), rates))
    if preload is not None:
        given.append((slice(first, None), spring_rows("preload", preload, springs, most)))
    if one:
        cases = cases.copy()
    else:
        columns = of_all_cases(*(values for _, values in given))
        given = [(place, values) for (place, _), values in zip(given, columns, strict=True)]
        cases = cases.repeat(len(columns[0]), axis=0)
    for where, values in given:
        cases[:, where] = values
    return cases


def speeds_of(value: ArrayLike) -> FloatArray:
    """Cylinder speeds, one a case, checked, shape (1,) or (n,) [r/min]."""
    return column("speed_rpm", value, 0.0, FASTEST_RPM, open_low=True)


def spring_rows(key: str, value: ArrayLike, springs: int, most: float = math.inf) -> FloatArray:
    """One row of spring values a case, checked, shape (1 or n, springs).

    Args:
        key: Name of the parameter, which begins with stiffness or preload.
        value: One number for all, shape (n,) with one spring or (springs,) with more, or
            (n, springs).
        most: Most cases.
    """
    low = 0.0 if key.startswith("stiffness") else -LARGEST
    allowed = f"finite numbers from {low:g} to {LARGEST:g}, one for each of {springs} springs"
    found = numbers(key, value, low, LARGEST, allowed=allowed)
    if found.ndim == 0:
        found = np.full((1, springs), float(found))
    elif found.ndim == 1:
        found = found[:, None] if springs == 1 else found[None]
    if found.ndim != 2 or found.shape[1] != springs or len(found) > most:
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
