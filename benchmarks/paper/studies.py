"""The three studies: transitions over speed, restitution and spring rate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.dynamics import DriveMode
from nipper_pin.errors import InputError, SimulationError
from nipper_pin.mechanism import Mechanism
from nipper_pin.study.cases import Settings, cases_of
from nipper_pin.study.transitions import TransitionTable, table_of

from ..tolerances import DIRECT_DEFAULT, SLOWEST_REBOUND
from .published import Published


@dataclass(frozen=True)
class Study:
    """Transitions over n values of one quantity: "speed", "restitution" or "stiffness".

    Rest is the limit of the series in ``table``; in ``bounces``, which has all collisions that any
    threshold of interest counts, the first rebound slower than 1e-6 rad/s.
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

    def record(self) -> list[dict[str, Any]]:
        """Return one row a case as plain data, SI units."""
        columns = {
            self.name: self.values,
            "rebound_amplitude_1": self.amplitudes[:, 0],
            "rebound_amplitude_2": self.amplitudes[:, 1],
            "rebound_time_s_1": self.times[:, 0],
            "rebound_time_s_2": self.times[:, 1],
            "duration_s": self.table.duration,
            "first_two_share": self.table.first_two_share,
        }
        return [
            {**{key: float(column[i]) for key, column in columns.items()}, "premise_holds": holds}
            for i, holds in enumerate(self.table.premise_holds)
        ]


class Studies(NamedTuple):
    """Over the speed, and at the common speed over restitution and spring rate (preload kept)."""

    speed: Study
    restitution: Study
    stiffness: Study


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
    over = (conditions.speeds_rpm, conditions.restitutions, conditions.stiffnesses)
    given = zip(usual, over, strict=True)
    return Studies(*(_study(mechanism, {**usual, key: v}, key, drive) for key, v in given))


def _study(mechanism: Mechanism, given: dict[str, Any], key: str, drive: DriveMode) -> Study:
    name, values, cases = key.removesuffix("_rpm"), given[key], cases_of(mechanism, **given)
    table, bounces = (
        table_of(
            mechanism,
            cases,
            Settings(rest_rate=rate, tolerance=DIRECT_DEFAULT, drive=drive),
            "direct",
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
