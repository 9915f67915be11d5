"""Joints of a URDF in the plane of the machine, to the last bit; and joints that are none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from small_machines import SHAFT, hinge, link, machine

from nipper_pin.mechanism.files import urdf, urdf_parts

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
