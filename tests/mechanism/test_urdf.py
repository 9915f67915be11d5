"""What a URDF may hold: meshes, joints and their planes, damping, loops; and another reader."""

from __future__ import annotations

import logging
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from small_machines import hinge, link, machine, slide, turn

from nipper_pin import Mechanism, ModelError, load
from nipper_pin.mechanism import (
    changed,
    collision_model,
    find_model,
)
from nipper_pin.mechanism.files import parse_xml, urdf_parts
from nipper_pin.mechanism.files.urdf import check_urdf
from tests.refusals.bases import model

PLATE = """solid plate
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0.1 0
endloop
endfacet
endsolid plate
"""

SHAPE = '<collision name="p"><geometry><mesh filename="{}"/></geometry></collision></link>'


def plated(folder: Path, filename: str) -> Path:
    """The small machine, whose only shape is a mesh."""
    home = model("small", ("</link>", SHAPE.format(filename)), folder)
    (home / "meshes").mkdir()
    (home / "meshes" / "plate.stl").write_text(PLATE, encoding="utf-8")
    return home


def test_meshes_stand_in_the_folder_of_the_model(tmp_path: Path) -> None:
    """Their paths start from there, wherever the process works, and no link leads out."""
    home = plated(tmp_path, "meshes/plate.stl")
    plate = home / "meshes" / "plate.stl"
    geometry, shapes = collision_model(load(home))
    assert [(item.name, item.meshPath) for item in geometry.geometryObjects] == [("p", str(plate))]
    assert shapes["lever"] == ("p",)
    plate.rename(tmp_path / "plate.stl")
    plate.symlink_to(tmp_path / "plate.stl")
    with pytest.raises(ModelError, match="stays inside") as caught:
        load(home)
    assert caught.value.evidence["value"] == "meshes/plate.stl"


def test_a_package_is_the_model_folder(tmp_path: Path) -> None:
    """With a package.xml its name counts."""
    home = plated(tmp_path, "package://parts/meshes/plate.stl")
    load(home)
    (home / "package.xml").write_text("<package><name>parts</name></package>", encoding="utf-8")
    load(home)
    (home / "package.xml").write_text("<package><name>others</name></package>", encoding="utf-8")
    with pytest.raises(ModelError, match="the package of the model folder, package://others/"):
        load(home)


def test_a_mesh_that_is_only_drawn_may_be_missing(e62: Mechanism, tmp_path: Path) -> None:
    """A run loads where the pictures are not."""
    folder = model("e62", (), tmp_path)
    shutil.rmtree(folder / "meshes")
    assert load(folder).model == e62.model


def test_another_reader_agrees(e62: Mechanism, caplog: pytest.LogCaptureFixture) -> None:
    path = find_model("e62") / "e62.urdf"
    with caplog.at_level(logging.WARNING):
        robot = yourdfpy.URDF.load(
            str(path), build_collision_scene_graph=True, load_collision_meshes=True
        )
    assert robot.validate()
    assert not caplog.records
    assert robot.base_link == "frame"
    kinematics, data = e62.model, e62.model.createData()
    random = np.random.default_rng(7)
    for _ in range(10):
        q = random.uniform(-0.04, 0.04, kinematics.nq)
        pin.framesForwardKinematics(kinematics, data, q)
        robot.update_cfg({joint.name: q[joint.index] for joint in e62.joints})
        for name in robot.link_map:
            frame = kinematics.getFrameId(name, pin.FrameType.BODY)
            np.testing.assert_allclose(
                robot.get_transform(name, "frame"),
                data.oMf[frame].homogeneous,
                rtol=0.0,
                atol=1e-12,
            )


JOINTS = (
    '<robot name="r"><link name="f"/><link name="a"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial>'
    '<mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
    '<joint name="p" type="revolute"><parent link="f"/><child link="a"/><axis xyz="0 -1 0"/>'
    "</joint>"
    '<joint name="j" type="{}"><parent link="a"/><child link="b"/><origin rpy="{}"/>{}</joint>'
    "</robot>"
)


def joint_of(kind: str, rpy: str, axis: str | None) -> urdf_parts.UrdfJoint:
    written = "" if axis is None else f'<axis xyz="{axis}"/>'
    root = parse_xml(JOINTS.format(kind, rpy, written), "x.urdf")
    return check_urdf(root, "x.urdf", Path()).joints["j"]


