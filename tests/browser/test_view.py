"""The page in a real browser: it draws, it plays, it says what the solution says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playing_page import apart, picture, playing, seek, until
from playwright.sync_api import Browser, Page

from nipper_pin import Case, PhaseInterval, Solution, load, simulate, view
from nipper_pin.view.phases import intervals
from nipper_pin.view.scene import Film, Look, film
from nipper_pin.view.scene.colours import channels

# A browser takes seconds to start and to draw.
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def solution() -> Solution:
    return simulate(load("e62"), Case(speed_rpm=650.0, window="cycle"))


@pytest.fixture(scope="module")
def shown(solution: Solution) -> Film:
    return film(solution, Look(exaggerate=10.0))


def shown_page(open_page, folder: Path, solution: Solution, factor: float) -> Iterator[Page]:
    """The static file, opened once; what it complains of or asks for fails the last test."""
    with playing(open_page, view(solution, folder / "e62.html", exaggerate=factor)) as page:
        yield page


@pytest.fixture(scope="module")
def page(open_page, solution: Solution, tmp_path_factory) -> Iterator[Page]:
    """Gaps are drawn ten times as large."""
    yield from shown_page(open_page, tmp_path_factory.mktemp("page"), solution, 10.0)


@pytest.fixture(scope="module")
def plain(open_page, solution: Solution, tmp_path_factory) -> Iterator[Page]:
    """Gaps are drawn as they are."""
    yield from shown_page(open_page, tmp_path_factory.mktemp("plain"), solution, 1.0)


def machine(page: Page) -> np.ndarray:
    """The picture of the machine, without the buttons in its lower corner."""
    return picture(page, "#pane")[20:-45]


def numbers(page: Page) -> dict[str, float]:
    rows = page.evaluate(
        "[...document.querySelectorAll('#numbers tr')].map(row => "
        "[row.cells[0].textContent, row.cells[1].textContent])"
    )
    return {label: float(value) for label, value in rows}


def elsewhere(solution: Solution, item: PhaseInterval) -> bool:
    """A phase without closed stops in which no collision of the jaw falls."""
    jaw = [hit.t for hit in solution.collisions if hit.stop == "jaw"]
    return not item.closed and not any(item.t_start <= t < item.t_end for t in jaw)


def tinted(image: np.ndarray, colour: str) -> int:
    """Pixels whose hue is that of a colour, lit brightly or darkly."""
    wanted = np.array(channels(colour))
    length = np.linalg.norm(image, axis=-1)
    cosine = image @ wanted / np.maximum(length, 1.0) / np.linalg.norm(wanted)
    return int(((cosine > 0.997) & (length > 80.0)).sum())


def test_the_picture_changes_as_it_plays(page: Page) -> None:
    """The film, which plays by itself when it opens, stops and plays on at a click."""
    # From a known place: the film repeats, and the end of a wait must not lie behind its end.
    seek(page, 0.2)
    before = machine(page)
    assert page.text_content("#play") == "play"
    page.click("#play")
    until(page, "animator.time > 0.7")
    page.click("#play")
    until(page, "!animator.playing")
    still = machine(page)
    assert (np.abs(still - before).max(axis=-1) > 30.0).mean() > 0.01
    np.testing.assert_array_equal(machine(page), still)
    page.click("#play")
    until(page, "animator.playing")


def test_numbers_follow_the_time(page: Page, shown: Film) -> None:
    """At frames all over the film the page says the numbers of the film, to its four digits."""
    jaw = shown.solution.mechanism.stop("jaw").index
    for k in range(5, len(shown.q), 97):
        # In the middle of the frame, so that rounding of its time does not choose another one.
        at = 0.5 * float(shown.pace.playback[k] + shown.pace.playback[min(k + 1, len(shown.q) - 1)])
        seek(page, at)
        read = numbers(page)
        assert read["index"] == pytest.approx(shown.index[k], rel=1e-3)
        assert read["time"] == pytest.approx(1e3 * shown.pace.machine[k], rel=1e-3)
        # The machine's angle, not the one that is drawn ten times as large.
        angle = np.degrees(shown.q[k, jaw])
        assert read["jaw angle"] == pytest.approx(angle, rel=1e-3, abs=1e-9)
        force = shown.force["jaw"][k]
        assert read["jaw clamping force"] == pytest.approx(force, rel=1e-3, abs=1e-6)
        item = shown.solution.phases[int(shown.phase[k])]
        wanted = "jaw open" if elsewhere(shown.solution, item) else f"phase {item.number}"
        assert page.text_content("#phase").startswith(wanted)


def test_colour_tells_the_phase(page: Page, shown: Film) -> None:
    """In the middle of each phase its own colour covers more than the others' do."""
    colours = {item.start: item.colour for item in intervals(shown.solution)}
    bouncing = [item for item in shown.solution.phases if not elsewhere(shown.solution, item)]
    for item in bouncing[-3:]:
        seek(page, float(shown.pace.playback_at(0.5 * (item.t_start + item.t_end))))
        image = machine(page)
        own = tinted(image, colours[item.t_start])
        named = {colours[one.t_start] for one in bouncing}
        others = [tinted(image, one) for one in named - {colours[item.t_start]}]
        assert own > 2000
        assert own > 2 * max(others)


