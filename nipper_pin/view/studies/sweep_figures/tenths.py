"""The lowest and the highest tenth of a sweep's scenarios."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....arrays import FloatArray
from .columns import Quantity


@dataclass(frozen=True, eq=False, kw_only=True)
class Tenth:
    """Scenarios with the lowest or the highest values.

    Attributes:
        inside: Whether a scenario belongs to it, shape (rows,).
        words: What it is, and up to or from which value.
    """

    inside: NDArray[np.bool_]
    words: str


def tenths(y: FloatArray, quantity: Quantity) -> tuple[Tenth, Tenth]:
    """The lowest and the highest tenth; both are larger where many scenarios have one value.

    Args:
        y: Values that are all finite, shape (rows,).
        quantity: What they are of.
    """
    low, high = np.percentile(y, [10, 90])
    # A value that most scenarios have belongs to neither.
    parts = (y <= low) & (y < high), (y >= high) & (y > low)
    ends = y[parts[0]].max(initial=y.min()), y[parts[1]].min(initial=y.max())
    words = (f"up to {quantity.short(ends[0])}", f"from {quantity.short(ends[1])}")
    return tuple(
        Tenth(
            inside=inside,
            words=f"{name} {100.0 * np.mean(inside):.2g} %: {text} {quantity.shown.unit}".rstrip(),
        )
        for name, inside, text in zip(("lowest", "highest"), parts, words, strict=True)
    )  # type: ignore[return-value]
