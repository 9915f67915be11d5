"""The control of an optimum: what the machine does in its turns, and doctored results refused.

The file of a design as it is read, and what is told of an optimum: its record and command.
"""

from __future__ import annotations

import json
import math
import shlex
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import BALL, design, parameter, problem, study
from programs import study_text
from snapshots import Words
from waiting import notes

from nipper_pin import Case, Mechanism, Solution, Window, load, simulate
from nipper_pin.cli import main
from nipper_pin.study.optimise import Control, Design, Optimum, optimise
from nipper_pin.study.optimise.control import Row, control
from nipper_pin.study.optimise.points import Evaluator
from nipper_pin.study.optimise.problem.problem import read_text
from nipper_pin.study.optimise.problem.quantities import QUANTITIES
from nipper_pin.study.optimise.search.binding import Account, Binding
from nipper_pin.study.optimise.search.descend import Descent
from nipper_pin.study.optimise.search.samples import Found
from tests.refusals.bases import right

STATED = study_text("stated_design.toml")
# What a search led to that took transitions as they are assumed: its steeve is off its stop at the
# touch, where the transition starts on it.
MISLED = (5.8072267226383145, 260.0, 2.094944510736112)
# Limits that hold, so that a problem asks for every quantity.
EVERY = (
    STATED[: STATED.index("clamping_force_N")]
    + """duration_s = { high = 1.0 }
rebound_time_s_1 = { high = 1.0 }
closing_index = { high = 36.0 }
opening_index = { high = 8.0 }
clamping_force_N = { high = 1e4 }
stop_force_N = { high = 1e4 }
jaw_opening_deg = { low = 0.0 }
stroke_mm = { low = 0.0 }
speed_rpm = { high = 1e4 }
"""
)
# Every quantity of a whole turn.
LIMITS = "[limits]\n" + "".join(
    f"{name} = {{ low = 0.0 }}\n" for name, item in QUANTITIES.items() if item.source == "turn"
)


def whole(path: str, low: float, high: float, limits: str = LIMITS) -> str:
    head = 'model = "e62"\nmaximise = "clamped_share"\ncase = { speed_rpm = 700.0 }\n'
    return head + parameter(path, low, high) + limits


WHOLE = whole("preload", 7.0, 16.0)


def turn_of(numbers: tuple[float, ...], speed: float) -> Solution:
    """Three turns of the E62 from index 24, as `simulate --window cycle --cycles 3`."""
    names = (
        "springs.steeve.preload_length_mm", "points.eccentric_pin.angle_deg",
        "drives.tension.ratio",
    )  # fmt: skip
    mechanism = load("e62", dict(zip(names, numbers, strict=True)))
    return simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE, cycles=3))


def test_a_point_whose_premise_fails_has_the_numbers_of_its_turn(tmp_path: Path) -> None:
    """The assumed transition rebounds by 6.79 mrad; the machine by 15.3 mrad in every turn.

    Both simulations state errors below 1e-10 of the rebound; the widest opening is the largest of
    20,000 samples, which misses less than a 1e-7 of it.
    """
    found = design(problem(tmp_path, STATED), MISLED)
    assert found.engine == "turn"
    turns = turn_of(MISLED, 700.0)
    hits = [hit for hit in turns.collisions if hit.stop == "jaw"]
    later = [hit for hit in hits if hit.t > 2.0 * turns.shaft.period]
    assert later[0].rebound_amplitude == pytest.approx(0.015296, rel=1e-5)
    assert found.values["rebound_amplitude_1"] == pytest.approx(
        later[0].rebound_amplitude, rel=1e-9
    )
    assert found.values["duration_s"] == pytest.approx(turns.transitions[-1].duration, rel=1e-9)
    t = np.linspace(turns.shaft.period, 2.0 * turns.shaft.period, 20_000)
    widest = turns.trajectory.evaluate(t).q[:, turns.mechanism.stop("jaw").index].max()
    assert found.values["jaw_opening_deg"] == pytest.approx(math.degrees(widest), rel=1e-7)
    # Half of the middle half of the closed phase is over before the jaw has come to rest.
    assert 33.0 < found.values["clamping_force_N"] < 34.0


