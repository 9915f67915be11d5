"""The film of a run: its pace, its frames, gaps that are drawn larger, and the film as a GIF."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from matplotlib.colors import to_hex, to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon, Rectangle
from matplotlib.transforms import Bbox, BboxBase
from PIL import Image, ImageSequence
from runs_shown import machine_called, run_of, turn
from snapshots import Words

from nipper_pin import Case, InputError, SingularConfigurationError, Solution, load, simulate
from nipper_pin.view.scene import Film, Look, film, solids
from nipper_pin.view.scene.film import rebound_flights
from nipper_pin.view.scene.gif import MovingSketch, write_gif
from nipper_pin.view.scene.objects import animation
from nipper_pin.view.scene.pace import pace
from nipper_pin.view.scene.readings import readings
from nipper_pin.view.sketch import sketch

MODELS = Path(__file__).parents[1] / "verification" / "models"


@pytest.fixture(scope="module")
def large(cycle: Solution) -> Film:
    return film(cycle, Look(exaggerate=50.0))


# Pace.


@pytest.mark.parametrize("name", ["e62", "boxed"])
def test_time_is_stretched_around_groups_of_events_and_nowhere_else(name: str) -> None:
    """800 from 1 % of a turn before the first to as long after the last, with flanks of 1 %.

    Events less than 7 % of a turn apart are one group. A flank has 16 steps of one ratio, so that a
    step is off by at most half of what the ratio is above 1.
    """
    run, slow = run_of(name), 800.0
    found = pace(run, slow)
    events = np.array([event.t for event in run.events])
    assert set(events) <= set(found.machine)
    assert (found.machine[0], found.machine[-1]) == (0.0, run.segments[-1].t_end)
    assert (np.diff(found.machine) > 0.0).all()
    # From frame to frame the two clocks advance by the stretch in between.
    rate = np.diff(found.playback) / np.diff(found.machine)
    low, high = (f(found.stretch[1:], found.stretch[:-1]) for f in (np.minimum, np.maximum))
    assert (rate > low * (1.0 - 1e-6)).all()
    assert (rate < high * (1.0 + 1e-6)).all()
    marks = np.array([-np.inf, *events, np.inf])
    after = np.searchsorted(marks, found.machine, side="right")
    gone, left = found.machine - marks[after - 1], marks[np.minimum(after, len(marks) - 1)]
    gone, left = gone / run.shaft.period, (left - found.machine) / run.shaft.period
    away = np.where(gone + left < 0.07, 0.0, np.minimum(gone, left))
    wanted = 50.0 * 16.0 ** np.clip(2.0 - away / 0.01, 0.0, 1.0)
    step = 0.5 * (16.0 ** (1.0 / 16.0) - 1.0)
    np.testing.assert_allclose(found.stretch, wanted, rtol=step * (1.0 + 1e-9))
    flank = (away > 0.0099) & (away < 0.0201)
    np.testing.assert_allclose(found.stretch[~flank], wanted[~flank], rtol=1e-9)
    assert np.count_nonzero(flank) > 20


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


def test_of_many_turns_the_first_two_are_shown(many_turns: Solution) -> None:
    shown = film(many_turns, Look(exaggerate=1.0))
    assert shown.pace.machine[-1] == pytest.approx(2.0 * many_turns.shaft.period, rel=1e-12)
    document = readings(shown)
    assert document["phases"][-1]["start"] < document["duration"]
    assert document["collisions"][-1]["at"] < document["duration"]
    for clip in animation(shown, solids(many_turns.mechanism))["animations"]:
        for found in clip["clip"]["tracks"]:
            t = np.frombuffer(found["times"].data, dtype="<f4")
            # All tracks end together, or the film would come apart when it starts again.
            assert t[-1] == pytest.approx(document["duration"], rel=1e-6)
            assert (np.diff(t) >= 0.0).all()


# Gaps that are drawn larger.


def test_an_exaggerated_gap_keeps_the_loops_closed(cycle: Solution, large: Film) -> None:
    """Only the loops' other coordinates follow; frames of the cut joints meet to round-off."""
    mechanism = cycle.mechanism
    model, data = mechanism.model, mechanism.model.createData()
    jaw = mechanism.stop("jaw").index
    gap, t = large.q[:, jaw], large.pace.machine
    larger = np.ones(len(gap))
    for hit in cycle.collisions:
        if hit.stop == "jaw" and hit.rebound_time is not None:
            inside = (t >= hit.t) & (t <= hit.t + hit.rebound_time)
            larger[inside] = min(50.0, math.radians(6.0) / hit.rebound_amplitude)
    drawn = large.drawn[:, jaw]
    np.testing.assert_allclose(drawn, larger * gap, rtol=1e-12, atol=1e-16)
    # Rebounds reach the limit; closing and opening are drawn as they are, without a jump.
    first = next(hit for hit in cycle.collisions if hit.stop == "jaw")
    assert drawn[(t > first.t) & (t < first.t + first.rebound_time)].max() > math.radians(5.9)
    np.testing.assert_array_equal(drawn[t < first.t], gap[t < first.t])
    for drive in mechanism.drives:
        np.testing.assert_array_equal(large.drawn[:, drive.index], large.q[:, drive.index])
    for k in range(0, len(gap), 20):
        pin.framesForwardKinematics(model, data, large.drawn[k])
        for closure in mechanism.closures:
            a, b = (
                data.oMf[model.getFrameId(name)].translation
                for name in (closure.frame_a, closure.frame_b)
            )
            assert np.abs(a - b)[[0, 2]].max() < 1e-14
    assert film(cycle, Look(exaggerate=1.0)).drawn is not large.drawn


