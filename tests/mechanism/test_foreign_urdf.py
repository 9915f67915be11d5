"""URDFs as other programs and people write them: read as they are meant, or refused in a sentence.

The texts are those of public files and threads, cut down to what made them fail.
"""

from __future__ import annotations

import codecs
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_machines import hinge, link, slide, sources

from nipper_pin import Case, ModelError, Window, load, simulate
from nipper_pin.mechanism import Mechanism, from_sources
from nipper_pin.mechanism.files.xml_text import encoding_of

NO_INERTIA = 'ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"'
LIMIT = '<limit lower="-10" upper="10" effort="1e5" velocity="1e3"/>'
A_LIMIT = f'<axis xyz="0 -1 0"/>{LIMIT}</joint>'
BOX = '<visual><geometry><box size="0.1 0.1 0.1"/></geometry>{}</visual></link>'
CRANK = (
    '<link name="crank"><inertial><origin xyz="0.015 0 0.02"/><mass value="0.2"/>'
    '<inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>'
)
ROBOT = '<robot name="bar">'
FOUR_BAR = f"""<?xml version="1.0"?>
{ROBOT}
<link name="frame"/>{CRANK}<link name="coupler_end"/><link name="rocker_end"/>
{link("coupler", 0.3, 3e-4, (0.05, 0.025))}{link("rocker", 0.25, 2e-4, (0.005, 0.045))}
<joint name="O" type="continuous"><parent link="frame"/><child link="crank"/><axis xyz="0 -1 0"/>
</joint><joint name="A" type="revolute"><parent link="crank"/><child link="coupler"/>
<origin xyz="0.03 0 0.04"/>{A_LIMIT}
<joint name="Bc" type="fixed"><parent link="coupler"/><child link="coupler_end"/>
<origin xyz="0.1 0 0.05"/></joint>
<joint name="C" type="continuous"><parent link="frame"/><child link="rocker"/>
<origin xyz="0.12 0 0"/><axis xyz="0 -1 0"/></joint>
<joint name="Br" type="fixed"><parent link="rocker"/><child link="rocker_end"/>
<origin xyz="0.01 0 0.09"/></joint></robot>
"""
DOCUMENT = """
format = 1
title = "K\u00fcrbel"
degrees_of_freedom = 1
gravity_m_s2 = 9.81
initial_phase = 1
cylinder = { rated_speed_rpm = 120, direction = "counter-clockwise", angle_at_touch_deg = 53.0, \
reference_index = 24.0, reference_angle_deg = 90.0 }
phases = [{ number = 1, name = "run", closed = [] }]
drives.crank = { joint = "O", law = "constant_speed", ratio = 1.0 }
closures.B = { frame_a = "coupler_end", frame_b = "rocker_end" }
"""

# What to replace in the file, and by what: the same machine.
READ_ALIKE = {
    "no limit": (A_LIMIT, '<axis xyz="0 -1 0"/></joint>'),
    "limit without effort": (LIMIT, '<limit lower="-10" upper="10"/>'),
    "limit in words": (LIMIT, '<limit lower="-pi" upper="pi" effort="1" velocity="1"/>'),
    "effort inf": (LIMIT, '<limit lower="-1" upper="1" effort="inf" velocity="nan"/>'),
    "safety": (LIMIT, f'{LIMIT}<safety_controller k_velocity="x"/><calibration/>'),
    "empty dynamics": (LIMIT, f"{LIMIT}<dynamics/>"),
    "version": (ROBOT, '<robot name="bar" version="9.x">'),
    "no name": (ROBOT, "<robot>"),
    "material without a name": (
        f"{CRANK[:-7]}</link>",
        CRANK[:-7] + BOX.format('<material><color rgba="255 0 0 255"/></material>'),
    ),
    "unknown material": (CRANK, CRANK[:-7] + BOX.format('<material name="rust"/>')),
    "other programs": (
        "</robot>",
        '<gazebo><color/><joint name="x" type="revolute"><axis xyz="1"/></joint></gazebo>'
        '<transmission name="t"/></robot>',
    ),
    "namespace": (ROBOT, '<robot name="bar" xmlns="http://example.org/x">'),
    "a frame with a mass": (
        '<link name="coupler_end"/>',
        f'<link name="coupler_end"><inertial><mass value="0"/><inertia {NO_INERTIA}/></inertial>'
        "</link>",
    ),
    "a frame without mass at rest": (
        '<link name="frame"/>',
        '<link name="frame"><inertial><mass value="0"/><inertia ixx="1" iyy="-1"/></inertial>'
        "</link>",
    ),
    "a frame without anything": ('<link name="frame"/>', '<link name="frame"><inertial/></link>'),
    "rounded half turns": (
        '<origin xyz="0.12 0 0"/><axis xyz="0 -1 0"/>',
        '<origin xyz="0.12 0 0" rpy="6.2832 0 0"/><axis xyz="0 -1 0.0005"/>',
    ),
}


