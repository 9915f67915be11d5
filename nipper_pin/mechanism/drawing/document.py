"""The texts of a drawing: its URDF, and the TOML document beside it.

The URDF has links with mass, joints, named frames of cut joints, and shapes; what is only seen is
bars between points, blocks, and the ground under fixed pins. The document has shaft, closures and
phases, beside the tables of the model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import atan2, pi, radians, tau
from typing import Any
from xml.sax.saxutils import quoteattr

from ...errors import meant
from ...units import M_PER_MM
from .layout import FRAME, JointTable
from .mass import mass_of
from .points import Place, direction, distance, place, vector
from .read import Tree, grown, read

LINE = "{}_line"
"""Name of the frame of a slot, by the slot's name."""
_WIDTH = 0.028  # of a bar, by the size of the drawing
_ALONE = 100.0  # size of a drawing of one point [mm]
_GROUND = '<material name="ground"><color rgba="0.55 0.57 0.6 1"/></material>'
# Of a model's file, in the order in which they are written.
_SECTIONS = ("drives", "springs", "dampers", "forces", "initial", "stops")


def drawn_sources(tables: Mapping[str, Any], name: str) -> tuple[str, dict[str, Any]]:
    """The URDF and the TOML document of a drawing, as plain data."""
    tree = grown(read(tables, name))
    return urdf_text(tree), document(tree)


def document(tree: Tree) -> dict[str, Any]:
    """The TOML document of a drawing as plain data."""
    drawn = tree.drawn
    table, model = drawn.table, drawn.model
    given = {section: _with_frames(tree, section) for section in _SECTIONS}
    stops, springs = given.pop("stops"), given["springs"]
    struck = table.transition_stop or next(iter(stops), "")
    for key, names in (("closed", table.closed), ("transition_stop", (struck,) if struck else ())):
        for name in names:
            if name not in stops:
                allowed = f"{meant(name, stops)}a stop: {', '.join(stops) or 'there is none'}"
                drawn.refuse(key, name, allowed)
    slots = sum(cut.slot is not None for cut in tree.cut.values())
    geared = sum(joint.follows is not None for joint in tree.carried.values())
    mobility = len(tree.carried) + slots - geared - 2 * len(tree.cut)
    if mobility < 1:
        value = f"{len(tree.carried) + slots} coordinates and {len(tree.cut)} closed loops"
        allowed = (
            "a machine that moves: each pin or slot that closes a loop takes two freedoms, each "
            f"joint that follows one, and {mobility} are left; loops are closed by "
            f"{', '.join(tree.cut)}; of bodies that are guided twice alike leave one out"
        )
        drawn.refuse("joints", value, allowed)
    found: dict[str, Any] = {
        "format": 1,
        "title": table.title,
        "degrees_of_freedom": mobility,
        "gravity_m_s2": table.gravity_m_s2,
        "transition_stop": struck,
        "initial_phase": 1,
        "cylinder": {
            "rated_speed_rpm": table.speed_rpm,
            "direction": table.direction,
            "angle_at_touch_deg": table.touch_deg,
            "reference_index": 24.0,
            "reference_angle_deg": table.touch_deg if table.start_deg is None else table.start_deg,
        },
        **given,
        "stops": stops,
        "closures": _closures(tree),
        "phases": _phases(table.closed, struck),
        "shortcuts": _shortcuts(struck, springs),
        "provenance": {
            "urdf.points": table.known or table.invented,
            "urdf.links": "invention: bars of an even mass by their length, blocks as given",
            **dict.fromkeys(("drives", "springs", "stops"), table.invented),
        },
        **{key: value for key, value in model.items() if key not in _SECTIONS},
    }
    return {key: value for key, value in found.items() if value or key == "gravity_m_s2"}


def frame_name(link: str, point: str) -> str:
    """Name of the frame at a point of a link."""
    return f"{link}_{point.replace('/', '_')}"


