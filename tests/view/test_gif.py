"""The film as a GIF: what is seen of solids from the side, and the file."""

from __future__ import annotations

import itertools
import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image, ImageSequence
from shapely import Polygon
from shapely.ops import unary_union

from nipper_pin import Case, Solution, load, simulate
from nipper_pin.cli import main
from nipper_pin.hybrid.case import Window
from nipper_pin.mechanism import find_model, known_models
from nipper_pin.view.phases import ELSEWHERE, phase_colour
from nipper_pin.view.scene import Film, Look, film
from nipper_pin.view.scene.colours import ARROW, channels
from nipper_pin.view.scene.flat import Flat, flat, moved
from nipper_pin.view.scene.gif import PER_SECOND, write_gif
from nipper_pin.view.scene.solids import CYLINDER, Solid, cylinder_axis, solids


@pytest.fixture(scope="module")
def shown(cycle: Solution) -> Film:
    return film(cycle, Look(slow=100.0, exaggerate=10.0))


@pytest.fixture(scope="module")
def drawn(shown: Film) -> tuple[Solid, ...]:
    return solids(shown.solution.mechanism)


@pytest.fixture(scope="module")
def seen(shown: Film, drawn: tuple[Solid, ...]) -> Flat:
    return flat(shown, drawn)


def faces_of(seen: Flat, place: int) -> list[tuple[int, ...]]:
    """Faces of one solid, without its edges."""
    rows = zip(seen.items, seen.solid, strict=True)
    return [item for item, solid in rows if solid == place and len(item) == 3]


def frames_of(path: Path) -> list[np.ndarray]:
    with Image.open(path) as image:
        return [np.asarray(item.convert("RGB"), int) for item in ImageSequence.Iterator(image)]


def has(picture: np.ndarray, colour: str, box: tuple[slice, slice]) -> int:
    """Pixels of a part of a picture that have a colour, to the step in which Pillow looks up."""
    wanted = np.rint(255.0 * np.array(channels(colour)))
    return int((np.abs(picture[box] - wanted).max(axis=-1) <= 4).sum())


def test_corners_stand_where_pinocchio_puts_the_links(
    shown: Film, drawn: tuple[Solid, ...], seen: Flat
) -> None:
    """trimesh reads and places each mesh itself, in three dimensions, in frames of all phases.

    Files hold single precision, 2^-24 of 0.3 m, of which two readings may keep 1e-9 m; a link
    forgotten or turned the wrong way would miss by its whole motion, which is centimetres.
    """
    mechanism, body = shown.solution.mechanism, shown.solution.system.body
    axis = cylinder_axis(mechanism)
    assert axis is not None
    ends = np.array(axis)
    for frame in range(0, len(shown.q), len(shown.q) // 7):
        found = moved(seen, shown, frame)
        placements = body.placements(shown.drawn[frame])
        for place, solid in enumerate(drawn):
            points = np.asarray(trimesh.load_mesh(solid.path).vertices, dtype=float)
            scale = solid.scale.copy()
            if solid.spring is not None:
                scale[2] -= shown.drawn[frame, solid.spring]
            points = (points * scale) @ solid.placement[:3, :3].T + solid.placement[:3, 3]
            if solid.body >= 0:
                link = placements[solid.body]
                points = points @ link.rotation.T + link.translation
            flat_points = points[:, [0, 2]]
            if solid.body == CYLINDER:
                c, s = np.cos(shown.turned[frame]), np.sin(shown.turned[frame])
                flat_points = (flat_points - ends) @ np.array([[c, s], [-s, c]]) + ends
            used = sorted({corner for item in faces_of(seen, place) for corner in item})
            distance = np.linalg.norm(found[used][:, None] - flat_points[None], axis=-1)
            assert distance.min(axis=1).max() < 2e-8, solid.name


def test_faces_cover_what_the_eye_sees_of_a_solid(drawn: tuple[Solid, ...], seen: Flat) -> None:
    """The shadow of a closed body is that of the half of its faces that look at the eye.

    The shadow is that of all faces of the mesh as trimesh reads it, whichever way they look. Only
    of the thin wires of the springs do the faces that are seen from their edge leave a strip, of
    less than two parts in a thousand; a missing half of a plate, a hole that is filled or a side
    taken for the other changes far more.
    """
    for place, solid in enumerate(drawn):
        mesh = trimesh.load_mesh(solid.path)
        points = (mesh.vertices * solid.scale) @ solid.placement[:3, :3].T
        shadow = unary_union([Polygon(points[item][:, [0, 2]]) for item in mesh.faces])
        covered = unary_union([Polygon(seen.points[list(item)]) for item in faces_of(seen, place)])
        assert covered.area == pytest.approx(shadow.area, rel=2e-3), solid.name


def test_near_things_are_drawn_after_far_ones(drawn: tuple[Solid, ...], seen: Flat) -> None:
    """The wall stands behind everything, the front rocker's pins and arms before the drum."""
    names = [item.name for item in drawn]
    last = {name: int(np.flatnonzero(seen.solid == names.index(name)).max()) for name in names}
    first = {name: int(np.flatnonzero(seen.solid == names.index(name)).min()) for name in names}
    assert last["rockers"] > last["cylinder_drum"] > first["frame_wall"]
    assert first["frame_wall"] == min(first.values())


@pytest.mark.parametrize(("depth", "front"), [(-0.5, True), (0.5, False)])
def test_a_joint_off_the_plane_takes_its_link_along(depth: float, front: bool) -> None:
    """Half a metre before all else or behind it: its faces come after all others, or first."""
    mechanism = load("e62", {"urdf.joint.rocker_pin.origin.xyz.y": depth})
    run = simulate(mechanism, Case(speed_rpm=650.0))
    drawn = solids(mechanism)
    found = flat(film(run, Look(slow=100.0, exaggerate=10.0)), drawn)
    link = [joint.name for joint in mechanism.joints].index("rocker_pin")
    own = {place for place, item in enumerate(drawn) if item.body == link}
    places = np.flatnonzero(np.isin(found.solid, list(own)))
    others = np.flatnonzero(~np.isin(found.solid, list(own)))
    assert len(places) > 0
    assert places.min() > others.max() if front else places.max() < others.min()


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
        assert has(picture, phase, machine) > 20
        assert all(has(picture, other, machine) == 0 for other in every - {phase})
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
        # The impulse of the first collision opens the film; those that close it have less than a
        # tenth of it. The length of an arrow goes with the impulse, its width with the root.
        largest = has(pictures[1], ARROW, machine)
        assert largest > 500
        assert has(pictures[-1], ARROW, machine) < 0.1**1.5 * largest
    assert capsys.readouterr().out == ""
    assert sizes[1] == pytest.approx(2 * sizes[0], abs=2)
    assert sizes[2] == sizes[0]
    assert (np.abs(openings[0] - openings[2]).max(axis=-1) > 60).sum() > 50


@pytest.mark.slow
@pytest.mark.parametrize("model", known_models())
def test_every_model_of_the_package_can_be_filmed(model: str, tmp_path: Path) -> None:
    mechanism = load(model)
    solution = simulate(
        mechanism, Case(speed_rpm=mechanism.cylinder.rated_speed_rpm, window=Window.CYCLE)
    )
    path = write_gif(solution, tmp_path / f"{model}.gif", Look(slow=20.0))
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