def test_an_exaggerated_gap_opens_away_from_its_stop() -> None:
    """Drawn five times as large, gaps of an upper stop grow downwards from the stop's place."""
    run = run_of("boxed")
    plain, large = film(run, Look(exaggerate=1.0)), film(run, Look(exaggerate=5.0))
    floor, t = run.mechanism.stop("floor"), plain.pace.machine
    assert floor.sense < 0.0
    gap, drawn = floor.gaps(plain.drawn), floor.gaps(large.drawn)
    back = [hit for hit in run.collisions if hit.stop == "floor" and hit.rebound_amplitude]
    small = [hit for hit in back if 5.0 * hit.rebound_amplitude < 0.03 * run.mechanism.reach_m]
    for hit in small[:2]:
        rebound = (t >= hit.t) & (t <= hit.t + hit.rebound_time)
        assert gap[rebound].max() > 0.9 * hit.rebound_amplitude
        assert drawn[rebound] == pytest.approx(5.0 * gap[rebound], rel=1e-9, abs=1e-15)
    assert len(small) > 2
    assert drawn.min() >= -1e-15


def test_the_heights_drawn_larger_are_those_of_the_transition_stop() -> None:
    """Of two balls that fall from one height and are struck together, that of its own floor."""
    both = run_of("balls")
    e_N = both.mechanism.stop(both.mechanism.transition_stop).restitution
    assert rebound_flights(both)[0].highest == pytest.approx(e_N**2 * 0.1, rel=1e-12)


# What is refused.


@pytest.mark.parametrize("values", [{"slow": 1.0}, {"slow": 1e5}, {"exaggerate": 1000.0}])
def test_looks_up_to_their_ends(values: dict[str, float]) -> None:
    assert Look(**values)
    with pytest.raises(InputError, match=r"cannot be used: 1 to 1000(00)?$"):
        Look(**{key: 1.001 * value if value > 1.0 else 0.999 for key, value in values.items()})


@pytest.mark.parametrize(("run", "larger", "words"), [
    (lambda: simulate(load("e62", {"stops.jaw.restitution": 0.0}), Case(speed_rpm=450.0)), 1.0,
     "no motion to show"),
    (lambda: turn(load(MODELS / "four_bar"), 300.0), 2.0, "no transition stop"),
])  # fmt: skip
def test_runs_that_cannot_be_shown(run: Callable[[], Solution], larger: float, words: str) -> None:
    with pytest.raises(InputError, match=words):
        film(run(), Look(exaggerate=larger))


