"""What each picture of a GIF says and shows, the pace of a film, and what a page is made of.

Texts, polygons and bars are taken down as they are drawn; what they must be is read from the run
and from the numbers of the page, which tests of their own compare with the run.
"""

from __future__ import annotations

import base64
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshcat
import numpy as np
import pytest
import umsgpack
from PIL import Image, ImageDraw, ImageSequence
from three_js import Scene

from nipper_pin import Case, InputError, Solution, load, simulate
from nipper_pin.view.scene import Film, Look, film, gif
from nipper_pin.view.scene.flat import moved
from nipper_pin.view.scene.gif import _Painter, write_gif
from nipper_pin.view.scene.pace import _profile, pace
from nipper_pin.view.scene.page import scene_page
from nipper_pin.view.scene.readings import readings

ARROW = "#D55E00"
PHASES = ("#F0E442", "#56B4E9", "#E69F00")
# Of phases without closed stops in which the jaw does not bounce.
ELSEWHERE = "#F7F0B5"
# Of the file; the pictures are drawn twice as large.
SIZE, MACHINE, BAR = (800, 560), (290, 66, 784, 462), (16, 480, 784, 492)
LIPS = (16, 308, 272, 462)


@pytest.fixture(scope="module")
def shown(cycle: Solution) -> Film:
    return film(cycle, Look(slow=100.0))


@pytest.fixture(scope="module")
def painter(shown: Film) -> _Painter:
    return _Painter(shown)


