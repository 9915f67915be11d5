"""The live page: what it is built of, what it says of a setting, and its sliders and fields.

Words of the page are reviewed texts of real pages; its numbers are compared with runs of the
model's file in test_surfaces.py.
"""

from __future__ import annotations

import math
import re
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from judge import press
from snapshots import Words

from nipper_pin import Case, EventKind, InputError, Mechanism, Window, load, simulate
from nipper_pin.view.live import answer as answers
from nipper_pin.view.live import whole_turn
from nipper_pin.view.live.answer import Answer, Number, Rows, answer, difference
from nipper_pin.view.live.settings import Knob, knobs
from nipper_pin.view.live.whole_turn import WholeTurns, turn_rows, unusable


def stand(controls: tuple[Knob, ...], **values: float) -> dict[str, float]:
    """Where sliders stand: at their starts, but for some."""
    assert set(values) <= {item.key.rpartition(".")[2] for item in controls}
    return {item.key: values.get(item.key.rpartition(".")[2], item.start) for item in controls}


def asked(mechanism: Mechanism, **values: float) -> Answer:
    controls = knobs(mechanism, 650.0)
    return answer(mechanism, controls, stand(controls, **values))


# What the page says.

BACKWARDS = {"cylinder.direction": "counter-clockwise"}
SETTINGS: dict[str, Callable[[], Answer]] = {
    "no turn has it": lambda: asked(load("e62"), speed=800.0, restitution=0.4),
    "no rebound": lambda: asked(load("e62"), restitution=0.0),
    "no run": lambda: asked(load("e62", BACKWARDS)),
    "press": lambda: asked(press()),
}


@pytest.mark.parametrize("name", SETTINGS)
def test_words_of_a_setting(name: str, words: Words) -> None:
    """Numbers with their units, or the reason why there are none."""
    found = SETTINGS[name]()
    assert (found.solution is None) == bool(found.message)
    assert bool(found.rows) is not bool(found.message)
    rows = (f"{item.key}: {item.label}: {item.text}" for item in found.rows)
    text = "\n".join([found.setting, found.message or "-", *rows, ""])
    words(re.sub(r"direct, [\d.]+ ms", "direct, # ms", text))


def test_without_restitution_the_jaw_is_shut(e62: Mechanism) -> None:
    found = asked(e62, restitution=0.0)
    assert found.impulse.shape == (2, 1)
    assert not found.gap[1].any()
    assert found.force[1, -1] > 50.0


def test_the_force_behind_the_rest_is_that_of_a_whole_turn(e62: Mechanism) -> None:
    """A turn from its start arrives at the same rest and goes on; its forces are other lines."""
    found = asked(e62)
    turn = simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))
    touch = next(hit.t for hit in turn.collisions if hit.stop == "jaw")
    t, force = found.force
    shut = t >= 1e3 * simulate(e62, Case(speed_rpm=650.0)).transitions[0].duration
    assert shut.sum() == 9
    times = touch + 1e-3 * t[shut]
    wanted = turn.trajectory.reactions(times).contacts["jaw"]
    np.testing.assert_allclose(force[shut], wanted, rtol=1e-9)
    assert not force[~shut].any()
    assert t[-1] - t[shut][0] == pytest.approx(6e4 / 650.0 / 40.0)


def test_other_stops_on_the_way_have_a_row(e62: Mechanism) -> None:
    """After the numbers of the transition; without any there is none."""
    run = simulate(e62, Case(speed_rpm=650.0))
    other = replace(run.collisions[1], stop="steeve")
    rows = answers._rows(run, list(run.collisions), [other])
    late = 1e3 * (other.t - run.collisions[0].t)
    said = f"On the way the steeve struck its stop once, first after {late:.3g} ms."
    assert rows[-2][:3] == ("others", "other stops", said)
    assert "others" not in {key for key, *_ in answers._rows(run, list(run.collisions), [])}


# Sliders and fields.


def told(controls: tuple[Knob, ...]) -> str:
    return "".join(
        f"{item.key}: {item.shown.label}, {item.low:g} to {item.high:g} by {item.step:g}, starts "
        f"at {item.start:g}; times {1.0 / item.shown.factor:.6g} in SI\n" for item in controls
    )  # fmt: skip


