"""Least and largest values of a model's numbers, both sides of each."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest

from nipper_pin.mechanism.files import description


def taken(kind: Any, value: object) -> bool:
    """Whether a value can be one of this kind."""
    try:
        return bool(msgspec.convert(value, kind) == value)
    except msgspec.ValidationError:
        return False


@pytest.mark.parametrize(
    ("name", "inside", "outside"),
    [
        ("Positive", (1e-300, 1e300), (0.0, -1e-300)),
        ("NotNegative", (0.0, 1e300), (-1e-300,)),
        ("Stiffness", (1e-300, 1e15), (0.0, -1.0, 1.0001e15)),
        ("Damping", (0.0, 1e15), (-1e-300, 1.0001e15)),
        ("Length", (0.0, 1e15), (-1e-300, 1.0001e15)),
        ("Restitution", (0.0, 0.5, 1.0), (-1e-300, 1.0000001)),
        ("Index", (0.0, 39.999999), (-1e-300, 40.0)),
        ("Name", ("a",), ("",)),
    ],
)
def test_ranges_of_values(name: str, inside: tuple[Any, ...], outside: tuple[Any, ...]) -> None:
    kind = getattr(description, name)
    assert all(taken(kind, value) for value in inside)
    assert not any(taken(kind, value) for value in outside)


def test_counts() -> None:
    """Phases from 1 on and one at least; one freedom at least; layout 1."""
    phase = {"number": 1, "name": "free", "closed": []}
    whole: dict[str, Any] = {
        "format": 1, "title": "t", "degrees_of_freedom": 1, "gravity_m_s2": 0.0,
        "initial_phase": 1, "phases": [phase],
        "cylinder": {"rated_speed_rpm": 60.0, "direction": "clockwise", "angle_at_touch_deg": 0.0,
                     "reference_index": 0.0, "reference_angle_deg": 0.0},
    }  # fmt: skip

    def reads(**changes: Any) -> bool:
        try:
            msgspec.convert({**whole, **changes}, description.Description)
        except msgspec.ValidationError as error:
            return f"$.{next(iter(changes))}" not in str(error)
        return True

    assert reads()
    assert reads(degrees_of_freedom=2)
    assert reads(cylinder={**whole["cylinder"], "angle_at_touch_deg": -3600.0})
    assert reads(phases=[phase, {**phase, "number": 2, "closed": ["a"]}])
    for changes in (
        {"degrees_of_freedom": 0}, {"phases": []}, {"phases": [{**phase, "number": 0}]},
        {"format": 2}, {"format": 0}, {"title": ""}, {"gravity_m_s2": -1.0},
        {"phases": [{**phase, "name": ""}]}, {"phases": [{**phase, "closed": [""]}]},
        *({"cylinder": {**whole["cylinder"], key: angle}} for angle in (1e16, 3600.1, -3600.1)
          for key in ("angle_at_touch_deg", "reference_angle_deg")),
    ):  # fmt: skip
        assert not reads(**changes), changes
