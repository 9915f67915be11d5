"""The transition of a turn, read from made-up events of the reduced engine."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from nipper_pin import SimulationError
from nipper_pin.hybrid.run.outcome import Outcome
from nipper_pin.mechanism import Mechanism
from nipper_pin.reduced.kernels import turn_layout as columns
from nipper_pin.reduced.turns import ReducedTurns
from nipper_pin.study import turn_transition as module
from nipper_pin.study.turn_transition import TurnCase, TurnTransition, turn_transition

STOPS = ("steeve", "jaw")
HIT, REST, RELEASE = columns.COLLISION, columns.REST, columns.RELEASE
# The jaw touches a fortieth of a turn after the start.
TOUCH = 1.0 / 40.0


def event(kind: int, stop: str, place: float, **more: float) -> np.ndarray:
    """A row: its place in turns from the start, at one turn a second."""
    row = np.full(columns.EVENT_COLUMNS, np.nan)
    row[columns.KIND], row[columns.STOP] = kind, STOPS.index(stop)
    row[columns.TIME], row[columns.TRAVEL] = place, math.tau * place
    row[columns.TIME_ERROR] = 1e-9 * (1.0 + place)
    if kind == HIT:
        row[columns.SEPARATION], row[columns.AMPLITUDE] = 0.5, 0.25
        row[columns.AMPLITUDE_ERROR] = 1e-6
    for name, value in more.items():
        row[getattr(columns, name)] = value
    return row


def read(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, events: list[np.ndarray], done: int = 4,
    again: int = 0, most: int = 9,
) -> TurnTransition:  # fmt: skip
    asked: list[dict[str, Any]] = []

    def turns(mechanism: Mechanism, **options: Any) -> ReducedTurns:
        asked.append(options)
        table = np.array(events)
        return ReducedTurns(mechanism.name, STOPS, done, again, table[np.argsort(table[:, 3])])

    monkeypatch.setattr(module, "turns", turns)
    values = np.array([9000.0])
    case = TurnCase(speed_rpm=60.0, restitution=0.2, stiffness=values, preload=values * 1e-6,
                    rest_rate=0.5, tolerance=1e-9, max_collisions=most)  # fmt: skip
    found = turn_transition(e62, case)
    (options,) = asked
    touch = e62.cylinder.index_from_angle(e62.cylinder.angle_at_touch_rad)
    assert options["start_index"] == touch - 1.0
    told = options["speed_rpm"], options["restitution"], options["rest_rate"], options["tolerance"]
    assert told == (60.0, 0.2, 0.5, 1e-9)
    assert (options["stiffness"], options["preload"]) == (9000.0, 0.009)
    return found


def begun(late: float = 0.1) -> list[np.ndarray]:
    """The touch of the first turn; in the second one the jaw closes later."""
    return [event(HIT, "jaw", TOUCH), event(REST, "jaw", 0.2), event(HIT, "jaw", 1 + TOUCH + late)]


def test_the_third_turn_is_read(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """From half a turn before its touch; times count from its first collision, and so do errors."""
    third = [
        event(REST, "jaw", 2.0), event(HIT, "steeve", 2.1), event(HIT, "jaw", 2.2),
        event(HIT, "jaw", 2.3), event(HIT, "jaw", 2.35, AMPLITUDE=np.nan), event(REST, "jaw", 2.4),
        event(HIT, "jaw", 2.9),
    ]  # fmt: skip
    found = read(monkeypatch, e62, [*begun(), *third])
    assert (found.premise_holds, found.repeats, found.outcome) == (False, False, Outcome.AT_REST)
    assert "Turns differ" in found.message
    np.testing.assert_allclose(found.time, [0.0, 0.1, 0.15], atol=1e-15)
    np.testing.assert_allclose(found.time_error, 1e-9 * np.array([3.2, 6.5, 6.55]))
    np.testing.assert_allclose(found.rebound_time, [0.1, 0.05, np.nan])
    np.testing.assert_allclose(found.rebound_error, 1e-9 * np.array([6.5, 6.65, np.nan]))
    np.testing.assert_allclose(found.duration, 0.2)
    np.testing.assert_allclose(found.duration_error, 6.6e-9)
    np.testing.assert_allclose(found.share, 0.75)
    travel = e62.cylinder.sense * (found.cylinder_angle - e62.cylinder.angle_at_touch_rad)
    np.testing.assert_allclose(travel / math.tau, np.array([0.2, 0.3, 0.35]) - TOUCH)
    few = read(monkeypatch, e62, [*begun(), *third], most=2)
    assert (few.outcome, few.table.shape[1]) == (Outcome.TOO_MANY_COLLISIONS, 2)
    assert np.isnan([few.duration, few.duration_error, few.share]).all()


def test_turns_that_repeat_are_copied(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """After one turn, or after two: the third is then the first again."""
    second = [event(HIT, "jaw", 1.3, SEPARATION=-1e-9, AMPLITUDE=np.nan), event(REST, "jaw", 1.3)]
    found = read(monkeypatch, e62, [*begun()[:2], *second], done=2, again=1)
    assert (found.repeats, found.message) == (True, "This is the transition of the turn.")
    np.testing.assert_allclose([found.duration, found.rebound_amplitude[0]], [0.0, 0.0], atol=1e-15)
    travel = e62.cylinder.sense * (found.cylinder_angle[0] - e62.cylinder.angle_at_touch_rad)
    assert travel / math.tau == pytest.approx(0.3 - TOUCH)
    found = read(monkeypatch, e62, [*begun()[:2], *second], done=2, again=2)
    assert found.repeats is False
    assert found.duration == pytest.approx(0.2 - TOUCH)


@pytest.mark.parametrize(
    "third",
    [
        [event(HIT, "jaw", 2.2)],
        [event(HIT, "jaw", 2.2), event(RELEASE, "jaw", 2.3), event(REST, "jaw", 2.4)],
        # The series began before the window.
        [event(HIT, "jaw", 1.4), event(HIT, "jaw", 2.2), event(REST, "jaw", 2.4)],
    ],
)
def test_without_rest(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, third: list[np.ndarray]
) -> None:
    found = read(monkeypatch, e62, [*begun(), *third, event(HIT, "jaw", 3 + TOUCH + 0.01)])
    assert (found.outcome, found.table.shape[1]) == (Outcome.NO_REST, 1)
    assert np.isnan([found.duration, found.duration_error, found.share]).all()


def test_where_the_turns_do_not_tell(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    third = [event(HIT, "jaw", 2.2), event(REST, "jaw", 2.4)]
    assert read(monkeypatch, e62, [*begun(0.0), *third]).premise_holds is None
    assert read(monkeypatch, e62, [*begun(2e-6), *third]).premise_holds is False
    for events, status in (
        ([event(RELEASE, "steeve", 0.01), *begun(), *third], "OTHER_START"),
        ([event(HIT, "jaw", TOUCH + 2e-6), *third], "OTHER_START"),
        (begun(), "NO_COLLISION"),
        # Only every second turn has one.
        ([*begun(), event(HIT, "jaw", 3.1)], "NO_COLLISION"),
        ([*begun(), event(HIT, "jaw", 2.2, AMPLITUDE=np.nan), third[1]], "LEFT_OUT"),
    ):
        with pytest.raises(SimulationError) as caught:
            read(monkeypatch, e62, events)
        assert caught.value.evidence["status"] == status
