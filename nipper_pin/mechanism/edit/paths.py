"""Single values of both texts of a model by their paths.

In the TOML document: ``stops.jaw.restitution``, ``drives.pendulum.crank_axis_mm[0]``,
``springs.steeve.force_N[12]``. A place in a list or a column of a table is counted from 0, whether
the table was written out or came from a CSV file. Numbers of a drive, a stop or a start that need
not be written have their paths, too.

``urdf.<element>.<name>.<element>...<attribute>`` follows the elements of the URDF; an element that
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

import numbers
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

from ...errors import ModelError, UnknownNameError
from ...given import read_number
from ...written_units import known_key, number_in, unit_of_key
from ..files.describe import optional_numbers

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
        place: Place in an attribute of several numbers; None if it is the only one.
    """

    element: ElementTree.Element
    attribute: str
    place: int | None

    def read(self, path: str, file: str) -> float:
        """Read the number."""
        text = self._parts()[self.place or 0]
        try:
            return read_number(text)
        except ValueError:
            raise ModelError(
                file=file, key=path, value=text, allowed="the path of a number"
            ) from None

    def write(self, value: float, path: str, file: str) -> None:
        """Write the number; the others of its attribute stay."""
        self.read(path, file)
        parts = self._parts()
        parts[self.place or 0] = repr(float(value))
        self.element.set(self.attribute, " ".join(parts))

    def _parts(self) -> list[str]:
        return self.element.get(self.attribute, "").split() or [""]


def find_value(root: ElementTree.Element, path: str) -> UrdfValue:
    """Follow a path into a URDF."""
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


UNWRITTEN = {"simultaneous": "newton"}
"""Texts at the top of a document that need not be written, and what they are then."""

_OPTIONAL = ("drives", "stops", "initial")


def number_at(document: Mapping[str, object], path: str, file: str) -> float:
    """Number at a path of a TOML document whose tables are written out.

    Raises:
        UnknownNameError: The path leads nowhere.
        ModelError: There is no number.
    """
    path, factor = in_unit_of(document, path)
    steps, where = steps_of(path), f"path {path}"
    value = _value(_holder(document, steps, path, where), steps, where)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ModelError(file=file, key=path, value=value, allowed="the path of one number")
    return float(value) / factor


def in_unit_of(document: object, path: str) -> tuple[str, float]:
    """A path with the key that the document has, and the factor into the unit of that.

    ``springs.rod.stiffness_N_per_mm`` is the number under ``stiffness_N_per_m``, by 1000.
    """
    steps = steps_of(path)
    holder = document
    for step in steps[:-1]:
        holder = holder.get(step) if isinstance(holder, Mapping) else None
    if not isinstance(holder, Mapping) or not steps or steps[-1] in holder:
        return path, 1.0
    key, factor = known_key(steps[-1], [*holder, *_unwritten(holder, steps)]) or (steps[-1], 1.0)
    return path.removesuffix(steps[-1]) + key, factor


def replace_value(document: dict[str, object], path: str, value: object, file: str) -> None:
    """Replace a value in place, in a document whose tables are written out.

    Args:
        value: The new value; a string is converted to the type of the value that it replaces.

    Raises:
        UnknownNameError: The path leads nowhere, or to a whole table.
        ModelError: The string cannot be converted.
    """
    steps, where = steps_of(path), f"override {path}"
    if _unwritten_start(document, steps):
        starts = document.setdefault("initial", {})
        starts[steps[1]] = {}  # type: ignore[index]
    holder: Any = _holder(document, steps, path, where)
    old = UNWRITTEN.get(path) or _value(holder, steps, where)
    if isinstance(old, dict):
        known = (f"{path}.{key}" for key in old)
        raise UnknownNameError(kind="value", name=path, known=known, where=where)
    key = int(steps[-1][1:-1]) if isinstance(holder, list) else steps[-1]
    holder[key] = _convert(value, old, path, file)


def number_from(value: object, path: str, file: str) -> float:
    """Convert a new value to a number in the unit of its path.

    Args:
        value: A number, or a string that holds one, with a unit of its own or without.
    """
    if isinstance(value, bool) or not isinstance(value, numbers.Real | str):
        raise ModelError(file=file, key=path, value=value, allowed="a number")
    if not isinstance(value, str):
        return float(value)
    key = next((step for step in reversed(steps_of(path)) if not step.startswith("[")), "")
    try:
        return number_in(value, unit_of_key(key))
    except ValueError as error:
        raise ModelError(file=file, key=path, value=value, allowed=str(error)) from None


def _holder(document: object, steps: Sequence[str], path: str, where: str) -> object:
    """Return the table or list that holds the last step of a path."""
    if not steps:
        known = document if isinstance(document, Mapping) else ()
        raise UnknownNameError(kind="key", name=path, known=known, where=where)
    if _unwritten_start(document, steps):
        return {}
    for depth in range(1, len(steps)):
        document = _item(document, steps[:depth], where)
    return document


def _unwritten_start(document: object, steps: Sequence[str]) -> bool:
    """True for the path of a joint's start in a document that gives that joint none."""
    if not (len(steps) == 3 and steps[0] == "initial" and isinstance(document, Mapping)):
        return False
    starts = document.get("initial", {})
    return isinstance(starts, Mapping) and steps[1] not in starts


def _item(holder: object, steps: Sequence[str], where: str) -> object:
    """The last step of a path, from what holds it."""
    step = steps[-1]
    if isinstance(holder, Mapping):
        if step in holder:
            return holder[step]
        known = [*holder, *_unwritten(holder, steps)]
        raise UnknownNameError(kind="key", name=step, known=known, where=where)
    if isinstance(holder, list | tuple):
        # A path writes its places in one way: [3], not [03].
        place = int(step[1:-1]) if step.startswith("[") else -1
        if 0 <= place < len(holder) and step == f"[{place}]":
            return holder[place]
        known = [f"[0] to [{len(holder) - 1}]"] if holder else []
        raise UnknownNameError(kind="place", name=step, known=known, where=where)
    raise UnknownNameError(kind="key", name=step, known=(), where=where)


def _value(holder: object, steps: Sequence[str], where: str) -> object:
    """What the last step of a path leads to, be it written or not."""
    value = _unwritten(holder, steps).get(steps[-1])
    return _item(holder, steps, where) if value is None else value


def _unwritten(holder: object, steps: Sequence[str]) -> dict[str, float]:
    """Defaults of omitted numbers of the table that holds the last step."""
    if len(steps) == 3 and steps[0] in _OPTIONAL and isinstance(holder, Mapping):
        return optional_numbers(steps[0], holder)
    return {}


def _convert(value: object, old: object, path: str, file: str) -> object:
    """Convert a string to the type of the value that it replaces, a foreign number to Python's."""
    # Only plain Python numbers are validated and saved, not those of numpy.
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        value = int(value)
    elif isinstance(value, numbers.Real) and not isinstance(value, bool):
        value = float(value)
    if not isinstance(value, str) or isinstance(old, str):
        return list(value) if isinstance(value, tuple) else value
    if isinstance(old, int | float) and not isinstance(old, bool):
        number = number_from(value, path, file)
        return int(number) if isinstance(old, int) and number.is_integer() else number
    try:
        return tomllib.loads(f"value = {value}")["value"]
    except (ValueError, RecursionError):
        allowed = f"a value like {old!r}"
        raise ModelError(file=file, key=path, value=value, allowed=allowed) from None
