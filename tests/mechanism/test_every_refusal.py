"""What models are refused for, with evidence, and branches that few machines take."""

from __future__ import annotations

import copy
import re
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from small_machines import SHAFT, hinge, link, machine

from nipper_pin import Mechanism
from nipper_pin.errors import AssemblyError, InputError, ModelError, UnknownNameError
from nipper_pin.mechanism import new_folder
from nipper_pin.mechanism.build import contact, laws, tree
from nipper_pin.mechanism.drawing import tree as drawn
from nipper_pin.mechanism.drives import DriveTable, register_drive
from nipper_pin.mechanism.edit import dimensions, layout, points
from nipper_pin.mechanism.files import describe, schema, urdf, urdf_parts, urdf_shapes
from nipper_pin.mechanism.files.description import CylinderDescription

# The package has a function of the same name.
load: Any = import_module("nipper_pin.mechanism.load")
model_files: Any = import_module("nipper_pin.mechanism.model_files")


def refused(error: Any) -> tuple[Any, Any, Any]:
    return tuple(error.value.evidence[key] for key in ("file", "key", "value"))  # type: ignore[return-value]


# The document.


def test_sections_that_are_no_tables() -> None:
    with pytest.raises(ModelError, match="a table of tables") as caught:
        describe.describe({"stops": 7}, "x.toml")
    assert refused(caught) == ("x.toml", "stops", 7)


@pytest.mark.parametrize(
    ("document", "place", "name"),
    [
        ({"a\nb": 1}, "the file", "a\nb"),
        ({"stops": {"x\t": {}}}, "stops", "x\t"),
        ({"phases": [{}, {"deep": {"\x07": 1}}]}, "phases[1].deep", "\x07"),
    ],
)
def test_names_that_no_message_can_show(document: Any, place: str, name: str) -> None:
    with pytest.raises(ModelError, match="without line breaks and control characters") as caught:
        describe.describe(document, "x.toml")
    assert refused(caught) == ("x.toml", place, name)


def test_numbers_that_an_entry_may_have() -> None:
    """None of a law that does not exist; of others those that are not given."""
    assert describe.optional_numbers("drives", {"joint": "a", "law": "magic"}) == {}
    found = describe.optional_numbers("stops", {"joint": "a", "restitution": 0.25})
    assert "restitution" not in found
    assert all(isinstance(value, float | int) for value in found.values())


def test_a_key_of_several_kinds() -> None:
    """Null is no value of TOML; a choice of one is that one."""
    plain = schema._plain
    number, text = {"type": "number"}, {"type": "string"}
    null = {"type": "null"}
    assert plain({"anyOf": [number, null], "default": None}, "words") == {
        "description": "words", **number,
    }  # fmt: skip
    assert plain({"anyOf": [number, text, null], "default": 1}, None) == {
        "anyOf": [number, text], "default": 1,
    }  # fmt: skip
    assert plain({"additionalProperties": {"discriminator": 1, "a": 2}}, "") == {
        "additionalProperties": {"a": 2}
    }
    assert plain(dict(text), "") == text


def test_tables_that_are_no_drive_law() -> None:
    """Neither another class nor a second law of one name."""

    class SecondCam(DriveTable, frozen=True, kw_only=True, tag="cam"):
        """A law of this name exists."""

    no_table: Any = dict
    with pytest.raises(InputError, match="is no table of a drive law: derive it from DriveTable"):
        register_drive(no_table)
    with pytest.raises(InputError, match=r"a drive law 'cam' exists already \(CamDrive\)"):
        register_drive(SecondCam)


def test_classes_of_one_name() -> None:
    """The schema goes by names of classes, in all rooms: none pushes another one out."""
    for name in ("CamDrive", "OrificeForce", "StopDescription"):
        kind = type(DriveTable)(
            name, (DriveTable,), {"__module__": __name__}, frozen=True, kw_only=True, tag="lifter"
        )
        with pytest.raises(InputError, match=f"a class {name} exists already"):
            register_drive(kind)
    keys = schema.model_schema()["$defs"]["Description"]["properties"]
    laws = keys["drives"]["additionalProperties"]["anyOf"]
    assert {"$ref": "#/$defs/CamDrive"} in laws


