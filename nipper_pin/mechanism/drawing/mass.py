"""Masses of bodies: thin rods, flat bars, plates and discs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from math import pi

from ...units import M_PER_MM
from .layout import STEEL_KG_M3, BodyTable
from .points import Place, distance, place


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
    """Mass of a body, of its shape where its table does not give it.

    Points that are all in one place, or corners on a line, make none.
    """
    places = [place(points, name) for name in body.points.split()]
    # Of a plate [kg/mm2].
    area = STEEL_KG_M3 if body.density_kg_m3 is None else body.density_kg_m3
    area *= 1e-9 * (body.thickness_mm or 0.0)
    if len(places) == 1:
        mass = pi * body.radius_mm**2 * area if body.mass_kg is None else body.mass_kg
        found = Mass(mass, places[0], 0.5e-6 * mass * body.radius_mm**2)
    elif body.thickness_mm and body.width_mm is None:
        found = _plate(places, area, body.mass_kg)
    elif body.thickness_mm:
        width = body.width_mm or 0.0
        found = _bars(places, area * width, width, body.mass_kg)
    else:
        found = _bars(places, M_PER_MM * body.density_kg_m, 0.0, body.mass_kg)
    given = body.inertia_kg_m2
    inertia = found.inertia if given is None else given
    return Mass(found.mass, body.centre_mm or found.centre, inertia)


def _bars(places: Sequence[Place], line: float, width: float, given: float | None) -> Mass:
    """Bars from each place to the next, of a mass by their length [kg/mm]."""
    rods = [
        (distance(a, b), (0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]))) for a, b in pairwise(places)
    ]
    length = sum(size for size, _ in rods)
    if not length:
        return Mass(0.0, places[0], 0.0)
    mass = line * length if given is None else given
    centre = (
        sum(size * middle[0] for size, middle in rods) / length,
        sum(size * middle[1] for size, middle in rods) / length,
    )
    spread = sum(
        size * ((size**2 + width**2) / 12.0 + distance(middle, centre) ** 2)
        for size, middle in rods
    )
    return Mass(mass, centre, 1e-6 * mass * spread / length)


def _plate(corners: Sequence[Place], area: float, given: float | None) -> Mass:
    """A polygon: the triangles from its first corner, each with a sign."""
    (x0, z0), *others = corners
    total, first, second, square = 0.0, 0.0, 0.0, 0.0
    for (x, z), (u, w) in pairwise((p[0] - x0, p[1] - z0) for p in others):
        twice = x * w - u * z
        total += 0.5 * twice
        first += twice * (x + u) / 6.0
        second += twice * (z + w) / 6.0
        square += twice * (x * x + x * u + u * u + z * z + z * w + w * w) / 12.0
    if not total:
        return Mass(0.0, corners[0], 0.0)
    mass = area * abs(total) if given is None else given
    x, z = first / total, second / total
    return Mass(mass, (x0 + x, z0 + z), 1e-6 * mass * (square / total - x * x - z * z))


def crosses(corners: Sequence[Place]) -> bool:
    """Whether two edges of a polygon cross, so that its corners are in no order around it."""
    edges = [*pairwise([*corners, corners[0]])]
    return any(
        _side(*first, second[0]) * _side(*first, second[1]) < 0.0
        and _side(*second, first[0]) * _side(*second, first[1]) < 0.0
        for first, second in combinations(edges, 2)
    )


def _side(start: Place, end: Place, point: Place) -> float:
    """Positive of a point to the left of a line, negative to the right."""
    x, z = end[0] - start[0], end[1] - start[1]
    return x * (point[1] - start[1]) - z * (point[0] - start[0])
