"""Meshes of the package, and solids and bars of any machine: closed, small, in their places."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import manifold3d
import numpy as np
import pytest
import trimesh
import yourdfpy
from runs_shown import run_of, turn
from small_machines import SHAFT, frame, hinge, link, machine, slide
from three_js import Scene
from urdf_shapes import shaped

from nipper_pin import InputError, Mechanism, load
from nipper_pin.mechanism import collision_model, find_model, from_sources
from nipper_pin.view.scene import CYLINDER, FIXED, Look, Solid, film, solids
from nipper_pin.view.scene.colours import link_colour
from nipper_pin.view.scene.solids import _material

FOLDER = find_model("e62")
DRAWN = ["e62", "e62_offset_guide"]


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
def test_meshes_are_closed_small_and_all_of_them_used(model: str) -> None:
    folder = find_model(model)
    files = {f"meshes/{path.name}": path for path in (folder / "meshes").iterdir()}
    robot = ElementTree.parse(folder / f"{model}.urdf")
    assert {item.get("filename") for item in robot.iter("mesh")} == set(files)
    for name, path in files.items():
        mesh = trimesh.load_mesh(path)
        assert mesh.is_watertight, name
        assert mesh.volume > 0.0, name
    assert sum(path.stat().st_size for path in files.values()) < 1_000_000


def test_the_engine_does_not_see_what_is_drawn(e62) -> None:
    """Without any visual the tree and the collision shapes are the same to the last bit."""
    bare = re.sub(r"<visual\b.*?</visual>", "", e62.urdf, flags=re.S)
    assert "<mesh" not in bare
    other = from_sources("e62", bare, e62.description, e62.mesh_folder)
    assert other.model == e62.model
    one, two = collision_model(e62)[0], collision_model(other)[0]
    assert [item.name for item in one.geometryObjects] == [i.name for i in two.geometryObjects]
    assert all(a == b for a, b in zip(one.geometryObjects, two.geometryObjects, strict=True))


@pytest.mark.parametrize(("model", "larger"), [("e62", 1.0), ("e62", 50.0), (DRAWN[1], 1.0)])
def test_drawn_links_never_run_through_one_another(model: str, larger: float) -> None:
    """Overlaps of all pairs over a turn, by a library of solids: none, also exaggerated.

    Holes are 0.1 mm wider than their pins, which the sag of their chords (50 um, or 30 um at 20 mm
    and 56 to a turn) does not close; a link in a wrong place would overlap by whole pins.
    """
    run = run_of("e62") if model == "e62" else turn(load(model), 350.0, 24.0)
    shown = film(run, Look(exaggerate=larger))
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
        low, high = np.split(np.array([body.bounding_box() for body in placed]), 2, axis=1)
        near = (low[:, None] < high[None]).all(axis=2)
        for i, j in itertools.combinations(range(len(drawn)), 2):
            # Boxes that are apart hold nothing in common.
            if drawn[i].body != drawn[j].body and near[i, j] and near[j, i]:
                overlap = (placed[i] ^ placed[j]).volume()
                assert overlap < 1e-12, (drawn[i].name, drawn[j].name, shown.index[k])


def vertices(solid: Solid) -> np.ndarray:
    """Corners of a drawn mesh in the frame of its body."""
    points = np.asarray(trimesh.load_mesh(solid.path).vertices) * solid.scale
    return points @ solid.placement[:3, :3].T + solid.placement[:3, 3]


def named(e62, name: str) -> Solid:
    return next(item for item in solids(e62) if item.name == name)


def test_springs_stay_between_nut_and_tube(page_of: Callable[..., str]) -> None:
    """Both ends of the drawn coil, from the meshes' corners, in every frame of a motion whose
    stroke passes 5 mm; meshes are stored in single precision (1e-8 of 0.2 m)."""
    large = film(run_of("e62"), Look(exaggerate=50.0))
    scene = Scene(page_of(large.solution, exaggerate=50.0))
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
        (path,) = (item for item in scene.objects if item.endswith(f"/{name}"))
        _, scale = scene.tracks[path][".scale"]
        ends = start + scale[:, 2]
        np.testing.assert_allclose(ends, tube - large.drawn[:, stroke], atol=1e-7)
        assert np.ptp(scale[:, :2]) == 0.0
    coil = trimesh.load_mesh(FOLDER / "meshes" / "spring.stl")
    np.testing.assert_allclose(coil.bounds[:, 2], [0.0, 1.0], atol=1e-7)


def test_a_link_without_its_meshes_is_drawn_by_its_collision_shapes(e62, tmp_path: Path) -> None:
    moved = replace(e62, mesh_folder=str(tmp_path))
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


def test_meshes_that_cannot_be_read(tmp_path: Path) -> None:
    """Missing, and of no known format."""
    (horn,) = (item for item in solids(shaped(tmp_path)) if item.name == "horn")
    (tmp_path / "horn.ply").write_text("nothing", encoding="utf-8")
    for name, words in (
        ("gone.stl", ": the mesh cannot be read"),
        ("horn.ply", ": mesh = .* a mesh as STL, OBJ or DAE"),
    ):
        with pytest.raises(InputError, match=f"{name}{words}") as caught:
            _ = replace(horn, path=tmp_path / name).mesh
        assert Path(str(caught.value.evidence["file"])).name == name


# Corners of round solids, and bars of links without any.


def test_corners_of_round_solids() -> None:
    """Cylinders of 32 corners an end and spheres of nine rings have their radius and length."""

    def corners(kind: str, *sizes: float) -> np.ndarray:
        made = Solid("round", FIXED, kind, sizes, None, np.eye(4), np.ones(3), (0.2, 0.4, 0.8))
        return made.mesh[0]

    points = corners("cylinder", 0.5, 3.0)
    assert len(points) == 64
    assert np.abs(points).max(axis=0) == pytest.approx([0.5, 0.5, 1.5])
    points = corners("sphere", 0.7)
    assert len(points) == 9 * 32 + 2
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 0.7, rtol=1e-12)
    heights = np.unique(points[:, 2].round(9))
    assert heights == pytest.approx(0.7 * np.cos(np.pi * np.arange(10, -1, -1) / 10.0), abs=1e-9)


def ends(mechanism: Mechanism) -> dict[str, list[list[float]]]:
    """Far ends of the bars of each link, by middle and length (x, z) [m]."""
    found: dict[str, list[list[float]]] = {}
    for solid in solids(mechanism):
        if solid.kind == "cylinder" and solid.body != FIXED:
            _, length = solid.sizes
            half = 0.5 * length * solid.placement[:3, 2]
            np.testing.assert_allclose(solid.placement[:3, 3], half, atol=1e-12)
            assert np.linalg.det(solid.placement[:3, :3]) == pytest.approx(1.0)
            own = found.setdefault(mechanism.joints[solid.body].child, [])
            own.append((2.0 * half)[[0, 2]].round(9).tolist())
    return {name: sorted(items) for name, items in found.items()}


def test_bars_reach_the_ends_of_springs_and_dampers() -> None:
    """Each frame of a link that something is fixed to has a bar to it; others have none."""
    parts = [
        link("arm", centre=(0.3, 0.1)), hinge("arm_pin", "frame", "arm"),
        frame("hook", "arm", (0.0, 0.5)), frame("unused", "arm", (0.7, 0.0)),
        frame("eye", "arm", (0.4, 0.0)), frame("wall", "frame", (0.6, 0.6)),
    ]  # fmt: skip
    made = machine(
        parts,
        1,
        springs={"coil": {"frame_a": "hook", "frame_b": "wall", "stiffness_N_per_m": 1e3,
                          "free_length_mm": 100.0}},
        dampers={"stay": {"frame_a": "wall", "frame_b": "eye", "damping_N_s_per_m": 2.0}},
    )  # fmt: skip
    assert {item.name for item in made.struts} == {"coil", "stay"}
    assert ends(made) == {"arm": [[0.0, 0.5], [0.4, 0.0]]}
    assert ends(machine(parts, 1)) == {"arm": [[0.3, 0.1]]}


def boxed(text: str, *boxes: tuple[float, float, float, float]) -> str:
    """A link with collision boxes: middle (x, z) and edges along x and z [m]."""
    shapes = "".join(
        f'<collision><origin xyz="{x} 0 {z}"/><geometry><box size="{wide} 0.01 {high}"/></geometry>'
        "</collision>" for x, z, wide, high in boxes
    )  # fmt: skip
    return text.replace("</link>", f"{shapes}</link>")


@pytest.mark.parametrize(("boxes", "bars"), [
    ([(0.4, 0.0, 0.1, 0.1)], [[0.4, 0.0]]), ([(0.0, 0.0, 0.1, 0.1)], [[0.4, 0.0]]),
    ([(0.2, 0.0, 0.44, 0.1)], []), ([(0.0, 0.0, 0.1, 0.1), (0.4, 0.0, 0.1, 0.1)], []),
    ([(0.2, 0.0, 0.1, 0.1)], [[0.2, 0.0], [0.4, 0.0]]), (None, [[0.0, 0.5], [0.4, 0.0]]),
])  # fmt: skip
def test_links_reach_all_that_hangs_on_them(boxes: list[Any] | None, bars: list[Any]) -> None:
    """A bar goes to each pin that no shape of its link reaches, and none where a part slides.

    Of machines without shapes to all joints, or to the centre of mass, from a ball at the joint.
    """

    def part(name: str, centre: tuple[float, float], *own: Any) -> str:
        return link(name, centre=centre) if boxes is None else boxed(link(name), *own)

    made = machine(
        [
            part("arm", (0.3, 0.1), *(boxes or ())), hinge("arm_pin", "frame", "arm", (0.1, 0.2)),
            part("hand", (0.0, 0.25), (0.0, 0.0, 0.1, 0.1)),
            hinge("hand_pin", "arm", "hand", (0.4, 0.0)),
            part("shoe", (0.05, 0.0), (0.3, 0.0, 0.1, 0.1)),
            slide("shoe_x", "arm", "shoe", at=(0.0, 0.5)),
        ],
        3,
        drives={"arm": {"joint": "arm_pin", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
    )  # fmt: skip
    names = [solid.name for solid in solids(made) if solid.body == 0]
    assert len(set(names)) == len(names)
    if boxes is None:
        assert ends(made) == {"arm": bars, "hand": [[0.0, 0.25]], "shoe": [[0.05, 0.0]]}
        balls = [solid for solid in solids(made) if solid.kind == "sphere"]
        for ball in balls:
            assert (ball.name, ball.sizes) == ("joint", (pytest.approx(0.032 * 0.5),))
            assert (ball.placement == np.eye(4)).all()
        assert sorted(made.joints[ball.body].child for ball in balls) == ["arm", "hand", "shoe"]
        return
    assert ends(made) == ({"arm": bars} if bars else {})
    (pin,) = (solid for solid in solids(made) if solid.body == FIXED)
    np.testing.assert_allclose(pin.placement[:3, 3], [0.1, 0.0, 0.2])
    np.testing.assert_allclose(np.abs(pin.placement[:3, 2]), [0.0, 1.0, 0.0], rtol=0.0, atol=1e-15)


def test_a_bar_ends_inside_the_shape_that_it_goes_to() -> None:
    """A lip is seen no thicker than it is: half of it in side view, whatever its depth is."""
    made = machine([boxed(link("arm"), (0.4, 0.0, 0.02, 0.06)), hinge("pin", "frame", "arm")], 1)
    (bar,) = (solid for solid in solids(made) if "bar_" in solid.name)
    assert bar.sizes == (pytest.approx(0.005), pytest.approx(0.4))


def test_colours_are_those_of_the_material_itself_or_of_its_name() -> None:
    named = {"steel": (0.1, 0.2, 0.3)}
    own = "<visual><material name='steel'><color rgba='0.5 0.6 0.7 1'/></material></visual>"
    of_name = "<visual><material name='steel'/></visual>"
    unknown = "<visual><material name='brass'/></visual>"
    for text, colour in (
        (own, (0.5, 0.6, 0.7)),
        (of_name, (0.1, 0.2, 0.3)),
        (unknown, link_colour(2)),
        ("<visual/>", link_colour(2)),
    ):
        assert _material(ElementTree.fromstring(text), named, 2) == colour
