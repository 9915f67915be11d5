"""The live page in a real browser: a slider moves, and everything follows it."""

from __future__ import annotations

import io
import signal
import statistics
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Locator, Page

from nipper_pin import Case, Solution, Window, load, simulate

pytestmark = [
    pytest.mark.skipif(find_spec("viser") is None, reason="viser is not installed (extra `live`)"),
    pytest.mark.slow,
]

COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]
# three.js, inside of viser, says this of viser's own clock whenever a page is opened.
ALWAYS_SAID = "THREE.Clock: This module has been deprecated"
SPEED, RESTITUTION, STIFFNESS, PRELOAD = range(4)
# Times from the key to the new numbers in the page, as the page itself sees both.
STOPWATCH = """() => {
    window.delays = [];
    addEventListener('keydown', () => {
        const began = performance.now(), before = document.querySelector('#setting').textContent;
        const watch = new MutationObserver(() => {
            const now = document.querySelector('#setting');
            if (now && now.textContent !== before) {
                window.delays.push(performance.now() - began);
                watch.disconnect();
            }
        });
        watch.observe(document.body, {subtree: true, childList: true, characterData: true});
    }, true);
}"""


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    command = [*COMMAND, "live", "--speed", "650", "--port", "0", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        try:
            yield server.stdout.readline().split()[4]
        finally:
            server.send_signal(signal.SIGINT)
        assert server.wait(timeout=60) == 0


@pytest.fixture
def page(chromium: Browser, watch, address: str) -> Iterator[Page]:
    """The page, drawn, sliders at their starts; what it complains of or asks for fails the test."""
    opened = chromium.new_page(viewport={"width": 900, "height": 700})
    found = watch(opened)
    opened.goto(address)
    opened.wait_for_selector("canvas")
    opened.wait_for_selector("#setting")
    for place, start in ((SPEED, "650"), (RESTITUTION, "0.2"), (STIFFNESS, "9"), (PRELOAD, "11")):
        enter(opened, place, start)
    follow(opened, "speed 650 r/min, restitution of the jaw 0.2, stiffness 9 N/mm, preload 11 mm")
    yield opened
    opened.close()
    assert [item for item in found.complaints if not item.startswith(ALWAYS_SAID)] == []
    # Its own server, and what the page makes of itself: no other place in the network.
    own = (address, f"blob:{address}")
    assert [item for item in found.requests if not item.startswith(own)] == []


def slider(page: Page, place: int) -> Locator:
    return page.locator("[role=slider]").nth(place)


def enter(page: Page, place: int, value: str) -> None:
    """Write a number into the field beside a slider, and wait for its answer.

    viser sends at most one value in 50 ms, the last one, whichever slider it is of: two sliders
    moved in less would lose the first, which no hand can do.
    """
    field = page.locator("input[inputmode]").nth(place)
    field.fill(value)
    field.blur()
    page.wait_for_function(
        "([place, value]) => document.querySelector('#setting')?.textContent.split(', ')[place]"
        ".split(' ').includes(value)",
        arg=[place, value],
    )


def press(page: Page, place: int, key: str, times: int) -> None:
    slider(page, place).focus()
    for _ in range(times):
        page.keyboard.press(key)


def follow(page: Page, setting: str) -> None:
    """Wait until the page says that what it shows belongs to a setting."""
    page.wait_for_function(
        "wanted => document.querySelector('#setting')?.textContent === wanted", arg=setting
    )


def number(page: Page, key: str) -> float:
    return float(page.locator(f"[data-key={key}]").inner_text())


def line(page: Page, place: int) -> np.ndarray:
    """What a plot shows: rows x and y, from the chart itself."""
    return np.array(
        page.evaluate(
            "place => Object.values(window.__viserTestpoints.uplots)"
            ".map(item => item.chart).sort((a, b) => a.root.getBoundingClientRect().top"
            " - b.root.getBoundingClientRect().top)[place].data.map(row => Array.from(row))",
            place,
        )
    )


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
    """Numbers and plots of the page are those of a run, to their four digits."""
    first, whole = wanted.collisions[0], wanted.transitions[0]
    amplitude = np.degrees(first.rebound_amplitude)
    assert number(page, "amplitude") == pytest.approx(amplitude, rel=6e-4)
    assert number(page, "duration") == pytest.approx(1e3 * whole.duration, rel=6e-4)
    assert number(page, "impulse") == pytest.approx(first.impulse, rel=6e-4)
    assert number(page, "collisions") == whole.collisions
    gap, impulse = line(page, 0), line(page, 1)
    assert gap[1].max() == pytest.approx(amplitude, rel=1e-3)
    np.testing.assert_allclose(impulse[1], [item.impulse for item in wanted.collisions], rtol=1e-9)
    times = [1e3 * (item.t - first.t) for item in wanted.collisions]
    np.testing.assert_allclose(impulse[0], times, rtol=1e-9, atol=1e-12)


def picture(page: Page) -> np.ndarray:
    """What stands left of the panel and below the messages of the viewer."""
    image = page.screenshot(clip={"x": 0, "y": 160, "width": 480, "height": 540})
    return np.asarray(Image.open(io.BytesIO(image)).convert("RGB"), dtype=float)


def test_numbers_and_plots_follow_every_slider(page: Page) -> None:
    """Each slider by its keys; each changes the numbers by far more than their four digits."""
    check(page, run(650.0, 0.2, 9.0, 11.0))
    press(page, SPEED, "ArrowRight", 6)
    follow(page, "speed 680 r/min, restitution of the jaw 0.2, stiffness 9 N/mm, preload 11 mm")
    check(page, run(680.0, 0.2, 9.0, 11.0))
    press(page, RESTITUTION, "ArrowLeft", 5)
    follow(page, "speed 680 r/min, restitution of the jaw 0.15, stiffness 9 N/mm, preload 11 mm")
    check(page, run(680.0, 0.15, 9.0, 11.0))
    press(page, STIFFNESS, "ArrowRight", 10)
    follow(page, "speed 680 r/min, restitution of the jaw 0.15, stiffness 10 N/mm, preload 11 mm")
    check(page, run(680.0, 0.15, 10.0, 11.0))
    press(page, PRELOAD, "ArrowLeft", 5)
    follow(page, "speed 680 r/min, restitution of the jaw 0.15, stiffness 10 N/mm, preload 10 mm")
    check(page, run(680.0, 0.15, 10.0, 10.0))


def test_the_whole_turn_follows_the_sliders(page: Page) -> None:
    """Rest and opening in the turn, as the direct engine has them; also where the jaw throws on."""
    page.wait_for_selector("[data-key=rest]")
    for speed in (650.0, 700.0):
        enter(page, SPEED, f"{speed:g}")
        page.wait_for_selector("[data-key=rest]")
        wanted = simulate(load("e62"), Case(speed_rpm=speed, window=Window.CYCLE))
        whole = wanted.transitions[0]
        rest = float(wanted.shaft.angle(whole.t_start + whole.duration))
        index = wanted.mechanism.cylinder.index_from_angle(rest)
        assert number(page, "rest") == pytest.approx(index, abs=6e-4)
        assert number(page, "opening") == pytest.approx(7.492, abs=2e-3)
        assert page.locator("[data-key=turn_engine]").inner_text().startswith("reduced, ")
    enter(page, RESTITUTION, "0.7")
    page.wait_for_selector("#message")
    page.wait_for_selector("[data-key=rest]")
    assert page.locator("#turn").count() == 1


def test_a_setting_without_rest_shows_its_reason_instead_of_numbers(page: Page) -> None:
    enter(page, RESTITUTION, "0.7")
    page.wait_for_selector("#message")
    assert "did not come to rest" in page.inner_text("#message")
    assert page.locator("#numbers").count() == 0
    assert page.locator(".uplot").count() == 0
    enter(page, RESTITUTION, "0.2")
    page.wait_for_selector("#numbers")
    page.wait_for_function("document.querySelectorAll('.uplot').length === 2")
    assert page.locator("#message").count() == 0
    check(page, run(650.0, 0.2, 9.0, 11.0))


def test_the_picture_shows_the_machine_and_moves(page: Page) -> None:
    """Not blank: saturated colours that no background has; and it changes as it plays.

    The jaw goes to and fro, so one later moment may look like the first, and a busy machine draws
    late: pictures are taken for a while, and a page that stands still shows the same in all.
    """
    page.wait_for_function("document.querySelector('#now')?.textContent.includes('jaw')")
    page.wait_for_timeout(1000)
    before = picture(page)
    assert (before.max(axis=-1) - before.min(axis=-1) > 60.0).mean() > 0.02
    assert len(np.unique(before.reshape(-1, 3), axis=0)) > 300
    told = page.inner_text("#now")
    page.wait_for_function("old => document.querySelector('#now').textContent !== old", arg=told)
    changed = 0.0
    for _ in range(20):
        page.wait_for_timeout(500)
        changed = max(changed, (np.abs(picture(page) - before).max(axis=-1) > 30.0).mean())
        if changed > 1e-3:
            return
    pytest.fail(f"{changed:.2e} of the picture changed in twenty pictures of a film that plays")


def test_what_the_picture_tells_is_the_motion_of_the_setting(page: Page) -> None:
    """Time and jaw angle of a moment, read together, against the run; the drawing exaggerates."""
    wanted = run(650.0, 0.2, 9.0, 11.0)
    jaw = wanted.mechanism.stop("jaw").index
    page.wait_for_function("document.querySelector('#now')?.textContent.includes('jaw')")
    t, _, angle, _ = page.inner_text("#now").split(", ")
    moment = 1e-3 * float(t.split()[0])
    # The time has two decimals [ms]; in that, the angle moves by the rate times 5e-6 s.
    slack = np.degrees(np.abs(wanted.events[0].v_before[jaw])) * 6e-6 + 1e-4
    at = min(moment, wanted.segments[-1].t_end)
    found = np.degrees(wanted.trajectory.evaluate(at).q[0, jaw])
    assert float(angle.split()[1]) == pytest.approx(found, abs=slack)


def test_the_page_says_what_it_is(page: Page) -> None:
    assert "not the maker's data" in page.inner_text("#title")
    assert "none is the maker's" in page.inner_text("#note")
    assert page.locator("[data-key=engine]").inner_text().startswith("direct, ")


def test_the_delay_of_the_numbers_can_be_read(page: Page) -> None:
    """Every key has its answer, one by one; `pytest -s` prints how long they took."""
    page.wait_for_timeout(2000)
    page.evaluate(STOPWATCH)
    slider(page, SPEED).focus()
    for count in range(1, 41):
        page.keyboard.press("ArrowRight" if count <= 20 else "ArrowLeft")
        page.wait_for_function("count => window.delays.length === count", arg=count)
    delays = sorted(page.evaluate("window.delays"))
    assert len(delays) == 40
    print(
        f"slider to numbers: least {delays[0]:.0f} ms, median {statistics.median(delays):.0f} ms, "
        f"95 % {delays[37]:.0f} ms"
    )
