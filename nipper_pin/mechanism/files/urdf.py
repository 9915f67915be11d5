"""Reading and checking a URDF before Pinocchio sees it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import numpy as np

from ...errors import ModelError, UnknownNameError
from ...texts import MOST_TEXT
from ...tolerances.mechanics import URDF_TOLERANCE
from .toml_text import NAMES, is_name
from .urdf_values import (
    check_colours,
    check_dynamics,
    check_inertial,
    check_shapes,
    numbers,
    origin,
    rotation_from_rpy,
)

# Parsers of URDF call themselves for each joint in a row.
_DEEPEST = 500
# Checks of closures solve dense equations in the coordinates of joints that move.
_MOST_LINKS, _MOST_MOVING, _MOST_SHAPES = 2000, 500, 2000
HINGE_AXIS = (0.0, -1.0, 0.0)
_KINDS: dict[str, Literal["revolute", "prismatic", "fixed"]] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}


@dataclass(frozen=True, kw_only=True)
class UrdfJoint:
    """One joint of the URDF.

    Attributes:
        name: Joint name.
        kind: "revolute", "prismatic" or "fixed".
        parent: Parent link.
        child: Child link.
        axis: Unit axis of rotation or translation in the joint frame; zero if fixed.
        damping: Of its <dynamics> [N s/m or N m s/rad].
    """

    name: str
    kind: Literal["revolute", "prismatic", "fixed"]
    parent: str
    child: str
    axis: tuple[float, float, float]
    damping: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Urdf:
    """A checked URDF.

    Attributes:
        root: Name of the root link.
        links: Names of all links.
        joints: All joints by name.
        shapes: Names of the collision elements of each link, in the order of the file; an element
            without a name is called ``<link>_<place>``.
        masses: Mass of each link [kg], zero without inertial.
    """

    root: str
    links: tuple[str, ...]
    joints: dict[str, UrdfJoint]
    shapes: dict[str, tuple[str, ...]]
    masses: dict[str, float]


def parse_xml(text: str, file: str) -> ElementTree.Element:
    """Parse URDF text, comments kept.

    Args:
        text: The URDF.
        file: File name, for messages.

    Raises:
        ModelError: The text is not well-formed XML or not a URDF.
    """
    if len(text) > MOST_TEXT:
        allowed = f"at most {MOST_TEXT} characters"
        raise ModelError(file=file, key="length", value=len(text), allowed=allowed)
    builder = ElementTree.TreeBuilder(insert_comments=True)
    try:
        root = ElementTree.fromstring(text, ElementTree.XMLParser(target=builder))
    except (ElementTree.ParseError, ValueError) as error:
        value = str(error)
        raise ModelError(
            file=file, key="XML", value=value, allowed="a URDF is well-formed XML"
        ) from error
    if root.tag != "robot":
        raise ModelError(
            file=file, key="root element", value=root.tag, allowed="a URDF starts with <robot>"
        )
    return root


def check_urdf(root: ElementTree.Element, file: str, mesh_folder: Path) -> Urdf:
    """Check a URDF for errors that Pinocchio would not report, or not clearly.

    Args:
        root: The ``robot`` element.
        file: File name, for messages.
        mesh_folder: Folder that mesh files must lie in.

    Returns:
        Links, joints and collision elements.

    Raises:
        ModelError: A value cannot belong to a planar mechanism.
        UnknownNameError: A joint names a link that does not exist.
    """
    links = {_name(item, file): item for item in _unique(root.findall("link"), file)}
    _check_count(len(links), _MOST_LINKS, "links", file)
    joints = {}
    for item in _unique(root.findall("joint"), file):
        joint = _check_joint(item, links, file)
        joints[joint.name] = joint
    top = _check_tree(links, joints, file)
    moving = {joint.child for joint in joints.values() if joint.kind != "fixed"}
    _check_count(len(moving), _MOST_MOVING, "joints that move", file)
    shapes, masses = {}, {}
    for name, link in links.items():
        masses[name] = check_inertial(link, name, name in moving, file)
        shapes[name] = check_shapes(link, name, file, mesh_folder)
    _check_count(sum(map(len, shapes.values())), _MOST_SHAPES, "collision shapes", file)
    _check_shape_names(shapes, file)
    check_colours(root, file)
    return Urdf(root=top, links=tuple(links), joints=joints, shapes=shapes, masses=masses)


def _check_count(count: int, most: int, what: str, file: str) -> None:
    """Refuse more parts than can be checked while somebody waits."""
    if count > most:
        raise ModelError(file=file, key=what, value=count, allowed=f"at most {most}")


def _name(element: ElementTree.Element, file: str) -> str:
    """Name of an element."""
    name = element.get("name")
    if name is None or not is_name(name):
        raise ModelError(file=file, key=f"<{element.tag}> name", value=name, allowed=NAMES)
    return name


def _unique(elements: list[ElementTree.Element], file: str) -> list[ElementTree.Element]:
    """Refuse two elements of one name."""
    seen: set[str] = set()
    for element in elements:
        name = _name(element, file)
        if name in seen:
            raise ModelError(
                file=file,
                key=f"<{element.tag}> name",
                value=name,
                allowed=f"each {element.tag} needs a name of its own",
            )
        seen.add(name)
    return elements


def _check_joint(element: ElementTree.Element, links: Iterable[str], file: str) -> UrdfJoint:
    """Check type, links, placement and axis of a joint."""
    name = _name(element, file)
    key = f"joint {name}"
    kind = element.get("type", "")
    if kind not in _KINDS:
        allowed = f"a planar mechanism has joints of type {', '.join(_KINDS)}"
        raise ModelError(file=file, key=f"{key} type", value=kind, allowed=allowed)
    ends = []
    for side in ("parent", "child"):
        end = element.find(side)
        link = end.get("link", "") if end is not None else ""
        if link not in links:
            raise UnknownNameError(
                kind="link", name=link, known=links, where=f"{file}: {key} {side}"
            )
        ends.append(link)
    _, rpy = origin(element, key, file)
    rotation = rotation_from_rpy(rpy)
    # The direction of y must be kept: a half turn about x keeps the plane but mirrors angles.
    if abs(rotation[1, 1] - 1.0) > URDF_TOLERANCE:
        raise ModelError(
            file=file,
            key=f"{key} origin rpy",
            value=rpy.tolist(),
            allowed="a rotation about y only, others leave the plane of the mechanism",
        )
    if element.find("mimic") is not None:
        raise ModelError(
            file=file,
            key=f"{key} mimic",
            value=element.find("mimic").attrib,  # type: ignore[union-attr]
            allowed="no mimic; gear pairs are drives with law = 'geared' in the TOML file",
        )
    axis = _check_axis(element, _KINDS[kind], key, file)
    return UrdfJoint(
        name=name,
        kind=_KINDS[kind],
        parent=ends[0],
        child=ends[1],
        axis=axis,
        damping=check_dynamics(element, key, file),
    )


def _check_axis(
    element: ElementTree.Element, kind: str, key: str, file: str
) -> tuple[float, float, float]:
    """A hinge turns about -y, a slider moves in the plane; return the unit axis, exactly so."""
    if kind == "fixed":
        return (0.0, 0.0, 0.0)
    axis = element.find("axis")
    value = np.array([1.0, 0.0, 0.0])
    if axis is not None:
        value = numbers(axis, "xyz", 3, "1 0 0", f"{key} axis", file)
    length = float(np.linalg.norm(value))
    allowed = ""
    if length == 0.0:
        allowed = "an axis has a direction"
    elif kind == "revolute" and np.abs(value / length - HINGE_AXIS).max() > URDF_TOLERANCE:
        allowed = "a hinge turns about 0 -1 0 (positive counter-clockwise in the side view)"
    elif kind == "prismatic" and abs(value[1]) / length > URDF_TOLERANCE:
        allowed = "a slider moves in the x-z plane, its axis has no y component"
    if allowed:
        raise ModelError(file=file, key=f"{key} axis", value=value.tolist(), allowed=allowed)
    if kind == "revolute":
        return HINGE_AXIS
    length = float(np.hypot(value[0], value[2]))
    return (float(value[0]) / length, 0.0, float(value[2]) / length)


def flatten(root: ElementTree.Element) -> bool:
    """Put the joints of a checked URDF exactly into the plane, in place; True if one was not.

    Programs write half a turn about y as three angles, of which one may be pi but for round-off, or
    angles of a few digits. A pin whose parts are not exactly parallel would pull across the plane.

    Args:
        root: The ``robot`` element.
    """
    changed = False
    for joint in root.findall("joint"):
        place, axis = joint.find("origin"), joint.find("axis")
        if place is not None:
            roll, pitch, yaw = (float(word) for word in place.get("rpy", "0 0 0").split())
            if roll or yaw:
                turn = rotation_from_rpy(np.array([roll, pitch, yaw]))
                place.set("rpy", f"0 {math.atan2(turn[0, 2], turn[0, 0])!r} 0")
                changed = True
        if axis is not None and joint.get("type") != "fixed":
            x, y, z = (float(word) for word in axis.get("xyz", "1 0 0").split())
            sliding = _KINDS[joint.get("type", "")] == "prismatic"
            if y if sliding else x or z:
                axis.set("xyz", f"{x!r} 0 {z!r}" if sliding else f"0 {y!r} 0")
                changed = True
    return changed


def _check_tree(links: Iterable[str], joints: dict[str, UrdfJoint], file: str) -> str:
    """Each link but one hangs from exactly one joint; return the one."""
    above: dict[str, str] = {}
    for joint in joints.values():
        if joint.child in above:
            raise ModelError(
                file=file,
                key=f"joint {joint.name} child",
                value=joint.child,
                allowed="each link hangs from one joint; [closures] in the TOML close loops",
            )
        above[joint.child] = joint.parent
    roots = [link for link in links if link not in above]
    if len(roots) != 1:
        allowed = "a URDF is one tree with exactly one root link"
        raise ModelError(file=file, key="root links", value=roots, allowed=allowed)
    for link in links:
        seen = {link}
        while link in above:
            link = above[link]
            if len(seen) > _DEEPEST:
                allowed = f"a tree of at most {_DEEPEST} joints in a row"
                raise ModelError(file=file, key="links", value=f"behind {link}", allowed=allowed)
            if link in seen:
                allowed = "links hang from the root; these hang from one another in a circle"
                raise ModelError(file=file, key="links", value=sorted(seen), allowed=allowed)
            seen.add(link)
    return roots[0]


def _check_shape_names(shapes: dict[str, tuple[str, ...]], file: str) -> None:
    """A contact names a link or a collision element, so these names must not clash."""
    seen: dict[str, str] = dict.fromkeys(shapes, "the link of that name")
    for link, names in shapes.items():
        for name in names:
            if name in seen and not (name == link and len(names) == 1):
                allowed = (
                    f"a collision element needs a name of its own; it clashes with {seen[name]}"
                )
                raise ModelError(
                    file=file, key=f"link {link} collision name", value=name, allowed=allowed
                )
            seen[name] = f"a collision element of link {link}"


def edit(text: str, change: Callable[[ElementTree.Element], None], file: str) -> str:
    """Apply a change to URDF text, comments kept.

    Args:
        text: The URDF.
        change: Called with the ``robot`` element.
        file: File name, for messages.
    """
    root = parse_xml(text, file)
    change(root)
    return ElementTree.tostring(root, encoding="unicode")
