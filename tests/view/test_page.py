"""The page of a film: what it says and holds, and the command that writes or serves it."""

from __future__ import annotations

import itertools
import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import meshcat
import numpy as np
import pinocchio as pin
import pytest
from page_words import said
from runs_shown import run_of
from snapshots import Words
from three_js import Scene

from nipper_pin import Case, Solution, Window, load, simulate
from nipper_pin.cli import main
from nipper_pin.mechanism import collision_model, known_models

ARROW = "#D55E00"


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
    """No grid and no axes, a light background, two sides, and tracks as three.js calls them.

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


@pytest.mark.parametrize("name", sorted(known_models()))
def test_the_camera_sees_every_plain_body(name: str, page_of: Callable[..., str]) -> None:
    """All corners of all collision shapes, as Pinocchio places them, are inside of the picture.

    The page lets the camera see 40 degrees from top to bottom: a cone of 20 around its axis in
    any window that is not higher than wide.
    """
    mechanism = load(name)
    case = Case(speed_rpm=mechanism.cylinder.rated_speed_rpm, window=Window.CYCLE)
    seen = re.search(
        r'"whole": \{"target": (\[.*?\]), "position": (\[.*?\])\}',
        page_of(simulate(mechanism, case)),
    )
    target, position = (np.array(json.loads(text)) for text in seen.groups())
    axis = (target - position) / np.linalg.norm(target - position)
    geometry, _ = collision_model(mechanism)
    data, placed = mechanism.model.createData(), geometry.createData()
    pin.updateGeometryPlacements(
        mechanism.model, data, geometry, placed, np.zeros(mechanism.model.nq)
    )
    widest = 0.0
    for item, place in zip(geometry.geometryObjects, placed.oMg, strict=True):
        item.geometry.computeLocalAABB()
        low, high = item.geometry.aabb_local.min_, item.geometry.aabb_local.max_
        for corner in itertools.product(*zip(low, high, strict=True)):
            ray = place.act(np.array(corner)) - position
            widest = max(widest, math.degrees(math.acos(ray @ axis / np.linalg.norm(ray))))
    assert widest < 20.0
    # Nor is the mechanism lost in the picture.
    assert widest > 12.0


# The command.


def test_the_record_of_the_run_can_be_had_as_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    page = tmp_path / "page.html"
    arguments = ["--speed", "550", "--window", "transition", "--html", str(page), "--json", "-"]
    assert main(["view", *arguments]) == 0
    assert json.loads(capsys.readouterr().out)["case"]["speed_rpm"] == 550.0
    # Events are slowed down a thousand times unless one says otherwise.
    film_of = re.search(r'<script id="film"[^>]*>(.*?)</script>', page.read_text(encoding="utf-8"))
    columns = {item["label"]: item["values"] for item in json.loads(film_of[1])["columns"]}
    assert max(columns["slow motion 1 :"]) == pytest.approx(1000.0)
