"""Points of a drawing: circles and lines that meet, polar coordinates, all in mm."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, degrees, hypot, radians, sin, sqrt

from ...errors import InputError, meant

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
    """A point by its name; ``A/B`` is halfway between A and B.

    Raises:
        InputError: There is no such point.
    """
    ends = [item for item in name.split("/") if item in points]
    if len(ends) != name.count("/") + 1 or len(ends) > 2:
        near = meant(name, points)
        message = f"the drawing has no point {name!r}; {near}its points: {', '.join(points)}"
        raise InputError(message, point=name)
    return points[name] if name in points else between(points[ends[0]], points[ends[1]], 0.5)


def vector(points: Mapping[str, Place], along: Place | str) -> Place:
    """A direction that is given as such, or by the names of two points.

    Raises:
        InputError: A point does not exist.
    """
    if not isinstance(along, str):
        return along
    first, second = (place(points, name) for name in along.split())
    return second[0] - first[0], second[1] - first[1]
