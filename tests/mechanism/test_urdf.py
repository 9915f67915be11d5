"""What a URDF may hold: meshes, joints and their planes, damping; and another reader.

URDFs as other programs and people write them are read as they are meant: texts of public files and
threads, cut down to what made them fail.
"""

from __future__ import annotations

import codecs
import logging
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from scipy.integrate import solve_ivp
from small_machines import hinge, link, machine, slide, sources, turn
from snapshots import Block, Words, blocks

from nipper_pin import Mechanism, ModelError, load
from nipper_pin.mechanism import (
    changed,
    collision_model,
    find_model,
    from_sources,
)
from nipper_pin.mechanism.files import parse_xml, urdf_parts
from nipper_pin.mechanism.files.urdf import check_urdf
from nipper_pin.mechanism.files.xml_text import encoding_of
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


def joint_of(kind: str, rpy: str, axis: str | None) -> urdf_parts.UrdfJoint:
    joint = slide("j", "a", "b").replace("prismatic", kind)
    joint = joint.replace("<origin ", f'<origin rpy="{rpy}" ')
    written = "" if axis is None else f'<axis xyz="{axis}"/>'
    parts = [link("a"), hinge("p", "frame", "a"), link("b"), re.sub("<axis .*?/>", written, joint)]
    root = parse_xml(sources(parts, 0)[0], "x.urdf")
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
    solution = turn(machine(parts, 2, drives=drives))
    t = np.linspace(0.0, 1.0, 21)
    rates = solution.trajectory.evaluate(t).rates
    w, k = 2.0 * np.pi, DAMPING / INERTIA
    # p = u' obeys p' + k p = A w^2 sin w t, whose steady part is below.
    steady = SWING * w**2 * (k * np.sin(w * t) - w * np.cos(w * t)) / (k**2 + w**2)
    expected = steady + (rates["wheel"][0] - steady[0]) * np.exp(-k * t)
    assert rates["shaft"] == pytest.approx(SWING * w * np.cos(w * t), abs=1e-12)
    assert rates["wheel"] == pytest.approx(expected, abs=1e-11)


def test_it_adds_to_the_dampers_of_the_file_and_has_a_path() -> None:
    dampers = {"oil": {"joint": "wheel", "damping_N_m_s_per_rad": 0.5}}
    parts = [link("wheel"), with_dynamics(hinge("wheel", "frame", "wheel"), 'damping="0.7"')]
    mechanism = machine(parts, 1, dampers=dampers)
    assert sorted(item.damping for item in mechanism.dampers) == [0.5, 0.7]
    other = changed(mechanism, {"urdf.joint.wheel.dynamics.damping": 0.9})
    assert sorted(item.damping for item in other.dampers) == [0.5, 0.9]
    parts = [link("ram"), with_dynamics(slide("ram", "frame", "ram"), 'damping="3.0"')]
    assert [item.damping for item in machine(parts, 1).dampers] == [3.0]


def test_what_does_not_matter_is_not_minded(
    e62: Mechanism, tmp_path: Path, capfd: pytest.CaptureFixture[str], words: Words
) -> None:
    """To the last bit, without a word; the differences stand in the reviewed text.

    Pinocchio's parser takes an inertial for none whose mass is spaced so. And many attributes:
    reading takes time in proportion to the text.
    """
    text, many = "", "<robot" + "".join(f' a{k}="{k}"' for k in range(30000))
    reviewed = blocks(__file__, "test_what_does_not_matter_is_not_minded")
    for number, item in enumerate([*reviewed, Block("many attributes", ["<robot", many], "")]):
        home = tmp_path / str(number)
        home.mkdir()
        found = load(model("e62", item.edits, home))
        assert capfd.readouterr() == ("", ""), item.name
        for ours, theirs in zip(found.model.inertias, e62.model.inertias, strict=True):
            assert (ours.toDynamicParameters() == theirs.toDynamicParameters()).all(), item.name
        for here, there in zip(found.model.jointPlacements, e62.model.jointPlacements, strict=True):
            assert (here.homogeneous == there.homogeneous).all(), item.name
        assert found.joints == e62.joints, item.name
        assert [stop.lever for stop in found.stops] == [stop.lever for stop in e62.stops]
        text += item.text and f"{item.text}    {found.side_view or 'the same'}\n"
    words(text, masked=False)


HEAD = '<?xml version="1.0"?>'