def test_words_of_sliders(e62: Mechanism, words: Words) -> None:
    """0.4 to 2 times the rated speed, a quarter to 2.5 times of rate and preload, in round steps.

    Of the E62, of one that is livelier or started elsewhere, and of springs at hinges: a rate of
    zero cannot be scaled, and a preload of zero has usual ends.
    """
    machine, degree = press(), math.radians(1.0)
    spring, steeve = machine.springs[0], replace(e62.springs[0], preload=0.0)
    found = {
        "the E62": knobs(e62, 650.0),
        "far from its speed": (*knobs(e62, 1234.5)[:1], *knobs(e62, 20.0)[:1]),
        "a lively jaw": knobs(load("e62", {"stops.jaw.restitution": 0.93}), 650.0)[1:2],
        "a hinge": knobs(machine, 30.0),
        "without rate and preload": knobs(
            replace(machine, springs=(replace(spring, preload=0.0, stiffness=0.0),)), 30.0
        ),
        "pulled": knobs(replace(machine, springs=(replace(spring, preload=-20.0 * degree),)), 30.0),
        "two springs": knobs(replace(e62, springs=(steeve, replace(steeve, name="other"))), 650.0),
    }
    for controls in found.values():
        for item in controls:
            assert item.low <= item.start <= item.high
    words("\n".join(f"{name}\n{told(controls)}" for name, controls in found.items()))


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
def test_an_unusable_speed_is_refused(e62: Mechanism, speed: float) -> None:
    with pytest.raises(InputError, match="a finite speed above 0"):
        knobs(e62, speed)


def test_each_spring_has_sliders_of_its_own(e62: Mechanism) -> None:
    """Of two; what no slider names stays as it is."""
    spring = e62.springs[0]
    two = replace(e62, springs=(spring, replace(spring, name="other")))
    found = answer(two, knobs(two, 650.0), {
        "speed": 650.0, "restitution": 0.31, "steeve.stiffness": 5.0, "steeve.preload": 6.0,
        "other.stiffness": 7.0, "other.preload": 8.0,
    })  # fmt: skip
    assert found.solution is not None
    made = found.solution.mechanism
    # Two roundings of their units.
    numbers = {item.name: pytest.approx((item.stiffness, item.preload), rel=4e-16)
               for item in made.springs}  # fmt: skip
    assert numbers == {"steeve": (5e3, 6e-3), "other": (7e3, 8e-3)}
    known = {stop.name: stop.restitution for stop in e62.stops}
    assert {stop.name: stop.restitution for stop in made.stops} == {**known, "jaw": 0.31}


def test_differences_are_per_cent_or_indices() -> None:
    def of(value: float | None, *, on_scale: bool = False) -> Number:
        return Number("key", "label", "text", value, on_scale)

    assert difference(of(103.25), of(100.0)) == "+3.25 %"
    assert difference(of(-99.0), of(-100.0)) == "-1.00 %"
    assert difference(of(100.001), of(100.0)) == "< 0.01 %"
    assert difference(of(0.0), of(0.0)) == "0"
    assert difference(of(39.9, on_scale=True), of(0.2, on_scale=True)) == "-0.300"
    for now, other in ((1.0, 0.0), (None, 1.0), (1.0, None), (float("nan"), 1.0)):
        assert difference(of(now), of(other)) == ""
    assert difference(of(1.0), None) == ""


# The whole turn beside the numbers, against turns of the direct engine.


@pytest.fixture(scope="module")
def controls(e62: Mechanism) -> tuple[Knob, ...]:
    pytest.importorskip("numba", reason="numba is not installed (extra `study`)")
    return knobs(e62, 650.0)


def read(rows: Rows) -> dict[str, str]:
    return {item.key: item.text for item in rows}


def test_numbers_are_those_of_the_direct_engine(e62: Mechanism, controls: tuple[Knob, ...]) -> None:
    """Indices of touch, rest and opening, and the time between the last two, of the second turn.

    Each slider moves the rest by more than its three decimals.
    """
    values = {"restitution": 0.3, "stiffness": 8.0, "preload": 12.0}
    found = read(turn_rows(e62, controls, stand(controls, speed=860.0, **values)))
    case = Case(speed_rpm=860.0, window=Window.CYCLE, cycles=2)
    run = simulate(load("e62", values | {"stiffness": 8e3}), case)
    period = run.shaft.period
    touch = next(hit for hit in run.collisions if hit.stop == "jaw" and hit.t > period)
    later = [event for event in run.events if event.t > touch.t]
    rest = next(item for item in later if item.kind is EventKind.REST and "jaw" in item.stops)
    opening = next(
        item for item in later
        if item.t > rest.t and "jaw" in item.closed_before and "jaw" not in item.closed_after
    )  # fmt: skip
    for key, t in (("closing", touch.t), ("rest", rest.t), ("opening", opening.t)):
        index = run.mechanism.cylinder.index_from_angle(float(run.shaft.angle(t)))
        assert float(found[key]) == pytest.approx(index, abs=6e-4), key
    assert float(found["held"]) == pytest.approx(1e3 * (opening.t - rest.t), rel=6e-4)
    assert float(found["clamped"]) == pytest.approx(100.0 * (opening.t - rest.t) / period, rel=6e-4)
    assert (found["lost"], found["repeats"]) == ("not lost", "every turn")
    assert found["turn_engine"].startswith("reduced, ")