def test_reference_of_a_drive() -> None:
    """Where it is smallest or largest; only of a drive that swings, and no other place beside."""

    def cylinder(**given: Any) -> CylinderDescription:
        return CylinderDescription(
            rated_speed_rpm=60.0, direction="clockwise", angle_at_touch_deg=0.0,
            reference_index=0.0, **given,
        )  # fmt: skip

    class Swing:
        """-cos(angle - 1): smallest at 1 and largest at 1 + pi."""

        knots_rad: tuple[float, ...] = ()

        def evaluate(self, angle: Any) -> Any:
            return -np.cos(angle - 1.0), np.sin(angle - 1.0), np.cos(angle - 1.0)

    class Turn(Swing):
        """Goes on and on."""

        def evaluate(self, angle: Any) -> Any:
            return angle, np.ones_like(angle), np.zeros_like(angle)

    known: Any = {"swing": Swing(), "turn": Turn()}
    find = lambda **given: laws._reference(cylinder(**given), known, "x.toml")  # noqa: E731
    assert find(reference_angle_deg=90.0) == pytest.approx(np.pi / 2.0)
    low = find(reference_drive="swing", reference_extreme="minimum")
    high = find(reference_drive="swing", reference_extreme="maximum")
    assert (low, high) == (pytest.approx(1.0), pytest.approx(1.0 + np.pi))
    with pytest.raises(ModelError, match="a drive that swings to and fro") as caught:
        find(reference_drive="turn")
    assert refused(caught) == ("x.toml", "cylinder.reference_drive", "turn")
    for given in ({}, {"reference_drive": "swing", "reference_angle_deg": 1.0}):
        with pytest.raises(ModelError, match="exactly one of") as caught:
            find(**given)
        assert refused(caught)[1] == "cylinder.reference_drive"
    with pytest.raises(UnknownNameError, match="nothing"):
        find(reference_drive="nothing")


# The URDF.


def test_links_without_the_part_that_changes() -> None:
    urdf_text = (
        '<robot name="r"><link name="a"><inertial><mass value="2"/></inertial></link></robot>'
    )
    found = layout.read_layout(urdf.parse_xml(urdf_text, "x.urdf"), {}, "x.urdf")
    dimensions._write_number(found, "a", "mass_kg", 3.5, "links.a.mass_kg", "x.urdf")
    assert found.root.find("link/inertial/mass").get("value") == "3.5"  # type: ignore[union-attr]
    with pytest.raises(ModelError, match="the link has no <inertia>") as caught:
        dimensions._write_number(found, "a", "inertia_kg_m2", 1.0, "links.a.inertia", "x.urdf")
    assert refused(caught) == ("x.urdf", "links.a.inertia", None)


@pytest.mark.parametrize(
    ("inertial", "key", "words"),
    [
        ('<mass value="1"/>', "link a inertia", "an inertia about the centre of mass"),
        ('<inertia ixx="1" iyy="1" izz="1"/>', "link a mass", "a positive mass"),
    ],
)
def test_bodies_without_inertia(inertial: str, key: str, words: str) -> None:
    parts = [f'<link name="a"><inertial>{inertial}</inertial></link>', hinge("p", "frame", "a")]
    with pytest.raises(ModelError, match=words) as caught:
        machine(parts, 1)
    assert refused(caught) == ("small.urdf", key, None)


def test_contacts_of_links_without_shapes() -> None:
    """The element of that name, all of a link, or a refusal that says what is missing."""
    objects = {"one": 0, "two": 1, "three": 2}
    geometry: Any = SimpleNamespace(
        geometryObjects=["1st", "2nd", "3rd"], getGeometryId=lambda name: objects[name]
    )
    urdf: Any = SimpleNamespace(shapes={"arm": ("one", "three"), "bare": (), "hand": ("two",)})

    def find(name: str) -> Any:
        among = tree.Tree(None, (), [], urdf, geometry, "x.toml", "x.urdf")
        return contact._shapes(name, among, "stops.a.contact")

    assert find("two") == ["2nd"]
    assert find("arm") == ["1st", "3rd"]
    with pytest.raises(ModelError, match=r"stops\.a\.contact in x\.toml needs a coll") as caught:
        find("bare")
    assert refused(caught) == ("x.urdf", "link bare collision", None)
    with pytest.raises(UnknownNameError) as no:
        find("foot")
    for name in ("one", "two", "three", "arm", "hand"):
        assert name in no.value.message
    assert "bare" not in no.value.message


