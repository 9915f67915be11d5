"""Shapes of a URDF as Pinocchio reads them: points in the world; a machine with all kinds."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import coal
import numpy as np
import pinocchio as pin
import trimesh
from judge import Judge, press
from small_machines import SHAFT, hinge, link
from three_js import ball, box, ring

from nipper_pin import Mechanism
from nipper_pin.mechanism import from_sources

Array = Any

SHAPES = {
    "frame": [
        ("wall", '<box size="0.5 0.02 0.3"/>', "0.1 0.2 -0.3", "0 0.3 0", "0.2 0.4 0.8"),
        ("cylinder_drum", '<box size="0.1 0.2 0.05"/>', "0.05 0 -0.4", "0 0.1 0", "0.4 0.4 0"),
    ],
    "arm": [("bar", '<box size="0.2 0.02 0.03"/>', "-0.1 0 0", "0 0 0", "0.3 0.3 0.6")],
    "sled": [
        ("bed", '<box size="0.3 0.1 0.04"/>', "0.05 0.01 -0.02", "0 0.2 0", "0.9 0.5 0.1"),
        ("horn", '<mesh filename="horn.stl" scale="-1 2 0.5"/>', ".02 0 .05", ".7 -.4 .5", "1 0 0"),
    ],
    "flap": [("rod", '<cylinder radius="0.01" length="0.4"/>', "0.2 0 0.03", "0 1.4 0", "0 1 0")],
    "ball": [("head", '<sphere radius="0.03"/>', "0.01 -0.05 0.02", "0 0 0", "0 0.5 1")],
}  # fmt: skip


def shaped(folder: Path) -> Mechanism:
    """A machine with a shape of each kind, all turned and beside their links; one is mirrored."""
    corners = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.03, 0], [0.02, 0.01, 0.2]])
    faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]
    trimesh.Trimesh(corners, faces).export(folder / "horn.stl")
    plain = press()
    guide = {
        "joint": "arm_pin", "law": "oscillating_guide", "crank_radius_mm": 30.0,
        "crank_axis_mm": [40.0, -350.0], "guide_axis_mm": [300.0, -300.0], **SHAFT,
    }  # fmt: skip
    document: Any = {
        **plain.description,
        "degrees_of_freedom": 4,
        "drives": {**plain.description["drives"], "arm": guide},  # type: ignore[dict-item]
    }
    arm = link("arm") + hinge("arm_pin", "frame", "arm", (0.3, -0.3))
    robot = ElementTree.fromstring(plain.urdf.replace("</robot>", f"{arm}</robot>"))
    for item in robot.findall("link"):
        for name, shape, xyz, rpy, rgb in SHAPES[str(item.get("name"))]:
            text = (
                f'<visual name="{name}"><origin xyz="{xyz}" rpy="{rpy}"/><geometry>{shape}'
                f'</geometry><material name="m"><color rgba="{rgb} 1"/></material></visual>'
            )
            item.append(ElementTree.fromstring(text))
    urdf = ElementTree.tostring(robot, encoding="unicode")
    return from_sources("small", urdf, document, str(folder))


@dataclass(frozen=True)
class Wanted:
    """A shape of the URDF.

    Attributes:
        path: Its node in the page.
        points: Points whose convex hull it is, in the world by configuration and cylinder angle.
        rgb: Its colour, 0 to 255; None where the URDF has none.
        mesh: True if its own corners are the points.
    """

    path: str
    points: Callable[[Array, float], Array]
    rgb: tuple[int, ...] | None
    mesh: bool


def shapes(judge: Judge) -> list[Wanted]:
    """All shapes as Pinocchio reads them."""
    mechanism = judge.run.mechanism
    robot = ElementTree.fromstring(mechanism.urdf)
    drawn = robot.find(".//visual") is not None
    tag, kind = ("visual", pin.VISUAL) if drawn else ("collision", pin.COLLISION)
    geometry = pin.buildGeomFromUrdfString(
        judge.model, mechanism.urdf, kind, package_dirs=[mechanism.mesh_folder or "."]
    )
    # Pinocchio knows a shape by its link and its number there.
    names = {}
    for item in robot.findall("link"):
        for place, element in enumerate(item.findall(tag)):
            names[f"{item.get('name')}_{place}"] = (str(item.get("name")), element)
    found = []
    for item in geometry.geometryObjects:
        owner, element = names[item.name]
        name = element.get("name") or item.name
        body = body_of(judge, robot, owner)
        turns = body == "frame" and name.startswith("cylinder_") and bool(crank(judge))
        path = f"/nipper/{'cylinder' if turns else body}/{name}"
        colour = element.find("material/color")
        rgb = None
        if colour is not None:
            parts = str(colour.get("rgba")).split()[:3]
            rgb = tuple(round(255.0 * float(part)) for part in parts)
        mesh = item.meshPath not in ("", "BOX", "CYLINDER", "SPHERE")
        found.append(Wanted(path, placed(judge, geometry, item, name, turns=turns), rgb, mesh))
    return found


def body_of(judge: Judge, robot: ElementTree.Element, owner: str) -> str:
    """The link that carries another one through fixed joints."""
    joints = {str(j.find("child").get("link")): j for j in robot.findall("joint")}  # type: ignore[union-attr]
    while owner in joints and joints[owner].get("name") not in judge.names:
        owner = str(joints[owner].find("parent").get("link"))  # type: ignore[union-attr]
    return owner if owner in joints else "frame"


def crank(judge: Judge) -> tuple[float, float] | None:
    """Axis of the cylinder by the document (x, z) [m]."""
    laws = [item for item in judge.document["drives"].values() if "crank_axis_mm" in item]
    return tuple(1e-3 * part for part in laws[0]["crank_axis_mm"]) if laws else None  # type: ignore[return-value]


def placed(
    judge: Judge, geometry: Any, item: Any, name: str, *, turns: bool
) -> Callable[[Array, float], Array]:
    """The function of ``Wanted.points``."""
    springs = [n for n in judge.document.get("springs", {}) if name.startswith(f"spring_{n}")]
    touch = math.radians(judge.document["cylinder"]["angle_at_touch_deg"])
    shape, data = item.geometry, geometry.createData()
    number = geometry.getGeometryId(item.name)
    if isinstance(shape, coal.Box):
        local = box(*(2.0 * shape.halfSide))
    elif isinstance(shape, coal.Sphere):
        local = ball(shape.radius)
    elif isinstance(shape, coal.Cylinder):
        half = np.array([0.0, 0.0, shape.halfLength])
        local = np.concatenate([ring(shape.radius) + half, ring(shape.radius) - half])
    else:
        local = np.asarray(trimesh.load_mesh(item.meshPath).vertices)

    def points(q: Array, psi: float) -> Array:
        size = np.array(item.meshScale) if len(item.meshScale) else np.ones(3)
        if isinstance(shape, coal.ShapeBase):
            size = np.ones(3)
        if springs:
            column = judge.names.index(judge.document["springs"][springs[0]]["joint"])
            size = size - [0.0, 0.0, q[column]]
        pin.updateGeometryPlacements(judge.model, judge.data, geometry, data, judge.full(q))
        place = data.oMg[number]
        found = (local * size) @ place.rotation.T + place.translation
        if turns:
            axis = np.array([crank(judge)[0], 0.0, crank(judge)[1]])  # type: ignore[index]
            c, s = math.cos(psi - touch), math.sin(psi - touch)
            found = (found - axis) @ np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]) + axis
        return found

    return points
