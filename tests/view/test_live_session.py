"""The live page as a browser gets it: its panel, what it takes, and what it answers."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from judge import press
from page_words import film_of
from snapshots import Words
from three_js import Scene

pytest.importorskip("meshcat", reason="meshcat is not installed (extra `live`)")

from nipper_pin import Case, InputError, Mechanism, load, simulate
from nipper_pin.view.live import session as sessions
from nipper_pin.view.live.curves import BEFORE, NOW, PINNED
from nipper_pin.view.live.session import Session, Shown, shown_live

Json = dict[str, Any]


class Clock:
    """Seconds that pass when they are told to."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture(scope="module")
def served(e62: Mechanism) -> tuple[Shown, str]:
    return shown_live(e62, 650.0)


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def session(served: tuple[Shown, str], clock: Clock) -> Session:
    return Session(served[0], clock)


def slide(session: Session, key: str, value: float) -> Json:
    assert session.take(json.dumps({"kind": "slid", "key": key, "value": value}))
    return session.state()


def write(session: Session, key: str, text: str) -> Json:
    assert session.take(json.dumps({"kind": "typed", "key": key, "text": text}))
    return session.state()


def push(session: Session, button: str) -> Json:
    assert session.take(json.dumps({"kind": "pressed", "button": button}))
    return session.state()


def run(e62: Mechanism, speed: float) -> Any:
    return simulate(e62, Case(speed_rpm=speed))


# What it says.


def told(state: Json) -> Iterator[str]:
    """A line for each part of an answer, of curves their lanes."""
    for key, value in state.items():
        if key == "axes":
            yield f"time to {value['until']:g} s, {len(value['ticks'])} marks"
            for lane in value["curves"]:
                head = {item: lane[item] for item in lane if item not in ("at", "values", "more")}
                yield f"lane {head}, and {[item['colour'] for item in lane['more']]}"
        elif isinstance(value, list):
            yield from (f"{key}: {item}" for item in value)
        elif isinstance(value, dict):
            yield from (f"{key} {name}: {item}" for name, item in value.items())
        else:
            yield f"{key}: {value}"


def lines(*parts: str) -> str:
    return re.sub(r"direct, [\d.]+ ms", "direct, # ms", "\n".join(parts)) + "\n"


@pytest.mark.parametrize("name", ["e62", "hanging_pendulum"])
def test_words_of_the_page(name: str, words: Words) -> None:
    """Sliders with names and ranges, lanes with labels and units, and the note on estimates."""
    made = load(name)
    title = "an </script> <estimate> & co" if name == "e62" else "a machine"
    _, page = shown_live(replace(made, title=title), 650.0)
    film = film_of(page)
    assert "</script> <estimate>" not in page
    assert page.count("connect-src data: blob: 'self'\"") == 1
    controls = (f"control {item}" for item in film["live"]["controls"])
    text = (f"{key}: {film[key]}" for key in ("title", "case", "note", "exaggerate"))
    words(lines(*text, *controls, *told(film["live"]["state"])))


def test_words_of_a_change(session: Session, clock: Clock, words: Words) -> None:
    """Beside the setting before or the pinned one; also of a setting without a transition."""
    parts = []
    for asked in ({"speed": 680.0}, {"speed": 900.0, "restitution": 0.7}):
        push(session, "pin")
        clock.now += 1.0
        slide(session, "speed", 700.0)
        clock.now += 1.0
        for key, value in asked.items():
            slide(session, key, value)
        for _ in "with", "without":
            parts += [*told(session.state()), ""]
            push(session, "pin")
        push(session, "pin")
        push(session, "reset")
    words(lines(*parts))


def test_the_film_says_gaps_in_the_units_of_rebounds(session: Session, e62: Mechanism) -> None:
    """In each frame, by the motion of a run; every millisecond of the machine is a second."""
    slide(session, "speed", 700.0)
    found: Any = session.film()
    film = found["film"]
    assert session.film() is None
    wanted = run(e62, 700.0)
    columns = {item["label"]: (np.array(item["values"]), item["unit"]) for item in film["columns"]}
    t, unit = columns["time"]
    assert unit == "ms"
    np.testing.assert_allclose(film["playback"], t, rtol=1e-5)
    inside = t <= 1e3 * wanted.segments[-1].t_end
    gap = e62.stop("jaw").gaps(wanted.trajectory.evaluate(1e-3 * t[inside]).q)
    mdeg, lips = columns["jaw angle"], columns["jaw gap at the contact"]
    assert (mdeg[1], lips[1]) == ("mdeg", "mm")
    # Six digits of the time at the largest rate, and six of the gap.
    near = {"rtol": 6e-6, "atol": 2e-5 * gap.max()}
    np.testing.assert_allclose(np.radians(1e-3 * mdeg[0][inside]), gap, **near)
    np.testing.assert_allclose(1e-3 * lips[0][inside], e62.stop("jaw").lever * gap, **near)
    # It goes on one index beyond the rest, in which the jaw is pressed shut.
    rest = 1e3 * wanted.transitions[0].duration
    assert t[-1] - rest == pytest.approx(6e4 / 700.0 / 40.0, rel=1e-4)
    force = columns["jaw clamping force"][0]
    np.testing.assert_array_equal(force > 0.0, t >= rest * (1.0 - 1e-5))


