"""One point of a search: its quantities, and the room that its limits leave."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ....arrays import FloatArray
from ....hybrid.result.turns import INDICES
from ....mechanism import index_difference
from ..problem.problem import Limit


@dataclass(frozen=True, eq=False, kw_only=True)
class Point:
    """Quantities of one set of free numbers.

    Attributes:
        z: Unit coordinates, shape (parameters,).
        values: Quantities by name; empty without a machine that can be simulated.
        rows: Slacks of the limits, positive inside, each in the unit of its quantity, in the order
            of ``owners``; empty without a machine.
        owners: Place of the limit that a row belongs to.
        engine: Engine that found the transition, or the whole turn if one is asked for, as of
            :class:`~.bounces.Bounces`; empty without a machine.
        why: Why there are no quantities; empty if there are.
    """

    z: FloatArray
    values: Mapping[str, float]
    rows: FloatArray
    owners: tuple[int, ...]
    engine: str = ""
    why: str = ""

    @property
    def slacks(self) -> tuple[float, ...]:
        """Slack of every limit: the least of its rows."""
        count = max(self.owners, default=-1) + 1
        return tuple(
            min(float(row) for row, owner in zip(self.rows, self.owners, strict=True) if owner == k)
            for k in range(count)
        )

    @property
    def usable(self) -> bool:
        """Whether these numbers make a machine that can be simulated."""
        return not self.why


def slack_rows(
    limits: Sequence[Limit], values: Mapping[str, float], waiting: FloatArray
) -> tuple[FloatArray, tuple[int, ...]]:
    """Slacks of limits, and the place of the limit that each belongs to.

    Args:
        values: Quantities by name.
        waiting: Least stop force in every interval of the initial phase [N]: a limit on it has a
            row for each, since the least of all has kinks.
    """
    owners: list[int] = []
    rows: list[float] = []
    for place, limit in enumerate(limits):
        found = _slacks(limit, values, waiting)
        rows.extend(found)
        owners.extend([place] * len(found))
    return np.array(rows), tuple(owners)


def _slacks(limit: Limit, values: Mapping[str, float], waiting: FloatArray) -> list[float]:
    """Slacks of one limit, in the unit of its quantity."""
    sign = 1.0 if limit.side == "low" else -1.0
    if limit.quantity == "stop_force_N" and sign > 0.0:
        return [float(force) - limit.value for force in waiting]
    value = values[limit.quantity]
    if limit.quantity in INDICES:
        # On the turn on which it is nearest to the limit: 39 is one below 0.
        value = limit.value + index_difference(value, limit.value)
    return [sign * (value - limit.value)]
