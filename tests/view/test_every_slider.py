"""All that the live page consists of: sliders, texts, plots, and what is drawn for a setting."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from judge import press

from nipper_pin import Case, InputError, Mechanism, Outcome, load, simulate
from nipper_pin.view.live import answer as answers
from nipper_pin.view.live.answer import answer
from nipper_pin.view.live.panel.text import as_html
from nipper_pin.view.live.settings import _round_step, changed, knobs

pytest.importorskip("viser", reason="viser is not installed (extra `live`)")
import viser

from nipper_pin.view.live import page as pages
from nipper_pin.view.live import stage as stages
from nipper_pin.view.live.page import Page
from nipper_pin.view.live.stage import Stage


def ends(mechanism: Mechanism, speed: float) -> dict[str, tuple[Any, ...]]:
    return {
        item.key: (item.label, item.unit, item.factor, item.low, item.high, item.step, item.start)
        for item in knobs(mechanism, speed)
    }


def test_sliders_of_the_e62(e62: Mechanism) -> None:
    """0.4 to 2 times the rated speed, a quarter to 2.5 times of rate and preload, in round steps.

    A step is at most a fiftieth of the value.
    """
    assert ends(e62, 650.0) == {
        "speed": ("speed [r/min]", "r/min", 1.0, 180.0, 900.0, 5.0, 650.0),
        "restitution": ("restitution of the jaw", "", 1.0, 0.0, 0.8, 0.01, 0.2),
        "steeve.stiffness": ("stiffness [N/mm]", "N/mm", 1e3, 2.2, 22.5, 0.1, 9.0),
        "steeve.preload": ("preload [mm]", "mm", 1e-3, 0.0, 27.6, 0.2, 11.0),
    }
    lively = load("e62", {"stops.jaw.restitution": 0.93})
    assert ends(lively, 650.0)["restitution"][4] == 0.93


def test_sliders_of_springs_at_hinges_and_of_several(e62: Mechanism) -> None:
    """Moments and angles; a rate of zero cannot be scaled; a preload of zero has usual ends."""
    machine = press()
    spring = machine.springs[0]
    degree = math.radians(1.0)
    assert list(ends(machine, 30.0).items())[2:] == [
        ("flap.stiffness", ("stiffness [N m/rad]", "N m/rad", 1.0, 0.75, 7.5, 0.05, 3.0)),
        ("flap.preload", ("preload [deg]", "deg", degree, 0.0, 50.0, 0.2, 20.0)),
    ]
    none = replace(machine, springs=(replace(spring, preload=0.0, stiffness=0.0),))
    assert list(ends(none, 30.0).items())[2:] == [
        ("flap.preload", ("preload [deg]", "deg", degree, 0.0, 25.0, 0.2, 0.0)),
    ]
    pulled = replace(machine, springs=(replace(spring, preload=-20.0 * degree),))
    assert ends(pulled, 30.0)["flap.preload"][3:] == (-50.0, 0.0, 0.2, -20.0)
    steeve = replace(e62.springs[0], preload=0.0)
    two = replace(e62, springs=(steeve, replace(steeve, name="other")))
    found = ends(two, 650.0)
    assert [label for label, *_ in found.values()][2:] == [
        "stiffness of spring steeve [N/mm]", "preload of spring steeve [mm]",
        "stiffness of spring other [N/mm]", "preload of spring other [mm]",
    ]  # fmt: skip
    # 2.5 times a fiftieth of the reach.
    usual = 20.0 * e62.reach_m
    step = found["other.preload"][5]
    assert found["other.preload"][4] == pytest.approx(math.ceil(2.5 * usual / step) * step)
    values = {"speed": 1.0, "restitution": 0.31, "steeve.stiffness": 5.0, "steeve.preload": 6.0,
              "other.stiffness": 7.0, "other.preload": 8.0}  # fmt: skip
    made = changed(two, values)
    assert [(item.name, item.stiffness, item.preload) for item in made.springs] == [
        ("steeve", 5.0, 6.0), ("other", 7.0, 8.0),
    ]  # fmt: skip
    known = {stop.name: stop.restitution for stop in e62.stops}
    assert {stop.name: stop.restitution for stop in made.stops} == {**known, "jaw": 0.31}


@pytest.mark.parametrize(
    ("value", "step"), [(1.0, 1.0), (1.99, 1.0), (2.0, 2.0), (4.9, 2.0), (5.1, 5.0), (0.097, 0.05)]
)
def test_steps_are_round(value: float, step: float) -> None:
    assert _round_step(value) == step


def test_sliders_need_the_transition_stop(e62: Mechanism) -> None:
    """It is enough alone, and no other stop stands in for it."""
    jaw, steeve = (e62.stop(name) for name in ("jaw", "steeve"))
    assert knobs(replace(e62, stops=(jaw,)), 650.0)
    with pytest.raises(InputError, match="no transition stop"):
        knobs(replace(e62, stops=(steeve,)), 650.0)


class Rows(HTMLParser):
    """Texts of a page by the id or the key of their element, and the labels of the table."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.texts: dict[str, str] = {}
        self.labels: list[str] = []
        self.roles: dict[str, str | None] = {}
        self._open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        given = dict(attrs)
        name = given.get("id") or given.get("data-key") or ""
        self._open.append(name or (self._open[-1] if self._open and tag == "b" else ""))
        if given.get("role"):
            self.roles[name] = given["role"]
        if tag == "td" and not name and "data-difference" not in given:
            self.labels.append("")

    def handle_data(self, data: str) -> None:
        if self._open[-1]:
            self.texts[self._open[-1]] = self.texts.get(self._open[-1], "") + data
        elif self.labels:
            self.labels[-1] += data

    def handle_endtag(self, tag: str) -> None:
        assert tag
        self._open.pop()


