"""Held shafts or shafts that an impact can slow down: how much it matters.

The equations of the published study allow both. With a reflected inertia I on an elastic drive
train an impact takes speed from the shafts; held shafts are the limit I -> infinity.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics import DriveMode
from nipper_pin.hybrid import Case, simulate
from nipper_pin.mechanism import Mechanism

from .published import Published
from .ratios import Ratio, ratios
from .studies import run_studies

FACTORS = (0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 100.0)


@dataclass(frozen=True)
class DriveEffect:
    """Relative changes of a transition by shafts with so many times the model's inertias [-].

    ``shaft_jump`` is the largest change of a shaft's rate in the first collision, by its rate.
    """

    factor: float
    speed_rpm: float
    first_impulse: float
    first_amplitude: float
    second_amplitude: float
    transition_time: float
    shaft_jump: float


@dataclass(frozen=True)
class DriveComparison:
    """Inertias by drive [kg m^2], effects by inertia and speed, and the ratios with them."""

    inertias: dict[str, float]
    effects: tuple[DriveEffect, ...]
    ratios: tuple[Ratio, ...]

    def record(self) -> dict[str, Any]:
        """Return the comparison as plain data."""
        return {
            "reflected_inertias_kg_m2": self.inertias,
            "effects": [asdict(item) for item in self.effects],
            "ratios": [item.record() for item in self.ratios],
        }


def compare_drives(mechanism: Mechanism, conditions: Published) -> DriveComparison:
    """Compare inertial with held shafts at the published speeds."""
    effects = []
    for speed in conditions.speeds_rpm:
        held = _numbers(mechanism, speed, DriveMode.HELD)
        for factor in FACTORS:
            numbers = _numbers(_scaled(mechanism, factor), speed, DriveMode.INERTIAL)
            changes = [*(numbers[:4] / held[:4] - 1.0), numbers[4]]
            effects.append(DriveEffect(factor, speed, *map(float, changes)))
    return DriveComparison(
        {drive.name: drive.reflected_inertia for drive in mechanism.drives},
        tuple(effects),
        ratios(run_studies(mechanism, conditions, DriveMode.INERTIAL), conditions),
    )


def _scaled(mechanism: Mechanism, factor: float) -> Mechanism:
    drives = (replace(d, reflected_inertia=factor * d.reflected_inertia) for d in mechanism.drives)
    return replace(mechanism, drives=tuple(drives))


def _numbers(mechanism: Mechanism, speed: float, drive: DriveMode) -> FloatArray:
    solution = simulate(mechanism, Case(speed_rpm=speed, drive=drive))
    first, second = solution.collisions[:2]
    shafts, event = solution.system.driven, first.event
    jump = np.abs(event.v_after[shafts] / event.v_before[shafts] - 1.0).max()
    heights = (first.rebound_amplitude, second.rebound_amplitude)
    return np.array([first.impulse, *heights, solution.transitions[0].duration, jump])
