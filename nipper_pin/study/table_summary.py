"""What tables of transitions and of turns say alike of their cases."""

from __future__ import annotations

from collections import Counter

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..frames import Column
from ..hybrid.result.quantities import coordinate_unit
from ..mechanism import Mechanism
from .cases import SPRING_KEYS


def spring_columns(mechanism: Mechanism, **rows: FloatArray) -> dict[str, Column]:
    """Rates and preloads by their paths in the model, in the units of its file.

    Args:
        rows: ``stiffness`` and ``preload``, shape (n, springs) each, in SI units.
    """
    return {
        f"springs.{spring.name}.{key}": rows[row][:, place] / scale
        for place, spring in enumerate(mechanism.springs)
        for key, (unit, row, scale, _) in SPRING_KEYS.items()
        if unit == coordinate_unit(mechanism, spring.index)
    }


def outcomes(outcome: NDArray[np.str_]) -> str:
    """How the cases of a table ended, and how many so."""
    found = Counter(outcome.tolist())
    return ", ".join(f"{count:,} {word.replace('_', ' ')}" for word, count in found.most_common())
