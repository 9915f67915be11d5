"""The file of a design as it is read, and what is told of an optimum: its record and command."""

from __future__ import annotations

import json
import shlex
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from designs import parameter, problem
from snapshots import Words

from nipper_pin import Case, Mechanism, Window
from nipper_pin.study.optimise import Control, Design, Optimum
from nipper_pin.study.optimise.control import Row
from nipper_pin.study.optimise.problem.problem import read_text
from nipper_pin.study.optimise.search.binding import Account, Binding
from nipper_pin.study.optimise.search.descend import Descent
from nipper_pin.study.optimise.search.samples import Found
from tests.refusals.studies import DESIGN

AIM, TIME = "rebound_amplitude_1", "duration_s"
PRELOAD, RATIO = "springs.steeve.preload_length_mm", "drives.tension.ratio"
PROBLEM = f"""
title = "mine"
model = "e62"
minimise = "{AIM}"
maximise = "{TIME}"
case = {{ speed_rpm = 600.0 }}
limits = {{ {TIME} = {{ high = 3.0 }} }}
set = {{ "stops.jaw.restitution" = 0.25 }}
parameters = {{ "{PRELOAD}" = {{ low = 10.0, high = 14.0 }}, \
"{RATIO}" = {{ low = 2.0, high = 3.0 }} }}
"""


def design(value: float, engine: str = "direct") -> Design:
    return Design(z=(0.25, 0.75), numbers={PRELOAD: 11.0, RATIO: 2.75},
                  values={AIM: value, TIME: 2.0}, errors={AIM: 1e-3, TIME: float("nan")},
                  slacks=(0.5,), inside=True, holding=("a limit",), engine=engine)  # fmt: skip


def control(turn: float = 1.0, turns: int = 3) -> Control:
    row = Row(quantity=AIM, unit="rad", reported=1.0, turn=turn, allowed=0.5)
    return Control(rows=(row,), turns=turns, why="")


@pytest.fixture(name="found")
def made_up(tmp_path: Path) -> Optimum:
    descent = Descent(start=(0.5, 0.5), z=(0.25, 0.75), aim=1.0, violation=0.0, evaluations=7,
                      failures=1, engines={"direct": 6}, converged=True)  # fmt: skip
    binding = Binding(name="b", kind="bound", value=1.0, slack=2.0, active=True, price=3.0)
    return Optimum(
        problem=problem(tmp_path, PROBLEM), seed=5, before=design(4.0), best=design(3.0),
        account=Account(bindings=(binding,), residual=0.125), descents=(descent,), screened=65,
        no_machine=("why",), check=Found(z=(0.25, 0.75), feasible=True, evaluations=40,
                                         engines={"direct": 39}),
        check_gain=0.0625, engines={"direct": 50, "turn": 2}, why_engine="they move",
        control=control(), front=(design(3.0), design(5.0)),
        front_controls=(control(), control(turns=4)), evaluations=123, wall_s=4.5,
    )  # fmt: skip


def test_the_record(found: Optimum, words: Words) -> None:
    """As it is written; it has no number that JSON has not."""
    words(json.dumps(found.record(), indent=1, allow_nan=False) + "\n")
    bare = replace(found, before=None, check=None).record()
    assert bare["before"] is bare["search"]["check"] is bare["relative_change"] is None
    assert replace(found, before=design(0.0)).gain is None


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
        found, problem=replace(found.problem, rest_rate=1e-3), best=design(3.0, "turn")
    )
    assert shlex.split(limited.command) == [
        *begin, "--window", "cycle", "--cycles", "4", "--rest-rate", "0.001", *ending,
    ]  # fmt: skip
    assert limited.case == Case(speed_rpm=600.0, rest_rate=1e-3, window=Window.CYCLE, cycles=4)


def test_contradictions(found: Optimum) -> None:
    """Of the best design first, then of the first point of the front that is wrong."""
    assert found.contradiction == ""
    said = str(control(2.0).rows[0])
    wrong = replace(found, control=control(2.0), front_controls=(control(2.0), control(2.0)))
    assert wrong.contradiction == f"the simulated turn contradicts the optimum: {said}"
    second = replace(found, front_controls=(control(), control(2.0)))
    assert second.contradiction == f"the simulated turn contradicts point 2 of the front: {said}"
    assert second.record()["contradiction"] == second.contradiction


def test_the_file_of_a_design(tmp_path: Path, e62: Mechanism, words: Words) -> None:
    """All keys, and what stands there where a file says nothing; the text of it is the same."""
    found = problem(tmp_path, DESIGN.replace("format = 1\n", ""))
    plain = problem(tmp_path, 'minimise = "duration_s"\n' + parameter("restitution", 0.1, 0.3))
    said = []
    for item in (found, plain):
        record = {key: value for key, value in asdict(item).items() if key != "sources"}
        record["asked"] = [str(one) for one in (*item.aims, *item.limits)]
        assert record.pop("tolerance") == (1e-6 if item is found else 1e-10)
        assert read_text(item.text()) == item
        said.append(json.dumps(record, indent=1, default=dict))
    words("\n".join(said) + "\n")
    assert "<visual" not in found.sources.urdf
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
