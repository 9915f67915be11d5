"""Where every drawn solid, line and arrow stands, how it is turned and how large it is.

The page is read as three.js does (:mod:`three_js`). What it must show comes from Pinocchio's own
reading of the shapes in the URDF and from its kinematics of the run's states (:mod:`judge`). Convex
shapes are the same if they reach equally far in every direction.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh
from judge import Judge, press
from matplotlib.colors import to_rgba
from small_machines import SHAFT, SLED, hinge, link, machine, slide
from three_js import Scene, ball, box, ring, rotation

from nipper_pin import Case, InputError, Mechanism, Solution, Window, load, simulate
from nipper_pin.mechanism import from_sources
from nipper_pin.view.scene import Film, Look, film
from nipper_pin.view.scene.gif import MovingSketch
from nipper_pin.view.scene.objects import solid_commands
from nipper_pin.view.scene.page import scene_page
from nipper_pin.view.scene.solids import solids

MODELS = Path(__file__).parents[1] / "verification" / "models"
Array = Any
# Tracks hold single precision, 2^-24 of half a metre; states between nodes are interpolated here.
FINE = 3e-7
ARROW = "#D55E00"
DIRECTIONS = np.random.default_rng(5).normal(size=(40, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]

SHAPES = {
    "frame": [
        ("wall", '<box size="0.5 0.02 0.3"/>', "0.1 0.2 -0.3", "0 0.3 0", "0.2 0.4 0.8"),
        ("cylinder_drum", '<box size="0.1 0.2 0.05"/>', "0.05 0 -0.4", "0 0.1 0", "0.4 0.4 0"),
    ],
    "arm": [("bar", '<box size="0.2 0.02 0.03"/>', "-0.1 0 0", "0 0 0", "0.3 0.3 0.6")],
    "sled": [
        ("bed", '<box size="0.3 0.1 0.04"/>', "0.05 0.01 -0.02", "0 0.2 0", "0.9 0.5 0.1"),
        ("horn", '<mesh filename="horn.stl" scale="-1 2 0.5"/>', ".02 0 .05", ".7 -.4 .5", "1 0 0"),
    ],
    "flap": [("rod", '<cylinder radius="0.01" length="0.4"/>', "0.2 0 0.03", "0 1.4 0", "0 1 0")],
    "ball": [("head", '<sphere radius="0.03"/>', "0.01 -0.05 0.02", "0 0 0", "0 0.5 1")],
}  # fmt: skip


@pytest.fixture(scope="module")
def shaped(tmp_path_factory: pytest.TempPathFactory) -> Mechanism:
    """A machine with a shape of each kind, all turned and beside their links; one is mirrored."""
    folder = tmp_path_factory.mktemp("shapes")
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.03, 0], [0.02, 0.01, 0.2]])
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    trimesh.Trimesh(corners, faces).export(folder / "horn.stl")
    plain = press()
    guide = {
        "joint": "arm_pin", "law": "oscillating_guide", "crank_radius_mm": 30.0,
        "crank_axis_mm": [40.0, -350.0], "guide_axis_mm": [300.0, -300.0], **SHAFT,
    }  # fmt: skip
    document: Any = {
        **plain.description,
        "degrees_of_freedom": 4,
        "drives": {**plain.description["drives"], "arm": guide},  # type: ignore[dict-item]
    }
    arm = link("arm") + hinge("arm_pin", "frame", "arm", (0.3, -0.3))
    robot = ElementTree.fromstring(plain.urdf.replace("</robot>", f"{arm}</robot>"))
    for item in robot.findall("link"):
        for name, shape, xyz, rpy, rgb in SHAPES[str(item.get("name"))]:
            text = (
                f'<visual name="{name}"><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{shape}'
                f'</geometry><material name="m"><color rgba="{rgb} 1"/></material></visual>'
            )
            item.append(ElementTree.fromstring(text))
    urdf = ElementTree.tostring(robot, encoding="unicode")
    return from_sources("small", urdf, document, str(folder))


def turn(mechanism: Mechanism, speed: float = 60.0, start: float = 0.0) -> Solution:
    return simulate(mechanism, Case(speed_rpm=speed, window=Window.CYCLE, start_index=start))


@pytest.fixture(scope="module", params=["shaped", "e62", "e62_identified"])
def run(request: pytest.FixtureRequest, shaped: Mechanism) -> Solution:
    """Turns of machines whose shapes are plain, meshes, or those that serve to find contacts."""
    if request.param == "shaped":
        return turn(shaped)
    return turn(load(request.param), 650.0, 24.0)


@pytest.fixture(scope="module")
def judge(run: Solution) -> Judge:
    """Reads it in another way."""
    return Judge(run)


@pytest.fixture(scope="module")
def shown(run: Solution) -> Film:
    """Its film."""
    return film(run, Look())


@pytest.fixture(scope="module")
def scene(shown: Film) -> Scene:
    """The page."""
    return Scene(scene_page(shown))


@dataclass(frozen=True)
class Wanted:
    """A shape of the URDF.

    Attributes:
        path: Its node in the page.
        points: Points whose convex hull it is, in the world by configuration and cylinder angle.
        rgb: Its colour, 0 to 255; None where the URDF has none.
        mesh: True if its own corners are the points.
    """

    path: str
    points: Callable[[Array, float], Array]
    rgb: tuple[int, ...] | None
    mesh: bool


def shapes(judge: Judge) -> list[Wanted]:
    """All shapes as Pinocchio reads them."""
    mechanism = judge.run.mechanism
    robot = ElementTree.fromstring(mechanism.urdf)
    drawn = robot.find(".//visual") is not None
    tag, kind = ("visual", pin.VISUAL) if drawn else ("collision", pin.COLLISION)
    geometry = pin.buildGeomFromUrdfString(
        judge.model, mechanism.urdf, kind, package_dirs=[mechanism.mesh_folder or "."]
    )
    # Pinocchio knows a shape by its link and its number there.
    names = {}
    for item in robot.findall("link"):
        for place, element in enumerate(item.findall(tag)):
            names[f"{item.get('name')}_{place}"] = (str(item.get("name")), element)
    found = []
    for item in geometry.geometryObjects:
        owner, element = names[item.name]
        name = element.get("name") or item.name
        body = body_of(judge, robot, owner)
        turns = body == "frame" and name.startswith("cylinder_") and bool(crank(judge))
        path = f"/nipper/{'cylinder' if turns else body}/{name}"
        colour = element.find("material/color")
        rgb = None
        if colour is not None:
            parts = str(colour.get("rgba")).split()[:3]
            rgb = tuple(round(255.0 * float(part)) for part in parts)
        mesh = item.meshPath not in ("", "BOX", "CYLINDER", "SPHERE")
        found.append(Wanted(path, placed(judge, geometry, item, name, turns=turns), rgb, mesh))
    return found


def body_of(judge: Judge, robot: ElementTree.Element, owner: str) -> str:
    """The link that carries another one through fixed joints."""
    joints = {str(j.find("child").get("link")): j for j in robot.findall("joint")}  # type: ignore[union-attr]
    while owner in joints and joints[owner].get("name") not in judge.names:
        owner = str(joints[owner].find("parent").get("link"))  # type: ignore[union-attr]
    return owner if owner in joints else "frame"


def crank(judge: Judge) -> tuple[float, float] | None:
    """Axis of the cylinder by the document (x, z) [m]."""
    laws = [item for item in judge.document["drives"].values() if "crank_axis_mm" in item]
    return tuple(1e-3 * part for part in laws[0]["crank_axis_mm"]) if laws else None  # type: ignore[return-value]


def placed(
    judge: Judge, geometry: Any, item: Any, name: str, *, turns: bool
) -> Callable[[Array, float], Array]:
    """The function of ``Wanted.points``."""
    springs = [n for n in judge.document.get("springs", {}) if name.startswith(f"spring_{n}")]
    touch = math.radians(judge.document["cylinder"]["angle_at_touch_deg"])
    shape, data = item.geometry, geometry.createData()
    number = geometry.getGeometryId(item.name)
    if isinstance(shape, coal.Box):
        local = box(*(2.0 * shape.halfSide))
    elif isinstance(shape, coal.Sphere):
        local = ball(shape.radius)
    elif isinstance(shape, coal.Cylinder):
        half = np.array([0.0, 0.0, shape.halfLength])
        local = np.concatenate([ring(shape.radius) + half, ring(shape.radius) - half])
    else:
        local = np.asarray(trimesh.load_mesh(item.meshPath).vertices)

    def points(q: Array, psi: float) -> Array:
        size = np.array(item.meshScale) if len(item.meshScale) else np.ones(3)
        if isinstance(shape, coal.ShapeBase):
            size = np.ones(3)
        if springs:
            column = judge.names.index(judge.document["springs"][springs[0]]["joint"])
            size = size - [0.0, 0.0, q[column]]
        pin.updateGeometryPlacements(judge.model, judge.data, geometry, data, judge.full(q))
        place = data.oMg[number]
        found = (local * size) @ place.rotation.T + place.translation
        if turns:
            axis = np.array([crank(judge)[0], 0.0, crank(judge)[1]])  # type: ignore[index]
            c, s = math.cos(psi - touch), math.sin(psi - touch)
            found = (found - axis) @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) + axis
        return found

    return points


def moments(judge: Judge, shown: Film, count: int = 5) -> list[tuple[int, float, Array, float]]:
    """Some frames: place, time of playback [s], configuration, cylinder angle."""
    found = []
    for k in np.linspace(0, len(shown.pace.machine) - 1, count).astype(int):
        t = float(shown.pace.machine[k])
        q, _, _ = judge.state(t, left=k > 0)
        found.append((int(k), float(np.float32(shown.pace.playback[k])), q, judge.angle(t)))
    return found


def test_solids_of_the_page(judge: Judge, shown: Film, scene: Scene) -> None:
    """Each reaches as far as Pinocchio's in forty directions, or has its very corners; colours."""
    every = shapes(judge)
    drawn = {path for path in scene.objects if "/impulse_" not in path}
    assert drawn == {item.path for item in every}
    opening = judge.document["stops"][judge.document["transition_stop"]]["joint"]
    jaw = next(j.child for j in judge.run.mechanism.joints if j.name == opening)
    for item in every:
        for _, at, q, psi in moments(judge, shown):
            found, wanted = scene.points(item.path, at), item.points(q, psi)
            reach = (found @ DIRECTIONS.T).max(axis=0), (wanted @ DIRECTIONS.T).max(axis=0)
            # Points of two circles need not be the same ones: 1e-5 of a radius of 0.2 m.
            np.testing.assert_allclose(*reach, atol=FINE + 2e-6, err_msg=item.path)
            if item.mesh:
                np.testing.assert_allclose(found, wanted, atol=FINE, err_msg=item.path)
        if item.rgb is not None and f"/{jaw}/" not in item.path:
            assert scene.colour(item.path) == item.rgb