@pytest.mark.parametrize(
    ("shapes", "wrong"),
    [
        ({"a": ("x", "y"), "b": ("z",), "c": ()}, None),
        # The only shape of a link may have its name, and no other link's.
        ({"a": ("a",), "b": ("b",)}, None),
        ({"a": ("a", "x")}, ("a", "a", "the link of that name")),
        ({"a": ("x",), "b": ("a",)}, ("b", "a", "the link of that name")),
        ({"a": ("b",), "b": ("y",)}, ("a", "b", "the link of that name")),
        ({"a": ("x",), "b": ("x",)}, ("b", "x", "a collision element of link a")),
        ({"a": ("x", "x")}, ("a", "x", "a collision element of link a")),
        ({"a": ("a",), "b": ("a",)}, ("b", "a", "a collision element of link a")),
    ],
)
def test_names_of_shapes(shapes: Any, wrong: Any) -> None:
    """Contacts name links and shapes alike, so that each name is that of one thing."""
    if wrong is None:
        urdf._check_shape_names(shapes, "x.urdf")
        return
    link_name, name, other = wrong
    with pytest.raises(ModelError, match=f"a name of its own; it clashes with {other}") as caught:
        urdf._check_shape_names(shapes, "x.urdf")
    assert refused(caught) == ("x.urdf", f"link {link_name} collision name", name)


@pytest.mark.parametrize(
    ("joints", "wrong"),
    [
        ((("root", "a"), ("a", "b"), ("root", "c")), None),
        ((("root", "a"), ("b", "a")), ("joint 1 child", "a")),
        ((("root", "a"),), ("root links", ["root", "b", "c"])),
        ((("b", "a"), ("a", "b"), ("root", "c")), ("links", ["a", "b"])),
    ],
)
def test_links_that_are_no_tree(joints: Any, wrong: Any) -> None:
    """One joint a link, one root, and no circle."""
    links = ("root", "a", "b", "c")
    given: Any = {
        str(k): SimpleNamespace(name=str(k), parent=one, child=other)
        for k, (one, other) in enumerate(joints)
    }
    if wrong is None:
        assert urdf._check_tree(links, given, "x.urdf") == "root"
        return
    with pytest.raises(ModelError) as caught:
        urdf._check_tree(links, given, "x.urdf")
    assert refused(caught) == ("x.urdf", *wrong)


JOINTS = (
    '<robot name="r"><link name="f"/><link name="a"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1"/></inertial></link><link name="b"><inertial>'
    '<mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>'
    '<joint name="p" type="revolute"><parent link="f"/><child link="a"/><axis xyz="0 -1 0"/>'
    "</joint>"
    '<joint name="j" type="{}"><parent link="a"/><child link="b"/><origin rpy="{}"/>{}</joint>'
    "</robot>"
)


def _read(kind: str, rpy: str, axis: str | None) -> urdf_parts.UrdfJoint:
    written = "" if axis is None else f'<axis xyz="{axis}"/>'
    root = urdf.parse_xml(JOINTS.format(kind, rpy, written), "x.urdf")
    return urdf.check_urdf(root, "x.urdf", Path()).joints["j"]


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
    found = _read(kind, rpy, axis)
    assert found.axis == pytest.approx(wanted, abs=1e-15)
    assert found.axis[1] in (0.0, wanted[1])
    turn = found.placement.rotation
    assert (turn[1] == [0.0, 1.0, 0.0]).all()
    assert (turn[:, 1] == [0.0, 1.0, 0.0]).all()
    # An angle of three digits is followed to as many.
    assert np.arctan2(turn[0, 2], turn[0, 0]) == pytest.approx(pitch, abs=3e-6)


@pytest.mark.parametrize(
    ("kind", "axis", "wanted"),
    [
        ("prismatic", "0 0 0", "an axis has a direction"),
        ("revolute", "0 0 0", "an axis has a direction"),
        ("prismatic", "3 1e-1 4", "an axis across y of the root link, as the plane of p has it"),
        ("revolute", "0 -1 1e-2", "an axis along y of the root link, as the plane of p has it"),
        ("revolute", None, "an axis along y of the root link"),
    ],
)
def test_axes_out_of_the_plane(kind: str, axis: str | None, wanted: str) -> None:
    """Refused by the joint that leaves the plane of the others, with what the file has."""
    with pytest.raises(ModelError, match=wanted) as caught:
        _read(kind, "0 0 0", axis)
    value: Any = "none, which means 1 0 0"
    if axis is not None:
        value = [float(word) for word in axis.split()]
    assert refused(caught) == ("x.urdf", "joint j axis", value)


