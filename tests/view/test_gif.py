"""The film as a GIF: links stand where the solution has them, and what the file is."""

from __future__ import annotations

import itertools
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Polygon
from PIL import Image, ImageSequence

from nipper_pin import Case, Mechanism, Solution, load, simulate
from nipper_pin.cli import main
from nipper_pin.hybrid.case import Window
from nipper_pin.mechanism import find_model, known_models
from nipper_pin.mechanism.drawing import drawn_mechanism
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.view.phases import ELSEWHERE, phase_colour
from nipper_pin.view.scene import Look, film
from nipper_pin.view.scene.colours import ARROW, channels
from nipper_pin.view.scene.gif import PER_SECOND, MovingSketch, write_gif
from nipper_pin.view.sketch import sketch

BAND = """
[springs.band]
frame_a = "steeve_lower"
frame_b = "frame"
stiffness_N_per_m = 120.0
free_length_mm = 90.0

[stops.jaw]"""


def machine(name: str, folder: Path) -> Mechanism:
    """A model of the package, one of the gallery, or the E62 with a spring between two points."""
    if name in GALLERY:
        return drawn_mechanism(GALLERY[name]())
    if name != "banded":
        return load(name)
    shutil.copytree(find_model("e62"), folder / "e62")
    path = folder / "e62" / "e62.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("[stops.jaw]", BAND, 1), encoding="utf-8")
    return load(folder / "e62")


def turn(mechanism: Mechanism) -> Solution:
    speed = mechanism.cylinder.rated_speed_rpm
    return simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE))


def frames_of(path: Path) -> list[np.ndarray]:
    with Image.open(path) as image:
        return [np.asarray(item.convert("RGB"), int) for item in ImageSequence.Iterator(image)]


def has(picture: np.ndarray, colour: str, box: tuple[slice, slice]) -> int:
    """Pixels of a part of a picture that have a colour, to the step in which Pillow looks up."""
    wanted = np.rint(255.0 * np.array(channels(colour)))
    return int((np.abs(picture[box] - wanted).max(axis=-1) <= 4).sum())


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
    "name", ["e62", "banded", "hanging_pendulum", "peaucellier", "scotch_yoke", "bell"]
)
def test_every_link_stands_where_the_solution_has_it(name: str, tmp_path: Path) -> None:
    """Bars, plates, pins and the ends of springs, by Pinocchio's own kinematics of each frame.

    In frames all along the film every corner of every link stands where the link of the solution
    takes it, every pin of the tree at its joint, and springs between two points end at these.
    """
    mechanism = machine(name, tmp_path)
    shown = film(turn(mechanism), Look(slow=20.0))
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


@pytest.mark.slow
def test_the_file_is_the_film_ten_times_a_second(cycle: Solution, tmp_path: Path) -> None:
    """Pictures, time and size from the file itself; no two pictures of a moving machine are alike.

    Each phase colours both its part of the line below and, while it lasts, the top nipper: the
    colour is looked for where only the machine is drawn.
    """
    look = Look(slow=100.0, exaggerate=10.0)
    path = write_gif(cycle, tmp_path / "film.gif", look)
    shown = film(cycle, look)
    with Image.open(path) as image:
        assert image.format == "GIF"
        assert image.size == (800, 560)
        assert image.info["duration"] == 1000 // PER_SECOND
        assert image.info["loop"] == 0
    pictures = frames_of(path)
    times = np.arange(0.0, shown.pace.playback[-1], 1.0 / PER_SECOND)
    assert len(pictures) == len(times) > 20
    assert all((one != two).any() for one, two in itertools.pairwise(pictures))
    assert path.stat().st_size < 3_000_000
    machine, line = np.s_[60:465, 290:790], np.s_[481:491, 16:784]
    mechanism = cycle.mechanism
    every = {phase_colour(mechanism, item.closed) for item in mechanism.phases} | {ELSEWHERE}
    assert len(every) == 4
    jaw = [hit.t for hit in cycle.collisions if hit.stop == "jaw"]
    own = np.searchsorted(shown.pace.playback, times)
    shows = set()
    for picture, frame in zip(pictures, own, strict=True):
        item = cycle.phases[shown.phase[frame]]
        phase = phase_colour(mechanism, item.closed)
        if not item.closed and not any(item.t_start <= t < item.t_end for t in jaw):
            phase = ELSEWHERE
        own_pixels = has(picture, phase, machine)
        assert own_pixels > 400
        # Where it ends, its colour fades into others.
        assert all(has(picture, other, machine) < 0.05 * own_pixels for other in every - {phase})
        assert all(has(picture, colour, line) > 20 for colour in every)
        shows.add(phase)
    assert shows == every


@pytest.mark.slow
def test_exaggeration_and_slow_motion_are_those_of_the_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """By the command: twice as slow has about twice as many pictures, a larger gap others."""
    sizes, openings, machine = [], [], np.s_[60:465, 290:790]
    for slow, exaggerate in (("500", "1"), ("1000", "1"), ("500", "10")):
        path = tmp_path / f"{slow}_{exaggerate}.gif"
        arguments = ["--window", "transition", "--slow", slow, "--exaggerate", exaggerate]
        assert main(["view", *arguments, "--gif", str(path)]) == 0
        pictures = frames_of(path)
        sizes.append(len(pictures))
        openings.append(pictures[len(pictures) // 3][machine])
        # The crosses of the stops have that colour all the time.
        crosses = min(has(picture, ARROW, machine) for picture in pictures)
        # The impulse of the first collision opens the film; those that close it have less than a
        # tenth of it. The length of an arrow goes with the impulse, its width with the root.
        largest = has(pictures[1], ARROW, machine) - crosses
        assert crosses < 200
        assert largest > 500
        assert has(pictures[-1], ARROW, machine) - crosses < 0.1**1.5 * largest
    assert capsys.readouterr().out == ""
    assert sizes[1] == pytest.approx(2 * sizes[0], abs=2)
    assert sizes[2] == sizes[0]
    assert (np.abs(openings[0] - openings[2]).max(axis=-1) > 60).sum() > 50


@pytest.mark.slow
@pytest.mark.parametrize("model", known_models())
def test_every_model_of_the_package_can_be_filmed(model: str, tmp_path: Path) -> None:
    path = write_gif(turn(load(model)), tmp_path / f"{model}.gif", Look(slow=20.0))
    pictures = frames_of(path)
    ink = [(picture[60:465, 290:790] < 230).any(axis=-1).mean() for picture in pictures]
    assert len(pictures) > 5
    assert min(ink) > 0.02


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--gif", "/nowhere/at/all.gif"], "cannot be written"),
        (["--gif", "{folder}"], "cannot be written"),
        (["--slow", "1e5", "--gif", "{folder}/long.gif"], "--slow"),
    ],
)
def test_what_cannot_be_written_is_one_sentence_and_leaves_nothing(
    arguments: list[str], sentence: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [item.format(folder=tmp_path) for item in arguments]
    assert main(["view", "--window", "transition", *given]) == 2
    assert sentence in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_damaged_mesh_is_one_sentence_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    model, path = tmp_path / "e62", tmp_path / "film.gif"
    shutil.copytree(find_model("e62"), model)
    (model / "meshes" / "top_lip.stl").write_bytes(b"no mesh")
    assert main(["view", str(model), "--window", "transition", "--gif", str(path)]) == 2
    said = capsys.readouterr().err
    assert "top_lip.stl: the mesh cannot be read" in said
    assert said.count("\n") == 1
    assert list(tmp_path.iterdir()) == [model]


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