def test_solids_of_the_live_page(judge: Judge) -> None:
    """What viser is sent reaches as far as Pinocchio's shapes, but for triangles that are saved.

    A surface may be moved by 4e-4 of the reach, at a corner by more; circles have 48 corners.
    """
    viser = pytest.importorskip("viser", reason="viser is not installed (extra `live`)")
    from nipper_pin.view.live.stage import Stage

    mechanism = judge.run.mechanism
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        stage = Stage(server, mechanism)
        assert 0.5 < server.initial_camera.fov < 1.5
        for t in (0.0, 0.31 * judge.run.segments[-1].t_end):
            q, psi = judge.state(t, left=t > 0.0)[0], judge.angle(t)
            stage.pose(q, psi)
            for item in shapes(judge):
                _, _, body, name = item.path.split("/")
                owner = body if body in ("frame", "cylinder") else f"links/{body}"
                frame = server.scene.get_handle_by_name(f"/{owner}")
                mesh = server.scene.get_handle_by_name(f"/{owner}/{name}")
                found = np.asarray(mesh.vertices, dtype=float) * np.asarray(mesh.scale)
                for place in (mesh, frame):
                    w, *vector = place.wxyz
                    found = found @ rotation(np.array([*vector, w])).T + place.position
                wanted = item.points(q, psi)
                off = (found @ DIRECTIONS.T).max(axis=0) - (wanted @ DIRECTIONS.T).max(axis=0)
                size = float(np.ptp(wanted, axis=0).max())
                assert np.abs(off).max() < 2e-3 * mechanism.reach_m + 3e-3 * size, item.path
    finally:
        server.stop()


