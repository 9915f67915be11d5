"""The URDF of a drawing: links with mass, joints, named frames of cut joints, and what is seen.

A body is made of thin rods.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import atan2
from xml.sax.saxutils import quoteattr

from ...errors import InputError
from ...units import M_PER_MM
from .parts import FRAME, Body, Drawing, Pin, Place, Slide, Slot, Tie
from .places import distance, place, vector
from .tree import Tree
from .visuals import body_visuals, frame_visuals


@dataclass(frozen=True)
class Mass:
    """Mass of a body.

    Attributes:
        mass: Mass [kg].
        centre: Centre of mass (x, z) [mm].
        inertia: About that [kg m2].
    """

    mass: float
    centre: Place
    inertia: float


def mass_of(body: Body, points: Mapping[str, Place]) -> Mass:
    """Mass of a body: of its rods, or of a disc about its only point.

    Args:
        points: Places by name [mm].

    Raises:
        InputError: A point does not exist, or a body with one point has no mass.
    """
    places = [place(points, name) for name in body.points.split()]
    if len(places) == 1:
        if body.mass_kg is None:
            message = f"body {body.name} has one point, so its mass has to be given: mass_kg"
            raise InputError(message, body=body.name)
        disc = 0.5e-6 * body.mass_kg * body.radius_mm**2
        inertia = disc if body.inertia_kg_m2 is None else body.inertia_kg_m2
        return Mass(body.mass_kg, body.centre_mm or places[0], inertia)
    rods = [
        (distance(a, b), (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))) for a, b in pairwise(places)
    ]
    length = sum(size for size, _ in rods)
    mass = M_PER_MM * body.density_kg_m * length if body.mass_kg is None else body.mass_kg
    centre = (
        sum(size * middle[0] for size, middle in rods) / length,
        sum(size * middle[1] for size, middle in rods) / length,
    )
    spread = sum(
        size * (size**2 / 12.0 + distance(middle, centre) ** 2) for size, middle in rods
    )  # fmt: skip
    inertia = 1e-6 * mass * spread / length if body.inertia_kg_m2 is None else body.inertia_kg_m2
    return Mass(mass, body.centre_mm or centre, inertia)


LINE = "{}_line"
"""Name of the frame of a slot, by the slot's name."""


def frame_name(link: str, point: str) -> str:
    """Name of the frame at a point of a link."""
    return f"{link}_{point.replace('/', '_')}"


def ends_of(drawing: Drawing, ends: object) -> list[tuple[str, str]]:
    """Link and point of both ends of a spring or damper between points.

    Raises:
        InputError: They are no two texts of a link and a point each.
    """
    given = ends if isinstance(ends, list | tuple) else ()
    words = [str(end).split() for end in given]
    if [len(item) for item in words] != [2, 2]:
        message = f'{drawing.name}: ends = {ends!r}: two texts of a link and a point, "jaw E"'
        raise InputError(message, ends=ends)
    return [(link, point) for link, point in words]


def _ties(drawing: Drawing) -> list[object]:
    """Ends of the springs and dampers between points."""
    found: list[object] = [part.ends for part in drawing.parts if isinstance(part, Tie)]
    for section in ("springs", "dampers"):
        entries = drawing.tables.get(section)
        for entry in entries.values() if isinstance(entries, Mapping) else ():
            if isinstance(entry, Mapping) and "ends" in entry:
                found.append(entry["ends"])
    return found


def urdf_text(tree: Tree, name: str) -> str:
    """The URDF of a drawing.

    Raises:
        InputError: A point or a mass is missing.
    """
    drawing = tree.drawing
    lines = [
        '<?xml version="1.0"?>',
        f"<robot name={quoteattr(name)}>",
        f'  <link name="{FRAME}">',
        *frame_visuals(tree),
        "  </link>",
    ]
    for number, (key, joint) in enumerate(tree.carried.items()):
        lines += _link(tree, tree.bodies[joint.child], number)
        lines += _joint(tree, key, joint)
    frames: dict[str, str] = {}
    for key, cut in tree.cut.items():
        if isinstance(cut, Slot):
            x, z = vector(drawing.points, cut.along)
            frames[LINE.format(key)] = _frame(tree, LINE.format(key), cut.slotted, cut.at,
                                              atan2(z, x))  # fmt: skip
        ends = (cut.parent, cut.child) if isinstance(cut, Pin) else (cut.pinned,)
        point = cut.point if isinstance(cut, Pin) else cut.at
        for link in ends:
            frames[frame_name(link, point)] = _frame(tree, frame_name(link, point), link, point)
    for tied in _ties(drawing):
        for link, point in ends_of(drawing, tied):
            frames[frame_name(link, point)] = _frame(tree, frame_name(link, point), link, point)
    return "\n".join([*lines, *frames.values(), "</robot>", ""])


def _link(tree: Tree, body: Body, number: int) -> list[str]:
    found = mass_of(body, tree.drawing.points)
    moments = " ".join(f'{axis}="{found.inertia!r}"' for axis in ("ixx", "iyy", "izz"))
    return [
        f'  <link name="{body.name}">',
        f'    <inertial><origin xyz="{_offset(tree, body.name, found.centre)}"/>'
        f'<mass value="{found.mass!r}"/><inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial>',
        *body_visuals(tree, body, number),
        "  </link>",
    ]


def _joint(tree: Tree, name: str, joint: Pin | Slide) -> list[str]:
    points = tree.drawing.points
    if isinstance(joint, Pin):
        kind, at, axis, limit = "continuous", joint.point, "0 -1 0", ""
    else:
        x, z = vector(points, joint.along)
        kind, at, axis = "prismatic", joint.at, f"{x!r} 0 {z!r}"
        limit = '<limit lower="-10" upper="10" effort="1e6" velocity="1e3"/>'
    return [
        f'  <joint name="{name}" type="{kind}">',
        f'    <parent link="{joint.parent}"/><child link="{joint.child}"/>',
        f'    <origin xyz="{_offset(tree, joint.parent, place(points, at))}"/>'
        f'<axis xyz="{axis}"/>{limit}',
        "  </joint>",
    ]


def _frame(tree: Tree, name: str, link: str, point: str, turned: float = 0.0) -> str:
    at = _offset(tree, link, place(tree.drawing.points, point))
    # A rotation about +y is clockwise in the side view.
    rpy = f' rpy="0 {-turned!r} 0"' if turned else ""
    return (
        f'  <link name="{name}"/>\n  <joint name="{name}_fixed" type="fixed">'
        f'<parent link="{link}"/><child link="{name}"/><origin xyz="{at}"{rpy}/></joint>'
    )


def _offset(tree: Tree, link: str, at: Place) -> str:
    x, z = tree.origins[link]
    return f"{M_PER_MM * (at[0] - x)!r} 0 {M_PER_MM * (at[1] - z)!r}"
