"""What tables of transitions and of turns have in common: their cases, and how each ended."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import FloatArray
from ..frames import Column
from ..mechanism import Mechanism
from ..terms.shown import counted
from .cases import spring_numbers


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class CaseTable:
    """Cases of one mechanism; attributes as of the tables that have more of them."""

    model: str
    why: str
    engine: NDArray[np.str_]
    outcome: NDArray[np.str_]
    message: tuple[str, ...]
    speed_rpm: FloatArray
    stiffness: FloatArray
    preload: FloatArray
    mechanism: Mechanism

    def __len__(self) -> int:
        """Number of cases."""
        return len(self.speed_rpm)

    def __repr__(self) -> str:
        """One line."""
        told = f"{counted(len(self), 'case')}, {self._outcomes()}"
        return f"<{type(self).__name__} of {self.model}: {told}; {self.why}>"

    def _outcomes(self) -> str:
        """How the cases ended, and how many so."""
        found = Counter(self.outcome.tolist()).most_common()
        return ", ".join(f"{count:,} {word.replace('_', ' ')}" for word, count in found)

    def _cases(self, restitution: Mapping[str, FloatArray]) -> dict[str, Column]:
        """How each case ended and its parameters, in the units of the model's file.

        Args:
            restitution: Columns of it by name.
        """
        rows = {"stiffness": self.stiffness, "preload": self.preload}
        return {
            "engine": self.engine.tolist(),
            "outcome": self.outcome.tolist(),
            "message": list(self.message),
            "speed_rpm": self.speed_rpm,
            **restitution,
            **{
                path: rows[row][:, place] / scale
                for path, row, place, scale in spring_numbers(self.mechanism)
            },
        }
