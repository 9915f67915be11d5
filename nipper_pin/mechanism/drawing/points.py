"""Points of a drawing, each of them given or found from others, all in mm.

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
from math import atan2, cos, degrees, hypot, radians, sin, sqrt

from ...errors import InputError, ModelError, meant
from ..files.description import PlanePoint
from .layout import PointTable

Place = tuple[float, float]
"""(x, z) of a point, or a direction [mm]."""


def polar(centre: Place, radius: float, angle_deg: float) -> Place:
    """The point at a distance and an angle, counter-clockwise from x, of another one."""
    angle = radians(angle_deg)
    return centre[0] + radius * cos(angle), centre[1] + radius * sin(angle)


def between(first: Place, second: Place, share: float, left: float = 0.0) -> Place:
    """The point at a share of the way between two others, and to the left of that way.

    Raises:
        InputError: They are one point, which has no left.
    """
    x, z = second[0] - first[0], second[1] - first[1]
    aside = left / _apart(first, second) if left else 0.0
    return first[0] + share * x - aside * z, first[1] + share * z + aside * x


def meet(first: Place, r_first: float, second: Place, r_second: float, left: bool) -> Place:
    """The point at given distances of two others, to the left of the way from first to second.

    Raises:
        InputError: There is none.
    """
    apart = _apart(first, second)
    along = (apart**2 + r_first**2 - r_second**2) / (2.0 * apart)
    high = r_first**2 - along**2
    if high < 0.0:
        message = (
            f"no point is {r_first:g} mm from {_shown(first)} and {r_second:g} mm from "
            f"{_shown(second)}, which are {apart:g} mm apart"
        )
        raise InputError(message, lengths=(r_first, r_second, apart))
    return between(first, second, along / apart, sqrt(high) if left else -sqrt(high))


def on_line(centre: Place, radius: float, at: Place, along: Place, ahead: bool) -> Place:
    """The point of a line at a distance of another point, the further one along it if ahead.

    Raises:
        InputError: There is none.
    """
    size = _apart((0.0, 0.0), along)
    x, z = along[0] / size, along[1] / size
    foot = (centre[0] - at[0]) * x + (centre[1] - at[1]) * z
    aside = hypot(at[0] + foot * x - centre[0], at[1] + foot * z - centre[1])
    if aside > radius:
        message = f"the line passes {_shown(centre)} at {aside:g} mm, further than {radius:g} mm"
        raise InputError(message, distance=aside)
    away = foot + (1.0 if ahead else -1.0) * sqrt(radius**2 - aside**2)
    return at[0] + away * x, at[1] + away * z


def distance(first: Place, second: Place) -> float:
    """Distance of two points [mm]."""
    return hypot(second[0] - first[0], second[1] - first[1])


def _apart(first: Place, second: Place) -> float:
    """Distance of two points, which has to be above zero [mm]."""
    if not (apart := distance(first, second)):
        message = f"{_shown(first)} and {_shown(second)} are one point, and give no direction"
        raise InputError(message, points=(first, second))
    return apart


def direction(first: Place, second: Place) -> float:
    """Angle of the way from one point to another, counter-clockwise from x [deg]."""
    return degrees(atan2(second[1] - first[1], second[0] - first[0]))


def _shown(point: Place) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"


def place(points: Mapping[str, Place], name: str) -> Place:
    """A point by its name; ``A/B`` is halfway between A and B."""
    ends = [item for item in name.split("/") if item in points]
    if len(ends) != name.count("/") + 1 or len(ends) > 2:
        near = meant(name, points)
        message = f"the drawing has no point {name!r}; {near}its points: {', '.join(points)}"
        raise InputError(message, point=name)
    return points[name] if name in points else between(points[ends[0]], points[ends[1]], 0.5)


def vector(points: Mapping[str, Place], along: Place | str) -> Place:
    """A direction that is given as such, or by the names of two points."""
    if not isinstance(along, str):
        return along
    first, second = (place(points, name) for name in along.split())
    return second[0] - first[0], second[1] - first[1]


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
