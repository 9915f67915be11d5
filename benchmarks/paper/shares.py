"""Many transitions: the share of the first two rebounds, and a map of the transition time.

Take the force that closes the jaw as constant: the jaw leaves with the rate w, comes back after
T = 2 w / b with the rate w and leaves with e w. So every rebound takes e times the one before, the
transition 2 w / (b (1 - e)) in all, and n rebounds the share 1 - e^n of it, whatever b, w, speed
and spring. Amplitudes w^2 / (2 b) fall by e^2. What is left, the difference of a real share from
1 - e^2, is the change of b along the way.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.mechanism import INDEX_PER_TURN, Mechanism
from nipper_pin.study.cases import Settings, cases_of
from nipper_pin.study.transitions import table_of, transition_table
from nipper_pin.units import S_PER_MIN

from .published import Published

RESTITUTIONS = np.linspace(0.02, 0.5, 49)
# Of the map; speeds in rated ones, 400 to 700 r/min of the E62, and places of spring rates.
_SPEEDS = np.linspace(400.0, 700.0, 61) / 450.0
MAP_RESTITUTIONS = np.linspace(0.02, 0.32, 61)
_RATES = (0, 2, 4)


@dataclass(frozen=True)
class Shares:
    """Shares of the first two rebounds over speeds (n) and restitutions (m).

    Attributes:
        shares: Shape (n, m); NaN where the jaw does not come to rest.
        ballistic: 1 - e^2, shape (m,).
        ballistic_ratios: Published ratios that a constant force would give, by name.
    """

    speeds_rpm: FloatArray
    restitutions: FloatArray
    shares: FloatArray
    ballistic: FloatArray
    ballistic_ratios: dict[str, float]

    @property
    def largest_difference(self) -> float:
        """Largest difference from 1 - e^2 for the published restitutions, up to 0.25."""
        usual = self.restitutions <= 0.25
        return float(np.nanmax(np.abs(self.shares - self.ballistic)[:, usual]))

    def record(self) -> dict[str, Any]:
        """Return the findings as plain data."""
        return {
            "largest_difference_up_to_0.25": self.largest_difference,
            "ratios_of_a_constant_force": self.ballistic_ratios,
        }


def shares(mechanism: Mechanism, conditions: Published) -> Shares:
    """Compute shares over the restitution at the published speeds."""
    speeds = np.array(conditions.speeds_rpm)
    grid = np.meshgrid(speeds, RESTITUTIONS, indexing="ij")
    table = transition_table(
        mechanism, speed_rpm=grid[0].ravel(), restitution=grid[1].ravel(), tolerance=1e-9
    )
    low, high = conditions.restitutions[0], conditions.restitutions[-1]
    e = conditions.common_restitution
    ballistic = {f"speed.first_two_share_{speed:g}": 1.0 - e**2 for speed in speeds} | {
        "speed.first_rebound_amplitude_increase": (speeds[-1] / speeds[0]) ** 2 - 1.0,
        "speed.second_rebound_amplitude_increase": (speeds[-1] / speeds[0]) ** 2 - 1.0,
        "restitution.first_rebound_amplitude_increase": (high / low) ** 2 - 1.0,
        "restitution.second_rebound_amplitude_increase": (high / low) ** 4 - 1.0,
        "restitution.transition_time_increase": high * (1.0 - low) / (low * (1.0 - high)) - 1.0,
    }
    return Shares(
        speeds,
        RESTITUTIONS,
        table.first_two_share.reshape(grid[0].shape),
        1.0 - RESTITUTIONS**2,
        {name: float(value) for name, value in ballistic.items()},
    )


@dataclass(frozen=True)
class DurationMap:
    """Transition times [s] over spring rates (n), MAP_RESTITUTIONS (m) and speeds (l)."""

    stiffnesses: FloatArray
    speeds_rpm: FloatArray
    durations: FloatArray

    @property
    def index_units(self) -> FloatArray:
        """The same in units of the comber's index, 40 to a turn, shape (n, m, l)."""
        return self.durations * self.speeds_rpm / S_PER_MIN * INDEX_PER_TURN

    def record(self) -> dict[str, Any]:
        """Return a thinned map as plain data."""
        return {
            "speed_rpm": self.speeds_rpm[::10].tolist(),
            "restitution": MAP_RESTITUTIONS[::10].tolist(),
            "stiffness": self.stiffnesses.tolist(),
            "duration_s": [
                [[None if np.isnan(t) else float(t) for t in row] for row in panel]
                for panel in self.durations[:, ::10, ::10]
            ],
        }


def duration_map(mechanism: Mechanism, conditions: Published) -> DurationMap:
    """Compute the map for the smallest, the middle and the largest published spring rate."""
    rates = np.array([conditions.stiffnesses[i] for i in _RATES])
    speeds = _SPEEDS * mechanism.cylinder.rated_speed_rpm
    grid = np.meshgrid(rates, MAP_RESTITUTIONS, speeds, indexing="ij")
    cases = cases_of(mechanism, grid[2].ravel(), grid[1].ravel(), grid[0].ravel())
    table = table_of(mechanism, cases, Settings(tolerance=1e-9))
    return DurationMap(rates, speeds, table.duration.reshape(grid[0].shape))