@pytest.mark.parametrize(
    ("declared", "encoding"),
    [
        ("", "utf-8"), ("", "utf-8-sig"), ("UTF-8", "utf-8"), ("ISO-8859-1", "latin-1"),
        ("windows-1252", "cp1252"), ("UTF-16", "utf-16"), ("utf-16", "utf-16-le"),
        ("utf-16", "utf-16-be"), ("", "utf-16"), ("us-ascii", "utf-8-sig"),
    ],
)  # fmt: skip
def test_encodings_are_those_of_the_file(
    e62: Mechanism, tmp_path: Path, declared: str, encoding: str
) -> None:
    """By the mark at its start, or what its first line declares; lines may end as on any system."""
    head = HEAD.replace("?>", f' encoding="{declared}"?>') if declared else HEAD
    file = (
        model("e62", (HEAD, head + "<!-- Kr\u00fcbel gr\u00f6\u00dfer -->"), tmp_path) / "e62.urdf"
    )
    file.write_bytes(file.read_text(encoding="utf-8").replace("\n", "\r\n").encode(encoding))
    found = load(file.parent)
    assert "gr\u00f6\u00dfer" in found.urdf
    # It is written in UTF-8 into runs and other models.
    assert encoding_of(found.urdf.encode()).lower() == "utf-8"
    assert found.model == e62.model


def test_marks_at_the_start_of_the_other_files(tmp_path: Path) -> None:
    """Of the TOML and of a table; lines may end as on any system."""
    spring = 'springs.coil = { joint = "axle", file = "spring.csv" }'
    file = model("small", [spring], tmp_path) / "small.toml"
    text = file.read_text(encoding="utf-8").replace("a lever", "Hebel l\u00e4nger")
    file.write_bytes(codecs.BOM_UTF8 + text.replace("\n", "\r\n").encode())
    table = b"coordinate_deg,torque_N_m\r\n-90,-1\r\n90,1\r\n"
    (file.parent / "spring.csv").write_bytes(codecs.BOM_UTF8 + table)
    found = load(file.parent)
    assert found.title.startswith("Hebel l\u00e4nger")
    assert len(found.tabulated_springs) == 1


def started(stranger: str, joint: str, at_deg: float) -> Mechanism:
    """A machine of others, with a joint turned at its start."""
    own = load(Path(__file__).parents[1] / "strangers" / stranger)
    document = {**own.description, "initial": {joint: {"at_deg": at_deg}}}
    return from_sources(stranger, own.urdf, document, ".")


def test_a_pendulum_of_points_welded_together() -> None:
    """Two halves of its mass are links of their own: 1 kg at 0.5 m, and the damper of the file."""
    times = np.linspace(0.0, 0.99, 12)
    found = turn(started("u08_pendulum", "th", 30.0)).trajectory.evaluate(times).joints["th"]
    right = solve_ivp(
        lambda _, y: [y[1], -9.81 / 0.5 * np.sin(y[0]) - 0.1 / 0.25 * y[1]],
        (0.0, 1.0), [np.pi / 6, 0.0], t_eval=times, rtol=1e-12, atol=1e-13, method="DOP853",
    ).y[0]  # fmt: skip
    np.testing.assert_allclose(found, right, rtol=0.0, atol=1e-9)


def test_a_cart_with_a_pole_that_grows_clockwise() -> None:
    """The public one: its hinge turns about +y, so the pole falls towards +x as its angle grows."""
    mechanism = started("u03_cartpole", "h", 5.0)
    assert mechanism.side_view.startswith("coordinates of h grow clockwise")
    times = np.linspace(0.0, 0.99, 12)
    q = turn(mechanism).trajectory.evaluate(times).joints
    found = np.column_stack([q["s"], q["h"]])

    def rates(_: float, y: Any) -> list[float]:
        m, big, arm, turning = 10.0, 1.0, 0.5, 1.0
        mass = [[big + m, m * arm * np.cos(y[1])], [m * arm * np.cos(y[1]), turning + m * arm**2]]
        force = [m * arm * y[3] ** 2 * np.sin(y[1]), m * 9.81 * arm * np.sin(y[1])]
        return [*y[2:], *np.linalg.solve(mass, force)]

    right = solve_ivp(
        rates, (0.0, 1.0), [0.0, np.radians(5.0), 0.0, 0.0], t_eval=times, rtol=1e-12,
        atol=1e-13, method="DOP853",
    ).y[:2].T  # fmt: skip
    assert found[4, 0] < 0.0 < found[4, 1]
    np.testing.assert_allclose(found, right, rtol=0.0, atol=1e-9)


def test_a_spatial_machine_is_refused_by_the_joint_that_makes_it_so() -> None:
    """Three directions of sliding."""
    parts = [link("a"), slide("x", "frame", "a"), link("b"), slide("z", "a", "b", (0.0, 1.0)),
             link("c"), slide("y", "b", "c").replace("1.0 0 0.0", "0 1 0")]  # fmt: skip
    words = "an axis across y of the root link, as the plane of x, z has it"
    with pytest.raises(ModelError, match=words) as caught:
        machine(parts, 3)
    assert caught.value.evidence["key"] == "joint y axis"
