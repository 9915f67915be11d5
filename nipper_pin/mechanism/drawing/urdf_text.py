"""The URDF of a drawing: links with mass, joints, named frames of cut joints, and what is seen.

A body is made of thin rods.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from math import atan2
from xml.sax.saxutils import quoteattr

from ...units import M_PER_MM
from .layout import FRAME, BodyTable, JointTable
from .places import Place, distance, place, vector
from .read import Drawn
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


def mass_of(body: BodyTable, points: Mapping[str, Place]) -> Mass:
    """Mass of a body: of its rods, or of a disc about its only point, which gives its mass.

    Args:
        points: Places by name [mm].
    """
    places = [place(points, name) for name in body.points.split()]
    if len(places) == 1:
        mass = body.mass_kg or 0.0
        centre, inertia = places[0], 0.5e-6 * mass * body.radius_mm**2
    else:
        rods = [
            (distance(a, b), (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])))
            for a, b in pairwise(places)
        ]
        length = sum(size for size, _ in rods)
        mass = M_PER_MM * body.density_kg_m * length if body.mass_kg is None else body.mass_kg
        centre = (
            sum(size * middle[0] for size, middle in rods) / length,
            sum(size * middle[1] for size, middle in rods) / length,
        )
        spread = sum(
            size * (size**2 / 12.0 + distance(middle, centre) ** 2) for size, middle in rods
        )
        inertia = 1e-6 * mass * spread / length
    given = body.inertia_kg_m2
    return Mass(mass, body.centre_mm or centre, inertia if given is None else given)


LINE = "{}_line"
"""Name of the frame of a slot, by the slot's name."""


def frame_name(link: str, point: str) -> str:
    """Name of the frame at a point of a link."""
    return f"{link}_{point.replace('/', '_')}"


def ends_of(drawn: Drawn, ends: object, key: str) -> list[tuple[str, str]]:
    """Link and point of both ends of a spring or damper between points.

    Raises:
        ModelError: They are no two texts of a link and a point each.
    """
    words = [str(end).split() for end in ends] if isinstance(ends, list | tuple) else []
    if [len(item) for item in words] != [2, 2]:
        raise drawn.refused(
            key, ends, 'two texts of a link and a point, as in ["jaw E", "frame O"]'
        )
    for link, point in words:
        drawn.link(link, key)
        drawn.place(point, key)
    return [(link, point) for link, point in words]


def _ties(drawn: Drawn) -> list[tuple[str, str]]:
    """Links and points of the springs and dampers between points."""
    found: list[tuple[str, str]] = []
    for section in ("springs", "dampers"):
        entries = drawn.model.get(section)
        for name, entry in entries.items() if isinstance(entries, Mapping) else ():
            if isinstance(entry, Mapping) and "ends" in entry:
                found += ends_of(drawn, entry["ends"], f"{section}.{name}.ends")
    return found


def urdf_text(tree: Tree) -> str:
    """The URDF of a drawing; errors as of :func:`ends_of`."""
    drawn = tree.drawn
    lines = [
        '<?xml version="1.0"?>',
        f"<robot name={quoteattr(drawn.name)}>",
        f'  <link name="{FRAME}">',
        *frame_visuals(tree),
        "  </link>",
    ]
    for number, (key, joint) in enumerate(tree.carried.items()):
        lines += _link(tree, joint.child, number)
        lines += _joint(tree, key, joint)
    frames: dict[str, str] = {}
    for key, cut in tree.cut.items():
        if cut.slot:
            x, z = vector(drawn.points, cut.along or "")
            line = LINE.format(key)
            frames[line] = _frame(tree, line, cut.parent, cut.point, atan2(z, x))
        for link in (cut.child,) if cut.slot else (cut.parent, cut.child):
            name = frame_name(link, cut.point)
            frames[name] = _frame(tree, name, link, cut.point)
    for link, point in _ties(drawn):
        frames[frame_name(link, point)] = _frame(tree, frame_name(link, point), link, point)
    return "\n".join([*lines, *frames.values(), "</robot>", ""])


def _link(tree: Tree, name: str, number: int) -> list[str]:
    body = tree.drawn.table.bodies[name]
    found = mass_of(body, tree.drawn.points)
    moments = " ".join(f'{axis}="{found.inertia!r}"' for axis in ("ixx", "iyy", "izz"))
    return [
        f'  <link name="{name}">',
        f'    <inertial><origin xyz="{_offset(tree, name, found.centre)}"/>'
        f'<mass value="{found.mass!r}"/><inertia {moments} ixy="0" ixz="0" iyz="0"/></inertial>',
        *body_visuals(tree, name, number),
        "  </link>",
    ]


def _joint(tree: Tree, name: str, joint: JointTable) -> list[str]:
    points = tree.drawn.points
    kind, axis, limit = "continuous", "0 -1 0", ""
    if joint.slide:
        x, z = vector(points, joint.along or "")
        kind, axis = "prismatic", f"{x!r} 0 {z!r}"
        limit = '<limit lower="-10" upper="10" effort="1e6" velocity="1e3"/>'
    return [
        f'  <joint name="{name}" type="{kind}">',
        f'    <parent link="{joint.parent}"/><child link="{joint.child}"/>',
        f'    <origin xyz="{_offset(tree, joint.parent, place(points, joint.point))}"/>'
        f'<axis xyz="{axis}"/>{limit}',
        "  </joint>",
    ]


def _frame(tree: Tree, name: str, link: str, point: str, turned: float = 0.0) -> str:
    at = _offset(tree, link, place(tree.drawn.points, point))
    # A rotation about +y is clockwise in the side view.
    rpy = f' rpy="0 {-turned!r} 0"' if turned else ""
    return (
        f'  <link name="{name}"/>\n  <joint name="{name}_fixed" type="fixed">'
        f'<parent link="{link}"/><child link="{name}"/><origin xyz="{at}"{rpy}/></joint>'
    )


def _offset(tree: Tree, link: str, at: Place) -> str:
    x, z = tree.origins[link]
    return f"{M_PER_MM * (at[0] - x)!r} 0 {M_PER_MM * (at[1] - z)!r}"
