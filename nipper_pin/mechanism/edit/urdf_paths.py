"""Single values of a URDF by paths of its elements and attributes.

``urdf.<element>.<name>.<element>...<attribute>`` follows the elements of the file; an element that
can occur more than once is followed by its name, and an attribute of several numbers by x, y, z or
a place in brackets::

    urdf.joint.jaw.origin.xyz.x
    urdf.link.rocker.inertial.inertia.iyy
    urdf.link.rocker.collision.rocker_hub_left.geometry.cylinder.radius
    urdf.link.rocker.collision.rocker_arm_left.geometry.box.size[2]

A shape without a name goes by its place among its kind, ``collision[0]``. A placement that is not
written is one of zeros. Units are those of a URDF: m, rad, kg, kg m2.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from ...errors import ModelError, UnknownNameError
from ...given import read_number

_AXES = {"x": 0, "y": 1, "z": 2}
_ANGLES = {"r": 0, "p": 1, "y": 2}
_PLACED = ("joint", "inertial", "visual", "collision")
_STEP = re.compile(r"[^.\[\]]+|\[[0-9]+\]")


def steps_of(path: str) -> list[str]:
    """Steps of a dotted path; an index of a list is a separate step, such as ``[0]``."""
    return _STEP.findall(path)


@dataclass(frozen=True)
class UrdfValue:
    """One number of a URDF.

    Attributes:
        element: Element that holds it.
        attribute: Attribute that holds it.
        place: Place in an attribute of several numbers; None if it is the only one.
    """

    element: ElementTree.Element
    attribute: str
    place: int | None

    def read(self, path: str, file: str) -> float:
        """Read the number.

        Raises:
            ModelError: There is no number.
        """
        text = self._parts()[self.place or 0]
        try:
            return read_number(text)
        except ValueError:
            raise ModelError(
                file=file, key=path, value=text, allowed="the path of a number"
            ) from None

    def write(self, value: float, path: str, file: str) -> None:
        """Write the number; the others of its attribute stay.

        Raises:
            ModelError: There was no number.
        """
        self.read(path, file)
        parts = self._parts()
        parts[self.place or 0] = repr(float(value))
        self.element.set(self.attribute, " ".join(parts))

    def _parts(self) -> list[str]:
        return self.element.get(self.attribute, "").split() or [""]


def find_value(root: ElementTree.Element, path: str) -> UrdfValue:
    """Follow a path into a URDF.

    Args:
        path: The path; its first step is ``urdf``.

    Raises:
        UnknownNameError: The path leads nowhere, or stops before a number.
    """
    where = f"path {path}"
    element, rest = root, steps_of(path)[1:]
    while rest:
        _write_out(element, rest[0])
        if rest[0] in element.attrib:
            break
        element, rest = _child(element, rest, where)
    if not rest:
        known = [*_inside(element), *element.attrib]
        raise UnknownNameError(kind="value", name=path, known=known, where=where)
    attribute, *rest = rest
    count = len(element.get(attribute, "").split())
    if not rest and count == 1:
        return UrdfValue(element, attribute, None)
    places = {f"[{place}]": place for place in range(count)}
    if count == 3:
        places |= _ANGLES if attribute == "rpy" else _AXES
    if count < 2 or len(rest) != 1 or rest[0] not in places:
        name = ".".join(rest)
        raise UnknownNameError(
            kind="place", name=name, known=places if count > 1 else (), where=where
        )
    return UrdfValue(element, attribute, places[rest[0]])


def _write_out(element: ElementTree.Element, step: str) -> None:
    """Write the default placement that the file omits."""
    if step == "origin" and element.tag in _PLACED and element.find(step) is None:
        ElementTree.SubElement(element, step)
    elif element.tag == "origin" and step in ("xyz", "rpy") and step not in element.attrib:
        element.set(step, "0 0 0")


def _child(
    element: ElementTree.Element, steps: Sequence[str], where: str
) -> tuple[ElementTree.Element, list[str]]:
    """One element down: by its tag, and by name or place where there can be several."""
    tag, *rest = steps
    found = element.findall(tag) if tag.isidentifier() else []
    if not found:
        known = [*_inside(element), *element.attrib]
        raise UnknownNameError(kind="element or attribute", name=tag, known=known, where=where)
    if len(found) == 1 and found[0].get("name") is None and rest[:1] != ["[0]"]:
        return found[0], rest
    named = {item.get("name", f"[{place}]"): item for place, item in enumerate(found)}
    # A name may hold a dot, so the longest one that fits counts.
    for count in range(len(rest), 0, -1):
        name = ".".join(rest[:count])
        if name in named:
            return named[name], rest[count:]
    name = rest[0] if rest else ""
    raise UnknownNameError(kind=tag, name=name, known=named, where=where)


def _inside(element: ElementTree.Element) -> list[str]:
    """Tags of the elements inside an element."""
    return list(dict.fromkeys(item.tag for item in element if isinstance(item.tag, str)))
