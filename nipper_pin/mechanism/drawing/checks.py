"""Checks of what a drawing says of its parts, one by another."""

from __future__ import annotations

from collections.abc import Iterator

from ...errors import meant
from .layout import BodyTable, DrawingTable, JointTable
from .mass import crosses, mass_of
from .places import place, vector
from .read import Drawn


def check_parts(drawn: Drawn) -> None:
    """Refuse parts at points, and on bodies, that there are not, and bodies without a mass.

    Raises:
        ModelError: Names the first of them.
    """
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
