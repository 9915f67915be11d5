"""A drawing as it is read: its tables checked, its points found, its joints named."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from ...errors import InputError, ModelError, meant
from ..files.describe import converted, kind_of_entry, refuse_unusable
from ..files.description import Description
from ..files.other_units import in_known_units
from .layout import FRAME, MADE, BodyTable, DrawingTable, JointTable, PointTable, ShapeTable
from .places import Place, place
from .points import found_points

_WORD = re.compile(r"\w+(?:[.-]\w+)*")
# Most points, bodies and joints: each is compared with all others.
_MOST = 1000
_OWN = frozenset(DrawingTable.__struct_fields__)
_KEYS = {
    "pin": ("pin", "parent", "child"),
    "slide": ("slide", "parent", "child", "at", "along"),
    "slot": ("slot", "parent", "child", "at", "along"),
}
_GEARS = ("follows", "ratio", "lead_mm_per_turn")
_MAY_BE = {"pin": ("name", *_GEARS), "slide": _GEARS, "slot": ("block_mass_kg",)}
_TABLES = {"points": PointTable, "bodies": BodyTable, "joints": JointTable, "shapes": ShapeTable}


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
            self.refuse(key, name, error.message)

    def link(self, name: str, key: str) -> None:
        """Refuse a link that there is not.

        Raises:
            ModelError: There is none.
        """
        links = [FRAME, *self.table.bodies]
        if name not in links:
            self.refuse(key, name, f"{meant(name, links)}one of {', '.join(links)}")

    def middle(self, shape: ShapeTable) -> Place:
        """Where a shape is."""
        return place(self.points, shape.at) if isinstance(shape.at, str) else shape.at

    def refuse(self, key: str, value: object, allowed: str) -> NoReturn:
        """Refuse a value.

        Raises:
            ModelError: It cannot be used.
        """
        raise ModelError(file=self.file, key=key, value=value, allowed=allowed)


def read(document: Mapping[str, Any], name: str) -> Drawn:
    """Read the document of a drawing.

    Args:
        name: Name of the machine.

    Raises:
        ModelError: A value in it cannot be used.
    """
    file = f"{name}.toml"
    top = {*_OWN, *Description.__struct_fields__}
    document = in_known_units(document, file, top, _table_of)
    own = {key: value for key, value in document.items() if key in _OWN}
    for key in MADE:
        if key in document:
            allowed = "nothing: a drawing makes it, of its points, bodies, joints and shaft"
            raise ModelError(file=file, key=key, value=document[key], allowed=allowed)
    known = sorted(top - {*MADE})
    for key in document:
        if key not in top:
            allowed = f"unknown key; {meant(key, known)}known here: {', '.join(known)}"
            raise ModelError(file=file, key=key, value=document[key], allowed=allowed)
    refuse_unusable(own, "", file)
    table: DrawingTable = converted(own, DrawingTable, "", file)
    for key in _TABLES:
        if (count := len(getattr(table, key))) > _MOST:
            value = f"{count} entries"
            raise ModelError(file=file, key=key, value=value, allowed=f"at most {_MOST}")
    _need_words(table, file)
    joints = _named(table.joints, file)
    model = {key: value for key, value in document.items() if key not in _OWN}
    return Drawn(name, file, table, found_points(table.points, file), joints, model)


def _table_of(section: str, entry: Mapping[str, Any]) -> Any:
    return _TABLES.get(section) or kind_of_entry(section, entry)


def _need_words(table: DrawingTable, file: str) -> None:
    """Refuse names that are not one word: lists of points are split at spaces and strokes."""
    names = [(f"points.{name}", name) for name in table.points]
    names += [(f"bodies.{name}", name) for name in table.bodies]
    names += [(f"shapes.{name}", name) for name in table.shapes]
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
        if kind and wanted - given:
            allowed = f"a {kind} with {', '.join(sorted(wanted - given))} too"
        raise ModelError(file=file, key=key, value=", ".join(sorted(given)), allowed=allowed)
