"""Which transition is taken of a machine, its numbers as rows, and its errors: all made up."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from polynomial_problem import problem

from nipper_pin import Case, Mechanism, Window, simulate
from nipper_pin.errors import SimulationError
from nipper_pin.hybrid.event import EventKind
from nipper_pin.hybrid.result.rebound_errors import rebound_error
from nipper_pin.hybrid.run.outcome import Outcome
from nipper_pin.reduced import build, transition
from nipper_pin.reduced.kernels import layout
from nipper_pin.study import true_transition as module
from nipper_pin.study.optimise.points import bounces, evaluate
from nipper_pin.study.optimise.points.bounces import Bounces, Transitions
from nipper_pin.study.optimise.problem.problem import Aim, Limit
from nipper_pin.study.transitions.rows import collision_rows, rest_numbers
from nipper_pin.study.true_transition import (
    TrueTransition,
    assumed_transition,
    transition_of_turns,
    true_transition,
)

CASE = Case(speed_rpm=600.0, window=Window.CYCLE, cycles=9, max_collisions=4)


def hit(number: int, t: float, stop: str = "jaw") -> Any:
    return SimpleNamespace(
        stop=stop, t=t, event=SimpleNamespace(number=number), rebound_amplitude=0.5,
        rebound_time=0.25,
    )  # fmt: skip


def run(**changes: Any) -> Any:
    """Three turns of 0.1 s from the touch on, with two collisions in each."""
    hits = [hit(2 * n + k, 0.1 * n + 0.01 * k) for n in range(3) for k in (1, 2)]
    given = {
        "collisions": [*hits, hit(99, 0.28, "steeve")], "outcome": Outcome.AT_REST,
        "transitions": [SimpleNamespace(t_start=0.1 * n + 0.01, duration=n + 0.5, collisions=2)
                        for n in range(3)],
        "premise_holds": True, "premise": SimpleNamespace(why="It arrives late."),
        "shaft": SimpleNamespace(period=0.1), "repeated_from": 2,
        "mechanism": SimpleNamespace(transition_stop="jaw"),
    }  # fmt: skip
    return SimpleNamespace(**{**given, **changes})


@pytest.fixture(name="asked")
def simulated(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What is simulated, and what comes out: ``out`` of the list's only attribute."""

    class Asked(list[Case]):
        out = run()

    asked = Asked()

    def simulate_it(_: Mechanism, case: Case) -> Any:
        asked.append(case)
        return asked.out

    monkeypatch.setattr(module, "simulate", simulate_it)
    return asked


def test_a_transition_as_it_is_assumed(asked: Any, e62: Mechanism) -> None:
    found = assumed_transition(e62, CASE)
    assert asked[0].window is Window.TRANSITION
    assert (asked[0].speed_rpm, asked[0].cycles, asked[0].max_collisions) == (600.0, 9, 4)
    assert found.solution is asked.out
    assert [item.stop for item in found.collisions] == ["jaw"] * 6
    assert found.transition is asked.out.transitions[-1]
    assert (found.premise_holds, found.outcome, found.message) == (True, Outcome.AT_REST, "")
    assert true_transition(e62, CASE).premise_holds is True
    asked.out = run(premise_holds=None, transitions=[])
    assert true_transition(e62, CASE).transition is None
    assert len(asked) == 3
    asked.out = run(premise_holds=False)
    assert true_transition(e62, CASE).message.startswith("It arrives late. This is the transition")
    assert [case.window for case in asked[3:]] == [Window.TRANSITION, Window.CYCLE]


@pytest.mark.parametrize("before", [0.0, 0.25])
def test_the_transition_of_the_third_turn(asked: Any, e62: Mechanism, before: float) -> None:
    """Three turns from the touch, or from a part of a turn before it; the last one is read."""
    touch = e62.cylinder.index_from_angle(e62.cylinder.angle_at_touch_rad)
    found = transition_of_turns(e62, CASE, "Why.", before)
    (case,) = asked
    assert (case.window, case.cycles) == (Window.CYCLE, 3)
    assert case.start_index == pytest.approx(touch - 40.0 * before)
    assert case.max_collisions >= 256
    assert [item.t for item in found.collisions] == pytest.approx([0.21, 0.22])
    assert found.transition is asked.out.transitions[2]
    assert (found.premise_holds, found.outcome) == (False, Outcome.AT_REST)
    assert found.message == "Why. This is the transition of the simulated turn."
    # From one and a half turns on, and as much later as the turns start earlier.
    edge = 0.1 * (1.5 + before)
    for t, count in ((edge - 1e-6, 2), (edge + 1e-6, 3)):
        asked.out = run(
            collisions=[hit(1, t), hit(2, 0.21), hit(3, 0.22)],
            transitions=[SimpleNamespace(t_start=0.21, duration=2.5, collisions=2)],
        )
        found = transition_of_turns(e62, CASE, "Why.", before)
        assert len(found.collisions) == count
        assert found.outcome is (Outcome.AT_REST if count == 2 else Outcome.NO_REST)
    many = [hit(n, 0.21 + 0.001 * n) for n in range(6)]
    asked.out = run(collisions=many, transitions=[SimpleNamespace(t_start=0.21, collisions=5)],
                    repeated_from=None)  # fmt: skip
    found = transition_of_turns(e62, CASE, "Why.", before)
    assert (len(found.collisions), found.transition) == (4, None)
    assert found.outcome is Outcome.TOO_MANY_COLLISIONS
    assert found.message.endswith(" Turns differ from one another; it is that of number 3.")
    asked.out = run(collisions=many[:4], transitions=[SimpleNamespace(t_start=0.21, collisions=4)])
    assert transition_of_turns(e62, CASE, "", before).outcome is Outcome.AT_REST
    asked.out = run(collisions=[hit(1, 0.01)])
    with pytest.raises(SimulationError, match=r"Why\. No turn has a collision of stop 'jaw'"):
        transition_of_turns(e62, CASE, "Why.", before)


