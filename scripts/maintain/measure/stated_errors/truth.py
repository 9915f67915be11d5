"""Random machines, and their events by the independent 80-bit solution of the tests."""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

REFERENCE = Path(__file__).resolve().parents[4] / "tests" / "reference"
# Where the jaw of the E62-class model does not close at all, to six digits.
_NO_APPROACH_DEG = 115.58
_TURNS = 3
_SLOW = 5


@dataclass(frozen=True)
class Trial:
    """One random machine: numbers are decimals that both solutions read."""

    number: int
    turn: bool
    speed_rpm: float
    jaw: float
    steeve: float
    stiffness_N_per_m: float
    preload_mm: float
    touch_deg: float


def trial(seed: int, number: int) -> Trial:
    """The random machine of that number; each third one for a whole turn, some touch slowly."""
    random = np.random.default_rng([seed, number])
    turn = number % _TURNS == _TURNS - 1
    touch = 166.0
    if number % _SLOW == 0:
        touch = _NO_APPROACH_DEG + 10.0 ** random.uniform(-3.0, 1.5)
    # The end of long series tells nothing new and takes as long as all the rest.
    jaw, steeve = 0.02 * (0.8 / 0.02) ** random.uniform(size=2)
    return Trial(
        number,
        turn,
        float(random.uniform(300.0, 900.0)),
        float(jaw),
        float(steeve),
        float(random.uniform(4000.0, 12000.0)),
        float(random.uniform(4.0, 14.0)),
        float(touch),
    )


def solved(one: Trial) -> dict[str, Any]:
    """The events of a case by the independent solution, as decimals; none if it has no answer."""
    if str(REFERENCE) not in sys.path:
        sys.path.insert(0, str(REFERENCE))
    extended = import_module("extended")
    changes = {
        "speed_rpm": repr(one.speed_rpm),
        "jaw_restitution": repr(one.jaw),
        "stop_restitution": repr(one.steeve),
        "stiffness_N_per_m": repr(one.stiffness_N_per_m),
        "preload_length_mm": repr(one.preload_mm),
        "cylinder_angle_at_touch_deg": repr(one.touch_deg),
    }
    try:
        events = (extended.cycle if one.turn else extended.transition)(changes)
    except ArithmeticError as error:
        return {"trial": asdict(one), "refused": str(error)}
    rows = [
        {
            key: str(value) if isinstance(value, np.floating) else value
            for key, value in vars(event).items()
        }
        for event in events
    ]
    return {"trial": asdict(one), "events": rows}