def urdf_text(tree: Tree) -> str:
    """The URDF of a drawing."""
    drawn = tree.drawn
    lines = [
        '<?xml version="1.0"?>',
        f"<robot name={quoteattr(drawn.name)}>",
        f'  <link name="{FRAME}">',
        *frame_visuals(tree),
        *_shapes(tree, FRAME),
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
    for link, point in (end for ends in tree.ends.values() for end in ends):
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
        *_shapes(tree, name),
        "  </link>",
    ]


def _shapes(tree: Tree, link: str) -> list[str]:
    """Shapes of a link that stops know, which are seen as well."""
    found = []
    for name, shape in tree.drawn.table.shapes.items():
        if shape.body != link:
            continue
        depth = M_PER_MM * shape.depth_mm
        if shape.box_mm is None:
            radius, rpy = M_PER_MM * (shape.radius_mm or 0.0), f"{0.5 * pi!r} 0 0"
            solid = f'<cylinder radius="{radius!r}" length="{depth!r}"/>'
        else:
            # A rotation about +y is clockwise in the side view.
            rpy = f"0 {-radians(shape.angle_deg) + 0.0!r} 0"
            along, across = (M_PER_MM * edge for edge in shape.box_mm)
            solid = f'<box size="{along!r} {depth!r} {across!r}"/>'
        at = place(tree.drawn.points, shape.at) if isinstance(shape.at, str) else shape.at
        inner = f'<origin xyz="{_offset(tree, link, at)}" rpy="{rpy}"/><geometry>{solid}</geometry>'
        found += [f'    <{kind} name="{name}">{inner}</{kind}>' for kind in ("visual", "collision")]
    return found


