"""Where every drawn solid, line and arrow stands, how it is turned and how large it is.

The page is read as three.js does (:mod:`three_js`). What it must show comes from Pinocchio's own
reading of the shapes in the URDF and from its kinematics of the run's states (:mod:`judge`). Convex
shapes are the same if they reach equally far in every direction.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from judge import Judge, press
from runs_shown import machine_called, run_of, turn
from scipy.spatial import ConvexHull
from scipy.spatial.distance import cdist
from three_js import Scene
from urdf_shapes import shaped, shapes

from nipper_pin import Mechanism, Solution, load
from nipper_pin.mechanism import from_sources, known_models
from nipper_pin.view.scene import Film, Look, Solid, film, pictured, solids

MODELS = Path(__file__).parents[1] / "verification" / "models"
Array = Any
# Tracks hold single precision, 2^-24 of half a metre; states between nodes are interpolated here.
FINE = 3e-7
DIRECTIONS = np.random.default_rng(5).normal(size=(40, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]

# Plates, slides, slots, struts and bars.
FEW = ("peaucellier", "toggle_press", "slider_crank", "jaw_crusher", "ratchet_feed", "door_closer")
SMALL = ("aside", "boxed", "balls", "elements")


def run_called(name: str) -> Solution:
    """A run of a model of the package, of a machine of the gallery, or of another one."""
    if name in SMALL:
        return run_of(name)
    if name == "four_bar":
        return turn(load(MODELS / name), 300.0)
    made = machine_called(name)
    return turn(made, made.cylinder.rated_speed_rpm, 24.0)


@pytest.mark.parametrize("name", [*sorted(known_models()), *FEW, *SMALL, "four_bar"])
def test_every_link_stands_where_pinocchio_has_it(name: str, page_of: Callable[..., str]) -> None:
    """Place and rotation of its node at some moments; a machine without shapes has bars there."""
    run = run_called(name)
    shown, judge = film(run, Look(exaggerate=1.0)), Judge(run)
    scene = Scene(page_of(shown.solution))
    drawn = {path.split("/")[2] for path in scene.objects}
    children = {joint.child for joint in run.mechanism.joints}
    if not re.search("<(visual|collision)", run.mechanism.urdf):
        assert drawn & children == children
    for _, at, q, _ in moments(judge, shown):
        pin.forwardKinematics(judge.model, judge.data, judge.full(q))
        for joint in run.mechanism.joints:
            wanted = judge.data.oMi[judge.model.getJointId(joint.name)].homogeneous
            found = scene.matrix(f"/nipper/{joint.child}", at)
            np.testing.assert_allclose(found, wanted, atol=2.0 * FINE, err_msg=joint.child)


@pytest.fixture(scope="module", params=["shaped", "e62", "e62_identified"])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Solution:
    """Turns of machines whose shapes are plain, meshes, or those that serve to find contacts."""
    if request.param == "shaped":
        return turn(shaped(tmp_path_factory.mktemp("shapes")), 60.0)
    return turn(load(request.param), 650.0, 24.0)


@pytest.fixture(scope="module")
def judge(run: Solution) -> Judge:
    return Judge(run)


@pytest.fixture(scope="module")
def shown(run: Solution) -> Film:
    return film(run, Look(exaggerate=1.0))


@pytest.fixture(scope="module")
def scene(shown: Film, page_of: Callable[..., str]) -> Scene:
    return Scene(page_of(shown.solution))


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
    more = drawn - {item.path for item in every}
    assert drawn >= {item.path for item in every}
    assert all(re.search("/(stop|spring)_", path) for path in more)
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


# Lines between two points.


def test_lines_go_from_point_to_point(page_of: Callable[..., str]) -> None:
    """From frame to frame of springs and dampers, in the plane."""
    run = run_of("elements")
    shown, judge = film(run, Look(exaggerate=1.0)), Judge(run)
    scene = Scene(page_of(shown.solution))
    lengths = set()
    for _, at, q, _ in moments(judge, shown):
        pin.framesForwardKinematics(judge.model, judge.data, judge.full(q))
        for kind, name in (("spring", "band"), ("damper", "stay")):
            item = judge.document[f"{kind}s"][name]
            frames = (judge.model.getFrameId(item[key]) for key in ("frame_a", "frame_b"))
            places = [judge.data.oMf[frame].translation * (1, 0, 1) for frame in frames]
            place = scene.matrix(f"/nipper/{kind}_{name}", at)
            ends = [(place @ [0.0, side, 0.0, 1.0])[:3] for side in (-0.5, 0.5)]
            np.testing.assert_allclose(ends, places, rtol=0.0, atol=1e-6)
            lengths.add(round(float(np.linalg.norm(np.subtract(*ends))), 5))
    assert len(lengths) > 4


# Springs and stops on joints.


def outline(drawn: list[Solid], pose: tuple[float, float, float]) -> Array:
    """Points along the edges of what solids of one link cover in side view, shape (N, 2) [m]."""
    found, (x, z, turned) = [], pose
    way = np.array([[math.cos(turned), math.sin(turned)], [-math.sin(turned), math.cos(turned)]])
    for solid in drawn:
        corners = solid.mesh[0] * solid.scale @ solid.placement[:3, :3].T
        flat = (corners + solid.placement[:3, 3])[:, [0, 2]] @ way + [x, z]
        edge = flat[ConvexHull(flat).vertices]
        found += [
            np.linspace(a, b, 60) for a, b in zip(edge, np.roll(edge, 1, axis=0), strict=True)
        ]
    return np.concatenate(found)


@pytest.mark.parametrize("name", [*FEW, "bell", "needle_bar", "sieve"])
def test_springs_end_at_their_links_and_closed_stops_touch_them(name: str) -> None:
    made = machine_called(name)
    judge = Judge(turn(made, made.cylinder.rated_speed_rpm, 24.0))
    drawn = pictured(made)
    size = max(np.ptp(outline([solid], (0.0, 0.0, 0.0)), axis=0).max() for solid in drawn)
    for column, joint in enumerate(made.joints):
        own = [solid for solid in solids(made) if solid.body == column]
        if not judge.turning[column]:
            # A rod in a tube passes its stop: what meets it is the eye at its end.
            own = [min(own, key=lambda solid: np.hypot(*solid.placement[[0, 2], 3]))]
        for value in (0.0, 0.1):
            places = {"frame": (0.0, 0.0, 0.0), **judge.places(value * judge.unit(column))}
            for spring in (item for item in made.springs if item.index == column):
                (coil,) = (item for item in drawn if item.name == f"spring_{spring.name}")
                long = coil.scale[2] + (coil.stretch * value if coil.spring == column else 0.0)
                end = coil.placement[:3, 3] + long * coil.placement[:3, 2]
                x, z, turned = places[joint.parent]
                e = complex(end[0], end[2]) * complex(math.cos(turned), math.sin(turned))
                assert (x + e.real, z + e.imag) == pytest.approx(places[joint.child][:2], abs=1e-9)
        for stop in (item for item in made.stops if item.index == column):
            (mark,) = (item for item in drawn if item.name == f"stop_{stop.name}")
            gap = 0.2 if judge.turning[column] else 0.1 * size
            apart = []
            for value in (stop.at, stop.at + stop.sense * gap):
                places = {"frame": (0.0, 0.0, 0.0), **judge.places(value * judge.unit(column))}
                edges = outline([mark], places[joint.parent]), outline(own, places[joint.child])
                apart.append(float(cdist(*edges).min()))
            assert apart[0] < (0.03 if judge.turning[column] else 1e-3) * size
            assert apart[1] > apart[0] + 0.01 * size


def test_a_shape_of_the_urdf_stands_for_a_stop() -> None:
    """If it is called so: two of one name would be one node of the page."""
    made = machine_called("sieve")
    (old,) = (item for item in pictured(made) if item.name == "stop_rear")
    link = made.joints[old.body].child
    shape = '<visual name="stop_rear"><geometry><box size="1 1 1"/></geometry></visual>'
    urdf = made.urdf.replace(f'<link name="{link}">', f'<link name="{link}">{shape}')
    other = from_sources("sieve", urdf, made.description, ".")
    (own,) = (item for item in pictured(other) if item.name == "stop_rear")
    assert (own.body, own.sizes) == (old.body, (1.0, 1.0, 1.0))


# Arrows.


def two_sided() -> Mechanism:
    """The press with a flap at its hinge that is struck far harder than its ball."""
    plain = press()
    urdf = plain.urdf.replace('value="1.5"', 'value="40.0"').replace('"0.02"', '"30.0"')
    return from_sources("small", urdf, plain.description, ".")


@pytest.fixture(scope="module", params=["e62", "two_sided", "boxed"])
def struck(request: pytest.FixtureRequest) -> Judge:
    """Impulses at two contact points, one that is a moment, or floor and ceiling of a box."""
    if request.param == "two_sided":
        return Judge(turn(two_sided(), 60.0))
    return Judge(run_of(request.param))


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


def test_arrows_of_the_page(struck: Judge, page_of: Callable[..., str]) -> None:
    """Foot at the contact, direction of the push, length by the largest impulse that is drawn."""
    shown = film(struck.run, Look(exaggerate=1.0))
    scene = Scene(page_of(shown.solution))
    found = forces(struck)
    paths = [path.split("/impulse_")[1] for path in scene.objects if "/impulse_" in path]
    forced = {name for name, stop in struck.stops.items() if stop.lever or not stop.turns}
    assert {path.split("/")[0] for path in paths} == forced >= set(found)
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
            if after - at < 2e-3 or impulse < 1e-2 * largest:
                continue
            checked += 1
            now = float(np.float32(at))
            shaft, head = (scene.points(f"{path}/{part}", now) for part in ("shaft", "head"))
            if joint in struck.places(q):
                zero = np.zeros(len(q))
                begin, ahead = (struck.point(joint, p, zero, q) for p in (foot, foot + way))
            else:
                begin, ahead = foot, foot + way
            x, z = ahead - begin
            own = np.array([[x, 0.0, z], [-z, 0.0, x], [0.0, 1.0, 0.0]])
            # In its own axes: along the push, across it in the plane, and out of the plane.
            shaft, head = ((part - [begin[0], 0.0, begin[1]]) @ own.T for part in (shaft, head))
            # The shaft ends where the head begins.
            assert shaft[:, 0].min() == pytest.approx(0.0, abs=1e-4 * reach)
            assert shaft[:, 0].max() == pytest.approx(head[:, 0].min(), abs=1e-5 * reach)
            length, *off = head[int(np.argmax(head[:, 0]))]
            np.testing.assert_allclose(off, 0.0, atol=1e-4 * reach)
            unit = unit or length / impulse
            assert length == pytest.approx(unit * impulse, rel=2e-3)
            # It stays for half a second, or until the next one.
            until = min(at + 0.5, after - 2e-3)
            still = [np.interp(when, t, size[:, 1]) for when in (now, until)]
            assert still[0] == pytest.approx(still[1], rel=1e-6)
            # Round; narrower than long, and the head wider than the shaft.
            widths = np.array([np.abs(part[:, 1:]).max(axis=0) for part in (shaft, head)])
            np.testing.assert_allclose(widths[:, 0], widths[:, 1], rtol=1e-3)
            assert widths[0, 0] < widths[1, 0] < 0.5 * math.sqrt(length * unit * largest)
    assert checked > 3
    assert unit is not None
    # The largest is a part of the machine that neither covers it nor is lost in it.
    assert 0.05 * reach < unit * largest < 0.5 * reach
