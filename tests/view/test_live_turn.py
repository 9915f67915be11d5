"""The whole turn beside the numbers of the live page, against turns of the direct engine."""

from __future__ import annotations

import sys
import threading
from dataclasses import replace
from typing import Any

import pytest
from judge import press

from nipper_pin import Case, EventKind, Mechanism, Window, load, simulate
from nipper_pin.view.live import whole_turn
from nipper_pin.view.live.panel.numbers import Number, Rows
from nipper_pin.view.live.settings import Knob, knobs
from nipper_pin.view.live.whole_turn import WholeTurns, turn_rows, unusable

pytest.importorskip("numba", reason="numba is not installed (extra `study`)")


@pytest.fixture(scope="module")
def controls(e62: Mechanism) -> tuple[Knob, ...]:
    return knobs(e62, 650.0)


def asked(controls: tuple[Knob, ...], **values: float) -> dict[str, float]:
    return {item.key: values.get(item.key.rpartition(".")[2], item.start) for item in controls}


def read(rows: Rows) -> dict[str, str]:
    return {item.key: item.text for item in rows}


@pytest.mark.parametrize(
    "values",
    [
        {"speed": 650.0},
        {"speed": 860.0, "restitution": 0.3, "stiffness": 8.0, "preload": 12.0},
    ],
)
def test_numbers_are_those_of_the_direct_engine(
    e62: Mechanism, controls: tuple[Knob, ...], values: dict[str, float]
) -> None:
    """Indices of touch, rest and opening, and the time between the last two, of the second turn.

    Each slider moves the rest by more than its three decimals.
    """
    found = read(turn_rows(e62, controls, asked(controls, **values)))
    shown = {"speed": 650.0, "restitution": 0.2, "stiffness": 9.0, "preload": 11.0} | values
    changed = {
        "stops.jaw.restitution": shown["restitution"],
        "springs.steeve.stiffness_N_per_m": 1e3 * shown["stiffness"],
        "springs.steeve.preload_length_mm": shown["preload"],
    }
    case = Case(speed_rpm=shown["speed"], window=Window.CYCLE, cycles=2)
    run = simulate(load("e62", changed), case)
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


IN_PLACE = [
    ({"speed": 1600.0}, "rest", "no rest before it opens"),
    ({"speed": 1600.0}, "opening", "none"),
    ({"speed": 1600.0}, "clamped", "0"),
    ({"speed": 800.0, "stiffness": 3.0, "preload": 2.0}, "repeats", "after 2 turns"),
    ({"speed": 450.0, "restitution": 0.8, "preload": 0.0}, "repeats", "not within 32 turns"),
    (
        {"speed": 1600.0, "restitution": 0.1, "stiffness": 3.0, "preload": 0.0}, "turn",
        "not followed: round-off decides whether a stop comes to rest or is released",
    ),
    (
        {"speed": 1600.0, "restitution": 0.1, "stiffness": 3.0, "preload": 0.0}, "turn_engine",
        "none; simulate --window cycle takes the direct one",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("values", "key", "words"), IN_PLACE)
def test_words_in_place_of_numbers(
    e62: Mechanism, controls: tuple[Knob, ...], values: dict[str, float], key: str, words: str
) -> None:
    """A jaw that does not rest; turns that alternate; turns that are not followed."""
    assert read(turn_rows(e62, controls, asked(controls, **values)))[key] == words


def test_clamping_that_is_lost(e62: Mechanism, controls: tuple[Knob, ...]) -> None:
    """At the index at which the direct engine has the jaw released after its rest."""
    values = {"speed": 800.0, "restitution": 0.1, "preload": 0.0}
    found = read(turn_rows(e62, controls, asked(controls, **values)))
    changes = {"stops.jaw.restitution": 0.1, "springs.steeve.preload_length_mm": 0.0}
    run = simulate(load("e62", changes), Case(speed_rpm=800.0, window=Window.CYCLE, cycles=2))
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
    rows = read(turn_rows(e62, controls, asked(controls), why))
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
    turns = WholeTurns(e62, controls, told.set)
    turns.start()
    one, other = asked(controls), asked(controls, speed=700.0)
    assert turns.rows(one) == (Number("turn", "whole turn", "its tables are being made"),)
    gate.set()
    assert told.wait(60.0)

    def built(*_: Any, **__: Any) -> Any:
        message = "tables are made while a slider waits"
        raise AssertionError(message)

    monkeypatch.setattr("nipper_pin.reduced.turns.turn.build_turns", built)
    assert read(turns.rows(one))["rest"] != read(turns.rows(other))["rest"]
    high = asked(controls, speed=900.0, restitution=0.8, preload=0.0)
    assert read(turns.rows(high))["rest"] == "no rest before it opens"
