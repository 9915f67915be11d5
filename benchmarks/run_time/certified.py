"""The certified reference: an independent planar solution, read from its files.

``tests/reference`` holds how it was made: closed-form geometry, one coordinate, Taylor series in
60 digits, nothing of Pinocchio and nothing of this package.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nipper_pin.arrays import FloatArray
from nipper_pin.errors import InputError, UnknownNameError
from nipper_pin.mechanism import Mechanism, load

# Parameters of the reference as paths of the model.
_PATHS = {
    "jaw_restitution": "stops.jaw.restitution",
    "stiffness_N_per_m": "springs.steeve.stiffness_N_per_m",
}
MODEL, CASE = "e62", "650"


@dataclass(frozen=True)
class Flight:
    """Gap [rad] and rate [rad/s] between two collisions, at K fractions from 0 to 1."""

    start_s: float
    duration_s: float
    fractions: FloatArray
    gap: FloatArray
    rate: FloatArray


@dataclass(frozen=True)
class Certified:
    """Certified numbers of one transition of N collisions, rounded to double precision."""

    name: str
    speed_rpm: float
    overrides: dict[str, float]  # what differs from the model, by path
    times: FloatArray  # from the first collision on, shape (N,) [s]
    impulses: FloatArray  # at the lips, shape (N,) [N s]
    amplitudes: FloatArray  # largest jaw angles, shape (N,) [rad]
    rebound_times: FloatArray  # shape (N,) [s]
    separation_rate: float  # after the first collision [rad/s]
    transition_time: float  # [s]
    flights: tuple[Flight, ...]  # of one case alone

    def mechanism(self) -> Mechanism:
        """Load the model of this case."""
        return load(MODEL, self.overrides)


def certified_names() -> tuple[str, ...]:
    """Names of the certified transitions."""
    return tuple(_document("e62_transition.json")["cases"])


def certified(name: str = CASE) -> Certified:
    """Read one certified transition, by default at 650 r/min with the model's own values.

    Raises:
        UnknownNameError: There is no such case.
        InputError: The reference files are missing.
    """
    cases = _document("e62_transition.json")["cases"]
    if name not in cases:
        raise UnknownNameError(kind="certified case", name=name, known=cases)
    case = cases[name]
    changes = dict(case["changes"])
    speed = float(changes.pop("speed_rpm"))
    rows = case["collisions"]

    def column(key: str) -> FloatArray:
        return np.array([float(row[key]) for row in rows])

    return Certified(
        name=name,
        speed_rpm=speed,
        overrides={_PATHS[key]: float(value) for key, value in changes.items()},
        times=column("time_s"),
        impulses=column("impulse_lip_N_s"),
        amplitudes=column("rebound_amplitude"),
        rebound_times=column("rebound_time_s"),
        separation_rate=float(rows[0]["separation_rate"]),
        transition_time=float(case["rest_time_s"]),
        flights=_flights() if name == CASE else (),
    )


def certified_cycle(speed: str) -> list[dict[str, Any]]:
    """Return the certified collisions of one turn at "450" or "650" r/min, as they are written."""
    rows: list[dict[str, Any]] = _document("e62_cycle.json")["cases"][speed]["collisions"]
    return rows


def _flights() -> tuple[Flight, ...]:
    document = _document("e62_flights.json")
    fractions = np.array(document["fractions"], dtype=float)
    return tuple(
        Flight(
            float(item["start_s"]),
            float(item["duration_s"]),
            fractions,
            *(np.array(item[key], dtype=float) for key in ("gap_rad", "rate_rad_s")),
        )
        for item in document["flights"]
    )


def _document(file: str) -> dict[str, Any]:
    path = Path(__file__).parents[2] / "tests" / "reference" / file
    if not path.is_file():
        message = f"the certified reference {file} is missing: get the checkout anew"
        raise InputError(message, file=file)
    document: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return document