def test_a_mesh_that_no_viewer_reads_is_refused(shaped: Mechanism, tmp_path: Path) -> None:
    """The formats that can be read are named."""
    (tmp_path / "horn.ply").write_text("ply")
    urdf = shaped.urdf.replace("horn.stl", "horn.ply")
    odd = replace(shaped, urdf=urdf, mesh_folder=str(tmp_path))
    (horn,) = (item for item in solids(odd) if item.name == "horn")
    with pytest.raises(InputError, match=r"horn.ply: .*\.stl, \.obj, \.dae; convert"):
        list(solid_commands(odd, horn))


def test_colour_tells_the_phase(judge: Judge, shown: Film, scene: Scene) -> None:
    """The link that opens the transition stop has one colour for each set of closed stops.

    Where none is closed there are two: one for its bounces, and one for those of other stops.
    """
    opening = judge.document["stops"][judge.document["transition_stop"]]["joint"]
    jaw = next(j.child for j in judge.run.mechanism.joints if j.name == opening)
    coloured = {path for path, tracks in scene.tracks.items() if ".material.color" in tracks}
    assert coloured == {
        f"{item.path}/<object>" for item in shapes(judge) if item.path.startswith(f"/nipper/{jaw}/")
    }
    colours: dict[tuple[frozenset[str], bool], tuple[float, ...]] = {}
    for closed, begin, end in judge.phases:
        edges = np.interp([begin, end], shown.pace.machine, shown.pace.playback)
        # A change takes a thousandth of a second.
        if edges[1] - edges[0] > 0.1:
            for path in coloured:
                t, values = scene.tracks[path][".material.color"]
                for at in (edges[0] + 0.01, edges.mean(), edges[1] - 0.01):
                    now = tuple(round(float(np.interp(at, t, column)), 4) for column in values.T)
                    kind = closed, judge.bounces(closed, begin, end)
                    assert colours.setdefault(kind, now) == now
    assert len(set(colours.values())) == len(colours) > 1
    assert scene.options == {"play": True, "repetitions": math.inf}


