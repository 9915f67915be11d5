"""The page of a comparison in a real browser: two machines, two lips, two curves, one cursor."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playing_page import picture, playing, seek, until
from playwright.sync_api import Page

from nipper_pin import Case, Comparison, compare, load, simulate, view
from nipper_pin.view.compare.pair import COLOUR_A, COLOUR_B, Pair, pair
from nipper_pin.view.scene import Look
from nipper_pin.view.scene.colours import channels

pytestmark = pytest.mark.slow
LOOK = Look(exaggerate=4.0)


@pytest.fixture(scope="module")
def turns() -> Comparison:
    """Two machines of unequal dimensions at one speed, so that both pictures differ everywhere."""
    case = Case(speed_rpm=450.0, window="cycle")
    return compare(*(simulate(load(name), case) for name in ("e62", "e62_identified")))


@pytest.fixture(scope="module")
def both(turns: Comparison) -> Pair:
    return pair(turns, LOOK)


@pytest.fixture(scope="module")
def page_file(turns: Comparison, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return view(turns, tmp_path_factory.mktemp("page") / "compare.html", exaggerate=LOOK.exaggerate)


@pytest.fixture(scope="module")
def window(open_page, page_file: Path) -> Iterator[Page]:
    """Opened once; what it complains of or asks for fails the last test."""
    with playing(open_page, page_file) as opened:
        yield opened


@pytest.fixture
def page(window: Page) -> Page:
    """With both machines, whatever the test before has left."""
    for side in ("a", "b"):
        window.locator(f"#shown-{side}").check()
    return window


def of_colour(image: np.ndarray, colour: str, within: float = 40.0) -> np.ndarray:
    """Pixels that are nearly of a colour, shape (height, width)."""
    return np.abs(image - 255.0 * np.array(channels(colour))).max(axis=-1) < within


def rebound(both: Pair, run: int) -> float:
    """Time of the film in the middle of the first rebound of A (0) or B (1)."""
    shown = (both.a, both.b)[run]
    hit = next(item for item in shown.solution.collisions if item.stop == "jaw")
    return float(shown.pace.playback_at(hit.t + 0.5 * hit.rebound_time))


def test_both_curves_stand_where_both_runs_are(page: Page, both: Pair) -> None:
    """In the lane of the gap each colour has its top in the middle of its rebound, to scale."""
    seek(page, 0.0)
    image = picture(page, "#curves canvas")
    duration, left, right = page.evaluate("[film.duration, LEFT, RIGHT]")
    count = page.evaluate("film.curves.length")
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
        share = 1e3 * lever * hit.rebound_amplitude / page.evaluate("film.curves[0].most")
        assert tops[run] == pytest.approx((1.0 - share) * len(lane), abs=3.0)
    assert abs(tops[0] - tops[1]) > 3.0


def test_numbers_of_both_are_written_and_marks_of_both_lead_to_them(page: Page, both: Pair) -> None:
    duration, left, right = page.evaluate("[film.duration, LEFT, RIGHT]")
    seek(page, 0.6 * duration)
    frame = page.evaluate("last(film.playback, animator.time + 1e-6)")
    rows = page.evaluate(
        "[...document.querySelectorAll('#numbers tbody tr, #numbers > tr')].map("
        "row => [...row.cells].map(cell => cell.textContent))"
    )
    angle = next(row for row in rows if row[0] == "jaw angle")
    for cell, film in zip(angle[1:3], (both.a, both.b), strict=True):
        jaw = film.solution.mechanism.stop("jaw").index
        assert float(cell) == pytest.approx(np.degrees(film.q[frame, jaw]), rel=1e-3, abs=1e-9)
    page.mouse.move(0, 0)
    box = page.locator("#curves canvas").bounding_box()
    hit = page.evaluate(
        "film.collisions.find(hit => hit.text.startsWith('B') && hit.stop === 'jaw')"
    )
    at = left + hit["at"] / duration * (box["width"] - left - right)
    page.mouse.click(box["x"] + at + 2.0, box["y"] + 10.0)
    assert page.evaluate("animator.time") == pytest.approx(hit["at"], abs=1e-9)
    until(page, "byId('hit').textContent.startsWith('B last: collision')")


def test_both_machines_are_seen_and_can_be_hidden(page: Page, both: Pair) -> None:
    """The second one is of its tint; without it, or without the first, the picture is another."""
    seek(page, rebound(both, 0))
    images = [picture(page, "#pane")]
    for side in ("b", "a"):
        page.locator(f"#shown-{side}").uncheck()
        images.append(picture(page, "#pane"))
    whole, alone, none = images

    def pink(image: np.ndarray) -> int:
        return int(
            ((image[..., 0] - image[..., 1] > 25.0) & (image[..., 2] - image[..., 1] > 15.0)).sum()
        )

    assert pink(whole) > 20 * pink(alone) + 500
    assert (np.abs(alone - none).max(axis=-1) > 30.0).mean() > 0.05
    page.locator("#shown-b").check()
    assert pink(picture(page, "#pane")) > pink(whole)


def test_the_lips_of_both_are_apart_by_their_own_gaps(page: Page, both: Pair) -> None:
    """In the middle of A's first rebound B is still closing; each close-up shows its own gap."""
    seek(page, rebound(both, 0))
    frame = page.evaluate("last(film.playback, animator.time + 1e-6)")
    high = page.evaluate("film.lips.height")
    found = []
    for place, film in enumerate((both.a, both.b)):
        image = picture(page, f"#closeups figure:nth-child({place + 1}) canvas")
        stop = film.solution.mechanism.stop("jaw")
        gap = stop.lever * float(stop.gaps(film.drawn[[frame]])[0])
        wide = image.shape[1]
        middle = image[:, int(0.46 * wide) : int(0.5 * wide)]
        saturation = middle.max(axis=-1) - middle.min(axis=-1)
        # The lower lip of A is grey; that of B has the tint of the upper one, below the middle.
        upper = np.flatnonzero((saturation > 60.0).any(axis=1))
        upper = upper[upper < 0.5 * image.shape[0] - 2.0]
        lowest = 0.5 * image.shape[0] - upper.max() - 0.5
        found.append((lowest, gap * image.shape[0] / high))
    for lowest, wanted in found:
        assert lowest == pytest.approx(wanted, abs=4.0)
    assert abs(found[0][1] - found[1][1]) > 8.0


def test_the_table_stands_on_the_page(page: Page, turns: Comparison) -> None:
    rows = page.locator("#differences tbody tr").count()
    assert rows == len([row for row in turns.rows if row.a is not None or row.b is not None])
    assert "B rebounds" in page.text_content("#finding")
    assert "450 r/min" in page.text_content("#case")