def late(number: int) -> Any:
    return SimpleNamespace(time=1e-6 * number, impulse=1e-5 * number)


def test_errors_of_a_transition() -> None:
    """Of its own collisions, and of the first rest of the stop after the last of them."""
    events = [
        SimpleNamespace(number=n, kind=kind, stops=stops)
        for n, (kind, stops) in enumerate(
            [(EventKind.REST, ("jaw",)), (EventKind.COLLISION, ("jaw",)),
             (EventKind.COLLISION, ("jaw",)), (EventKind.REST, ("steeve",)),
             (EventKind.COLLISION, ("jaw",)), (EventKind.REST, ("jaw",)),
             (EventKind.REST, ("jaw",))], 1)
    ]  # fmt: skip
    solution = run(events=events, errors=[late(n) for n in range(1, 8)])
    hits = (hit(2, 0.1), hit(3, 0.2))
    rest = SimpleNamespace(t_start=0.1, duration=0.75, first_two_share=None)
    made: Any = TrueTransition
    found = made(solution, None, hits, rest, Outcome.AT_REST)
    assert found.errors == (late(2), late(3))
    assert found.duration_error == pytest.approx(6e-6)
    assert made(solution, None, hits, None, Outcome.NO_REST).duration_error is None
    duration, error, share = rest_numbers(found)
    assert (duration, error) == (0.75, pytest.approx(6e-6))
    assert math.isnan(share)
    rest.first_two_share = 0.125
    assert rest_numbers(found)[2] == 0.125
    assert np.isnan(rest_numbers(made(solution, None, hits, None, Outcome.NO_REST))).all()
    # As a search states them: the larger of both rates, both times, and the rest.
    of_turn = Bounces("turn", found)
    assert of_turn.turn is found
    assert of_turn.values == {
        "rebound_amplitude_1": 0.5, "rebound_time_s_1": 0.25, "duration_s": 0.75,
    }  # fmt: skip
    assert of_turn.errors == pytest.approx(
        {"rebound_amplitude_1": 2.0 * 3e-5 * 0.5, "rebound_time_s_1": 5e-6 + 3e-5 * 0.25,
         "duration_s": 8e-6}
    )  # fmt: skip
    assert Bounces("direct", found).turn is None
    hits[0].rebound_amplitude = hits[0].rebound_time = None
    none = Bounces("direct", made(solution, None, hits, None, Outcome.NO_REST))
    assert np.isnan(list(none.values.values())).all()
    assert none.errors == pytest.approx(
        {"rebound_amplitude_1": 0.0, "rebound_time_s_1": 5e-6, "duration_s": 2e-6}
    )


def test_rows_of_collisions(e62: Mechanism) -> None:
    """Every column of the direct engine's rows is its own number of the run."""
    found = assumed_transition(e62, Case(speed_rpm=650.0))
    rows = collision_rows(found)
    solution = simulate(e62, Case(speed_rpm=650.0))
    assert rows.shape == (layout.COLUMNS, len(solution.collisions))
    for place, item in enumerate(solution.collisions):
        error, rebound = solution.errors[item.event.number - 1], rebound_error(solution, item)
        told = {
            "TIME": item.t, "ANGLE": item.cylinder_angle, "APPROACH": item.approach_rate,
            "SEPARATION": item.separation_rate, "IMPULSE": item.impulse, "ENERGY": item.energy_lost,
            "TIME_ERROR": error.time, "RATE_ERROR": error.impulse * abs(item.approach_rate),
            "IMPULSE_ERROR": error.impulse * item.impulse, "AMPLITUDE": item.rebound_amplitude,
            "REBOUND": item.rebound_time, "AMPLITUDE_ERROR": rebound.amplitude,
            "REBOUND_ERROR": rebound.time,
        }  # fmt: skip
        for name, value in told.items():
            assert rows[getattr(layout, name), place] == pytest.approx(value, rel=1e-12), name
    assert rows[layout.AMPLITUDE_ERROR, 1] != rows[layout.REBOUND_ERROR, 1]
    assert assumed_transition(e62, Case(speed_rpm=650.0)).duration_error == (
        solution.errors[-1].time
    )