def test_bars_of_links_without_shapes() -> None:
    """From each joint of a four-bar to the pins that hang on its link, with a ball at the joint."""
    mechanism = load(MODELS / "four_bar")
    run = turn(mechanism, 300.0)
    judge, shown = Judge(run), film(run, Look())
    scene = Scene(scene_page(shown))
    robot = ElementTree.fromstring(mechanism.urdf)
    hung: dict[str, list[str]] = {joint.child: [] for joint in mechanism.joints}
    for item in judge.document["closures"].values():
        for name in (item["frame_a"], item["frame_b"]):
            owner = body_of(judge, robot, name)
            if owner in hung:
                hung[owner].append(name)
    for joint in mechanism.joints:
        if joint.parent in hung:
            hung[joint.parent].append(joint.name)
    for _, at, q, _ in moments(judge, shown):
        pin.framesForwardKinematics(judge.model, judge.data, judge.full(q))
        for joint in mechanism.joints:
            begin = judge.data.oMi[judge.model.getJointId(joint.name)].translation
            far = [judge.data.oMf[judge.model.getFrameId(n)].translation for n in hung[joint.child]]
            paths = [path for path in scene.objects if path.startswith(f"/nipper/{joint.child}/")]
            ends = []
            for path in paths:
                points = scene.points(path, at)
                if path.endswith("/joint"):
                    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
                    np.testing.assert_allclose(middle, begin, atol=1e-6)
                    width = float(np.ptp(points, axis=0).max())
                    continue
                one, other = points[:720].mean(axis=0), points[720:].mean(axis=0)
                near, end = sorted((one, other), key=lambda x: float(np.linalg.norm(x - begin)))
                np.testing.assert_allclose(near, begin, atol=1e-6)
                thick = np.linalg.norm(points[:720] - one, axis=1)
                assert float(np.ptp(thick)) < 1e-9
                assert 2.0 * thick[0] < width < 0.1 * mechanism.reach_m
                ends.append(end)
            assert len(ends) == len(far)
            for end in far:
                assert min(float(np.linalg.norm(end - item)) for item in ends) < 2e-6


