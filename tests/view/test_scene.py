"""The scene: solids, film, animation and page, without a browser."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import manifold3d
import numpy as np
import pinocchio as pin
import pytest
import trimesh
import yourdfpy

from nipper_pin import Case, InputError, Solution, load, save, simulate
from nipper_pin.cli import main
from nipper_pin.errors import SingularConfigurationError
from nipper_pin.hybrid.case import Window
from nipper_pin.mechanism import collision_model, find_model, from_sources, known_models
from nipper_pin.view.scene import Film, Look, film
from nipper_pin.view.scene.pace import pace
from nipper_pin.view.scene.page import scene_page
from nipper_pin.view.scene.readings import readings
from nipper_pin.view.scene.solids import CYLINDER, FIXED, Solid, solids
from nipper_pin.view.scene.tracks import animation

FOLDER = find_model("e62")
DRAWN = ["e62", "e62_offset_guide"]
MODELS = Path(__file__).parents[1] / "verification" / "models"
COMMAND = [sys.executable, "-c", "import sys; from nipper_pin.cli import main; sys.exit(main())"]


@pytest.fixture(scope="session")
def plain(cycle: Solution) -> Film:
    return film(cycle, Look())


@pytest.fixture(scope="session")
def large(cycle: Solution) -> Film:
    return film(cycle, Look(exaggerate=50.0))


def vertices(solid: Solid) -> np.ndarray:
    """Corners of a drawn mesh in the frame of its body."""
    points = np.asarray(trimesh.load_mesh(solid.path).vertices) * solid.scale
    return points @ solid.placement[:3, :3].T + solid.placement[:3, 3]


def named(e62, name: str) -> Solid:
    return next(item for item in solids(e62) if item.name == name)


def track(shown: Film, end: str, kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of the track of a node, decoded from the message to the viewer."""
    command = animation(shown, solids(shown.solution.mechanism))
    for item in command["animations"]:
        for found in item["clip"]["tracks"]:
            if item["path"].endswith(end) and found["name"] == f".{kind}":
                t = np.frombuffer(found["times"].data, dtype="<f4")
                return t, np.frombuffer(found["values"].data, dtype="<f4").reshape(len(t), -1)
    raise AssertionError(end)


def test_another_viewer_finds_every_mesh_and_the_machine_in_its_place() -> None:
    """yourdfpy knows nothing of this package: it resolves, scales and places the meshes itself.

    At q = 0 the lips just meet. The top lip is a polygon of 14 chords in a quarter of a circle of
    1.5 mm, so that its lowest point lies at most 1.5 mm (1 - cos(pi / 56)) = 2.4 um above the
    round it stands for.
    """
    robot = yourdfpy.URDF.load(str(FOLDER / "e62.urdf"), load_meshes=True)
    wanted = {item.get("name") for item in ElementTree.parse(FOLDER / "e62.urdf").iter("visual")}
    assert len(robot.scene.geometry) == len(wanted) == 21
    low, high = robot.scene.bounds
    assert 0.28 < high[1] - low[1] < 0.32
    # The eccentric's head stands highest, 20 mm over its pin; the pendulum shaft is rearmost.
    assert high[2] == pytest.approx(0.2618487823687206 + 0.020, abs=1e-5)
    assert low[0] == pytest.approx(-0.19 - 0.04, abs=1e-6)
    contact = load().stop("jaw").contact
    for name, side in (("top_lip", 1.0), ("cushion_plate", -1.0)):
        (node,) = [item for item in robot.scene.graph.nodes_geometry if name in item]
        matrix, geometry = robot.scene.graph[node]
        points = trimesh.transform_points(robot.scene.geometry[geometry].vertices, matrix)
        gap = side * ((points - contact.point) @ contact.normal)
        assert gap.min() == pytest.approx(0.0, abs=5e-6)