def test_points_that_are_one_pin() -> None:
    """Ends of a closure are; a pin in a slot goes its own way."""
    points = {name: name for name in ("a", "b", "c", "d", "e")}
    closures = {
        "one": {"frame_a": "a", "frame_b": "b"}, "two": {"frame_a": "b", "frame_b": "c"},
        "slot": {"frame_a": "c", "frame_b": "d", "slot_axis": "x"},
        "loose": {"frame_a": "e", "frame_b": "nothing"},
    }  # fmt: skip
    found = layout._meeting(points, {"closures": closures})
    assert {name: set(pins) for name, pins in found.items()} == {
        "a": {"a", "b", "c"}, "b": {"a", "b", "c"}, "c": {"a", "b", "c"}, "d": {"d"}, "e": {"e"},
    }  # fmt: skip
    assert layout._meeting(points, {}) == {name: (name,) for name in points}


def test_axes_of_drives_go_with_their_pins() -> None:
    """Those that stand on a pin, to a millionth of a millimetre; the document itself stays."""
    found: Any = SimpleNamespace(
        points={"a": "one", "b": "two"},
        place={"one": np.array([0.1, 9.0, 0.2]), "two": np.array([0.3, 9.0, 0.4])},
    )
    place = {"one": np.array([0.5, 9.0, 0.6]), "two": np.array([0.7, 9.0, 0.8])}
    document = {
        "drives": {
            "on": {"guide_axis_mm": [100.0, 200.0], "crank_axis_mm": [300.0, 400.0]},
            "near": {"guide_axis_mm": [300.0, 400.0000005]},
            "off": {"guide_axis_mm": [300.0, 400.000002], "crank_axis_mm": [300.000002, 400.0]},
            "none": {"ratio": 1.0},
        },
        "other": 1,
    }
    before = copy.deepcopy(document)
    moved: Any = points._with_guides(document, found, place)
    assert document == before
    assert moved["other"] == 1
    assert moved["drives"]["on"] == {
        "guide_axis_mm": pytest.approx([500.0, 600.0]),
        "crank_axis_mm": pytest.approx([700.0, 800.0]),
    }
    assert moved["drives"]["near"]["guide_axis_mm"] == pytest.approx([700.0, 800.0])
    for name in ("off", "none"):
        assert moved["drives"][name] == before["drives"][name]  # type: ignore[index]
    assert points._with_guides({}, found, place) == {"drives": {}}


def test_points_of_one_pin_go_together() -> None:
    """Two places for one pin are refused; a point that stays is none that moves."""
    found: Any = SimpleNamespace(
        meeting={"a": ("a", "b"), "b": ("a", "b"), "c": ("c",)},
        points={"a": "one", "b": "two", "c": "three"},
        point_mm=lambda name: {"a": (1.0, 2.0), "b": (1.0, 2.0), "c": (5.0, 6.0)}[name],
    )
    shifts = points._shifts(found, {"a": (4.0, 1.0), "c": (5.0, 6.0)}, "x.urdf")
    assert {name: shift.tolist() for name, shift in shifts.items()} == {
        "one": pytest.approx([3e-3, 0.0, -1e-3]), "two": pytest.approx([3e-3, 0.0, -1e-3]),
    }  # fmt: skip
    same = points._shifts(found, {"a": (4.0, 1.0), "b": (4.0, 1.0000005)}, "x.urdf")
    assert set(same) == {"one", "two"}
    with pytest.raises(ModelError, match="one place for the points a, b: one pin") as caught:
        points._shifts(found, {"a": (4.0, 1.0), "b": (4.0, 1.000002)}, "x.urdf")
    assert refused(caught) == ("x.urdf", "points.b", [4.0, 1.000002])


