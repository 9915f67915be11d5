"""A drawing as it is read: its tables checked, its points found, its joints named."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ...errors import InputError, ModelError, meant
from ..files.describe import converted, refuse_unusable
from .layout import FRAME, DrawingTable, JointTable
from .places import Place, place, vector
from .points import found_points

_WORD = re.compile(r"\w+(?:[.-]\w+)*")
# Most points, bodies and joints: each is compared with all others.
_MOST = 1000
_OWN = frozenset(DrawingTable.__struct_fields__)
# Of a model's file, these follow from the drawing.
_MADE = ("format", "degrees_of_freedom", "cylinder", "closures")
_KEYS = {
    "pin": ("pin", "parent", "child"),
    "slide": ("slide", "parent", "child", "at", "along"),
    "slot": ("slot", "parent", "child", "at", "along"),
}
_MAY_BE = {"pin": ("name",), "slide": (), "slot": ("block_mass_kg",)}


@dataclass(frozen=True)
class Drawn:
    """What a drawing says.

    Attributes:
        name: Name of the machine.
        file: Name of its file, for messages.
        table: Its own tables.
        points: Places by name [mm].
        joints: Its joints by name, in its order.
        model: The other tables, as a model's file has them.
    """

    name: str
    file: str
    table: DrawingTable
    points: Mapping[str, Place]
    joints: Mapping[str, JointTable]
    model: Mapping[str, Any]

    def place(self, name: str, key: str) -> Place:
        """A point that a key names.

        Raises:
            ModelError: There is no such point.
        """
        try:
            return place(self.points, name)
        except InputError as error:
            raise self.refused(key, name, error.message) from None

    def link(self, name: str, key: str) -> None:
        """Refuse a link that there is not.

        Raises:
            ModelError: There is none.
        """
        links = [FRAME, *self.table.bodies]
        if name not in links:
            raise self.refused(key, name, f"{meant(name, links)}one of {', '.join(links)}")

    def refused(self, key: str, value: object, allowed: str) -> ModelError:
        """The error of a value that cannot be used."""
        return ModelError(file=self.file, key=key, value=value, allowed=allowed)


def read(document: Mapping[str, Any], name: str) -> Drawn:
    """Read the document of a drawing.

    Args:
        name: Name of the machine.

    Raises:
        ModelError: A value in it cannot be used.
    """
    file = f"{name}.toml"
    own = {key: value for key, value in document.items() if key in _OWN}
    for key in _MADE:
        if key in document:
            allowed = "nothing: a drawing makes it, of its points, bodies, joints and shaft"
            raise ModelError(file=file, key=key, value=document[key], allowed=allowed)
    refuse_unusable(own, "", file)
    table: DrawingTable = converted(own, DrawingTable, "", file)
    for key in ("points", "bodies", "joints"):
        if (count := len(getattr(table, key))) > _MOST:
            value = f"{count} entries"
            raise ModelError(file=file, key=key, value=value, allowed=f"at most {_MOST}")
    _need_words(table, file)
    joints = _named(table.joints, file)
    model = {key: value for key, value in document.items() if key not in _OWN}
    drawn = Drawn(name, file, table, found_points(table.points, file), joints, model)
    _check_places(drawn)
    return drawn


def _need_words(table: DrawingTable, file: str) -> None:
    """Refuse names that are not one word: lists of points are split at spaces and strokes."""
    names = [(f"points.{name}", name) for name in table.points]
    names += [(f"bodies.{name}", name) for name in table.bodies]
    for number, joint in enumerate(table.joints):
        names += [
            (f"joints[{number}]", name or "_") for name in (joint.name, joint.slide, joint.slot)
        ]
    for key, name in names:
        if not _WORD.fullmatch(name):
            allowed = "one word of letters, digits and _, in which single - and dots may stand"
            raise ModelError(file=file, key=key, value=name, allowed=allowed)
    if FRAME in table.bodies:
        allowed = "another name: the frame is no moving body"
        raise ModelError(file=file, key="bodies", value=FRAME, allowed=allowed)


def _named(joints: tuple[JointTable, ...], file: str) -> dict[str, JointTable]:
    """Joints by name: a pin has that of its point, unless another one came before."""
    found: dict[str, JointTable] = {}
    for number, joint in enumerate(joints):
        _check_kind(joint, f"joints[{number}]", file)
        name = joint.name or joint.slide or joint.slot or joint.pin or ""
        if name == joint.pin and name in found and not joint.name:
            name = f"{joint.pin}_{joint.child}"
        if name in found:
            allowed = "a name of its own; another joint has this one"
            raise ModelError(file=file, key=f"joints[{number}]", value=name, allowed=allowed)
        found[name] = joint
    return found


def _check_kind(joint: JointTable, key: str, file: str) -> None:
    """Refuse keys that are not those of one kind of joint."""
    given = {item for item in joint.__struct_fields__ if getattr(joint, item) is not None}
    kind = next((kind for kind in _KEYS if kind in given), "")
    wanted, may_be = set(_KEYS.get(kind, ())), set(_MAY_BE.get(kind, ()))
    if not (kind and wanted <= given <= wanted | may_be):
        ways = "; ".join(", ".join(keys) for keys in _KEYS.values())
        allowed = f"the keys of one kind of joint: {ways}"
        raise ModelError(file=file, key=key, value=", ".join(sorted(given)), allowed=allowed)


def _check_places(drawn: Drawn) -> None:
    """Refuse bodies and joints at points, and joints on bodies, that there are not."""
    for key, name in _named_points(drawn.table):
        drawn.place(name, key)
    for name, body in drawn.table.bodies.items():
        if len(body.points.split()) == 1 and body.mass_kg is None:
            allowed = "a mass: a body with one point is a disc, which has no length to weigh"
            key = f"bodies.{name}.mass_kg"
            raise drawn.refused(key, None, allowed)
    for number, joint in enumerate(drawn.joints.values()):
        drawn.link(joint.parent, f"joints[{number}].parent")
        drawn.link(joint.child, f"joints[{number}].child")
        along = joint.along
        one = isinstance(along, str) and len(along.split()) != 2
        if along is not None and (one or not any(vector(drawn.points, along))):
            key = f"joints[{number}].along"
            raise drawn.refused(key, along, "a direction, or two points that are apart")


def _named_points(table: DrawingTable) -> Iterator[tuple[str, str]]:
    """Every point that bodies and joints name, after the key that names it."""
    for name, body in table.bodies.items():
        yield from ((f"bodies.{name}.points", point) for point in body.points.split())
    for number, joint in enumerate(table.joints):
        yield f"joints[{number}].{'pin' if joint.pin else 'at'}", joint.point
        if isinstance(joint.along, str):
            yield from ((f"joints[{number}].along", point) for point in joint.along.split())
