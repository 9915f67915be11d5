"""The three studies: transitions over speed, restitution and spring rate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics.system import DriveMode
from nipper_pin.errors import InputError, SimulationError
from nipper_pin.mechanism import Mechanism
from nipper_pin.study.cases import cases_of
from nipper_pin.study.transitions import TransitionTable, table_of

from ..tolerances import DIRECT_DEFAULT, SLOWEST_REBOUND
from .published import Published


@dataclass(frozen=True)
class Study:
    """Transitions over one quantity.

    Attributes:
        name: "speed", "restitution" or "stiffness".
        values: Values of the quantity [r/min, - or N/m], shape (n,).
        table: Their transitions, rest as the limit of the series.
        bounces: The same, rest as the first rebound slower than 1e-6 rad/s: all collisions that
            any threshold of interest counts.
    """

    name: str
    values: FloatArray
    table: TransitionTable
    bounces: TransitionTable

    @property
    def rates(self) -> FloatArray:
        """Separation rates of all collisions, falling, shape (n, most), NaN beyond [rad/s]."""
        return self.bounces.separation_rate

    @property
    def amplitudes(self) -> FloatArray:
        """Amplitudes of the first two rebounds [rad], shape (n, 2)."""
        return self.table.rebound_amplitude[:, :2]

    @property
    def times(self) -> FloatArray:
        """Times of the first two rebounds [s], shape (n, 2)."""
        return self.table.rebound_time[:, :2]

    @property
    def durations(self) -> FloatArray:
        """Transition times [s], shape (n,)."""
        return self.table.duration

    @property
    def shares(self) -> FloatArray:
        """Shares of the first two rebounds in the transition times, shape (n,)."""
        return self.table.first_two_share

    def record(self) -> list[dict[str, Any]]:
        """Return one row a case as plain data, SI units."""
        return [
            {
                self.name: float(value),
                "rebound_amplitude_1": float(self.amplitudes[i, 0]),
                "rebound_amplitude_2": float(self.amplitudes[i, 1]),
                "rebound_time_s_1": float(self.times[i, 0]),
                "rebound_time_s_2": float(self.times[i, 1]),
                "duration_s": float(self.durations[i]),
                "first_two_share": float(self.shares[i]),
                "premise_holds": self.table.premise_holds[i],
            }
            for i, value in enumerate(self.values)
        ]


@dataclass(frozen=True)
class Studies:
    """Over the speed, and at the common speed over restitution and spring rate (preload kept)."""

    speed: Study
    restitution: Study
    stiffness: Study

    def __iter__(self) -> Iterator[Study]:
        """The studies in the paper's order."""
        return iter((self.speed, self.restitution, self.stiffness))


def run_studies(
    mechanism: Mechanism, conditions: Published, drive: DriveMode = DriveMode.HELD
) -> Studies:
    """Run the three studies.

    Raises:
        InputError: The mechanism has not exactly one spring.
        SimulationError: A transition does not come to rest, or has fewer than two rebounds.
    """
    if len(mechanism.springs) != 1:
        message = (
            f"the published study changes the rate of one spring; {mechanism.name!r} has "
            f"{len(mechanism.springs)}"
        )
        raise InputError(message, springs=len(mechanism.springs))
    usual: dict[str, Any] = {
        "speed_rpm": conditions.common_speed_rpm,
        "restitution": conditions.common_restitution,
        "stiffness": mechanism.springs[0].stiffness,
    }
    return Studies(
        _study(mechanism, "speed", usual, "speed_rpm", conditions.speeds_rpm, drive),
        _study(mechanism, "restitution", usual, "restitution", conditions.restitutions, drive),
        _study(mechanism, "stiffness", usual, "stiffness", conditions.stiffnesses, drive),
    )


def _study(
    mechanism: Mechanism,
    name: str,
    usual: dict[str, Any],
    key: str,
    values: tuple[float, ...],
    drive: DriveMode,
) -> Study:
    cases = cases_of(mechanism, **{**usual, key: values})
    table, bounces = (
        table_of(
            mechanism,
            cases,
            rest_rate=rate,
            tolerance=DIRECT_DEFAULT,
            drive=drive,
            engine="direct",
        )
        for rate in (None, SLOWEST_REBOUND)
    )
    for found in (table, bounces):
        for i, outcome in enumerate(found.outcome):
            if outcome != "at_rest" or found.collisions[i] < 3:
                message = (
                    f"{key} = {values[i]:g}: the {mechanism.transition_stop} does not come to rest "
                    f"after two rebounds or more ({found.message[i] or outcome}); the study cannot "
                    "be done for these values"
                )
                raise SimulationError(message, study=name, value=float(values[i]))
    return Study(name, np.array(values, dtype=float), table, bounces)