def test_numbers_of_the_reduced_engine(e62: Mechanism) -> None:
    found = transition(build(e62), speed_rpm=650.0)
    told = Bounces("reduced", found)
    assert told.turn is None
    assert told.values == {
        "rebound_amplitude_1": found.rebound_amplitude[0],
        "rebound_time_s_1": found.rebound_time[0], "duration_s": found.duration,
    }  # fmt: skip
    assert told.errors == {
        "rebound_amplitude_1": found.amplitude_error[0],
        "rebound_time_s_1": found.rebound_error[0], "duration_s": found.duration_error,
    }  # fmt: skip
    assert len({*told.values.values(), *told.errors.values()}) == 6
    assert list(bounces.counted({"turn": 3, "reduced": 1}).items()) == [
        ("reduced", 1), ("direct", 0), ("reduced_turn", 0), ("turn", 3),
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("reduced", "holds", "back", "engine"),
    [
        (True, True, True, "reduced"), (False, True, True, "direct"), (None, True, True, "direct"),
        ("none", True, True, "direct"), ("none", False, True, "turn"), ("none", None, True, "turn"),
        ("none", False, False, "direct"), (None, False, True, "turn"),
    ],
)  # fmt: skip
def test_the_engine_of_a_point(
    monkeypatch: pytest.MonkeyPatch,
    e62: Mechanism,
    reduced: Any,
    holds: Any,
    back: bool,
    engine: str,
) -> None:
    """Tables where they say that the premise holds; turns where it does not and they come back."""
    cases: list[Any] = []

    def assumed(_: Mechanism, case: Case) -> Any:
        cases.append(case)
        solution = SimpleNamespace(system="system", premise=SimpleNamespace(why="late"))
        return SimpleNamespace(premise_holds=holds, outcome=Outcome.AT_REST, solution=solution)

    def turns(_: Mechanism, case: Case, why: str, before: float) -> Any:
        cases.append((case, why, before))
        return SimpleNamespace(outcome=Outcome.AT_REST, solution=SimpleNamespace(repeated_from=2))

    asking = problem(rest_rate=1e-3, tolerance=1e-8)
    source = Transitions(asking)
    told = None if reduced == "none" else SimpleNamespace(premise_holds=reduced)
    monkeypatch.setattr(source, "_by_tables", lambda *_: told)
    monkeypatch.setattr(bounces, "assumed_transition", assumed)
    monkeypatch.setattr(bounces, "transition_of_turns", turns)
    monkeypatch.setattr(bounces, "comes_back", lambda _: back)
    found = source.at(e62, 512.5)
    assert found.engine == engine
    if engine == "reduced":
        assert cases == []
        return
    case = cases[0]
    assert (case.speed_rpm, case.rest_rate, case.resolution.tolerance) == (512.5, 1e-3, 1e-8)
    assert case.max_collisions == 500
    if engine == "turn":
        assert cases[1] == (case, "late", 0.0)
    assert source.why == "one, two change the machine, and so the tables"


@pytest.mark.parametrize(
    ("why", "turn", "asked", "times"),
    [("", None, "N", 0), ("late", None, "N", 1), ("late", "turn", "N", 0), ("late", None, "s", 0)],
)
def test_points_whose_kinematics_are_not_the_turns(
    monkeypatch: pytest.MonkeyPatch, why: str, turn: Any, asked: str, times: int
) -> None:
    """A turn is simulated where kinematics would be wrong, none was, and they are asked for."""
    limit = Limit(quantity="clamping_force_N", side="high", value=60.0)
    asking = problem(*([limit] if asked == "N" else []),
                     aims=(Aim(quantity="duration_s", sense=1.0),))  # fmt: skip
    source = evaluate.Evaluator(asking)
    told: list[Any] = []
    dense_asked: list[bool] = []
    own = SimpleNamespace(turn=turn, values={"duration_s": 0.5})
    monkeypatch.setattr(source, "mechanism", lambda _: "machine")
    monkeypatch.setattr(
        source.transitions, "at", lambda *_, dense: (dense_asked.append(dense), own)[1]
    )
    monkeypatch.setattr(
        source.transitions, "in_turn", lambda *words: (told.append(words), "new")[1]
    )
    monkeypatch.setattr(evaluate, "working_cycle", lambda *words: ("cycle", *words))
    monkeypatch.setattr(evaluate, "differs", lambda *words: (told.append(words), why)[1])
    known = source._known(np.array([0.5, 0.5]))
    assert dense_asked == [asked == "N"]
    if asked == "s":
        assert known.cycle is None
        assert told == []
        return
    assert known.cycle == ("cycle", "machine", 600.0)
    assert told[0] == (known.cycle, 0.5, frozenset({"duration_s", "clamping_force_N"}))
    assert told[1:] == [("machine", 600.0, "late", 0.25)] * times
    assert known.bounces == ("new" if times else own)