def asked(mechanism: Mechanism, **values: float) -> Any:
    controls = knobs(mechanism, 650.0)
    return answer(mechanism, controls, {item.key: item.start for item in controls} | values)


def test_numbers_and_setting_in_the_page(e62: Mechanism) -> None:
    """The setting with units, a row a number with its label, and the time that the engine took."""
    found = asked(e62, speed=700.0)
    read = Rows(as_html(found))
    assert read.texts["setting"] == (
        "speed 700 r/min, restitution of the jaw 0.2, stiffness 9 N/mm, preload 11 mm"
    )
    assert read.labels == [
        "first rebound amplitude [mdeg]", "first rebound time [ms]", "time to rest [ms]",
        "collisions", "share of the first two rebounds [%]",
        "rate of the first collision [rad/s]", "impulse of the first collision [N s]", "engine",
    ]  # fmt: skip
    keys = ["amplitude", "rebound", "duration", "collisions", "share", "approach", "impulse"]
    assert list(read.texts) == ["setting", *keys, "engine"]
    assert [(item.key, item.text) for item in found.rows] == list(read.texts.items())[1:]
    run = found.solution
    assert read.texts["engine"] == f"direct, {1e3 * run.wall_s:.1f} ms"
    assert run.case == Case(speed_rpm=700.0, max_collisions=400)
    assert float(read.texts["approach"]) < 0.0


def test_other_stops_on_the_way_have_a_row(e62: Mechanism) -> None:
    """After the numbers of the transition; without any there is none."""
    run = simulate(e62, Case(speed_rpm=650.0))
    other = replace(run.collisions[1], stop="steeve")
    rows = answers._rows(run, list(run.collisions), [other])
    late = 1e3 * (other.t - run.collisions[0].t)
    said = f"On the way the steeve struck its stop once, first after {late:.3g} ms."
    assert rows[-2][:3] == ("others", "other stops", said)
    assert "others" not in {key for key, *_ in answers._rows(run, list(run.collisions), [])}


