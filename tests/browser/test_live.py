"""The live page in a real browser: a slider moves, and everything follows it."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from playing_page import apart, picture, seek, until, watch
from playwright.sync_api import Browser, Page, ViewportSize

from nipper_pin import Case, Solution, load, simulate

pytestmark = [
    pytest.mark.skipif(find_spec("tornado") is None, reason="tornado is missing (extra `live`)"),
    pytest.mark.slow,
]

START = "speed 650 r/min, restitution of the jaw 0.2, stiffness 9 N/mm, preload 11 mm"
KEYS = ("speed", "restitution", "steeve.stiffness", "steeve.preload")
PINNED, BEFORE, NOW = "#E69F00", "#A6CDE6", "#0072B2"
SIZE: ViewportSize = {"width": 900, "height": 700}


@pytest.fixture(scope="module")
def address(serving) -> Iterator[str]:
    with serving("live", "--speed", "650") as place:
        yield place


@pytest.fixture(scope="module")
def window(chromium: Browser, address: str) -> Iterator[Page]:
    """The page, opened once; what it complains of or asks for fails the last test."""
    opened = chromium.new_page(viewport=SIZE)
    found = watch(opened)
    opened.goto(address)
    until(opened, "state.turn.length > 1")
    yield opened
    opened.close()
    assert found.complaints == []
    # Its own server, and what the page makes of itself: no other place in the network.
    own = (address, f"blob:{address}", "data:")
    assert [item for item in found.requests if not item.startswith(own)] == []


@pytest.fixture
def page(window: Page) -> Page:
    """Sliders at their starts, nothing pinned, whatever the test before has left.

    The film stands: a processor that draws does nothing else.
    """
    window.set_viewport_size(SIZE)
    window.evaluate("() => { animator.pause(); playOn = false; }")
    if window.inner_text("#pin") == "unpin":
        window.click("#pin")
    window.click("#reset")
    until(window, f"state.setting === '{START}' && !state.pinned && queue.length === 0 && !busy")
    return window


def field(page: Page, key: str) -> Any:
    return page.locator(".control input[type=text]").nth(KEYS.index(key))


def enter(page: Page, key: str, value: str) -> None:
    """Write a number into the field beside a slider, and wait for its answer."""
    field(page, key).fill(value)
    until(page, f"state.controls['{key}'].value === {float(value)} && !busy")


def press(page: Page, key: str, arrow: str, times: int) -> None:
    page.locator(".control input[type=range]").nth(KEYS.index(key)).focus()
    for _ in range(times):
        page.keyboard.press(arrow)


def number(page: Page, key: str) -> float:
    return float(page.locator(f"[data-key={key}]").inner_text())


def line(page: Page, place: int, colour: str = NOW) -> np.ndarray:
    """Times [ms] and values of a curve that is drawn."""
    lines = f"[film.curves[{place}], ...film.curves[{place}].more]"
    found = f"{lines}.find(item => item.colour === '{colour}')"
    return np.array(page.evaluate(f"[{found}.at, {found}.values]"))


def run(speed: float, restitution: float, stiffness: float, preload: float) -> Solution:
    mechanism = load(
        "e62",
        {
            "stops.jaw.restitution": restitution,
            "springs.steeve.stiffness_N_per_m": 1e3 * stiffness,
            "springs.steeve.preload_length_mm": preload,
        },
    )
    return simulate(mechanism, Case(speed_rpm=speed))


def check(page: Page, wanted: Solution) -> None:
    """Numbers and curves of the page are those of a run, to their four and six digits."""
    first = wanted.collisions[0]
    amplitude = 1e3 * np.degrees(first.rebound_amplitude)
    assert number(page, "amplitude") == pytest.approx(amplitude, rel=6e-4)
    gap, impulse = line(page, 0), line(page, 2)
    assert gap[1].max() == pytest.approx(amplitude, rel=1e-3)
    np.testing.assert_allclose(impulse[1], [hit.impulse for hit in wanted.collisions], rtol=6e-6)
    times = [1e3 * (item.t - first.t) for item in wanted.collisions]
    np.testing.assert_allclose(impulse[0], times, rtol=6e-6)


def follow(page: Page, setting: str) -> None:
    until(page, f"byId('setting').textContent === '{setting}' && !busy")


def test_numbers_and_curves_follow_every_slider(page: Page) -> None:
    """Each slider by its keys."""
    check(page, run(650.0, 0.2, 9.0, 11.0))
    for key, arrow, times in (
        ("speed", "ArrowRight", 6), ("restitution", "ArrowLeft", 5),
        ("steeve.stiffness", "ArrowRight", 10), ("steeve.preload", "ArrowLeft", 5),
    ):  # fmt: skip
        press(page, key, arrow, times)
    follow(page, "speed 680 r/min, restitution of the jaw 0.15, stiffness 10 N/mm, preload 10 mm")
    check(page, run(680.0, 0.15, 10.0, 10.0))
    values = [field(page, key).input_value() for key in KEYS]
    assert values == ["680", "0.15", "10", "10"]


def test_a_setting_without_rest_shows_its_reason_instead_of_numbers(page: Page) -> None:
    """The machine stands in the touch configuration, and no number is that of another setting.

    The whole turn, in which the jaw throws on, has numbers.
    """
    turn = page.locator("#turn [data-key=turn_engine]")
    assert turn.inner_text().startswith("reduced, ")
    before = number(page, "rest")
    seek(page, 3.0)
    enter(page, "restitution", "0.7")
    assert "did not come to rest" in page.inner_text("#message")
    assert page.locator("#rows tr").count() == 0
    assert page.locator("#turn [data-key=rest]").inner_text() != f"{before:.3f}"
    assert not page.is_visible("#curves canvas")
    assert not page.is_visible("#numbers")
    assert page.evaluate("animator.time") == 0.0
    until(page, "byId('phase').textContent.startsWith('there is no motion to show')")
    enter(page, "restitution", "0.2")
    assert page.inner_text("#message") == ""
    assert page.is_visible("#curves canvas")
    check(page, run(650.0, 0.2, 9.0, 11.0))


def test_the_film_is_that_of_the_setting_and_plays_on(page: Page) -> None:
    """It stands while something is moved, then plays on; time and pace are kept."""
    page.click("#play")
    enter(page, "speed", "700")
    assert not page.evaluate("animator.playing")
    until(page, "film.case.startsWith('700')")
    until(page, "animator.playing")
    page.click("#play")
    seek(page, 4.0)
    page.select_option("#pace", "0.5")
    enter(page, "speed", "690")
    until(page, "film.case.startsWith('690')")
    assert page.evaluate("[animator.time, animator.mixer.timeScale]") == [4.0, 0.5]
    page.select_option("#pace", "1")


def test_the_picture_shows_the_machine_larger_rebounds_and_both_lips(page: Page) -> None:
    """Colours that no background has; drawn less large the jaw is elsewhere, and so is its lip."""
    first = run(650.0, 0.2, 9.0, 11.0).collisions[0]
    images = []
    for larger in (10.0, 2.0):
        page.locator(".control input[type=text]").nth(4).fill(f"{larger:g}")
        until(page, f"film.exaggerate === {larger}")
        seek(page, 500.0 * first.rebound_time)
        assert page.inner_text("#lips figcaption").endswith(f"rebounds x {larger:g}")
        images.append((picture(page, "#pane"), picture(page, "#lips canvas")))
    (whole, lips), (less, less_lips) = images
    assert (whole.max(axis=-1) - whole.min(axis=-1) > 60.0).mean() > 0.02
    assert (np.abs(whole - less).max(axis=-1) > 30.0).mean() > 1e-3
    assert (np.abs(lips - less_lips).max(axis=-1) > 30.0).mean() > 0.05


def test_a_bad_number_is_refused_and_nothing_else_changes(page: Page) -> None:
    refused = page.locator(".refused").first
    field(page, "speed").fill("3000")
    until(page, "document.querySelector('.refused').textContent !== ''")
    assert refused.inner_text() == (
        "speed: 180 to 900 r/min. Refused: 3000 is too large. Shown: 650 r/min."
    )
    assert page.inner_text("#setting") == START
    check(page, run(650.0, 0.2, 9.0, 11.0))
    style = "element => getComputedStyle(element).textDecorationLine"
    assert field(page, "speed").evaluate(style) == "line-through"
    assert field(page, "steeve.stiffness").evaluate(style) == "none"
    # Still there after leaving the field: nothing is replaced in silence.
    enter(page, "restitution", "0.21")
    assert field(page, "speed").input_value() == "3000"
    enter(page, "speed", "720")
    assert not refused.is_visible()
    field(page, "speed").fill("3000")
    until(page, "document.querySelector('.refused').textContent !== ''")
    page.click("#reset")
    follow(page, START)
    assert [field(page, key).input_value() for key in KEYS] == ["650", "0.2", "9", "11"]
    assert not refused.is_visible()


def seen(page: Page, colour: str) -> int:
    """Pixels of a colour in the curves."""
    wanted = np.array(list(bytes.fromhex(colour[1:])), dtype=float)
    return int((np.abs(picture(page, "#curves canvas") - wanted).max(axis=-1) < 12.0).sum())


def test_ghost_and_pinned_curve_are_seen_and_the_pinned_one_stays(page: Page) -> None:
    """By their colours and the legend; numbers are compared with the pinned setting, or before."""
    page.click("#pin")
    until(page, "state.pinned")
    for speed in ("700", "740"):
        page.wait_for_timeout(900)
        enter(page, "speed", speed)
    assert min(seen(page, colour) for colour in (NOW, BEFORE, PINNED)) > 100
    assert page.inner_text("[data-curve=pinned]") == "pinned: speed 650 r/min"
    assert page.inner_text("[data-curve=before]") == "before: speed 700 r/min"
    assert "the pinned setting (speed 650 r/min)" in page.inner_text("#against")
    assert page.inner_text("[data-difference=impulse]").endswith(" %")
    page.click("#pin")
    until(page, "!state.pinned")
    assert seen(page, PINNED) == 0
    assert seen(page, BEFORE) > 100
    assert page.locator("[data-curve=pinned]").count() == 0
    assert "the setting before (speed 700 r/min)" in page.inner_text("#against")


USEFUL = ("#pane", "#panel", "aside", "#bar", "#line", "#curves", "#note")


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (1024, 768), (390, 800)])
def test_nothing_covers_anything_and_curves_are_in_sight(
    page: Page, width: int, height: int
) -> None:
    """Picture, controls, numbers and curves are apart, and within the width of the window."""
    page.set_viewport_size({"width": width, "height": height})
    boxes = apart(page, *USEFUL)
    assert width < 700 or all(one["y"] + one["height"] <= height + 0.5 for one in boxes)
    assert boxes[0]["width"] * boxes[0]["height"] > 0.2 * width * height
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    # Of all controls and numbers, nothing is cut off to the right.
    assert page.evaluate("[panel, aside].every(item => item.scrollWidth <= item.clientWidth)")


def test_another_browser_has_its_own_setting_and_learns_of_the_end(
    page: Page, chromium: Browser, serving
) -> None:
    """A second page changes nothing of the first; one whose program has ended says so."""
    with serving("live", "--speed", "650") as address:
        other = chromium.new_page(viewport=SIZE)
        other.goto(address)
        until(other, "talk.readyState === 1")
        other.evaluate("animator.pause()")
        enter(other, "speed", "500")
        assert page.inner_text("#setting") == START
    until(other, "byId('message').textContent.includes('has ended')")
    other.close()
