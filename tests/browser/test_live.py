"""The live page in a real browser: a slider moves, and everything follows it."""

from __future__ import annotations

import io
from collections.abc import Iterator
from importlib.util import find_spec

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Locator, Page, ViewportSize

from nipper_pin import Case, Solution, Window, load, simulate

pytestmark = [
    pytest.mark.skipif(find_spec("viser") is None, reason="viser is not installed (extra `live`)"),
    pytest.mark.slow,
]

# three.js, inside of viser, says this of viser's own clock whenever a page is opened.
ALWAYS_SAID = "THREE.Clock: This module has been deprecated"
SPEED, RESTITUTION, STIFFNESS, PRELOAD = range(4)
START = "speed 650 r/min, restitution of the jaw 0.2, stiffness 9 N/mm, preload 11 mm"
PINNED, BEFORE, NOW = 1, 2, 3
SIZE: ViewportSize = {"width": 900, "height": 700}
# viser draws as often as it may, which takes all of a processor: ten pictures a second are enough.
SELDOM = """
    window.requestAnimationFrame = draw => setTimeout(() => draw(performance.now()), 100);
    window.cancelAnimationFrame = clearTimeout;
"""
# Panels of viser's own have fields and sliders as well, which are hidden.
PANEL = "div:has(> div > #layout)"
FIELD = f"{PANEL} .mantine-TextInput-input"


@pytest.fixture(scope="module")
def address(serving) -> Iterator[str]:
    with serving("live", "--speed", "650") as place:
        yield place


@pytest.fixture(scope="module")
def window(chromium: Browser, watch, address: str) -> Iterator[Page]:
    """The page, drawn once; what it complains of or asks for fails the last test."""
    opened = chromium.new_page(viewport=SIZE)
    found = watch(opened)
    opened.add_init_script(SELDOM)
    opened.goto(address)
    opened.wait_for_selector("canvas")
    opened.wait_for_selector("#setting")
    yield opened
    opened.close()
    assert [item for item in found.complaints if not item.startswith(ALWAYS_SAID)] == []
    # Its own server, and what the page makes of itself: no other place in the network.
    own = (address, f"blob:{address}")
    assert [item for item in found.requests if not item.startswith(own)] == []


@pytest.fixture
def page(window: Page) -> Page:
    """Sliders at their starts, nothing pinned, whatever the test before has left."""
    window.set_viewport_size(SIZE)
    if window.get_by_role("button", name="unpin").count():
        press_button(window, "unpin")
        window.wait_for_selector("button:has-text('pin this curve')")
    # A reset where nothing has moved shows no answer that could be waited for, and may set sliders
    # back that a test already moves.
    if window.inner_text("#setting") != START or window.locator(".refused").count():
        press_button(window, "reset")
        follow(window, START)
        window.wait_for_selector(".refused", state="detached")
    return window


def slider(page: Page, place: int) -> Locator:
    return page.locator("[role=slider]").nth(place)


def field(page: Page, place: int) -> Locator:
    return page.locator(FIELD).nth(place)


def press_button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def enter(page: Page, place: int, value: str) -> None:
    """Write a number into the field beside a slider, and wait for its answer.

    viser sends at most one value in 50 ms, the last one, whichever slider it is of: two sliders
    moved in less would lose the first, which no hand can do.
    """
    field(page, place).fill(value)
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


CHARTS = (
    "Object.values(window.__viserTestpoints.uplots).map(item => item.chart).sort((a, b) =>"
    " a.root.getBoundingClientRect().top - b.root.getBoundingClientRect().top)"
)


def line(page: Page, place: int, curve: int = NOW) -> np.ndarray:
    """What a plot shows: times and values of a curve, from the chart itself."""
    told = page.evaluate(
        f"place => {CHARTS}[place].data.map(row => Array.from(row, String))", place
    )
    data = np.array(told, dtype=float)[[0, curve]]
    return data[:, np.isfinite(data[1])]


