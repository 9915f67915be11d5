"""A map of the transition time over speed, restitution and spring rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...mechanism import INDEX_PER_TURN, Mechanism
from ...units import S_PER_MIN
from ..cases import cases_of
from ..transitions import table_of
from .published import Published

# In rated speeds: 400 to 700 r/min of the E62.
_SPEEDS = np.linspace(400.0, 700.0, 61) / 450.0
RESTITUTIONS = np.linspace(0.02, 0.32, 61)
_RATES = (0, 2, 4)


@dataclass(frozen=True)
class DesignMap:
    """Transition times.

    Attributes:
        stiffnesses: Spring rates [N/m or N m/rad], shape (n,).
        speeds_rpm: Speeds [r/min], shape (l,).
        durations: Transition times over RESTITUTIONS and speeds [s], shape (n, m, l).
        cases: Transitions that were computed.
        engine: The engine that computed them, and why.
    """

    stiffnesses: FloatArray
    speeds_rpm: FloatArray
    durations: FloatArray
    cases: int
    engine: str

    @property
    def index_units(self) -> FloatArray:
        """The same in units of the comber's index, 40 to a turn, shape (n, m, l)."""
        return self.durations * self.speeds_rpm / S_PER_MIN * INDEX_PER_TURN

    def record(self) -> dict[str, Any]:
        """Return a thinned map as plain data."""
        return {
            "speed_rpm": self.speeds_rpm[::10].tolist(),
            "restitution": RESTITUTIONS[::10].tolist(),
            "stiffness": self.stiffnesses.tolist(),
            "duration_s": [
                [[None if np.isnan(t) else float(t) for t in row] for row in panel]
                for panel in self.durations[:, ::10, ::10]
            ],
        }


def design_map(mechanism: Mechanism, conditions: Published) -> DesignMap:
    """Compute the map for the smallest, the middle and the largest published spring rate.

    Args:
        mechanism: The mechanism; its preload length is kept.
        conditions: The published numbers.
    """
    rates = np.array([conditions.stiffnesses[i] for i in _RATES])
    speeds = _SPEEDS * mechanism.cylinder.rated_speed_rpm
    grid = np.meshgrid(rates, RESTITUTIONS, speeds, indexing="ij")
    cases = cases_of(mechanism, grid[2].ravel(), grid[1].ravel(), grid[0].ravel())
    table = table_of(mechanism, cases, tolerance=1e-9)
    return DesignMap(rates, speeds, table.duration.reshape(grid[0].shape), len(table), table.why)
