"""The whole turn beside the numbers of the live page, against turns of the direct engine."""

from __future__ import annotations

import threading
from dataclasses import replace
from typing import Any

import pytest

from nipper_pin import Case, EventKind, Mechanism, SimulationError, Window, load, simulate
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


def test_words_in_place_of_numbers(
    e62: Mechanism, controls: tuple[Knob, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A jaw that does not rest; turns that alternate; clamping that is lost; turns not followed."""
    found = read(turn_rows(e62, controls, asked(controls, speed=1600.0)))
    assert found["rest"] == "no rest before it opens"
    assert (found["clamped"], found["opening"]) == ("0", "none")
    real = whole_turn.turn_quantities

    def doctored(**changes: Any) -> Rows:
        monkeypatch.setattr(
            whole_turn, "turn_quantities", lambda *a, **b: replace(real(*a, **b), **changes)
        )
        return turn_rows(e62, controls, asked(controls))

    known = real(e62, speed_rpm=650.0)
    table = known.table.copy()
    table[0, 2] = 3.0
    lost = read(doctored(table=table))["lost"]
    assert float(lost) == pytest.approx((24.0 + 40.0 * 3.0 / 6.283185307) % 40.0, abs=6e-4)
    assert read(doctored(repeats_after=known.repeats_after + 1))["repeats"] == "after 2 turns"
    assert read(doctored(repeats_after=0 * known.repeats_after))["repeats"] == "not within 32 turns"
    refused = read(doctored(status=known.status + 5))
    assert refused["turn"] == "not followed: there are more collisions than max_collisions allows"
    assert refused["turn_engine"].startswith("none")


def test_without_tables_the_reason_is_told(
    e62: Mechanism, controls: tuple[Knob, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert unusable(e62) == ""
    law: Any = "any"
    lawful = tuple(replace(stop, law=law) for stop in e62.stops)
    why = unusable(replace(e62, stops=lawful))
    assert "constant restitutions" in why
    rows = read(turn_rows(e62, controls, asked(controls), why))
    assert rows["turn"] == f"not followed: {why}"
    assert rows["turn_engine"] == "none; simulate --window cycle takes the direct one"
    monkeypatch.setattr(whole_turn, "installed", lambda _: False)
    assert unusable(e62) == "it needs numba (extra study)"
    monkeypatch.undo()

    def fails(*_: Any, **__: Any) -> Any:
        message = "a dead centre"
        raise SimulationError(message)

    monkeypatch.setattr(whole_turn, "turn_quantities", fails)
    assert unusable(e62) == "a dead centre"
    assert read(turn_rows(e62, controls, asked(controls)))["turn"] == "not followed: a dead centre"


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
