"""The live page as it is built and drawn, without a browser: a real page on a real server."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from judge import press
from runs_shown import run_of
from snapshots import Words

pytest.importorskip("viser", reason="viser is not installed (extra `live`)")
pytest.importorskip("manifold3d", reason="manifold3d is not installed (extra `live`)")
import viser

from nipper_pin import InputError, Mechanism, load
from nipper_pin.view.live import page as pages
from nipper_pin.view.live.curves.axes import SteadyAxis, SteadyDecades, round_above
from nipper_pin.view.live.moment import impulses_at
from nipper_pin.view.live.page import Page
from nipper_pin.view.live.settings import knobs
from nipper_pin.view.live.shapes import coarse
from nipper_pin.view.live.stage import Stage
from nipper_pin.view.phases import phase_colour
from nipper_pin.view.scene import solids


@pytest.fixture
def page(e62: Mechanism, server: viser.ViserServer) -> Page:
    return Page(server, e62, knobs(e62, 650.0))


def noted(patch: pytest.MonkeyPatch, owner: Any, *names: str) -> list[str]:
    """Calls of some methods of viser, which are done as ever, a line each."""
    made: list[str] = []

    def follow(name: str, real: Any) -> Any:
        def note(*words: Any, **more: Any) -> Any:
            given = [*map(repr, words), *(f"{key}={value!r}" for key, value in more.items())]
            made.append(f"{name}({', '.join(given)})")
            return real(*words, **more)

        return note

    for name in names:
        patch.setattr(owner, name, follow(name, getattr(owner, name)))
    return made


@pytest.mark.parametrize("name", ["e62", "press"])
def test_words_of_the_page(
    name: str, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch, words: Words
) -> None:
    """Panel, title, sliders and fields, plots with axes and colours, and the note on estimates."""
    made = load(name) if name == "e62" else press()
    titled = replace(made, title="an <estimate> & co" if name == "e62" else "a machine")
    kinds = ("slider", "checkbox", "html", "text", "button_group")
    panel = noted(
        monkeypatch, server.gui, "configure_theme", "set_panel_label",
        *(f"add_{kind}" for kind in kinds),
    )  # fmt: skip
    page = Page(server, titled, knobs(titled, 650.0))
    text = re.sub(r"<(style|svg)[^>]*>.*?</\1>", r"<\1>", "\n".join(panel))
    for place, plot in enumerate((page._plots.gap, page._plots.force, page._plots.impulse)):
        for what in ("axes", "scales", "series", "legend", "visible"):
            found = getattr(plot, what)
            for item in found if isinstance(found, tuple | list) else [found]:
                text += f"\nplot {place}, {what}: {item}"
    words(text + "\n")


def test_words_of_the_scene(
    e62: Mechanism, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch, words: Words
) -> None:
    """z is up, the sun is in front and above; frames of all links, none with axes."""
    made = noted(
        monkeypatch, server.scene, "set_up_direction", "configure_environment_map",
        "configure_default_lights", "add_light_ambient", "add_light_directional", "add_frame",
    )  # fmt: skip
    Stage(server, e62)
    words("\n".join(made) + "\n")
    view = server.initial_camera
    ahead = view.look_at - view.position
    ahead /= np.linalg.norm(ahead)
    off = []
    for joint in e62.joints:
        way = server.scene.get_handle_by_name(f"/links/{joint.child}").position - view.position
        off.append(math.acos(float(way @ ahead / np.linalg.norm(way))))
    assert math.radians(5.0) < max(off) < 0.5 * view.fov == pytest.approx(math.radians(22.5))
    assert ahead[1] > 0.7
    assert ahead[2] < 0.0


def test_solids_keep_their_shape_with_fewer_triangles(e62: Mechanism) -> None:
    """Both surfaces pass the corners of the other by no more than twice the tolerance.

    By trimesh's own distances; manifold3d moves one edge after the other, and so a little further
    than it is told. Without a look at what is left, the lip of the cushion plate would go whole,
    which is ten tolerances. Half of the triangles go.
    """
    tolerance, before, after = 4e-4 * e62.reach_m, 0, 0
    for solid in solids(e62):
        mesh = trimesh.load_mesh(solid.path)
        thin = coarse(mesh, tolerance)
        before, after = before + len(mesh.faces), after + len(thin.faces)
        for one, other in ((mesh, thin), (thin, mesh)):
            _, distance, _ = trimesh.proximity.closest_point(one, other.vertices)
            assert distance.max() < 2.0 * tolerance, solid.name
        assert thin.is_watertight
    assert after < 0.6 * before


def test_a_surface_with_holes_is_drawn_as_it_is() -> None:
    """manifold3d has no body for it, and a plate thinner than the tolerance would vanish."""
    box = trimesh.creation.box(extents=(1.0, 2.0, 3.0))
    torn = trimesh.Trimesh(box.vertices, box.faces[:-1])
    assert coarse(torn, 1e-3) is torn
    plate = trimesh.creation.box(extents=(1.0, 1.0, 1e-4))
    assert coarse(plate, 1e-2) is plate
    assert len(coarse(trimesh.creation.icosphere(4), 0.05).faces) < 2000


# What is drawn.


def test_the_arrow_at_the_lips_points_along_the_impulse(
    e62: Mechanism, server: viser.ViserServer
) -> None:
    """Its foot and its tip in the touch configuration, where the contact of the model is known."""
    scene, shown = server.scene, Stage(server, e62)
    assert not scene.get_handle_by_name("/links/bottom_nipper/impulse_jaw").visible
    shown.impulses({"jaw": 0.25})
    handle = scene.get_handle_by_name("/links/bottom_nipper/impulse_jaw")
    link = scene.get_handle_by_name("/links/bottom_nipper")
    shown.rest()
    # At q = 0 all links are parallel to the world.
    np.testing.assert_allclose(link.wxyz, [1.0, 0.0, 0.0, 0.0], atol=1e-12)
    w, x, y, z = handle.wxyz
    points = pin.Quaternion(w, x, y, z).toRotationMatrix() @ (handle.vertices * handle.scale).T
    points = points.T + handle.position + link.position
    contact = e62.stop("jaw").contact
    along = (points - contact.point) @ contact.normal
    # Stored in single precision; a quarter of the impulse is a quarter of the length.
    assert along.min() == pytest.approx(0.0, abs=1e-7)
    assert along.max() == pytest.approx(0.25 * 0.18 * e62.reach_m, rel=1e-6)
    tip = points[along.argmax()] - contact.point
    np.testing.assert_allclose(tip, along.max() * contact.normal, atol=1e-7)
    shown.impulses({})
    assert not handle.visible


def test_the_colour_of_the_opening_link_is_that_of_the_phase(
    e62: Mechanism, server: viser.ViserServer
) -> None:
    """Of both its solids, and of no other link."""
    scene, shown = server.scene, Stage(server, e62)
    others = scene.get_handle_by_name("/links/bottom_nipper/bottom_nipper").color
    seen = set()
    for phase in e62.phases:
        shown.phase(phase.closed)
        own = [scene.get_handle_by_name(f"/links/top_nipper/{name}").color
               for name in ("top_nipper", "top_lip")]  # fmt: skip
        wanted = phase_colour(e62, phase.closed)
        assert own == [tuple(bytes.fromhex(wanted[1:]))] * 2
        assert scene.get_handle_by_name("/links/bottom_nipper/bottom_nipper").color == others
        seen.add(own[0])
    assert len(seen) == 3


def test_an_impulse_is_held_shrinks_and_goes() -> None:
    """At 1 : 1000, a millisecond of the machine is a second of playback."""
    run = run_of("transition")
    first, second = run.collisions[:2]
    assert first.impulse == max(hit.impulse for hit in run.collisions)
    assert second.t - first.t > 5e-3
    for after, size in ((0.0, 1.0), (0.59e-3, 1.0), (0.8e-3, 0.5), (1.01e-3, 0.0)):
        assert impulses_at(run, first.t + after, 1e3)["jaw"] == pytest.approx(size, abs=1e-9)
    share = second.impulse / first.impulse
    assert impulses_at(run, second.t, 1e3)["jaw"] == pytest.approx(share, rel=1e-12)


def opened(server: viser.ViserServer) -> float:
    """How far the jaw is drawn open [rad]: the angle between its links."""
    turns = []
    for name in ("bottom_nipper", "top_nipper"):
        w, x, y, z = server.scene.get_handle_by_name(f"/links/{name}").wxyz
        turns.append(pin.Quaternion(w, x, y, z).toRotationMatrix())
    between = turns[0].T @ turns[1]
    return abs(math.atan2(between[0, 2], between[0, 0]))


def test_the_picture_follows_the_clock(
    page: Page, e62: Mechanism, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With the gap that the slider asks for; without motion all stands as it does at touch."""
    run, jaw = page._answer.solution, e62.stop("jaw")
    assert run is not None
    page._draw(2.0)
    q = run.trajectory.evaluate(2.0 / 1000.0).q[0]
    wanted = min(10.0 * jaw.gap(q), math.radians(6.0))
    assert opened(server) == pytest.approx(wanted, rel=1e-9)
    assert page._text.startswith("2.00 ms, index ")
    page._larger.value = 1.0
    page._draw(0.0)
    assert opened(server) == pytest.approx(jaw.gap(q), rel=1e-9)
    # Where the loops cannot follow a larger gap the page says so, and shows the machine's own.
    monkeypatch.setattr(
        pages, "exaggerated", lambda *_: (_ for _ in ()).throw(InputError("too large"))
    )
    page._larger.value = 50.0
    page._draw(0.0)
    assert opened(server) == pytest.approx(jaw.gap(q), rel=1e-9)
    assert page._text.endswith(" too large")
    page._set.sliders["speed"].value = 900.0
    page._set.sliders["restitution"].value = 0.7
    page._answer = page._follow()
    page._draw(0.0)
    assert opened(server) == pytest.approx(0.0, abs=1e-12)
    assert page._text == "there is no motion to show: the touch configuration"


