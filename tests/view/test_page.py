"""Pages of a film and of two runs on one clock: what they say and hold, and the command."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import meshcat
import numpy as np
import pytest
from page_words import film_of, said
from runs_shown import machine_called, run_of, turn
from snapshots import Words
from three_js import Scene

import nipper_pin as nip
from nipper_pin import (
    Case,
    Comparison,
    Mechanism,
    Solution,
    Window,
    compare,
    load,
    simulate,
)
from nipper_pin.cli import main
from nipper_pin.mechanism import known_models
from nipper_pin.mechanism.gallery import GALLERY
from nipper_pin.view.scene import Look, film


@pytest.fixture(scope="module")
def page(cycle: Solution, page_of: Callable[..., str]) -> str:
    return page_of(cycle)


@pytest.mark.parametrize("name", ["e62", "press", "boxed", "balls", "elements", "larger"])
def test_words_of_the_page(name: str, page_of: Callable[..., str], words: Words) -> None:
    """Title, case, note, columns, phases, collisions, names and legends; of other rebounds too."""
    run, look = run_of("transition" if name == "larger" else name), {}
    if name == "larger":
        title = "a comber </script> & co"
        run = replace(run, mechanism=replace(run.mechanism, title=title))
        look = {"slow": 20.0, "exaggerate": 3.0}
    words(said(page_of(run, **look)))


def test_page_is_one_file_that_asks_for_nothing(page: str) -> None:
    assert len(page.encode()) < 10_000_000
    # Outside of the script of the viewer, which holds addresses of XML name spaces.
    head, _, tail = page.partition("<script>")
    tail = tail[tail.index('<script id="scene"') :]
    assert not re.search(
        r"https?://|\bsrc=|@import|url\(", re.sub(r"(?s)<!--.*?-->", "", head + tail)
    )
    assert "MIT License" in head
    assert "@@" not in head


def test_words_of_the_scene(page: str, words: Words) -> None:
    """No grid and no axes, two sides, and tracks as three.js calls them.

    One that it does not know ends the whole film.
    """
    scene, text = Scene(page), []
    for item in scene.sent:
        if item["type"] == "set_property":
            text.append(f"{item['path']} {item['property']}: {item['value']}")
    for path, item in scene.objects.items():
        (material,) = item["materials"]
        shapes = " ".join(shape["type"] for shape in item["geometries"])
        colour = "#" + bytes(scene.colour(path)).hex()
        text.append(f"{path}: {shapes}, {material['type']}, side {material['side']}, {colour}")
    clips = [item["clip"] for item in scene.sent[-1]["animations"]]
    kinds = {f"track {t['name']} {t['type']}, fps {c['fps']}" for c in clips for t in c["tracks"]}
    words("\n".join([*text, *sorted(kinds), f"options {scene.options}"]) + "\n")


def test_a_page_carries_the_licences_of_what_is_in_it(page: str) -> None:
    """In one comment, which nothing in them ends."""
    comment = re.search(r"<!--(.*?)-->", page, re.S)
    assert comment is not None
    viewer = Path(meshcat.__file__).parent / "viewer"
    for file in (viewer / "LICENSE", viewer / "dist" / "main.min.js.LICENSE.txt"):
        assert file.read_text(encoding="utf-8").strip().replace("--", "- -") in comment[1]
    assert "--" not in comment[1]


@pytest.mark.sampled(13)
@pytest.mark.parametrize("name", [*sorted(known_models()), *sorted(GALLERY)])
def test_every_part_is_in_the_frame_all_the_turn(name: str, page_of: Callable[..., str]) -> None:
    """Links, springs, dampers and stops, with all their points.

    The page lets the camera see 40 degrees from top to bottom and, where its pane is less than a
    quarter wider than high, moves it back.
    """
    mechanism = load(GALLERY.get(name, name))
    case = Case(speed_rpm=mechanism.cylinder.rated_speed_rpm, window=Window.CYCLE)
    page = page_of(simulate(mechanism, case))
    scene, film = Scene(page), film_of(page)
    parts = [path for path in scene.objects if "/impulse_" not in path]
    document = mechanism.description
    springs = document.get("springs", {}), document.get("dampers", {})
    wanted = {f"/{joint.child}/" for joint in mechanism.joints}
    wanted |= {f"/spring_{item}" for item in springs[0]}
    wanted |= {f"/damper_{key}" for key, item in springs[1].items() if "frame_a" in item}
    wanted |= {f"/stop_{stop.name}" for stop in mechanism.stops if stop.contact is None}
    assert [item for item in wanted if not any(item in path for path in parts)] == []
    target, position = (np.array(film["cameras"]["whole"][key]) for key in ("target", "position"))
    axis = (target - position) / np.linalg.norm(target - position)
    right = np.cross(axis, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(axis, [0.0, 0.0, 1.0]))
    up = np.cross(right, axis)
    found = []
    for at in np.linspace(0.0, film["duration"], 24):
        for path in parts:
            points = scene.points(path, at)
            found.append(points[:: max(1, len(points) // 300)])
    rays = np.concatenate(found) - position
    ahead = rays @ axis
    high, wide = (np.degrees(np.arctan(np.abs(rays @ way) / ahead)).max() for way in (up, right))
    widest = math.degrees(math.atan(1.25 * math.tan(math.radians(20.0))))
    assert high < 20.0
    assert wide < widest
    # Nor is the mechanism lost in the picture.
    assert max(high / 20.0, wide / widest) > 0.5


@pytest.mark.parametrize(("name", "rebounds"), [
    ("e62", True), ("balls", False), ("drag_link", True), ("evans", False),
])  # fmt: skip
def test_rebounds_are_seen_where_nobody_asks_for_a_factor(
    name: str, rebounds: bool, page_of: Callable[..., str]
) -> None:
    """The highest is drawn 1.4 to 3.6 degrees high, or as much of the reach; a page has both."""
    made = machine_called(name) if name in {"drag_link", "evans"} else None
    run = run_of(name) if made is None else turn(made, made.cylinder.rated_speed_rpm, 24.0)
    shown, plain = film(run, Look()), film(run, Look(exaggerate=1.0))
    assert (shown.larger > 1.0) is rebounds
    np.testing.assert_array_equal(shown.q, plain.q)
    page, true_page = page_of(run, exaggerate=None), page_of(run)
    told = film_of(page)
    if not rebounds:
        assert told == film_of(true_page)
        return
    stop = run.mechanism.stop(run.mechanism.transition_stop)
    turns = next(item.kind for item in run.mechanism.joints if item.index == stop.index)[0] == "r"
    highest = max(hit.rebound_amplitude or 0.0 for hit in run.collisions if hit.stop == stop.name)
    high = shown.larger * highest / (math.radians(6.0) if turns else 0.03 * run.mechanism.reach_m)
    assert 0.6 * 0.4 < high < 0.6
    assert round(math.log10(shown.larger) % 1.0, 9) in {0.0, round(math.log10(2.0), 9),
                                                        round(math.log10(5.0), 9)}  # fmt: skip
    asked = page_of(run, exaggerate=shown.larger)
    assert (told, scene_text(page)) == (film_of(asked), scene_text(asked))
    assert_true_size(page, true_page, "exaggerate", "note", "lips")


def assert_true_size(page: str, true_page: str, *keys: str) -> None:
    """A page holds what it shows at a click: what another one that is in true size has."""
    other, true = film_of(page)["true_size"], film_of(true_page)
    assert {key: other[key] for key in keys} == {key: true[key] for key in keys}
    assert other["scene"] == scene_text(true_page)


def scene_text(page: str) -> str:
    """The message that plays the film, as the page holds it."""
    (found,) = re.findall(r'<script id="scene"[^>]*>(.*?)</script>', page, re.S)
    return str(json.loads(found)[-1])


def test_two_machines_share_a_factor(turns: Comparison, page_of: Callable[..., str]) -> None:
    """The smaller of both, and both are shown in true size at a click."""
    alone = [film(run, Look()).larger for run in (turns.a, turns.b)]
    page = page_of(turns, exaggerate=None)
    assert film_of(page)["exaggerate"] == min(alone) > 1.0
    assert_true_size(page, page_of(turns), "exaggerate", "note", "lips", "other_lips")


# The command.


def test_the_record_of_the_run_can_be_had_as_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    arguments = ["--speed", "550", "--window", "transition", "--html", str(page), "--json", "-"]
    assert main(["view", *arguments]) == 0
    assert json.loads(capsys.readouterr().out)["case"]["speed_rpm"] == 550.0
    # Events are slowed down a thousand times unless one says otherwise.
    film = film_of(page.read_text(encoding="utf-8"))
    columns = {item["label"]: item["values"] for item in film["columns"]}
    assert max(columns["slow motion 1 :"]) == pytest.approx(1000.0)


# Two runs on one clock.


@pytest.fixture(scope="module")
def turns(e62: Mechanism) -> Comparison:
    """Two speeds: both are shown with their first collision at the same time."""
    return compare(*(simulate(e62, Case(speed_rpm=rpm, window="cycle")) for rpm in (450.0, 520.0)))


@pytest.fixture(scope="module")
def transitions(e62: Mechanism) -> Comparison:
    """One speed and two preloads, of which the second takes longer."""
    other = load("e62", {"preload": 7.0})
    return compare(*(simulate(item, Case(speed_rpm=650.0)) for item in (e62, other)))


@pytest.fixture(scope="module")
def pages(
    turns: Comparison, transitions: Comparison, page_of: Callable[..., str]
) -> tuple[str, str]:
    return page_of(turns), page_of(transitions)


def times(film: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Of both machines in each frame [ms]."""
    (column,) = (item for item in film["columns"] if item["label"] == "time")
    return np.array(column["values"]), np.array(column["other"])


