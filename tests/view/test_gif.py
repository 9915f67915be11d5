"""The film as a GIF: what each picture says and shows, and what the file is.

Links stand where the solution has them; texts, arrows and bars are those of the figure, and what
they must be is read from the run and from the numbers of the page, which tests of their own
compare with the run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from matplotlib.colors import to_hex, to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle
from PIL import Image, ImageSequence
from runs_shown import turn, with_elements
from snapshots import Words

from nipper_pin import InputError, Mechanism, Solution, load
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.view.scene import Film, Look, film
from nipper_pin.view.scene.gif import MovingSketch, write_gif
from nipper_pin.view.scene.pace import pace
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


def texts(moving: MovingSketch) -> list[tuple[str, Box]]:
    """All texts, each with its left, top, right and bottom [px]."""
    found = [(item.get_text(), item.get_window_extent()) for item in moving.figure.texts]
    return [(text, (box.x0, SIZE[1] - box.y1, box.x1, SIZE[1] - box.y0))
            for text, box in found if text]  # fmt: skip


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


def seen(moving: MovingSketch, frame: int) -> Iterator[str]:
    """Texts and boxes with their colours, and arrows from their feet to their tips [px]."""
    moving.picture(frame)
    for item in moving.figure.texts:
        if item.get_text():
            x, y = np.array(item.get_position()) * SIZE
            yield f"{x:.0f}, {SIZE[1] - y:.0f} {item.get_color()} {item.get_text()!r}"
    for box in moving.figure.artists:
        if isinstance(box, Rectangle):
            (x, y), (right, top) = box.get_bbox().get_points() * SIZE
            ends = f"{x:.0f}..{right:.0f}, {SIZE[1] - top:.0f}..{SIZE[1] - y:.0f}"
            yield f"box {ends} {to_hex(box.get_facecolor())}"
    for corners in arrows(moving):
        foot, tip = 0.5 * (corners[0] + corners[-2]), corners[3]
        yield "arrow " + " to ".join(f"{x:.0f}, {SIZE[1] - z:.0f}" for x, z in (foot, tip))


def test_words_of_pictures(cycle: Solution, words: Words) -> None:
    """The first, those around a collision, whose arrow stays and then shrinks, and the last.

    Of each what differs from the one before. All texts stand inside of the picture, and none on
    another one, on the bar or on the machine.
    """
    shown = film(cycle, Look())
    moving, playback = MovingSketch(shown), shown.pace.playback
    hit = next(hit for hit in cycle.collisions if hit.stop == "jaw")
    at = float(shown.pace.playback_at(hit.t))
    frames = [int(np.searchsorted(playback, at + delay)) for delay in (0.0, 0.58, 0.8, 1.01)]
    told, before = [], list[str]()
    for frame in (0, frames[0] - 1, *frames, len(playback) - 1):
        lines = list(seen(moving, frame))
        told += [f"{playback[frame]:.2f} s of the film",
                 *(f"  {line}" for line in lines
                   if line not in before or line.startswith("arrow"))]  # fmt: skip
        before, found = lines, texts(moving)
        for place, (text, box) in enumerate(found):
            assert min(box) >= 0.0, text
            assert box[2] <= SIZE[0], text
            assert box[3] <= SIZE[1], text
            assert apart(box, BAR), text
            assert box[3] < MACHINE[1] or apart(box, MACHINE), text
            assert all(apart(box, other) for _, other in found[:place]), text
    words("\n".join(told) + "\n")


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


def test_long_titles_end_before_the_edge(shown: Film) -> None:
    mechanism = replace(shown.solution.mechanism, title="word " * 60)
    long = replace(shown, solution=replace(shown.solution, mechanism=mechanism))
    title, box = next(item for item in texts(MovingSketch(long)) if "word" in item[0])
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
