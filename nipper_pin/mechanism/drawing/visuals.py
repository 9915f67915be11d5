"""Visual shapes of a drawing: bars between points, blocks, and the ground under fixed pins."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from math import radians

from ...units import M_PER_MM
from .layout import FRAME
from .places import Place, direction, distance, place, vector
from .tree import Tree

_WIDTH = 0.028  # of a bar, by the size of the drawing
_ALONE = 100.0  # size of a drawing of one point [mm]
_GROUND = (0.55, 0.57, 0.6)


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
        return [_box(tree, name, "block", places[0], (side, depth, side), turned, aside)]
    bars = [
        _box(tree, name, f"bar_{place}", ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2),
             (distance(a, b), depth, width), direction(a, b), aside)
        for place, (a, b) in enumerate(pairwise(places))
        if a != b
    ]  # fmt: skip
    pins = [
        _disc(tree, name, f"eye_{place}", at, 0.75 * width, 1.05 * depth, aside)
        for place, at in enumerate(dict.fromkeys(places))
    ]
    return bars + pins


def frame_visuals(tree: Tree) -> list[str]:
    """Shapes of the frame: a foot under each fixed pin, a rail along each guide."""
    return list(_ground(tree))


def _ground(tree: Tree) -> Iterator[str]:
    points, size = tree.drawn.points, _size(tree)
    width = _WIDTH * size
    depth = 0.6 * width
    for key, joint in {**tree.carried, **tree.cut}.items():
        if joint.pin and FRAME in (joint.parent, joint.child):
            x, z = place(points, joint.point)
            foot = (2.2 * width, depth, 1.6 * width)
            yield _box(tree, FRAME, f"foot_{key}", (x, z - 0.8 * width), foot, 0.0, depth, _GROUND)
        elif joint.slide and joint.parent == FRAME:
            angle = _angle(vector(points, joint.along or ""))
            rail = (0.35 * size, depth, 0.35 * width)
            yield _box(tree, FRAME, f"rail_{key}", place(points, joint.point), rail, angle, depth,
                       _GROUND)  # fmt: skip


def _size(tree: Tree) -> float:
    """Larger extent of the points [mm]."""
    points = list(tree.drawn.points.values())
    extents = [[point[axis] for point in points] for axis in (0, 1)]
    return max(max(extent) - min(extent) for extent in extents) or _ALONE


def _angle(along: Place) -> float:
    return direction((0.0, 0.0), along)


def _box(
    tree: Tree,
    link: str,
    name: str,
    at: Place,
    edges: tuple[float, float, float],
    angle_deg: float,
    aside: float,
    colour: tuple[float, float, float] | None = None,
) -> str:
    lean = -radians(angle_deg)
    size = " ".join(f"{M_PER_MM * edge:.6g}" for edge in edges)
    return _shape(tree, link, name, at, aside, f"0 {lean:.9g} 0", f'<box size="{size}"/>', colour)


def _disc(
    tree: Tree, link: str, name: str, at: Place, radius: float, thick: float, aside: float
) -> str:
    solid = f'<cylinder radius="{M_PER_MM * radius:.6g}" length="{M_PER_MM * thick:.6g}"/>'
    return _shape(tree, link, name, at, aside, "1.57079632679 0 0", solid, None)


def _shape(
    tree: Tree,
    link: str,
    name: str,
    at: Place,
    aside: float,
    rpy: str,
    solid: str,
    colour: tuple[float, float, float] | None,
) -> str:
    x, z = at[0] - tree.origins[link][0], at[1] - tree.origins[link][1]
    xyz = f"{M_PER_MM * x:.6g} {M_PER_MM * aside:.6g} {M_PER_MM * z:.6g}"
    paint = ""
    if colour is not None:
        rgba = " ".join(f"{part:g}" for part in (*colour, 1.0))
        paint = f'<material name="ground"><color rgba="{rgba}"/></material>'
    return (
        f'    <visual name="{name}"><origin xyz="{xyz}" rpy="{rpy}"/>'
        f"<geometry>{solid}</geometry>{paint}</visual>"
    )