def _joint(tree: Tree, name: str, joint: JointTable) -> list[str]:
    points = tree.drawn.points
    kind, axis, limit = "continuous", "0 -1 0", ""
    if joint.slide:
        x, z = vector(points, joint.along or "")
        kind, axis = "prismatic", f"{x!r} 0 {z!r}"
        limit = '<limit lower="-10" upper="10" effort="1e6" velocity="1e3"/>'
    gear = ""
    if joint.follows:
        by = joint.ratio if joint.lead_mm_per_turn is None else joint.lead_mm_per_turn / 1e3 / tau
        gear = f'<mimic joint={quoteattr(joint.follows)} multiplier="{by!r}"/>'
    return [
        f'  <joint name="{name}" type="{kind}">',
        f'    <parent link="{joint.parent}"/><child link="{joint.child}"/>',
        f'    <origin xyz="{_offset(tree, joint.parent, place(points, joint.point))}"/>'
        f'<axis xyz="{axis}"/>{limit}{gear}',
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


def body_visuals(tree: Tree, name: str, number: int) -> list[str]:
    """Bars of a body, in a separate layer; a block if it has one point."""
    points, size = tree.drawn.points, _size(tree)
    body = tree.drawn.table.bodies[name]
    places = [place(points, each) for each in body.points.split()]
    if body.thickness_mm and not body.width_mm and len(places) > 1:
        places.append(places[0])
    width, depth = body.width_mm or _WIDTH * size, 0.6 * _WIDTH * size
    aside = -depth * (number + 1)
    if len(places) == 1:
        side = 2.4 * width
        carrier = next(joint for joint in tree.carried.values() if joint.child == name)
        turned = _angle(vector(points, carrier.along)) if carrier.along else 0.0
        return [_seen(tree, name, "block", places[0], aside, _box((side, depth, side), turned))]
    bars = []
    for piece, (a, b) in enumerate(pairwise(places)):
        if a != b:
            middle = (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
            bar = _box((distance(a, b), depth, width), direction(a, b))
            bars.append(_seen(tree, name, f"bar_{piece}", middle, aside, bar))
    radius, thick = M_PER_MM * (0.75 * width), M_PER_MM * (1.05 * depth)
    eye = "1.57079632679 0 0", f'<cylinder radius="{radius:.6g}" length="{thick:.6g}"/>'
    pins = [
        _seen(tree, name, f"eye_{piece}", at, aside, eye)
        for piece, at in enumerate(dict.fromkeys(places))
    ]
    return bars + pins


def frame_visuals(tree: Tree) -> Iterator[str]:
    """Shapes of the frame: a foot under each fixed pin, a rail along each guide."""
    points, size = tree.drawn.points, _size(tree)
    width = _WIDTH * size
    depth = 0.6 * width
    for key, joint in {**tree.carried, **tree.cut}.items():
        if joint.pin and FRAME in (joint.parent, joint.child):
            x, z = place(points, joint.point)
            foot = _box((2.2 * width, depth, 1.6 * width), 0.0)
            yield _seen(tree, FRAME, f"foot_{key}", (x, z - 0.8 * width), depth, foot, _GROUND)
        elif joint.slide and joint.parent == FRAME:
            angle = _angle(vector(points, joint.along or ""))
            rail, at = _box((0.35 * size, depth, 0.35 * width), angle), place(points, joint.point)
            yield _seen(tree, FRAME, f"rail_{key}", at, depth, rail, _GROUND)


def _size(tree: Tree) -> float:
    """Larger extent of the points [mm]."""
    points = list(tree.drawn.points.values())
    extents = [[point[axis] for point in points] for axis in (0, 1)]
    return max(max(extent) - min(extent) for extent in extents) or _ALONE


def _angle(along: Place) -> float:
    return direction((0.0, 0.0), along)


def _box(edges: tuple[float, float, float], angle_deg: float) -> tuple[str, str]:
    """Angles and geometry of a box [mm], turned counter-clockwise."""
    size = " ".join(f"{M_PER_MM * edge:.6g}" for edge in edges)
    return f"0 {-radians(angle_deg):.9g} 0", f'<box size="{size}"/>'


def _seen(
    tree: Tree,
    link: str,
    name: str,
    at: Place,
    aside: float,
    solid: tuple[str, str],
    paint: str = "",
) -> str:
    x, z = at[0] - tree.origins[link][0], at[1] - tree.origins[link][1]
    xyz = f"{M_PER_MM * x:.6g} {M_PER_MM * aside:.6g} {M_PER_MM * z:.6g}"
    rpy, geometry = solid
    return (
        f'    <visual name="{name}"><origin xyz="{xyz}" rpy="{rpy}"/>'
        f"<geometry>{geometry}</geometry>{paint}</visual>"
    )


def _with_frames(tree: Tree, section: str) -> dict[str, Any]:
    """Entries of a section, the ends of springs and dampers as frames."""
    drawn, found = tree.drawn, {}
    entries = drawn.model.get(section, {})
    if not isinstance(entries, Mapping):
        drawn.refuse(section, entries, "a table of tables")
    for name, entry in entries.items():
        if not isinstance(entry, Mapping):
            drawn.refuse(f"{section}.{name}", entry, "a table")
        found[name] = dict(entry)
        if ends := tree.ends.get(f"{section}.{name}"):
            first, second = (frame_name(*end) for end in ends)
            found[name] = {"frame_a": first, "frame_b": second, **entry}
            del found[name]["ends"]
    return found


def _closures(tree: Tree) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, cut in tree.cut.items():
        first = LINE.format(name) if cut.slot else frame_name(cut.parent, cut.point)
        found[name] = {"frame_a": first, "frame_b": frame_name(cut.child, cut.point)}
        if cut.slot:
            mass = 0.02 if cut.block_mass_kg is None else cut.block_mass_kg
            found[name] |= {"slot_axis": "x", "block_mass_kg": mass}
    return found


def _phases(closed: tuple[str, ...], struck: str) -> list[dict[str, Any]]:
    """The start, the stop that is struck by itself, and nothing closed."""
    found: dict[tuple[str, ...], str] = {closed: "running"}
    if struck:
        found.setdefault((struck,), f"on the {struck}")
    found.setdefault((), "free")
    return [
        {"number": number, "name": name, "closed": list(stops)}
        for number, (stops, name) in enumerate(found.items(), start=1)
    ]


def _shortcuts(struck: str, springs: dict[str, Any]) -> dict[str, str]:
    found = {"restitution": f"stops.{struck}.restitution"} if struck else {}
    name, table = next(iter(springs.items()), ("", {}))
    if key := next((key for key in table if key.startswith("stiffness")), ""):
        found["stiffness"] = f"springs.{name}.{key}"
    return found
