"""Points of a drawing: circles and lines that meet, polar coordinates, all in mm."""

from __future__ import annotations

from collections.abc import Mapping
from math import atan2, cos, degrees, hypot, radians, sin, sqrt

from ...errors import InputError, meant

Place = tuple[float, float]
"""(x, z) of a point, or a direction [mm]."""


def polar(centre: Place, radius: float, angle_deg: float) -> Place:
    """The point at a distance and an angle, counter-clockwise from x, of another one.

    Args:
        centre: The other point [mm].
        radius: Distance [mm].
        angle_deg: Angle [deg].
    """
    angle = radians(angle_deg)
    return centre[0] + radius * cos(angle), centre[1] + radius * sin(angle)


def between(first: Place, second: Place, share: float, left: float = 0.0) -> Place:
    """The point at a share of the way between two others, and to the left of that way.

    Args:
        first: Start [mm].
        second: End [mm].
        share: Share of the way; beyond 0 to 1 the line goes on.
        left: Distance to the left of the line [mm].
    """
    x, z = second[0] - first[0], second[1] - first[1]
    aside = left / hypot(x, z)
    return first[0] + share * x - aside * z, first[1] + share * z + aside * x


def meet(first: Place, r_first: float, second: Place, r_second: float, left: bool) -> Place:
    """The point at given distances of two others.

    Args:
        first: A point [mm].
        r_first: Distance from it [mm].
        second: Another one [mm].
        r_second: Distance from it [mm].
        left: Whether it lies to the left of the way from the first to the second.

    Raises:
        InputError: There is none.
    """
    apart = distance(first, second)
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
    """The point of a line at a distance of another point.

    Args:
        centre: The other point [mm].
        radius: Distance from it [mm].
        at: A point of the line [mm].
        along: Direction of the line.
        ahead: Whether it is the further one of two in that direction.

    Raises:
        InputError: There is none.
    """
    size = hypot(*along)
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


def direction(first: Place, second: Place) -> float:
    """Angle of the way from one point to another, counter-clockwise from x [deg]."""
    return degrees(atan2(second[1] - first[1], second[0] - first[0]))


def _shown(point: Place) -> str:
    return f"({point[0]:.6g}, {point[1]:.6g})"


def place(points: Mapping[str, Place], name: str) -> Place:
    """A point by its name; ``A/B`` is halfway between A and B.

    Args:
        points: Places by name [mm].

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
    """A direction that is given as such, or by two points.

    Args:
        points: Places by name [mm].
        along: The direction, or the names of two points.

    Raises:
        InputError: A point does not exist.
    """
    if not isinstance(along, str):
        return along
    first, second = (place(points, name) for name in along.split())
    return second[0] - first[0], second[1] - first[1]