@pytest.mark.parametrize(
    ("kind", "rpy", "axis", "pitch", "wanted"),
    [
        ("revolute", "0 0.5 0", "0 -1 0", 0.5, (0, -1, 0)),
        ("prismatic", "0 0.5 0", "3 0 4", 0.5, (0.6, 0, 0.8)),
        ("prismatic", "0 0 0", "3e-200 0 -4e-200", 0.0, (0.6, 0, -0.8)),
        ("prismatic", "0 0 0", None, 0.0, (1, 0, 0)),
        ("continuous", "0 0 0", "1e-12 -1 0", 0.0, (0, -1, 0)),
        ("revolute", "0 0 0", "0 7 0.007", 0.0, (0, 1, 0)),
        ("prismatic", "0 0 0", "3 1e-12 4", 0.0, (0.6, 0, 0.8)),
        ("fixed", "0 0 0", "3 1e-12 4", 0.0, (0, 0, 0)),
        # Half a turn about y, as three angles and as two, of sixteen digits and of three.
        ("revolute", f"{np.pi!r} 0.25 {np.pi!r}", "0 -1 0", np.pi - 0.25, (0, -1, 0)),
        ("revolute", "3.14 0.25 3.14", "0 -1 0", np.pi - 0.25, (0, -1, 0)),
        ("revolute", "1e-12 0.25 0", "0 -1 0", 0.25, (0, -1, 0)),
        ("revolute", "0 0.25 1e-12", "0 -1 0", 0.25, (0, -1, 0)),
        # A half turn about x points the y axis of the frame out of the page.
        ("revolute", f"{np.pi!r} 0 0", "0 1 0", 0.0, (0, -1, 0)),
        ("revolute", f"{np.pi / 2!r} 0 0", "0 0 -2", 0.0, (0, 1, 0)),
        ("prismatic", f"{np.pi / 2!r} 0 0", "0 3 0", 0.0, (0, 0, 1)),
    ],
)
def test_joints_are_put_into_the_plane(
    kind: str, rpy: str, axis: str | None, pitch: float, wanted: tuple[float, ...]
) -> None:
    """Exactly: a hinge turns about y, a slide moves along x and z, frames turn about y alone."""
    found = joint_of(kind, rpy, axis)
    assert found.axis == pytest.approx(wanted, abs=1e-15)
    assert found.axis[1] in (0.0, wanted[1])
    turn = found.placement.rotation
    assert (turn[1] == [0.0, 1.0, 0.0]).all()
    assert (turn[:, 1] == [0.0, 1.0, 0.0]).all()
    # An angle of three digits is followed to as many.
    assert np.arctan2(turn[0, 2], turn[0, 0]) == pytest.approx(pitch, abs=3e-6)


INERTIA, DAMPING, SWING = 0.3, 0.7, 0.2


def with_dynamics(text: str, dynamics: str) -> str:
    return text.replace("</joint>", f"<dynamics {dynamics}/></joint>")


def test_damping_of_a_joint_slows_it_as_the_closed_form_says() -> None:
    """A wheel on a shaft that swings by A sin w t: I (u'' + s'') = -c u', u the angle between."""
    wheel = with_dynamics(hinge("wheel", "shaft", "wheel"), f'damping="{DAMPING}" friction="0"')
    parts = [link("shaft"), hinge("shaft", "frame", "shaft"), link("wheel", inertia=INERTIA), wheel]
    drives = {"shaft": {"joint": "shaft", "law": "fourier", "sine_rad": [SWING]}}
    mechanism = machine(parts, 2, drives=drives)
    solution = turn(mechanism)
    t = np.linspace(0.0, 1.0, 21)
    v = solution.trajectory.evaluate(t).v
    w, k = 2.0 * np.pi, DAMPING / INERTIA
    # p = u' obeys p' + k p = A w^2 sin w t, whose steady part is below.
    shaft, wheel = (
        next(j.index for j in mechanism.joints if j.name == n) for n in ("shaft", "wheel")
    )
    steady = SWING * w**2 * (k * np.sin(w * t) - w * np.cos(w * t)) / (k**2 + w**2)
    expected = steady + (v[0, wheel] - steady[0]) * np.exp(-k * t)
    assert v[:, shaft] == pytest.approx(SWING * w * np.cos(w * t), abs=1e-12)
    assert v[:, wheel] == pytest.approx(expected, abs=1e-11)


def test_it_adds_to_the_dampers_of_the_file_and_has_a_path() -> None:
    dampers = {"oil": {"joint": "wheel", "damping_N_m_s_per_rad": 0.5}}
    parts = [link("wheel"), with_dynamics(hinge("wheel", "frame", "wheel"), 'damping="0.7"')]
    mechanism = machine(parts, 1, dampers=dampers)
    assert sorted(item.damping for item in mechanism.dampers) == [0.5, 0.7]
    other = changed(mechanism, {"urdf.joint.wheel.dynamics.damping": 0.9})
    assert sorted(item.damping for item in other.dampers) == [0.5, 0.9]
    parts = [link("ram"), with_dynamics(slide("ram", "frame", "ram"), 'damping="3.0"')]
    assert [item.damping for item in machine(parts, 1).dampers] == [3.0]