def lines(curve: dict[str, Any]) -> list[np.ndarray]:
    """Values of each line; NaN where its run has no motion."""
    return [np.array([math.nan if value is None else value for value in item["values"]])
            for item in (curve, *curve["more"])]  # fmt: skip


def first_touch(run: nip.Solution) -> float:
    return next(hit.t for hit in run.collisions if hit.stop == "jaw")


def test_both_are_struck_first_in_the_same_frame(pages: tuple[str, str], turns: Comparison) -> None:
    film = film_of(pages[0])
    one, other = (next(hit["at"] for hit in film["collisions"]
                       if hit["stop"] == "jaw" and hit["text"].startswith(side))
                  for side in "AB")  # fmt: skip
    assert one == pytest.approx(other, rel=1e-12)
    # A second of the film is the same time of both machines; of 130 ms six digits are shown.
    later = 1e3 * (first_touch(turns.a) - first_touch(turns.b))
    moved = np.subtract(*times(film))
    np.testing.assert_allclose(moved, later, rtol=0.0, atol=1.001e-3)
    assert f"B starts {later:.3f} ms later than A" in film["note"]
    assert "The run of B ends at" in film["note"]


def test_at_one_speed_both_start_together(pages: tuple[str, str], transitions: Comparison) -> None:
    film = film_of(pages[1])
    time, other = times(film)
    np.testing.assert_array_equal(time, other)
    assert "Both start together" in film["note"]
    ends = [1e3 * run.segments[-1].t_end for run in (transitions.a, transitions.b)]
    assert ends[0] < ends[1]
    # The shorter run stands still in its last state, and its curves end.
    gap, second = lines(film["curves"][0])
    outside = np.isnan(gap)
    assert time[outside].min() > ends[0] >= time[~outside].max()
    assert not np.isnan(second).any()
    for column in film["columns"]:
        if column["label"] in ("jaw angle", "jaw gap at the contact", "steeve stroke"):
            assert np.ptp(np.array(column["values"])[outside]) == 0.0