@pytest.mark.parametrize("model", DRAWN)
def test_meshes_are_closed_and_all_of_them_used(model: str) -> None:
    folder = find_model(model)
    files = {f"meshes/{path.name}": path for path in (folder / "meshes").iterdir()}
    robot = ElementTree.parse(folder / f"{model}.urdf")
    assert {item.get("filename") for item in robot.iter("mesh")} == set(files)
    for name, path in files.items():
        mesh = trimesh.load_mesh(path)
        assert mesh.is_watertight, name
        assert mesh.volume > 0.0, name


def test_all_meshes_of_the_package_are_small() -> None:
    """The least of a mesh, a tetrahedron, is counted too: a glob that finds nothing would fail."""
    sizes = [path.stat().st_size for path in FOLDER.parent.glob("*/meshes/*")]
    assert len(sizes) >= 20 * len(DRAWN)
    assert sum(sizes) < 2_000_000


def test_the_engine_does_not_see_what_is_drawn(e62) -> None:
    """Without any visual the tree and the collision shapes are the same to the last bit."""
    bare = re.sub(r"<visual\b.*?</visual>", "", e62.urdf, flags=re.S)
    assert "<mesh" not in bare
    other = from_sources("e62", bare, e62.description, e62.mesh_folder)
    assert other.model == e62.model
    one, two = collision_model(e62)[0], collision_model(other)[0]
    assert [item.name for item in one.geometryObjects] == [i.name for i in two.geometryObjects]
    assert all(a == b for a, b in zip(one.geometryObjects, two.geometryObjects, strict=True))


@pytest.fixture(scope="session")
def offset_guide() -> Film:
    mechanism = load("e62_offset_guide")
    return film(simulate(mechanism, Case(speed_rpm=350.0, window=Window.CYCLE)), Look())


@pytest.mark.parametrize("name", ["plain", "large", "offset_guide"])
def test_drawn_links_never_run_through_one_another(
    name: str, request: pytest.FixtureRequest
) -> None:
    """Overlaps of all pairs over a turn, by a library of solids: none, also exaggerated.

    Holes are 0.1 mm wider than their pins, which the sag of their chords (50 um, or 30 um at 20 mm
    and 56 to a turn) does not close; a link in a wrong place would overlap by whole pins.
    """
    shown = request.getfixturevalue(name)
    drawn = [item for item in solids(shown.solution.mechanism) if item.spring is None]
    bodies = []
    for item in drawn:
        mesh = trimesh.load_mesh(item.path)
        mesh.apply_transform(item.placement)
        bodies.append(
            manifold3d.Manifold(
                manifold3d.Mesh(mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32))
            )
        )
    assert all(body.volume() > 0.0 for body in bodies)
    for k in range(0, len(shown.angle), 40):
        placed = []
        for item, body in zip(drawn, bodies, strict=True):
            angle, place = 0.0, np.zeros(2)
            if item.body == CYLINDER:
                angle = shown.turned[k]
            elif item.body != FIXED:
                angle, place = shown.angle[k, item.body], shown.position[k, item.body]
            c, s = math.cos(angle), math.sin(angle)
            placed.append(body.transform([[c, 0, -s, place[0]], [0, 1, 0, 0], [s, 0, c, place[1]]]))
        for i, j in itertools.combinations(range(len(drawn)), 2):
            if drawn[i].body != drawn[j].body:
                overlap = (placed[i] ^ placed[j]).volume()
                assert overlap < 1e-12, (drawn[i].name, drawn[j].name, shown.index[k])