# Arrows.


def two_sided() -> Mechanism:
    """A ball on a slide and a flap on a hinge, on a sled: the flap's impulses are far larger."""
    return machine(
        [
            link("sled", 2.0, 0.1),
            slide("sled_x", "frame", "sled"),
            link("flap", 40.0, 30.0, (0.2, 0.03)),
            hinge("flap_pin", "sled", "flap", (0.1, 0.05)),
            link("ball", 0.7),
            slide("ball_z", "sled", "ball", (0.6, 0.8), (-0.2, 0.1)),
        ],
        3,
        gravity=9.81,
        drives={"sled": {"joint": "sled_x", "law": "screw", "lead_mm_per_turn": 80.0, **SLED}},
        stops={
            "ball": {"joint": "ball_z", "restitution": 0.3, "side": "lower", "at_mm": -20.0},
            "flap": {"joint": "flap_pin", "restitution": 0.4, "at_deg": -8.0},
        },
        phases=[
            {"number": number, "name": "and ".join(closed) or "free", "closed": closed}
            for number, closed in enumerate(([], ["ball"], ["flap"], ["ball", "flap"]), start=1)
        ],
    )


@pytest.fixture(scope="module", params=["e62", "two_sided"])
def struck(request: pytest.FixtureRequest) -> Judge:
    """A turn with impulses at two contact points, or with one that is a moment."""
    if request.param == "e62":
        return Judge(turn(load("e62"), 650.0, 24.0))
    return Judge(turn(two_sided()))


def forces(judge: Judge) -> dict[str, list[tuple[float, float, Array]]]:
    """Times, impulses [N s] and configurations of collisions, by stops that no moment closes."""
    found: dict[str, list[tuple[float, float, Array]]] = {}
    for event in judge.hits:
        item = judge.stops[event.stops[0]]
        if item.lever is not None or not item.turns:
            impulse = judge.impulses(event)[0][event.stops[0]] / (item.lever or 1.0)
            found.setdefault(event.stops[0], []).append((event.t, impulse, event.q))
    return found


def carrier(judge: Judge, name: str) -> tuple[str, Array, Array]:
    """Link before a stop's joint; foot and direction of the push in the world at q = 0 (x, z)."""
    column = judge.stops[name].column
    joint = judge.run.mechanism.joints[column]
    contact = judge.run.mechanism.stop(name).contact
    if contact is not None:
        return joint.parent, contact.point[[0, 2]], contact.normal[[0, 2]]
    zero = np.zeros(len(judge.names))
    at = np.array(judge.places(zero)[joint.child][:2])
    way = np.array(judge.places(judge.unit(column))[joint.child][:2]) - at
    return joint.parent, at, judge.stops[name].sense * way / np.linalg.norm(way)


