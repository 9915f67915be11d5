"""The control of premises: what it draws, reads and compares, of transitions that are made up."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nipper_pin.errors import InputError, SimulationError
from nipper_pin.hybrid.case import Window
from nipper_pin.hybrid.event import EventKind
from nipper_pin.mechanism import Mechanism

sys.path.append(str(Path(__file__).parents[2] / "scripts/maintain/measure"))

import measure_premise as premises
from measure_premise import Drawn, Judged, draw, judged

ONE = Drawn("e62", (), 512.5, 0.25, 9500.0, 0.011)
TINY = np.finfo(float).tiny


def test_what_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Groups of 25 of one machine, all numbers inside their ranges, and the same by a seed."""
    asked: list[tuple[str, dict[str, float]]] = []

    def load(model: str, overrides: dict[str, float]) -> Any:
        asked.append((model, overrides))
        if len(asked) % 5 == 0:
            words = "none such"
            raise InputError(words)
        return f"machine {len(asked)}"

    monkeypatch.setattr(premises, "load", load)
    found = list(draw(1010, 4))
    assert [len(drawn) for _, drawn in found] == [25] * 40 + [10]
    assert not any(str(name).endswith(("5", "0")) for name, _ in found)
    rows = [one for _, drawn in found for one in drawn]
    assert len(rows) == 1010
    for key, low, high in (("speed_rpm", 350.0, 750.0), ("restitution", 0.0, 0.5),
                           ("stiffness", 6000.0, 12000.0), ("preload", 0.007, 0.014)):  # fmt: skip
        values = np.array([getattr(one, key) for one in rows])
        assert low <= values.min() < low + 0.02 * (high - low)
        assert high - 0.02 * (high - low) < values.max() <= high
    assert {model for model, _ in asked} == {"e62", "e62_identified", "e62_offset_guide"}
    plain = [overrides for _, overrides in asked if len(overrides) == 1]
    whole = [overrides for _, overrides in asked if len(overrides) == 4]
    assert len(plain) + len(whole) == len(asked)
    # One in four: within three standard deviations of as many throws.
    assert abs(len(plain) - 0.25 * len(asked)) < 3.0 * math.sqrt(0.1875 * len(asked))
    assert all(list(item) == ["stops.steeve.restitution"] for item in plain)
    for key, low, high in (("points.eccentric_pin.radius_mm", 3.0, 7.0),
                           ("points.eccentric_pin.angle_deg", 120.0, 230.0),
                           ("drives.tension.ratio", 1.8, 2.6)):  # fmt: skip
        values = np.array([item[key] for item in whole])
        assert low <= values.min() < low + 0.2 * (high - low)
        assert high - 0.2 * (high - low) < values.max() <= high
    loss = np.array([item["stops.steeve.restitution"] for item in [*plain, *whole]])
    # Squares of even numbers: half of them below a quarter.
    assert 0.3 < np.mean(loss < 0.25) < 0.7
    assert loss.max() > 0.8
    for (_, drawn), overrides in zip(found, (o for n, (_, o) in enumerate(asked, 1) if n % 5),
                                     strict=False):  # fmt: skip
        assert {one.overrides for one in drawn} == {tuple(overrides.items())}
    asked.clear()
    assert [drawn for _, drawn in draw(1010, 4)] == [drawn for _, drawn in found]
    asked.clear()
    assert [drawn for _, drawn in draw(25, 5)] != [drawn for _, drawn in found[:1]]
    assert [len(drawn) for _, drawn in draw(25, 5)] == [25]


def hit(number: int, t: float, stop: str = "jaw") -> Any:
    return SimpleNamespace(stop=stop, t=t, event=SimpleNamespace(number=number), approach_rate=-4.0,
                           rebound_amplitude=0.5, rebound_time=0.25)  # fmt: skip


def run(*hits: Any, begin: float = 1.0, **changes: Any) -> Any:
    """Six events, the fourth and the fifth of them rests."""
    kinds = [("collision", "jaw"), ("collision", "jaw"), ("collision", "jaw"), ("rest", "steeve"),
             ("rest", "jaw"), ("rest", "jaw")]  # fmt: skip
    events = tuple(
        SimpleNamespace(kind=EventKind(kind), stops=(stop,), number=n)
        for n, (kind, stop) in enumerate(kinds, 1)
    )
    errors = tuple(SimpleNamespace(time=1e-6 * 2**n, impulse=1e-3 * (n % 3 + 1)) for n in range(6))
    given = {
        "mechanism": SimpleNamespace(transition_stop="jaw"), "collisions": hits, "events": events,
        "errors": errors, "transitions": [SimpleNamespace(t_start=begin, duration=0.75)],
    }  # fmt: skip
    return SimpleNamespace(**{**given, **changes})


def test_numbers_of_a_transition() -> None:
    """Of the first collision from a time on: its rate, its rebound and the time to the rest."""
    found = premises._numbers(
        run(hit(1, 0.5), hit(9, 1.0, "steeve"), hit(2, 1.0), hit(3, 2.0)), 0.6
    )
    assert found is not None
    assert found.values == pytest.approx([-4.0, 0.5, 0.25, 0.75])
    # The second event is off by 2e-6 s and 2e-3, the next by 4e-6 s and 3e-3, the rest by 16e-6 s.
    assert found.errors == pytest.approx([2e-3 * 4.0, 2.0 * 3e-3 * 0.5, 6e-6 + 3e-3 * 0.25, 18e-6])
    last = premises._numbers(run(hit(3, 1.0)), 1.0)
    assert last is not None
    # Of the third the own rate is the worse one: 3e-3 beside 1e-3.
    assert last.errors == pytest.approx([3e-3 * 4.0, 3e-3, 12e-6 + 3e-3 * 0.25, 20e-6])
    assert premises._numbers(run(hit(1, 0.5)), 0.6) is None
    assert premises._numbers(run(hit(2, 1.1)), 0.6) is None
    assert premises._numbers(run(hit(2, 1.0), transitions=[]), 0.6) is None
    for name in ("rebound_amplitude", "rebound_time"):
        bare = hit(2, 1.0)
        setattr(bare, name, None)
        assert premises._numbers(run(bare), 0.6) is None
    still = run(hit(2, 1.0), errors=tuple(SimpleNamespace(time=0.0, impulse=0.0) for _ in range(6)))
    exact = premises._numbers(still, 0.0)
    assert exact is not None
    assert exact.errors.tolist() == [TINY] * 4


