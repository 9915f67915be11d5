"""URDFs as other programs and people write them: read as they are meant, or refused in a sentence.

The texts are those of public files and threads, cut down to what made them fail.
"""

from __future__ import annotations

import codecs
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_machines import hinge, link, slide, sources

from nipper_pin import Case, Mechanism, ModelError, Window, load, simulate
from nipper_pin.mechanism import from_sources
from nipper_pin.mechanism.files.xml_text import encoding_of
from tests.refusals.bases import model
from tests.refusals.hostile import MASS

# Of the E62.
JAW = '<origin xyz="0.1226 0 0.0561" rpy="0 0 0"/>\n    <axis xyz="0 -1 0"/>'
INERTIA = 'iyy="0.001142"'
FOOT, FRAME = '<link name="rocker_foot"/>', '<link name="frame">'
NO_INERTIA = 'ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"'
ENDED, ROBOT, HEAD = "</robot>", "<robot", '<?xml version="1.0"?>'
LIMITED, EFFORT = f'{JAW}\n    <limit lower="-3.2" upper="3.2"', ' effort="10000" velocity="1000"/>'
COLOUR = '<material><color rgba="255 0 0 255"/></material>'

# What to replace in the URDF of the E62, and by what: the same machine.
READ_ALIKE = {
    "no limit": (f"{LIMITED}{EFFORT}", JAW),
    "limit of nothing": (LIMITED, f"{JAW}<limit"),
    "limit without effort": (f"{LIMITED}{EFFORT}", f'{JAW}<limit lower="-10" upper="10"/>'),
    "limit in words": (LIMITED, f'{JAW}<limit lower="-pi" upper="pi"'),
    "no end": (LIMITED, f'{JAW}<limit lower="-inf" upper="INF"'),
    "no end of a number": (LIMITED, f'{JAW}<limit lower=" -1e400 " upper="+Infinity"'),
    "short numbers": (LIMITED, f'{JAW}<limit lower="-.5" upper="1.E2"'),
    "effort": (LIMITED, f'{JAW}<limit lower="-1" upper="1" effort="inf" velocity="nan"/><limit'),
    "safety": (LIMITED, f'{JAW}<safety_controller k_velocity="x"/><calibration/><limit'),
    "empty dynamics": (LIMITED, f"{JAW}<dynamics/><limit"),
    "version": (ROBOT, '<robot version="9.x"'),
    "no name": ('<robot name="e62"', "<robot"),
    "material without a name": (FRAME, f'{FRAME}<visual><geometry><box size="1 1 1"/></geometry>'
                                       f"{COLOUR}</visual>"),
    "unknown material": (FRAME, f'{FRAME}<visual><geometry><box size="1 1 1"/></geometry>'
                                '<material name="rust"/></visual>'),
    "other programs": (ENDED, '<gazebo><color/><joint name="x" type="revolute"><axis xyz="1"/>'
                              f'</joint></gazebo><transmission name="t"/>{ENDED}'),
    "namespace": (ROBOT, '<robot xmlns="http://example.org/x"'),
    "a frame with a mass": (FOOT, '<link name="rocker_foot"><inertial><mass value="0"/>'
        '<inertia ixx="0" iyy="0" izz="0"/></inertial></link>'),
    "a frame without mass at rest": (
        FRAME, f'{FRAME}<inertial><mass value="0"/><inertia ixx="1" iyy="-1"/></inertial>'),
    "a frame without anything": (FRAME, f"{FRAME}<inertial/>"),
    "many attributes": (ROBOT, ROBOT + "".join(f' a{k}="{k}"' for k in range(30000))),
    # Pinocchio's parser takes an inertial that is spaced so for none, and goes on.
    **{f"mass {text!r}": (MASS, f'<mass value="{text}"/>')
       for text in ("1.2 ", " 1.2", "\t1.2", "+1.2e0")},
    "spaces around an inertia": (INERTIA, 'iyy=" 0.001142 "'),
    "product of inertia left out": (' iyz="0"', ""),
    "spaces in a place": (JAW, JAW.replace("0.1226 0 0.0561", " 0.1226\n0\t0.0561  ")),
    "spaces in an axis": (JAW, JAW.replace("0 -1 0", "0   -1 0 ")),
    "few digits": (JAW, JAW.replace('"0 -1 0"', '"0 -1 0.0005"').replace("0 0 0", "6.2832 0 0")),
}  # fmt: skip