def test_arrows_of_the_page(struck: Judge) -> None:
    """Foot at the contact, direction of the push, length by the largest impulse that is drawn."""
    shown = film(struck.run, Look())
    scene = Scene(scene_page(shown))
    found = forces(struck)
    paths = [path.split("/impulse_")[1] for path in scene.objects if "/impulse_" in path]
    assert {path.split("/")[0] for path in paths} == set(found)
    largest = max(impulse for items in found.values() for _, impulse, _ in items)
    reach = struck.run.mechanism.reach_m
    unit = None
    checked = 0
    for name, items in found.items():
        joint, foot, way = carrier(struck, name)
        starts = np.interp([t for t, _, _ in items], shown.pace.machine, shown.pace.playback)
        path = next(p for p in scene.objects if f"/impulse_{name}/" in p).rpartition("/")[0]
        t, size = scene.tracks[path][".scale"]
        for event in struck.hits:
            at = float(np.interp(event.t, shown.pace.machine, shown.pace.playback))
            # A second after its own collisions there is no arrow, whatever else is struck.
            if not any(-0.1 < at - start < 1.1 for start in starts):
                assert np.interp(at, t, size[:, 1]) < 1e-4
        for (_, impulse, q), at, after in zip(items, starts, [*starts[1:], 1e9], strict=True):
            if after - at < 2e-3 or impulse < 1e-3 * largest:
                continue
            checked += 1
            now = float(np.float32(at))
            shaft, head = (scene.points(f"{path}/{part}", now) for part in ("shaft", "head"))
            if joint in struck.places(q):
                zero = np.zeros(len(q))
                begin, ahead = (struck.point(joint, p, zero, q) for p in (foot, foot + way))
            else:
                begin, ahead = foot, foot + way
            along = np.array([ahead[0] - begin[0], 0.0, ahead[1] - begin[1]])
            start = np.array([begin[0], 0.0, begin[1]])
            # Along the push: the shaft ends where the head begins.
            ends = [(part - start) @ along for part in (shaft, head)]
            assert ends[0].min() == pytest.approx(0.0, abs=1e-4 * reach)
            assert ends[0].max() == pytest.approx(ends[1].min(), abs=1e-5 * reach)
            tip = head[int(np.argmax(ends[1]))] - start
            length = float(ends[1].max())
            np.testing.assert_allclose(tip, length * along, atol=1e-4 * reach)
            unit = unit or length / impulse
            assert length == pytest.approx(unit * impulse, rel=2e-3)
            # It stays for half a second, or until the next one.
            size = scene.tracks[path][".scale"]
            until = min(at + 0.5, after - 2e-3)
            still = [np.interp(x, size[0], size[1][:, 1]) for x in (now, until)]
            assert still[0] == pytest.approx(still[1], rel=1e-6)
            width = []
            for part in (shaft, head):
                across = part - start - np.outer((part - start) @ along, along)
                width.append(float(np.linalg.norm(across, axis=1).max()))
                assert width[-1] == pytest.approx(np.abs(across[:, 1]).max(), rel=1e-3)
                assert width[-1] == pytest.approx(np.abs(across[:, 0] / along[2]).max(), rel=1e-3)
            # Narrower than long, and the head wider than the shaft.
            assert width[0] < width[1]
            assert width[1] < 0.5 * math.sqrt(length * unit * largest)
    assert checked > 3
    assert unit is not None
    # The largest is a part of the machine that neither covers it nor is lost in it.
    assert 0.05 * reach < unit * largest < 0.5 * reach


def test_arrows_of_the_picture(struck: Judge) -> None:
    """After a collision an arrow of the GIF is as long as the impulse by the largest drawn."""
    shown = film(struck.run, Look())
    moving = MovingSketch(shown)
    found = forces(struck)
    largest = max(impulse for items in found.values() for _, impulse, _ in items)
    pairs = []
    for name, items in found.items():
        starts = np.interp([t for t, _, _ in items], shown.pace.machine, shown.pace.playback)
        others = [t for other, rest in found.items() for t, _, _ in rest if other != name]
        others = np.interp(others, shown.pace.machine, shown.pace.playback).tolist()
        for (t, impulse, _), at, after in zip(items, starts, [*starts[1:], 1e9], strict=True):
            frame = int(np.searchsorted(shown.pace.machine, t)) + 1
            now = float(shown.pace.playback[frame])
            near = [x for x in others if abs(x - now) < 1.1]
            # Held for 0.6 s after a collision.
            if near or not at < now < min(after, at + 0.55) or impulse < 0.1 * largest:
                continue
            moving.picture(frame)
            (corners,) = (
                patch.get_transform().transform(patch.get_xy())
                for patch in moving.figure.axes[0].patches
                if patch.get_visible() and patch.get_facecolor() == to_rgba(ARROW)
            )
            x, y = corners.T
            pairs.append((impulse / largest, float(np.hypot(np.ptp(x), np.ptp(y)))))
    assert max(share for share, _ in pairs) > 0.99
    full = max(length for _, length in pairs)
    assert full > 40.0
    for share, length in pairs:
        # Pixels, and the width of the head, which shrinks less.
        assert length == pytest.approx(share * full, abs=8.0)