def numbers(*values: float, errors: float = 0.1) -> Any:
    return premises._Numbers(np.array(values), np.full(len(values), errors))


def test_how_far_two_are_apart() -> None:
    """The worst of all, by both errors; infinitely where the turn has none."""
    one, other = numbers(1.0, 2.0, 3.0), numbers(1.05, 1.4, 3.1, errors=0.2)
    assert premises._apart(one, other) == pytest.approx(2.0)
    assert premises._apart(one, None) == math.inf
    for holds, apart, wrong in ((True, 1.1, True), (True, 0.9, False), (False, 9.0, False),
                                (None, 9.0, False)):  # fmt: skip
        assert Judged(ONE, "direct", holds, apart).wrong is wrong


def test_what_both_engines_say(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Each against the second of two turns that are both computed; what fails is left out."""
    cases: list[Any] = []

    def simulate(machine: Any, case: Any) -> Any:
        cases.append((machine, case))
        if case.speed_rpm == 600.0:
            words = "no"
            raise SimulationError(words)
        shaft = SimpleNamespace(period=0.125)
        return SimpleNamespace(
            window=case.window, shaft=shaft, premise_holds=None, speed=case.speed_rpm
        )

    def read(solution: Any, begin: float) -> Any:
        if solution.window is Window.CYCLE:
            assert begin == 0.125
            return numbers(1.0, errors=0.0)
        assert begin == 0.0
        return None if solution.speed == 700.0 else numbers(1.3)

    monkeypatch.setattr(premises, "simulate", simulate)
    monkeypatch.setattr(premises, "_numbers", read)
    monkeypatch.setattr(premises, "retuned", lambda *words: words)
    drawn = [ONE, replace(ONE, speed_rpm=600.0), replace(ONE, speed_rpm=700.0)]
    known = [(True, numbers(1.2)), (True, numbers(1.2)), None]
    monkeypatch.setattr(premises, "_reduced", lambda *_: known)
    found = judged(e62, drawn)
    assert [(item.drawn, item.engine, item.holds) for item in found] == [
        (ONE, "direct", None), (ONE, "reduced", True),
    ]  # fmt: skip
    assert [item.apart for item in found] == pytest.approx([3.0, 2.0])
    (machine, first), (_, turns) = cases[:2]
    assert machine[0] is e62
    assert machine[1] == 0.25
    assert (machine[2].tolist(), machine[3].tolist()) == ([9500.0], [0.011])
    assert first.window is Window.TRANSITION
    assert (turns.window, turns.cycles, turns.reuse_cycles) == (Window.CYCLE, 2, False)
    assert turns.speed_rpm == 512.5


def test_what_the_reduced_engine_says(monkeypatch: pytest.MonkeyPatch, e62: Mechanism) -> None:
    """Verdicts and numbers in their columns; nothing of what it has not solved."""
    asked: dict[str, Any] = {}
    n = 4

    def column(start: float) -> np.ndarray:
        return start + np.arange(2.0 * n).reshape(n, 2)

    def transitions(model: Any, **named: Any) -> Any:
        asked.update(named, model=model)
        return SimpleNamespace(
            status=np.array([0, 0, 3, 0]), premise=np.array([1, 0, 1, -1]),
            approach_rate=column(10.0), rebound_amplitude=column(20.0), rebound_time=column(30.0),
            duration=40.0 + np.arange(n), rate_error=column(50.0), amplitude_error=column(60.0),
            rebound_error=column(70.0), duration_error=80.0 + np.arange(n),
        )  # fmt: skip

    monkeypatch.setattr(premises, "transitions", transitions)
    monkeypatch.setattr(premises, "reduced_model", lambda machine: ("tables", machine))
    drawn = [replace(ONE, speed_rpm=500.0 + k, restitution=0.1 * k, stiffness=9e3 + k,
                     preload=0.01 + 1e-3 * k) for k in range(n)]  # fmt: skip
    found = premises._reduced(e62, drawn)
    assert asked["model"] == ("tables", e62)
    assert asked["speed_rpm"] == [500.0, 501.0, 502.0, 503.0]
    assert asked["restitution"] == pytest.approx([0.0, 0.1, 0.2, 0.3])
    assert asked["stiffness"] == [9000.0, 9001.0, 9002.0, 9003.0]
    assert asked["preload"] == pytest.approx([0.01, 0.011, 0.012, 0.013])
    assert asked["max_collisions"] == 256
    assert found[2] is None
    for place, holds in ((0, True), (1, False), (3, None)):
        told = found[place]
        assert told is not None
        assert told[0] is holds
        k = 2.0 * place
        assert told[1].values.tolist() == [10.0 + k, 20.0 + k, 30.0 + k, 40.0 + place]
        assert told[1].errors.tolist() == [50.0 + k, 60.0 + k, 70.0 + k, 80.0 + place]

    def refused(*_: Any, **__: Any) -> Any:
        words = "no tables"
        raise SimulationError(words)

    monkeypatch.setattr(premises, "transitions", refused)
    assert premises._reduced(e62, drawn) == [None] * 4
