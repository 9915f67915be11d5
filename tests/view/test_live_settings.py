"""The live page: what it is built of, what it says of a setting, and its sliders and fields.

Words of the page are reviewed texts of real pages; its numbers are compared with runs of the
model's file in test_surfaces.py.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from judge import press
from snapshots import Words

from nipper_pin import Case, InputError, Mechanism, Window, load, simulate
from nipper_pin.view.live import answer as answers
from nipper_pin.view.live.answer import Answer, answer
from nipper_pin.view.live.panel.fields import refusal, refusal_html, typed
from nipper_pin.view.live.panel.memory import ONE_CHANGE, Memory
from nipper_pin.view.live.panel.numbers import Number, difference
from nipper_pin.view.live.panel.text import as_html
from nipper_pin.view.live.settings import Knob, knobs


def asked(mechanism: Mechanism, **values: float) -> Answer:
    """The answer to sliders at their starts, but for some."""
    controls = knobs(mechanism, 650.0)
    stand = {item.key: item.start for item in controls}
    assert set(values) <= {key.rpartition(".")[2] for key in stand}
    return answer(mechanism, controls, {key: values.get(key.rpartition(".")[2], start)
                                        for key, start in stand.items()})  # fmt: skip


# What the page says.

BACKWARDS = {"cylinder.direction": "counter-clockwise"}
SETTINGS: dict[str, Callable[[], Answer]] = {
    "usual": lambda: asked(load("e62")),
    "no turn has it": lambda: asked(load("e62"), speed=800.0, restitution=0.4),
    # The steeve reaches its stop in this one, which the sentence tells.
    "no rest": lambda: asked(load("e62"), speed=900.0, restitution=0.7),
    "no rebound": lambda: asked(load("e62"), restitution=0.0),
    "no run": lambda: asked(load("e62", BACKWARDS)),
    "press": lambda: asked(press()),
}


def lines(html: str) -> str:
    """Texts of the page, a line for each element that is one, with its id, key or role."""
    words = re.sub(r"direct, [\d.]+ ms", "direct, # ms", html)
    found = []
    for tag, text in re.findall(r"<([^>]*)>([^<]*)", words):
        name = " ".join(re.findall(r'(?:id|data-key|data-difference|role|class)="([^"]*)"', tag))
        if name or text.strip():
            found.append(f"{tag.split()[0]}{f' {name}' if name else ''}: {text}".rstrip(": "))
    return "\n".join(found) + "\n"


@pytest.mark.parametrize("name", SETTINGS)
def test_words_of_a_setting(name: str, words: Words) -> None:
    """Numbers with their units, or the reason why there are none, below the setting."""
    found = SETTINGS[name]()
    assert (found.solution is None) == bool(found.message)
    assert bool(found.rows) is not bool(found.message)
    words(lines(as_html(found)))


def test_words_of_a_change(e62: Mechanism, words: Words) -> None:
    """Beside the setting before or the pinned one, and with numbers of the whole turn below."""
    usual = asked(e62)
    memory = Memory()
    memory.take(0.0, usual, ())
    memory.pin()
    memory.end_change()
    memory.take(1.0, asked(e62, speed=700.0), ())
    turn = (Number("closing", "index <of> touch", "34.05"),)
    texts = []
    for found in (asked(e62, speed=680.0), asked(e62, speed=900.0, restitution=0.7)):
        for pinned in (False, True):
            texts.append(lines(as_html(found, turn, memory.other, pinned=pinned)))
    words("\n".join(texts))


def test_without_restitution_the_jaw_is_shut(e62: Mechanism) -> None:
    found = asked(e62, restitution=0.0)
    assert len(found.impulse) == 1
    assert not found.gap.any()
    assert found.force[-1] > 50.0


def test_names_cannot_become_part_of_the_page(e62: Mechanism) -> None:
    controls = knobs(e62, 650.0)
    knob = replace(controls[0], name="<script>alert(1)</script>")
    found = answer(e62, (knob, *controls[1:]), {item.key: item.start for item in controls})
    assert "<script>" not in as_html(found)


def test_the_force_behind_the_rest_is_that_of_a_whole_turn(e62: Mechanism) -> None:
    """A turn from its start arrives at the same rest and goes on; its forces are other lines."""
    found = asked(e62)
    turn = simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))
    touch = next(hit.t for hit in turn.collisions if hit.stop == "jaw")
    shut = found.force_time >= 1e3 * simulate(e62, Case(speed_rpm=650.0)).transitions[0].duration
    assert shut.sum() == 9
    times = touch + 1e-3 * found.force_time[shut]
    wanted = turn.trajectory.reactions(times).contacts["jaw"]
    np.testing.assert_allclose(found.force[shut], wanted, rtol=1e-9)
    assert not found.force[~shut].any()
    assert found.force_time[-1] - found.force_time[shut][0] == pytest.approx(6e4 / 650.0 / 40.0)


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
    """A line for each slider."""
    return "".join(
        f"{item.key}: {item.label}, {item.low:g} to {item.high:g} by {item.step:g}, starts at "
        f"{item.start:g}; times {item.factor:.6g} in SI\n" for item in controls
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


def test_sliders_need_the_transition_stop(e62: Mechanism) -> None:
    """It is enough alone, and no other stop stands in for it."""
    jaw, steeve = (e62.stop(name) for name in ("jaw", "steeve"))
    assert knobs(replace(e62, stops=(jaw,)), 650.0)
    with pytest.raises(InputError, match="no transition stop"):
        knobs(replace(e62, stops=(steeve,)), 650.0)


def solved(found: Answer) -> Mechanism:
    assert found.solution is not None
    return found.solution.mechanism


def test_sliders_set_what_they_name(e62: Mechanism) -> None:
    """At their starts they mean the model; each spring is set by its own."""
    same = solved(asked(e62))
    assert same.stops == e62.stops
    for one, other in zip(same.springs, e62.springs, strict=True):
        # Units are converted forth and back: two roundings.
        assert one.stiffness == pytest.approx(other.stiffness, rel=4e-16)
        assert one.preload == pytest.approx(other.preload, rel=4e-16)
    spring = e62.springs[0]
    two = replace(e62, springs=(spring, replace(spring, name="other")))
    made = solved(answer(two, knobs(two, 650.0), {
        "speed": 650.0, "restitution": 0.31, "steeve.stiffness": 5.0, "steeve.preload": 6.0,
        "other.stiffness": 7.0, "other.preload": 8.0,
    }))  # fmt: skip
    for item, wanted in zip(made.springs, (("steeve", 5e3, 6e-3), ("other", 7e3, 8e-3)),
                            strict=True):  # fmt: skip
        assert item.name == wanted[0]
        assert (item.stiffness, item.preload) == pytest.approx(wanted[1:], rel=4e-16)
    known = {stop.name: stop.restitution for stop in e62.stops}
    assert {stop.name: stop.restitution for stop in made.stops} == {**known, "jaw": 0.31}


SPEED = Knob(key="speed", name="speed", unit="r/min", factor=1.0, low=60.0, high=2000.0, step=5.0,
             start=650.0)  # fmt: skip


@pytest.mark.parametrize(("text", "value"), [
    ("650", 650.0), (" 650.5 ", 650.5), ("1,200", 1200.0), ("+60", 60.0), ("2e3", 2000.0),
    (".5e3", 500.0), ("700.", 700.0), ("59.99", None), ("2000.1", None), ("-650", None),
    ("", None), (" ", None), ("abc", None), ("6 50", None), ("650,5", None), ("1,2,3", None),
    ("nan", None), ("inf", None), ("1e999", None), ("0x400", None), ("6_5_0", None), ("٦٥٠", None),
])  # fmt: skip
def test_a_text_is_a_number_in_its_range_or_is_refused(text: str, value: float | None) -> None:
    assert typed(SPEED, text) == value


@pytest.mark.parametrize(("text", "reason"), [
    ("3000", "3000 is too large"), ("7", "7 is too small"), ("abc", "“abc” is no number"),
    ("", "the field is empty"), ("650,5", "“650,5”: decimals follow a point"),
])  # fmt: skip
def test_a_refusal_says_the_range_the_reason_and_what_is_shown(text: str, reason: str) -> None:
    wanted = f"speed: 60 to 2,000 r/min. Refused: {reason}. Shown: 650 r/min."
    assert refusal(SPEED, text, 650.0) == wanted
    assert "<b>" not in refusal_html(refusal(SPEED, "<b>", 650.0))


def test_differences_are_per_cent_or_indices() -> None:
    def of(value: float | None, *, on_scale: bool = False) -> Number:
        return Number("key", "label", "text", value, on_scale)

    assert difference(of(103.25), of(100.0)) == "+3.2 %"
    assert difference(of(-99.0), of(-100.0)) == "-1.0 %"
    assert difference(of(100.01), of(100.0)) == "0.0 %"
    assert difference(of(0.0), of(0.0)) == "0.0 %"
    assert difference(of(39.9, on_scale=True), of(0.2, on_scale=True)) == "-0.300"
    for now, other in ((1.0, 0.0), (None, 1.0), (1.0, None), (float("nan"), 1.0)):
        assert difference(of(now), of(other)) == ""
    assert difference(of(1.0), None) == ""


def test_the_setting_before_is_the_one_before_a_change_however_long(e62: Mechanism) -> None:
    """Moves that follow each other are one change; a setting without numbers is none before."""
    answers = [asked(e62, speed=speed) for speed in (650.0, 660.0, 670.0)]
    endless = asked(e62, speed=900.0, restitution=0.7)
    memory, gap = Memory(), 2.0 * ONE_CHANGE
    for now, found in ((0.0, answers[0]), (gap, answers[1]), (gap + 0.1, answers[2])):
        memory.take(now, found, ())
    assert memory.before is not None
    assert memory.before.answer is answers[0]
    memory.take(3.0 * gap, endless, ())
    memory.pin()
    assert memory.pinned is None
    memory.take(4.0 * gap, answers[0], ())
    assert memory.before.answer is answers[2]
    memory.pin()
    memory.take(5.0 * gap, answers[1], ())
    assert memory.other is memory.pinned is not None
    assert memory.pinned.answer is answers[0]
    memory.pin()
    assert memory.other is memory.before
    memory.end_change()
    memory.take(5.0 * gap + 0.1, answers[2], ())
    assert memory.before.answer is answers[1]