@pytest.mark.parametrize(
    ("text", "numbers", "engine"),
    [
        # The steeve stays on its stop: all comes from kinematics and the direct engine.
        (EVERY.replace("700.0", "550.0"), (11.0, 176.0, 2.2), "direct"),
        # It is back in time, but was away when the jaw was open.
        (EVERY.replace("700.0", "650.0"), (11.0, 176.0, 2.2), "turn"),
        # The premise fails.
        (EVERY, MISLED, "turn"),
        # Quantities of whole turns, by tables.
        (WHOLE, (10.6,), "reduced_turn"),
    ],
    ids=["cycle", "released", "no premise", "whole turns"],
)
def test_every_doctored_quantity_is_refused(
    text: str, numbers: tuple[float, ...], engine: str, tmp_path: Path
) -> None:
    """The true design is confirmed by the dense motion of its turns; off by little it is not."""
    found = problem(tmp_path, text)
    true = design(found, numbers)
    assert true.engine == engine
    seen = control(found.text(), true)
    assert seen.confirmed, seen.contradictions
    assert set(seen.values) == set(found.quantities)
    for row in seen.rows:
        # The least of a force is stated to what every second of its samples would change.
        off = 1e-2 if row.quantity == "stop_force_N" else 1e-4
        wrong = [row.reported * (1.0 + off), row.reported * (1.0 - off)]
        if row.turn == 0.0:
            # This stop is left in the turn, which says no more than that the force is below zero.
            wrong = [1.0]
        assert not any(replace(row, reported=value).agrees for value in wrong), row.quantity
        assert row.allowed < off * max(abs(row.reported), 1.0)


def test_turns_that_cannot_be_simulated_confirm_nothing(tmp_path: Path) -> None:
    """A model that is gone: no row, a reason, and not confirmed."""
    found = problem(tmp_path, STATED)
    true = design(found, MISLED)
    seen = control(replace(found, model=str(tmp_path / "gone")).text(), true)
    assert not seen.confirmed
    assert "no turn can be simulated" in seen.contradictions[0]


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


def test_what_is_confirmed() -> None:
    """Turns that repeat and agree; what does not is told with the unit, or why there is none."""
    good, wrong = row(quantity="speed_rpm"), row(allowed=0.1)
    none = row(unit="", turn=None, why="no rebound", breaks=("a", "b"))
    assert str(none) == (
        "duration_s is 2 as reported and none (no rebound) in the simulated turn, which breaks a "
        "and b"
    )
    assert Control(rows=(good,), turns=3, why="").confirmed
    assert not Control(rows=(good, wrong), turns=3, why="").confirmed
    assert not Control(rows=(good,), turns=3, why="they differ").confirmed
    found = Control(rows=(good, wrong), turns=3, why="they differ")
    assert found.contradictions == ("they differ", str(wrong))
    assert found.values == {"speed_rpm": 2.5, "duration_s": 2.5}


@pytest.mark.parametrize(
    ("side", "limit", "reported", "error", "breaks"),
    [
        # The report breaks it, too, and by as much within the stated error.
        ("low", 1.02, 1.01, 0.011, False), ("low", 1.02, 1.01, 0.009, True),
        ("low", 1.01, 1.02, 0.011, False),
        ("high", 0.98, 0.97, 0.01, True), ("high", 0.98, 0.99, 0.011, False),
    ],
)  # fmt: skip
def test_limits_that_a_turn_breaks(
    side: str, limit: float, reported: float, error: float, breaks: bool, tmp_path: Path
) -> None:
    """By more than the report does, and than both may err; a ball of e V bounces for 2 e V / g."""
    name, time = "rebound_time_s_1", 2.0 * 0.3 * 0.1 / 9.81
    text = BALL + f"[limits]\n{name} = {{ {side} = {limit * time!r} }}\n"
    found = problem(tmp_path, text)
    true = design(found, (0.3, 100.0))
    told = replace(
        true, values={**true.values, name: reported * time},
        errors={**true.errors, name: error * time},
    )  # fmt: skip
    (seen,) = (row for row in control(found.text(), told).rows if row.quantity == name)
    assert seen.turn == pytest.approx(time, rel=1e-9)
    assert seen.allowed == pytest.approx(error * time, rel=1e-6)
    assert seen.breaks == ((str(found.limits[0]),) if breaks else ())
    assert seen.agrees is (not breaks and abs(reported - 1.0) <= error)


