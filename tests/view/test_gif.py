"""The film as a GIF: what each picture says and shows, and what the file is.

Links stand where the solution has them; texts, arrows and bars are those of the figure, and what
they must be is read from the run and from the numbers of the page, which tests of their own
compare with the run.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from matplotlib.colors import to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon
from PIL import Image, ImageSequence
from runs_shown import turn, with_elements

from nipper_pin import InputError, Mechanism, Solution, load
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.view.scene import Film, Look, film
from nipper_pin.view.scene.gif import MovingSketch, write_gif
from nipper_pin.view.scene.pace import pace
from nipper_pin.view.scene.readings import readings
from nipper_pin.view.sketch import sketch

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


def machine(name: str) -> Mechanism:
    """A model of the package, one of the gallery, or the E62 with springs between two points."""
    if name in GALLERY:
        return drawn_mechanism(GALLERY[name]())
    return with_elements() if name == "elements" else load(name)


def drawn_at(artist: Any) -> np.ndarray:
    """Corners of a patch or points of a line on the figure [px]; of a circle its middle."""
    if isinstance(artist, Line2D):
        return np.asarray(artist.get_transform().transform(artist.get_xydata()))
    if isinstance(artist, Circle):
        moved = artist.get_transform().transform_path(artist.get_path())
        low, high = moved.get_extents().min, moved.get_extents().max
        return 0.5 * (np.asarray(low) + np.asarray(high))[None]
    return np.asarray(artist.get_transform().transform(artist.get_xy()))


@pytest.mark.parametrize(
    "name", ["e62", "elements", "hanging_pendulum", "peaucellier", "scotch_yoke", "bell"]
)
def test_every_link_stands_where_the_solution_has_it(name: str) -> None:
    """Bars, plates, pins and the ends of springs, by Pinocchio's own kinematics of each frame.

    In frames all along the film every corner of every link stands where the link of the solution
    takes it, every pin of the tree at its joint, and springs between two points end at these. Gaps
    of the E62 are drawn larger.
    """
    mechanism = machine(name)
    look = Look(slow=20.0, exaggerate=10.0 if name in ("e62", "elements") else 1.0)
    shown = film(turn(mechanism, mechanism.cylinder.rated_speed_rpm, 24.0), look)
    moving = MovingSketch(shown)
    axes = moving.figure.axes[0]
    still, model = sketch(mechanism), mechanism.model
    data, rest = model.createData(), model.createData()
    pin.framesForwardKinematics(model, rest, np.zeros(model.nq))
    joints = [model.getJointId(joint.name) for joint in mechanism.joints]
    shapes = [patch for patch in axes.patches if isinstance(patch, Polygon)]
    circles = [patch for patch in axes.patches if isinstance(patch, Circle)]
    coils = [line for line in axes.lines if len(np.asarray(line.get_xydata())) == 14]
    travel = 0.0
    for frame in moving.frames[:: max(1, len(moving.frames) // 9)]:
        moving.picture(int(frame))
        pin.framesForwardKinematics(model, data, shown.drawn[frame])
        place = axes.transData.transform
        for link, shape in zip(still.links, shapes, strict=False):
            joint = joints[link.body]
            moved = data.oMi[joint] * rest.oMi[joint].inverse()
            across = np.insert(link.points, 1, rest.oMi[joint].translation[1], axis=1)
            wanted = place([1e3 * moved.act(point)[[0, 2]] for point in across])
            found = drawn_at(shape)
            off = np.linalg.norm(found[:, None] - wanted[None], axis=-1).min(axis=1)
            assert off.max() < 1e-3, link.name
            travel = max(travel, float(np.abs(wanted - place(1e3 * link.points)).max()))
        seen = np.concatenate([drawn_at(circle) for circle in circles])
        for joint in mechanism.joints:
            at = place(1e3 * data.oMi[model.getJointId(joint.name)].translation[[0, 2]])
            if joint.kind == "revolute":
                assert np.linalg.norm(seen - at, axis=1).min() < 1e-3, joint.name
        for strut in mechanism.struts:
            ends = [place(1e3 * data.oMf[model.getFrameId(end)].translation[[0, 2]])
                    for end in (strut.frame_a, strut.frame_b)]  # fmt: skip
            assert min(
                float(np.abs(drawn_at(coil)[[0, -1]] - ends).max()) for coil in coils
            ) < 1e-3, strut.name  # fmt: skip
    assert travel > 20.0


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


def test_arrows_shrink_after_a_while(cycle: Solution) -> None:
    """Whole for 0.6 s after a collision, then evenly less until nothing is left after 1 s."""
    hits, shown = cycle.collisions, film(cycle, Look())
    moving = MovingSketch(shown)
    at = np.interp([hit.t for hit in hits], shown.pace.machine, shown.pace.playback)
    # Of these no other arrow is there; smaller ones are wider than long.
    lone = [
        k for k, hit in enumerate(hits[:-1])
        if (k == 0 or at[k] > at[k - 1] + 1.1) and at[k + 1] > at[k] + 1.2
        and hit.impulse > 0.04 * max(item.impulse for item in hits)
    ]  # fmt: skip
    assert {hits[k].stop for k in lone} == {"jaw", "steeve"}
    units = []
    for k in lone:
        for delay in (0.02, 0.55, 0.7, 0.8, 0.95, 1.05):
            frame = int(np.searchsorted(shown.pace.playback, at[k] + delay))
            moving.picture(frame)
            gone = float(shown.pace.playback[frame]) - at[k]
            left = min(1.0, max(0.0, (1.0 - gone) / 0.4))
            found = arrows(moving)
            assert len(found) == (left > 0.0)
            for points in found:
                foot = 0.5 * (points[0] + points[-2])
                length = np.linalg.norm(points - foot, axis=1).max()
                units.append(length / (left * hits[k].impulse))
    assert len(units) >= 10
    np.testing.assert_allclose(units, units[0], rtol=1e-6)


def test_long_titles_end_before_the_edge(shown: Film) -> None:
    mechanism = replace(shown.solution.mechanism, title="word " * 60)
    long = replace(shown, solution=replace(shown.solution, mechanism=mechanism))
    title, box, _ = next(item for item in texts(MovingSketch(long)) if "word" in item[0])
    assert title.endswith("word ...")
    assert 0.8 * SIZE[0] < box[2] <= MACHINE[2]


# The file.


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


def test_a_film_of_more_than_two_minutes_is_refused(cycle: Solution, tmp_path: Path) -> None:
    short, long = 50.0, 9e4
    while long > 1.001 * short:
        middle = 0.5 * (short + long)
        fits = float(pace(cycle, middle).playback[-1]) < 120.0
        short, long = (middle, long) if fits else (short, middle)
    with pytest.raises(InputError, match=r"takes 120 s, and a GIF at most 120 s; use --slow"):
        write_gif(cycle, tmp_path / "b.gif", Look(slow=long))
    assert list(tmp_path.iterdir()) == []


def test_a_film_that_fails_leaves_the_file_that_was_there(
    cycle: Solution, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "film.gif"
    path.write_bytes(b"what was there")

    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Image.Image, "save", full)
    with pytest.raises(Exception, match="No space left"):
        write_gif(cycle, path, Look(slow=20.0))
    assert path.read_bytes() == b"what was there"
    assert list(tmp_path.iterdir()) == [path]