def test_texts_come_eight_times_a_second(page: Page) -> None:
    """Or at once after a slider; names in them are no part of the page."""
    told = []
    for now, text, at_once in (
        (10.0, "a <b>", False), (10.11, "b", False), (10.12001, "c", False), (10.13, "d", True),
        (10.2, "e", False), (10.2501, "f", False),
    ):  # fmt: skip
        page._text = text
        page._tell(now, at_once=at_once)
        told.append(re.search(r'id="now">(.*?)</span>', page._now.content)[1])
    assert told == ["a &lt;b&gt;", "a &lt;b&gt;", "c", "d", "d", "f"]
    # Two styles, which no reader sees, move the cursor and the lips.
    words, styles = re.subn(r"<style>.*?</style>", "", page._now.content)
    assert styles == 2
    assert re.sub(r"<[^>]*>", "", words) == "Picture: f"


@pytest.mark.parametrize("slow", [250.0, 500.0])
def test_the_film_stands_at_its_end_for_a_moment_and_begins_again(page: Page, slow: float) -> None:
    """0.7 s of playback, however slow: so long the page says the last time, and then the first."""
    step = 0.02
    # One index behind the rest.
    end = run_of("transition").events[-1].t + 60.0 / 650.0 / 40.0
    page._slow.value = slow
    told = []
    for _ in range(int(slow * end / step) + 60):
        page._draw(step)
        told.append(page._text.partition(" ms")[0])
    first, still = told.index(f"{1e3 * end:.2f}"), told.count(f"{1e3 * end:.2f}")
    assert first == pytest.approx(slow * end / step, abs=1)
    assert still == pytest.approx(0.7 / step, abs=1)
    assert told[first + still] == "0.00"
    assert "0.00" not in told[: first + still]