def opened(message: str, at: float) -> float:
    """How far the jaw is drawn open [rad]: the angle between its links."""
    scene = Scene(f'<script id="scene">{json.dumps([message])}</script>')
    lower, upper = (
        scene.matrix(f"/nipper/{name}_nipper", at)[:3, :3] for name in ("bottom", "top")
    )
    between = lower.T @ upper
    return abs(math.atan2(between[0, 2], between[0, 0]))


def test_the_gap_is_drawn_larger(
    session: Session, e62: Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As the slider says; where the loops cannot follow, the page says so and draws it as it is."""
    wanted = run(e62, 650.0)
    first = wanted.collisions[0]
    top = first.t + 0.5 * first.rebound_time
    gap = float(e62.stop("jaw").gaps(wanted.trajectory.evaluate(top).q)[0])
    # Between frames it is drawn along a line.
    for larger in (1.0, 4.0, 50.0):
        slide(session, "larger", larger)
        found: Any = session.film()
        drawn = opened(found["scene"], 1e3 * top)
        most = math.radians(6.0) / first.rebound_amplitude
        assert drawn == pytest.approx(gap * min(larger, most), rel=1e-3)
        assert ("drawn" in found["film"]["note"]) is (larger > 1.0)
    real = sessions.film

    def refuse(solution: Any, look: Any, frames: Any) -> Any:
        if look.exaggerate > 1.0:
            message = "it is too large"
            raise InputError(message)
        return real(solution, look, frames)

    monkeypatch.setattr(sessions, "film", refuse)
    slide(session, "larger", 40.0)
    found = session.film()
    assert found["film"]["note"].endswith(" it is too large")
    assert opened(found["scene"], 1e3 * top) == pytest.approx(gap, rel=1e-3)


def test_a_page_may_begin_with_a_setting_that_has_no_transition() -> None:
    """The machine stands in the touch configuration, and the page says why it does not move."""
    mechanism = load("e62", {"restitution": 0.8})
    shown, page = shown_live(mechanism, 900.0)
    assert "did not come to rest" in film_of(page)["live"]["state"]["message"]
    session = Session(shown)
    assert session.film() is None
    assert write(session, "restitution", "0.1")["message"] == ""
    assert session.film() is not None
    # Where there is none at any setting there is nothing to follow.
    with pytest.raises(InputError, match="stands open by 8 deg in the touch configuration"):
        shown_live(press(), 30.0)


# Curves.


def lane(state: Json, place: int) -> dict[str, np.ndarray]:
    """Times [ms] and values of each line, by its colour."""
    curve = state["axes"]["curves"][place]
    return {item["colour"]: np.array([item["at"], item["values"]])
            for item in (curve, *curve["more"])}  # fmt: skip


def test_ghost_and_pinned_curve(session: Session, e62: Mechanism, clock: Clock) -> None:
    """The pinned one is dashed and stays; the pale one is that of the setting before."""
    push(session, "pin")
    for speed in (700.0, 740.0):
        clock.now += 1.0
        # Moves that follow each other at once are one change.
        slide(session, "speed", speed - 5.0)
        state = slide(session, "speed", speed)
    curve = state["axes"]["curves"][0]
    dashes = {item["colour"]: item["dash"] for item in (curve, *curve["more"])}
    assert dashes == {PINNED: (6, 3), BEFORE: (), NOW: ()}
    for colour, speed in ((PINNED, 650.0), (BEFORE, 700.0), (NOW, 740.0)):
        wanted = run(e62, speed)
        (time, gap), hits = lane(state, 0)[colour], lane(state, 2)[colour]
        highest = 1e3 * np.degrees(wanted.collisions[0].rebound_amplitude)
        assert gap.max() == pytest.approx(highest, rel=1e-3)
        assert time[0] == 0.0
        times = [1e3 * (item.t - wanted.collisions[0].t) for item in wanted.collisions]
        np.testing.assert_allclose(hits[0], times, rtol=6e-6)
        np.testing.assert_allclose(hits[1], [hit.impulse for hit in wanted.collisions], rtol=6e-6)
    assert PINNED not in lane(push(session, "pin"), 0)


def ends(state: Json) -> tuple[Any, ...]:
    axes = state["axes"]
    return axes["until"], *(item["most"] for item in axes["curves"]), axes["curves"][2]["decades"]


def test_axes_stand_still_for_small_changes_and_fit_when_asked(session: Session) -> None:
    before = ends(session.state())
    assert ends(slide(session, "speed", 660.0)) == before
    grown = ends(slide(session, "speed", 880.0))
    assert all(new >= old for new, old in zip(grown[:3], before[:3], strict=True))
    assert grown[1] > before[1]
    assert ends(slide(session, "speed", 500.0)) == grown
    assert ends(push(session, "fit"))[1] < before[1]
    state = slide(session, "speed", 880.0)
    gap, lips = state["axes"]["curves"][0], load("e62").stop("jaw").lever
    told_mm = float(gap["right"].partition(" ")[0])
    assert told_mm == pytest.approx(lips * np.radians(gap["most"]), rel=6e-4)
    # Every value has its place.
    for curve in state["axes"]["curves"]:
        assert max(curve["values"]) <= curve["most"]
        assert max(curve["at"]) <= state["axes"]["until"]


# What it takes.


@pytest.mark.parametrize(("value", "shown"), [(450, 450.0), (1e9, 900.0), (-1e9, 180.0)])
def test_a_slider_stays_in_its_range(session: Session, value: float, shown: float) -> None:
    state = slide(session, "speed", value)
    assert state["controls"]["speed"] == {"value": shown, "text": f"{shown:g}", "refusal": ""}
    assert state["setting"].startswith(f"speed {shown:g} r/min")


@pytest.mark.parametrize(("text", "found"), [
    (" 650.5 ", 650.5), ("+180", 180.0), ("9e2", 900.0), (".5e3", 500.0), ("700.", 700.0),
    ("700 rpm", 700.0), ("11 r/s", 660.0), ("900.1", "900.1 is too large"),
    ("1e999", "1e999 is too large"), ("179.99", "179.99 is too small"),
    ("-650", "-650 is too small"), ("", "the field is empty"), (" ", "the field is empty"),
    *((text, f"“{text}” is not a number") for text in ("abc", "6 50", "6_5_0", "٦٥٠")),
    ("650mm", "“650mm” is not a number in r/min, or with a unit of that kind, which mm is not"),
    ("nan", "nan is no number"), ("inf", "inf is too large"),
    ("650,5", "“650,5” is not a number, with a decimal point: 650.5"),
])  # fmt: skip
def test_a_text_is_taken_or_refused_and_then_nothing_else_changes(
    session: Session, text: str, found: float | str
) -> None:
    """A refusal says the range, the reason, and what is shown; a button takes it back."""
    before = session.state()
    state = write(session, "speed", text)
    refused = isinstance(found, str)
    said = f"speed: 180 to 900 r/min. Refused: {found}. Shown: 650 r/min." if refused else ""
    wanted = {"value": 650.0 if refused else found, "text": text, "refusal": said}
    assert state["controls"]["speed"] == wanted
    if refused:
        assert {key for key in state if state[key] != before[key]} == {"controls"}
        assert session.film() is None
        assert push(session, "reset") == before


def message(**fields: object) -> str:
    return json.dumps(fields)


HOSTILE: list[str | bytes] = [
    "", "text", "[]", "1", "null", "{}", "[" * 60_000, b"\xff" * 9, b"\0", '{"kind": "slid"}',
    *(message(kind="slid", key=key, value=value) for key, value in (
        ("other", 1.0), (["speed"], 1.0), ("speed", "450"), ("speed", None), ("speed", True),
        ("speed", [450]), ("speed", {}), ("speed", math.nan), ("speed", math.inf),
        ("__class__", 1.0),
    )),
    '{"kind": "slid", "key": "speed", "value": 1e999}',
    message(kind="slid", key="speed", value=450, more=1), message(key="speed", value=450),
    message(kind="typed", key="speed", text=450), message(kind="typed", key="speed", text="6" * 41),
    message(kind="typed", key="other", text="450"), message(kind="typed", key="speed", value=450),
    message(kind="pressed", button="other"), message(kind="pressed", button=True),
    message(kind="pressed", button=["reset"]), message(kind="other", key="speed", value=450),
]  # fmt: skip


@pytest.mark.parametrize("raw", HOSTILE, ids=lambda raw: repr(raw[:60]))
def test_all_else_changes_nothing(session: Session, raw: str | bytes) -> None:
    slide(session, "speed", 700.0)
    before = session.state()
    assert not session.take(raw)
    assert session.state() == before


def test_each_browser_has_its_own_setting(served: tuple[Shown, str]) -> None:
    one, other = Session(served[0]), Session(served[0])
    slide(one, "speed", 700.0)
    push(one, "pin")
    for key in ("setting", "pinned", "controls", "legend", "axes"):
        assert other.state()[key] == Session(served[0]).state()[key]
