"""What each picture of a GIF says and shows, the pace of a film, and what a page is made of.

Texts, arrows and bars are those of the figure; what they must be is read from the run and from the
numbers of the page, which tests of their own compare with the run.
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
from matplotlib.colors import to_rgba
from matplotlib.patches import Polygon
from PIL import Image, ImageSequence
from three_js import Scene

from nipper_pin import Case, InputError, Solution, load, simulate
from nipper_pin.view.scene import Film, Look, film, gif
from nipper_pin.view.scene.gif import MovingSketch, write_gif
from nipper_pin.view.scene.pace import _profile, pace
from nipper_pin.view.scene.page import scene_page
from nipper_pin.view.scene.readings import readings

ARROW = "#D55E00"
PHASES = ("#F0E442", "#56B4E9", "#E69F00")
# Of phases without closed stops in which the jaw does not bounce.
ELSEWHERE = "#F7F0B5"
SIZE, MACHINE, BAR = (800, 560), (290, 60, 792, 466), (16, 480, 784, 492)
LIPS = (16, 308, 272, 462)


@pytest.fixture(scope="module")
def shown(cycle: Solution) -> Film:
    return film(cycle, Look(slow=100.0))


@pytest.fixture(scope="module")
def moving(shown: Film) -> MovingSketch:
    return MovingSketch(shown)


Box = tuple[float, ...]


def texts(moving: MovingSketch) -> list[tuple[str, Box, Any]]:
    """All texts, each with its left, top, right and bottom [px] and its colour."""
    found = []
    for item in moving.figure.texts:
        box = item.get_window_extent()
        ends = (box.x0, SIZE[1] - box.y1, box.x1, SIZE[1] - box.y0)
        if item.get_text():
            found.append((item.get_text(), ends, item.get_color()))
    return found


def arrows(moving: MovingSketch) -> list[np.ndarray]:
    """Corners of the arrows that are seen [px]."""
    return [
        patch.get_transform().transform(patch.get_xy())
        for patch in moving.figure.axes[0].patches
        if isinstance(patch, Polygon) and patch.get_visible()
        and patch.get_facecolor() == to_rgba(ARROW)
    ]  # fmt: skip


def apart(one: Box, other: Box) -> bool:
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


def test_texts_of_a_picture(shown: Film, moving: MovingSketch) -> None:
    """Title, case and note on all; phase, numbers with units, and the last collision by frame.

    All stand inside of the picture, below one another, and none on another or on the machine.
    """
    said: Any = readings(shown)
    for frame in moving.frames[:: len(moving.frames) // 4]:
        moving.picture(int(frame))
        found = texts(moving)
        words = [" ".join(text.split()) for text, *_ in found]
        boxes = dict(zip(words, (box for _, box, _ in found), strict=True))
        common = [said["title"], "650 r/min, window cycle (1 turn from index 24), held drive"]
        caption = "jaw cut along its hinge; bar 2 mm"
        phase = said["phases"][said["phase_of_frame"][frame]]["name"]
        assert {*common, said["note"], caption, phase} <= set(words)
        title, case = (boxes[text] for text in common)
        assert title[3] < case[1] < case[3] < MACHINE[1]
        assert boxes[said["note"]][1] > BAR[3]
        assert LIPS[3] <= boxes[caption][1] < boxes[caption][3] <= BAR[1] - 3
        ends = []
        for column in said["columns"]:
            left = boxes[column["label"]]
            (right, value) = next(
                (box, text) for text, box in boxes.items()
                if abs(box[1] - left[1]) < 6.0 and left[2] < box[0] < MACHINE[0]
            )  # fmt: skip
            digits, _, unit = value.partition(" ")
            assert float(digits) == pytest.approx(column["values"][frame], rel=6e-4)
            assert unit == column["unit"]
            ends.append(right[2])
        # Values end below one another.
        assert np.ptp(ends) < 2.0
        now = float(shown.pace.playback[frame])
        done = [item["text"] for item in said["collisions"] if item["at"] <= now]
        last = [text for text, (_, _, fill) in zip(words, found, strict=True) if fill == ARROW]
        assert last == done[-1:]
        for place, (text, box, _) in enumerate(found):
            assert min(box) >= 0.0, text
            assert box[2] <= SIZE[0], text
            assert box[3] <= SIZE[1], text
            assert apart(box, BAR), text
            assert text in common or apart(box, MACHINE), text
            assert all(apart(box, other) for _, other, _ in found[:place]), text


def test_a_collision_is_told_from_its_own_frame_on(shown: Film, moving: MovingSketch) -> None:
    """Not before it, and the last of several."""
    hit = shown.solution.collisions[0]
    at = int(np.searchsorted(shown.pace.machine, hit.t))
    for frame, told in ((at - 1, False), (at, True)):
        moving.picture(frame)
        assert any(f"collision {hit.number} " in text for text, *_ in texts(moving)) == told


def test_the_machine_fills_its_part_of_the_picture(moving: MovingSketch) -> None:
    """One scale, z upwards; the motion reaches opposite sides but for the room of symbols."""
    axes = moving.figure.axes[0]
    x, z = axes.transData.transform([(1.0, 0.0), (0.0, 1.0)]) - axes.transData.transform((0, 0))
    assert x[0] == pytest.approx(z[1], rel=1e-9)
    assert x[0] > 0.0
    assert abs(x[1]) + abs(z[0]) < 1e-9
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for frame in moving.frames:
        moving.picture(int(frame))
        for patch in axes.patches:
            if isinstance(patch, Polygon) and patch.get_facecolor() != to_rgba(ARROW):
                corners = patch.get_transform().transform(patch.get_xy())
                low, high = (
                    np.minimum(low, corners.min(axis=0)),
                    np.maximum(high, corners.max(axis=0)),
                )
    left, top, right, bottom = MACHINE
    assert (low >= (left, SIZE[1] - bottom)).all()
    assert (high <= (right, SIZE[1] - top)).all()
    # The circle of the crank is part of the machine, too.
    assert max((high - low) / (right - left, bottom - top)) > 0.7


def test_bar_and_mark_of_a_picture(shown: Film, moving: MovingSketch) -> None:
    """The phases along the film by their colours, and where the film is."""
    said: Any = readings(shown)
    left, top, right, bottom = BAR
    starts = [item["start"] / said["duration"] for item in said["phases"]]
    for frame in moving.frames[:: len(moving.frames) // 5]:
        picture = np.asarray(moving.picture(int(frame)), int)
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
    moving = MovingSketch(shown)
    at = np.interp([item.t for item in hits], shown.pace.machine, shown.pace.playback)
    largest = max(item.impulse for item in hits)
    lengths: dict[str, list[tuple[float, float]]] = {}
    lone = [k for k in range(len(hits) - 1) if at[k + 1] > at[k] + 1.2]
    assert len(lone) >= 2
    later = [at[k] + delay for k in lone for delay in (0.02, 0.55, 0.7, 0.8, 0.95, 1.05)]
    for frame in np.searchsorted(shown.pace.playback, later):
        moving.picture(int(frame))
        found = arrows(moving)
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
            foot = 0.5 * (points[0] + points[-2])
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
    moving = MovingSketch(shown)
    with Image.open(path) as image:
        assert (image.format, image.size) == ("GIF", SIZE)
        assert (image.info["duration"], image.info["loop"]) == (100, 0)
        found = [np.asarray(item.convert("RGB"), int) for item in ImageSequence.Iterator(image)]
    length = float(shown.pace.playback[-1])
    assert len(found) == math.ceil(10.0 * length)
    for number, picture in enumerate(found):
        frame = int(moving.frames[number])
        # The first frame that is not before its time.
        assert shown.pace.playback[frame] >= 0.1 * number - 1e-12
        assert frame == 0 or shown.pace.playback[frame - 1] < 0.1 * number
        wanted = np.asarray(moving.picture(frame), int)
        assert np.abs(picture - wanted).mean() < 2.0
        for colour in ("#ffffff", ARROW, *PHASES):
            exact = list(bytes.fromhex(colour[1:]))
            assert np.abs(picture[(wanted == exact).all(axis=-1)] - exact).max(initial=0) <= 1


@pytest.mark.slow
def test_a_film_of_more_than_two_minutes_is_refused(
    cycle: Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written: list[Path] = []
    monkeypatch.setattr(gif, "_write", lambda _shown, file: written.append(file))
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
    title, box, _ = next(item for item in texts(MovingSketch(long)) if "word" in item[0])
    assert title.endswith("word ...")
    assert 0.8 * SIZE[0] < box[2] <= MACHINE[2]
