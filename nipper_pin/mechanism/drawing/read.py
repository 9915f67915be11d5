"""A drawing as it is read: tables checked, points found, joints named, and the tree they make.

A joint carries the first body that it leads to; joints that lead to a body which is carried close
loops.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

from ...errors import InputError, ModelError, meant
from ..files.describe import converted, in_known_units, kind_of_entry, refuse_unusable
from ..files.description import Description
from .layout import FRAME, MADE, BodyTable, DrawingTable, JointTable, PointTable, ShapeTable
from .mass import crosses, mass_of
from .points import Place, found_points, place, vector

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
        """A point that a key names."""
        try:
            return place(self.points, name)
        except InputError as error:
            self.refuse(key, name, error.message)

    def link(self, name: str, key: str) -> None:
        """Refuse a link that there is not."""
        links = [FRAME, *self.table.bodies]
        if name not in links:
            self.refuse(key, name, f"{meant(name, links)}one of {', '.join(links)}")

    def refuse(self, key: str, value: object, allowed: str) -> NoReturn:
        """Refuse a value."""
        raise ModelError(file=self.file, key=key, value=value, allowed=allowed)


def read(document: Mapping[str, Any], name: str) -> Drawn:
    """Read the document of a drawing."""
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
    sections = ("points", "bodies", "shapes")
    names = [(f"{key}.{name}", name) for key in sections for name in getattr(table, key)]
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


def check_parts(drawn: Drawn) -> None:
    """Refuse parts at points, and on bodies, that there are not, and bodies without a mass."""
    for key, name in _named_points(drawn.table):
        drawn.place(name, key)
    for name, body in drawn.table.bodies.items():
        _check_body(drawn, body, f"bodies.{name}")
    for name, shape in drawn.table.shapes.items():
        drawn.link(shape.body, f"shapes.{name}.body")
        if (shape.box_mm is None) == (shape.radius_mm is None):
            given = None if shape.box_mm is None else "box_mm and radius_mm"
            drawn.refuse(f"shapes.{name}", given, "one of box_mm and radius_mm")
    for number, joint in enumerate(drawn.joints.values()):
        drawn.link(joint.parent, f"joints[{number}].parent")
        drawn.link(joint.child, f"joints[{number}].child")
        along = joint.along
        one = isinstance(along, str) and len(along.split()) != 2
        if along is not None and (one or not any(vector(drawn.points, along))):
            drawn.refuse(
                f"joints[{number}].along", along, "a direction, or two points that are apart"
            )
        _check_gears(drawn, joint, f"joints[{number}]")


def _check_body(drawn: Drawn, body: BodyTable, key: str) -> None:
    """Refuse a body that has no mass, or numbers that make none."""
    flat = body.thickness_mm is not None
    if not flat and (body.width_mm is not None or body.density_kg_m3 is not None):
        allowed = "a thickness, which width_mm and density_kg_m3 go with"
        drawn.refuse(f"{key}.thickness_mm", None, allowed)
    count = len(body.points.split())
    if count == 1 and not flat and body.mass_kg is None:
        allowed = "a mass, or a thickness_mm: a body with one point is a disc"
        drawn.refuse(f"{key}.mass_kg", None, allowed)
    if count == 2 and flat and body.width_mm is None:
        allowed = "a width: two points are the ends of a bar, a plate has three corners or more"
        drawn.refuse(f"{key}.width_mm", None, allowed)
    corners = [place(drawn.points, name) for name in body.points.split()]
    plate = flat and body.width_mm is None
    if not mass_of(body, drawn.points).mass > 0.0 or (plate and crosses(corners)):
        allowed = "points that are apart, of a plate corner after corner around it"
        drawn.refuse(f"{key}.points", body.points, allowed)


def _check_gears(drawn: Drawn, joint: JointTable, key: str) -> None:
    """Refuse a joint that follows none, or by a number that does not fit their kinds."""
    if joint.follows is None:
        if joint.ratio is not None or joint.lead_mm_per_turn is not None:
            drawn.refuse(f"{key}.follows", None, "the joint that this one follows")
        return
    others = {name: each for name, each in drawn.joints.items() if each is not joint}
    if joint.follows not in others:
        allowed = f"{meant(joint.follows, others)}another joint: {', '.join(others)}"
        drawn.refuse(f"{key}.follows", joint.follows, allowed)
    alike = bool(joint.slide) == bool(others[joint.follows].slide)
    need, other = ("ratio", "lead_mm_per_turn")[:: 1 if alike else -1]
    kinds = f"{'a slide' if joint.slide else 'a hinge'} that follows {joint.follows}"
    if getattr(joint, other) is not None:
        drawn.refuse(f"{key}.{other}", getattr(joint, other), f"{need} in its place, of {kinds}")
    if not getattr(joint, need):
        drawn.refuse(f"{key}.{need}", getattr(joint, need), f"a number other than 0, of {kinds}")


def _named_points(table: DrawingTable) -> Iterator[tuple[str, str]]:
    """Every point that bodies and joints name, after the key that names it."""
    for name, body in table.bodies.items():
        yield from ((f"bodies.{name}.points", point) for point in body.points.split())
    for name, shape in table.shapes.items():
        if isinstance(shape.at, str):
            yield f"shapes.{name}.at", shape.at
    for number, joint in enumerate(table.joints):
        yield f"joints[{number}].{'pin' if joint.pin else 'at'}", joint.point
        if isinstance(joint.along, str):
            yield from ((f"joints[{number}].along", point) for point in joint.along.split())


@dataclass(frozen=True)
class Tree:
    """The bodies of a drawing as they hang on one another.

    Attributes:
        carried: Joints that carry a body, by their names, the frame's first.
        cut: Pins and slots that close loops, by their names.
        origins: Place of the frame of each link [mm].
        ends: Link and point of both ends of springs and dampers between points, by their paths.
    """

    drawn: Drawn
    carried: dict[str, JointTable]
    cut: dict[str, JointTable]
    origins: dict[str, Place]
    ends: dict[str, list[tuple[str, str]]]


def grown(drawn: Drawn) -> Tree:
    """Grow the tree of a drawing from its frame, joints in the order in which they are listed.

    Raises:
        ModelError: A body hangs on nothing, a slide closes a loop, or a part cannot be used.
    """
    check_parts(drawn)
    origins: dict[str, Place] = {FRAME: (0.0, 0.0)}
    carried: dict[str, JointTable] = {}
    while True:
        before = len(carried)
        for name, joint in drawn.joints.items():
            if joint.slot or joint.parent not in origins or joint.child in origins:
                continue
            carried[name] = joint
            origins[joint.child] = place(drawn.points, joint.point)
        if len(carried) == before:
            break
    for name, body in drawn.table.bodies.items():
        if name not in origins:
            allowed = "a body to which a joint leads, from the frame or from one that hangs on it"
            drawn.refuse(f"bodies.{name}", body.points, allowed)
    cut = {name: joint for name, joint in drawn.joints.items() if name not in carried}
    for number, (name, joint) in enumerate(drawn.joints.items()):
        if joint.follows in cut or (joint.follows and name in cut):
            allowed = f"one of two joints that carry bodies: {', '.join(carried)}"
            drawn.refuse(f"joints[{number}].follows", joint.follows, allowed)
        if joint.slide and name in cut:
            allowed = "a slide that carries its child: only pins and slots close loops"
            drawn.refuse(f"joints[{number}].slide", name, allowed)
    return Tree(drawn, carried, cut, origins, _ends(drawn))


def _ends(drawn: Drawn) -> dict[str, list[tuple[str, str]]]:
    found = {}
    for section in ("springs", "dampers"):
        entries = drawn.model.get(section)
        for name, entry in entries.items() if isinstance(entries, Mapping) else ():
            if not (isinstance(entry, Mapping) and "ends" in entry):
                continue
            key, ends = f"{section}.{name}.ends", entry["ends"]
            words = [str(end).split() for end in ends] if isinstance(ends, list | tuple) else []
            if [len(item) for item in words] != [2, 2]:
                allowed = 'two texts of a link and a point, as in ["jaw E", "frame O"]'
                drawn.refuse(key, ends, allowed)
            for link, point in words:
                drawn.link(link, key)
                drawn.place(point, key)
            found[f"{section}.{name}"] = [(link, point) for link, point in words]
    return found
