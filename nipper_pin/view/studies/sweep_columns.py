"""Columns of a sweep in the words and units that people read."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...arrays import FloatArray
from ...hybrid import START_INDEX
from ...hybrid.result.turns import INDICES
from ...mechanism import counted_from, within_turn
from ...study.sweep import SweepTable
from ...terms import NONE, Shown, named

# Cells of a sampled parameter: enough scenarios in each, and not more than can be seen.
_FEWEST = 4
_MOST_CELLS = 24
_IN_CELL = 12


@dataclass(frozen=True, eq=False, kw_only=True)
class Quantity:
    """A quantity of all scenarios.

    Attributes:
        name: Its name in the table.
        shown: Its words and its unit for people.
        values: Its values in that unit, NaN where a scenario has none, shape (rows,); indices count
            on from the start of the turn, so that they have means.
    """

    name: str
    shown: Shown
    values: FloatArray

    @classmethod
    def of(cls, sweep: SweepTable, name: str) -> Quantity:
        """Read it from a sweep."""
        unit = (sweep.table.schema.field(name).metadata or {}).get(b"unit", NONE.encode()).decode()
        shown = named(name, unit)
        values = shown.value(np.asarray(sweep.table[name].to_numpy(), dtype=float))
        if name in INDICES:
            values = counted_from(START_INDEX, values)
        return cls(name=name, shown=shown, values=values)

    def short(self, value: float, _: object = None) -> str:
        """A value beside an axis; an index on the one scale from 0 to 40."""
        return short(float(within_turn(value)) if self.name in INDICES else value)

    @property
    def title(self) -> str:
        """Its words at the beginning of a sentence."""
        return self.shown.words[:1].upper() + self.shown.words[1:]


@dataclass(frozen=True, eq=False, kw_only=True)
class Parameter:
    """A parameter, and the cells that its values fall into.

    Attributes:
        name: Its name in the study.
        shown: Its words and its unit for people.
        log: Whether its scale is logarithmic.
        cell: Cell of every scenario, shape (rows,).
        centres: Middles of the cells in that unit, shape (cells,); those of a grid are its values.
        grid: Whether its values are those of a grid.
    """

    name: str
    shown: Shown
    log: bool
    cell: NDArray[np.int64]
    centres: FloatArray
    grid: bool

    @classmethod
    def of(cls, sweep: SweepTable, place: int) -> Parameter:
        """Grid values are cells of their own; the range of samples is divided evenly."""
        axis = sweep.axes[place]
        name, log = str(axis["name"]), axis["scale"] == "log"
        shown = named(str(axis["path"]))
        x = np.asarray(sweep.table[name].to_numpy())
        if axis["values"]:
            centres = np.unique(np.array(axis["values"], dtype=float))
            cell = np.searchsorted(centres, x)
        else:
            low, high = float(axis["low"]), float(axis["high"])
            # Grids that are crossed with the samples do not make them more.
            different = len(np.unique(x))
            count = min(max(_FEWEST, int(math.sqrt(different / _IN_CELL))), _MOST_CELLS)
            scale = np.log if log else np.asarray
            parts = (scale(x) - scale(low)) / ((scale(high) - scale(low)) or 1.0)
            cell = np.minimum((parts * count).astype(np.int64), count - 1)
            middle = (np.arange(count) + 0.5) / count
            centres = low * (high / low) ** middle if log else low + (high - low) * middle
        return cls(
            name=name,
            shown=shown,
            log=log,
            cell=cell,
            centres=shown.value(centres),
            grid=bool(axis["values"]),
        )


def short(value: float) -> str:
    """A value beside an axis: three digits, and no powers of ten for what a designer reads."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e6 else f"{value:.3g}"
