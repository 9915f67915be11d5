"""Masses of the moving links, and whether one looks like grams in place of kilograms."""

from __future__ import annotations

import math
from dataclasses import dataclass
from xml.etree import ElementTree

from ..mechanism import Mechanism
from ..mechanism.files import parse_xml

# No machine of this kind has such a link. Shapes may be thinner than the part that they stand for:
# 20 times denser than any metal is left for them, and grams are 1,000 times too many.
_HEAVY_KG = 1000.0
_DENSEST_KG_M3 = 5e5


@dataclass(frozen=True)
class LinkMass:
    """Mass of a link with everything that is fixed to it.

    Attributes:
        link: Name of the link.
        mass_kg: Its mass [kg].
        density_kg_m3: Mass by the volume of its collision shapes [kg/m3]; None without any, and
            with a mesh among them.
    """

    link: str
    mass_kg: float
    density_kg_m3: float | None

    @property
    def doubt(self) -> str:
        """Return why the mass is probably not in kg; empty where it may be."""
        if self.density_kg_m3 is not None and self.density_kg_m3 > _DENSEST_KG_M3:
            return f"{self.density_kg_m3:.3g} kg/m3 by its shapes is far denser than any metal"
        return "more than a machine's link weighs" if self.mass_kg > _HEAVY_KG else ""


def link_masses(mechanism: Mechanism) -> tuple[LinkMass, ...]:
    """Masses of the moving links.

    Returns:
        One for every joint, in their order.
    """
    model = mechanism.model
    volumes = _volumes(mechanism)
    found = []
    for joint in mechanism.joints:
        mass = float(model.inertias[model.getJointId(joint.name)].mass)
        volume = volumes.get(joint.child)
        found.append(LinkMass(joint.child, mass, mass / volume if volume else None))
    return tuple(found)


def _volumes(mechanism: Mechanism) -> dict[str, float | None]:
    """Volume of every moving link's shapes, of what is fixed to it too; None with a mesh [m3]."""
    root = parse_xml(mechanism.urdf, f"{mechanism.name}.urdf")
    fixed = {}
    for joint in root.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if joint.get("type") == "fixed" and parent is not None and child is not None:
            fixed[child.get("link", "")] = parent.get("link", "")
    found: dict[str, float | None] = {}
    for link in root.findall("link"):
        name = link.get("name", "")
        while name in fixed:
            name = fixed[name]
        for shape in link.iterfind("collision/geometry/*"):
            volume, before = _volume(shape), found.get(name, 0.0)
            found[name] = None if volume is None or before is None else before + volume
    return found


def _volume(shape: ElementTree.Element) -> float | None:
    """Volume of a shape [m3]; None of a mesh."""
    if shape.tag == "box":
        return math.prod(float(word) for word in shape.get("size", "").split())
    if shape.tag == "mesh":
        return None
    radius = float(shape.get("radius", "nan"))
    if shape.tag == "sphere":
        return 4.0 / 3.0 * math.pi * radius**3
    return math.pi * radius**2 * float(shape.get("length", "nan"))