def test_curves_of_one_name_share_their_axes(pages: tuple[str, str], turns: Comparison) -> None:
    """The values are those of each run at its own time, and the axes show the higher rebound."""
    film = film_of(pages[0])
    colours = [film["compare"][side]["colour"] for side in "ab"]
    assert colours[0] != colours[1]
    for curve in film["curves"]:
        assert [curve["colour"], *(item["colour"] for item in curve["more"])] == colours
    stop = turns.a.mechanism.stop("jaw")
    for run, values, time in zip(
        (turns.a, turns.b), lines(film["curves"][0]), times(film), strict=True
    ):
        inside = ~np.isnan(values)
        motion = run.trajectory.evaluate(1e-3 * time[inside])
        gap = 1e3 * stop.lever * stop.gaps(motion.q)
        # Six digits of the value, and half a last digit of the time at the largest rate.
        fastest = 1e3 * stop.lever * np.abs(motion.v[:, stop.index]).max()
        np.testing.assert_allclose(values[inside], gap, rtol=6e-6, atol=5.01e-7 * fastest)
    highest = max(
        hit.rebound_amplitude for run in (turns.a, turns.b) for hit in run.collisions
        if hit.stop == "jaw"
    )  # fmt: skip
    # Frames need not meet the top of a rebound.
    assert film["curves"][0]["most"] == pytest.approx(1.15 * 1e3 * stop.lever * highest, rel=1e-3)


def test_words_of_both_pages(pages: tuple[str, str], words: Words) -> None:
    """Curves and numbers of both, collisions of either in the order of time, the table below."""
    words("\n".join(map(said, pages)))
    hits = [hit["at"] for hit in film_of(pages[0])["collisions"]]
    assert hits == sorted(hits)


def test_both_machines_stand_in_the_scene(pages: tuple[str, str]) -> None:
    """The second one in its tint, and seen through; the first one's colour tells the phase."""
    scene = Scene(pages[0])
    tint = int(film_of(pages[0])["compare"]["b"]["colour"][1:], 16)
    roots = [path.split("/")[1] for path in scene.objects]
    assert roots.count("nipper") == roots.count("other") > 10
    for path, item in scene.objects.items():
        second = path.startswith("/other/")
        for material in item["materials"]:
            assert (material["color"] == tint) is second
            assert (material["opacity"] < 1.0) is second
    tints = [path for path in scene.tracks if path.endswith("<object>")]
    assert tints
    assert all(path.startswith("/nipper/") for path in tints)
    assert {"/nipper/top_nipper", "/other/top_nipper"} <= set(scene.tracks)


@pytest.mark.slow
def test_machines_of_other_parts_have_lanes_of_their_own(
    turns: Comparison, page_of: Callable[..., str]
) -> None:
    pendulum = simulate(load("hanging_pendulum"), Case(speed_rpm=220.0, window="cycle"))
    film = film_of(page_of(compare(turns.a, pendulum)))
    lines = {curve["label"][0]: len(curve["more"]) for curve in film["curves"]}
    assert lines == {"jaw gap": 1, "clamping": 1, "steeve stroke": 0, "rod stroke": 0}
    colours = {curve["label"][0]: curve["colour"] for curve in film["curves"]}
    own = (film["compare"][side]["colour"] for side in "ab")
    assert (colours["steeve stroke"], colours["rod stroke"]) == tuple(own)
    alone = {item["label"]: item["values"] is None for item in film["columns"]}
    assert alone["rod stroke"]
    assert not alone["steeve stroke"]