LOST = {"speed": 1600.0, "restitution": 0.1, "stiffness": 3.0, "preload": 0.0}


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"speed": 1600.0}, {"rest": "no rest before it opens", "opening": "none", "clamped": "0"}),
        ({"speed": 800.0, "stiffness": 3.0, "preload": 2.0}, {"repeats": "after 2 turns"}),
        ({"speed": 450.0, "restitution": 0.8, "preload": 0.0},
         {"repeats": "not within 32 turns"}),
        (LOST, {
            "turn": "not followed: round-off decides whether a stop comes to rest or is released",
            "turn_engine": "none; simulate --window cycle takes the direct one"}),
    ],
)  # fmt: skip
def test_words_in_place_of_numbers(
    e62: Mechanism, controls: tuple[Knob, ...], values: dict[str, float], words: dict[str, str]
) -> None:
    """A jaw that does not rest; turns that alternate; turns that are not followed."""
    found = read(turn_rows(e62, controls, stand(controls, **values)))
    assert {key: found[key] for key in words} == words


def test_clamping_that_is_lost(e62: Mechanism, controls: tuple[Knob, ...]) -> None:
    """At the index at which the direct engine has the jaw released after its rest."""
    values = {"speed": 800.0, "restitution": 0.1, "preload": 0.0}
    found = read(turn_rows(e62, controls, stand(controls, **values)))
    changed = load("e62", {"restitution": 0.1, "preload": 0.0})
    run = simulate(changed, Case(speed_rpm=800.0, window=Window.CYCLE, cycles=2))
    released = [event for event in run.events
                if event.kind is EventKind.RELEASE and "jaw" in event.stops]  # fmt: skip
    index = run.mechanism.cylinder.index_from_angle(float(run.shaft.angle(released[-1].t)))
    assert float(found["lost"]) == pytest.approx(index, abs=6e-4)
    assert found["opening"] == "none"


def test_without_tables_the_reason_is_told(
    e62: Mechanism, controls: tuple[Knob, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of machines that have none, of laws that depend on the rate, and without numba."""
    assert unusable(e62) == ""
    assert "one degree of freedom in flight, and 2 are left" in unusable(press())
    law: Any = "any"
    lawful = tuple(replace(stop, law=law) for stop in e62.stops)
    why = unusable(replace(e62, stops=lawful))
    assert "constant restitutions" in why
    rows = read(turn_rows(e62, controls, stand(controls), why))
    assert rows["turn"] == f"not followed: {why}"
    assert rows["turn_engine"] == "none; simulate --window cycle takes the direct one"
    monkeypatch.setitem(sys.modules, "numba", None)
    assert unusable(e62) == "it needs numba (extra study)"


def test_tables_are_made_beside_the_page(
    e62: Mechanism, controls: tuple[Knob, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """In another thread, the wider ones too; then a turn comes at once, in the one that asks."""
    gate, told = threading.Event(), threading.Event()
    real = whole_turn.unusable
    monkeypatch.setattr(whole_turn, "unusable", lambda machine: (gate.wait(), real(machine))[1])
    turns = WholeTurns(e62, controls)
    turns.start(told.set)
    one, other = stand(controls), stand(controls, speed=700.0)
    assert turns.rows(one) == (Number("turn", "whole turn", "its tables are being made"),)
    gate.set()
    assert told.wait(60.0)

    def built(*_: Any, **__: Any) -> Any:
        message = "tables are made while a slider waits"
        raise AssertionError(message)

    monkeypatch.setattr("nipper_pin.reduced.turns.model.charts_of", built)
    assert read(turns.rows(one))["rest"] != read(turns.rows(other))["rest"]
    high = stand(controls, speed=900.0, restitution=0.8, preload=0.0)
    assert read(turns.rows(high))["rest"] == "no rest before it opens"
