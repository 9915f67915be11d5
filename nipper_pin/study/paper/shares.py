"""Share of the first two rebounds in the transition time, about 1 - e^2, and its limits.

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

from ...arrays import FloatArray
from ...mechanism import Mechanism
from ..transitions import transition_table
from .published import Published

RESTITUTIONS = np.linspace(0.02, 0.5, 49)


@dataclass(frozen=True)
class Shares:
    """Shares of the first two rebounds over the restitution.

    Attributes:
        speeds_rpm: Speeds [r/min], shape (n,).
        restitutions: Shape (m,).
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
    """Compute shares over the restitution at the published speeds.

    Args:
        mechanism: The mechanism.
        conditions: The published numbers.
    """
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