def test_springs_stay_between_nut_and_tube(large: Film) -> None:
    """Both ends of the drawn coil, from the meshes' corners, in every frame of a motion whose
    stroke passes 5 mm; meshes are stored in single precision (1e-8 of 0.2 m)."""
    mechanism = large.solution.mechanism
    stroke = next(item.index for item in mechanism.springs)
    head = mechanism.model.jointPlacements[mechanism.model.getJointId("steeve")].translation
    up = head / np.linalg.norm(head)
    nuts = vertices(named(mechanism, "steeve_nuts"))
    nut = (nuts[np.abs(nuts[:, 1]) < 0.09] @ up).max()
    tube = ((vertices(named(mechanism, "steeve_tubes")) + head) @ up).min()
    assert large.drawn[:, stroke].max() > 0.005
    for name in ("spring_steeve_left", "spring_steeve_right"):
        spring = named(mechanism, name)
        start = spring.placement[:3, 3] @ up
        assert spring.placement[:3, 2] == pytest.approx(up, abs=1e-12)
        assert start == pytest.approx(nut, abs=1e-7)
        _, scale = track(large, name, "scale")
        ends = start + scale[:, 2]
        np.testing.assert_allclose(ends, tube - large.drawn[:, stroke], atol=1e-7)
        assert np.ptp(scale[:, :2]) == 0.0
    coil = trimesh.load_mesh(FOLDER / "meshes" / "spring.stl")
    np.testing.assert_allclose(coil.bounds[:, 2], [0.0, 1.0], atol=1e-7)


def test_links_stand_where_pinocchio_puts_them(plain: Film) -> None:
    """Tracks decoded and turned back into matrices; single precision of 0.3 m is 2e-8 m."""
    mechanism = plain.solution.mechanism
    model, data = mechanism.model, mechanism.model.createData()
    for link, joint in enumerate(mechanism.joints):
        t, place = track(plain, f"/{joint.child}", "position")
        _, turn = track(plain, f"/{joint.child}", "quaternion")
        np.testing.assert_allclose(t, plain.pace.playback, rtol=1e-6)
        for k in range(0, len(t), 60):
            pin.forwardKinematics(model, data, plain.q[k])
            true = data.oMi[model.getJointId(joint.name)]
            np.testing.assert_allclose(place[k], true.translation, atol=5e-8)
            found = pin.Quaternion(*(float(turn[k, i]) for i in (3, 0, 1, 2))).matrix()
            np.testing.assert_allclose(found, true.rotation, atol=3e-7)
        # Between frames the viewer takes the short way round.
        assert np.abs(np.diff(plain.angle[:, link])).max() < 0.2


def test_the_crank_pin_stays_in_its_slot(plain: Film) -> None:
    """The cylinder's drawn rotation and the pendulum's meet: the pin lies on the bar's line."""
    law = next(item.law for item in plain.solution.mechanism.drives if item.name == "pendulum")
    _, turn = track(plain, "/cylinder", "quaternion")
    _, arm = track(plain, "/pendulum_arm", "quaternion")

    def angle(quaternion: np.ndarray) -> np.ndarray:
        return -2.0 * np.arctan2(quaternion[:, 1], quaternion[:, 3])

    touch = plain.solution.mechanism.cylinder.angle_at_touch_rad
    pins = np.array(law.crank_axis) + law.crank_radius_m * np.column_stack(
        [np.cos(touch + angle(turn)), np.sin(touch + angle(turn))]
    )
    shape = collision_model(plain.solution.mechanism)[0]
    (bar,) = [item for item in shape.geometryObjects if item.name == "guide_bar"]
    along = bar.placement.rotation[[0, 2], 0]
    c, s = np.cos(angle(arm)), np.sin(angle(arm))
    normal = np.column_stack([-s * along[0] - c * along[1], c * along[0] - s * along[1]])
    apart = ((pins - np.array(law.guide_axis)) * normal).sum(axis=1)
    # The URDF gives the bar's place to 5e-6 m; half a degree of error would be 1 mm.
    assert np.abs(apart).max() < 2e-5


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
    assert film(cycle, Look()).drawn is not large.drawn


