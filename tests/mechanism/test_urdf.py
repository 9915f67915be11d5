"""What a URDF may hold, its meshes, and its agreement with another reader."""

import logging
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy

from nipper_pin.errors import ModelError
from nipper_pin.mechanism import find_model, load
from nipper_pin.mechanism.shapes import collision_model

VERIFICATION = Path(__file__).parents[1] / "verification" / "models"
MASS = '<mass value="1.2"/>'
JAW = '<origin xyz="0.1226 0 0.0561" rpy="0 0 0"/>\n    <axis xyz="0 -1 0"/>'
INERTIA = 'iyy="0.001142"'
TYPE = 'name="jaw" type="revolute"'
JAW_LIMIT = JAW + '\n    <limit lower="-3.2" upper="3.2"'


@pytest.mark.parametrize(
    ("lower", "upper"), [("-inf", "INF"), (" -1e400 ", "+Infinity"), ("-.5", "1.E2")]
)
def test_limits_that_say_there_is_none(spoil, lower: str, upper: str) -> None:  # type: ignore[no-untyped-def]
    limit = JAW_LIMIT.replace("-3.2", lower).replace('"3.2"', f'"{upper}"')
    assert load(spoil(urdf=((JAW_LIMIT, limit),))).stops


def test_continuous_joint_has_one_coordinate(spoil) -> None:  # type: ignore[no-untyped-def]
    mechanism = load(spoil(urdf=((TYPE, TYPE.replace("revolute", "continuous")),)))
    assert mechanism.model.nq == mechanism.model.nv == 7
    assert mechanism.joints[2].kind == "revolute"


def test_mesh_inside_the_folder(spoil) -> None:  # type: ignore[no-untyped-def]
    folder = spoil(urdf=(('<box size="0.07 0.22 0.002"/>', '<mesh filename="meshes/plate.stl"/>'),))
    (folder / "meshes" / "plate.stl").write_text(
        "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\n"
        "vertex 0 0.1 0\nendloop\nendfacet\nendsolid plate\n",
        encoding="utf-8",
    )
    assert load(folder).stop("jaw").contact is not None
    (folder / "meshes" / "plate.stl").rename(folder.parent / "plate.stl")
    (folder / "meshes" / "plate.stl").symlink_to(folder.parent / "plate.stl")
    with pytest.raises(ModelError, match="stays inside") as caught:
        load(folder)
    assert caught.value.evidence["value"] == "meshes/plate.stl"


def test_a_mesh_that_is_only_drawn_may_be_missing(spoil) -> None:  # type: ignore[no-untyped-def]
    """A run loads where the pictures are not."""
    folder = spoil()
    shutil.rmtree(folder / "meshes")
    assert load(folder).model == load("e62").model


def test_a_package_is_the_model_folder(spoil) -> None:  # type: ignore[no-untyped-def]
    """With a package.xml its name counts."""
    plate = (
        "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\n"
        "vertex 0 0.1 0\nendloop\nendfacet\nendsolid plate\n"
    )
    mesh = '<mesh filename="package://{}/meshes/plate.stl" scale="0.1 0.1 0.1"/>'
    shape = f'<collision name="p"><geometry>{mesh.format("parts")}</geometry></collision></link>'
    folder = spoil(urdf=(("</link>", shape),))
    (folder / "meshes" / "plate.stl").write_text(plate, encoding="utf-8")
    load(folder)
    (folder / "package.xml").write_text("<package><name>parts</name></package>", encoding="utf-8")
    load(folder)
    (folder / "package.xml").write_text("<package><name>others</name></package>", encoding="utf-8")
    with pytest.raises(ModelError, match="the package of the model folder, package://others/"):
        load(folder)


def test_shapes_that_are_all_meshes(tmp_path: Path) -> None:
    """Their paths start from the model folder, wherever the process works."""
    folder = tmp_path / "bouncing_mass"
    shutil.copytree(VERIFICATION / "bouncing_mass", folder)
    urdf = folder / "bouncing_mass.urdf"
    text = urdf.read_text(encoding="utf-8")
    assert "<collision" not in text
    plate = (
        "solid plate\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\n"
        "vertex 0 0.1 0\nendloop\nendfacet\nendsolid plate\n"
    )
    (folder / "plate.stl").write_text(plate, encoding="utf-8")
    shape = '<collision name="p"><geometry><mesh filename="plate.stl"/></geometry></collision>'
    urdf.write_text(text.replace("</link>", f"{shape}</link>", 1), encoding="utf-8")
    geometry, shapes = collision_model(load(folder))
    assert [item.name for item in geometry.geometryObjects] == ["p"]
    assert [item.meshPath for item in geometry.geometryObjects] == [str(folder / "plate.stl")]
    assert shapes["table"] == ("p",)


def test_another_reader_agrees(caplog: pytest.LogCaptureFixture) -> None:
    mechanism = load()
    path = find_model("e62") / "e62.urdf"
    with caplog.at_level(logging.WARNING):
        robot = yourdfpy.URDF.load(
            str(path), build_collision_scene_graph=True, load_collision_meshes=True
        )
    assert robot.validate()
    assert not caplog.records
    assert robot.base_link == "frame"
    model, data = mechanism.model, mechanism.model.createData()
    random = np.random.default_rng(7)
    for _ in range(10):
        q = random.uniform(-0.04, 0.04, model.nq)
        pin.framesForwardKinematics(model, data, q)
        robot.update_cfg({joint.name: q[joint.index] for joint in mechanism.joints})
        for link in robot.link_map:
            frame = model.getFrameId(link, pin.FrameType.BODY)
            np.testing.assert_allclose(
                robot.get_transform(link, "frame"), data.oMf[frame].homogeneous, atol=1e-12
            )


@pytest.mark.parametrize("change", [
    (MASS, '<mass value="1.2 "/>'), (MASS, '<mass value=" 1.2"/>'), (MASS, '<mass value="\t1.2"/>'),
    (MASS, '<mass value="+1.2e0"/>'), (INERTIA, 'iyy=" 0.001142 "'), (' iyz="0"', ""),
    (JAW, JAW.replace("0.1226 0 0.0561", " 0.1226\n0\t0.0561  ")),
    (JAW, JAW.replace("0 -1 0", "0   -1 0 ")),
])  # fmt: skip
def test_pinocchio_reads_what_was_checked(spoil, change: tuple[str, str]) -> None:  # type: ignore[no-untyped-def]
    """However a number is spaced: its parser takes such an inertial for none, and goes on."""
    plain, changed = load("e62").model, load(spoil(urdf=(change,))).model
    for ours, theirs in zip(changed.inertias, plain.inertias, strict=True):
        assert (ours.toDynamicParameters() == theirs.toDynamicParameters()).all()
    for ours, theirs in zip(changed.jointPlacements, plain.jointPlacements, strict=True):
        assert (ours.homogeneous == theirs.homogeneous).all()
