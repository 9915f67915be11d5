"""Solids that are drawn: corners of round ones, how far they reach, bars of links without any."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from small_machines import SHAFT, frame, hinge, link, machine, slide

from nipper_pin import InputError, Mechanism
from nipper_pin.view.live.shapes import shape
from nipper_pin.view.scene import FIXED, Solid, solids
from nipper_pin.view.scene.colours import link_colour
from nipper_pin.view.scene.meshes import mesh_of
from nipper_pin.view.scene.solids import _material


def block(turned: float, depth: float = 0.0, body: int = FIXED) -> Solid:
    """A box of 2 x 4 x 6 that is turned about the vertical."""
    place = np.eye(4)
    c, s = math.cos(turned), math.sin(turned)
    place[:2, :2], place[1, 3] = [[c, -s], [s, c]], depth
    return Solid("block", body, "box", (2.0, 4.0, 6.0), None, place, np.ones(3), (0.2, 0.4, 0.8))


def test_corners_of_round_solids() -> None:
    """Cylinders of 32 corners an end and spheres of nine rings have their radius and length."""
    points, _ = mesh_of(replace(block(0.0), kind="cylinder", sizes=(0.5, 3.0)))
    assert len(points) == 64
    assert points.max(axis=0) == pytest.approx([0.5, 0.5, 1.5])
    assert points.min(axis=0) == pytest.approx([-0.5, -0.5, -1.5])
    points, _ = mesh_of(replace(block(0.0), kind="sphere", sizes=(0.7,)))
    assert len(points) == 9 * 32 + 2
    assert points.max(axis=0) == pytest.approx([0.7, 0.7, 0.7])
    assert np.linalg.norm(points, axis=1).max() == pytest.approx(0.7)
    heights = np.unique(points[:, 2].round(9))
    assert heights == pytest.approx(0.7 * np.cos(np.pi * np.arange(10, -1, -1) / 10.0), abs=1e-9)


def test_bars_of_links_without_shapes() -> None:
    """From a joint to all that hangs on its link, or to the centre of mass; a ball at the joint."""
    made = machine(
        [
            link("arm", centre=(0.3, 0.1)), hinge("arm_pin", "frame", "arm", (0.1, 0.2)),
            link("hand", centre=(0.0, 0.25)), hinge("hand_pin", "arm", "hand", (0.4, 0.0)),
            link("finger", centre=(0.05, 0.0)), slide("finger_x", "arm", "finger", at=(0.0, 0.5)),
        ],
        3,
        drives={"arm": {"joint": "arm_pin", "law": "constant_speed", "ratio": 1.0, **SHAFT}},
    )  # fmt: skip
    balls = [solid for solid in solids(made) if solid.kind == "sphere"]
    for ball in balls:
        assert (ball.name, ball.sizes) == ("joint", (pytest.approx(0.032 * made.reach_m),))
        assert (ball.placement == np.eye(4)).all()
    assert [made.joints[ball.body].child for ball in balls] == ["arm", "finger", "hand"]
    assert ends(made) == {
        "arm": [[0.0, 0.5], [0.4, 0.0]], "hand": [[0.0, 0.25]], "finger": [[0.05, 0.0]],
    }  # fmt: skip


def ends(mechanism: Mechanism) -> dict[str, list[list[float]]]:
    """Far ends of the bars of each link, by middle and length (x, z) [m]."""
    found: dict[str, list[list[float]]] = {}
    for solid in solids(mechanism):
        if solid.kind == "cylinder":
            radius, length = solid.sizes
            assert radius == pytest.approx(0.02 * mechanism.reach_m)
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


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("horn.stl", "the mesh cannot be read"),
        ("horn.xyz_", "mesh = .* a mesh as STL, OBJ or DAE"),
    ],
)
def test_meshes_that_cannot_be_read(tmp_path: Path, name: str, words: str) -> None:
    """One that is missing, and one of no known format."""
    file = tmp_path / name
    if "xyz" in name:
        file.write_text("nothing", encoding="utf-8")
    with pytest.raises(InputError, match=f"{name}: {words}") as caught:
        shape(replace(block(0.0), kind="mesh", path=file))
    assert Path(str(caught.value.evidence["file"])).name == name


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
