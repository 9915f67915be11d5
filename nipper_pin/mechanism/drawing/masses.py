"""Mass, centre and inertia of a body of thin rods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

from ...errors import InputError
from ...units import M_PER_MM
from .parts import Body, Place
from .places import distance, place


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