def test_origins_that_are_written() -> None:
    """Angles stay unless they are given; an origin that is not there is made."""
    joint = ElementTree.fromstring('<joint><origin xyz="1 2 3" rpy="0.5 0 0"/></joint>')
    points.write_origin(joint, np.array([0.1, 1e-17, -3.0]), None)
    assert joint.find("origin").attrib == {"xyz": "0.1 1e-17 -3.0", "rpy": "0.5 0 0"}  # type: ignore[union-attr]
    points.write_origin(joint, np.zeros(3), np.array([1.0, 2.0, 0.25]))
    assert joint.find("origin").attrib == {"xyz": "0.0 0.0 0.0", "rpy": "1.0 2.0 0.25"}  # type: ignore[union-attr]
    bare = ElementTree.fromstring("<joint/>")
    points.write_origin(bare, np.ones(3), None)
    assert bare.find("origin").attrib == {"xyz": "1.0 1.0 1.0"}  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "name", ["/abs.stl", "../up.stl", "a/../b.stl", "C:x.stl", "a\\b.stl", "", "package://only"]
)
def test_meshes_outside_of_the_folder(name: str) -> None:
    with pytest.raises(ModelError) as caught:
        urdf_shapes.path_inside(name, "link a", "x.urdf")
    assert refused(caught) == ("x.urdf", "link a mesh", name)


def test_meshes_of_packages(tmp_path: Path) -> None:
    """The model folder stands for its own package, and for no other that it names."""
    assert urdf_shapes.path_inside("a/b.stl", "k", "f") == "a/b.stl"
    assert urdf_shapes.path_inside("package://p/a/b.stl", "k", "f") == "a/b.stl"
    (tmp_path / "b.stl").write_text("", encoding="utf-8")
    find = lambda name: urdf_shapes.mesh_path(name, tmp_path, "link a", "x.urdf")  # noqa: E731
    assert find("package://any/b.stl") == find("b.stl") == (tmp_path / "b.stl").resolve()
    (tmp_path / "package.xml").write_text("<p><name> mine </name></p>", encoding="utf-8")
    assert find("package://mine/b.stl") == find("b.stl")
    with pytest.raises(ModelError, match=r"package://mine/\.\.\.") as caught:
        find("package://other/b.stl")
    assert refused(caught) == ("x.urdf", "link a mesh", "package://other/b.stl")
    (tmp_path / "package.xml").write_text("<p>", encoding="utf-8")
    with pytest.raises(ModelError, match=r"a package whose package.xml can be read") as caught:
        find("package://mine/b.stl")
    assert refused(caught) == ("x.urdf", "link a mesh", "package://mine/b.stl")
    with pytest.raises(ModelError, match="a mesh file in the model folder") as caught:
        find("gone.stl")
    assert refused(caught) == ("x.urdf", "link a mesh", "gone.stl")
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "away.stl").symlink_to(tmp_path / "b.stl")
    with pytest.raises(ModelError) as caught:
        urdf_shapes.mesh_path("away.stl", tmp_path / "inner", "link a", "x.urdf")
    assert refused(caught) == ("x.urdf", "link a mesh", "away.stl")


# The whole model.


def test_advice_on_pins_that_open() -> None:
    """Only where an override moves one side of a pin."""
    error = AssemblyError(file="x.toml", key="closures", value=1.0, allowed="closures that meet")
    assert load._with_advice(error, {"stops.a.restitution": 1.0}) is error
    raw = {"urdf.joint.a.origin.xyz.x": 1.0, "urdf.joint.b.origin.xyz.z": 2.0, "points.c.x_mm": 3.0}
    told = load._with_advice(error, raw)
    assert told.evidence == {
        **error.evidence,
        "allowed": "closures that meet; urdf.joint.a.origin.xyz.x, urdf.joint.b.origin.xyz.z moves "
        "one side of a pin only: points.<hinge or frame>.x_mm, z_mm, radius_mm and angle_deg move "
        "everything that meets in it",
    }


def test_a_changed_mechanism_whose_pins_open(
    monkeypatch: pytest.MonkeyPatch, e62: Mechanism
) -> None:
    def opens(*_: Any) -> Any:
        raise AssemblyError(file="e62.toml", key="closures", value=1.0, allowed="pins that meet")

    path = "urdf.joint.jaw.origin.xyz.x"
    monkeypatch.setattr(load, "from_sources", opens)
    words = f"pins that meet; {re.escape(path)} moves one side of a pin only"
    with pytest.raises(AssemblyError, match=words):
        load.with_numbers(e62, {path: 0.5})