class Pen:
    """Takes down what is drawn."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.texts: list[tuple[str, tuple[float, ...], Any]] = []
        self.shapes: list[tuple[Any, Any]] = []
        text, polygon = ImageDraw.ImageDraw.text, ImageDraw.ImageDraw.polygon

        def write(draw: Any, at: Any, words: str, fill: Any, font: Any, anchor: str) -> None:
            box = draw.textbbox(at, words, font=font, anchor=anchor)
            self.texts.append((words, tuple(part / 2.0 for part in box), fill))
            text(draw, at, words, fill=fill, font=font, anchor=anchor)

        def cover(draw: Any, corners: Any, fill: Any) -> None:
            self.shapes.append((np.array(corners) / 2.0, fill))
            polygon(draw, corners, fill=fill)

        patch.setattr(ImageDraw.ImageDraw, "text", write)
        patch.setattr(ImageDraw.ImageDraw, "polygon", cover)

    def box(self, words: str) -> tuple[float, ...]:
        """Left, top, right and bottom of a text."""
        return next(box for text, box, _ in self.texts if text == words)


def apart(one: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return (
        one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]
    )  # fmt: skip


def test_slow_motion_of_groups_of_events() -> None:
    """Slow from 1 % of a turn before the first to as long after the last, with flanks of 1 %.

    Events less than 7 % of a turn apart are one group; in a flank every hundredth of it changes
    the speed by the same ratio.
    """
    period, slow = 0.5, 800.0
    events = period * np.array([0.30, 0.36, 0.60, 0.68])
    knots, stretch = _profile(events, period, period, slow)
    for turn, wanted in (
        (0.0, 50.0), (0.279, 50.0), (0.285, 200.0), (0.291, slow), (0.33, slow), (0.369, slow),
        (0.375, 200.0), (0.381, 50.0), (0.57, 50.0), (0.585, 200.0), (0.60, slow), (0.609, slow),
        (0.64, 50.0), (0.671, slow), (0.695, 200.0), (0.8, 50.0), (1.0, 50.0),
    ):  # fmt: skip
        assert np.interp(turn * period, knots, stretch) == pytest.approx(wanted, rel=1e-9), turn
    assert (knots[0], knots[-1]) == (0.0, period)


def test_texts_of_a_picture(shown: Film, monkeypatch: pytest.MonkeyPatch) -> None:
    """Title, case and note on all; phase, numbers with units, and the last collision by frame.

    All stand inside of the picture, below one another, and none on another or on the machine.
    """
    pen = Pen(monkeypatch)
    painter = _Painter(shown)
    common = list(pen.texts)
    caption = common.pop()
    assert caption[0] == "jaw cut along its hinge; bar 2 mm"
    assert LIPS[3] <= caption[1][1] < caption[1][3] <= BAR[1] - 4
    said: Any = readings(shown)
    assert [text for text, *_ in common[:2]] == [
        said["title"],
        "650 r/min, window cycle (1 turn from index 24), held drive",
    ]
    assert " ".join(text for text, *_ in common[2:]) == said["note"]
    assert common[0][1][3] < common[1][1][1] < common[1][1][3] < MACHINE[1]
    assert min(box[1] for _, box, _ in common[2:]) > BAR[3]
    for frame in painter.frames[:: len(painter.frames) // 4]:
        pen.texts[:] = common
        painter.picture(int(frame))
        phase, *others = pen.texts[len(common) :]
        assert phase[0] == said["phases"][said["phase_of_frame"][frame]]["name"]
        rows = said["columns"]
        for number, column in enumerate(rows):
            (label, left, _), (value, right, _) = others[2 * number : 2 * number + 2]
            assert label == column["label"]
            digits, _, unit = value.partition(" ")
            assert float(digits) == pytest.approx(column["values"][frame], rel=6e-4)
            assert unit == column["unit"]
            # On one line, and values end below one another.
            assert left[2] < right[0] < right[2] <= MACHINE[0]
            assert abs(left[1] - right[1]) < 6.0
            assert right[2] == pytest.approx(others[1][1][2], abs=2.0)
        now = float(shown.pace.playback[frame])
        done = [item["text"] for item in said["collisions"] if item["at"] <= now]
        last = others[2 * len(rows) :]
        assert " ".join(text for text, *_ in last) == (done[-1] if done else "")
        assert {fill for *_, fill in last} <= {ARROW}
        for place, (_, box, _) in enumerate(pen.texts):
            assert box[0] >= 0.0
            assert box[1] >= 0.0
            assert box[2] <= SIZE[0]
            assert box[3] <= SIZE[1]
            assert apart(box, BAR)
            assert place < 2 or apart(box, MACHINE)
            assert all(apart(box, other) for _, other, _ in pen.texts[:place])


def test_a_collision_is_told_from_its_own_frame_on(shown: Film, painter: _Painter) -> None:
    """Not before it, and the last of several."""
    with pytest.MonkeyPatch.context() as patch:
        pen = Pen(patch)
        hit = shown.solution.collisions[0]
        at = int(np.searchsorted(shown.pace.machine, hit.t))
        for frame, told in ((at - 1, False), (at, True)):
            pen.texts.clear()
            painter.picture(frame)
            assert any(f"collision {hit.number} " in text for text, *_ in pen.texts) == told


def test_the_machine_fills_its_part_of_the_picture(shown: Film, painter: _Painter) -> None:
    """Every corner by one scale, z upwards; the motion reaches opposite sides and stays inside."""
    with pytest.MonkeyPatch.context() as patch:
        pen = Pen(patch)
        low, high = np.full(2, np.inf), np.full(2, -np.inf)
        for frame in painter.frames[::9]:
            pen.shapes.clear()
            painter.picture(int(frame))
            corners = moved(painter._seen, shown, int(frame))
            faces = [item for item in painter._seen.items if len(item) == 3]
            drawn = [points for points, fill in pen.shapes if fill != ARROW]
            # What is drawn after the machine is the cut through the lips, on a picture of its own.
            lips, drawn = drawn[len(faces) :], drawn[: len(faces)]
            assert len(lips) >= 2
            wanted = np.concatenate([corners[list(item)] for item in faces])
            found = np.concatenate(drawn)
            across, upwards = (np.polyfit(wanted[:, k], found[:, k], 1) for k in range(2))
            assert across[0] == pytest.approx(-upwards[0], rel=1e-9)
            assert across[0] > 0.0
            for k, line in enumerate((across, upwards)):
                np.testing.assert_allclose(np.polyval(line, wanted[:, k]), found[:, k], atol=1e-6)
            low, high = np.minimum(low, found.min(axis=0)), np.maximum(high, found.max(axis=0))
    left, top, right, bottom = MACHINE
    assert (low >= np.array([left, top]) - 8.0).all()
    assert (high <= np.array([right, bottom]) + 8.0).all()
    shares = (high - low) / (right - left, bottom - top)
    assert max(shares) > 0.96
    middle = 0.5 * (low + high) - 0.5 * np.array([left + right, top + bottom])
    assert np.abs(middle).max() < 8.0


def test_bar_and_mark_of_a_picture(shown: Film, painter: _Painter) -> None:
    """The phases along the film by their colours, and where the film is."""
    said: Any = readings(shown)
    left, top, right, bottom = BAR
    starts = [item["start"] / said["duration"] for item in said["phases"]]
    for frame in painter.frames[:: len(painter.frames) // 5]:
        picture = np.asarray(painter.picture(int(frame)), int)
        here = left + (right - left) * float(shown.pace.playback[frame]) / said["duration"]
        dark = np.flatnonzero(picture[top - 3, left - 4 : right + 4].max(axis=-1) < 120) + left - 4
        assert abs(float(dark.mean()) + 0.5 - here) < 1.0
        assert (picture[bottom + 3, dark[0]] < 120).all()
        for pixel in range(left + 1, right - 1, 3):
            share = (pixel + 0.5 - left) / (right - left)
            if abs(pixel - here) < 3 or min(abs(share - item) for item in starts) < 2e-3:
                continue
            phase = max(k for k, start in enumerate(starts) if start <= share)
            wanted = bytes.fromhex(said["phases"][phase]["colour"][1:])
            for row in (top + 1, bottom - 1):
                assert tuple(picture[row, pixel]) == tuple(wanted)
        # The phase itself: a square of its colour before its name.
        wanted = bytes.fromhex(said["phases"][said["phase_of_frame"][frame]]["colour"][1:])
        square = picture[MACHINE[1] + 2 : MACHINE[1] + 15, left + 2 : left + 15]
        assert (square == list(wanted)).all()
    assert {item["colour"] for item in said["phases"]} == {*PHASES, ELSEWHERE}


@pytest.mark.slow
def test_arrows_shrink_after_a_while(cycle: Solution) -> None:
    """Whole for 0.6 s after a collision, then evenly less until nothing is left after 1 s."""
    hits, shown = cycle.collisions, film(cycle, Look())
    painter = _Painter(shown)
    at = np.interp([item.t for item in hits], shown.pace.machine, shown.pace.playback)
    largest = max(item.impulse for item in hits)
    lengths: dict[str, list[tuple[float, float]]] = {}
    with pytest.MonkeyPatch.context() as patch:
        pen = Pen(patch)
        lone = [k for k in range(len(hits) - 1) if at[k + 1] > at[k] + 1.2]
        assert len(lone) >= 2
        later = [at[k] + delay for k in lone for delay in (0.02, 0.55, 0.7, 0.8, 0.95, 1.05)]
        for frame in np.searchsorted(shown.pace.playback, later):
            pen.shapes.clear()
            painter.picture(int(frame))
            found = [points for points, fill in pen.shapes if fill == ARROW]
            wanted = []
            for stop in ("jaw", "steeve"):
                past = [k for k, item in enumerate(hits) if item.stop == stop
                        and item.t <= shown.pace.machine[frame]]  # fmt: skip
                if past:
                    gone = float(shown.pace.playback[frame]) - at[past[-1]]
                    left = min(1.0, max(0.0, (1.0 - gone) / 0.4))
                    if left * hits[past[-1]].impulse > 0.0:
                        wanted.append((stop, left * hits[past[-1]].impulse / largest))
            assert len(found) == len(wanted)
            for points, (stop, share) in zip(found, wanted, strict=True):
                foot = 0.5 * (points[0] + points[-1])
                tip = points[np.argmax(np.linalg.norm(points - foot, axis=1))]
                lengths.setdefault(stop, []).append((share, float(np.linalg.norm(tip - foot))))
    assert set(lengths) == {"jaw", "steeve"}
    # The smallest ones are wider than long.
    pairs = [pair for items in lengths.values() for pair in items if pair[0] > 0.02]
    unit = max(length / share for share, length in pairs)
    assert len({round(share, 6) for share, _ in pairs}) >= 6
    for share, length in pairs:
        assert length == pytest.approx(unit * share, rel=1e-6)


@pytest.mark.slow
def test_the_file_holds_the_pictures(cycle: Solution, tmp_path: Path) -> None:
    """In their order, ten a second, for ever; phases, arrows and the ground keep their colours."""
    look = Look(slow=5.0)
    path = write_gif(cycle, tmp_path / "film.gif", look)
    assert path == tmp_path / "film.gif"
    assert [item.name for item in tmp_path.iterdir()] == ["film.gif"]
    shown = film(cycle, look)
    painter = _Painter(shown)
    with Image.open(path) as image:
        assert (image.format, image.size) == ("GIF", SIZE)
        assert (image.info["duration"], image.info["loop"]) == (100, 0)
        found = [np.asarray(item.convert("RGB"), int) for item in ImageSequence.Iterator(image)]
    length = float(shown.pace.playback[-1])
    assert len(found) == math.ceil(10.0 * length)
    colours = set()
    for number, picture in enumerate(found):
        frame = int(painter.frames[number])
        # The first frame that is not before its time.
        assert shown.pace.playback[frame] >= 0.1 * number - 1e-12
        assert frame == 0 or shown.pace.playback[frame - 1] < 0.1 * number
        wanted = np.asarray(painter.picture(frame), int)
        assert np.abs(picture - wanted).mean() < 0.6
        exact = (wanted == picture).all(axis=-1)
        colours |= {tuple(item) for item in picture[exact].reshape(-1, 3)[::7].tolist()}
    assert {tuple(bytes.fromhex(item[1:])) for item in ("#ffffff", *PHASES)} <= colours


@pytest.mark.slow
def test_a_film_of_more_than_two_minutes_is_refused(
    cycle: Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[Path] = []
    monkeypatch.setattr(gif, "_Painter", lambda _shown: None)
    monkeypatch.setattr(gif, "_write", lambda _painter, file: written.append(file))
    short, long = 50.0, 9e4
    while long > 1.001 * short:
        middle = 0.5 * (short + long)
        fits = float(pace(cycle, middle).playback[-1]) < 120.0
        short, long = (middle, long) if fits else (short, middle)
    write_gif(cycle, tmp_path / "a.gif", Look(slow=short))
    assert len(written) == 1
    with pytest.raises(InputError, match=r"takes 120 s, and a GIF at most 120 s; use --slow"):
        write_gif(cycle, tmp_path / "b.gif", Look(slow=long))
    assert [item.name for item in tmp_path.iterdir()] == ["a.gif"]


# Pace.


def test_frames_of_a_film(cycle: Solution) -> None:
    """Thirty a second besides events, at most six thousand; never faster than 1 : 50."""
    events = len({item.t for item in cycle.events})
    for slow in (20.0, 1000.0):
        found = pace(cycle, slow)
        steps = np.diff(found.playback)
        assert steps.max() <= 1.0 / 30.0 + 1e-9
        assert abs(len(found.machine) - 30.0 * found.playback[-1]) < events + 3
        assert found.stretch.min() == pytest.approx(min(slow, 50.0), rel=1e-12)
        assert found.stretch.max() == pytest.approx(slow, rel=1e-12)
    assert 5998 <= len(pace(cycle, 1e5).machine) <= 6000 + events
    plain = pace(cycle, 20.0)
    np.testing.assert_allclose(plain.playback, 20.0 * plain.machine, rtol=1e-12)
    np.testing.assert_allclose(plain.playback_at(cycle.events[3].t), 20.0 * cycle.events[3].t)


# The page.


@pytest.fixture(scope="module")
def page(shown: Film) -> str:
    return scene_page(shown)


def test_surroundings_and_surfaces(page: str) -> None:
    """Neither grid nor axes, a background that fades, and surfaces with two sides."""
    found = re.search(r'<script id="scene"[^>]*>(.*?)</script>', page, re.S)
    assert found is not None
    sent = [umsgpack.unpackb(base64.b64decode(text)) for text in json.loads(found[1])]
    set_to = {
        (item["path"], item["property"]): item["value"]
        for item in sent
        if item["type"] == "set_property"
    }
    assert set(set_to) == {
        ("/Background", "top_color"), ("/Background", "bottom_color"), ("/Grid", "visible"),
        ("/Axes", "visible"),
    }  # fmt: skip
    assert set_to["/Grid", "visible"] is set_to["/Axes", "visible"] is False
    for name in ("top_color", "bottom_color"):
        # Light, so that dark texts can be read on it.
        assert all(0.7 < part <= 1.0 for part in set_to["/Background", name])
    scene = Scene(page)
    for path, item in scene.objects.items():
        (material,) = item["materials"]
        assert material["side"] == 2
        arrow = "/impulse_" in path
        assert material["type"] == ("MeshBasicMaterial" if arrow else "MeshPhongMaterial")
        assert arrow == (scene.colour(path) == tuple(bytes.fromhex(ARROW[1:])))
        assert all(item["type"] != "_meshfile" for item in item["geometries"])
    assert scene.options == {"play": True, "repetitions": math.inf}
    (animation,) = (item for item in sent if item["type"] == "set_animation")
    clips = [item["clip"] for item in animation["animations"]]
    assert {clip["fps"] for clip in clips} == {1}
    # As three.js calls them; one that it does not know ends the whole film.
    kinds = {(track["name"], track["type"]) for clip in clips for track in clip["tracks"]}
    assert kinds == {
        (".position", "vector3"), (".quaternion", "quaternion"), (".scale", "vector3"),
        (".material.color", "color"),
    }  # fmt: skip


def test_a_page_carries_the_licences_of_what_is_in_it(page: str) -> None:
    """In one comment, which nothing in them ends."""
    comment = re.search(r"<!--(.*?)-->", page, re.S)
    assert comment is not None
    viewer = Path(meshcat.__file__).parent / "viewer"
    for file in (viewer / "LICENSE", viewer / "dist" / "main.min.js.LICENSE.txt"):
        assert file.read_text(encoding="utf-8").strip().replace("--", "- -") in comment[1]
    assert "--" not in comment[1]


def test_names_cannot_end_the_script_that_they_stand_in(e62: Any) -> None:
    """The page still holds the whole title, as text."""
    title = "</script><script>alert(1)</script> & co @@scene@@"
    run = simulate(e62, Case(speed_rpm=650.0))
    named = replace(run, mechanism=replace(run.mechanism, title=title))
    text = scene_page(film(named, Look(slow=20.0)))
    found = re.search(r'<script id="film" type="application/json">(.*?)</script>', text, re.S)
    assert found is not None
    assert json.loads(found[1])["title"] == title
    assert "<script>alert" not in text


def test_what_the_note_says(cycle: Solution) -> None:
    """Estimates where the title speaks of them, exaggeration with its factor and limit."""
    plain = "Shapes are illustrations built on the model's dimensions; "
    arrow = "the arrow at a stop is its impulse, in proportion to the largest one."
    estimates = "these dimensions are estimates, not the maker's drawings; "
    assert readings(film(cycle, Look(slow=20.0)))["note"] == plain + estimates + arrow
    other = load("e62", {})
    named = replace(cycle, mechanism=replace(other, title="a comber"))
    assert readings(film(named, Look(slow=20.0, exaggerate=3.0)))["note"] == (
        f"{plain}{arrow} Rebounds of the jaw are drawn 3 times as large, up to 6 deg, and the "
        "other links follow; closing, opening and all numbers are those of the machine."
    )


def test_long_titles_end_before_the_edge(shown: Film) -> None:
    mechanism = replace(shown.solution.mechanism, title="word " * 60)
    long = replace(shown, solution=replace(shown.solution, mechanism=mechanism))
    with pytest.MonkeyPatch.context() as patch:
        pen = Pen(patch)
        _Painter(long)
    title, box, _ = pen.texts[0]
    assert title.endswith("word ...")
    assert 0.8 * SIZE[0] < box[2] <= MACHINE[2]
