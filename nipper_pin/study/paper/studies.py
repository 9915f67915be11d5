"""The three studies: transitions over speed, restitution and spring rate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...arrays import FloatArray
from ...dynamics.system import DriveMode
from ...errors import InputError, SimulationError
from ...mechanism import Mechanism
from ...tolerances.study import SLOWEST_REBOUND, STUDY_TOLERANCE
from ..cases import cases_of
from ..transitions import TransitionTable, table_of
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

    @property
    def without_turn(self) -> tuple[float, ...]:
        """Values at which no turn has the transition: the machine does not arrive as assumed."""
        told = zip(self.values, self.table.premise_holds, strict=True)
        return tuple(float(value) for value, holds in told if holds is False)


@dataclass(frozen=True)
class Studies:
    """The three studies of the paper.

    Attributes:
        speed: Over the cylinder speed.
        restitution: Over the restitution, at the common speed.
        stiffness: Over the spring rate with the preload length kept, at the common speed.
    """

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

    Args:
        mechanism: The mechanism; with one spring.
        conditions: Speeds, restitutions and spring rates.
        drive: Behaviour of the driven shafts.

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
    speed, e_N = conditions.common_speed_rpm, conditions.common_restitution
    rate = mechanism.springs[0].stiffness
    over: dict[str, dict[str, Any]] = {
        "speed": {"speed_rpm": conditions.speeds_rpm, "restitution": e_N, "stiffness": rate},
        "restitution": {
            "speed_rpm": speed, "restitution": conditions.restitutions, "stiffness": rate,
        },
        "stiffness": {
            "speed_rpm": speed, "restitution": e_N, "stiffness": conditions.stiffnesses,
        },
    }  # fmt: skip
    keys = {"speed": "speed_rpm", "restitution": "restitution", "stiffness": "stiffness"}
    return Studies(
        **{name: _study(mechanism, name, keys[name], given, drive) for name, given in over.items()}
    )


def _study(
    mechanism: Mechanism, name: str, key: str, given: dict[str, Any], drive: DriveMode
) -> Study:
    values = np.array(given[key], dtype=float)
    cases = cases_of(mechanism, **given)
    table, all_bounces = (
        table_of(
            mechanism,
            cases,
            rest_rate=rate,
            tolerance=STUDY_TOLERANCE,
            drive=drive,
            engine="direct",
        )
        for rate in (None, SLOWEST_REBOUND)
    )
    for found in (table, all_bounces):
        for i, outcome in enumerate(found.outcome):
            if outcome != "at_rest" or found.collisions[i] < 3:
                message = (
                    f"{key} = {values[i]:g}: the jaw does not come to rest after two rebounds or "
                    f"more ({found.message[i] or outcome}); the study cannot be done for these "
                    "values"
                )
                raise SimulationError(message, study=name, value=float(values[i]))
    return Study(name, values, table, all_bounces)