@pytest.fixture
def written(tmp_path: Path) -> Callable[..., Path]:
    """Write the four-bar with a text replaced, in an encoding."""

    def write(old: str = "", new: str = "", encoding: str = "utf-8", urdf: str = FOUR_BAR) -> Path:
        folder = tmp_path / "bar"
        folder.mkdir(exist_ok=True)
        assert old in urdf
        (folder / "bar.urdf").write_bytes(urdf.replace(old, new).encode(encoding))
        (folder / "bar.toml").write_text(DOCUMENT, encoding="utf-8")
        return folder

    return write


def motion(mechanism: Mechanism) -> Any:
    found = simulate(mechanism, Case(speed_rpm=120.0, window=Window.CYCLE))
    return found.trajectory.evaluate(np.linspace(0.0, 0.4, 9)).q


@pytest.mark.parametrize("name", READ_ALIKE)
def test_what_does_not_matter_is_not_minded(
    written: Callable[..., Path], name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    plain = motion(load(written()))
    found = load(written(*READ_ALIKE[name]))
    assert capfd.readouterr() == ("", "")
    # Axes of few digits are put into the plane; nothing else changes anything.
    np.testing.assert_allclose(motion(found), plain, rtol=0.0, atol=1e-10)
    assert found.side_view == ("" if "round" not in name else found.side_view)


GREATER = FOUR_BAR.replace(ROBOT, f"<!-- Kr\u00fcbel gr\u00f6\u00dfer -->{ROBOT}")


@pytest.mark.parametrize(
    ("declared", "encoding"),
    [
        ("", "utf-8"), ("", "utf-8-sig"), ("UTF-8", "utf-8"), ("ISO-8859-1", "latin-1"),
        ("windows-1252", "cp1252"), ("UTF-16", "utf-16"), ("utf-16", "utf-16-le"),
        ("utf-16", "utf-16-be"), ("", "utf-16"), ("us-ascii", "utf-8-sig"),
    ],
)  # fmt: skip
def test_encodings_are_those_of_the_file(
    written: Callable[..., Path], declared: str, encoding: str
) -> None:
    """By the mark at its start, or what its first line declares."""
    head = f'<?xml version="1.0" encoding="{declared}"?>' if declared else '<?xml version="1.0"?>'
    text = GREATER.replace('<?xml version="1.0"?>', head).replace("\n", "\r\n")
    found = load(written(urdf=text, encoding=encoding))
    assert "gr\u00f6\u00dfer" in found.urdf
    # It is written in UTF-8 into runs and other models.
    assert encoding_of(found.urdf.encode()).lower() == "utf-8"
    np.testing.assert_array_equal(motion(found), motion(load(written())))


def test_marks_at_the_start_of_the_other_files(written: Callable[..., Path]) -> None:
    """Of the TOML and of a table; lines may end as on any system."""
    folder = written()
    toml, table = folder / "bar.toml", folder / "spring.csv"
    text = DOCUMENT + '[springs.coil]\njoint = "C"\nfile = "spring.csv"\n'
    toml.write_bytes(codecs.BOM_UTF8 + text.replace("\n", "\r\n").encode())
    table.write_bytes(codecs.BOM_UTF8 + b"coordinate_deg,torque_N_m\r\n-90,-1\r\n90,1\r\n")
    found = load(folder)
    assert found.title == "K\u00fcrbel"
    assert len(found.tabulated_springs) == 1


def test_a_urdf_of_many_attributes_is_read_at_once(written: Callable[..., Path]) -> None:
    """Reading takes time in proportion to the text; one parser takes twelve seconds for this."""
    many = " ".join(f'a{number}="{number}"' for number in range(30000))
    found = load(written(ROBOT, f'<robot name="bar" {many}>'))
    assert len(found.joints) == 3


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


def test_a_slide_whose_mass_is_beside_the_plane() -> None:
    """A chute on a base without mass, its centre a metre off the plane: it falls freely."""
    urdf = (
        f'<robot name="u"><link name="base"><inertial><mass value="0"/><inertia {NO_INERTIA}/>'
        '</inertial></link><link name="ch"><inertial><origin xyz="0 1 -1"/><mass value="10"/>'
        '<inertia ixx="1" iyy="1" izz="1"/></inertial></link><joint name="j" type="prismatic">'
        '<origin xyz="0 0 1"/><axis xyz="0 0 1"/><limit lower="-0.1" upper="0.2"/>'
        '<parent link="base"/><child link="ch"/></joint></robot>'
    )
    times = np.linspace(0.0, 0.99, 5)
    found = followed(machine_of(urdf, 1), times)[:, 0]
    np.testing.assert_allclose(found, -0.5 * 9.81 * times**2, rtol=1e-12, atol=1e-15)


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
