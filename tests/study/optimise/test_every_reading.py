"""Every quantity that is read off a simulated turn, and what the control says of it."""

from __future__ import annotations

import math
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from made_up_turn import PERIOD, solution

from nipper_pin import Window, load
from nipper_pin.errors import InputError, SimulationError
from nipper_pin.hybrid.event import EventKind
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY, drawn
from nipper_pin.study.identify.problem.working_cycle import unfit, working_cycle
from nipper_pin.study.optimise.control import compare
from nipper_pin.study.optimise.control.compare import Control, Row
from nipper_pin.study.optimise.control.reading import (
    MOST_TURNS,
    ControlTurn,
    Read,
    control_turn,
    read,
)
from nipper_pin.study.optimise.points.turn import differs
from nipper_pin.study.optimise.problem.problem import Limit
from nipper_pin.study.optimise.problem.quantities import (
    QUANTITIES,
    check_fit,
    cycle_values,
    thinned,
)
from nipper_pin.tolerances.study import QUANTITY_ROUND_OFF

MASS = Path(__file__).resolve().parents[2] / "verification" / "models" / "bouncing_mass"
# Samples of a stretch: of a smooth curve the largest one misses the peak by a part of 1e-7.
SAMPLES = 20_000


@pytest.fixture(scope="module", params=[550.0, 650.0])
def turn(request: pytest.FixtureRequest) -> ControlTurn:
    """The E62 in two turns: the steeve stays on its stop while the jaw is open, or lifts off it."""
    changes = {
        "springs.steeve.preload_length_mm": 11.0, "points.eccentric_pin.angle_deg": 176.0,
        "drives.tension.ratio": 2.2,
    }  # fmt: skip
    return control_turn(load("e62", changes), request.param, None)


def sampled(turn: ControlTurn) -> dict[str, float]:
    """All quantities, by samples of the dense motion between the events of the last turn."""
    run, period = turn.solution, turn.solution.shaft.period
    begin = (turn.number - 1) * period
    events = [item for item in run.events if begin <= item.t < begin + period]
    hits = [item for item in events if item.kind is EventKind.COLLISION and "jaw" in item.stops]
    rest = next(item for item in events if item.kind is EventKind.REST and "jaw" in item.stops)
    opens = next(item for item in events if item.number > rest.number
                 and "jaw" in item.closed_before and "jaw" not in item.closed_after)  # fmt: skip
    cylinder = run.mechanism.cylinder

    def index(t: float) -> float:
        return cylinder.index_from_angle(float(run.shaft.angle(t)))

    def highest(stop: str, first: float, last: float) -> float:
        t = np.linspace(first, last, SAMPLES)
        return float(
            run.trajectory.evaluate(t, left=True).q[:, run.mechanism.stop(stop).index].max()
        )

    def forces(stop: str, first: float, last: float) -> Any:
        """Force where the stop is closed, at the middles of equal parts."""
        found = []
        for item in run.phases:
            low, high = max(item.t_start, first), min(item.t_end, last)
            if stop in item.closed and low < high:
                t = low + (high - low) * (np.arange(SAMPLES) + 0.5) / SAMPLES
                found.append((high - low, run.trajectory.reactions(t).contacts[stop]))
        return found

    first, quarter = hits[0], 0.25 * (opens.t - hits[0].t)
    middle = forces("jaw", first.t + quarter, opens.t - quarter)
    closed = forces("jaw", begin, begin + period)
    lifted = any(item.kind is EventKind.RELEASE and "steeve" in item.stops for item in events)
    clamped = sum(length for length, _ in closed)
    losing = (EventKind.COLLISION, EventKind.REST)
    waiting = forces("steeve", opens.t - period, first.t)
    return {
        "rebound_amplitude_1": highest("jaw", first.t, hits[1].t),
        "rebound_time_s_1": hits[1].t - first.t,
        "duration_s": rest.t - first.t,
        "closing_index": index(first.t),
        "opening_index": index(opens.t),
        "clamping_force_N": sum(length * force.mean() for length, force in middle) / (2 * quarter),
        "stop_force_N": 0.0 if lifted else min(force.min() for _, force in waiting),
        "jaw_opening_deg": math.degrees(highest("jaw", opens.t - period, first.t)),
        "stroke_mm": 1e3 * highest("steeve", rest.t, opens.t),
        "speed_rpm": 60.0 / period,
        "clamped_time_s": clamped,
        "clamped_share": clamped / period,
        "rest_index": index(rest.t),
        "rest_margin": 40.0 * (opens.t - rest.t) / period,
        "least_clamping_force_N": min(force.min() for _, force in closed),
        "largest_clamping_force_N": max(force.max() for _, force in closed),
        "largest_gap": highest("jaw", first.t, hits[1].t),
        "energy_lost_turn_J": sum(item.energy_lost for item in events if item.kind in losing),
    }  # fmt: skip


