"""Cases are validated when they are made."""

from __future__ import annotations

import math

import pytest

from nipper_pin import Case, DriveMode, InputError, Resolution, Window


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("speed_rpm", 0.0),
        ("speed_rpm", -450.0),
        ("speed_rpm", math.nan),
        ("speed_rpm", math.inf),
        ("cycles", 0),
        ("start_index", math.nan),
        ("max_collisions", 0),
        ("rest_rate", 0.0),
        ("rest_rate", -0.1),
        ("rest_rate", math.nan),
    ],
)
def test_a_value_out_of_range_is_named_with_what_is_allowed(key: str, value: float) -> None:
    """The message holds the key, the value found and what may stand there."""
    with pytest.raises(InputError, match=f"{key} = {value!r} cannot be used: ") as caught:
        Case(**{"speed_rpm": 450.0, key: value})
    assert caught.value.evidence["key"] == key
    assert caught.value.evidence["allowed"]


@pytest.mark.parametrize(
    ("key", "value", "allowed"),
    [
        ("tolerance", 0.0, "1e-14 to 1e-3"),
        ("tolerance", 0.1, "1e-14 to 1e-3"),
        ("tolerance", math.nan, "1e-14 to 1e-3"),
        ("flight_nodes", 2, "a whole number from 3 to 64"),
        ("kinematic_nodes", 65, "a whole number from 3 to 64"),
        ("panels_per_turn", 0, "a whole number from 1 to 1,000,000"),
    ],
)
def test_a_resolution_out_of_range_is_refused(key: str, value: float, allowed: str) -> None:
    """Resolution names the key, the value and the range."""
    with pytest.raises(InputError, match=f"{key} = {value!r} cannot be used: {allowed}"):
        Resolution(**{key: value})


@pytest.mark.parametrize(("key", "value"), [("window", "turn"), ("drive", "elastic")])
def test_an_unknown_choice_lists_the_known_ones(key: str, value: str) -> None:
    """A wrong window or drive is named together with all the right ones."""
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
    """A validated case stays as it was validated."""
    case = Case(speed_rpm=450.0)
    with pytest.raises(AttributeError):
        case.speed_rpm = -1.0  # type: ignore[misc]