def test_loops_that_do_not_close_cannot_be_exaggerated(
    transition: Solution, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(*_: object) -> None:
        message = "a dead centre"
        raise SingularConfigurationError(message)

    monkeypatch.setattr(sys.modules["nipper_pin.view.scene.film"], "close_positions", fails)
    words = r"gap of stop jaw cannot be drawn 12 times as large, .*\(a dead centre\); use a smaller"
    with pytest.raises(InputError, match=words) as caught:
        film(transition, Look(exaggerate=12.0))
    assert caught.value.evidence == {"exaggerate": 12.0}


# The film as a GIF: texts, arrows and bars are those of the figure, and what they must be is read
# from the run and from the numbers of the page, which tests of their own compare with the run.

ARROW = "#D55E00"
PHASES = ("#F0E442", "#56B4E9", "#E69F00")
# The picture, and in it the machine and the bar [px], from the lower left corner.
SIZE = (800, 560)
MACHINE, BAR = Bbox([[290, 94], [792, 500]]), Bbox([[16, 68], [784, 80]])


def texts(moving: MovingSketch) -> list[tuple[str, BboxBase]]:
    """All texts, each with where it stands [px]."""
    found = moving.figure.texts
    return [(item.get_text(), item.get_window_extent()) for item in found if item.get_text()]


def arrows(moving: MovingSketch) -> list[np.ndarray]:
    """Corners of the arrows that are seen [px]."""
    return [
        patch.get_transform().transform(patch.get_xy())
        for patch in moving.figure.axes[0].patches
        if isinstance(patch, Polygon) and patch.get_visible()
        and patch.get_facecolor() == to_rgba(ARROW)
    ]  # fmt: skip


def drawn_at(artist: Any) -> np.ndarray:
    """Corners of a patch or points of a line on the figure [px]; of a circle its middle."""
    if isinstance(artist, Circle):
        box = artist.get_transform().transform_path(artist.get_path()).get_extents()
        return 0.5 * (box.min + box.max)[None]
    points = artist.get_xydata() if isinstance(artist, Line2D) else artist.get_xy()
    return np.asarray(artist.get_transform().transform(points))


@pytest.mark.parametrize(
    "name", ["e62", "elements", "hanging_pendulum", "peaucellier", "scotch_yoke", "bell"]
)
def test_every_link_stands_where_the_solution_has_it(name: str) -> None:
    """Bars, plates, pins and the ends of springs, by Pinocchio's own kinematics of each frame.

    In frames all along the film every corner of every link stands where the link of the solution
    takes it, every pin of the tree at its joint, and springs between two points end at these. Gaps
    of the E62 are drawn larger. With one scale, z upwards, the motion reaches opposite sides of the
    machine's part of the picture, but for the room of symbols, and nothing leaves it.
    """
    mechanism = machine_called(name)
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
    x, z = axes.transData.transform([(1.0, 0.0), (0.0, 1.0)]) - axes.transData.transform((0, 0))
    np.testing.assert_allclose([x[1], z[0], z[1]], [0.0, 0.0, x[0]], rtol=1e-9, atol=1e-9)
    assert x[0] > 0.0
    travel, reached = 0.0, []
    for frame in moving.frames[:: max(1, len(moving.frames) // 9)]:
        moving.picture(int(frame))
        pin.framesForwardKinematics(model, data, shown.drawn[frame])
        place = axes.transData.transform
        for part, shape in zip(still.links, shapes, strict=False):
            joint = joints[part.body]
            moved = data.oMi[joint] * rest.oMi[joint].inverse()
            across = np.insert(part.points, 1, rest.oMi[joint].translation[1], axis=1)
            wanted = place([1e3 * moved.act(point)[[0, 2]] for point in across])
            found = drawn_at(shape)
            reached.append(found)
            off = np.linalg.norm(found[:, None] - wanted[None], axis=-1).min(axis=1)
            assert off.max() < 1e-3, part.name
            travel = max(travel, float(np.abs(wanted - place(1e3 * part.points)).max()))
        seen = np.concatenate([drawn_at(circle) for circle in circles])
        reached.append(seen)
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
    low, high = (ends(np.concatenate(reached), axis=0) for ends in (np.min, np.max))
    assert (low >= MACHINE.min).all()
    assert (high <= MACHINE.max).all()
    assert max((high - low) / MACHINE.size) > 0.7


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
    shown = film(cycle, Look(exaggerate=1.0))
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
            assert (box.min >= 0.0).all(), text
            assert (box.max <= SIZE).all(), text
            others = [BAR, MACHINE, *(other for _, other in found[:place])]
            assert box.count_overlaps(others) == 0, text
    words("\n".join(told) + "\n")


def test_long_titles_end_before_the_edge(cycle: Solution) -> None:
    long = replace(cycle, mechanism=replace(cycle.mechanism, title="word " * 60))
    moving = MovingSketch(film(long, Look(slow=100.0)))
    title, box = next(item for item in texts(moving) if "word" in item[0])
    assert title.endswith("word ...")
    assert 0.8 * SIZE[0] < box.x1 <= MACHINE.x1


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