def test_the_arrow_of_an_impulse_comes_and_goes(page: Page, shown: Film) -> None:
    """Pixels of the arrow's colour: many just after the largest collisions, none later."""
    hit = max(shown.solution.collisions, key=lambda item: item.impulse)
    first = next(item for item in shown.solution.collisions if item.stop == "jaw")
    for item in (hit, first):
        at = float(shown.pace.playback_at(item.t))
        seek(page, at + 0.3)
        during = tinted(machine(page), "#D55E00")
        seek(page, at + 1.5)
        assert during > 4 * tinted(machine(page), "#D55E00") + 500
        assert f"collision {item.number} " in page.text_content("#hit")


def test_an_exaggerated_gap_shows(page: Page, plain: Page, shown: Film) -> None:
    """In the middle of the first rebound, 0.3 degrees, the two drawings differ; at rest not.

    A click shows the one as the other, at the same time of the film.
    """
    first = next(item for item in shown.solution.collisions if item.stop == "jaw")
    closed = next(item for item in shown.solution.phases if item.number == 2)
    share = []
    for t in (first.t + 0.5 * first.rebound_time, 0.5 * (closed.t_start + closed.t_end)):
        images = []
        for one in (page, plain):
            seek(one, float(shown.pace.playback_at(t)))
            images.append(machine(one))
        page.uncheck("#larger")
        np.testing.assert_array_equal(machine(page), images[1])
        assert page.inner_text("#lips figcaption").endswith("true size")
        page.check("#larger")
        np.testing.assert_array_equal(machine(page), images[0])
        assert page.inner_text("#size").strip() == "rebounds x 10"
        share.append((np.abs(images[0] - images[1]).max(axis=-1) > 30.0).mean())
    assert share[0] > 0.003
    assert share[1] == 0.0


def test_the_line_scrubs(page: Page) -> None:
    box = page.locator("#scrub").bounding_box()
    page.evaluate("animator.pause()")
    page.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.5 * box["height"])
    time, duration, left, right = page.evaluate("[animator.time, film.duration, LEFT, RIGHT]")
    share = (0.6 * box["width"] - left) / (box["width"] - left - right)
    assert time == pytest.approx(share * duration, rel=0.02)


def test_a_served_page_runs_no_script_but_its_own(chromium: Browser, watch, serving) -> None:
    with serving("view", "--speed", "650") as address:
        page = chromium.new_page(viewport={"width": 1100, "height": 900})
        found = watch(page)
        page.goto(address)
        page.wait_for_selector("#pane canvas")
        until(page, "animator.time > 0.2")
        complaints = list(found.complaints)
        # Whatever a model's texts became, the browser would run no script but those of the page.
        ran = "() => { const one = document.createElement('script'); one.textContent = 'bad = 1';"
        assert page.evaluate(ran + " document.head.append(one); return window.bad; }") is None
        assert any("Content Security Policy" in item for item in found.complaints)
        page.close()
    assert complaints == []


@pytest.mark.parametrize(("drawn", "factor"), [("plain", 1.0), ("page", 10.0)])
def test_both_lips_are_seen_close_up(
    request: pytest.FixtureRequest, solution: Solution, shown: Film, drawn: str, factor: float
) -> None:
    """Apart by the gap that is drawn, to the scale that is shown; and together at rest.

    The distance between the upper lip's lowest pixel and the row of the contact point, the middle
    of the picture, is the gap: 0.47 mm in the first rebound, or ten times that.
    """
    page: Page = request.getfixturevalue(drawn)
    first = next(hit for hit in solution.collisions if hit.stop == "jaw")
    lever = solution.mechanism.stop("jaw").lever
    closed = next(item for item in solution.phases if item.number == 2)
    rest = 0.5 * (closed.t_start + closed.t_end)
    high, scale = page.evaluate("[film.lips.height, film.lips.scale_mm]")
    assert scale / 1e3 < 0.5 * high
    for t in (first.t + 0.5 * first.rebound_time, rest):
        seek(page, float(shown.pace.playback_at(t)))
        image = picture(page, "#lips canvas")
        gap = factor * lever * float(solution.trajectory.evaluate(t).q[0, 2])
        # Just behind the contact point: farther back the gap of a turned lip is smaller.
        wide = image.shape[1]
        middle = image[:, int(0.46 * wide) : int(0.5 * wide)]
        saturation = middle.max(axis=-1) - middle.min(axis=-1)
        amber = (saturation > 120.0) & (middle[..., 0] > middle[..., 2] + 100.0)
        blue = (saturation > 60.0) & (middle[..., 2] > middle[..., 0] + 60.0)
        upper = np.flatnonzero((amber if t != rest else blue).any(axis=1))
        pixels = image.shape[0] / high
        lowest = 0.5 * image.shape[0] - upper.max() - 0.5
        assert upper.size
        assert lowest == pytest.approx(gap * pixels, abs=4.0)
        # Something is under it: the lower lip, from the contact point downwards.
        under = middle[int(0.5 * image.shape[0]) + 2 : int(0.5 * image.shape[0]) + 8]
        assert (under.max(axis=-1) < 215.0).mean() > 0.3


