"""Every quantity that is read off a simulated turn, from motions that are polynomials of time."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_turn import (
    BLURRED,
    BOTH,
    HIT,
    JAW,
    LATE,
    NONE,
    OPENING,
    PERIOD,
    REST,
    SECOND,
    STEEVE,
    event,
    events,
    index,
    jaw,
    lips,
    mean,
    phase,
    solution,
    steeve,
    stop,
)

from nipper_pin import Case, Mechanism, Window
from nipper_pin.errors import SimulationError
from nipper_pin.hybrid.event import EventKind
from nipper_pin.study.optimise.control import compare, turn
from nipper_pin.study.optimise.control.compare import Control, Row
from nipper_pin.study.optimise.control.reading import READ
from nipper_pin.study.optimise.control.turn import ControlTurn
from nipper_pin.study.optimise.problem.problem import Limit

# Relative round-off that is stated of whatever closures and clocks give.
ROUND = 1e-9
PHASES = (
    phase(-0.02, 0.029, STEEVE), phase(0.029, 0.045, NONE), phase(0.045, 0.060, JAW),
    phase(0.060, 0.062, NONE), phase(0.062, 0.090, JAW), phase(0.092, 0.092, BOTH),
)  # fmt: skip


def control_turn(**changes: Any) -> ControlTurn:
    return ControlTurn(solution(**{"phases": PHASES, **changes}), 0.0, PERIOD, repeats=True)


def test_times_and_indices() -> None:
    found = control_turn()
    late = LATE[1] + LATE[2]
    assert READ["rebound_time_s_1"](found) == (pytest.approx(SECOND - HIT), pytest.approx(late))
    assert READ["duration_s"](found) == (
        pytest.approx(REST - HIT), pytest.approx(LATE[1] + LATE[3]),
    )  # fmt: skip
    for name, t, error in (("closing_index", HIT, LATE[1]), ("opening_index", OPENING, LATE[4])):
        value, stated = READ[name](found)
        assert value == pytest.approx(index(t))
        assert stated == pytest.approx(40.0 * (error / PERIOD + ROUND))
    assert READ["speed_rpm"](found) == (pytest.approx(600.0), pytest.approx(600.0 * ROUND))


def test_peaks() -> None:
    """Tops of parabolas, inside of the right stretch or at its end."""
    found = control_turn()
    height, error = READ["rebound_amplitude_1"](found)
    assert height == pytest.approx(0.01, rel=1e-10)
    # Errors of both rates, of which the larger counts; a height goes with the square.
    assert error == pytest.approx((2.0 * max(BLURRED[1:3]) + ROUND) * 0.01)
    widest, error = READ["jaw_opening_deg"](found)
    assert widest == pytest.approx(math.degrees(jaw(HIT)), rel=1e-10)
    assert error == pytest.approx(ROUND * widest)
    stroke, error = READ["stroke_mm"](found)
    assert stroke == pytest.approx(4.0, rel=1e-10)
    assert error == pytest.approx(ROUND * 4.0)
    # The coordinate is looked at where there is motion.
    short = control_turn(span=(0.0, 0.055))
    assert READ["stroke_mm"](short)[0] == pytest.approx(1e3 * steeve(0.055))


def test_a_single_collision_has_its_own_rebound() -> None:
    happened = events()
    happened[2] = event(3, SECOND, EventKind.RELEASE, NONE, NONE)
    found = control_turn(found=happened)
    assert READ["rebound_amplitude_1"](found) == (
        0.0125,
        pytest.approx((2e-5 * 3 + ROUND) * 0.0125),
    )
    assert READ["rebound_time_s_1"](found) == (0.0375, LATE[1])
    # A second collision after the rest is none of this transition.
    happened[2], happened[3] = (
        event(3, SECOND, EventKind.REST, NONE, JAW),
        event(4, REST, EventKind.COLLISION, NONE, NONE),
    )  # fmt: skip
    assert READ["rebound_time_s_1"](control_turn(found=happened)) == (0.0375, LATE[1])
    for hit in (found.hits[0],):
        hit.rebound_amplitude = hit.rebound_time = None
    assert READ["rebound_amplitude_1"](found) == (0.0, 0.0)
    assert READ["rebound_time_s_1"](found) == (0.0, LATE[1])


def test_mean_force_of_the_lips() -> None:
    """Over the middle half, 42.5 to 67.5 ms, of it 45 to 60 and 62 to 67.5 ms with the jaw shut.

    A midpoint rule of n parts misses the mean of a + c t^2 by c h^2 / 12, twice as many parts by a
    quarter of that; both together are exact, and their difference is what is stated.
    """
    value, error = READ["clamping_force_N"](control_turn())
    closed = ((0.045, 0.060), (0.062, 0.0675))
    assert value == pytest.approx(sum(mean(lips, *item) for item in closed) / 0.025, rel=1e-12)
    stated = 0.0
    for begin, end in closed:
        h = (end - begin) / 240.0
        stated += (end - begin) / 0.025 * 1e5 * h**2 / 16.0
    assert error == pytest.approx(stated + ROUND * value, rel=1e-6)
    assert READ["clamping_force_N"](control_turn(phases=PHASES[:2])) == (0.0, 0.0)


def test_least_force_of_the_stop() -> None:
    """While the jaw is open: from its opening in the turn before to its first collision."""
    release = events()
    assert READ["stop_force_N"](control_turn()) == (0.0, 0.0)
    release[0] = event(1, 0.029, EventKind.RELEASE, STEEVE, NONE, ("jaw",))
    low, error = READ["stop_force_N"](control_turn(found=release))
    assert low == pytest.approx(7.0, rel=1e-9)
    assert error == pytest.approx(7.0 * ROUND)
    # In the first half of the way alone: at its end, but for a millionth of the stretch.
    part = (phase(-0.02, 0.008, STEEVE), phase(0.031, 0.05, STEEVE))
    low, _ = READ["stop_force_N"](control_turn(found=release, phases=part))
    assert low == pytest.approx(stop(0.008), rel=1e-4)
    assert low > stop(0.008)
    assert READ["stop_force_N"](control_turn(found=release, phases=PHASES[1:])) == (0.0, 0.0)
    # A release before the jaw opened, or after it was hit, is of another stretch.
    for t in (-0.021, 0.0301):
        release[0] = event(1, t, EventKind.RELEASE, STEEVE, NONE, ("steeve",))
        assert READ["stop_force_N"](control_turn(found=release))[0] > 6.9


def test_the_turn_that_is_read() -> None:
    """Collisions and events of the turn alone, the first rest and what opens after it."""
    shifted = solution(shift=PERIOD, span=(0.0, 2.0 * PERIOD))
    both = [*events(), *shifted.events]
    for number, item in enumerate(both, 1):
        item.number = number
    errors = [SimpleNamespace(time=1e-6 * n, impulse=1e-5 * n) for n in range(10)]
    run = solution(found=both, repeated_from=3, case=SimpleNamespace(cycles=8), errors=errors)
    second = ControlTurn(run, PERIOD, 2.0 * PERIOD, repeats=True)
    assert [hit.t for hit in second.hits] == [PERIOD + HIT, PERIOD + SECOND]
    assert second.rest.number == 9
    assert second.opening.number == 10
    assert second.open_between == pytest.approx((OPENING, PERIOD + HIT))
    assert [item.number for item in second.events] == [6, 7, 8, 9, 10]
    assert (second.late(both[8]), second.blurred(both[8])) == (8e-6, 8e-5)
    assert (second.stop, second.waiting, second.computed) == ("jaw", "steeve", 3)
    whole = ControlTurn(solution(case=SimpleNamespace(cycles=8)), 0.0, PERIOD, repeats=False)
    assert whole.computed == 8
    # What begins with the turn belongs to it, what ends it to the next.
    edges = ControlTurn(solution(), HIT, OPENING, repeats=True)
    assert len(edges.hits) == 2
    assert [item.number for item in edges.events] == [2, 3, 4]


@pytest.mark.parametrize(
    ("attribute", "words"),
    [("hits", "is not hit"), ("rest", "does not come to rest"), ("opening", "does not open again")],
)
def test_what_a_turn_lacks(attribute: str, words: str) -> None:
    found: list[Any] = {
        "hits": [], "rest": [item for item in events() if item.kind is not EventKind.REST],
        "opening": events()[:4],
    }[attribute]  # fmt: skip
    with pytest.raises(SimulationError, match=f"turn of mine the stop jaw {words}") as caught:
        getattr(control_turn(found=found), attribute)
    assert caught.value.evidence == {"stop": "jaw"}


@pytest.mark.parametrize("winding", [False, True])
def test_turns_that_are_simulated(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism, winding: bool
) -> None:
    """From a quarter of a turn before the touch; eight turns, or the one of a drive that winds."""
    touch = e62.cylinder.index_from_angle(e62.cylinder.angle_at_touch_rad)
    cases: list[Case] = []
    moved = 2e-6 if winding else 0.5e-6
    driven = (np.array([[0.1, 0.2], [0.1, 0.2 + moved]]),)

    def simulated(_: Mechanism, case: Case) -> Any:
        cases.append(case)
        shaft = SimpleNamespace(period=PERIOD, driven=lambda t: driven if len(t) == 2 else None)
        return solution(case=case, shaft=shaft, repeated_from=4 if len(cases) > 1 else None)

    monkeypatch.setattr(turn, "simulate", simulated)
    found = turn.control_turn(e62, 600.0, 1e-4)
    first = Case(speed_rpm=600.0, window=Window.CYCLE, start_index=cases[0].start_index,
                 rest_rate=1e-4)  # fmt: skip
    assert cases[0].start_index == pytest.approx(touch - 10.0)
    assert cases[0] == first
    if winding:
        assert len(cases) == 1
        assert (found.begin, found.end, found.repeats) == (0.0, PERIOD, True)
    else:
        assert cases[1:] == [replace(first, cycles=8)]
        assert (found.begin, found.end) == pytest.approx((0.7, 0.8))
        assert found.repeats


def row(**changes: Any) -> Row:
    given = {"quantity": "duration_s", "unit": "s", "reported": 2.0, "turn": 2.5, "allowed": 0.5}
    return Row(**{**given, **changes})


@pytest.mark.parametrize(
    ("changes", "agrees"),
    [
        ({}, True), ({"allowed": 0.49}, False), ({"turn": 1.5}, True), ({"turn": 1.49}, False),
        ({"turn": None}, False), ({"breaks": ("x",)}, False),
        ({"quantity": "stop_force_N", "turn": 0.0, "reported": -9.0}, True),
        ({"quantity": "stop_force_N", "turn": 0.0, "reported": 0.5}, True),
        ({"quantity": "stop_force_N", "turn": 0.0, "reported": 0.51}, False),
        ({"quantity": "stop_force_N", "turn": 0.25, "reported": -9.0}, False),
        ({"quantity": "opening_index", "turn": 39.9, "reported": 0.3}, True),
        ({"quantity": "opening_index", "turn": 39.7, "reported": 0.3}, False),
        ({"quantity": "opening_index", "turn": 0.3, "reported": 39.9}, True),
    ],
)  # fmt: skip
def test_what_agrees(changes: dict[str, Any], agrees: bool) -> None:
    """Within the stated errors of both; indices the short way around."""
    assert row(**changes).agrees is agrees


def test_words_of_the_control() -> None:
    one, two = row(allowed=0.1), row(unit="", turn=None, why="no rebound", breaks=("a", "b"))
    said = "duration_s is 2 s as reported and 2.5 s in the simulated turn"
    assert str(one) == said
    assert str(two) == (
        "duration_s is 2 as reported and none (no rebound) in the simulated turn, which breaks a "
        "and b"
    )
    good = row(quantity="speed_rpm")
    wrong = Control(rows=(good, one), turns=3, why="they differ")
    assert not wrong.confirmed
    assert wrong.contradictions == ("they differ", said)
    assert not Control(rows=(good,), turns=3, why="they differ").confirmed
    right = Control(rows=(good,), turns=3, why="")
    assert right.confirmed
    assert right.contradictions == ()
    assert wrong.record() == {
        "engine": "direct", "window": "cycle", "turns": 3, "confirmed": False,
        "values": {"speed_rpm": 2.5, "duration_s": 2.5},
        "allowed": {"speed_rpm": 0.5, "duration_s": 0.1}, "contradictions": ["they differ", said],
    }  # fmt: skip


@pytest.mark.parametrize(
    ("name", "limits", "reported", "broken"),
    [
        # Allowed: 1e-4 of the report, and 6e-6 s of the 0.01 s that are read.
        ("rebound_time_s_1", (("low", 0.0102),), 0.0102, 1),
        ("rebound_time_s_1", (("low", 0.0102),), 0.0101, 0),
        ("rebound_time_s_1", (("low", 0.0101),), 0.0102, 0),
        ("rebound_time_s_1", (("high", 0.0098),), 0.0097, 1),
        ("rebound_time_s_1", (("high", 0.0098),), 0.0100, 0),
        ("rebound_time_s_1", (("high", 0.0099),), 0.0099, 0),
        ("rebound_time_s_1", (("high", 0.0098), ("low", 0.0102)), 0.00985, 1),
        ("opening_index", (("high", 1.0),), 0.0, 1), ("opening_index", (("low", 1.0),), 0.0, 0),
        ("duration_s", (("high", 1e-9),), 0.02, 0),
    ],
)  # fmt: skip
def test_limits_that_a_turn_breaks(
    name: str, limits: tuple[tuple[Any, float], ...], reported: float, broken: int
) -> None:
    """By more than the report does, and than both may err; only those of the quantity itself."""
    given = tuple(
        Limit(quantity="opening_index" if name == "opening_index" else "rebound_time_s_1",
              side=side, value=value)
        for side, value in limits
    )  # fmt: skip
    # The made-up turn opens at some index; a report in the middle of the limits' way.
    shift = (index(OPENING) - 2.0) if name == "opening_index" else 0.0
    given = tuple(replace(item, value=item.value + shift) for item in given)
    problem: Any = SimpleNamespace(units={name: "s"}, limits=given)
    found = compare._row(problem, control_turn(), name, reported + shift, 1e-4)
    own = READ[name](control_turn())
    assert (found.quantity, found.unit, found.reported) == (name, "s", reported + shift)
    assert found.turn == own.value
    assert found.allowed == pytest.approx(1e-4 + own.error)
    assert len(found.breaks) == broken
    if broken:
        assert str(given[0]) in found.breaks or str(given[-1]) in found.breaks
    missing = compare._row(problem, control_turn(found=events()[:3]), "duration_s", 1.0, 0.5) if (
        name == "duration_s") else None  # fmt: skip
    if missing:
        assert (missing.turn, missing.allowed, missing.reported) == (None, 0.5, 1.0)
        assert missing.why.endswith("does not come to rest")
