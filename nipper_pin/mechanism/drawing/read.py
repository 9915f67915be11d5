"""A drawing from its TOML file: points, bodies and joints in mm, all else as in a model's file.

A point is two numbers, x and z, or says how it is found from others::

    A = [0.0, 0.0]
    B = { centre = "A", radius_mm = 30.0, angle_deg = -15.0 }
    C = { meet = ["B", "D"], radii_mm = [90.0, 60.0], side = "left" }
    H = { between = ["C", "P"], share = 2.0 }
    G = { centre = "H", radius_mm = 160.0, line = "O", along = [0.0, -1.0], side = "ahead" }
    S = { beside = "C", right_mm = 10.0, up_mm = 50.0 }
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from ...errors import InputError, ModelError
from ..files.describe import converted, refuse_unusable
from ..files.description import Name, NotNegative, PlanePoint, Positive, TomlTable
from ..files.toml_text import read_toml
from ..model_files import read_model_text
from .parts import Body, Drawing, Part, Pin, Place, Slide, Slot
from .places import between, meet, on_line, place, polar


class PointTable(TomlTable, frozen=True, kw_only=True):
    """How a point is found from others; the keys of one way.

    Attributes:
        centre: A point that this one lies around.
        radius_mm: Distance from it [mm].
        angle_deg: Angle seen from it, counter-clockwise from x [deg].
        line: A point of the line on which this one lies, or where it is [mm].
        along: Direction of that line.
        meet: Two points around which this one lies.
        radii_mm: Distances from them [mm].
        between: Two points; this one lies on their line, or left of it.
        share: Share of the way from the first to the second.
        left_mm: Distance to the left of that way [mm].
        beside: A point from which the next two are counted.
        right_mm: Distance along x [mm].
        up_mm: Distance along z [mm].
        side: Which of two points it is.
    """

    centre: Name | None = None
    radius_mm: NotNegative | None = None
    angle_deg: float | None = None
    line: PlanePoint | str | None = None
    along: PlanePoint | None = None
    meet: tuple[Name, Name] | None = None
    radii_mm: tuple[NotNegative, NotNegative] | None = None
    between: tuple[Name, Name] | None = None
    share: float | None = None
    left_mm: float | None = None
    beside: Name | None = None
    right_mm: float | None = None
    up_mm: float | None = None
    side: Literal["left", "right", "ahead", "behind"] | None = None


class BodyTable(TomlTable, frozen=True, kw_only=True):
    """A moving link.

    Attributes:
        points: Names of its points, separated by spaces; ``A/B`` is halfway from A to B.
        density_kg_m: Mass of the rods from point to point by their length [kg/m].
        mass_kg: Mass, in place of what the density gives [kg].
        radius_mm: Of the disc of a body with one point [mm].
        centre_mm: Centre of mass, in place of that of the rods [mm].
        inertia_kg_m2: About the centre of mass, in place of that of the rods [kg m2].
    """

    points: Name
    density_kg_m: Positive | None = None
    mass_kg: Positive | None = None
    radius_mm: Positive | None = None
    centre_mm: PlanePoint | None = None
    inertia_kg_m2: Positive | None = None


class JointTable(TomlTable, frozen=True, kw_only=True):
    """A joint: a pin at a point, a slide, or a pin of the child in a slot of the parent.

    Attributes:
        pin: Point of a hinge.
        slide: Name of a straight guide.
        slot: Name of a pin in a straight slot.
        parent: Link that carries the joint.
        child: Link that turns or slides in it.
        name: Name of a hinge, if it is not that of its point.
        at: Point where guide or pin are.
        along: Direction in which the coordinate grows, or two points.
        block_mass_kg: Mass of the block in a slot [kg].
    """

    pin: Name | None = None
    slide: Name | None = None
    slot: Name | None = None
    parent: Name
    child: Name
    name: Name | None = None
    at: Name | None = None
    along: PlanePoint | str | None = None
    block_mass_kg: Positive | None = None


class DrawingTable(TomlTable, frozen=True, kw_only=True):
    """The tables of a drawing that a model's file has not.

    Attributes:
        drawing: Layout version, 1.
        title: What the machine is, in a few words.
        speed_rpm: Rated speed [r/min].
        direction: Sense of rotation of the input shaft.
        touch_deg: Angle of the input shaft as drawn [deg].
        start_deg: Angle at which turns start; that of the drawing if not given [deg].
        closed: Stops that are closed at the start.
        transition_stop: The stop whose bouncing is the transition; the first one if not given.
        gravity_m_s2: Gravity along -z [m/s2].
        known: Where the dimensions come from.
        invented: What is an invention.
        traced: Link and point whose path is drawn.
        points: Places by name [mm].
        bodies: Moving links by name.
        joints: Joints, in the order in which a tree is grown from the frame.
    """

    drawing: Literal[1]
    title: Name
    speed_rpm: Positive
    direction: Literal["clockwise", "counter-clockwise"] = "counter-clockwise"
    touch_deg: float = 0.0
    start_deg: float | None = None
    closed: tuple[Name, ...] = ()
    transition_stop: str = ""
    gravity_m_s2: float = 9.81
    known: str = ""
    invented: str = ""
    traced: str = ""
    points: dict[Name, PlanePoint | PointTable]
    bodies: dict[Name, BodyTable]
    joints: tuple[JointTable, ...]


_WORD = re.compile(r"\w+(?:[.-]\w+)*")
# Most points, bodies and joints: each is compared with all others.
_MOST = 1000
_OWN = frozenset(DrawingTable.__struct_fields__)
# Of a model's file, these follow from the drawing.
_MADE = ("format", "degrees_of_freedom", "cylinder", "closures")
# Keys of each way to find a point, and on which sides it may be.
_WAYS: dict[tuple[str, ...], tuple[str | None, ...]] = {
    ("centre", "radius_mm", "angle_deg"): (None,),
    ("meet", "radii_mm", "side"): ("left", "right"),
    ("between", "share"): (None,),
    ("between", "share", "left_mm"): (None,),
    ("centre", "radius_mm", "line", "along", "side"): ("ahead", "behind"),
    ("beside", "right_mm", "up_mm"): (None,),
}
_WAYS_IN_WORDS = "[x, z], or the keys of one way: " + "; ".join(map(", ".join, _WAYS))
_KEYS = {
    "pin": ("pin", "parent", "child"),
    "slide": ("slide", "parent", "child", "at", "along"),
    "slot": ("slot", "parent", "child", "at", "along"),
}
_MAY_BE = {"pin": ("name",), "slide": (), "slot": ("block_mass_kg",)}


def read_drawing(file: str | Path) -> Drawing:
    """Read a drawing from its file, whose name becomes the machine's.

    Raises:
        ModelError: The file cannot be read, or a value in it cannot be used.
        InputError: A point cannot be found as it is given.
    """
    path = Path(file)
    return drawing_of(read_toml(read_model_text(path), path.name), path.stem, path.name)


def drawing_of(document: Mapping[str, Any], name: str, file: str) -> Drawing:
    """The drawing that a TOML document gives; errors as of :func:`read_drawing`.

    Args:
        name: Name of the machine.
    """
    own = {key: value for key, value in document.items() if key in _OWN}
    for key in _MADE:
        if key in document:
            allowed = "nothing: a drawing makes it, of its points, bodies, joints and shaft"
            raise ModelError(file=file, key=key, value=document[key], allowed=allowed)
    refuse_unusable(own, "", file)
    table: DrawingTable = converted(own, DrawingTable, "", file)
    for key, items in (
        ("points", table.points),
        ("bodies", table.bodies),
        ("joints", table.joints),
    ):
        if len(items) > _MOST:
            value = f"{len(items)} entries"
            raise ModelError(file=file, key=key, value=value, allowed=f"at most {_MOST}")
    _need_words(table, file)
    points = _places(table.points, file)
    parts: list[Part] = [_body(key, body) for key, body in table.bodies.items()]
    parts += [_joint(item, f"joints[{at}]", file) for at, item in enumerate(table.joints)]
    return Drawing(
        name,
        table.title,
        points,
        tuple(parts),
        touch_deg=table.touch_deg,
        start_deg=table.touch_deg if table.start_deg is None else table.start_deg,
        speed_rpm=table.speed_rpm,
        clockwise=table.direction == "clockwise",
        closed=table.closed,
        struck=table.transition_stop,
        gravity_m_s2=table.gravity_m_s2,
        known=table.known,
        invented=table.invented or Drawing.invented,
        traced=table.traced,
        tables={key: value for key, value in document.items() if key not in _OWN},
    )


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


def _places(points: Mapping[str, PlanePoint | PointTable], file: str) -> dict[str, Place]:
    """All points, each once those are known that it is found from."""
    found: dict[str, Place] = {}
    waiting = dict(points)
    while waiting:
        ready = [key for key, point in waiting.items() if not _others(point) - found.keys()]
        for key in ready:
            found[key] = _place(found, waiting.pop(key), f"points.{key}", file)
        if not ready:
            key, point = next(iter(waiting.items()))
            lacking = " and ".join(sorted(_others(point) - found.keys()))
            allowed = f"points that are found without it; those there are: {', '.join(points)}"
            value = f"found from {lacking}"
            raise ModelError(file=file, key=f"points.{key}", value=value, allowed=allowed)
    return {key: found[key] for key in points}


def _others(point: PlanePoint | PointTable) -> set[str]:
    """Names of the points that one is found from."""
    if not isinstance(point, PointTable):
        return set()
    line = point.line if isinstance(point.line, str) else None
    named = [point.centre, line, point.beside, *(point.meet or ()), *(point.between or ())]
    return {part for name in named if name for part in name.split("/")}


def _place(
    points: Mapping[str, Place], point: PlanePoint | PointTable, key: str, file: str
) -> Place:
    """A point, from others that are known."""
    if not isinstance(point, PointTable):
        return point
    given = {item: getattr(point, item) for item in point.__struct_fields__}
    given = {item: value for item, value in given.items() if value is not None}
    sides = next((sides for way, sides in _WAYS.items() if set(way) == set(given)), ())
    if not sides:
        raise ModelError(file=file, key=key, value=", ".join(given), allowed=_WAYS_IN_WORDS)
    if point.side not in sides:
        allowed = " or ".join(map(str, sides))
        raise ModelError(file=file, key=f"{key}.side", value=point.side, allowed=allowed)
    try:
        return _found(points, point)
    except InputError as error:
        words = ", ".join(f"{item} = {value}" for item, value in given.items())
        raise ModelError(file=file, key=key, value=words, allowed=error.message) from error


def _found(points: Mapping[str, Place], point: PointTable) -> Place:
    """A point by the way whose keys are given."""
    if point.meet and point.radii_mm:
        (a, b), (r_a, r_b) = point.meet, point.radii_mm
        return meet(place(points, a), r_a, place(points, b), r_b, point.side == "left")
    if point.between and point.share is not None:
        first, second = (place(points, item) for item in point.between)
        return between(first, second, point.share, point.left_mm or 0.0)
    if point.beside:
        x, z = place(points, point.beside)
        return x + (point.right_mm or 0.0), z + (point.up_mm or 0.0)
    centre, radius = place(points, point.centre or ""), point.radius_mm or 0.0
    if point.line and point.along:
        ahead = point.side == "ahead"
        at = place(points, point.line) if isinstance(point.line, str) else point.line
        return on_line(centre, radius, at, point.along, ahead)
    return polar(centre, radius, point.angle_deg or 0.0)


def _body(name: str, body: BodyTable) -> Body:
    given = {key: getattr(body, key) for key in body.__struct_fields__}
    return Body(name, **{key: value for key, value in given.items() if value is not None})


def _joint(joint: JointTable, key: str, file: str) -> Pin | Slide | Slot:
    given = {item for item in joint.__struct_fields__ if getattr(joint, item) is not None}
    kind = next((kind for kind in _KEYS if kind in given), "")
    wanted, may_be = set(_KEYS.get(kind, ())), set(_MAY_BE.get(kind, ()))
    if not (kind and wanted <= given <= wanted | may_be):
        ways = "; ".join(", ".join(keys) for keys in _KEYS.values())
        allowed = f"the keys of one kind of joint: {ways}"
        raise ModelError(file=file, key=key, value=", ".join(sorted(given)), allowed=allowed)
    at, along = joint.at or "", joint.along or ""
    if joint.pin:
        return Pin(joint.pin, joint.parent, joint.child, joint.name or "")
    if joint.slide:
        return Slide(joint.slide, joint.parent, joint.child, at, along)
    block = {} if joint.block_mass_kg is None else {"block_kg": joint.block_mass_kg}
    return Slot(joint.slot or "", joint.parent, joint.child, at, along, **block)