def test_the_cursor_follows_and_a_click_goes_to_a_collision(page: Page, solution: Solution) -> None:
    """The curves' dark line stands at the film's time; a click on a mark shows its impulse."""
    canvas = page.locator("#curves canvas")
    box = canvas.bounding_box()
    duration, left, right = page.evaluate("[film.duration, LEFT, RIGHT]")

    def across(time: float) -> float:
        return left + time / duration * (box["width"] - left - right)

    for share in (0.2, 0.7):
        seek(page, share * duration)
        image = picture(page, "#curves canvas")
        dark = (image.max(axis=-1) < 90.0).mean(axis=0)
        assert abs(int(dark.argmax()) - across(share * duration)) < 3.0
        assert dark.max() > 0.9
    hit = next(item for item in solution.collisions if item.stop == "jaw")
    at = page.evaluate("number => film.collisions[number - 1].at", hit.number)
    page.mouse.click(box["x"] + across(at) + 3.0, box["y"] + 10.0)
    assert page.evaluate("animator.time") == pytest.approx(at, abs=1e-9)
    until(page, f"byId('hit').textContent.includes('collision {hit.number} ')")
    assert f"{hit.impulse:.4g}" in page.text_content("#hit")
    # Dragged from there, the cursor stays under the pointer.
    page.mouse.move(box["x"] + across(at), box["y"] + 10.0)
    page.mouse.down()
    page.mouse.move(box["x"] + across(0.5 * duration), box["y"] + 10.0)
    page.mouse.up()
    assert page.evaluate("animator.time") == pytest.approx(0.5 * duration, rel=0.01)


def test_keys_buttons_and_speed(page: Page) -> None:
    """Space plays, arrows step a frame, the views move the camera, names can be switched off.

    The place in the turn is an index, or an angle of 9 degrees for each.
    """
    seek(page, 1.0)
    page.keyboard.press("Space")
    until(page, "animator.playing")
    page.keyboard.press("ArrowRight")
    until(page, "!animator.playing")
    before = page.evaluate("last(film.playback, animator.time + 1e-6)")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowLeft")
    assert page.evaluate("last(film.playback, animator.time + 1e-6)") == before + 1
    page.keyboard.press("Home")
    assert page.evaluate("animator.time") == 0.0
    places = []
    for button in ("whole", "side", "near"):
        page.click(f"#{button}")
        places.append(page.evaluate("viewer.camera.position.toArray()"))
    assert len({tuple(place) for place in places}) == 3
    index = numbers(page)["index"]
    page.click("#numbers button")
    until(page, "!byId('numbers').textContent.startsWith('index')")
    assert numbers(page)["angle from index 0"] == pytest.approx(9.0 * index, rel=2e-3)
    page.click("#numbers button")
    until(page, "byId('numbers').textContent.startsWith('index')")
    page.select_option("#pace", "2")
    assert page.evaluate("animator.mixer.timeScale") == 2.0
    page.locator("#names").check()
    until(page, "!byId('labels').hidden")
    assert "top nipper" in page.locator("#labels span").all_text_contents()
    page.locator("#names").uncheck()
    until(page, "byId('labels').hidden")


def test_a_dark_page(page: Page) -> None:
    """As the browser wants it: paper and background dark, words and curves bright; and back."""
    for scheme, dim in (("dark", True), ("light", False)):
        page.emulate_media(color_scheme=scheme)
        seek(page, 1.0)
        for part in ("#pane", "#curves canvas", "#note", "#numbers"):
            image = picture(page, part)
            assert bool(np.median(image) < 100.0) is dim, part
            # Something is told from its ground.
            assert np.abs(image - np.median(image)).max() > 100.0


@pytest.mark.parametrize(("width", "height"), [(1024, 768), (900, 700), (390, 844)])
def test_nothing_covers_the_machine_on_small_screens(plain: Page, width: int, height: int) -> None:
    """Picture, close-up, numbers and curves are apart; on a usual screen curves are in sight."""
    plain.set_viewport_size({"width": width, "height": height})
    *_, curves = apart(plain, "#pane", "#lips", "#numbers", "#line", "#curves")
    assert width < 1000 or curves["y"] + curves["height"] <= height
