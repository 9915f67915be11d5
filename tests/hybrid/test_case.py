"""Cases are validated when they are made; what is no number at all: `tests/test_given.py`."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import pytest

from nipper_pin import Case, DriveMode, InputError, Resolution, Window

WRONG = {
    "speed_rpm": (0.0, -450.0),
    "cycles": (0,),
    "max_collisions": (0,),
    "rest_rate": (0.0, -0.1),
    "tolerance": (0.0, 0.1),
    "flight_nodes": (2,),
    "kinematic_nodes": (65,),
    "panels_per_turn": (0,),
}
ALLOWED = {
    "tolerance": "1e-14 to 1e-3",
    "flight_nodes": "a whole number from 3 to 64",
    "kinematic_nodes": "a whole number from 3 to 64",
    "panels_per_turn": "a whole number from 1 to 1,000,000",
}


@pytest.mark.parametrize(("key", "values"), WRONG.items())
def test_a_value_out_of_range_is_named_with_what_is_allowed(
    key: str, values: tuple[float, ...]
) -> None:
    """The message holds the key, the value found and what may stand there."""
    make: Callable[..., object] = Resolution if key in ALLOWED else partial(Case, speed_rpm=450.0)
    for value in values:
        words = f"{key} = {value!r} cannot be used: {ALLOWED.get(key, '')}"
        with pytest.raises(InputError, match=words) as caught:
            make(**{key: value})
        assert caught.value.evidence["key"] == key
        assert caught.value.evidence["allowed"]


@pytest.mark.parametrize(("key", "value"), [("window", "turn"), ("drive", "elastic")])
def test_an_unknown_choice_lists_the_known_ones(key: str, value: str) -> None:
    with pytest.raises(InputError, match=value) as caught:
        Case(**{"speed_rpm": 450.0, key: value})
    for known in ("transition", "cycle", "held", "inertial"):
        assert known in caught.value.message


def test_choices_may_be_given_as_text() -> None:
    """Text becomes the typed choice, so later comparisons by identity hold."""
    case = Case(speed_rpm=450.0, window="cycle", drive="inertial")  # type: ignore[arg-type]
    assert case.window is Window.CYCLE
    assert case.drive is DriveMode.INERTIAL


def test_a_case_cannot_be_changed() -> None:
    case = Case(speed_rpm=450.0)
    with pytest.raises(AttributeError):
        case.speed_rpm = -1.0  # type: ignore[misc]
