"""Whole turns and the speed limit, asked for what cannot be: one sentence."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from nipper_pin import InputError, Mechanism, SimulationError, load
from nipper_pin.reduced.turns import TurnStatus, turn_quantities, turns
from nipper_pin.study import speed_limit as speed_limit_module
from nipper_pin.study.speed_limit import Verdict, speed_limit
from nipper_pin.view.studies.speed_limit_report import _sentence

NUMBERS: list[dict[str, Any]] = [
    {"speed_rpm": math.nan}, {"speed_rpm": "fast"}, {"speed_rpm": 0.0}, {"speed_rpm": [[450.0]]},
    {"start_index": math.nan}, {"start_index": math.inf}, {"start_index": "x"},
    {"restitution": {"nope": 0.1}}, {"restitution": math.nan}, {"stiffness": "stiff"},
    {"preload": math.inf}, {"rest_rate": math.nan}, {"tolerance": math.nan},
    {"max_collisions": 10**12}, {"max_collisions": 2.5}, {"max_collisions": 0},
]  # fmt: skip
COUNTS: list[object] = [0, 2.5, True, "3", None, 10**9, 10_001]
# Of a run and of a batch of runs; there has to be room for the events of all turns.
OF_ONE = [{"cycles": count} for count in COUNTS] + [{"cycles": 100, "max_collisions": 100_000}]
OF_MANY = [{"turns": count} for count in COUNTS] + [{"least_force": math.nan}]
OF_MANY += [{"last": count} for count in COUNTS if count not in (None, 10_001)]


@pytest.mark.parametrize(("ask", "own"), [(turns, OF_ONE), (turn_quantities, OF_MANY)])
def test_numbers_that_turns_cannot_have(
    ask: Any, own: list[dict[str, Any]], e62: Mechanism
) -> None:
    for given in (*NUMBERS, *own):
        with pytest.raises(InputError) as refused:
            ask(e62, **{"speed_rpm": 450.0, **given})
        assert len(refused.value.message.splitlines()) == 1
        assert any(word in refused.value.message for word in (*given, "nope", "spring"))


@pytest.mark.slow
def test_speeds_that_cannot_be_followed_are_told_of(
    e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are no speeds at which the jaw does not settle."""

    def lost(mechanism: Mechanism, **keys: Any) -> Any:
        """Turns of which none above 10,000 r/min could be followed."""
        found = turn_quantities(mechanism, **keys)
        away = np.asarray(keys["speed_rpm"]) > 1e4
        return replace(found, status=np.where(away, TurnStatus.LEFT_GAP, found.status))

    monkeypatch.setattr(speed_limit_module, "turn_quantities", lost)
    found = speed_limit(e62, low_rpm=600.0, high_rpm=1e9, speeds=2, turns=30)
    assert found.status == ("followed", "left_gap")
    assert found.settles_rpm is None
    assert found.repeats_rpm is None
    assert found.lost.startswith("At 1 of 2 speeds, the first of them 1e+09 r/min")
    said = _sentence(found)
    # Halved twelve times between 600 r/min and the speed that is lost.
    assert found.settled[-1].verdict is Verdict.UNKNOWN
    assert found.settled[-1].low_rpm <= 1e4 + 1e9 / 2**12
    assert "at every speed" not in said
    assert said.endswith(found.lost)
    with pytest.raises(SimulationError, match="at none of these speeds: a flight goes higher"):
        speed_limit(e62, low_rpm=1e8, high_rpm=1e9, speeds=3)


def test_blocks_of_speeds_change_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Speeds are followed some at a time, so that an interrupt is heard in between."""
    machine = load("hanging_pendulum")
    few = {"low_rpm": 100.0, "high_rpm": 300.0, "speeds": 7, "turns": 3}
    whole = speed_limit(machine, **few)
    monkeypatch.setattr("nipper_pin.study.speed_limit._BLOCK", 2)
    assert repr(speed_limit(machine, **few)) == repr(whole)
    np.testing.assert_array_equal(speed_limit(machine, **few).rests, whole.rests)