def test_time_is_stretched_around_events_and_nowhere_else(cycle: Solution) -> None:
    """The two clocks, differenced: 1000 within 1 % of a turn of any event, 50 far from all.

    Playback grows by the integral of the stretch, so that from frame to frame its rate lies between
    the stretches of both, except for round-off in differences of nearby times.
    """
    found = pace(cycle, 1000.0)
    events = np.array([event.t for event in cycle.events])
    assert set(events) <= set(found.machine)
    assert found.machine[0] == 0.0
    assert found.machine[-1] == cycle.segments[-1].t_end
    assert (np.diff(found.machine) > 0.0).all()
    away = np.abs(found.machine[:, None] - events).min(axis=1) / cycle.shaft.period
    np.testing.assert_allclose(found.stretch[away < 0.0099], 1000.0, rtol=1e-9)
    np.testing.assert_allclose(found.stretch[away > 0.055], 50.0, rtol=1e-9)
    rate = np.diff(found.playback) / np.diff(found.machine)
    low, high = (f(found.stretch[1:], found.stretch[:-1]) for f in (np.minimum, np.maximum))
    assert (rate > low * (1.0 - 1e-6)).all()
    assert (rate < high * (1.0 + 1e-6)).all()


def test_arrows_are_as_long_as_impulses(plain: Film) -> None:
    """Largest size of each arrow after each collision, decoded, against the table's impulses."""
    hits = plain.solution.collisions
    largest = max(item.impulse for item in hits)
    for stop in ("jaw", "steeve"):
        t, scale = track(plain, f"impulse_{stop}", "scale")
        assert (np.diff(t) >= 0.0).all()
        for hit in hits:
            # In single precision, as the times of the track are.
            at = float(np.float32(plain.pace.playback_at(hit.t)))
            shown = np.interp(at, t, scale[:, 1])
            if hit.stop == stop and hit.impulse > 0.01 * largest:
                assert shown == pytest.approx(hit.impulse / largest, rel=1e-3)
        # Nothing is left over at the end, long after the last collision.
        assert scale[-1].max() < 2e-3


def test_a_drawing_that_exaggerates_says_so(large: Film, plain: Film) -> None:
    assert "50 times as large, up to 6 deg" in str(readings(large)["note"])
    assert "times as large" not in str(readings(plain)["note"])


def test_page_is_one_file_that_asks_for_nothing(plain: Film) -> None:
    page = scene_page(plain)
    assert len(page.encode()) < 10_000_000
    # Outside of the script of the viewer, which holds addresses of XML name spaces.
    head, _, tail = page.partition("<script>")
    tail = tail[tail.index('<script id="scene"') :]
    assert not re.search(
        r"https?://|\bsrc=|@import|url\(", re.sub(r"(?s)<!--.*?-->", "", head + tail)
    )
    assert "MIT License" in head
    assert "@@" not in head


def test_a_link_without_its_meshes_is_drawn_by_its_collision_shapes(e62, tmp_path: Path) -> None:
    moved = dataclasses.replace(e62, mesh_folder=str(tmp_path))
    found = solids(moved)
    geometry, _ = collision_model(e62)
    assert {item.name for item in found} == {item.name for item in geometry.geometryObjects}
    assert {item.kind for item in found} == {"box", "cylinder"}


def test_links_without_a_material_are_told_apart() -> None:
    """The identified model says nothing of colours: one for each link, and grey for the frame."""
    mechanism = load("e62_identified")
    found: dict[int, set[tuple[float, float, float]]] = {}
    for item in solids(mechanism):
        found.setdefault(max(item.body, FIXED), set()).add(item.colour)
    assert all(len(colours) == 1 for body, colours in found.items() if body != FIXED)
    moving = [colours.pop() for body, colours in found.items() if body != FIXED]
    assert len(set(moving)) == len(moving) == len(mechanism.joints)
    assert all(max(colour) - min(colour) < 0.1 for colour in found[FIXED])


