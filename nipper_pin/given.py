"""Numbers that callers give: one check for all, which names what cannot be used and why.

Python takes a truth value, a text of digits or half a turn for a number and fails later, elsewhere,
or not at all.
"""

from __future__ import annotations

import math
import sys
from typing import Any, NoReturn

import numpy as np
from numpy.typing import ArrayLike

from .arrays import FloatArray
from .errors import InputError

LARGEST = 1e15
"""Largest number of a model, in its unit: products and squares of larger ones overflow."""
MOST_SEED = 2**63 - 1
"""Largest seed of random numbers: a larger one fits in no file."""
MOST_STARTS = 1_000_000
"""Most descents of a search, and most points of a front: days of the fastest machine."""
MOST_WORKERS = 10_000
"""Most processes: more than any machine has processors."""


def number(
    key: str, value: object, low: float = -math.inf, high: float = math.inf, *,
    open_low: bool = False, allowed: str = "", where: str = "",
) -> float:  # fmt: skip
    """Return a finite number.

    Args:
        key: Name of the argument, for messages.
        value: What was given: a number of Python or numpy.
        low: Least number allowed, or the one above which all are with ``open_low``.
        high: Largest number allowed.
        open_low: Whether ``low`` itself is excluded.
        allowed: What may stand there, in words; by default the bounds.
        where: What the argument belongs to.

    Raises:
        InputError: It is another thing, not finite, or out of range.
    """
    # The usual case, many times a second.
    if type(value) is float and low < value < high:
        return value
    plain = _plain(value)
    right = isinstance(plain, int | float) and not isinstance(plain, bool)
    right = right and abs(plain) <= sys.float_info.max and low <= plain <= high
    if not right or (open_low and plain == low):
        refuse(
            key, value, allowed or f"a finite number {_range(low, high, open_low)}".rstrip(), where
        )
    return float(plain)


def whole(key: str, value: object, low: int, high: int, *, where: str = "") -> int:
    """Return a whole number.

    Args:
        key: Name of the argument, for messages.
        value: What was given: an integer of Python or numpy.
        low: Least number allowed.
        high: Largest number allowed.
        where: What the argument belongs to.

    Raises:
        InputError: It is another thing, or out of range.
    """
    if type(value) is int and low <= value <= high:
        return value
    plain = _plain(value)
    right = isinstance(plain, int) and not isinstance(plain, bool)
    if not (right and low <= plain <= high):
        refuse(key, value, f"a whole number from {low} to {high:,}", where)
    return int(plain)


def flag(key: str, value: object, *, where: str = "") -> bool:
    """Return a truth value; others, such as the text "no", would count as true.

    Args:
        key: Name of the argument, for messages.
        value: What was given.
        where: What the argument belongs to.

    Raises:
        InputError: It is another thing.
    """
    plain = _plain(value)
    if not isinstance(plain, bool):
        refuse(key, value, "True or False", where)
    return bool(plain)


def numbers(
    key: str, value: ArrayLike, low: float = -math.inf, high: float = math.inf, *,
    open_low: bool = False, allowed: str = "",
) -> FloatArray:  # fmt: skip
    """Return finite numbers as an array of their shape; arguments and errors as of :func:`number`.

    A text and a truth value are no numbers here, either.
    """
    try:
        found = np.asarray(value)
    except ValueError:
        refuse(key, value, "numbers in rows of one length")
    right = (found.dtype.kind in "iuf" or not found.size) and not np.ma.is_masked(value)
    if right:
        found = found.astype(np.float64)
        inside = (found > low) if open_low else (found >= low)
        right = bool((np.isfinite(found) & inside & (found <= high)).all())
    if not right:
        refuse(key, value, allowed or f"finite numbers {_range(low, high, open_low)}".rstrip())
    return np.asarray(found, dtype=np.float64)


def column(
    key: str, value: ArrayLike, low: float, high: float, *, open_low: bool = False
) -> FloatArray:
    """Return one number a case, shape (1,) or (n,).

    Arguments and errors are those of :func:`numbers`; another shape is refused, too.
    """
    allowed = f"finite numbers {_range(low, high, open_low)}, one a case"
    found = np.atleast_1d(numbers(key, value, low, high, open_low=open_low, allowed=allowed))
    if found.ndim != 1:
        refuse(key, value, allowed)
    return found


def read_number(text: str) -> float:
    """Return the number that a text is.

    Args:
        text: Digits 0 to 9 with sign, point and exponent; Python reads more, as 1_0 or other
            scripts.

    Raises:
        ValueError: It is none.
    """
    _need_plain_digits(text)
    return float(text)


def read_whole(text: str) -> int:
    """Return the whole number that a text is; as :func:`read_number`."""
    _need_plain_digits(text)
    return int(text)


def _need_plain_digits(text: str) -> None:
    if "_" in text or not text.isascii():
        message = f"not a number: {text!r}"
        raise ValueError(message)


def refuse(key: str, value: object, allowed: str, where: str = "") -> NoReturn:
    """Refuse a value.

    Args:
        key: Name of the argument.
        value: What was given.
        allowed: What may stand there.
        where: What the argument belongs to.

    Raises:
        InputError: In any case.
    """
    place = f"{where}: " if where else ""
    message = f"{place}{key} = {_shown(value)} cannot be used: {allowed}"
    raise InputError(message, key=key, value=value, allowed=allowed)


def _plain(value: object) -> Any:
    """A number of numpy, or an array of no dimension, as one of Python; none of a masked array."""
    if not isinstance(value, np.generic | np.ndarray) or value.ndim:
        return value
    return None if np.ma.is_masked(value) else value.item()


def _shown(value: object) -> str:
    plain = _plain(value)
    if isinstance(plain, type):
        return f"the class {plain.__name__}"
    return repr(plain)


def _range(low: float, high: float, open_low: bool) -> str:
    least = "above" if open_low else "from"
    if math.isinf(low):
        return "" if math.isinf(high) else f"up to {high:g}"
    return f"{least} {low:g}" + ("" if math.isinf(high) else f" to {high:g}")
