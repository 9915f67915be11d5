"""The page in a real browser: it draws, it plays, it says what the solution says."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playing_page import apart, cells, picture, playing, seek, until, watch
from playwright.sync_api import Browser, Page

from nipper_pin import (
    Case,
    Comparison,
    PhaseInterval,
    Solution,
    compare,
    load,
    simulate,
    view,
)
from nipper_pin.view.compare.pair import COLOUR_A, COLOUR_B, Pair, pair
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


def shown_page(
    chromium: Browser, folder: Path, what: Solution | Comparison, factor: float
) -> Iterator[Page]:
    """The static file, opened once; what it complains of or asks for fails the last test."""
    with playing(chromium, view(what, folder / "page.html", exaggerate=factor)) as page:
        yield page


@pytest.fixture(scope="module")
def page(chromium: Browser, solution: Solution, tmp_path_factory) -> Iterator[Page]:
    """Gaps are drawn ten times as large."""
    yield from shown_page(chromium, tmp_path_factory.mktemp("page"), solution, 10.0)


@pytest.fixture(scope="module")
def plain(chromium: Browser, solution: Solution, tmp_path_factory) -> Iterator[Page]:
    """Gaps are drawn as they are."""
    yield from shown_page(chromium, tmp_path_factory.mktemp("plain"), solution, 1.0)


def machine(page: Page) -> np.ndarray:
    """The picture of the machine, without the buttons in its lower corner."""
    return picture(page, "#pane")[20:-45]


def numbers(page: Page) -> dict[str, float]:
    return {label: float(value) for label, value, *_ in cells(page, "#numbers tr")}


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


def test_a_served_page_runs_no_script_but_its_own(chromium: Browser, serving) -> None:
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


def close_up(page: Page, canvas: str) -> tuple[np.ndarray, np.ndarray]:
    """A strip of the lips, and how strong its colours are.

    Just behind the contact point: farther back the gap of a turned lip is smaller.
    """
    image = picture(page, canvas)
    strip = image[:, int(0.46 * image.shape[1]) : int(0.5 * image.shape[1])]
    return strip, strip.max(axis=-1) - strip.min(axis=-1)


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
        middle, saturation = close_up(page, "#lips canvas")
        gap, half = (
            factor * lever * float(solution.trajectory.evaluate(t).q[0, 2]),
            len(middle) // 2,
        )
        amber = (saturation > 120.0) & (middle[..., 0] > middle[..., 2] + 100.0)
        blue = (saturation > 60.0) & (middle[..., 2] > middle[..., 0] + 60.0)
        upper = np.flatnonzero((amber if t != rest else blue).any(axis=1))
        lowest = 0.5 * len(middle) - upper.max() - 0.5
        assert lowest == pytest.approx(gap * len(middle) / high, abs=4.0)
        # Something is under it: the lower lip, from the contact point downwards.
        under = middle[half + 2 : half + 8]
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


# Two machines on one page: two lips, two curves.


@pytest.fixture(scope="module")
def turns() -> Comparison:
    """Two machines of unequal dimensions at one speed, so that both pictures differ everywhere."""
    case = Case(speed_rpm=450.0, window="cycle")
    return compare(*(simulate(load(name), case) for name in ("e62", "e62_identified")))


@pytest.fixture(scope="module")
def both(turns: Comparison) -> Pair:
    return pair(turns, Look(exaggerate=4.0))


@pytest.fixture(scope="module")
def opened_pair(chromium: Browser, turns: Comparison, tmp_path_factory) -> Iterator[Page]:
    yield from shown_page(chromium, tmp_path_factory.mktemp("pair"), turns, 4.0)


@pytest.fixture
def paired(opened_pair: Page) -> Page:
    """With both machines, whatever the test before has left."""
    for side in ("a", "b"):
        opened_pair.locator(f"#shown-{side}").check()
    return opened_pair


def of_colour(image: np.ndarray, colour: str, within: float = 40.0) -> np.ndarray:
    """Pixels that are nearly of a colour, shape (height, width)."""
    return np.abs(image - 255.0 * np.array(channels(colour))).max(axis=-1) < within


def rebound(both: Pair, run: int) -> float:
    """Time of the film in the middle of the first rebound of A (0) or B (1)."""
    shown = (both.a, both.b)[run]
    hit = next(item for item in shown.solution.collisions if item.stop == "jaw")
    return float(shown.pace.playback_at(hit.t + 0.5 * hit.rebound_time))


def test_both_curves_stand_where_both_runs_are(paired: Page, both: Pair) -> None:
    """In the lane of the gap each colour has its top in the middle of its rebound, to scale."""
    seek(paired, 0.0)
    image = picture(paired, "#curves canvas")
    duration, left, right = paired.evaluate("[film.duration, LEFT, RIGHT]")
    count = paired.evaluate("film.curves.length")
    lane = image[5 : image.shape[0] // count - 5]
    tops = []
    for run, colour in enumerate((COLOUR_A, COLOUR_B)):
        at = left + rebound(both, run) / duration * (image.shape[1] - left - right)
        near = of_colour(lane, colour)[:, int(at) - 8 : int(at) + 9]
        assert near.any()
        tops.append(float(np.flatnonzero(near.any(axis=1)).min()))
        shown = (both.a, both.b)[run]
        hit = next(item for item in shown.solution.collisions if item.stop == "jaw")
        lever = shown.solution.mechanism.stop("jaw").lever
        share = 1e3 * lever * hit.rebound_amplitude / paired.evaluate("film.curves[0].most")
        assert tops[run] == pytest.approx((1.0 - share) * len(lane), abs=3.0)
    assert abs(tops[0] - tops[1]) > 3.0


def test_numbers_and_marks_of_both_are_there(paired: Page, both: Pair) -> None:
    duration, left, right = paired.evaluate("[film.duration, LEFT, RIGHT]")
    seek(paired, 0.6 * duration)
    frame = paired.evaluate("last(film.playback, animator.time + 1e-6)")
    rows = cells(paired, "#numbers tbody tr, #numbers > tr")
    angle = next(row for row in rows if row[0] == "jaw angle")
    for cell, one in zip(angle[1:3], (both.a, both.b), strict=True):
        jaw = one.solution.mechanism.stop("jaw").index
        assert float(cell) == pytest.approx(np.degrees(one.q[frame, jaw]), rel=1e-3, abs=1e-9)
    paired.mouse.move(0, 0)
    box = paired.locator("#curves canvas").bounding_box()
    hit = paired.evaluate(
        "film.collisions.find(hit => hit.text.startsWith('B') && hit.stop === 'jaw')"
    )
    at = left + hit["at"] / duration * (box["width"] - left - right)
    paired.mouse.click(box["x"] + at + 2.0, box["y"] + 10.0)
    assert paired.evaluate("animator.time") == pytest.approx(hit["at"], abs=1e-9)
    until(paired, "byId('hit').textContent.startsWith('B last: collision')")


def test_both_machines_are_seen_and_can_be_hidden(paired: Page, both: Pair) -> None:
    """The second one is of its tint; without it, or without the first, the picture is another."""
    seek(paired, rebound(both, 0))
    images = [picture(paired, "#pane")]
    for side in ("b", "a"):
        paired.locator(f"#shown-{side}").uncheck()
        images.append(picture(paired, "#pane"))
    whole, alone, none = images

    def pink(image: np.ndarray) -> int:
        return int(
            ((image[..., 0] - image[..., 1] > 25.0) & (image[..., 2] - image[..., 1] > 15.0)).sum()
        )

    assert pink(whole) > 20 * pink(alone) + 500
    assert (np.abs(alone - none).max(axis=-1) > 30.0).mean() > 0.05
    paired.locator("#shown-b").check()
    assert pink(picture(paired, "#pane")) > pink(whole)


def test_the_lips_of_both_are_apart_by_their_own_gaps(paired: Page, both: Pair) -> None:
    """In the middle of A's first rebound B is still closing; each close-up shows its own gap."""
    seek(paired, rebound(both, 0))
    frame = paired.evaluate("last(film.playback, animator.time + 1e-6)")
    high, wanted = paired.evaluate("film.lips.height"), []
    for place, one in enumerate((both.a, both.b)):
        canvas = f"#closeups figure:nth-child({place + 1}) canvas"
        middle, saturation = close_up(paired, canvas)
        half, stop = 0.5 * len(middle), one.solution.mechanism.stop("jaw")
        gap = stop.lever * float(stop.gaps(one.drawn[[frame]])[0])
        # The lower lip of A is grey; that of B has the tint of the upper one, below the middle.
        upper = np.flatnonzero((saturation > 60.0).any(axis=1))
        wanted.append(gap * len(middle) / high)
        assert half - upper[upper < half - 2.0].max() - 0.5 == pytest.approx(wanted[-1], abs=4.0)
    assert abs(wanted[0] - wanted[1]) > 8.0


def test_the_table_stands_on_the_page(paired: Page, turns: Comparison) -> None:
    """Of every angle a second row has the gap at the contact in mm."""
    rows = paired.locator("#differences tbody tr").count()
    told = [row for row in turns.rows if row.a is not None or row.b is not None]
    assert rows == len(told) + sum(row.unit == "rad" for row in told)
    assert "B rebounds" in paired.text_content("#finding")
    assert "450 r/min" in paired.text_content("#case")