def test_a_reason_instead_of_numbers(e62: Mechanism) -> None:
    """As an alert, with the setting above it."""
    read = Rows(as_html(asked(e62, speed=900.0, restitution=0.7)))
    assert set(read.texts) == {"setting", "message"}
    assert read.texts["message"].startswith("No numbers: ")
    assert Outcome.NO_REST.value in read.texts["message"] or "rest" in read.texts["message"]
    assert read.roles == {"message": "alert"}
    assert "speed 900 r/min" in read.texts["setting"]


# The page.


def noted(
    patch: pytest.MonkeyPatch, owner: Any, *names: str
) -> list[tuple[str, tuple[Any, ...], dict[str, Any]]]:
    """Calls of some methods, which are done as ever."""
    made: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = []

    def follow(name: str, real: Any) -> Any:
        def note(*words: Any, **more: Any) -> Any:
            made.append((name, words, more))
            return real(*words, **more)

        return note

    for name in names:
        patch.setattr(owner, name, follow(name, getattr(owner, name)))
    return made


@pytest.fixture
def server() -> Iterator[viser.ViserServer]:
    found = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield found
    found.stop()


def test_what_the_page_is_built_of(
    e62: Mechanism, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Panel, title, sliders with their ends, plots with their axes, and the note on estimates."""
    made = noted(
        monkeypatch, server.gui, "add_slider", "add_checkbox", "add_html", "add_text",
        "configure_theme", "set_panel_label",
    )  # fmt: skip
    titled = replace(e62, title="an <estimate> & co")
    page = Page(server, titled, knobs(titled, 650.0))
    by_kind: dict[str, list[Any]] = {}
    for name, words, more in made:
        by_kind.setdefault(name, []).append((words, more))
    assert by_kind["configure_theme"][0][1] == {"show_logo": False, "show_share_button": False}
    assert by_kind["set_panel_label"] == [(("nipper-pin live: e62",), {})]
    sliders = by_kind["add_slider"]
    for (words, more), item in zip(sliders, knobs(titled, 650.0), strict=False):
        assert words == (item.label,)
        assert more == {"min": item.low, "max": item.high, "step": item.step,
                        "initial_value": item.start}  # fmt: skip
    assert [words for words, _ in sliders[-2:]] == [
        ("slow motion 1 :", 100, 5000, 100, 1000),
        ("gap drawn larger, times", 1.0, 50.0, 1.0, 10.0),
    ]  # fmt: skip
    fields = [words for words, _ in by_kind["add_text"]]
    assert fields == [("speed", "650"), ("restitution of the jaw", "0.2"), ("stiffness", "9"),
                      ("preload", "11")]  # fmt: skip
    assert by_kind["add_checkbox"] == [(("play",), {"initial_value": True})]
    texts = [words[0] for words, _ in by_kind["add_html"]]
    assert Rows(texts[0].partition("</style>")[2]).texts == {"title": "an <estimate> & co"}
    assert "none is the maker's" in Rows(texts[-1]).texts["note"]
    plots = page._plots
    gap, force, impulse = plots.gap, plots.force, plots.impulse
    time = "time from the first collision [ms]"
    assert [axis.get("label") for axis in gap.axes] == [
        None, "jaw angle [mdeg]", "gap at the contact [mm]"
    ]  # fmt: skip
    assert [axis.get("label") for axis in force.axes] == [None, "clamping force [N]"]
    assert [axis.get("label") for axis in impulse.axes] == [time, "impulse [N s]"]
    x = {"time": False, "range": (0.0, 10.0)}
    assert gap.scales["x"] == force.scales["x"] == impulse.scales["x"] == x
    # One axis is the other times the lever of the contact.
    lever = e62.stop("jaw").contact.lever_m
    high = gap.scales["y"]["range"][1]
    assert gap.scales["lips"]["range"][1] == pytest.approx(lever * math.radians(high), rel=1e-12)
    # 3 is a logarithmic scale of uPlot, and its marks are the powers of ten.
    assert impulse.scales["y"] == {"distr": 3, "range": (1e-4, 1.0)}
    assert impulse.axes[1]["values"] == ("0.0001", "0.001", "0.01", "0.1", "1")
    for plot in (gap, force, impulse):
        assert plot.legend == {"show": False}
        assert all(axis.get("ticks") == {"show": False} for axis in plot.axes[1:])
        assert plot.visible
        assert plot.series[0] == {"label": time}
        assert len(plot.series) == len(plot.data)
    assert [item["stroke"] for item in gap.series[1:]] == [
        "#E69F00", "#A6CDE6", "#0072B2", "transparent"
    ]  # fmt: skip
    assert [item["points"]["fill"] for item in impulse.series[1:]] == [
        "#E69F00", "#A6CDE6", "#0072B2"
    ]  # fmt: skip
    np.testing.assert_array_equal(impulse.data[0], page._answer.hit_time)
    # A slider that moves wakes the page, whoever moves it.
    assert not page._wake.is_set()
    page._set.sliders["steeve.preload"].value = 8.0
    assert page._wake.is_set()
    without = Page(server, replace(e62, title="a machine"), knobs(e62, 650.0))
    assert without is not None
    assert "maker" not in made[-1][1][0]


def test_the_picture_follows_the_clock(
    e62: Mechanism, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drawn once for each moment; with the phase, the arrows and the gap that the slider asks."""
    page = Page(server, e62, knobs(e62, 650.0))
    run = page._answer.solution
    assert run is not None
    seen: list[tuple[Any, ...]] = []
    for name in ("pose", "phase", "impulses", "rest"):
        monkeypatch.setattr(
            page._stage, name, lambda *words, name=name: seen.append((name, *words))
        )
    jaw = e62.stop("jaw")
    page._draw(2.0)
    assert [item[0] for item in seen] == ["pose", "phase", "impulses"]
    t = 2.0 / 1000.0
    motion = run.trajectory.evaluate(t)
    wanted = min(10.0 * jaw.gap(motion.q[0]), math.radians(6.0))
    assert jaw.gap(seen[0][1]) == pytest.approx(wanted, rel=1e-9)
    assert seen[0][2] == float(motion.cylinder_angle[0])
    assert seen[1][1] == frozenset()
    assert page._text.startswith("2.00 ms, index ")
    page._draw(0.0)
    assert len(seen) == 3
    page._larger.value = 1.0
    page._draw(0.0)
    np.testing.assert_array_equal(seen[3][1], motion.q[0])
    # Where the loops cannot follow a larger gap the page says so, and shows the machine's own.
    monkeypatch.setattr(
        pages, "exaggerated", lambda *_: (_ for _ in ()).throw(pages.InputError("too large"))
    )
    page._larger.value = 50.0
    page._draw(0.0)
    np.testing.assert_array_equal(seen[6][1], motion.q[0])
    assert page._text.endswith(" too large")
    # Without motion everything stands as it does at touch, and no arrow is left over.
    page._set.sliders["speed"].value = 900.0
    page._set.sliders["restitution"].value = 0.7
    page._answer = page._follow()
    page._draw(0.0)
    assert seen[9:] == [("rest",), ("impulses", {})]
    assert page._text == "there is no motion to show: the touch configuration"


def test_texts_come_eight_times_a_second(e62: Mechanism, server: viser.ViserServer) -> None:
    """Or at once after a slider; names in them are no part of the page."""
    page = Page(server, e62, knobs(e62, 650.0))
    told = []
    for now, text, at_once in (
        (10.0, "a <b>", False), (10.11, "b", False), (10.12001, "c", False), (10.13, "d", True),
        (10.2, "e", False), (10.2501, "f", False),
    ):  # fmt: skip
        page._text = text
        page._tell(now, at_once=at_once)
        told.append(Rows(page._now.content).texts["now"])
    assert told == ["a <b>", "a <b>", "c", "d", "d", "f"]
    # Two styles, which no reader sees, move the cursor and the lips.
    words, styles = re.subn(r"<style>.*?</style>", "", page._now.content)
    assert styles == 2
    assert re.sub(r"<[^>]*>", "", words) == "Picture: f"


# What is drawn.


def test_what_the_scene_is_lit_and_seen_by(
    e62: Mechanism, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """z is up, the sun is in front and above, and all joints are in the picture, not far away."""
    scene = server.scene
    made = noted(
        monkeypatch, scene, "set_up_direction", "configure_environment_map",
        "configure_default_lights", "add_light_ambient", "add_light_directional", "add_frame",
    )  # fmt: skip
    Stage(server, e62)
    said: dict[str, Any] = {}
    for name, words, more in made:
        said.setdefault(name, []).append((words, more))
    assert said["set_up_direction"] == [(("+z",), {})]
    assert said["configure_environment_map"] == [((), {"hdri": None})]
    assert said["configure_default_lights"] == [((), {"enabled": False})]
    assert said["add_light_ambient"][0][1]["intensity"] > 0.5
    sun = said["add_light_directional"][0][1]
    assert sun["position"][1] < 0.0 < sun["position"][2]
    frames = {words[0]: more for words, more in said["add_frame"] if more.get("show_axes") is False}
    links = {f"/links/{joint.child}" for joint in e62.joints}
    assert set(frames) >= {*links, "/frame", "/cylinder"}
    view = server.initial_camera
    assert view.fov == pytest.approx(math.radians(45.0))
    ahead = view.look_at - view.position
    ahead /= np.linalg.norm(ahead)
    off = []
    for path in links:
        way = scene.get_handle_by_name(path).position - view.position
        off.append(math.acos(float(way @ ahead / np.linalg.norm(way))))
    assert math.radians(5.0) < max(off) < math.radians(22.5)
    assert ahead[1] > 0.7
    assert ahead[2] < 0.0


def test_mirrored_meshes_have_two_sides(
    e62: Mechanism, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And every surface is moved by no more than 0.04 % of the reach, whatever its scale is."""
    known = stages.solids(e62)
    mirrored = replace(known[0], scale=np.array([-3.0, 0.5, 1.0]))
    moved: list[float] = []
    monkeypatch.setattr(stages, "solids", lambda _: (mirrored, *known[1:]))
    monkeypatch.setattr(stages, "coarse", lambda mesh, off: (moved.append(off), mesh)[1])
    made = noted(monkeypatch, server.scene, "add_mesh_simple")
    Stage(server, e62)
    meshes = {words[0]: more for _, words, more in made}
    limit = 4e-4 * e62.reach_m
    wanted = [limit / np.abs(solid.scale).max() for solid in (mirrored, *known[1:])]
    np.testing.assert_allclose(moved, wanted, rtol=1e-12)
    solids = {path: more for path, more in meshes.items() if "/impulse_" not in path}
    assert len(solids) == len(known)
    for solid, (path, more) in zip((mirrored, *known[1:]), solids.items(), strict=True):
        assert path.endswith(f"/{solid.name}")
        assert more["side"] == ("double" if solid is mirrored else "front")
        assert more["scale"] == tuple(solid.scale)
        assert more["color"] == tuple(round(255.0 * part) for part in solid.colour)
    arrows = [more for path, more in meshes.items() if "/impulse_" in path]
    assert [more["visible"] for more in arrows] == [False] * 2
    assert {more["color"] for more in arrows} == {(0xD5, 0x5E, 0x00)}
    # Shadows cost more than all the rest.
    assert {(more["cast_shadow"], more["receive_shadow"]) for more in meshes.values()} == {
        (False, False)
    }
