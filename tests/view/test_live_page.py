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
from nipper_pin.view.live.lips import Lips
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


MM, PIXELS = 1e3, (320.0, 180.0)


def matrices(style: str) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """By link: matrix and shift of (x, z) [mm] in the link to pixels, as CSS defines them."""
    found = {}
    for body, numbers in re.findall(r"\.lips-(\d+) \{ transform: matrix\(([^)]*)\)", style):
        a, b, c, d, e, f = map(float, numbers.split(","))
        found[int(body)] = np.array([[a, c], [b, d]]), np.array([e, f])
    return found


def contact_in(mechanism: Mechanism) -> dict[str, np.ndarray]:
    """The contact point (x, z) [mm] in the frames of both lips, which meet there at zero."""
    model, data = mechanism.model, mechanism.model.createData()
    pin.forwardKinematics(model, data, np.zeros(model.nq))
    point = mechanism.stop("jaw").contact.point
    return {
        joint.child: MM * data.oMi[model.getJointId(joint.name)].actInv(point)[[0, 2]]
        for joint in mechanism.joints
    }


def placed(e62: Mechanism, style: str) -> dict[str, np.ndarray]:
    """Where the contact points of both lips are drawn [pixels]."""
    place, names = contact_in(e62), [joint.child for joint in e62.joints]
    return {names[k]: matrix @ place[names[k]] + shift
            for k, (matrix, shift) in matrices(style).items()}  # fmt: skip


@pytest.mark.parametrize("larger", [1.0, 10.0])
def test_both_lips_stand_apart_by_the_gap(e62: Mechanism, larger: float) -> None:
    """The lower one in the middle, the upper one above it by lever times angle, to second order.

    Drawn at the wrong scale, mirrored or turned, the contact point of the upper lip would lie
    elsewhere: its place is computed by Pinocchio's own kinematics of another configuration.
    """
    run = run_of("transition")
    first = run.collisions[0]
    q = run.trajectory.evaluate(first.t + 0.5 * first.rebound_time).q[0]
    angle = e62.stop("jaw").gap(q)
    style = Lips(e62).style(q, first.rebound_amplitude, larger)
    at, middle = placed(e62, style), 0.5 * np.array(PIXELS)
    assert at["bottom_nipper"] == pytest.approx(middle, abs=2e-3)
    scale = PIXELS[1] / {1.0: 12.0, 10.0: 25.0}[larger]
    gap = MM * e62.stop("jaw").lever * angle
    up = middle[1] - at["top_nipper"][1]
    # The chord of a circle differs from its arc by angle / 2 of it.
    assert up == pytest.approx(scale * gap, rel=angle)
    assert abs(at["top_nipper"][0] - middle[0]) < 1.5 * angle * scale * gap + 2e-3
    for matrix, _ in matrices(style).values():
        # (x, z) to pixels, whose second axis points down: a rotation, mirrored.
        assert np.linalg.det(matrix) == pytest.approx(-(scale**2), rel=1e-4)


@pytest.mark.parametrize(
    ("gap_mm", "larger", "high", "bar", "told"),
    [(0.0, 1.0, 12.0, 2, "true"), (2.9, 1.0, 12.0, 2, "true"), (3.1, 1.0, 25.0, 5, "true"),
     (0.5, 20.0, 50.0, 10, "rebounds x 20"), (1000.0, 1.0, 250.0, 50, "true")],
)  # fmt: skip
def test_the_view_holds_the_largest_rebound(
    e62: Mechanism, gap_mm: float, larger: float, high: float, bar: int, told: str
) -> None:
    """Closed lips meet in its middle, and a bar tells its scale."""
    angle = gap_mm / MM / e62.stop("jaw").lever
    style = Lips(e62).style(np.zeros(e62.model.nv), angle, larger)
    scale = np.sqrt(-np.linalg.det(matrices(style)[1][0]))
    assert scale == pytest.approx(PIXELS[1] / high, rel=1e-4)
    assert f'content: "bar {bar} mm; {told}"' in style
    (shown,) = re.findall(r"\.lips-bar \{[^}]*scale\(([\d.]+), 1\)", style)
    assert float(shown) == pytest.approx(bar * scale, rel=1e-4)
    at = placed(e62, style)
    for lip in ("top_nipper", "bottom_nipper"):
        assert at[lip] == pytest.approx(0.5 * np.array(PIXELS), abs=2e-3)


def test_outlines_are_those_of_the_meshes(e62: Mechanism) -> None:
    """Each link that is cut has its outline, inside of the box around its visuals."""
    html = Lips(e62).html
    names = [joint.child for joint in e62.joints]
    assert {"top_nipper", "bottom_nipper"} <= {
        names[int(k)] for k in re.findall(r'class="lips-(\d+)"', html)
    }
    for outline in re.findall(r' d="([^"]*)"', html):
        points = np.array([pair.split() for pair in re.findall(r"[ML]([-\d. ]+)", outline)], float)
        assert len(points) > 2
        assert np.abs(points).max() < MM * e62.reach_m


def test_a_stop_without_contact_point_has_no_close_up() -> None:
    lips = Lips(run_of("balls").mechanism)
    assert lips.html == ""
    assert lips.style(np.zeros(2), 0.0, 1.0) == ""
