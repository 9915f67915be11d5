"""Reading and checking a URDF: its links, joints and shapes, turned into the side view."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

import numpy as np

from ...errors import ModelError, looked_up
from .toml_text import NAMES, is_name
from .urdf_parts import Plane, Urdf, UrdfJoint, UrdfLink, in_side_view
from .urdf_shapes import check_colours, read_shapes
from .urdf_values import check_limits, finite, placement, read_damping, read_inertial

# Parsers of URDF call themselves for each joint in a row.
_DEEPEST = 500
# Checks of closures solve dense equations in the coordinates of joints that move.
_MOST_LINKS, _MOST_MOVING, _MOST_SHAPES = 2000, 500, 2000
_KINDS: dict[str, Literal["revolute", "prismatic", "fixed"]] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}


def check_urdf(root: ElementTree.Element, file: str, mesh_folder: Path) -> Urdf:
    """Read a URDF, check it, and turn it into the side view."""
    elements = _by_name(root.findall("link"), file)
    _check_count(len(elements), _MOST_LINKS, "links", file)
    named = _by_name(root.findall("joint"), file)
    joints = {name: _read_joint(name, item, elements, file) for name, item in named.items()}
    top = _check_tree(elements, joints, file)
    count = sum(joint.kind != "fixed" for joint in joints.values())
    _check_count(count, _MOST_MOVING, "joints that move", file)
    if not count:
        allowed = "a joint that moves: revolute, continuous or prismatic"
        raise ModelError(file=file, key="joints that move", value=0, allowed=allowed)
    _check_mimics(joints, file)
    still = _welded_to(top, joints)
    links = {
        name: UrdfLink(
            inertia=read_inertial(link, name, name not in still, file),
            shapes=read_shapes(link, name, file, mesh_folder),
        )
        for name, link in elements.items()
    }
    found = Urdf(root=top, links=links, joints=joints, plane=Plane(np.eye(3)), own_axes={})
    _check_count(sum(map(len, found.shapes.values())), _MOST_SHAPES, "collision shapes", file)
    _check_shape_names(found.shapes, file)
    check_colours(root, file)
    return in_side_view(found, file)


def _check_count(count: int, most: int, what: str, file: str) -> None:
    """Refuse more parts than can be checked while somebody waits."""
    if count > most:
        raise ModelError(file=file, key=what, value=count, allowed=f"at most {most}")


def _by_name(elements: list[ElementTree.Element], file: str) -> dict[str, ElementTree.Element]:
    """Elements by their names, each of which has one of its own."""
    found: dict[str, ElementTree.Element] = {}
    for element in elements:
        name, allowed = element.get("name"), NAMES
        if name in found:
            allowed = f"each {element.tag} needs a name of its own"
        if name is None or name in found or not is_name(name):
            raise ModelError(file=file, key=f"<{element.tag}> name", value=name, allowed=allowed)
        found[name] = element
    return found


def _read_joint(
    name: str, element: ElementTree.Element, links: Mapping[str, object], file: str
) -> UrdfJoint:
    """Read type, links, placement and axis of a joint."""
    key = f"joint {name}"
    kind = element.get("type", "")
    if kind not in _KINDS:
        allowed = f"a planar mechanism has joints of type {', '.join(_KINDS)}"
        raise ModelError(file=file, key=f"{key} type", value=kind, allowed=allowed)
    ends = []
    for side in ("parent", "child"):
        end = element.find(side)
        link = end.get("link", "") if end is not None else ""
        looked_up("link", link, links, f"{file}: {key} {side}")
        ends.append(link)
    axis, written = _read_axis(element, _KINDS[kind], key, file)
    check_limits(element, "m" if kind == "prismatic" else "rad", key, file)
    return UrdfJoint(
        name=name,
        kind=_KINDS[kind],
        parent=ends[0],
        child=ends[1],
        placement=placement(element, key, file),
        axis=axis,
        damping=read_damping(element, key, file),
        mimic=_read_mimic(element, key, file),
        written=written,
    )


def _read_axis(
    element: ElementTree.Element, kind: str, key: str, file: str
) -> tuple[tuple[float, float, float], object]:
    """Axis of a joint, of any length, and how the file has it; zero of a fixed joint."""
    axis, value = element.find("axis"), [1.0, 0.0, 0.0]
    if axis is not None:
        value = finite(axis, "xyz", 3, "1 0 0", f"{key} axis", file)
    if kind == "fixed":
        return (0.0, 0.0, 0.0), None
    if not any(value):
        allowed = "an axis has a direction"
        raise ModelError(file=file, key=f"{key} axis", value=value, allowed=allowed)
    x, y, z = value
    return (x, y, z), "none, which means 1 0 0" if axis is None else value


def _read_mimic(element: ElementTree.Element, key: str, file: str) -> tuple[str, float] | None:
    """The joint that a joint follows, and by which multiple."""
    mimic = element.find("mimic")
    if mimic is None:
        return None
    (multiplier,) = finite(mimic, "multiplier", 1, "1", f"{key} mimic multiplier", file)
    (offset,) = finite(mimic, "offset", 1, "0", f"{key} mimic offset", file)
    if not multiplier:
        allowed = "a multiplier other than 0; a joint that stays is fixed"
        raise ModelError(
            file=file, key=f"{key} mimic multiplier", value=multiplier, allowed=allowed
        )
    if offset:
        allowed = (
            "0: all coordinates are zero in the touch configuration; let the origin of the joint "
            "hold the offset"
        )
        raise ModelError(file=file, key=f"{key} mimic offset", value=offset, allowed=allowed)
    return mimic.get("joint", ""), multiplier


def _check_mimics(joints: Mapping[str, UrdfJoint], file: str) -> None:
    """A joint that moves may follow another one that moves."""
    moving = {name: joint for name, joint in joints.items() if joint.kind != "fixed"}
    for joint in joints.values():
        if joint.mimic is None:
            continue
        others = {name: item for name, item in moving.items() if item is not joint}
        if joint.kind == "fixed":
            allowed = "a joint that moves, if it is to follow another"
            raise ModelError(
                file=file, key=f"joint {joint.name} type", value="fixed", allowed=allowed
            )
        where = f"{file}: joint {joint.name} mimic"
        looked_up("other joint that moves", joint.mimic[0], others, where)


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


def _welded_to(top: str, joints: Mapping[str, UrdfJoint]) -> set[str]:
    """The root link and all links that no joint moves."""
    still, fixed = {top}, [joint for joint in joints.values() if joint.kind == "fixed"]
    while more := {joint.child for joint in fixed if joint.parent in still} - still:
        still |= more
    return still


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
