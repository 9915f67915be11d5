"""Every key of an optimum's result, its command, its case and its contradictions."""

from __future__ import annotations

import shlex
from dataclasses import asdict, replace
from typing import Any

import pytest
from polynomial_problem import problem

from nipper_pin import Case, Window
from nipper_pin.study.optimise.control import Control
from nipper_pin.study.optimise.control.compare import Row
from nipper_pin.study.optimise.design import Design
from nipper_pin.study.optimise.problem.problem import Aim, Limit
from nipper_pin.study.optimise.result import CAUTION, Optimum
from nipper_pin.study.optimise.search.binding import Account, Binding
from nipper_pin.study.optimise.search.descend import Descent
from nipper_pin.study.optimise.search.samples import Found

AIM, TIME = "rebound_amplitude_1", "duration_s"


def design(value: float, engine: str = "direct") -> Design:
    return Design(z=(0.25, 0.75), numbers={"one": 11.0, "two": 0.5}, values={AIM: value, TIME: 2.0},
                  errors={AIM: 1e-3, TIME: float("nan")}, slacks=(0.5,), inside=True,
                  holding=("a limit",), engine=engine)  # fmt: skip


def control(turn: float = 1.0, turns: int = 3) -> Control:
    row = Row(quantity=AIM, unit="rad", reported=1.0, turn=turn, allowed=0.5)
    return Control(rows=(row,), turns=turns, why="")


DESCENT = Descent(start=(0.5, 0.5), z=(0.25, 0.75), aim=1.0, violation=0.0, evaluations=7,
                  failures=1, engines={"direct": 6}, converged=True)  # fmt: skip
BINDING = Binding(name="b", kind="bound", value=1.0, slack=2.0, active=True, price=3.0)
FOUND = Found(z=(0.25, 0.75), feasible=True, evaluations=40, engines={"direct": 39})


def optimum(**changes: Any) -> Optimum:
    asking = problem(Limit(quantity=TIME, side="high", value=3.0),
                     aims=(Aim(quantity=AIM, sense=1.0), Aim(quantity=TIME, sense=-1.0)),
                     changes={"stops.jaw.restitution": 0.25, "a.b": True,
                              "c.d": "x y"})  # fmt: skip
    given: dict[str, Any] = {
        "problem": asking, "seed": 5, "before": design(4.0), "best": design(3.0),
        "account": Account(bindings=(BINDING,), residual=0.125), "descents": (DESCENT,),
        "screened": 65, "no_machine": ("why",), "check": FOUND, "check_gain": 0.0625,
        "engines": {"direct": 50, "turn": 2}, "why_engine": "they move", "control": control(),
        "front": (design(3.0), design(5.0)), "front_controls": (control(), control(turns=4)),
        "evaluations": 123, "wall_s": 4.5,
    }  # fmt: skip
    return Optimum(**{**given, **changes})


def test_the_record() -> None:
    found = optimum()
    record = found.record()
    assert record == {
        "title": "mine", "model": "e62", "caution": CAUTION,
        "aims": ["minimise rebound_amplitude_1", "maximise duration_s"],
        "limits": ["duration_s <= 3"],
        "parameters": [
            {"name": "one", "path": "to.one", "low": 10.0, "high": 14.0, "before": 11.0,
             "optimum": 11.0},
            {"name": "two", "path": "to.two", "low": -1.0, "high": 1.0, "before": -0.5,
             "optimum": 0.5},
        ],
        "before": design(4.0).record(), "optimum": design(3.0).record(),
        "relative_change": pytest.approx(-0.25), "holding": [asdict(BINDING)],
        "first_order_residual": 0.125, "control": control().record(), "contradiction": None,
        "front": [{**design(3.0).record(), "control": control().record()},
                  {**design(5.0).record(), "control": control(turns=4).record()}],
        "overrides": found.overrides, "command": found.command,
        "search": {
            "seed": 5, "engines": {"direct": 50, "turn": 2}, "why_engine": "they move",
            "screened": 65, "no_machine": ["why"], "descents": [asdict(DESCENT)],
            "check": asdict(FOUND), "check_gain": 0.0625,
        },
        "work": {"evaluations": 123, "wall_s": 4.5},
    }  # fmt: skip
    assert record["optimum"]["errors"] == {AIM: 1e-3, TIME: None}
    bare = optimum(before=None, check=None).record()
    assert bare["before"] is bare["search"]["check"] is bare["relative_change"] is None
    assert optimum(before=design(0.0)).gain is None


def test_the_command_and_the_case() -> None:
    """Numbers to their last digit; turns and one more where the transition is one of theirs."""
    found = optimum()
    assert found.overrides == {
        "stops.jaw.restitution": 0.25, "a.b": True, "c.d": "x y", "to.one": 11.0, "to.two": 0.5,
    }  # fmt: skip
    ending = ["--set", "stops.jaw.restitution=0.25", "--set", "a.b=true", "--set", "c.d=x y",
              "--set", "to.one=11.0", "--set", "to.two=0.5"]  # fmt: skip
    begin = ["nipper-pin", "simulate", "e62", "--speed", "600.0"]
    assert shlex.split(found.command) == [*begin, *ending]
    assert found.case == Case(speed_rpm=600.0)
    limited = optimum(problem=replace(found.problem, rest_rate=1e-3), best=design(3.0, "turn"))
    assert shlex.split(limited.command) == [
        *begin, "--window", "cycle", "--cycles", "4", "--rest-rate", "0.001", *ending,
    ]  # fmt: skip
    assert limited.case == Case(speed_rpm=600.0, rest_rate=1e-3, window=Window.CYCLE, cycles=4)


def test_contradictions() -> None:
    """Of the best design first, then of the first point of the front that is wrong."""
    assert optimum().contradiction == ""
    said = "rebound_amplitude_1 is 1 rad as reported and 2 rad in the simulated turn"
    wrong = optimum(control=control(2.0), front_controls=(control(2.0), control(2.0)))
    assert wrong.contradiction == f"the simulated turn contradicts the optimum: {said}"
    second = optimum(front_controls=(control(), control(2.0)))
    assert second.contradiction == (f"the simulated turn contradicts point 2 of the front: {said}")
    assert second.record()["contradiction"] == second.contradiction
