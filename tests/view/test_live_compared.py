"""What the live page compares: fields that refuse, steady axes, ghost and pinned curves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from nipper_pin import Case, Mechanism, Window, load, simulate
from nipper_pin.view.live.answer import answer
from nipper_pin.view.live.curves.axes import SteadyAxis, SteadyDecades, round_above
from nipper_pin.view.live.panel.fields import refusal, refusal_html, typed
from nipper_pin.view.live.panel.memory import ONE_CHANGE, Memory
from nipper_pin.view.live.panel.numbers import Number, difference
from nipper_pin.view.live.settings import Knob, knobs

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


def test_axes_grow_in_round_steps_and_shrink_only_when_asked() -> None:
    assert [round_above(value) for value in (0.011, 1.0, 3.1, 6.0, 8.5, 301.0)] == [
        0.015, 1.0, 4.0, 6.0, 10.0, 400.0
    ]  # fmt: skip
    axis, tops = SteadyAxis(), []
    for needed in (301.0, 310.0, 250.0, 401.0, 10.0):
        axis.hold(needed)
        tops.append(axis.top)
    assert tops == [400.0, 400.0, 400.0, 500.0, 500.0]
    axis.forget()
    axis.hold(10.0)
    assert axis.top == 15.0
    decades = SteadyDecades()
    for values, ends in (([0.9, 4e-4], (1e-4, 1.0)), ([1.1], (1e-4, 10.0)), ([0.5], (1e-4, 10.0))):
        decades.hold(values)
        assert decades.ends == pytest.approx(ends, rel=1e-12)
    decades.forget()
    decades.hold([0.5])
    assert decades.ends == pytest.approx((0.1, 1.0), rel=1e-12)


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


def test_percentages_are_those_of_two_runs(e62: Mechanism) -> None:
    """Two runs of their own, each with overrides of the model's file."""
    controls = knobs(e62, 650.0)
    start = {item.key: item.start for item in controls}
    other = {item.key: item for item in answer(e62, controls, start).rows}
    rows = answer(e62, controls, {**start, "speed": 700.0, "steeve.stiffness": 8.0}).rows
    found = {item.key: difference(item, other[item.key]) for item in rows}
    one = simulate(load("e62"), Case(speed_rpm=650.0))
    soft = load("e62", {"springs.steeve.stiffness_N_per_m": 8e3})
    two = simulate(soft, Case(speed_rpm=700.0))
    for key, before, now in (
        ("amplitude", one.collisions[0].rebound_amplitude, two.collisions[0].rebound_amplitude),
        ("duration", one.transitions[0].duration, two.transitions[0].duration),
        ("impulse", one.collisions[0].impulse, two.collisions[0].impulse),
        ("share", one.transitions[0].first_two_share, two.transitions[0].first_two_share),
    ):
        assert float(found[key].removesuffix(" %")) == pytest.approx(
            100.0 * (now - before) / before, abs=0.051
        ), key


def test_the_force_behind_the_rest_is_that_of_a_whole_turn(e62: Mechanism) -> None:
    """A turn from its start arrives at the same rest and goes on; its forces are other lines."""
    controls = knobs(e62, 650.0)
    found = answer(e62, controls, {item.key: item.start for item in controls})
    turn = simulate(e62, Case(speed_rpm=650.0, window=Window.CYCLE))
    touch = next(hit.t for hit in turn.collisions if hit.stop == "jaw")
    shut = found.force_time >= 1e3 * simulate(e62, Case(speed_rpm=650.0)).transitions[0].duration
    assert shut.sum() == 9
    times = touch + 1e-3 * found.force_time[shut]
    wanted = turn.trajectory.reactions(times).contacts["jaw"]
    np.testing.assert_allclose(found.force[shut], wanted, rtol=1e-9)
    assert not found.force[~shut].any()
    assert found.force_time[-1] - found.force_time[shut][0] == pytest.approx(6e4 / 650.0 / 40.0)


def test_the_setting_before_is_the_one_before_a_change_however_long(e62: Mechanism) -> None:
    """Moves that follow each other are one change; a setting without numbers is none before."""
    controls = knobs(e62, 650.0)
    start = {item.key: item.start for item in controls}
    answers = [answer(e62, controls, {**start, "speed": speed}) for speed in (650.0, 660.0, 670.0)]
    endless = answer(e62, controls, {**start, "speed": 900.0, "restitution": 0.7})
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


@pytest.fixture
def page(e62: Mechanism) -> Iterator[Any]:
    viser = pytest.importorskip("viser", reason="viser is not installed (extra `live`)")
    from nipper_pin.view.live.page import Page

    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield Page(server, e62, knobs(e62, 650.0))
    server.stop()


def test_slider_and_field_go_together_and_a_refused_text_changes_nothing(page: Any) -> None:
    controls, before = page._set, page._answer
    field, slider, said = (
        part["speed"] for part in (controls.fields, controls.sliders, controls.refusals)
    )
    slider.value = 700.0
    assert field.value == "700"
    field.value = "720.5"
    assert (slider.value, said.content) == (720.5, "")
    page._answer = page._follow()
    assert page._answer.setting.startswith("speed 720.5 r/min")
    assert page._answer is not before
    shown = page._answer
    field.value = "99999"
    assert "speed: 180 to 900 r/min" in said.content
    assert "Shown: 720.5 r/min" in said.content
    assert slider.value == 720.5
    assert page._follow() is shown
    page._press("reset")
    page._act()
    page._answer = page._follow()
    assert (field.value, slider.value, said.content) == ("650", 650.0, "")
    assert page._answer.setting == before.setting


def test_ghost_and_pinned_curves_have_rows_of_their_own(page: Any, e62: Mechanism) -> None:
    """Pinned, before, now; each is the line of its own run, between whose times it is straight."""
    first = page._answer
    plots = page._plots
    assert np.isnan(plots.gap.data[1]).all()
    assert np.isnan(plots.gap.data[2]).all()
    page._press("pin this curve")
    page._act()
    assert page._set.buttons.options[1] == "unpin"
    for speed in (700.0, 720.0):
        page._memory.end_change()
        page._set.sliders["speed"].value = speed
        page._answer = page._follow()
    x, pinned, before, now, lips = plots.gap.data
    for row, speed in ((pinned, 650.0), (before, 700.0), (now, 720.0)):
        run = simulate(e62, Case(speed_rpm=speed))
        wanted = 1e3 * np.degrees(run.collisions[0].rebound_amplitude)
        assert np.nanmax(row) == pytest.approx(wanted, rel=1e-3)
    np.testing.assert_array_equal(pinned[np.isin(x, first.time)], first.gap)
    lever = e62.stop("jaw").contact.lever_m
    np.testing.assert_allclose(lips, lever * np.radians(now), rtol=1e-12)
    legend = plots.legend.content
    assert "before: speed 700 r/min" in legend
    assert "pinned: speed 650 r/min" in legend
    ends = plots.gap.scales, plots.force.scales, plots.impulse.scales
    page._set.sliders["speed"].value = 715.0
    page._follow()
    assert (plots.gap.scales, plots.force.scales, plots.impulse.scales) == ends
    page._press("unpin")
    page._act()
    page._follow()
    assert np.isnan(plots.gap.data[1]).all()
    assert "pinned" not in plots.legend.content