def test_every_quantity_is_in_the_motion(turn: ControlTurn) -> None:
    """Within what is stated, and what samples miss: at ends the force goes on by a sample's way."""
    assert turn.repeats
    wanted = sampled(turn)
    assert set(wanted) == set(QUANTITIES)
    for name, value in wanted.items():
        found = read(turn, name)
        missed = 1e-4 if "clamping_force" in name or name == "stop_force_N" else 1e-6
        assert found.value == pytest.approx(value, abs=found.error + missed * abs(value)), name
        assert 0.0 <= found.error <= 1e-6 * max(abs(value), 40.0), name


def test_a_turn_without_a_transition() -> None:
    """What it lacks is named, and its speed is read all the same."""
    found = ControlTurn(solution(found=[], transitions=[]), 1, repeats=True)
    assert read(found, "speed_rpm").value == pytest.approx(60.0 / PERIOD)
    for name in ("rebound_amplitude_1", "duration_s", "closing_index", "stop_force_N"):
        with pytest.raises(SimulationError, match="the stop jaw is not hit in the simul") as caught:
            read(found, name)
        assert caught.value.evidence == {"stop": "jaw"}
    bouncing = ControlTurn(solution(transitions=[]), 1, repeats=True)
    with pytest.raises(SimulationError, match="the simulated turn has no duration_s"):
        read(bouncing, "duration_s")
    assert read(bouncing, "rebound_time_s_1").value == 0.0375


@pytest.mark.parametrize(("model", "turns"), [("e62", MOST_TURNS), (MASS, 1)], ids=str)
def test_turns_that_are_simulated(model: str | Path, turns: int) -> None:
    """From a quarter of a turn before the touch: until they repeat, or one if drives wind on."""
    machine = load(model)
    touch = machine.cylinder.index_from_angle(machine.cylinder.angle_at_touch_rad)
    found = control_turn(machine, 60.0, 1e-4)
    case = found.solution.case
    assert (case.speed_rpm, case.window, case.rest_rate) == (60.0, Window.CYCLE, 1e-4)
    assert case.start_index == pytest.approx(touch - 10.0)
    assert found.repeats
    assert found.number == case.cycles == turns


@pytest.mark.parametrize("name", ["e62", "e62_offset_guide", "hanging_pendulum", *GALLERY])
def test_kinematics_and_turn_have_one_window(name: str) -> None:
    """Forces and travels of a cycle are those of the turn, where no stop bounces too long.

    Off by no more than what every second sample of the kinematics changes, and half of those of
    the turn; of a smooth curve either is several times the error of all samples.
    """
    machine = drawn_mechanism(drawn(name)) if name in GALLERY else load(name)
    speed, asked = machine.cylinder.rated_speed_rpm, []
    for quantity, item in QUANTITIES.items():
        if item.source == "cycle":
            with suppress(InputError):
                check_fit([quantity], machine, name)
                asked.append(quantity)
    assert bool(asked) is (unfit(machine) is None)
    if not asked:
        return
    cycle, turn = working_cycle(machine, speed), control_turn(machine, speed, None)
    found, coarse = cycle_values(cycle), cycle_values(thinned(cycle))
    for quantity in asked:
        if differs(cycle, read(turn, "duration_s").value, frozenset({quantity})):
            continue
        seen, value = read(turn, quantity), found[quantity]
        error = abs(value - coarse[quantity]) + QUANTITY_ROUND_OFF * abs(value) + seen.error
        assert seen.value == pytest.approx(value, rel=0.0, abs=error), quantity


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
    name: str,
    limits: tuple[tuple[Any, float], ...],
    reported: float,
    broken: int,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By more than the report does, and than both may err; only those of the quantity itself."""
    seen = {"rebound_time_s_1": Read(0.01, 6e-6), "opening_index": Read(2.0, 4e-3),
            "duration_s": Read(0.02, 5e-6)}  # fmt: skip
    monkeypatch.setattr(compare, "read", lambda _turn, asked: seen[asked])
    given = tuple(
        Limit(quantity="opening_index" if name == "opening_index" else "rebound_time_s_1",
              side=side, value=value)
        for side, value in limits
    )  # fmt: skip
    problem: Any = SimpleNamespace(units={name: "s"}, limits=given)
    turn: Any = None
    found = compare._row(problem, turn, name, reported, 1e-4)
    assert (found.quantity, found.unit, found.reported) == (name, "s", reported)
    assert found.turn == seen[name].value
    assert found.allowed == pytest.approx(1e-4 + seen[name].error)
    assert len(found.breaks) == broken
    if broken:
        assert str(given[0]) in found.breaks or str(given[-1]) in found.breaks


def test_a_quantity_that_the_turn_lacks(monkeypatch: pytest.MonkeyPatch) -> None:
    """The row says why, and does not agree."""

    def missing(*_: object) -> Read:
        message = "it does not come to rest"
        raise SimulationError(message)

    monkeypatch.setattr(compare, "read", missing)
    problem: Any = SimpleNamespace(units={"duration_s": "s"}, limits=())
    turn: Any = None
    found = compare._row(problem, turn, "duration_s", 1.0, 0.5)
    assert (found.turn, found.allowed, found.reported) == (None, 0.5, 1.0)
    assert found.why == "it does not come to rest"
    assert not found.agrees