def ends(page: Page) -> list[list[float]]:
    """Ends of the axes of all plots."""
    return page.evaluate(
        f"{CHARTS}.map(item => Object.values(item.scales).flatMap(one => [one.min, one.max]))"
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
    amplitude = 1e3 * np.degrees(first.rebound_amplitude)
    assert number(page, "amplitude") == pytest.approx(amplitude, rel=6e-4)
    assert number(page, "duration") == pytest.approx(1e3 * whole.duration, rel=6e-4)
    assert number(page, "impulse") == pytest.approx(first.impulse, rel=6e-4)
    assert number(page, "collisions") == whole.collisions
    gap, impulse = line(page, 0), line(page, 2)
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
    page.wait_for_function("document.querySelectorAll('.uplot').length === 3")
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
    t, _, angle, lips, force, _ = page.inner_text("#now").split(", ")
    moment = 1e-3 * float(t.split()[0])
    # The time has two decimals [ms]; in that, the angle moves by the rate times 5e-6 s.
    slack = 1e3 * np.degrees(np.abs(wanted.events[0].v_before[jaw])) * 6e-6 + 0.1
    at = min(moment, wanted.segments[-1].t_end)
    found = 1e3 * np.degrees(wanted.trajectory.evaluate(at).q[0, jaw])
    assert float(angle.split()[1]) == pytest.approx(found, abs=slack)
    # The lever from the hinge to the lips, from the file of the model.
    assert lips.startswith("gap at the contact ")
    lever = wanted.mechanism.stop("jaw").contact.lever_m
    read = float(lips.split()[4])
    assert read == pytest.approx(lever * np.radians(float(angle.split()[1])), rel=2e-3)
    pressed = float(force.split()[2])
    assert (pressed > 50.0) == (moment > wanted.events[-1].t)


def test_a_bad_number_is_refused_and_nothing_else_changes(page: Page) -> None:
    field(page, SPEED).fill("3000")
    page.wait_for_selector(".refused")
    assert page.inner_text(".refused") == (
        "speed: 180 to 900 r/min. Refused: 3000 is too large. Shown: 650 r/min."
    )
    assert page.inner_text("#setting") == START
    check(page, run(650.0, 0.2, 9.0, 11.0))
    style = "element => getComputedStyle(element).textDecorationLine"
    assert field(page, SPEED).evaluate(style) == "line-through"
    assert field(page, STIFFNESS).evaluate(style) == "none"
    # Still there a while later and after leaving the field: nothing is replaced in silence.
    field(page, SPEED).blur()
    page.wait_for_timeout(500)
    assert field(page, SPEED).input_value() == "3000"
    for text, reason in (("abc", "no number"), ("", "is empty"), ("179.9", "too small")):
        field(page, SPEED).fill(text)
        page.wait_for_selector(f".refused:has-text('{reason}')")
    enter(page, SPEED, "720")
    page.wait_for_selector(".refused", state="detached")
    check(page, run(720.0, 0.2, 9.0, 11.0))


def seen(page: Page, colour: str) -> int:
    """Pixels of a colour in the plot of the jaw angle."""
    image = page.locator(".u-wrap canvas").first.screenshot()
    pixels = np.asarray(Image.open(io.BytesIO(image)).convert("RGB"), dtype=float)
    wanted = np.array(list(bytes.fromhex(colour)), dtype=float)
    return int((np.abs(pixels - wanted).max(axis=-1) < 12.0).sum())


def against(page: Page, setting: str, ratio: float) -> None:
    """The page compares with a setting, and says by how much the impulse differs."""
    assert setting in page.inner_text("#against")
    told = page.locator("[data-difference=impulse]").inner_text()
    assert float(told.removesuffix(" %")) == pytest.approx(100.0 * (ratio - 1.0), abs=0.051)


def test_ghost_and_pinned_curve_are_seen_and_the_pinned_one_stays(page: Page) -> None:
    """By their colours, their data and the legend."""
    blue, before, pinned = "0072B2", "A6CDE6", "E69F00"
    press_button(page, "pin this curve")
    page.wait_for_selector("[data-curve=pinned]")
    page.wait_for_timeout(900)
    for speed in ("700", "740"):
        enter(page, SPEED, speed)
        page.wait_for_timeout(900)
    for curve, value in ((PINNED, 650.0), (BEFORE, 700.0), (NOW, 740.0)):
        wanted = 1e3 * np.degrees(run(value, 0.2, 9.0, 11.0).collisions[0].rebound_amplitude)
        assert line(page, 0, curve)[1].max() == pytest.approx(wanted, rel=1e-3)
    page.locator(".u-wrap").first.scroll_into_view_if_needed()
    assert min(seen(page, colour) for colour in (blue, before, pinned)) > 100
    assert page.inner_text("[data-curve=pinned]") == "pinned: speed 650 r/min"
    assert page.inner_text("[data-curve=before]") == "before: speed 700 r/min"
    # And the numbers are compared with the pinned ones, then with those before.
    one, two, now = (run(speed, 0.2, 9.0, 11.0).collisions[0] for speed in (650.0, 700.0, 740.0))
    against(page, "the pinned setting (speed 650 r/min)", now.impulse / one.impulse)
    press_button(page, "unpin")
    page.wait_for_selector("[data-curve=pinned]", state="detached")
    page.wait_for_timeout(300)
    assert seen(page, pinned) == 0
    assert seen(page, before) > 100
    against(page, "the setting before (speed 700 r/min)", now.impulse / two.impulse)


def test_axes_stand_still_for_a_small_change_and_reset_returns(page: Page) -> None:
    before = ends(page)
    press(page, SPEED, "ArrowRight", 2)
    follow(page, START.replace("650", "660"))
    assert ends(page) == before
    enter(page, SPEED, "880")
    page.wait_for_function(f"wanted => {CHARTS}[0].scales.y.max > wanted", arg=before[0][3])
    grown = ends(page)
    enter(page, SPEED, "500")
    assert ends(page) == grown
    press_button(page, "fit axes")
    page.wait_for_timeout(1000)
    field(page, RESTITUTION).fill("2")
    page.wait_for_selector(".refused")
    press_button(page, "reset")
    follow(page, START)
    page.wait_for_selector(".refused", state="detached")
    places = (SPEED, RESTITUTION, STIFFNESS, PRELOAD)
    assert [field(page, place).input_value() for place in places] == ["650", "0.2", "9", "11"]
    check(page, run(650.0, 0.2, 9.0, 11.0))


USEFUL = (
    *("#title", "#setting", "#numbers", "#turn", "#now", "#legend", "#note"),
    *(FIELD, f"{PANEL} [role=slider]", f"{PANEL} .mantine-Button-root", ".uplot-container"),
)


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (900, 700), (390, 800)])
def test_nothing_covers_anything_and_a_wide_window_shows_all(
    page: Page, width: int, height: int
) -> None:
    """Boxes of what is of use are apart from each other and from the picture."""
    page.set_viewport_size({"width": width, "height": height})
    page.wait_for_timeout(2500)
    # In one go, because texts are renewed all the time.
    boxes = page.evaluate(
        "names => names.flatMap(name => [...document.querySelectorAll(name)].map("
        "item => ({name, ...item.getBoundingClientRect().toJSON()})))",
        list(USEFUL),
    )
    assert len(boxes) >= 20
    apart = page.locator("canvas[data-engine]").evaluate(
        "item => item.getBoundingClientRect().toJSON()"
    )
    assert apart["width"] * apart["height"] > 0.3 * width * height
    for place, one in enumerate(boxes):
        assert one["width"] > 0.0, one
        assert -0.5 <= one["left"] <= one["right"] <= width + 0.5
        if width == 1400:
            assert one["bottom"] <= height
        for other in boxes[place + 1 :]:
            across = min(one["right"], other["right"]) - max(one["left"], other["left"])
            along = min(one["bottom"], other["bottom"]) - max(one["top"], other["top"])
            assert min(across, along) < 2.0, (one, other)
    panel = page.locator("#title").evaluate(
        "item => item.closest('[data-dock-region], .mantine-Paper-root')"
        ".getBoundingClientRect().toJSON()"
    )
    beside = apart["right"] <= panel["left"] + 1.0
    above = apart["bottom"] <= panel["top"] + 1.0
    assert beside or above