def test_limits_of_indices_are_the_short_way_around(tmp_path: Path) -> None:
    """An opening at 8 is beyond 39 and before 15."""
    limits = "[limits]\nopening_index = { low = 15.0, high = 39.0 }\n"
    found = problem(tmp_path, STATED[: STATED.index("[limits]")] + limits)
    true = design(found, (11.0, 176.0, 2.2))
    told = replace(true, values={**true.values, "opening_index": 20.0})
    (seen,) = (row for row in control(found.text(), told).rows if row.quantity == "opening_index")
    assert seen.turn is not None
    assert 0.0 < seen.turn < 15.0
    assert set(seen.breaks) == {str(item) for item in found.limits}


@pytest.mark.slow
def test_an_optimum_that_is_contradicted_is_status_1_with_all_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search whose rebounds are too high by a thousandth: one sentence with both numbers.

    A ball that leaves with e V rises by (e V)^2 / 2 g; the front begins at e = 0.05, V = 0.02 m/s.
    """
    from nipper_pin.study.optimise.points.bounces import Bounces

    words = "--starts 1 --points 2 --no-check --workers 1 --json -"
    command = ["optimise", str(study(tmp_path, BALL)), *words.split()]
    assert main([*command, "--out", str(tmp_path / "right")]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["contradiction"] is None
    assert document["control"]["confirmed"]
    assert [item["control"]["confirmed"] for item in document["front"]] == [True, True]
    assert "never the maker's" in document["caution"]
    assert (tmp_path / "right" / "front.svg").read_text().startswith("<?xml")
    true = Bounces.values.fget
    assert true is not None

    def too_high(self: Bounces) -> dict[str, float]:
        values: dict[str, float] = true(self)
        return {**values, "rebound_amplitude_1": 1.001 * values["rebound_amplitude_1"]}

    monkeypatch.setattr(Bounces, "values", property(too_high))
    assert main([*command, "--out", str(tmp_path / "wrong")]) == 1
    captured = capsys.readouterr()
    height = (0.05 * 0.02) ** 2 / (2.0 * 9.81)
    assert notes(captured.err).count("\n") == 1
    assert f"{1.001 * height:.6g} m as reported and {height:.6g} m in the simulated" in captured.err
    document = json.loads(captured.out)
    assert document["contradiction"] in captured.err
    assert not document["control"]["confirmed"]
    assert document["control"]["values"]["rebound_amplitude_1"] == pytest.approx(height, rel=1e-9)
    assert json.loads((tmp_path / "wrong" / "result.json").read_text()) == document


@pytest.mark.campaign
def test_a_search_where_premises_fail_ends_where_the_turns_are(tmp_path: Path) -> None:
    """The stated problem: no design with the premise meets the limits, and 6.79 mrad is no answer.

    The optimum is what three turns of its overrides have.
    """
    found = optimise(problem(tmp_path, STATED), starts=1, check=False, workers=1)
    assert found.best.engine == "turn"
    assert found.engines["turn"] > found.engines.get("direct", 0)
    assert found.contradiction == ""
    turns = turn_of(tuple(found.best.numbers.values()), 700.0)
    later = [hit for hit in turns.collisions if hit.t > 2.0 * turns.shaft.period]
    first = next(hit for hit in later if hit.stop == "jaw")
    rebound = found.best.values["rebound_amplitude_1"]
    assert rebound == pytest.approx(first.rebound_amplitude, rel=1e-8)
    assert 0.010 < rebound < 0.011
    assert found.control.values["jaw_opening_deg"] > 25.0 - 1e-4
    assert 40.0 - 0.05 < found.control.values["clamping_force_N"] < 60.0 + 0.05


# --- quantities of whole turns -------------------------------------------------------------------


def test_a_machine_that_changes_takes_the_direct_engine(tmp_path: Path) -> None:
    """And has the same turn at the same numbers, within what both state."""
    free = whole("drives.tension.ratio", 2.1, 2.3)
    one = design(problem(tmp_path, WHOLE), [11.0])
    other = design(problem(tmp_path, free), [2.2])
    assert (one.engine, other.engine) == ("reduced_turn", "turn")
    assert len(one.values) > 8
    for name, value in one.values.items():
        allowed = one.errors[name] + other.errors[name]
        assert abs(value - other.values[name]) <= allowed, name


def test_turns_that_differ_are_no_usable_machine(tmp_path: Path) -> None:
    """At 1,900 r/min every second turn is the same."""
    source = Evaluator(problem(tmp_path, whole("speed_rpm", 1800.0, 2000.0)))
    assert "turns differ from one another" in source.at(np.array([0.5])).why


@pytest.mark.slow
def test_a_search_for_the_longest_clamping(tmp_path: Path) -> None:
    """More preload shortens the bounces, so the limit on the force binds, and the turn confirms."""
    limits = (
        "[limits]\nlargest_clamping_force_N = { high = 120.0 }\nclosing_index = { low = 30.0 }\n"
    )
    asked = problem(tmp_path, whole("preload", 7.0, 16.0, limits))
    found = optimise(asked, starts=1, check=False, workers=1)
    assert found.contradiction == ""
    assert found.best.engine == "reduced_turn"
    assert set(found.engines) == {"reduced_turn"}
    assert found.best.values["largest_clamping_force_N"] == pytest.approx(120.0, abs=1e-3)
    assert found.case.window.value == "cycle"


# --- what is told --------------------------------------------------------------------------------


AIM, TIME = "rebound_amplitude_1", "duration_s"
PRELOAD, RATIO = "springs.steeve.preload_length_mm", "drives.tension.ratio"
PROBLEM = study_text("told_design.toml")


def told_design(value: float, engine: str = "direct") -> Design:
    return Design(z=(0.25, 0.75), numbers={PRELOAD: 11.0, RATIO: 2.75},
                  values={AIM: value, TIME: 2.0}, errors={AIM: 1e-3, TIME: float("nan")},
                  slacks=(0.5,), inside=True, holding=("a limit",), engine=engine)  # fmt: skip


def told_control(turn: float = 1.0, turns: int = 3) -> Control:
    row = Row(quantity=AIM, unit="rad", reported=1.0, turn=turn, allowed=0.5)
    return Control(rows=(row,), turns=turns, why="")


@pytest.fixture(name="found")
def made_up(tmp_path: Path) -> Optimum:
    descent = Descent(start=(0.5, 0.5), z=(0.25, 0.75), aim=1.0, violation=0.0, evaluations=7,
                      failures=1, engines={"direct": 6}, converged=True)  # fmt: skip
    binding = Binding(name="b", kind="bound", value=1.0, slack=2.0, active=True, price=3.0)
    return Optimum(
        problem=problem(tmp_path, PROBLEM), seed=5, before=told_design(4.0), best=told_design(3.0),
        account=Account(bindings=(binding,), residual=0.125), descents=(descent,), screened=65,
        no_machine=("why",), check=Found(z=(0.25, 0.75), feasible=True, evaluations=40,
                                         engines={"direct": 39}),
        check_gain=0.0625, engines={"direct": 50, "turn": 2}, why_engine="they move",
        control=told_control(), front=(told_design(3.0), told_design(5.0)),
        front_controls=(told_control(), told_control(turns=4)), evaluations=123, wall_s=4.5,
    )  # fmt: skip


def test_the_record(found: Optimum, words: Words) -> None:
    """As it is written; it has no number that JSON has not."""
    words(json.dumps(found.record(), indent=1, allow_nan=False) + "\n")
    bare = replace(found, before=None, check=None).record()
    assert bare["before"] is bare["search"]["check"] is bare["relative_change"] is None
    assert replace(found, before=told_design(0.0)).gain is None


def test_the_command_and_the_case(found: Optimum) -> None:
    """Numbers to their last digit; turns and one more where the transition is one of theirs."""
    changes: dict[str, Any] = {"a.b": True, "c.d": "x y"}
    found = replace(found, problem=replace(found.problem, changes=changes))
    assert found.overrides == {**changes, PRELOAD: 11.0, RATIO: 2.75}
    ending = ["--set", "a.b=true", "--set", "c.d=x y", "--set", f"{PRELOAD}=11.0", "--set",
              f"{RATIO}=2.75"]  # fmt: skip
    begin = ["nipper-pin", "simulate", "e62", "--speed", "600.0"]
    assert shlex.split(found.command) == [*begin, *ending]
    assert found.case == Case(speed_rpm=600.0)
    limited = replace(
        found, problem=replace(found.problem, rest_rate=1e-3), best=told_design(3.0, "turn")
    )
    assert shlex.split(limited.command) == [
        *begin, "--window", "cycle", "--cycles", "4", "--rest-rate", "0.001", *ending,
    ]  # fmt: skip
    assert limited.case == Case(speed_rpm=600.0, rest_rate=1e-3, window=Window.CYCLE, cycles=4)


def test_contradictions(found: Optimum) -> None:
    """Of the best design first, then of the first point of the front that is wrong."""
    assert found.contradiction == ""
    said = str(told_control(2.0).rows[0])
    wrong = replace(
        found, control=told_control(2.0), front_controls=(told_control(2.0), told_control(2.0))
    )
    assert wrong.contradiction == f"the simulated turn contradicts the optimum: {said}"
    second = replace(found, front_controls=(told_control(), told_control(2.0)))
    assert second.contradiction == f"the simulated turn contradicts point 2 of the front: {said}"
    assert second.record()["contradiction"] == second.contradiction


def test_the_file_of_a_design(tmp_path: Path, e62: Mechanism, words: Words) -> None:
    """All keys, and what stands there where a file says nothing; the text of it is the same."""
    found = problem(tmp_path, right("design.toml").replace("format = 1\n", ""))
    plain = problem(tmp_path, 'minimise = "duration_s"\n' + parameter("restitution", 0.1, 0.3))
    said = []
    for item in (found, plain):
        texts = ("name", "urdf", "document", "folder")
        record = {key: value for key, value in asdict(item).items() if key not in texts}
        record["asked"] = [str(one) for one in (*item.aims, *item.limits)]
        assert record.pop("tolerance") == (1e-6 if item is found else 1e-10)
        assert read_text(item.text()) == item
        said.append(json.dumps(record, indent=1, default=dict))
    words("\n".join(said) + "\n")
    assert "<visual" not in found.urdf
    own = 1e3 * e62.springs[0].preload
    assert found.start == pytest.approx([(own - 9.0) / 4.0, 112.5 / 200.0, -1.0 / 3.0])
    z = np.full(3, 0.5)
    mass = {"links.top_nipper.mass_kg": pytest.approx(1.45)}
    assert found.numbers(z) == {"preload": 11.0, "speed_rpm": 500.0, **mass}
    assert found.overrides(z) == {
        "stops.jaw.restitution": 0.25, "springs.steeve.preload_length_mm": 11.0, **mass,
    }  # fmt: skip
    assert (found.speed(z), plain.speed(plain.start)) == (500.0, 450.0)
    asked = plain.with_aim(found.aims[1], *found.limits[:1])
    assert (asked.aims, asked.limits) == (found.aims[1:], found.limits[:1])
