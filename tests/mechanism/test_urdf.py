"""Mistakes in the URDF, and its agreement with another reader."""

import logging
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy

from nipper_pin.errors import ModelError, UnknownNameError
from nipper_pin.mechanism import find_model, load
from nipper_pin.mechanism.shapes import collision_model

VERIFICATION = Path(__file__).parents[1] / "verification" / "models"
MASS = '<mass value="1.2"/>'
JAW = '<origin xyz="0.1226 0 0.0561" rpy="0 0 0"/>\n    <axis xyz="0 -1 0"/>'
SLIDE = "0.3835683289474219 0 -0.9235124996601196"
LIP = '<box size="0.012 0.2 0.0003"/>'
INERTIA = 'iyy="0.001142"'
TYPE = 'name="jaw" type="revolute"'
FOOT = '<link name="rocker_foot"/>'
PLATE = '<collision name="bottom_plate">'

LINK = "link top_nipper"
SHAPE = "link bottom_nipper collision bottom_lip"
CLASH = "link bottom_nipper collision name"

# Old text, new text, key, value (... if it is not worth repeating), words of what is allowed.
MISTAKES = {
    "mass zero": (MASS, '<mass value="0"/>', f"{LINK} mass", 0.0, "positive mass"),
    "mass negative": (MASS, '<mass value="-2"/>', f"{LINK} mass", -2.0, "positive mass"),
    "mass a word": (MASS, '<mass value="x"/>', f"{LINK} mass", "x", "a finite number"),
    "mass infinite": (MASS, '<mass value="inf"/>', f"{LINK} mass", "inf", "a finite number"),
    "mass missing": (MASS, "", f"{LINK} mass", None, "a positive mass"),
    "inertia negative": (INERTIA, 'iyy="-1"', f"{LINK} inertia", ..., "positive principal"),
    "inertia impossible": (INERTIA, 'iyy="0.01"', f"{LINK} inertia", ..., "sum of the other two"),
    "hinge out of plane": (
        JAW,
        JAW.replace("0 -1 0", "0 -1 0.1"),
        "joint jaw axis",
        [0.0, -1.0, 0.1],
        "along y of the root link",
    ),
    "no direction": (
        JAW,
        JAW.replace("0 -1 0", "0 0 0"),
        "joint jaw axis",
        [0.0, 0.0, 0.0],
        "direction",
    ),
    "slider out of plane": (
        SLIDE,
        "0.38 0.1 -0.92",
        "joint steeve axis",
        [0.38, 0.1, -0.92],
        "across y of the root link",
    ),
    "placement out of plane": (
        JAW,
        JAW.replace("0 0 0", "0.1 0 0"),
        "joint jaw axis",
        [0.0, -1.0, 0.0],
        "along y of the root link",
    ),
    "joint floating": (
        TYPE,
        TYPE.replace("revolute", "floating"),
        "joint jaw type",
        "floating",
        "revolute, continuous, prismatic, fixed",
    ),
    "joint planar": (
        TYPE,
        TYPE.replace("revolute", "planar"),
        "joint jaw type",
        "planar",
        "revolute, continuous, prismatic, fixed",
    ),
    "mimic": (
        JAW,
        JAW + '<mimic joint="steeve" offset="1"/>',
        "joint jaw mimic offset",
        1.0,
        "touch",
    ),
    "two parents": (
        '<child link="top_nipper"/>',
        '<child link="rocker"/>',
        "joint jaw child",
        "rocker",
        "hangs from one joint",
    ),
    "several roots": (
        FOOT,
        FOOT + '<link name="loose"/>',
        "root links",
        ["frame", "loose"],
        "exactly one root link",
    ),
    "circle": (
        '<parent link="frame"/>\n    <child link="pendulum_arm"/>',
        '<parent link="top_nipper"/>\n    <child link="pendulum_arm"/>',
        "links",
        ...,
        "in a circle",
    ),
    "same link twice": (FOOT, FOOT + '<link name="frame"/>', "<link> name", "frame", "its own"),
    "link without name": (FOOT, "<link/>", "<link> name", None, "not empty"),
    "size": (LIP, '<box size="1 2 0"/>', f"{SHAPE} size", [1.0, 2.0, 0.0], "above 0 m"),
    "sizes missing": (LIP, '<box size="1 2"/>', f"{SHAPE} size", "1 2", "3 finite numbers"),
    "geometry": (LIP, "<torus/>", SHAPE, ["torus"], "box, cylinder, sphere, mesh"),
    "mesh above": (
        LIP,
        '<mesh filename="../lip.stl"/>',
        f"{SHAPE} mesh",
        "../lip.stl",
        "stays inside",
    ),
    "mesh anywhere": (
        LIP,
        '<mesh filename="/tmp/lip.stl"/>',
        f"{SHAPE} mesh",
        "/tmp/lip.stl",
        "stays inside",
    ),
    "mesh package": (
        LIP,
        '<mesh filename="package://a/lip.stl"/>',
        f"{SHAPE} mesh",
        "package://a/lip.stl",
        "a mesh file in the model folder",
    ),
    "mesh out of a package": (
        LIP,
        '<mesh filename="package://a/../lip.stl"/>',
        f"{SHAPE} mesh",
        "package://a/../lip.stl",
        "stays inside",
    ),
    "mesh missing": (
        LIP,
        '<mesh filename="lip.stl"/>',
        f"{SHAPE} mesh",
        "lip.stl",
        "a mesh file in the model folder",
    ),
    "same shape twice": (PLATE, '<collision name="bottom_lip">', CLASH, "bottom_lip", "its own"),
    "shape named as a link": (PLATE, '<collision name="frame">', CLASH, "frame", "its own"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_mistake(spoil, name: str) -> None:  # type: ignore[no-untyped-def]
    old, new, key, value, allowed = MISTAKES[name]
    with pytest.raises(ModelError) as caught:
        load(spoil(urdf=((old, new),)))
    evidence = caught.value.evidence
    assert evidence["file"] == "e62.urdf"
    assert evidence["key"] == key
    if value is not ...:
        assert evidence["value"] == value
    assert allowed in evidence["allowed"]
    assert str(caught.value).startswith(f"e62.urdf: {key} ")


JAW_LIMIT = JAW + '\n    <limit lower="-3.2" upper="3.2"'


@pytest.mark.parametrize("side", ["lower", "upper"])
@pytest.mark.parametrize(
    "text", ["0.2m", "nan", "true", "1,5", "", " ", "0x1", "1_0", "3 deg", "π"]
)
def test_limits_that_are_no_numbers(spoil, side: str, text: str) -> None:  # type: ignore[no-untyped-def]
    was = {"lower": "-3.2", "upper": "3.2"}[side]
    wrong = JAW_LIMIT.replace(f'{side}="{was}"', f'{side}="{text}"')
    with pytest.raises(ModelError, match=f"joint jaw limit {side}.* in rad") as caught:
        load(spoil(urdf=((JAW_LIMIT, wrong),)))
    assert caught.value.evidence["value"] == text


@pytest.mark.parametrize(
    ("lower", "upper"), [("-inf", "INF"), (" -1e400 ", "+Infinity"), ("-.5", "1.E2")]
)
def test_limits_that_say_there_is_none(spoil, lower: str, upper: str) -> None:  # type: ignore[no-untyped-def]
    limit = JAW_LIMIT.replace("-3.2", lower).replace('"3.2"', f'"{upper}"')
    assert load(spoil(urdf=((JAW_LIMIT, limit),))).stops
    wrong = JAW_LIMIT.replace("-3.2", upper if "nf" in upper.lower() else "inf")
    with pytest.raises(ModelError, match="joint jaw limit lower"):
        load(spoil(urdf=((JAW_LIMIT, wrong),)))


def test_numbers_that_nothing_uses(spoil) -> None:  # type: ignore[no-untyped-def]
    """Refused like others: the axis of what is fixed, the mass of what stands."""
    fixed = '<child link="rocker_foot"/>'
    with pytest.raises(ModelError, match=r"joint \w+ axis"):
        load(spoil(urdf=((fixed, f'{fixed}<axis xyz="0 one 0"/>'),)))
    assert load(spoil(urdf=((fixed, f'{fixed}<axis xyz="0 0 0"/>'),))).closures
    bare = '<link name="frame">'
    with pytest.raises(ModelError, match="link frame mass"):
        load(spoil(urdf=((bare, f'{bare}<inertial><mass value="heavy"/></inertial>'),)))


def test_origin_of_a_picture(spoil) -> None:  # type: ignore[no-untyped-def]
    """Numbers that are none are refused where a link is only looked at, too."""
    old = '<visual name="frame_wall">\n      <origin xyz="0 0 0"'
    with pytest.raises(ModelError) as caught:
        load(spoil(urdf=((old, old.replace("0 0 0", "0 zero 0")),)))
    assert caught.value.evidence["key"] == "link frame visual frame_wall origin xyz"


def test_moving_link_without_inertial(spoil) -> None:  # type: ignore[no-untyped-def]
    folder = spoil()
    path = folder / "e62.urdf"
    before, start, rest = path.read_text(encoding="utf-8").partition('<link name="rocker">')
    _, _, after = rest.partition("</inertial>")
    path.write_text(before + start + after, encoding="utf-8")
    with pytest.raises(ModelError, match=r"link rocker inertial is missing.* mass and inertia"):
        load(folder)


@pytest.mark.parametrize("side", ["parent", "child"])
def test_joint_to_unknown_link(spoil, side: str) -> None:  # type: ignore[no-untyped-def]
    ends = '<parent link="bottom_nipper"/>\n    <child link="top_nipper"/>'
    link = {"parent": "bottom_nipper", "child": "top_nipper"}[side]
    with pytest.raises(UnknownNameError) as caught:
        load(spoil(urdf=((ends, ends.replace(link, "nipper")),)))
    assert caught.value.evidence["name"] == "nipper"
    assert link in caught.value.evidence["known"]
    assert str(caught.value).startswith(f"e62.urdf: joint jaw {side}: there is no link")


@pytest.mark.parametrize(
    ("change", "key"),
    [(("</robot>", "</robot"), "XML"), (("<robot", "<machine"), "root element")],
)
def test_not_a_urdf(spoil, change: tuple[str, str], key: str) -> None:  # type: ignore[no-untyped-def]
    changes = (change,) if key == "XML" else (change, ("</robot>", "</machine>"))
    with pytest.raises(ModelError) as caught:
        load(spoil(urdf=changes))
    assert caught.value.evidence["key"] == key


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


def test_a_mesh_that_is_only_drawn_may_be_missing(spoil) -> None:  # type: ignore[no-untyped-def]
    """A run loads where the pictures are not; a path out of the folder is refused all the same."""
    folder = spoil()
    shutil.rmtree(folder / "meshes")
    assert load(folder).model == load("e62").model
    for name in ("../a.stl", "/a.stl", "package://a.stl", "b/../../a.stl", ""):
        with pytest.raises(ModelError, match="stays inside"):
            load(spoil(urdf=(('"meshes/rockers.stl"', f'"{name}"'),)))


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


@pytest.mark.parametrize(
    "number", ["1_2", "\uff11.2", "\u0661", "0x1p3", "infinity", "1e", "1.2.3"]
)
def test_what_is_no_number_of_xml_is_refused(spoil, number: str) -> None:  # type: ignore[no-untyped-def]
    """Python would read the first three and Pinocchio none of them."""
    with pytest.raises(ModelError, match="a finite number"):
        load(spoil(urdf=((MASS, f'<mass value="{number}"/>'),)))
