"""Points of a drawing, each of them given or found from others.

A point is two numbers, x and z, or says how it is found from others::

    A = [0.0, 0.0]
    B = { centre = "A", radius_mm = 30.0, angle_deg = -15.0 }
    C = { meet = ["B", "D"], radii_mm = [90.0, 60.0], side = "left" }
    H = { between = ["C", "P"], share = 2.0 }
    G = { centre = "H", radius_mm = 160.0, line = "O", along = [0.0, -1.0], side = "ahead" }
    S = { beside = "C", right_mm = 10.0, up_mm = 50.0 }
"""

from __future__ import annotations

from collections.abc import Mapping

from ...errors import InputError, ModelError
from ..files.description import PlanePoint
from .layout import PointTable
from .places import Place, between, meet, on_line, place, polar

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


def found_points(points: Mapping[str, PlanePoint | PointTable], file: str) -> dict[str, Place]:
    """All points, each once those are known that it is found from.

    Raises:
        ModelError: A point cannot be found as it is given.
    """
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