class Moves:
    """A clock that runs only while the page waits, and sliders that move at some of its times."""

    def __init__(self, *times: float, end: float) -> None:
        self.now, self.end, self._times = 0.0, end, list(times)

    def wait(self, timeout: float) -> bool:
        if self.now > self.end:
            raise StopIteration
        moved = bool(self._times) and self._times[0] <= self.now + timeout
        self.now = self._times.pop(0) if moved else self.now + timeout
        return moved

    def clear(self) -> None:
        """Nothing is kept: a move is told once."""

    def set(self) -> None:
        """A slider that moves is told by the times."""

    def perf_counter(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


def test_the_film_stands_while_sliders_move_and_goes_on_where_it_stood(
    page: Page, server: viser.ViserServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """0.8 s from the last of two moves, in which it is drawn for each setting, at the same time.

    The page's own loop, on a clock that no other work of the machine delays.
    """
    clock = Moves(2.0, 2.3, end=4.0)
    monkeypatch.setattr(pages, "time", clock)
    monkeypatch.setattr(page, "_wake", clock)
    monkeypatch.setattr(server, "get_clients", lambda: {0: None})
    shown: list[tuple[float, float]] = []
    draw = page._draw
    monkeypatch.setattr(
        page, "_draw", lambda passed: (draw(passed), shown.append((clock.now, page._clock)))
    )
    with pytest.raises(StopIteration):
        page.run()
    before = max(t for now, t in shown if now < 2.0)
    still = [now for now, t in shown if t == before and now >= 2.0]
    assert still == pytest.approx([2.0, 2.3, 3.1], abs=0.01)
    # From there on it runs as fast as ever.
    last, t = shown[-1]
    assert last > 3.5
    assert t - before == pytest.approx((last - still[-1]) / page._slow.value, rel=1e-9)


# Curves.


def test_axes_grow_in_round_steps_and_shrink_only_when_asked() -> None:
    assert [round_above(value) for value in (0.011, 1.0, 3.1, 6.0, 8.5, 301.0)] == [
        0.015, 1.0, 4.0, 6.0, 10.0, 400.0
    ]  # fmt: skip
    axis, tops = SteadyAxis(), []
    for needed in (301.0, 310.0, 250.0, 401.0, 10.0):
        axis.hold(needed)
        tops.append(axis.top)
    assert tops == [400.0, 400.0, 400.0, 500.0, 500.0]
    axis.forget()
    axis.hold(10.0)
    assert axis.top == 15.0
    decades = SteadyDecades()
    for values, ends in (([0.9, 4e-4], (1e-4, 1.0)), ([1.1], (1e-4, 10.0)), ([0.5], (1e-4, 10.0))):
        decades.hold(values)
        assert decades.ends == pytest.approx(ends, rel=1e-12)
    decades.forget()
    decades.hold([0.5])
    assert decades.ends == pytest.approx((0.1, 1.0), rel=1e-12)


def test_slider_and_field_go_together_and_a_refused_text_changes_nothing(page: Page) -> None:
    controls, before = page._set, page._answer
    field, slider, said = (
        part["speed"] for part in (controls.fields, controls.sliders, controls.refusals)
    )
    assert not page._wake.is_set()
    slider.value = 700.0
    assert field.value == "700"
    assert page._wake.is_set()
    field.value = "720.5"
    assert (slider.value, said.content) == (720.5, "")
    page._answer = page._follow()
    assert page._answer.setting.startswith("speed 720.5 r/min")
    assert page._answer is not before
    shown = page._answer
    field.value = "99999"
    assert "speed: 180 to 900 r/min" in said.content
    assert "Shown: 720.5 r/min" in said.content
    assert slider.value == 720.5
    assert page._follow() is shown
    page._press("reset")
    page._act()
    page._answer = page._follow()
    assert (field.value, slider.value, said.content) == ("650", 650.0, "")
    assert page._answer.setting == before.setting