@pytest.mark.parametrize("name", READ_ALIKE)
def test_what_does_not_matter_is_not_minded(
    name: str, e62: Mechanism, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """To the last bit, without a word; reading takes time in proportion to the text."""
    found = load(model("e62", READ_ALIKE[name], tmp_path))
    assert capfd.readouterr() == ("", "")
    for ours, theirs in zip(found.model.inertias, e62.model.inertias, strict=True):
        assert (ours.toDynamicParameters() == theirs.toDynamicParameters()).all()
    for here, there in zip(found.model.jointPlacements, e62.model.jointPlacements, strict=True):
        assert (here.homogeneous == there.homogeneous).all()
    assert found.joints == e62.joints
    assert [stop.lever for stop in found.stops] == [stop.lever for stop in e62.stops]
    assert bool(found.side_view) == ("few digits" in name)


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


def machine_of(urdf: str, freedom: int, **tables: Any) -> Mechanism:
    _, document = sources([], freedom, gravity=9.81, **tables)
    return from_sources("other", urdf, document, ".")


def followed(mechanism: Mechanism, times: Any) -> Any:
    found = simulate(mechanism, Case(speed_rpm=60.0, window=Window.CYCLE, cycles=1))
    return found.trajectory.evaluate(times).q


def test_a_pendulum_of_points_welded_together() -> None:
    """Two halves of its mass are links of their own: 1 kg at 0.5 m, and the damper of the file."""
    point = (
        f'<inertial><origin xyz="0 0 -.5"/><mass value="0.5"/><inertia {NO_INERTIA}/></inertial>'
    )
    urdf = (
        f'<robot name="P"><link name="world"/><link name="base">{point}</link>'
        '<joint name="up" type="fixed"><origin xyz="0 0 1"/><parent link="world"/>'
        f'<child link="base"/></joint><link name="arm">{point}</link>'
        '<joint name="th" type="continuous"><axis xyz="0 -1 0"/><dynamics damping="0.1"/>'
        f'<parent link="base"/><child link="arm"/></joint><link name="com">{point}</link>'
        '<joint name="aw" type="fixed"><parent link="arm"/><child link="com"/></joint></robot>'
    )
    mechanism = machine_of(urdf, 1, initial={"th": {"at_deg": 30.0}})
    times = np.linspace(0.0, 0.99, 12)
    found = followed(mechanism, times)[:, 0]
    right = solve_ivp(
        lambda _, y: [y[1], -9.81 / 0.5 * np.sin(y[0]) - 0.1 / 0.25 * y[1]],
        (0.0, 1.0), [np.pi / 6, 0.0], t_eval=times, rtol=1e-12, atol=1e-13, method="DOP853",
    ).y[0]  # fmt: skip
    np.testing.assert_allclose(found, right, rtol=0.0, atol=1e-9)


def test_a_cart_with_a_pole_that_grows_clockwise() -> None:
    """The public one: its hinge turns about +y, so the pole falls towards +x as its angle grows."""
    inertia = 'ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"'
    urdf = (
        f'<robot name="p"><link name="bar"><inertial><mass value="0"/><inertia {inertia}/>'
        '</inertial></link><link name="cart"><inertial><mass value="1"/>'
        f'<inertia {inertia}/></inertial></link><joint name="s" type="prismatic">'
        '<axis xyz="1 0 0"/><parent link="bar"/><child link="cart"/></joint><link name="pole">'
        f'<inertial><origin xyz="0 0 0.5"/><mass value="10"/><inertia {inertia}/></inertial></link>'
        '<joint name="h" type="continuous"><axis xyz="0 1 0"/><parent link="cart"/>'
        '<child link="pole"/></joint></robot>'
    )
    mechanism = machine_of(urdf, 2, initial={"h": {"at_deg": 5.0}})
    assert mechanism.side_view.startswith("coordinates of h grow clockwise")
    times = np.linspace(0.0, 0.99, 12)
    places = {joint.name: joint.index for joint in mechanism.joints}
    found = followed(mechanism, times)[:, [places["s"], places["h"]]]

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


@pytest.mark.parametrize(
    ("parts", "joint", "words"),
    [
        # Three directions of sliding; two planes of hinges, of which most joints share one.
        (
            [link("a"), slide("x", "frame", "a"), link("b"), slide("z", "a", "b", (0.0, 1.0)),
             link("c"), slide("y", "b", "c").replace("1.0 0 0.0", "0 1 0")],
            "y", "an axis across y of the root link, as the plane of x, z has it",
        ),
        (
            [link("a"), hinge("one", "frame", "a").replace("0 -1 0", "1 0 0"), link("b"),
             hinge("two", "a", "b"), link("c"), slide("x", "b", "c")],
            "one", "an axis along y of the root link, as the plane of two, x has it",
        ),
    ],
)  # fmt: skip
def test_a_spatial_machine_is_refused_by_the_joint_that_makes_it_so(
    parts: list[str], joint: str, words: str
) -> None:
    urdf, _ = sources(parts, 3)
    with pytest.raises(ModelError, match=words) as caught:
        machine_of(urdf, 3)
    assert caught.value.evidence["key"] == f"joint {joint} axis"