def test_models_that_come_with_the_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Inside the package, else beside it, else none; a folder without its file is no model."""
    package = tmp_path / "home" / "package"
    (package / "mechanism").mkdir(parents=True)
    monkeypatch.setattr(model_files, "__file__", str(package / "mechanism" / "model_files.py"))
    assert model_files.known_models() == {}

    def model(home: Path, name: str, *, whole: bool = True) -> None:
        (home / "models" / name).mkdir(parents=True)
        if whole:
            (home / "models" / name / f"{name}.toml").write_text("", encoding="utf-8")

    model(package.parent, "beside")
    model(package.parent, "empty", whole=False)
    assert model_files.known_models() == {"beside": package.parent / "models" / "beside"}
    model(package, "inside")
    assert model_files.known_models() == {"inside": package / "models" / "inside"}


def test_names_that_a_mechanism_has_not(e62: Mechanism) -> None:
    for item in e62.stops:
        assert e62.stop(item.name) is item
    with pytest.raises(UnknownNameError, match="jam") as caught:
        e62.stop("jam")
    assert all(item.name in caught.value.message for item in e62.stops)
    for phase in e62.phases:
        assert e62.phase(phase.number) is phase
        assert e62.phase_of(phase.closed) is phase
    assert e62.phase_of(frozenset({"nothing"})) is None
    with pytest.raises(UnknownNameError) as caught:
        e62.phase(99)
    assert "99" in caught.value.message
    assert all(str(phase.number) in caught.value.message for phase in e62.phases)
    assert e62.links == tuple(joint.child for joint in e62.joints)


def test_new_folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whole or not at all; what is there stays, and nothing is left behind."""
    target = tmp_path / "deep" / "model"
    with new_folder.new_folder(target) as partial:
        assert partial.name == "model"
        # Renaming is one step within one file system only.
        assert target.parent in partial.parents
        (partial / "file").write_text("x", encoding="utf-8")
        assert not target.exists()
    assert (target / "file").read_text(encoding="utf-8") == "x"
    assert [item.name for item in target.parent.iterdir()] == ["model"]
    with pytest.raises(InputError, match="is there already and is not empty") as caught:
        new_folder.check_new_folder(target)
    assert caught.value.evidence == {"folder": str(target)}
    with pytest.raises(InputError, match="is there already"):
        new_folder.check_new_folder(target / "file")
    (tmp_path / "empty").mkdir()
    assert new_folder.check_new_folder(tmp_path / "empty") == (tmp_path / "empty").resolve()
    message = "stop"

    def fails() -> None:
        with new_folder.new_folder(tmp_path / "other") as partial:
            (partial / "file").write_text("x", encoding="utf-8")
            raise RuntimeError(message)

    with pytest.raises(RuntimeError, match=message):
        fails()
    assert not (tmp_path / "other").exists()
    with (
        pytest.raises(InputError, match=r"cannot be made: .* is not a folder") as caught,
        new_folder.new_folder(target / "file" / "below"),
    ):
        pass
    assert caught.value.evidence == {"folder": str(target / "file" / "below")}

    def denied(_: Path) -> Any:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "iterdir", denied)
    with pytest.raises(InputError, match="cannot be written: Permission denied") as caught:
        new_folder.check_new_folder(tmp_path / "empty")
    assert caught.value.evidence == {"folder": str(tmp_path / "empty")}


def test_joints_of_a_drawing_that_slide() -> None:
    """Slides and blocks of slots do; pins do not, and what closes a loop has no coordinate."""
    slide, slot = object.__new__(drawn.Slide), object.__new__(drawn.Slot)
    hinge_, cut = object.__new__(drawn.Pin), object.__new__(drawn.Pin)
    made = drawn.Tree(
        SimpleNamespace(name="made up"),
        {},
        {"a": slide, "b": hinge_},
        {"c": slot, "d": cut},
        {},  # type: ignore[arg-type, dict-item]
    )
    assert [made.slides(name) for name in ("a", "b", "c")] == [True, False, True]
    for name in ("d", "e"):
        with pytest.raises(InputError, match=r"joints that have: a, b, c$") as caught:
            made.slides(name)
        assert caught.value.evidence == {"joint": name}


def test_fixed_joints_have_no_coordinate() -> None:
    """A named frame on a link is none of the tree's joints."""
    parts = [link("a"), hinge("p", "frame", "a"), '<link name="eye"/>',
             '<joint name="weld" type="fixed"><parent link="a"/><child link="eye"/></joint>',
             link("b"), hinge("q", "a", "b", (1.0, 0.0))]  # fmt: skip
    made = machine(
        parts, 2, drives={"d": {"joint": "p", "law": "constant_speed", "ratio": 1.0, **SHAFT}}
    )
    assert [(j.name, j.parent, j.child, j.index) for j in made.joints] == [
        ("p", "frame", "a", 0), ("q", "a", "b", 1),
    ]  # fmt: skip