@pytest.mark.parametrize("name", sorted(known_models()))
def test_the_camera_sees_every_plain_body(name: str) -> None:
    """All corners of all collision shapes, as Pinocchio places them, are inside of the picture.

    The page lets the camera see 40 degrees from top to bottom: a cone of 20 around its axis in
    any window that is not higher than wide.
    """
    mechanism = load(name)
    case = Case(speed_rpm=mechanism.cylinder.rated_speed_rpm, window=Window.CYCLE)
    seen = re.search(
        r'"whole": \{"target": (\[.*?\]), "position": (\[.*?\])\}',
        scene_page(film(simulate(mechanism, case), Look())),
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


@pytest.mark.parametrize(
    ("name", "case"),
    [
        ("four_bar", Case(speed_rpm=300.0, window=Window.CYCLE, start_index=0.0)),
        ("bouncing_mass", Case(speed_rpm=60.0)),
    ],
)
def test_models_without_any_shape_are_drawn_as_bars(name: str, case: Case) -> None:
    mechanism = load(MODELS / name)
    found = solids(mechanism)
    assert {item.body for item in found} == set(range(len(mechanism.joints)))
    assert scene_page(film(simulate(mechanism, case), Look()))


def test_of_many_turns_the_first_two_are_shown(many_turns: Solution) -> None:
    shown = film(many_turns, Look())
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


@pytest.mark.parametrize("values", [{"slow": 1.0}, {"slow": 1e5}, {"exaggerate": 50.0}])
def test_looks_up_to_their_ends(values: dict[str, float]) -> None:
    assert Look(**values)
    with pytest.raises(InputError, match=r"cannot be used: 1 to (50|100000)$|: 1 to 1e\+05"):
        Look(**{key: 1.001 * value if value > 1.0 else 0.999 for key, value in values.items()})


def test_a_run_without_motion_says_so() -> None:
    still = simulate(load("e62", {"stops.jaw.restitution": 0.0}), Case(speed_rpm=450.0))
    with pytest.raises(InputError, match="no motion to show"):
        film(still, Look())


def test_a_gap_that_is_not_there_cannot_be_exaggerated() -> None:
    mechanism = load(MODELS / "four_bar")
    case = Case(speed_rpm=300.0, window=Window.CYCLE, start_index=0.0)
    with pytest.raises(InputError, match="no transition stop"):
        film(simulate(mechanism, case), Look(exaggerate=2.0))


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


def test_a_saved_run_is_shown_as_it_was(tmp_path: Path, cycle: Solution) -> None:
    saved, page = save(cycle, tmp_path / "run"), tmp_path / "run.html"
    assert main(["view", "--solution", str(saved), "--html", str(page)]) == 0
    text = page.read_text(encoding="utf-8")
    assert "650 r/min, window cycle" in text
    values = re.search(r'<script id="film" type="application/json">(.*?)</script>', text)
    assert values is not None
    assert json.loads(values[1])["playback"] == readings(film(cycle, Look()))["playback"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--solution", "run.npz", "--speed", "500"], "leave one of them out"),
        (["--solution", "missing.npz"], "missing.npz"),
        (["--exaggerate", "100"], "1 to 50"),
        (["--port", "70000", "--no-browser"], "port 70000"),
        (["--json", "-"], "--html"),
        (["--html", "/nowhere/at/all.html"], "cannot be written"),
    ],
)
def test_unusable_arguments_give_one_sentence_and_status_2(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert words in err


def test_a_port_that_is_taken_is_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert main(["view", "--port", str(port), "--no-browser"]) == 2
    assert f"port {port} cannot be used" in capsys.readouterr().err


def test_the_server_ends_on_interrupt() -> None:
    command = [*COMMAND, "view", "--port", "0", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdout is not None
        assert "http://127.0.0.1:" in server.stdout.readline()
        server.send_signal(signal.SIGINT)
        assert server.wait(timeout=60) == 0


def test_a_run_that_is_not_looked_at_imports_nothing_of_this() -> None:
    program = (
        "import sys; from nipper_pin.cli import main; main(['simulate', '--json', '-']); "
        "sys.stderr.write(' '.join(n for n in sys.modules if n.partition('.')[0] in "
        "{'meshcat', 'umsgpack', 'IPython', 'tornado', 'http', 'trimesh', 'webbrowser'} "
        "or n.startswith('nipper_pin.view.scene')))"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert done.stderr == ""
