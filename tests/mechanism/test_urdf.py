"""What a URDF may hold, its meshes, and its agreement with another reader."""

import logging
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy

from nipper_pin import Mechanism, ModelError, load
from nipper_pin.mechanism import collision_model, find_model
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
        for link in robot.link_map:
            frame = kinematics.getFrameId(link, pin.FrameType.BODY)
            np.testing.assert_allclose(
                robot.get_transform(link, "frame"),
                data.oMf[frame].homogeneous,
                rtol=0.0,
                atol=1e-12,
            )