# What lies above the contact point, in the middle of the close-up, and in the lower lip behind it.
ABOVE = """() => {
    const box = document.querySelector('#lips').getBoundingClientRect();
    const x = box.left + box.width / 2, y = box.top + box.height / 2;
    const at = [[-6, -12], [-60, 8]];
    const found = at.map(([right, down]) => document.elementFromPoint(x + right, y + down).tagName);
    const now = document.querySelector('#now').textContent;
    const gap = now.match(/gap at the contact ([0-9.e-]+) mm/);
    return { found, gap: gap ? parseFloat(gap[1]) : NaN };
}"""


def test_the_lips_are_seen_close_up_open_and_closed(page: Page) -> None:
    """Between two rebounds there is paper above the lower lip, at rest there is the upper one."""
    page.set_viewport_size({"width": 1400, "height": 900})
    page.locator("#lips").scroll_into_view_if_needed()
    seen: dict[str, list[str]] = {}
    for _ in range(600):
        state = page.evaluate(ABOVE)
        if state["gap"] > 0.4:
            seen["open"] = state["found"]
        elif state["gap"] == 0.0:
            seen["closed"] = state["found"]
        if len(seen) == 2:
            break
        page.wait_for_timeout(50)
    # The lower lip stands still; the upper one is there or 30 pixels higher.
    assert seen == {"open": ["svg", "path"], "closed": ["path", "path"]}
    scale = page.evaluate(
        "getComputedStyle(document.querySelector('#lips-scale'), '::after').content"
    )
    assert scale == '"bar 5 mm; rebounds x 10"'
