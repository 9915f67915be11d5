"""Random machines, and their events by the independent 80-bit solution of the tests."""

from __future__ import annotations

import sys
from dataclasses import asdict, dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from .dimensions import random_numbers

REFERENCE = Path(__file__).resolve().parents[4] / "tests" / "reference"
# Where the jaw of the E62-class model does not close at all, to six digits.
_NO_APPROACH_DEG = 115.58
# Arm of the lips about the jaw's pin.
LEVER_M = np.sqrt(np.longdouble("81.8") ** 2 + np.longdouble("36.4") ** 2) / 1000
_TURNS = 3
_SLOW = 5
_ABOVE_ZERO = 4
# r/min
_SPEEDS, _SPEEDS_OF_TURNS = (300.0, 900.0), (250.0, 1200.0)
_RATED = (450.0, 650.0)


@dataclass(frozen=True)
class Trial:
    """One random machine: numbers are decimals that both solutions read.

    Attributes:
        numbers: Of a machine with other dimensions, by the names of the independent solution.
    """

    number: int
    turn: bool
    speed_rpm: float
    jaw: float
    steeve: float
    stiffness_N_per_m: float
    preload_mm: float
    touch_deg: float
    share: float = 0.0
    numbers: dict[str, str] = field(default_factory=dict)

    @property
    def lever_m(self) -> Any:
        """Arm of the lips about the jaw's pin; one where the stop has no contact point."""
        return 1 if self.numbers else LEVER_M

    @property
    def of_force_m(self) -> Any:
        """Its force by that at the lips: their arm, or one where it has a contact point."""
        if not self.numbers:
            return 1
        contact, pivot = "jaw_contact_{}_mm", "top_nipper_pivot_{}_mm"
        sides = [
            np.longdouble(self.numbers[contact.format(axis)])
            - np.longdouble(self.numbers[pivot.format(axis)])
            for axis in "xz"
        ]
        return np.sqrt(sides[0] ** 2 + sides[1] ** 2) / 1000


def trial(seed: int, number: int, *, turns: bool = False, dimensions: bool = False) -> Trial:
    """The random machine of that number; each third one for a whole turn, some touch slowly.

    Args:
        seed: Seed of all machines.
        number: Number of the machine.
        turns: All of them for whole turns, in a wider range of speeds.
        dimensions: All numbers within ten per cent, at 450 and 650 r/min.
    """
    random = np.random.default_rng([seed, number])
    turn = turns or number % _TURNS == _TURNS - 1
    touch = 166.0
    if number % _SLOW == 0:
        touch = _NO_APPROACH_DEG + 10.0 ** random.uniform(-3.0, 1.5)
    # The end of long series tells nothing new and takes as long as all the rest.
    jaw, steeve = 0.02 * (0.8 / 0.02) ** random.uniform(size=2)
    if dimensions:
        return _of_dimensions(number, turn, random_numbers(random))
    return Trial(
        number,
        turn,
        float(random.uniform(*(_SPEEDS_OF_TURNS if turns else _SPEEDS))),
        float(jaw),
        float(steeve),
        float(random.uniform(4000.0, 12000.0)),
        float(random.uniform(4.0, 14.0)),
        float(touch),
        # The jaw clamps above this share of the range of its force; in each fourth turn above zero.
        0.0 if number % _ABOVE_ZERO == 0 else float(random.uniform(0.02, 0.98)),
    )


def _of_dimensions(number: int, turn: bool, numbers: dict[str, str]) -> Trial:
    jaw, steeve = float(numbers["jaw_restitution"]), float(numbers["stop_restitution"])
    spring = float(numbers["stiffness_N_per_m"]), float(numbers["preload_length_mm"])
    touch = float(numbers["cylinder_angle_at_touch_deg"])
    speed = _RATED[number // 2 % len(_RATED)]
    return Trial(number, turn, speed, jaw, steeve, *spring, touch, numbers=numbers)


def solved(one: Trial) -> dict[str, Any]:
    """The events of a case by the independent solution, as decimals; none if it has no answer."""
    if str(REFERENCE) not in sys.path:
        sys.path.insert(0, str(REFERENCE))
    extended = import_module("extended")
    changes = one.numbers | {
        "speed_rpm": repr(one.speed_rpm),
        "jaw_restitution": repr(one.jaw),
        "stop_restitution": repr(one.steeve),
        "stiffness_N_per_m": repr(one.stiffness_N_per_m),
        "preload_length_mm": repr(one.preload_mm),
        "cylinder_angle_at_touch_deg": repr(one.touch_deg),
    }
    found: dict[str, Any] = {"trial": asdict(one)}
    try:
        if one.turn:
            held_turn = import_module("held_turn")
            turn = held_turn.HeldTurn(changes)
            found["quantities"] = _decimals(held_turn.quantities(turn, one.share))
            events = turn.events
        else:
            events = extended.transition(changes)
    except ArithmeticError as error:
        return {**found, "refused": str(error)}
    return {**found, "events": [_decimals(vars(event)) for event in events]}


def _decimals(values: dict[str, Any]) -> dict[str, Any]:
    """80-bit numbers as decimals, everything else as it is."""
    return {
        key: str(value) if isinstance(value, np.floating) else value
        for key, value in values.items()
    }
